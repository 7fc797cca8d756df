//! What the loader takes and refuses in suites of slaves on PROFIBUS.

mod small_slave;

use encspec::suite::model::{Answer, AnswerPart, InsteadStart, Verb};
use encspec::suite::{LoadErrors, Sources, load};
use rstest::rstest;
use small_slave::FILES;
use std::time::Duration;

fn sources() -> Sources {
    FILES.iter().fold(Sources::none(), |sources, (path, text)| sources.with(path, *text))
}

#[test]
fn the_small_slave_loads() {
    let manuals = load(&sources(), None).unwrap_or_else(|errors| panic!("{errors}"));
    let device = &manuals[0].device;
    let slave = device.profibus().expect("it is on PROFIBUS");
    assert_eq!((slave.address, slave.set_prm.dpv1, slave.ident), (5, Some([0x80, 0, 0]), 0x0C0A));
    assert_eq!(device.modules[1].cfg(), [0xD3, 0xE1]);
    assert_eq!((device.parameter_access.index, slave.parameter_slot), (47, 1));
    let unused: Vec<&str> = manuals[0].unused.iter().map(|(name, _)| name.as_str()).collect();
    let left = [
        "word `kind.single`",
        "code `diagnosis_error.amplitude`",
        "field `preset.value`",
        "signal `speed`",
        "switch `address`",
        "role `position`",
    ];
    assert_eq!(unused, left);
}

#[test]
fn what_goes_with_a_module_is_sent_unless_the_case_says_otherwise() {
    let manuals = load(&sources(), None).expect("it loads");
    let trials = &manuals[0].variants[0].trials;
    let first = trials[0].start().expect("a connection");
    assert_eq!(first.parameters.iter().map(|of| of.value).collect::<Vec<_>>(), [0, 0, 100]);
    assert_eq!(first.watchdog(&manuals[0].device), Duration::from_millis(100));
    let cycles = trials.iter().find(|trial| trial.id == "topic/cycles").expect("it is there");
    let start = cycles.start().expect("a connection");
    assert_eq!(start.cycle(&manuals[0].device), Duration::from_millis(1));
    assert_eq!(start.watchdog(&manuals[0].device), Duration::from_secs(1));
    let refused = trials.iter().find(|trial| trial.id == "topic/configuration[bytes]").expect("it is there");
    let Verb::Connect { start, answer: Some(Answer::Parts(parts)), .. } = &refused.how().steps[0].verb else {
        panic!("it connects and says which answer is right");
    };
    assert_eq!(start.instead, [InsteadStart::ChkCfg(vec![0xF0])]);
    assert_eq!(parts[0].0, AnswerPart::SetPrm);
    let Verb::Connect { start, .. } = &refused.how().steps[1].verb else { panic!("it connects") };
    assert_eq!(start.parameters.iter().map(|of| of.value).collect::<Vec<_>>(), [1, 1, 4096]);
}

#[test]
fn a_diagnosis_is_taken_apart_as_device_yaml_says() {
    let manuals = load(&sources(), None).expect("it loads");
    let slave = manuals[0].device.profibus().expect("it is on PROFIBUS");
    let blocks = slave.diagnosis.blocks.as_ref().expect("it has blocks");
    assert_eq!(blocks.codes(&[0, 12, 0, 2, 12, 10]), Some(vec![]));
    assert_eq!(blocks.codes(&[8, 12, 0, 2, 12, 10, 0x81, 0x40, 0x38, 0x81, 0x40, 0x36]), Some(vec![0x38, 0x36]));
    assert_eq!(blocks.codes(&[8, 12, 0, 2, 12, 10, 0x81, 0x40]), None, "cut off");
    assert_eq!(blocks.codes(&[8, 12, 0, 2, 12, 10, 0x81, 0x41, 0x38]), None, "another channel");
    let offset = &slave.diagnosis.fields[1];
    let mut octets = [0; 14];
    octets[10..].copy_from_slice(&(-2_i32).to_be_bytes());
    assert_eq!((offset.number_in(&octets), offset.number_in(&octets[..13])), (Some(-2), None));
}

