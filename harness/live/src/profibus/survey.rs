//! Survey of a PROFIBUS: which stations are on it, what they are, and what was received before the first frame of the harness.
//!
//! It listens first. On a silent bus it then takes the token, asks every address for its FDL status, and reads the diagnosis of each
//! slave; it sends nothing else, and nothing at all where another station sends. This module must not know suites.

use super::preflight::{interruptible, open_line};
use super::{is_of_master, words};
use crate::fdl::FdlFrames;
use crate::unusable::{PreflightResult, Unusable, unusable};
use controllers::profibus_dp::{
    DataLinkAnswer, LiveBusTiming, MasterOutcome, MasterRequest, MasterSettings, ProfibusMaster,
};
use link::{BusTransmission, SerialBus};
use results::bench_file::LineSpec;
use station::{Duration, Time};
use std::collections::BTreeMap;
use wire::profibus::diag::SlaveDiag;
use wire::profibus::fdl::{BROADCAST, BaudRate, BitTimes, FdlFrame, RequestFunction, StationType, UNNAMED};
use wire::profibus::sap::{MasterSap, SapService, SlaveSap};

/// Minimum time to listen before the first frame of the harness.
const SHORTEST_LISTENING: Duration = Duration::from_secs(1);
/// The longest token rotation time on most buses (TTR), in bit times.
const ROTATION: BitTimes = BitTimes(50_000);
/// Slot times until the master with the highest address, 126, claims the token (TTO = 6 TSL + 2 n TSL).
const LONGEST_TIME_OUT: u64 = 6 + 2 * UNNAMED as u64;
/// Timeout for a request, including the wait for the token.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(5);
/// The address of the master that asks; that of a programming device, which no slave has from the factory.
const OWN: u8 = 0;

/// How long to listen at `baud` until every station that sends without being asked has been received: the longest time-out of a master
/// (TTO) with this slot time, else that of the standard, and two rotations of the token; at least a second.
pub fn listening_time(baud: BaudRate, slot_time: Option<BitTimes>) -> Duration {
    let slot = slot_time.unwrap_or(MasterSettings::new(0, baud).slot_time);
    let bits = BitTimes((slot.0 * LONGEST_TIME_OUT).max(2 * ROTATION.0));
    SHORTEST_LISTENING.max(Duration::from_nanos(baud.nanoseconds(bits)))
}

/// What was received while nothing was sent.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReceivedTraffic {
    /// How long.
    pub time: Duration,
    /// Number of valid frames.
    pub frames: u64,
    /// The masters: stations that sent tokens or requests, with the number of tokens of each.
    pub masters: BTreeMap<u8, u64>,
    /// The shortest and the longest time between two tokens of the same master.
    pub rotation: Option<(Duration, Duration)>,
    /// The stations that answered, with the ident number where a diagnosis was among the answers.
    pub answering: BTreeMap<u8, Option<u16>>,
    /// Pieces that are no frames, and the first of them.
    pub damaged: (u64, Option<String>),
    last_token: BTreeMap<u8, Time>,
}

impl ReceivedTraffic {
    /// Whether nothing was received.
    pub fn is_silent(&self) -> bool {
        self.frames == 0 && self.damaged.0 == 0
    }

    /// Takes in one piece of the line.
    fn add(&mut self, begin: Time, octets: &[u8]) {
        let frame = match FdlFrame::parse(octets) {
            Ok(frame) => frame,
            Err(_) => {
                self.damaged.0 += 1;
                self.damaged.1.get_or_insert_with(|| words(octets));
                return;
            }
        };
        self.frames += 1;
        match frame {
            FdlFrame::Token { sa, .. } => {
                *self.masters.entry(sa).or_default() += 1;
                if let Some(before) = self.last_token.insert(sa, begin) {
                    let round = begin.since(before);
                    let (shortest, longest) = self.rotation.unwrap_or((round, round));
                    self.rotation = Some((shortest.min(round), longest.max(round)));
                }
            }
            FdlFrame::Data(frame) if frame.fc.is_request() => {
                self.masters.entry(frame.sa).or_default();
            }
            FdlFrame::Data(frame) => {
                let points = (frame.source.sap, frame.destination.sap);
                let is_diagnosis = points == (Some(SlaveSap::SLAVE_DIAG.0), Some(MasterSap::MS0.0));
                let ident = SlaveDiag::parse(frame.data).ok().filter(|_| is_diagnosis).map(|diagnosis| diagnosis.ident);
                let known = self.answering.entry(frame.sa).or_default();
                *known = ident.or(*known);
            }
            FdlFrame::ShortAcknowledgement => {}
        }
    }
}

