//! Watches a live PROFIBUS for other masters and late answers, apart from the meaning of frames.
//!
//! Neither says anything about the device: a line without bit times, a kernel and a slow slave look the same. Answers in time whose
//! addresses or length are wrong are the device's, and no disturbance. This module must not know trials.

use crate::profibus::{is_of_master, words};
use engine::Disturbance;
use link::BusTransmission;
use station::{Duration, Time};
use wire::profibus::diag::{SlaveDiag, Status2};
use wire::profibus::fdl::{DataFrame, END_DELIMITER, FdlFrame, checksum};
use wire::profibus::sap::{SapService, SlaveSap};

/// The length of the shortest frame of variable length: SD2, LE, LEr, SD2, DA, SA, FC, FCS, ED.
const SHORTEST: usize = 9;

/// A request that was sent and has no answer yet.
struct PendingBusRequest {
    /// The station asked, and ours; `None` for bytes that are damaged on purpose.
    stations: Option<(u8, u8)>,
    /// The access points of both, in the same order.
    access_points: (Option<u8>, Option<u8>),
    service: SapService,
    octets: Vec<u8>,
    /// When its first transmission ended.
    since: Time,
    /// Whether an answer came, with wrong addresses.
    has_misfit: bool,
}

impl PendingBusRequest {
    fn is_to(&self, station: u8) -> bool {
        self.stations.is_some_and(|(to, _)| to == station)
    }

    /// Whether the addresses of an answer are those of the request. An answer without data may leave out the access points.
    fn is_answered_by(&self, frame: &DataFrame<'_>) -> bool {
        let points = (frame.source.sap, frame.destination.sap);
        let is_bare = points == (None, None) && frame.data.is_empty();
        match self.stations {
            Some(stations) => stations == (frame.sa, frame.da) && (points == self.access_points || is_bare),
            None => true,
        }
    }
}

/// An answer whose length field is wrong although nothing else is.
struct MiscountedAnswer {
    stations: Option<(u8, u8)>,
    service: SapService,
    octets: Vec<u8>,
    /// Whether it came again, so that the device sends it so.
    is_confirmed: bool,
}

/// The observer of a PROFIBUS.
pub(super) struct BusWatch {
    /// Slot time: how long an answer is awaited.
    slot: Duration,
    /// The addresses of the other stations on the bus.
    others: Vec<u8>,
    pending: Option<PendingBusRequest>,
    /// A station that did not answer Data_Exchange in all repetitions, and since when.
    missed: Option<(u8, Time)>,
    /// The station whose last request was given up; its answer may still arrive.
    given_up: Option<u8>,
    /// An answer with a wrong length. If the next request of the same service has the same answer, the device sends it so; otherwise it was
    /// damaged.
    miscounted: Option<MiscountedAnswer>,
    /// When the last frame ended.
    last_end: Time,
    latest: Duration,
}

impl BusWatch {
    /// An observer for a bus with the slot time `slot` and, besides the device and our masters, the stations `others`.
    pub fn new(slot: Duration, others: Vec<u8>) -> BusWatch {
        let (pending, missed, given_up, miscounted) = (None, None, None, None);
        let (last_end, latest) = (Time::ZERO, Duration::ZERO);
        BusWatch { slot, others, pending, missed, given_up, miscounted, last_end, latest }
    }

    /// The longest time from a request to the start of its answer. An answer to a repetition, or in a later cycle while the
    /// station stayed in data exchange, counts from the first request.
    pub fn latest(&self) -> Duration {
        self.latest
    }

    /// Whether a request was given up whose answer may still arrive.
    pub fn lacks_answer(&self) -> bool {
        self.given_up.is_some()
    }

    /// Processes bytes on the line; returns when they began, and why no more can be concluded about the device, if so.
    pub fn observe(&mut self, heard: &BusTransmission<'_>) -> (Time, Option<Disturbance>) {
        // Bytes collected by the kernel may seem to begin before the previous frame ended.
        let begin = heard.begin.max(self.last_end);
        self.last_end = self.last_end.max(heard.end);
        let disturbance = match heard.sender {
            Some(_) => self.observe_request(heard),
            None => self.observe_answer(heard),
        };
        (begin, disturbance)
    }

