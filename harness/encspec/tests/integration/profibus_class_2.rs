//! The PROFIBUS master as class 2 master with the slave of the device stack, which is another implementation of MS2: neither reads the
//! other.

#[path = "../../../../device-under-test/device-stack/src/profibus/tests/bench.rs"]
#[allow(dead_code, reason = "the tests of the slave use the rest")]
mod bench;
#[path = "../../../../device-under-test/device-stack/src/profibus/tests/toy.rs"]
#[allow(dead_code, reason = "the tests of the slave use the rest")]
mod toy;

use self::toy::ToySlaveApplication;
use crate::common::program::encspec;
use controllers::profibus_dp::{
    DataLinkAnswer, DpRecordOutcome, MasterOutcome, MasterRequest, MasterSettings, Ms2Outcome, Ms2Parameters,
    Ms2Service, ProfibusMaster,
};
use device_stack::Attached;
use device_stack::profibus::DpDevice;
use station::{Duration, Time};
use virtual_wire::VirtualBus;
use wire::profibus::call::{DpIm0, FunctionIndex};
use wire::profibus::dpv1::{Dpv1AbortReason, RecordError, Subnet};
use wire::profibus::fdl::BaudRate;

/// The station address of the toy slave.
const SLAVE: u8 = 5;

struct Class2 {
    bus: VirtualBus,
    master: ProfibusMaster,
    device: DpDevice<ToySlaveApplication>,
}

impl Class2 {
    fn new() -> Class2 {
        let settings = MasterSettings::new(2, BaudRate(1_500_000));
        let bus = VirtualBus::new(settings.baud, settings.slot_time);
        Class2 { bus, master: ProfibusMaster::new(settings), device: toy::bench(Attached::NONE).device }
    }

    fn run(&mut self, time: Duration) {
        let until = self.bus.now() + time;
        self.bus.run(&mut [&mut self.master, &mut self.device], until, &mut |_| ());
    }

    fn request(&mut self, request: MasterRequest) -> MasterOutcome {
        self.master.request(self.bus.now(), request).expect("an idle master");
        for _ in 0..1_000_000 {
            if let Some(outcome) = self.master.take_outcome() {
                return outcome;
            }
            self.bus.step(&mut [&mut self.master, &mut self.device], Time::MAX, &mut |_| ());
        }
        panic!("no outcome");
    }

    fn ask(&mut self, service: Ms2Service) -> MasterOutcome {
        self.request(MasterRequest::Ms2 { to: SLAVE, service })
    }

    fn open(&mut self) {
        let outcome = self.ask(Ms2Service::Initiate(Ms2Parameters::default()));
        let MasterOutcome::Ms2(Ms2Outcome::Opened(opened)) = outcome else { panic!("{outcome:?}") };
        assert_eq!((opened.sap, opened.most_data, opened.send_timeout), (0, 240, Duration::from_secs(1)));
    }

    fn record(&mut self) -> DpRecordOutcome {
        match self.ask(Ms2Service::Read { slot: 1, index: 47, length: 240 }) {
            MasterOutcome::Ms2(Ms2Outcome::Record(outcome)) => outcome,
            other => panic!("{other:?}"),
        }
    }
}

fn accepted(data: &[u8]) -> DpRecordOutcome {
    DpRecordOutcome::Accepted { data: data.to_vec() }
}

#[test]
fn records_are_read_and_written_without_data_exchange() {
    let mut rig = Class2::new();
    rig.open();
    assert_eq!(rig.record(), accepted(&[1, 2, 3]));
    let write = Ms2Service::Write { slot: 1, index: 47, data: vec![7, 8] };
    assert_eq!(rig.ask(write), MasterOutcome::Ms2(Ms2Outcome::Record(accepted(&[]))));
    assert_eq!(rig.record(), accepted(&[7, 8]));
    let other = rig.ask(Ms2Service::Read { slot: 1, index: 48, length: 1 });
    let MasterOutcome::Ms2(Ms2Outcome::Record(DpRecordOutcome::Refused(refusal))) = other else { panic!("{other:?}") };
    assert_eq!(refusal.record_error(), Some(RecordError::INVALID_INDEX));
    assert_eq!(rig.bus.violations(), []);
}