fn changed(path: &str, old: &str, new: &str) -> Result<(), LoadErrors> {
    let text = FILES.iter().find(|(known, _)| *known == path).map_or("", |(_, text)| text);
    assert!(text.contains(old), "{path} has {old:?}");
    load(&sources().with(path, text.replacen(old, new, 1)), None).map(|_| ())
}

#[rstest]
// device.yaml
#[case("slave/device.yaml", "address: 5\n", "", "device: slave", "needs the key `address`")]
#[case("slave/device.yaml", "address: 5\n", "address: 127\n", "127", "127 is no station address")]
#[case("slave/device.yaml", "cfg: \"D1 E1\"", "cfg: \"D3 E1\"", "\"D3", "4 octets of outputs and 8 of inputs")]
#[case("slave/device.yaml", "cfg: \"D1 E1\"", "cfg: \"D1 E1 C1\"", "\"D1", "these are no identifiers")]
#[case("slave/device.yaml", "cfg: \"D1 E1\"", "cfg: D1", "D1", "octets stand in quotes")]
#[case(
    "slave/device.yaml",
    "cfg: \"D1 E1\"",
    "ident: 4, cfg: \"D1 E1\"",
    "ident",
    "unknown key of a module on PROFIBUS"
)]
#[case(
    "slave/device.yaml",
    "inputs: [place, speed]",
    "inputs: [place]",
    "{ out: 4, in: 8 }",
    "the inputs have 4 octets"
)]
#[case("slave/device.yaml", "fixes: { with_speed", "fixes: { with_sped", "with_sped", "unknown start parameter")]
#[case(
    "slave/device.yaml",
    "range: { octets: [1, 4]",
    "range: { octets: [1, 5]",
    "{",
    "octet 5 is beyond the 5 octets"
)]
#[case("slave/device.yaml", "dpv1: \"80 00 00\"", "dpv1: \"80 00\"", "\"80 00\"", "DP-V1 has three octets")]
#[case("slave/device.yaml", "  dpv1: \"80 00 00\"\n", "", "structured", "behind the octets of DP-V1")]
#[case("slave/device.yaml", "octets: [6, 24]", "octets: [6, 16, 24]", "[6", "with `blocks` there are two lengths")]
#[case("slave/device.yaml", "octets: [6, 24]", "octets: [24, 6]", "[24", "the lengths of a diagnosis go up")]
#[case("slave/device.yaml", "kind_of: { byte: 9", "ident: { byte: 9", "{", "every slave has `diag.ident`")]
#[case("slave/device.yaml", "serial: { bytes: [14, 23]", "serial: { bytes: [14, 24]", "{", "byte 24 is beyond")]
#[case("slave/device.yaml", "[14, 23] }", "[14, 23], signed: true }", "{", "more than eight bytes are no number")]
#[case("slave/device.yaml", "\"81 40 ..\"", "\"81 .. ..\"", "\"81", "one `..`, where the code stands")]
#[case(
    "slave/device.yaml",
    "code: diagnosis_error",
    "code: diagnosis_eror",
    "diagnosis_eror",
    "unknown table of codes"
)]
#[case("slave/device.yaml", "{ slot: 1 }", "{ at: pap }", "at", "unknown key of parameter_access on PROFIBUS `at`")]
#[case(
    "slave/device.yaml",
    "signals:",
    "records: {}\nsignals:",
    "records",
    "unknown key of device.yaml of a device on PROFIBUS"
)]
// names
#[case(
    "slave/topic.yaml",
    "diag.kind_of: multi",
    "diag.kind_off: multi",
    "diag.kind_off",
    "unknown part `kind_off` of the diagnosis"
)]
#[case("slave/topic.yaml", "diag.kind_of: multi", "diag.kind_of: mutli", "mutli", "`mutli` is no word of `kind`")]
#[case(
    "slave/topic.yaml",
    "diag.errors: [memory], diag",
    "diag.errors: [memroy], diag",
    "memroy",
    "`memroy` is no word"
)]
#[case("slave/topic.yaml", "read: { cfg.bytes", "read: { cfg.octets", "cfg.octets", "unknown name `cfg.octets`")]
#[case(
    "slave/topic.yaml",
    "- expect: { diag.errors",
    "- expect: { cfg.bytes: any, diag.errors",
    "cfg.bytes",
    "`cfg.bytes` has no `expect`"
)]
#[case(
    "slave/topic.yaml",
    "read: { station.address: =bench.station }",
    "read: { station.name: any }",
    "station.name",
    "`station.name` exists on PROFINET only"
)]
#[case("slave/topic.yaml", "led.bus: red }", "alarm: 1 }", "alarm", "`alarm` exists on PROFINET only")]
#[case("slave/topic.yaml", "=bench.station", "=bench.ip", "bench.ip", "`bench.ip` exists on PROFINET only")]
#[case(
    "slave/topic.yaml",
    "io.cyclic: running",
    "io.output_status: good",
    "io.output_status",
    "`io.output_status` exists on PROFINET only"
)]
#[case(
    "slave/topic.yaml",
    "read: { cfg.bytes: \"D1 E1\" }",
    "read: { cfg.bytes: \"D1 E1\", diag.length: 6 }",
    "diag.length",
    "one `read` asks one service"
)]
// connections and their answers
#[case("slave/topic.yaml", "watchdog: 100ms", "watchdog: 105ms", "105ms", "no two factors")]
#[case("slave/topic.yaml", "isochronous: 1ms", "isochronous: 1010us", "1010us", "in steps of 125us")]
#[case("slave/topic.yaml", "baud: 500000", "baud: 500001", "500001", "no bus runs at this rate")]
#[case("slave/topic.yaml", "lock: both", "lock: botch", "botch", "unknown lock `botch`")]
#[case("slave/topic.yaml", "freeze_req: 1", "freeze_req: 0", "0", "`freeze_req` is 1 or left out")]
#[case("slave/topic.yaml", "freeze_req: 1", "freze_req: 1", "freze_req", "unknown key of instead `freze_req`")]
#[case("slave/topic.yaml", "freeze_req: 1", "module_ident: 1", "module_ident", "unknown key of instead `module_ident`")]
#[case("slave/topic.yaml", "dpv1: \"00 00 00\"", "dpv1: \"00 00\"", "\"00 00\"", "DP-V1 has three octets")]
#[case(
    "slave/topic.yaml",
    "diag.cfg_fault: 1, diag.bytes",
    "diag.cfg_falt: 1, diag.bytes",
    "diag.cfg_falt",
    "unknown part `cfg_falt`"
)]
#[case("slave/topic.yaml", "chk_cfg: any", "chk_cgf: any", "chk_cgf", "unknown stage of a start-up `chk_cgf`")]
#[case("slave/topic.yaml", "refused: no_service }", "refused: no_servce }", "no_servce", "unknown code `no_servce`")]
// services
#[case(
    "slave/topic.yaml",
    "send: { fdl_status",
    "send: { dcp_signal",
    "{ dcp_signal",
    "`dcp_signal` exists on PROFINET only"
)]
#[case("slave/topic.yaml", "send: { fdl_status", "send: { fdl_stats", "fdl_stats", "unknown service `fdl_stats`")]
#[case("slave/topic.yaml", "clear: 1,", "claer: 1,", "claer", "unknown field of global_control `claer`")]
#[case("slave/topic.yaml", "clear: 1,", "clear: 2,", "2", "2 is no bit")]
#[case("slave/topic.yaml", "frame: checksum", "frame: checksun", "checksun", "unknown broken frame `checksun`")]
#[case(
    "slave/topic.yaml",
    "instead: { slot: 3 }",
    "instead: { subslot: 3 }",
    "subslot",
    "unknown key of instead `subslot`"
)]
#[case("slave/topic.yaml", "to: 126", "to: 256", "256", "256")]
fn refused(#[case] path: &str, #[case] old: &str, #[case] new: &str, #[case] points_at: &str, #[case] message: &str) {
    let errors = changed(path, old, new).expect_err("the change is a mistake");
    let first = &errors.0[0];
    let at: String = first.line.chars().skip(first.at.column as usize - 1).collect();
    let good = first.at.file.ends_with(path) && at.starts_with(points_at) && first.message.contains(message);
    assert!(good, "wanted {path}: {message}, at {points_at}\n{errors}");
}