    fn observe_request(&mut self, heard: &BusTransmission<'_>) -> Option<Disturbance> {
        let before = self.pending.take();
        let repeated = before.as_ref().filter(|before| before.octets == heard.octets).map(|before| before.since);
        if let (Some(before), None) = (before, repeated)
            && let (Some((to, _)), false) = (before.stations, before.has_misfit)
        {
            self.given_up = Some(to);
            if before.service == SapService::DataExchange {
                self.missed.get_or_insert((to, before.since));
            }
        }
        let mut damaged = None;
        match FdlFrame::parse(heard.octets) {
            Ok(FdlFrame::Data(frame)) => {
                let service = SapService::of(&frame);
                let is_other =
                    |of: &mut MiscountedAnswer| (of.stations, of.service) != (Some((frame.da, frame.sa)), service);
                damaged = self.miscounted.take_if(is_other).and_then(noise);
                if service == SapService::Slave(SlaveSap::SET_PRM) && self.missed.is_some_and(|(to, _)| to == frame.da)
                {
                    self.missed = None;
                }
                if frame.fc.requested().is_some_and(|function| function.expects_response()) {
                    self.pending = Some(PendingBusRequest {
                        stations: Some((frame.da, frame.sa)),
                        access_points: (frame.destination.sap, frame.source.sap),
                        service,
                        octets: heard.octets.to_vec(),
                        since: repeated.unwrap_or(heard.end),
                        has_misfit: false,
                    });
                }
            }
            Ok(FdlFrame::Token { .. } | FdlFrame::ShortAcknowledgement) => {}
            // Only a case sends bytes that are no frame, and it judges what comes then.
            Err(_) => {
                self.pending = Some(PendingBusRequest {
                    stations: None,
                    access_points: (None, None),
                    service: SapService::DataExchange,
                    octets: heard.octets.to_vec(),
                    since: heard.end,
                    has_misfit: false,
                });
            }
        }
        damaged
    }

    fn observe_answer(&mut self, heard: &BusTransmission<'_>) -> Option<Disturbance> {
        let what = || words(heard.octets);
        if is_of_master(heard.octets) {
            return Some(Disturbance::lasting(format!("another master is on the bus: received {}", what())));
        }
        let frame = match FdlFrame::parse(heard.octets) {
            Ok(FdlFrame::Data(frame)) => Some(frame),
            Ok(_) => None,
            Err(_) => return self.observe_damage(heard),
        };
        let Some(asked) = self.pending.take() else {
            self.given_up = None;
            let why = format!("received {} without a pending request; it may be a late answer", what());
            return Some(Disturbance::of_link(why));
        };
        if let Some(frame) = &frame
            && !asked.is_answered_by(frame)
        {
            return self.observe_misfit(heard, frame, asked);
        }
        self.given_up.take_if(|to| asked.is_to(*to));
        asked.stations?;
        self.latest = self.latest.max(heard.begin.since(asked.since));
        if let Some((_, since)) = self.missed.take_if(|(to, _)| asked.is_to(*to))
            && was_in_exchange(&asked, frame.as_ref())
        {
            self.latest = self.latest.max(heard.begin.since(since));
        }
        if let Some(noise) = self.miscounted.take().and_then(noise) {
            return Some(noise);
        }
        let late = heard.begin.since(asked.since);
        let gave_up = late > self.slot * 2;
        gave_up.then(|| {
            let why = format!("{} came after {late:?}, and the slot time of the bench is {:?}", what(), self.slot);
            Disturbance::of_link(why)
        })
    }