/// The slave closes a connection after twice its Send_Timeout without a frame.
#[test]
fn idle_keeps_the_connection_and_abort_makes_room_for_the_next() {
    let mut rig = Class2::new();
    rig.open();
    rig.run(Duration::from_secs(10));
    assert_eq!((rig.master.ms2_slave(), rig.master.take_ms2_end()), (Some(SLAVE), None));
    assert_eq!(rig.record(), accepted(&[1, 2, 3]));
    let abort = Ms2Service::Abort { subnet: Subnet::NO, reason: Dpv1AbortReason(0x20) };
    assert_eq!(rig.ask(abort), MasterOutcome::Ms2(Ms2Outcome::Aborted(DataLinkAnswer::Short)));
    // The slave has one connection: it is free again.
    rig.open();
}

#[test]
fn a_slave_without_power_ends_the_connection() {
    let mut rig = Class2::new();
    rig.open();
    rig.device.power(rig.bus.now(), false);
    rig.run(Duration::from_secs(1));
    assert_eq!(rig.master.ms2_slave(), None);
    assert!(matches!(rig.master.take_ms2_end(), Some(Ms2Outcome::Failed(_))));
}

#[test]
fn requests_and_polls_are_repeated_on_the_connection() {
    let mut rig = Class2::new();
    rig.open();
    let service = Ms2Service::Read { slot: 1, index: 47, length: 240 };
    let request = Box::new(MasterRequest::Ms2 { to: SLAVE, service });
    let MasterOutcome::Repeated(answers) = rig.request(MasterRequest::Repeated { request, times: 2 }) else {
        panic!("not repeated")
    };
    assert_eq!(answers.outcome, MasterOutcome::Ms2(Ms2Outcome::Record(accepted(&[1, 2, 3]))));
    assert!(answers.answered >= 4 && answers.difference.is_none(), "{answers:?}");
}

#[test]
fn identification_is_read_by_call() {
    let mut rig = Class2::new();
    rig.open();
    let outcome = rig.ask(Ms2Service::Call { slot: 0, index: FunctionIndex::IM0 });
    let MasterOutcome::Ms2(Ms2Outcome::Record(DpRecordOutcome::Accepted { data })) = outcome else {
        panic!("{outcome:?}")
    };
    let record = DpIm0::parse(&data).expect("the record of the toy slave");
    assert_eq!((record.im0.vendor_id, &record.im0.serial_number), (1, b"0000000000000042"));
    // The toy slave has no I&M1.
    let outcome = rig.ask(Ms2Service::Call { slot: 0, index: FunctionIndex::IM1 });
    assert!(matches!(outcome, MasterOutcome::Ms2(Ms2Outcome::Record(DpRecordOutcome::Refused(_)))), "{outcome:?}");
}

/// Cases for the A3M60, which serves records to its class 1 master only and has no identification data.
const CASES: &str = r#"
suite: class-2
defaults: { start: { module: IO_04 } }
cases:
  - id: refused
    why: There is no resource manager, and no record behind index 255.
    covers: [A3M60-CFG-001]
    steps:
      - send: { ms2_initiate: { send_timeout: 500ms, profile: 0x3D00 } }
        answer: { refused: no_service }
      - send: { im_read: { slot: 0, record: 0 } }
        answer: { refused: invalid_index }
        repeats: 1
  - id: accepted
    why: A connection is opened.
    covers: [A3M60-CFG-001]
    steps:
      - send: { ms2_initiate: {} }
  - id: not-opened
    why: A record is read over a connection that does not stand.
    covers: [A3M60-CFG-001]
    steps:
      - send: { ms2_read: { slot: 0, index: 47, length: 240 } }
"#;

#[test]
fn a_suite_uses_the_services_of_a_class_2_master() {
    let folder = testing::Folder::new("class-2");
    let entries = |path| std::fs::read_dir(path).expect("a folder").map(|entry| entry.expect("an entry").path());
    for manual in entries(testing::workspace().join("suites")).filter(|path| path.is_dir()) {
        let copy = folder.join("suites").join(manual.file_name().expect("a name"));
        std::fs::create_dir_all(&copy).expect("a folder");
        for file in entries(manual) {
            std::fs::copy(&file, copy.join(file.file_name().expect("a name"))).expect("a copy");
        }
    }
    std::fs::write(folder.join("suites/sick-a3m60-profibus/class-2.yaml"), CASES).expect("a topic");
    let arguments =
        ["run", "--suites", "suites", "--no-evidence", "--dut", "model:sick-a3m60-profibus/a3m60", "class-2/"];
    let said = encspec(&folder, &arguments).all();
    assert!(said.contains("1 pass, 1 fail, 1 inconclusive"), "{said}");
    assert!(said.contains("observed refused: FDL answer 0x03 (no_service)"), "{said}");
    assert!(said.contains("no MS2 connection stands with this slave"), "{said}");
}
