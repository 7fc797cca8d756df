//! What a live PROFIBUS is watched for besides what its frames mean: who speaks out of turn, and how late answers are.
//!
//! Neither says anything about the device: a line without bit times, a kernel and a slow slave look alike. This room must not know
//! trials.

use crate::profibus::{is_of_master, words};
use link::Heard;
use station::{Duration, Time};
use wire::profibus::diag::{SlaveDiag, Status2};
use wire::profibus::fdl::{DataFrame, Frame};
use wire::profibus::sap::{Service, SlaveSap};

/// A request that was sent and has no answer yet.
struct Asked {
    to: u8,
    service: Service,
    octets: Vec<u8>,
    /// When it had been sent for the first time.
    since: Time,
}

/// A PROFIBUS that is watched.
pub(super) struct BusWatch {
    /// How long an answer is waited for.
    slot: Duration,
    asked: Option<Asked>,
    /// A station that did not answer Data_Exchange however often it was asked, and since when.
    missed: Option<(u8, Time)>,
    /// When the last frame ended.
    told: Time,
    latest: Duration,
}

impl BusWatch {
    /// A bus on which answers are waited for the time `slot`.
    pub fn new(slot: Duration) -> BusWatch {
        BusWatch { slot, asked: None, missed: None, told: Time::ZERO, latest: Duration::ZERO }
    }

    /// How long after its request an answer began at worst: one that came when the request was repeated, or in a later cycle while
    /// the station was in data exchange all the time, is counted from the first request on.
    pub fn latest(&self) -> Duration {
        self.latest
    }

    /// Takes what was on the line; when it began, and why nothing can be said about the device any more, if that is so.
    pub fn see(&mut self, heard: &Heard<'_>) -> (Time, Option<String>) {
        // Octets that the kernel has gathered may seem to begin before the frame in front of them ended.
        let begin = heard.begin.max(self.told);
        self.told = self.told.max(heard.end);
        if heard.sender.is_some() {
            self.ask(heard);
            return (begin, None);
        }
        (begin, self.hear(heard))
    }

    fn ask(&mut self, heard: &Heard<'_>) {
        let before = self.asked.take();
        let repeated = before.as_ref().filter(|before| before.octets == heard.octets).map(|before| before.since);
        if let (Some(before), None) = (before, repeated)
            && before.service == Service::DataExchange
        {
            self.missed.get_or_insert((before.to, before.since));
        }
        let Ok(Frame::Data(frame)) = Frame::parse(heard.octets) else { return };
        let service = Service::of(&frame);
        if service == Service::Slave(SlaveSap::SET_PRM) && self.missed.is_some_and(|(to, _)| to == frame.da) {
            self.missed = None;
        }
        if frame.fc.requested().is_some_and(|function| function.wants_answer()) {
            let since = repeated.unwrap_or(heard.end);
            self.asked = Some(Asked { to: frame.da, service, octets: heard.octets.to_vec(), since });
        }
    }

    fn hear(&mut self, heard: &Heard<'_>) -> Option<String> {
        let what = || words(heard.octets);
        if is_of_master(heard.octets) {
            return Some(format!("another master is on the bus: {} was heard", what()));
        }
        let frame = match Frame::parse(heard.octets) {
            Ok(Frame::Data(frame)) => Some(frame),
            Ok(_) => None,
            Err(_) => return Some(format!("the line is disturbed: {} was heard", what())),
        };
        let Some(asked) = self.asked.take() else {
            return Some(format!("nobody was asked when {} was heard, which may have come late", what()));
        };
        if frame.as_ref().is_some_and(|frame| frame.sa != asked.to) {
            return Some(format!("station {} was asked, and {} was heard", asked.to, what()));
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
fn was_in_exchange(asked: &Asked, answer: Option<&DataFrame<'_>>) -> bool {
    match asked.service {
        Service::DataExchange => true,
        Service::Slave(SlaveSap::SLAVE_DIAG) => answer.is_some_and(|frame| {
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
    /// Master 1 asks slave 5 for data and for its diagnosis, and parameterises it; the function codes are SRD high.
    const DATA: [u8; 10] = [0x68, 4, 4, 0x68, 5, 1, 0x7D, 0, 0x83, 0x16];
    const DIAGNOSIS: [u8; 11] = [0x68, 5, 5, 0x68, 0x85, 0x81, 0x6D, 60, 62, 0xED, 0x16];
    const SET_PRM: [u8; 12] = [0x68, 6, 6, 0x68, 0x85, 0x81, 0x5D, 61, 62, 0x88, 0x66, 0x16];
    const ANSWER: [u8; 10] = [0x68, 4, 4, 0x68, 1, 5, 8, 7, 0x15, 0x16];
    const TOKEN: [u8; 3] = [0xDC, 1, 1];

    struct Line(BusWatch);

    impl Line {
        fn new() -> Line {
            Line(BusWatch::new(SLOT))
        }

        fn at(&mut self, millis: u64, sender: Option<usize>, octets: &[u8]) -> Option<String> {
            let time = Time::ZERO + Duration::from_millis(millis);
            let is_frame = Frame::parse(octets).is_ok();
            self.0.see(&Heard { begin: time, end: time, sender, octets, is_frame }).1
        }

        fn sent(&mut self, millis: u64, octets: &[u8]) {
            assert_eq!(self.at(millis, Some(0), octets), None);
        }
    }

    #[test]
    fn the_hand_made_frames_are_frames() {
        for octets in [&DATA[..], &DIAGNOSIS, &SET_PRM, &ANSWER, &TOKEN] {
            assert!(Frame::parse(octets).is_ok(), "{octets:02X?}");
        }
    }

    #[test]
    fn an_answer_in_time_is_as_late_as_it_is() {
        let mut line = Line::new();
        line.sent(0, &DATA);
        assert_eq!(line.at(3, None, &ANSWER), None);
        assert_eq!(line.0.latest(), Duration::from_millis(3));
    }

    #[test]
    fn an_answer_to_a_repetition_is_late_by_both() {
        let mut line = Line::new();
        line.sent(0, &DATA);
        line.sent(20, &DATA);
        assert_eq!(line.at(21, None, &ANSWER), None);
        assert_eq!(line.0.latest(), Duration::from_millis(21));
        // The slave answers the first one, too.
        let why = line.at(22, None, &ANSWER).expect("nobody asked");
        assert!(why.ends_with("which may have come late"), "{why}");
    }

    #[test]
    fn a_cycle_that_was_missed_counts_unless_the_slave_was_parameterised_anew() {
        for (between, latest) in [(&TOKEN[..], 52), (&SET_PRM, 2)] {
            let mut line = Line::new();
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
    fn who_speaks_out_of_turn_is_told() {
        let mut line = Line::new();
        let why = line.at(0, None, &TOKEN).expect("a token");
        assert_eq!(why, "another master is on the bus: a token from station 1 to station 1 was heard");
        let why = line.at(1, None, &DIAGNOSIS).expect("a request");
        assert!(why.starts_with("another master is on the bus: a request of station 1"), "{why}");
        let why = line.at(2, None, &[0xFF, 0]).expect("noise");
        assert_eq!(why, "the line is disturbed: something that is no frame (FF 00) was heard");
        line.sent(3, &[0x10, 9, 1, 0x49, 0x53, 0x16]);
        let why = line.at(4, None, &ANSWER).expect("another answers");
        assert_eq!(why, "station 9 was asked, and an answer of station 5 to station 1 was heard");
    }
}