    /// Processes an answer whose addresses are not those of the request. The trial judges it, unless another station or an answer to an
    /// earlier request explains it.
    fn observe_misfit(
        &mut self,
        heard: &BusTransmission<'_>,
        frame: &DataFrame<'_>,
        asked: PendingBusRequest,
    ) -> Option<Disturbance> {
        let (what, to) = (words(heard.octets), asked.stations.map(|(to, _)| to));
        if self.others.contains(&frame.sa) && !asked.is_to(frame.sa) {
            let to = to.map_or_else(|| "the device".to_owned(), |to| format!("station {to}"));
            return Some(Disturbance::lasting(format!("expected an answer of {to}, received {what}")));
        }
        self.pending = Some(PendingBusRequest { has_misfit: true, ..asked });
        self.given_up.take_if(|station| *station == frame.sa).map(|_| {
            let why = format!(
                "received {what}, which does not fit the last request; it may be a late answer to an earlier one"
            );
            Disturbance::of_link(why)
        })
    }

    /// Processes bytes that are no frame.
    fn observe_damage(&mut self, heard: &BusTransmission<'_>) -> Option<Disturbance> {
        let before = self.miscounted.take();
        let Some((octets, copies)) = miscounted_copies(heard.octets) else { return Some(disturbed(heard.octets)) };
        let asked = self.pending.as_mut().filter(|asked| asked.stations.is_some());
        // The bytes end with a silence, so they may arrive when the master has given up.
        if asked.is_none() && copies == 1 {
            return Some(disturbed(heard.octets));
        }
        let is_confirmed = match before {
            Some(before) if before.octets != octets => return Some(disturbed(heard.octets)),
            before => before.is_some() || copies > 1,
        };
        self.given_up = None;
        let (stations, service) = asked.map_or((None, SapService::DataExchange), |asked| {
            asked.has_misfit = true;
            (asked.stations, asked.service)
        });
        self.miscounted = Some(MiscountedAnswer { stations, service, octets: octets.to_vec(), is_confirmed });
        None
    }
}

/// The disturbance that a wrong length is that did not come again.
fn noise(of: MiscountedAnswer) -> Option<Disturbance> {
    (!of.is_confirmed).then(|| disturbed(&of.octets))
}

fn disturbed(octets: &[u8]) -> Disturbance {
    Disturbance::of_link(format!("the line is disturbed: received {}", words(octets)))
}

/// The frame of which bytes are one or more copies, and their number, if it is a [miscounted](is_miscounted) one. A frame that counts too
/// much takes the answer to the repeated request for its own end.
fn miscounted_copies(octets: &[u8]) -> Option<(&[u8], usize)> {
    (SHORTEST..=octets.len()).filter(|length| octets.len().is_multiple_of(*length)).find_map(|length| {
        let frame = octets.get(..length).filter(|frame| is_miscounted(frame))?;
        octets.chunks(length).all(|copy| copy == frame).then_some((frame, octets.len() / length))
    })
}

