//! Watches a live PROFIBUS for other masters and late answers, apart from the meaning of frames.
//!
//! Neither says anything about the device: a line without bit times, a kernel and a slow slave look the same. This module must
//! not know trials.

use crate::profibus::{is_of_master, words};
use link::BusTransmission;
use station::{Duration, Time};
use wire::profibus::diag::{SlaveDiag, Status2};
use wire::profibus::fdl::{DataFrame, FdlFrame};
use wire::profibus::sap::{SapService, SlaveSap};

/// A request that was sent and has no answer yet.
struct PendingBusRequest {
    to: u8,
    service: SapService,
    octets: Vec<u8>,
    /// When its first transmission ended.
    since: Time,
}

/// The observer of a PROFIBUS.
pub(super) struct BusWatch {
    /// Slot time: how long an answer is awaited.
    slot: Duration,
    pending: Option<PendingBusRequest>,
    /// A station that did not answer Data_Exchange in all repetitions, and since when.
    missed: Option<(u8, Time)>,
    /// When the last frame ended.
    last_end: Time,
    latest: Duration,
}

impl BusWatch {
    /// An observer for a bus with the slot time `slot`.
    pub fn new(slot: Duration) -> BusWatch {
        BusWatch { slot, pending: None, missed: None, last_end: Time::ZERO, latest: Duration::ZERO }
    }

    /// The longest time from a request to the start of its answer. An answer to a repetition, or in a later cycle while the
    /// station stayed in data exchange, counts from the first request.
    pub fn latest(&self) -> Duration {
        self.latest
    }

    /// Processes bytes on the line; returns when they began, and why no more can be concluded about the device, if so.
    pub fn observe(&mut self, heard: &BusTransmission<'_>) -> (Time, Option<String>) {
        // Bytes collected by the kernel may seem to begin before the previous frame ended.
        let begin = heard.begin.max(self.last_end);
        self.last_end = self.last_end.max(heard.end);
        if heard.sender.is_some() {
            self.observe_request(heard);
            return (begin, None);
        }
        (begin, self.observe_answer(heard))
    }

    fn observe_request(&mut self, heard: &BusTransmission<'_>) {
        let before = self.pending.take();
        let repeated = before.as_ref().filter(|before| before.octets == heard.octets).map(|before| before.since);
        if let (Some(before), None) = (before, repeated)
            && before.service == SapService::DataExchange
        {
            self.missed.get_or_insert((before.to, before.since));
        }
        let Ok(FdlFrame::Data(frame)) = FdlFrame::parse(heard.octets) else { return };
        let service = SapService::of(&frame);
        if service == SapService::Slave(SlaveSap::SET_PRM) && self.missed.is_some_and(|(to, _)| to == frame.da) {
            self.missed = None;
        }
        if frame.fc.requested().is_some_and(|function| function.expects_response()) {
            let since = repeated.unwrap_or(heard.end);
            self.pending = Some(PendingBusRequest { to: frame.da, service, octets: heard.octets.to_vec(), since });
        }
    }

    fn observe_answer(&mut self, heard: &BusTransmission<'_>) -> Option<String> {
        let what = || words(heard.octets);
        if is_of_master(heard.octets) {
            return Some(format!("another master is on the bus: received {}", what()));
        }
        let frame = match FdlFrame::parse(heard.octets) {
            Ok(FdlFrame::Data(frame)) => Some(frame),
            Ok(_) => None,
            Err(_) => return Some(format!("the line is disturbed: received {}", what())),
        };
        let Some(asked) = self.pending.take() else {
            return Some(format!("received {} without a pending request; it may be a late answer", what()));
        };
        if frame.as_ref().is_some_and(|frame| frame.sa != asked.to) {
            return Some(format!("expected an answer of station {}, received {}", asked.to, what()));
        }
        self.latest = self.latest.max(heard.begin.since(asked.since));
        if let Some((_, since)) = self.missed.take_if(|(to, _)| *to == asked.to)
            && was_in_exchange(&asked, frame.as_ref())
        {
            self.latest = self.latest.max(heard.begin.since(since));
        }
        let late = heard.begin.since(asked.since);
        let gave_up = late > self.slot * 2;
        gave_up.then(|| format!("{} came after {late:?}, and the slot time of the bench is {:?}", what(), self.slot))
    }
}

