//! Medium access of the DP master: idle times, token holding time, and whose token it accepts.

use crate::dp::{BAUD, MasterRig, SLAVE, ScriptedSlave, bits, connection, hex, settings};
use core::time::Duration;
use encspec_controllers::profibus_dp::{
    DataLinkAnswer, MasterOutcome, MasterRequest, MasterSettings, ProfibusMaster, SlaveConfig,
};
use rstest::rstest;
use station::{Station, Time};
use virtual_wire::VirtualBus;
use wire::profibus::fdl::{BaudRate, BitTimes};
use wire::profibus::global_control::{GlobalCommand, GlobalControl};

/// The master at port 0, the slave at port 1 and a second master at address 4 and port 2, which has nothing to send.
struct RingRig {
    bus: VirtualBus,
    first: ProfibusMaster,
    slave: ScriptedSlave,
    second: ProfibusMaster,
    /// Begin and end of each frame in nanoseconds, its port and its bytes.
    log: Vec<(u64, u64, usize, String)>,
}

impl RingRig {
    /// Both masters are in the ring; the first polls for others with every token.
    fn new(rotation: BitTimes) -> RingRig {
        let first = MasterSettings { rotation, gap_factor: 1, patience: Duration::from_millis(50), ..settings() };
        let second = MasterSettings { gap_factor: 0, ..MasterSettings::new(4, BAUD) };
        let mut rig = RingRig {
            bus: VirtualBus::new(BAUD, settings().slot_time),
            first: ProfibusMaster::new(first),
            slave: ScriptedSlave::new(),
            second: ProfibusMaster::new(second),
            log: Vec::new(),
        };
        rig.run(Duration::from_millis(50));
        assert!(rig.log.iter().any(|(_, _, port, octets)| (*port, octets.as_str()) == (2, "DC 02 04")));
        rig.log.clear();
        rig
    }

    fn run(&mut self, time: Duration) {
        let until = self.bus.now() + time;
        let log = &mut self.log;
        let stations: &mut [&mut dyn Station] = &mut [&mut self.first, &mut self.slave, &mut self.second];
        self.bus.run(stations, until, &mut |frame| {
            log.push((frame.begin.as_nanos(), frame.time.as_nanos(), frame.port, hex(frame.frame)));
        });
    }

    /// Sends a request to the first master; returns its outcome after `time`.
    fn ask(&mut self, request: MasterRequest, time: Duration) -> Option<MasterOutcome> {
        self.first.request(self.bus.now(), request).expect("nothing else is under way");
        self.run(time);
        self.first.take_outcome()
    }

    /// Starts an exchange of the first master whose next Data_Exchange is always due.
    fn exchange(&mut self) {
        let connection = SlaveConfig { cycle: Duration::from_micros(1), ..connection() };
        let outcome = self.ask(MasterRequest::Connect(Box::new(connection)), Duration::from_millis(40));
        assert!(matches!(outcome, Some(MasterOutcome::StartUp(result)) if result.standing));
        self.log.clear();
    }

    /// What the first master sends in each token hold: `X` Data_Exchange, `G` a poll for masters, `R` DP-V1, `?` anything else.
    fn holds(&self) -> Vec<String> {
        let text = |octets: &str| match octets {
            "DC 04 02" => " ",
            _ if octets.starts_with("10 ") && &octets[9..11] == "49" => "G",
            _ if octets.starts_with("68") && octets[12..14] == *"03" => "X",
            _ if octets.starts_with("68") && octets[21..23] == *"33" => "R",
            _ => "?",
        };
        let sent = self.log.iter().filter(|(_, _, port, _)| *port == 0);
        let all: String = sent.map(|(_, _, _, octets)| text(octets)).collect();
        let mut holds: Vec<String> = all.split(' ').map(str::to_owned).collect();
        // The first and the last are not whole.
        holds.pop();
        if !holds.is_empty() {
            holds.remove(0);
        }
        holds
    }
}

fn read() -> MasterRequest {
    MasterRequest::Read { to: SLAVE, slot: 1, index: 7, length: 10 }
}