/// Whether bytes are a frame of variable length that counts itself wrong: both length fields are the same, and checksum and end delimiter
/// are right for another length. Noise does not make such bytes, but a line that loses bytes 00 does.
fn is_miscounted(octets: &[u8]) -> bool {
    let [0x68, length, repeated, 0x68, body @ .., sum, END_DELIMITER] = octets else { return false };
    length == repeated && usize::from(*length) != body.len() && checksum(body) == *sum
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
    /// Another slave on the bus.
    const OTHER: u8 = 7;

    struct WatchedLine(BusWatch);

    impl WatchedLine {
        fn new() -> WatchedLine {
            WatchedLine(BusWatch::new(SLOT, vec![OTHER]))
        }

        fn at(&mut self, millis: u64, sender: Option<usize>, octets: &[u8]) -> Option<String> {
            let time = Time::ZERO + Duration::from_millis(millis);
            let is_frame = FdlFrame::parse(octets).is_ok();
            let (_, disturbance) =
                self.0.observe(&BusTransmission { begin: time, end: time, sender, octets, is_frame });
            disturbance.map(|of| of.why)
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
        line.sent(3, &DATA);
        let why = line.at(4, None, &answer(1, OTHER, 7)).expect("another answers");
        assert_eq!(why, "expected an answer of station 5, received an answer of station 7 to station 1");
    }

    /// An answer with one byte of data: SD2, LE, LEr, SD2, DA, SA, FC (data low), data, FCS, ED.
    fn answer(da: u8, sa: u8, data: u8) -> Vec<u8> {
        vec![0x68, 4, 4, 0x68, da, sa, 8, data, da + sa + 8 + data, 0x16]
    }

    #[test]
    fn an_answer_with_wrong_addresses_is_judged_by_the_trial() {
        // To another station, from an address that no station has, and from an access point that was not asked (62 instead of 60).
        let other_point = [0x68, 6, 6, 0x68, 0x81, 0x85, 8, 62, 62, 0, 0x8A, 0x16];
        for (request, wrong) in
            [(&DATA[..], answer(3, 5, 7)), (&DATA, answer(1, 9, 7)), (&DIAGNOSIS, other_point.to_vec())]
        {
            let mut line = WatchedLine::new();
            line.sent(0, request);
            assert_eq!(line.at(1, None, &wrong), None, "{wrong:02X?}");
            line.sent(2, request);
            assert_eq!(line.at(3, None, &wrong), None, "{wrong:02X?}");
            assert!(FdlFrame::parse(&wrong).is_ok());
        }
    }

    #[test]
    fn an_answer_to_a_request_that_was_given_up_is_late() {
        let mut line = WatchedLine::new();
        line.sent(0, &DIAGNOSIS);
        line.sent(20, &DIAGNOSIS);
        assert!(!line.0.lacks_answer());
        line.sent(40, &DATA);
        assert!(line.0.lacks_answer());
        let late = [0x68, 6, 6, 0x68, 0x81, 0x85, 8, 62, 60, 0, 0x88, 0x16];
        let why = line.at(41, None, &late).expect("it answers the first request");
        assert!(why.ends_with("it may be a late answer to an earlier one"), "{why}");
        assert!(!line.0.lacks_answer());
        // The answer to the last request shows that none is missing.
        line.sent(60, &DIAGNOSIS);
        line.sent(80, &DATA);
        assert_eq!(line.at(81, None, &ANSWER), None);
        assert!(!line.0.lacks_answer());
    }

    #[test]
    fn an_answer_to_bytes_damaged_on_purpose_is_judged_by_the_trial() {
        let mut line = WatchedLine::new();
        let mut damaged = DIAGNOSIS;
        damaged[9] ^= 1;
        line.sent(0, &damaged);
        assert_eq!(line.at(1, None, &ANSWER), None);
        line.sent(20, &damaged);
        assert_eq!(line.at(21, None, &[0xE5]), None);
        line.sent(40, &damaged);
        assert!(line.at(41, None, &[0xE5, 0x00]).is_some_and(|why| why.contains("disturbed")));
    }

    #[test]
    fn only_a_wrong_length_that_comes_again_is_the_devices() {
        // The answer says 5 bytes and has 4; checksum and end are right.
        let mut wrong = ANSWER;
        wrong[1..3].fill(5);
        let mut line = WatchedLine::new();
        line.sent(0, &DATA);
        assert_eq!(line.at(1, None, &wrong), None);
        line.sent(2, &DATA);
        assert_eq!(line.at(3, None, &wrong), None);
        // It has shown that it sends it so; from here on another line.
        line.sent(4, &DATA);
        assert_eq!(line.at(5, None, &ANSWER), None);
        let disturbed = |of: Option<String>| assert!(of.expect("noise").starts_with("the line is disturbed"));
        // A right answer follows, then another request.
        line.sent(4, &DATA);
        assert_eq!(line.at(5, None, &wrong), None);
        line.sent(6, &DATA);
        disturbed(line.at(7, None, &ANSWER));
        line.sent(8, &DATA);
        assert_eq!(line.at(9, None, &wrong), None);
        disturbed(line.at(10, Some(0), &DIAGNOSIS));
        // Two answers that run into each other, because the first counts bytes of the second, and which the silence ends too late.
        let both = [wrong, wrong].concat();
        line.sent(11, &TOKEN);
        assert_eq!(line.at(12, None, &both), None);
        disturbed(line.at(13, None, &both[..both.len() - 1]));
        // A wrong checksum is noise whatever follows.
        let mut noise = ANSWER;
        noise[8] ^= 1;
        line.sent(11, &DATA);
        disturbed(line.at(12, None, &noise));
    }
}