/// Whether an answer shows that the station has been in data exchange since it was last parameterised.
fn was_in_exchange(asked: &PendingBusRequest, answer: Option<&DataFrame<'_>>) -> bool {
    match asked.service {
        SapService::DataExchange => true,
        SapService::Slave(SlaveSap::SLAVE_DIAG) => answer.is_some_and(|frame| {
            SlaveDiag::parse(frame.data)
                .is_ok_and(|diagnosis| diagnosis.master == frame.da && !diagnosis.status_2.has(Status2::PRM_REQ))
        }),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLOT: Duration = Duration::from_millis(20);
    /// Master 1 sends Data_Exchange, Slave_Diag and Set_Prm to slave 5; the function codes are SRD high.
    const DATA: [u8; 10] = [0x68, 4, 4, 0x68, 5, 1, 0x7D, 0, 0x83, 0x16];
    const DIAGNOSIS: [u8; 11] = [0x68, 5, 5, 0x68, 0x85, 0x81, 0x6D, 60, 62, 0xED, 0x16];
    const SET_PRM: [u8; 12] = [0x68, 6, 6, 0x68, 0x85, 0x81, 0x5D, 61, 62, 0x88, 0x66, 0x16];
    const ANSWER: [u8; 10] = [0x68, 4, 4, 0x68, 1, 5, 8, 7, 0x15, 0x16];
    const TOKEN: [u8; 3] = [0xDC, 1, 1];

    struct WatchedLine(BusWatch);

    impl WatchedLine {
        fn new() -> WatchedLine {
            WatchedLine(BusWatch::new(SLOT))
        }

        fn at(&mut self, millis: u64, sender: Option<usize>, octets: &[u8]) -> Option<String> {
            let time = Time::ZERO + Duration::from_millis(millis);
            let is_frame = FdlFrame::parse(octets).is_ok();
            self.0.observe(&BusTransmission { begin: time, end: time, sender, octets, is_frame }).1
        }

        fn sent(&mut self, millis: u64, octets: &[u8]) {
            assert_eq!(self.at(millis, Some(0), octets), None);
        }
    }

    #[test]
    fn the_frames_of_these_tests_are_valid() {
        for octets in [&DATA[..], &DIAGNOSIS, &SET_PRM, &ANSWER, &TOKEN] {
            assert!(FdlFrame::parse(octets).is_ok(), "{octets:02X?}");
        }
    }

    #[test]
    fn the_delay_of_an_answer_in_time_is_measured() {
        let mut line = WatchedLine::new();
        line.sent(0, &DATA);
        assert_eq!(line.at(3, None, &ANSWER), None);
        assert_eq!(line.0.latest(), Duration::from_millis(3));
    }

    #[test]
    fn the_delay_of_an_answer_to_a_repetition_counts_from_the_first_request() {
        let mut line = WatchedLine::new();
        line.sent(0, &DATA);
        line.sent(20, &DATA);
        assert_eq!(line.at(21, None, &ANSWER), None);
        assert_eq!(line.0.latest(), Duration::from_millis(21));
        // The slave answers the first one, too.
        let why = line.at(22, None, &ANSWER).expect("no request is pending");
        assert!(why.ends_with("it may be a late answer"), "{why}");
    }

    #[test]
    fn a_missed_cycle_counts_unless_the_slave_was_parameterised_again() {
        for (between, latest) in [(&TOKEN[..], 52), (&SET_PRM, 2)] {
            let mut line = WatchedLine::new();
            line.sent(0, &DATA);
            line.sent(20, &DATA);
            line.sent(40, between);
            if between == SET_PRM {
                assert_eq!(line.at(41, None, &[0xE5]), None);
            }
            line.sent(50, &DATA);
            assert_eq!(line.at(52, None, &ANSWER), None);
            assert_eq!(line.0.latest(), Duration::from_millis(latest), "{between:02X?}");
        }
    }

    #[test]
    fn frames_of_other_stations_are_reported() {
        let mut line = WatchedLine::new();
        let why = line.at(0, None, &TOKEN).expect("a token");
        assert_eq!(why, "another master is on the bus: received a token from station 1 to station 1");
        let why = line.at(1, None, &DIAGNOSIS).expect("a request");
        assert!(why.starts_with("another master is on the bus: received a request of station 1"), "{why}");
        let why = line.at(2, None, &[0xFF, 0]).expect("noise");
        assert_eq!(why, "the line is disturbed: received bytes that are not a frame (FF 00)");
        line.sent(3, &[0x10, 9, 1, 0x49, 0x53, 0x16]);
        let why = line.at(4, None, &ANSWER).expect("another answers");
        assert_eq!(why, "expected an answer of station 9, received an answer of station 5 to station 1");
    }
}