#[test]
fn a_late_token_carries_one_message_of_high_priority() {
    let mut rig = RingRig::new(BitTimes(100));
    rig.exchange();
    rig.run(Duration::from_millis(5));
    let holds = rig.holds();
    assert!(holds.len() > 3 && holds.iter().all(|hold| hold == "X"), "{holds:?}");
    assert_eq!(rig.bus.violations(), []);
}

#[test]
fn a_late_token_carries_no_message_of_low_priority_and_the_request_gives_up() {
    let mut rig = RingRig::new(BitTimes(100));
    assert_eq!(rig.ask(read(), Duration::from_millis(30)), None);
    let holds = rig.holds();
    assert!(holds.len() > 10 && holds.iter().all(String::is_empty), "{holds:?}");
    rig.run(Duration::from_millis(40));
    let why = "the token comes too late to leave time for the request";
    assert_eq!(rig.first.take_outcome(), Some(MasterOutcome::Impossible(why)));
    let outcome = rig.ask(MasterRequest::Diagnosis { to: SLAVE }, Duration::from_millis(30));
    assert!(matches!(outcome, Some(MasterOutcome::Answer(answer)) if answer.diagnosis().is_some()));
}

#[test]
fn with_time_left_messages_of_low_priority_and_polls_are_sent_and_the_poll_is_last() {
    let mut rig = RingRig::new(BitTimes(50_000));
    let connection = SlaveConfig { cycle: Duration::from_micros(500), ..connection() };
    rig.ask(MasterRequest::Connect(Box::new(connection)), Duration::from_millis(40));
    rig.log.clear();
    let outcome = rig.ask(read(), Duration::from_millis(40));
    assert!(matches!(outcome, Some(MasterOutcome::Record(_))), "{outcome:?}");
    let holds = rig.holds();
    assert!(holds.iter().any(|hold| hold.contains('R')), "{holds:?}");
    assert!(holds.iter().any(|hold| hold.contains("XG")), "{holds:?}");
    assert!(holds.iter().all(|hold| hold.find('G').is_none_or(|at| at + 1 == hold.len())), "{holds:?}");
}

#[test]
fn a_message_that_has_begun_is_finished_with_its_retries() {
    let mut rig = RingRig::new(BitTimes(100));
    rig.run(Duration::from_millis(1));
    let outcome = rig.ask(MasterRequest::Diagnosis { to: 77 }, Duration::from_millis(30));
    assert_eq!(outcome, Some(MasterOutcome::Answer(DataLinkAnswer::None)));
    let holds = rig.holds();
    assert_eq!(holds.iter().filter(|hold| !hold.is_empty()).collect::<Vec<_>>(), ["??"]);
}

#[test]
fn the_rotation_is_measured_from_receipt_to_receipt() {
    let rotation = BitTimes(3_000);
    let mut rig = RingRig::new(rotation);
    rig.exchange();
    rig.run(Duration::from_millis(40));
    let is_receipt = |port: usize, octets: &str| (port, octets) == (2, "DC 02 04");
    let received = rig.log.iter().filter(|(_, _, port, octets)| is_receipt(*port, octets));
    let received: Vec<u64> = received.map(|(_, end, _, _)| *end).collect();
    assert!(received.len() > 10, "{}", received.len());
    // TTH ends at TTR after the receipt before. What was begun then is finished: at most two messages of 500 bits each, the token,
    // and the second master, which passes an unused token after half a slot.
    let most = bits(rotation.0 + 2 * 500 + 2 * (33 + 37) + 150 + 33);
    let least = bits(rotation.0);
    for of in received.windows(3) {
        let two_rotations = of[2] - of[0];
        assert!((least..most).contains(&two_rotations), "{two_rotations} ns");
    }
}