/// A station that answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundStation {
    /// Its address.
    pub address: u8,
    /// What it says it is.
    pub kind: StationType,
    /// The diagnosis of a slave, if it gave one.
    pub diagnosis: Option<SlaveDiag>,
}

/// The result of a survey.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BusSurvey {
    /// The line.
    pub line: String,
    /// The rate at which it was read.
    pub baud: BaudRate,
    /// What was received before anything was sent.
    pub received: ReceivedTraffic,
    /// The stations, by address; `None` if nothing was sent because another station sends.
    pub stations: Option<Vec<FoundStation>>,
}

/// Surveys the bus at the serial line `path`. Where another station sends, it sends only if the bus is `alone`, which says that no station on
/// it can be disturbed. Fails if the line cannot be used, or if another master begins to send.
pub fn survey(path: &str, spec: &LineSpec, alone: bool) -> PreflightResult<BusSurvey> {
    let (serial, baud) = open_line(path, spec)?;
    link::privileges::drop()?;
    let line = serial.describe();
    let mut bus = SerialBus::new(serial, Box::<FdlFrames>::default());
    let received = listen(&mut bus, listening_time(baud, spec.slot_time))?;
    let mut survey = BusSurvey { line, baud, received, stations: None };
    if survey.received.is_silent() || alone {
        let mut live_list =
            LiveList { bus, baud, pace: LiveBusTiming::new(baud, spec.slot_time, spec.max_tsdr), alone };
        survey.stations = Some(live_list.stations(&survey.line)?);
    }
    Ok(survey)
}

/// Listens for `time` without sending.
fn listen(bus: &mut SerialBus, time: Duration) -> PreflightResult<ReceivedTraffic> {
    bus.restart();
    let until = bus.now() + time;
    let mut received = ReceivedTraffic { time, ..ReceivedTraffic::default() };
    while bus.now() < until {
        interruptible()?;
        bus.step(&mut [], until, &mut |_| false, &mut |of: BusTransmission<'_>| received.add(of.begin, of.octets))?;
    }
    Ok(received)
}

/// Asks every address.
struct LiveList {
    bus: SerialBus,
    baud: BaudRate,
    pace: LiveBusTiming,
    /// Whether another master may be on the bus.
    alone: bool,
}

impl LiveList {
    /// The stations that answer, by address.
    fn stations(&mut self, line: &str) -> PreflightResult<Vec<FoundStation>> {
        let mut found = Vec::new();
        let mut master = self.master(OWN);
        for address in (0..BROADCAST).filter(|address| *address != OWN) {
            found.extend(self.station(&mut master, address, line)?);
        }
        // The address of the master that asked is asked by one with another address.
        let free = (0..BROADCAST).find(|address| *address != OWN && found.iter().all(|of| of.address != *address));
        if let Some(free) = free {
            let mut master = self.master(free);
            let own = self.station(&mut master, OWN, line)?;
            found.splice(0..0, own);
        }
        Ok(found)
    }

    fn master(&self, address: u8) -> ProfibusMaster {
        ProfibusMaster::new(self.pace.settings(address, self.baud, address))
    }

    /// The station at `address`, if one answers.
    fn station(
        &mut self,
        master: &mut ProfibusMaster,
        address: u8,
        line: &str,
    ) -> PreflightResult<Option<FoundStation>> {
        let kind = match self.ask(master, MasterRequest::FdlStatus { to: address }, line)? {
            DataLinkAnswer::Frame { station, .. } => station,
            // It answers, but no station answers FDL status so.
            DataLinkAnswer::Short => StationType::SLAVE,
            DataLinkAnswer::None | DataLinkAnswer::Unfit(_) => return Ok(None),
        };
        let diagnosis = match kind {
            StationType::SLAVE => self.ask(master, MasterRequest::Diagnosis { to: address }, line)?.diagnosis(),
            _ => None,
        };
        Ok(Some(FoundStation { address, kind, diagnosis }))
    }

    /// Sends a request and waits for its answer.
    fn ask(
        &mut self,
        master: &mut ProfibusMaster,
        request: MasterRequest,
        line: &str,
    ) -> PreflightResult<DataLinkAnswer> {
        let now = self.bus.now();
        master.request(now, request).map_err(|busy| Unusable(busy.to_string()))?;
        let until = now + REQUEST_TIMEOUT;
        loop {
            match master.take_outcome() {
                Some(MasterOutcome::Answer(answer)) => return Ok(answer),
                Some(_) => return unusable(format!("a request on the bus at {line} was interrupted")),
                None if self.bus.now() >= until => {
                    return unusable(format!("the master does not get the token on {line}"));
                }
                None => {}
            }
            interruptible()?;
            let mut foreign = None;
            let mut tap = |of: BusTransmission<'_>| {
                if of.sender.is_none() && is_of_master(of.octets) {
                    foreign = Some(words(of.octets));
                }
            };
            self.bus.step(&mut [&mut *master], until, &mut is_question, &mut tap)?;
            if let Some(foreign) = foreign.filter(|_| !self.alone) {
                return unusable(format!("{line} has another master: received {foreign}; nothing more was sent"));
            }
        }
    }
}

