//! The PROFIBUS master with the reference devices on the virtual bus, without a suite: both keep the bus timing.
//!
//! The bytes of Set_Prm and the expected answers come from the manuals and the notes in `device.yaml`, not from a run.

use controllers::profibus_dp::{
    ConnectionState, DataLinkAnswer, DpParameterOutcome, IsoModeClock, MasterOutcome, MasterRequest, MasterSettings,
    ProfibusMaster, SlaveConfig, SlaveConnectionEnd, SlaveReleaseOutcome, SlaveStartUpResult,
};
use deviations::{Line, ReferenceDevice, Setup, build};
use station::{Duration, StandAction, Time};
use virtual_wire::VirtualBus;
use wire::profibus::fdl::BaudRate;
use wire::profibus::global_control::{GlobalCommand, GlobalControl};

/// AMT58 HM, class 2, 65536 steps in each of 16384 revolutions; watchdog of 1 s.
const AMT58: &str = "88 14 05 0B 16 55 00 00 00 00 0A 00 01 00 00 40 00 00 00 00 00";
/// A3M60 with DP-V1 and its default parameters, no watchdog.
const A3M60: &str =
    "80 01 01 0B 0C 0A 00 80 00 00 02 0C 00 00 40 00 80 00 00 00 01 03 00 00 10 00 00 00 00 01 08 00 00 00";
/// The same as structured blocks, with isochronous mode of 1 ms (8 times 125 us).
const ISOCHRONOUS: &str = "80 01 01 0B 0C 0A 80 80 00 18 1C 81 00 00 02 0C 00 00 40 00 80 00 00 00 01 03 00 00 10 00 00 00 00 01 08 \
    00 00 00 1C 04 00 00 01 00 00 05 DC 00 08 01 00 00 00 0C 00 01 00 02 00 00 00 00 00 0C 00 00";

struct MasterAndSlave {
    bus: VirtualBus,
    master: ProfibusMaster,
    device: Box<dyn ReferenceDevice>,
    frames: usize,
}

fn octets(text: &str) -> Vec<u8> {
    let words = text.split_whitespace();
    words.map(|word| u8::from_str_radix(word, 16).expect("two hexadecimal digits")).collect()
}

impl MasterAndSlave {
    fn new(manual: &str, variant: &str, baud: BaudRate) -> MasterAndSlave {
        let setup = Setup { shaft: 5_000, line: Line { address: 3, baud }, ..Setup::default() };
        let device = build(manual, variant, &setup).map_err(|error| error.to_string()).expect("it is known");
        let settings = MasterSettings::new(2, baud);
        let bus = VirtualBus::new(baud, settings.slot_time);
        MasterAndSlave { bus, master: ProfibusMaster::new(settings), device, frames: 0 }
    }

    fn amt58() -> MasterAndSlave {
        let mut rig = MasterAndSlave::new("datalogic-amt58-profibus", "hm5816-16384", BaudRate(1_500_000));
        let start = rig.start(SlaveConfig::new(3, octets(AMT58), octets("D1 E1"), (4, 4)));
        assert!(start.standing, "{start:?}");
        rig
    }

    fn run(&mut self, time: Duration) {
        let until = self.bus.now() + time;
        let frames = &mut self.frames;
        self.bus.run(&mut [&mut self.master, &mut *self.device], until, &mut |_| *frames += 1);
    }

    fn ask(&mut self, request: MasterRequest) -> MasterOutcome {
        self.master.request(self.bus.now(), request).expect("an idle master");
        for _ in 0..1_000_000 {
            if let Some(outcome) = self.master.take_outcome() {
                return outcome;
            }
            self.bus.step(&mut [&mut self.master, &mut *self.device], Time::MAX, &mut |_| ());
        }
        panic!("no outcome");
    }

    fn start(&mut self, connection: SlaveConfig) -> SlaveStartUpResult {
        match self.ask(MasterRequest::Connect(Box::new(connection))) {
            MasterOutcome::StartUp(start) => *start,
            other => panic!("{other:?}"),
        }
    }