#[test]
fn a_token_of_an_unknown_master_is_taken_when_it_is_repeated() {
    let mut master = ProfibusMaster::new(settings());
    let mut bus = VirtualBus::new(BAUD, settings().slot_time);
    let mut log = Vec::new();
    let mut run = |bus: &mut VirtualBus, nanos: u64| {
        let until = bus.now() + Duration::from_nanos(nanos);
        bus.run(&mut [&mut master], until, &mut |frame| log.push((frame.port, hex(frame.frame))));
        core::mem::take(&mut log)
    };
    run(&mut bus, 10_000_000);
    // Between two of its tokens; then within the slot time nothing, as at a token that was lost.
    while run(&mut bus, bits(10)).is_empty() {}
    run(&mut bus, bits(40));
    bus.inject(5, &[0xDC, 0x02, 0x09]).expect("the bus is silent");
    assert_eq!(run(&mut bus, bits(33 + 300)), [(5, "DC 02 09".to_owned())]);
    bus.inject(5, &[0xDC, 0x02, 0x09]).expect("the bus is silent");
    let after = run(&mut bus, bits(33 + 300));
    assert_eq!(after, [(5, "DC 02 09".to_owned()), (0, "DC 09 02".to_owned())]);
}

// TID1 follows the token, TID2 the Global_Control, in bits.
#[rstest]
#[case(1_500_000, 37, 150)]
#[case(3_000_000, 46, 250)]
#[case(12_000_000, 76, 800)]
fn a_token_is_followed_by_tid1_and_a_request_without_answer_by_tid2(
    #[case] baud: u32,
    #[case] idle_1: u64,
    #[case] idle_2: u64,
) {
    let baud = BaudRate(baud);
    let mut master = ProfibusMaster::new(MasterSettings::new(2, baud));
    let control = GlobalControl { command: GlobalCommand::default(), groups: 0 };
    master.request(Time::ZERO, MasterRequest::GlobalControl { to: 127, control }).expect("nothing else is under way");
    let mut bus = VirtualBus::new(baud, master.settings().slot_time);
    let mut log = Vec::new();
    bus.run(&mut [&mut master], Time::ZERO + Duration::from_millis(3), &mut |frame| {
        log.push((frame.begin, frame.time, hex(frame.frame)));
    });
    let silence = |index: usize| baud.bits(log[index + 1].0.nanos_since(log[index].1) + 1);
    assert_eq!(log[0].2, "DC 02 02");
    assert_eq!(silence(0), BitTimes(idle_1));
    let at = log.iter().position(|(_, _, octets)| octets.starts_with("68")).expect("Global_Control is sent");
    assert_eq!(silence(at), BitTimes(idle_2));
    assert_eq!(bus.violations(), []);
}

#[test]
fn the_master_measures_answers_retries_and_the_rotation_of_the_token() {
    let mut rig = MasterRig::new();
    rig.slave.delay = BitTimes(37);
    rig.ask(MasterRequest::Diagnosis { to: SLAVE });
    rig.slave.delay = BitTimes(160);
    rig.ask(MasterRequest::Diagnosis { to: SLAVE });
    rig.slave.delay = BitTimes(11);
    rig.slave.deaf = 1;
    rig.ask(MasterRequest::Diagnosis { to: SLAVE });
    rig.ask(MasterRequest::Diagnosis { to: 77 });
    let measured = rig.master.statistics();
    // The polls for other masters are not among them.
    assert_eq!(measured.stations().iter().map(|of| of.station).collect::<Vec<_>>(), [SLAVE, 77]);
    let [slave, absent] = measured.stations() else { panic!("{measured:?}") };
    // 37, 160 after max TSDR, and 11 for the repetition: the mean is 69.3.
    assert_eq!(slave.answers.least_mean_most(), Some([11, 69, 160].map(BitTimes)));
    assert_eq!((slave.late, slave.retries, slave.unanswered), (1, 1, 0));
    assert_eq!((absent.answers.count(), absent.retries, absent.unanswered), (0, 1, 1));
    assert_eq!(measured.tsdr, (BitTimes(11), BitTimes(150)));
    // At the claim two tokens follow each other: 33 bits and TID1.
    let [least, ..] = measured.rotation.least_mean_most().expect("it holds the token");
    assert_eq!(least, BitTimes(70));
}
