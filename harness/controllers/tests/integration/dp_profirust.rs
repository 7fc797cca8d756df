//! The master of the harness and profirust, an independent master, in one logical ring: each accepts the token of the other and
//! passes it back.

use crate::dp::{BAUD, SLAVE, ScriptedSlave, hex, settings};
use core::time::Duration;
use encspec_controllers::profibus_dp::{
    ConnectionState, MasterOutcome, MasterRequest, MasterSettings, ProfibusMaster, SlaveConfig,
};
use profirust::fdl::live_list::LiveList;
use profirust::fdl::{FdlActiveStation, ParametersBuilder};
use profirust::phy::ProfibusPhy;
use profirust::time::Instant;
use station::{Outbox, Station, Time};
use virtual_wire::VirtualBus;
use wire::profibus::fdl::BitTimes;

/// How often profirust polls its line.
const POLL: Duration = Duration::from_micros(10);

/// The line of profirust.
#[derive(Default)]
struct ProfirustLine {
    received: Vec<u8>,
    sent: Vec<u8>,
    busy_until: Option<i64>,
    /// Start time of a frame that is not complete yet.
    hearing: Option<i64>,
}

impl ProfibusPhy for ProfirustLine {
    fn poll_transmission(&mut self, now: Instant) -> bool {
        self.busy_until.is_some_and(|until| now.total_micros() < until)
    }

    fn transmit_data<F, R>(&mut self, now: Instant, f: F) -> R
    where
        F: FnOnce(&mut [u8]) -> (usize, R),
    {
        let mut buffer = [0; 256];
        let (count, result) = f(&mut buffer);
        if count > 0 {
            self.sent.extend_from_slice(&buffer[..count]);
            let lasts = BAUD.nanoseconds(BitTimes::of_octets(count)).div_ceil(1_000);
            self.busy_until = Some(now.total_micros() + lasts as i64);
        }
        result
    }

    fn receive_data<F, R>(&mut self, _now: Instant, f: F) -> R
    where
        F: FnOnce(&[u8]) -> (usize, R),
    {
        let (count, result) = f(&self.received);
        self.received.drain(..count);
        result
    }

    /// Counts the bytes of a frame as they arrive, so that profirust notices it in time; the bytes are handed out when the frame
    /// is complete.
    fn poll_pending_received_bytes(&mut self, now: Instant) -> usize {
        let octet = BAUD.nanoseconds(BitTimes(BitTimes::PER_OCTET)).div_ceil(1_000) as i64;
        let coming = self.hearing.map_or(0, |since| (now.total_micros() - since) / octet);
        self.received.len() + usize::try_from(coming).unwrap_or_default()
    }
}

/// profirust as a station that lists the stations on the bus.
struct ProfirustStation {
    station: FdlActiveStation,
    list: LiveList,
    line: ProfirustLine,
    next: Time,
}

impl ProfirustStation {
    fn new(address: u8) -> ProfirustStation {
        let parameters = ParametersBuilder::new(address, profirust::Baudrate::B1500000).slot_bits(300).build();
        let mut station = FdlActiveStation::new(parameters);
        station.set_online();
        ProfirustStation { station, list: LiveList::new(), line: ProfirustLine::default(), next: Time::ZERO }
    }

    fn stations(&self) -> Vec<u8> {
        self.list.iter_stations().collect()
    }
}

/// A time in microseconds, as profirust counts.
fn micros(time: Time) -> i64 {
    i64::try_from(time.as_nanos() / 1_000).expect("a short run")
}

impl Station for ProfirustStation {
    fn carrier(&mut self, now: Time) {
        self.line.hearing = Some(micros(now));
    }

    fn receive(&mut self, _now: Time, frame: &[u8], _out: &mut Outbox) {
        self.line.hearing = None;
        self.line.received.extend_from_slice(frame);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.station.poll(Instant::from_micros(micros(now)), &mut self.line, &mut self.list);
        if !self.line.sent.is_empty() {
            out.push(&core::mem::take(&mut self.line.sent));
        }
        self.next = now + POLL;
    }

    fn deadline(&self) -> Option<Time> {
        Some(self.next)
    }
}

/// Runs the master of the harness at `own` and profirust at `other` on a bus with the slave; returns the observed tokens.
fn share(own: u8, other: u8) -> (ProfibusMaster, ProfirustStation, Vec<String>) {
    let mut master = ProfibusMaster::new(MasterSettings::new(own, BAUD));
    let mut profirust = ProfirustStation::new(other);
    let mut slave = ScriptedSlave::new();
    let mut bus = VirtualBus::new(BAUD, settings().slot_time);
    let connection = SlaveConfig::new(SLAVE, crate::dp::SET_PRM.to_vec(), vec![0xD1, 0xE1], (4, 4));
    master.request(Time::ZERO, MasterRequest::Connect(Box::new(connection))).expect("nothing else is under way");
    let mut tokens = Vec::new();
    let mut run = |master: &mut ProfibusMaster, profirust: &mut ProfirustStation, until: u64| {
        let mut tap = |frame: virtual_wire::TappedFrame<'_>| {
            if frame.frame[0] == 0xDC {
                tokens.push(hex(frame.frame));
            }
        };
        bus.run(&mut [master, &mut slave, profirust], Time::from_nanos(until), &mut tap);
    };
    run(&mut master, &mut profirust, 2_000_000_000);
    (master, profirust, tokens)
}

#[test]
fn profirust_enters_the_ring_of_the_harness() {
    let (mut master, profirust, tokens) = share(2, 4);
    assert!(tokens.iter().any(|token| token == "DC 04 02") && tokens.iter().any(|token| token == "DC 02 04"));
    assert!(profirust.station.is_in_ring());
    assert!([2, SLAVE].iter().all(|known| profirust.stations().contains(known)), "{:?}", profirust.stations());
    assert!(matches!(master.take_outcome(), Some(MasterOutcome::StartUp(result)) if result.standing));
    assert_eq!(master.state(), ConnectionState::Exchange);
    assert!(master.cycles_done() > 1_000, "{}", master.cycles_done());
    // Once both are in the ring, the token only moves between them.
    let last = &tokens[tokens.len() - 20..];
    assert!(last.iter().all(|token| token == "DC 04 02" || token == "DC 02 04"), "{last:?}");
}

#[test]
fn the_harness_enters_the_ring_of_profirust() {
    let (mut master, profirust, tokens) = share(4, 1);
    assert_eq!(tokens.first().map(String::as_str), Some("DC 01 01"), "it was there first");
    assert!(matches!(master.take_outcome(), Some(MasterOutcome::StartUp(result)) if result.standing));
    assert_eq!(master.state(), ConnectionState::Exchange);
    assert!([SLAVE, 4].iter().all(|known| profirust.stations().contains(known)), "{:?}", profirust.stations());
    let last = &tokens[tokens.len() - 20..];
    assert!(last.iter().all(|token| token == "DC 04 01" || token == "DC 01 04"), "{last:?}");
}
