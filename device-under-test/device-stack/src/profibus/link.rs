//! The data link of a slave: detects repeated requests, and times and encodes answers.
//!
//! This module must not depend on services and states.

use alloc::vec::Vec;
use station::{Duration, Outbox, Time};
use wire::profibus::fdl::{
    AnswerFunction, BaudRate, BitTimes, DataFrame, Extension, FdlFormat, FdlFrame, FrameCount, FunctionCode,
    StationType,
};

/// The answer of a service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ServiceAnswer {
    /// Short acknowledgement: the request was accepted, without data.
    Taken,
    /// Data, with high priority if the master must fetch the diagnosis.
    Data {
        /// The data.
        octets: Vec<u8>,
        /// Whether the priority is high.
        is_high: bool,
    },
    /// A function code without data.
    Code(AnswerFunction),
}

impl ServiceAnswer {
    /// RS: the service access point is not active for this request.
    pub const NO_SERVICE: ServiceAnswer = ServiceAnswer::Code(AnswerFunction::NO_SERVICE);

    /// Data of low priority.
    pub fn data(octets: Vec<u8>) -> ServiceAnswer {
        ServiceAnswer::Data { octets, is_high: false }
    }
}

/// The data link of a slave while it has power.
pub(super) struct FdlLink {
    baud: BaudRate,
    /// min TSDR as the last Set_Prm has it.
    pub delay: BitTimes,
    /// The last request with a frame count bit, and its answer.
    last: Option<LastRequest>,
    /// The answer that is due at this time.
    waiting: Option<(Time, Vec<u8>)>,
}

/// A request with a frame count bit that was answered.
struct LastRequest {
    sa: u8,
    count: FrameCount,
    answer: Vec<u8>,
}

impl FdlLink {
    /// A link that has received nothing.
    pub fn new(baud: BaudRate) -> FdlLink {
        FdlLink { baud, delay: BitTimes::DEFAULT_MIN_TSDR, last: None, waiting: None }
    }

    /// The rate of the bus.
    pub fn baud(&self) -> BaudRate {
        self.baud
    }

    /// Another frame was received: discards an answer that was not sent yet.
    pub fn discard_answer(&mut self) {
        self.waiting = None;
    }

    /// Whether a request repeats the last one with a frame count bit.
    pub fn is_repetition(&self, frame: &DataFrame<'_>) -> bool {
        let (Some(count), Some(last)) = (frame.fc.count(), &self.last) else { return false };
        match (count, last.count) {
            (FrameCount::One, FrameCount::One | FrameCount::First) | (FrameCount::Zero, FrameCount::Zero) => {
                last.sa == frame.sa
            }
            (FrameCount::Unused | FrameCount::First, _)
            | (FrameCount::One, FrameCount::Zero | FrameCount::Unused)
            | (FrameCount::Zero, FrameCount::One | FrameCount::First | FrameCount::Unused) => false,
        }
    }

    /// Sends the last answer again after `delay`.
    pub fn repeat(&mut self, now: Time, delay: BitTimes) {
        if let Some(last) = &self.last {
            let answer = last.answer.clone();
            self.send_later(now, answer, delay);
        }
    }

    /// Answers a request to the address `own` after `delay`.
    pub fn answer(&mut self, now: Time, own: u8, frame: &DataFrame<'_>, answer: &ServiceAnswer, delay: BitTimes) {
        let Some(octets) = octets(own, frame, answer) else { return };
        match frame.fc.count() {
            Some(count @ (FrameCount::First | FrameCount::Zero | FrameCount::One)) => {
                let mut answer = self.last.take().map_or_else(Vec::new, |last| last.answer);
                answer.clone_from(&octets);
                self.last = Some(LastRequest { sa: frame.sa, count, answer });
            }
            Some(FrameCount::Unused) | None => {}
        }
        self.send_later(now, octets, delay);
    }

    fn send_later(&mut self, now: Time, octets: Vec<u8>, delay: BitTimes) {
        let delay = Duration::from_nanos(self.baud.nanoseconds(delay));
        self.waiting = Some((now + delay, octets));
    }

    /// Sends what is due.
    pub fn wake(&mut self, now: Time, out: &mut Outbox) {
        if let Some((_, octets)) = self.waiting.take_if(|(due, _)| *due <= now) {
            out.push(&octets);
        }
    }

    /// When an answer is due.
    pub fn due(&self) -> Option<Time> {
        self.waiting.as_ref().map(|(due, _)| *due)
    }
}

fn octets(own: u8, request: &DataFrame<'_>, answer: &ServiceAnswer) -> Option<Vec<u8>> {
    let data_frame = |function, data, format, destination, source| {
        let fc = FunctionCode::answer(function, StationType::SLAVE);
        FdlFrame::Data(DataFrame { format, da: request.sa, sa: own, fc, destination, source, data })
    };
    let none = Extension::NONE;
    let frame = match answer {
        ServiceAnswer::Taken => FdlFrame::ShortAcknowledgement,
        ServiceAnswer::Code(function) => data_frame(*function, &[], FdlFormat::NoData, none, none),
        ServiceAnswer::Data { octets, is_high } => {
            let function = if *is_high { AnswerFunction::DATA_HIGH } else { AnswerFunction::DATA_LOW };
            let has_octets = !octets.is_empty() || !request.source.is_empty() || !request.destination.is_empty();
            let format = if has_octets { FdlFormat::Variable } else { FdlFormat::NoData };
            data_frame(function, octets.as_slice(), format, request.source, request.destination)
        }
    };
    let mut out = Vec::new();
    frame.write(&mut out);
    Some(out)
}
