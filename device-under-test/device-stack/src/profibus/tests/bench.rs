//! A scripted master in front of one device.

use station::{Duration, Outbox, Station, Time};
use std::vec::Vec;
use wire::profibus::fdl::{
    BROADCAST, DataFrame, Extension, FdlFormat, FdlFrame, FrameCount, FunctionCode, RequestFunction,
};

/// The answer to a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ObservedAnswer {
    /// No answer.
    Silence,
    /// A short acknowledgement.
    Taken,
    /// A function code and data.
    Data(u8, Vec<u8>),
}

/// RS: the access point is not active.
pub const RS: ObservedAnswer = ObservedAnswer::Data(0x03, Vec::new());

/// Idle time before each request.
const FRAME_GAP: Duration = Duration::from_millis(1);
/// How long the master waits for an answer: longer than max TSDR at any baud rate of the tests.
const ANSWER_WAIT: Duration = Duration::from_millis(1);

/// A device and a master.
pub struct SlaveBench<D> {
    pub device: D,
    pub now: Time,
    pub master: u8,
    pub slave: u8,
    pub count: FrameCount,
    /// The delay of the last answer.
    pub delay: Duration,
}

impl<D: Station> SlaveBench<D> {
    pub fn new(device: D, slave: u8) -> SlaveBench<D> {
        SlaveBench { device, now: Time::ZERO, master: 2, slave, count: FrameCount::First, delay: Duration::ZERO }
    }

    /// Advances time and discards what the device sends.
    pub fn wait(&mut self, time: Duration) {
        let until = self.now + time;
        let mut out = Outbox::new();
        while let Some(due) = self.device.deadline().filter(|due| *due <= until) {
            self.now = self.now.max(due);
            self.device.wake(self.now, &mut out);
        }
        self.now = until;
    }

    /// Sends `octets` and waits [`ANSWER_WAIT`] for an answer.
    pub fn send_frame(&mut self, octets: &[u8]) -> Option<Vec<u8>> {
        self.now += FRAME_GAP;
        let (sent_at, until) = (self.now, self.now + ANSWER_WAIT);
        let mut out = Outbox::new();
        self.device.receive(self.now, octets, &mut out);
        assert!(out.is_empty(), "a slave answers min TSDR later");
        while let Some(due) = self.device.deadline().filter(|due| *due <= until) {
            self.now = self.now.max(due);
            self.device.wake(self.now, &mut out);
            if let Some(frame) = out.frames().next() {
                self.delay = self.now.since(sent_at);
                return Some(frame.to_vec());
            }
        }
        self.now = until;
        None
    }

    fn frame(&self, count: FrameCount, saps: Option<(u8, u8)>, data: &[u8]) -> Vec<u8> {
        let extension = |sap: Option<u8>| sap.map_or(Extension::NONE, Extension::sap);
        let fc = FunctionCode::request(RequestFunction::SRD_HIGH, count);
        let (destination, source) = (extension(saps.map(|of| of.0)), extension(saps.map(|of| of.1)));
        let frame = DataFrame::new((self.slave, destination), (self.master, source), fc, data);
        let mut octets = Vec::new();
        FdlFrame::Data(frame).write(&mut octets);
        octets
    }

    /// Sends a new request to service access points and returns the answer.
    pub fn ask(&mut self, saps: Option<(u8, u8)>, data: &[u8]) -> ObservedAnswer {
        let octets = self.frame(self.count, saps, data);
        self.count = self.count.next();
        let answer = self.send_frame(&octets);
        self.parse(answer, saps)
    }

    /// Repeats the last request with the same frame count bit, as after a lost answer.
    pub fn repeat(&mut self, saps: Option<(u8, u8)>, data: &[u8]) -> ObservedAnswer {
        let last = self.count.next();
        let octets = self.frame(last, saps, data);
        let answer = self.send_frame(&octets);
        self.parse(answer, saps)
    }

    fn parse(&self, answer: Option<Vec<u8>>, saps: Option<(u8, u8)>) -> ObservedAnswer {
        let Some(octets) = answer else { return ObservedAnswer::Silence };
        match FdlFrame::parse(&octets).expect("a valid frame") {
            FdlFrame::Data(frame) => {
                assert_eq!((frame.da, frame.sa), (self.master, self.slave));
                if frame.format != FdlFormat::NoData {
                    assert_eq!((frame.source.sap, frame.destination.sap), (saps.map(|of| of.0), saps.map(|of| of.1)));
                }
                ObservedAnswer::Data(frame.fc.0, frame.data.to_vec())
            }
            FdlFrame::ShortAcknowledgement => ObservedAnswer::Taken,
            FdlFrame::Token { .. } => panic!("a slave sends no token"),
        }
    }

    /// Sends Global_Control to all slaves.
    pub fn control(&mut self, command: u8, groups: u8) {
        let fc = FunctionCode::request(RequestFunction::SDN_HIGH, FrameCount::Unused);
        let data = [command, groups];
        let frame = DataFrame::new((BROADCAST, Extension::sap(58)), (self.master, Extension::sap(62)), fc, &data);
        let mut octets = Vec::new();
        FdlFrame::Data(frame).write(&mut octets);
        assert_eq!(self.send_frame(&octets), None);
    }

    pub fn set_prm(&mut self, data: &[u8]) -> ObservedAnswer {
        self.ask(Some((61, 62)), data)
    }

    pub fn chk_cfg(&mut self, data: &[u8]) -> ObservedAnswer {
        self.ask(Some((62, 62)), data)
    }

    /// The bytes of Slave_Diag.
    pub fn diagnosis(&mut self) -> Vec<u8> {
        match self.ask(Some((60, 62)), &[]) {
            ObservedAnswer::Data(8, octets) => octets,
            other => panic!("expected a diagnosis, observed {other:?}"),
        }
    }

    /// The inputs of a Data_Exchange.
    pub fn exchange(&mut self, outputs: &[u8]) -> Vec<u8> {
        match self.ask(None, outputs) {
            ObservedAnswer::Data(8 | 10, octets) => octets,
            other => panic!("expected data, observed {other:?}"),
        }
    }
}