    fn diagnosis(&mut self, to: u8) -> Vec<u8> {
        match self.ask(MasterRequest::Diagnosis { to }) {
            MasterOutcome::Answer(answer) => answer.data().map(<[u8]>::to_vec).unwrap_or_default(),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn the_amt58_exchanges_data_and_both_keep_the_timing() {
    let mut rig = MasterAndSlave::amt58();
    rig.run(Duration::from_millis(200));
    assert_eq!(rig.master.state(), ConnectionState::Exchange);
    assert!((190..=210).contains(&rig.master.cycles_done()), "{}", rig.master.cycles_done());
    assert_eq!(rig.diagnosis(3)[..6], octets("00 0C 00 02 16 55"));
    assert_eq!(rig.bus.violations(), []);
    assert!(rig.frames < 1_000, "{} frames in 200 ms", rig.frames);
}

#[test]
fn the_preset_of_the_amt58_works_through_the_bus() {
    let mut rig = MasterAndSlave::amt58();
    rig.master.set_outputs(&octets("80 00 10 00"));
    rig.run(Duration::from_millis(10));
    rig.master.set_outputs(&octets("00 00 10 00"));
    rig.run(Duration::from_millis(10));
    assert_eq!(rig.master.inputs(), octets("00 00 10 00"));
}

#[test]
fn parameters_for_another_device_are_refused() {
    let mut rig = MasterAndSlave::new("datalogic-amt58-profibus", "hm5816-16384", BaudRate(1_500_000));
    let mut prm = octets(AMT58);
    prm[5] = 0x56;
    let start = rig.start(SlaveConfig::new(3, prm, octets("D1 E1"), (4, 4)));
    assert!(!start.standing);
    let diagnosis = start.diagnosis_after.and_then(|answer| answer.diagnosis()).expect("a diagnosis");
    assert!(diagnosis.status_1.0 & 0x40 != 0, "prm_fault in {diagnosis:?}");
    assert_eq!(rig.bus.violations(), []);
}

#[test]
fn a_pause_longer_than_the_watchdog_ends_the_exchange() {
    let mut rig = MasterAndSlave::amt58();
    rig.master.outputs_mut().pause(true);
    rig.run(Duration::from_millis(1_200));
    rig.master.outputs_mut().pause(false);
    rig.run(Duration::from_millis(5));
    assert_eq!(rig.master.state(), ConnectionState::None);
    assert!(matches!(rig.master.take_end(), Some(SlaveConnectionEnd::Answer(answer)) if answer.refused().is_some()));
}

#[test]
fn power_off_is_silence_and_release_frees_the_slave() {
    let mut rig = MasterAndSlave::amt58();
    assert_eq!(
        rig.ask(MasterRequest::Release),
        MasterOutcome::Ended(SlaveReleaseOutcome::Released(DataLinkAnswer::Short))
    );
    assert_eq!(rig.diagnosis(3)[3], 255, "no master controls the slave");
    let now = rig.bus.now();
    rig.device.act(now, &StandAction::Power(false)).expect("a model can be switched off");
    assert_eq!(rig.diagnosis(3), [0; 0]);
    assert_eq!(rig.ask(MasterRequest::FdlStatus { to: 3 }), MasterOutcome::Answer(DataLinkAnswer::None));
}

#[test]
fn clear_and_broken_frames_do_not_end_the_exchange() {
    let mut rig = MasterAndSlave::amt58();
    for (word, _) in controllers::profibus_dp::broken_frames() {
        // A faulty Set_Prm ends the exchange.
        if word == "set_prm_short" {
            continue;
        }
        let broken = controllers::profibus_dp::DamagedDpFrame::by_word(word).expect("it names itself");
        rig.ask(MasterRequest::Broken { to: 3, broken });
        rig.run(Duration::from_millis(5));
        assert_eq!(rig.master.state(), ConnectionState::Exchange, "{word}");
    }
    for command in [GlobalCommand::CLEAR_DATA, GlobalCommand::default()] {
        rig.ask(MasterRequest::GlobalControl { to: 127, control: GlobalControl { command, groups: 0 } });
        rig.run(Duration::from_millis(5));
    }
    assert_eq!(rig.master.state(), ConnectionState::Exchange);
    assert_eq!(rig.bus.violations(), []);
}

#[test]
fn parameters_of_the_a3m60_are_read_through_data_set_47() {
    let mut rig = MasterAndSlave::new("sick-a3m60-profibus", "a3m60", BaudRate(1_500_000));
    let start = rig.start(SlaveConfig::new(3, octets(A3M60), octets("C3 C1 C5 FD 00 51"), (4, 12)));
    assert!(start.standing, "{start:?}");
    // P922, the telegram in use, is 81.
    let request = octets("01 01 01 01 10 00 03 9A 00 00");
    let outcome = rig.ask(MasterRequest::Parameter { to: 3, slot: 1, request });
    assert_eq!(outcome, MasterOutcome::Parameter(DpParameterOutcome::Answer(octets("01 01 01 01 42 01 00 51"))));
    assert_eq!(rig.bus.violations(), []);
}

#[test]
fn the_a3m60_synchronises_with_the_clock() {
    let mut rig = MasterAndSlave::new("sick-a3m60-profibus", "a3m60", BaudRate(12_000_000));
    let mut connection = SlaveConfig::new(3, octets(ISOCHRONOUS), octets("C3 C1 C5 FD 00 51"), (4, 12));
    connection.clock = Some(IsoModeClock::default());
    let start = rig.start(connection);
    assert!(start.standing, "{start:?}");
    rig.run(Duration::from_millis(50));
    let life = |rig: &MasterAndSlave| rig.master.inputs()[0] >> 4;
    let first = life(&rig);
    assert_ne!(first, 0, "the encoder is synchronised");
    rig.run(Duration::from_millis(1));
    assert_eq!(life(&rig), first % 15 + 1);
    assert_eq!(rig.bus.violations(), []);
}
