//! Cycles: one message for each, none while the program says that nothing can change, and outputs in their order before anything else.

use application_protocol::{ApplicationBus, ApplicationProgram, ProgramCommand, RemoteIoApplication, in_program};
use device_stack::profinet::{ArKey, IoApplication, StationData};
use station::{StandAction, Time};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// A program that appends each message to `messages`, and answers a cycle with inputs that are constant until 1 ms.
const PROGRAM: &str = r#"
while read -r line; do
    word=${line#*\"message\":\"}
    word=${word%%\"*}
    [ "$word" = hello ] || echo "$line" >> messages
    case $word in
    hello) echo '{"answer":"hello","description":{"version":1,"name":"test","profinet":{"vendor_id":1,"device_id":2,"station_type":"T","order_id":"O","serial_number":"1","station":true,"submodules":[{"slot":0,"module_ident":1,"subslot":1,"submodule_ident":1},{"slot":1,"module_ident":2,"subslot":1,"submodule_ident":3,"inputs":2,"outputs":1}]}}}';;
    cycle) echo '{"answer":"cycle","inputs":[{"slot":1,"subslot":1,"data":"0102"}],"constant_until":1000000,"deadline":5000000}';;
    advance) echo '{"answer":"advance","deadline":5000000}';;
    act) echo '{"answer":"act","done":7}';;
    *) echo "{\"answer\":\"$word\"}";;
    esac
done
"#;

/// A device of the program in a folder of its own, which is removed at the end.
struct Device {
    folder: std::path::PathBuf,
    application: RemoteIoApplication,
    program: application_protocol::SharedProgram,
}

impl Device {
    fn new(name: &str) -> Device {
        let folder = std::env::temp_dir().join(format!("encspec-cycles-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let words = ["sh", "-c", PROGRAM].map(str::to_owned).to_vec();
        let command = ProgramCommand::new(words, Path::new(&folder));
        let program = ApplicationProgram::start(command, ApplicationBus::Profinet, Duration::from_secs(5));
        let program = Arc::new(Mutex::new(program.expect("it starts")));
        let station = StationData { name: b"dut".to_vec(), ..StationData::default() };
        let application = RemoteIoApplication::new(Arc::clone(&program), 7, station, [2, 0, 0, 0, 1, 0]);
        Device { folder, application: application.expect("a device on PROFINET"), program }
    }

    /// The inputs at a time, or `None` if they are bad.
    fn inputs(&mut self, micros: u64) -> Option<[u8; 2]> {
        let mut data = [0xFF; 2];
        self.application.frame(at(micros));
        self.application.inputs(at(micros), 1, 1, &mut data).then_some(data)
    }

    /// The words of the messages since the last call.
    fn messages(&self) -> Vec<String> {
        let file = self.folder.join("messages");
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        let _ = std::fs::remove_file(&file);
        text.lines().map(str::to_owned).collect()
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn at(micros: u64) -> Time {
    Time::from_nanos(micros * 1_000)
}

#[test]
fn constant_inputs_are_not_asked_for() {
    let mut device = Device::new("constant");
    device.messages();
    device.application.outputs(at(10), 1, 1, Some(&[5]));
    assert_eq!(device.inputs(20), Some([1, 2]));
    let cycle =
        r#"{"message":"cycle","now":20000,"outputs":[{"at":10000,"slot":1,"subslot":1,"data":"05"}],"inputs":true}"#;
    assert_eq!(device.messages(), [cycle]);
    for micros in [30, 500, 999] {
        device.application.outputs(at(micros), 1, 1, Some(&[5]));
        assert_eq!(device.inputs(micros), Some([1, 2]));
    }
    assert_eq!(device.messages(), [""; 0], "nothing can change");
    device.application.outputs(at(999), 1, 1, Some(&[6]));
    assert_eq!(device.inputs(999), Some([1, 2]));
    assert_eq!(device.messages().len(), 1, "the outputs have changed");
    assert_eq!(device.inputs(1_000), Some([1, 2]));
    assert_eq!(device.messages(), [r#"{"message":"cycle","now":1000000,"inputs":true}"#], "the time has come");
}

#[test]
fn any_other_message_ends_it_and_comes_after_the_outputs() {
    let mut device = Device::new("order");
    assert_eq!(device.inputs(1), Some([1, 2]));
    device.messages();
    device.application.outputs(at(2), 1, 1, Some(&[5]));
    device.application.outputs(at(3), 1, 1, None);
    assert_eq!(device.application.act(at(4), &StandAction::ShaftCounts(3)), Some(at(4)));
    let outputs =
        [r#"{"at":2000,"slot":1,"subslot":1,"data":"05"}"#, r#"{"at":3000,"slot":1,"subslot":1,"data":null}"#];
    let cycle = format!(r#"{{"message":"cycle","now":4000,"outputs":[{}],"inputs":false}}"#, outputs.join(","));
    let act = r#"{"message":"act","now":4000,"name":"shaft.counts","value":3}"#.to_owned();
    assert_eq!(device.messages(), [cycle, act]);
    assert_eq!(device.inputs(5), Some([1, 2]));
    assert_eq!(device.messages().len(), 1);
}

#[test]
fn program_learns_the_station_if_it_asks_for_it() {
    let mut device = Device::new("station");
    let station = |now: u64, name: &str, ip: &str| {
        let rest = r#""mask":"0.0.0.0","gateway":"0.0.0.0","mac":"020000000100""#;
        format!(r#"{{"message":"station","now":{now},"name":"{name}","ip":"{ip}",{rest}}}"#)
    };
    assert_eq!(device.messages(), [r#"{"message":"reset","shaft":7}"#.to_owned(), station(0, "dut", "0.0.0.0")]);
    let stored = StationData { name: b"other".to_vec(), ..StationData::default() };
    let current = StationData { ip: [192, 168, 0, 10], ..stored.clone() };
    device.application.set_station(at(1), &current, &stored);
    device.application.power_down(at(2));
    device.application.power_up(at(3));
    let messages = device.messages();
    assert_eq!(messages[0], station(1_000, "other", "192.168.0.10"));
    assert_eq!(messages.last(), Some(&station(3_000, "other", "0.0.0.0")), "a temporary address is lost");
}

#[test]
fn answers_that_do_not_fit_are_failures() {
    let failure = |device: &Device| in_program(&device.program).failure().map(ToString::to_string).unwrap_or_default();
    let mut device = Device::new("fit");
    device.application.frame(at(1));
    assert!(!device.application.inputs(at(1), 2, 1, &mut [0; 2]));
    assert!(failure(&device).ends_with("it has no inputs of slot 2 subslot 1"), "{}", failure(&device));
    let mut device = Device::new("deadline");
    assert_eq!(device.inputs(1), Some([1, 2]));
    device.application.advance(at(5_000));
    assert!(failure(&device).ends_with("`deadline` is 5000000, which is not after `now`"), "{}", failure(&device));
    assert_eq!(device.application.deadline(), None, "a failed program has nothing to do");
    device.application.ended(at(6_000), ArKey(0));
    assert_eq!(device.inputs(6_001), None);
}