/// Whether a frame changes nothing at its receiver: a token, FDL status, Slave_Diag. No other frame leaves.
fn is_question(octets: &[u8]) -> bool {
    match FdlFrame::parse(octets) {
        Ok(FdlFrame::Token { .. }) => true,
        Ok(FdlFrame::Data(frame)) => {
            frame.fc.requested() == Some(RequestFunction::FDL_STATUS)
                || !frame.fc.is_request()
                || SapService::of(&frame) == SapService::Slave(SlaveSap::SLAVE_DIAG)
        }
        Ok(FdlFrame::ShortAcknowledgement) | Err(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    /// IEC 61158-4-3: TTO = 6 TSL + 2 n TSL with n = 126, so 258 slot times; TTR is 50,000 bit times on most buses.
    #[rstest]
    #[case::two_rotations_at_a_low_rate(9_600, None, Duration::from_nanos(10_416_666_666))]
    #[case::a_second_at_least(1_500_000, None, Duration::from_secs(1))]
    #[case::the_time_out_with_a_long_slot_time(187_500, Some(3_750), Duration::from_millis(5_160))]
    fn the_bus_is_listened_to_for_the_longest_time_out_and_two_rotations(
        #[case] baud: u32,
        #[case] slot: Option<u64>,
        #[case] expected: Duration,
    ) {
        let time = listening_time(BaudRate(baud), slot.map(BitTimes));
        assert!(time.abs_diff(expected) < Duration::from_micros(1), "{time:?}");
    }

    #[test]
    fn traffic_is_summed_up_by_station() {
        let mut received = ReceivedTraffic::default();
        let at = |millis| Time::ZERO + Duration::from_millis(millis);
        // Two tokens of master 2, a Slave_Diag request of it to slave 5, and the answer with ident 0x1655.
        received.add(at(0), &[0xDC, 2, 2]);
        received.add(at(1), &[0x68, 5, 5, 0x68, 0x85, 0x82, 0x6D, 60, 62, 0xEE, 0x16]);
        let mut body = vec![0x82, 0x85, 0x08, 62, 60, 0x02, 0x05, 0x00, 0xFF, 0x16, 0x55];
        let sum = body.iter().fold(0u8, |sum, octet| sum.wrapping_add(*octet));
        body.extend([sum, 0x16]);
        received.add(at(2), &[&[0x68, 11, 11, 0x68][..], &body].concat());
        received.add(at(7), &[0xDC, 2, 2]);
        received.add(at(10), &[0xDC, 2, 2]);
        received.add(at(11), &[0xFF, 0x00]);
        assert_eq!(received.masters, BTreeMap::from([(2, 3)]));
        assert_eq!(received.answering, BTreeMap::from([(5, Some(0x1655))]));
        assert_eq!(received.rotation, Some((Duration::from_millis(3), Duration::from_millis(7))));
        assert_eq!((received.frames, received.damaged.0), (5, 1));
        assert!(!received.is_silent());
    }

    #[rstest]
    #[case::token(&[0xDC, 2, 2], true)]
    #[case::fdl_status(&[0x10, 5, 2, 0x49, 0x50, 0x16], true)]
    #[case::slave_diag(&[0x68, 5, 5, 0x68, 0x85, 0x82, 0x6D, 60, 62, 0xEE, 0x16], true)]
    #[case::get_cfg(&[0x68, 5, 5, 0x68, 0x85, 0x82, 0x6D, 59, 62, 0xED, 0x16], false)]
    #[case::data(&[0x68, 4, 4, 0x68, 5, 2, 0x7D, 0, 0x84, 0x16], false)]
    #[case::no_frame(&[0xFF, 1, 2], false)]
    fn only_questions_leave(#[case] octets: &[u8], #[case] goes: bool) {
        assert_eq!(is_question(octets), goes);
    }
}
