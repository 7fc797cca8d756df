//! What the loader refuses in `device.yaml` and in the lists of requirements and bugs.

mod small_manual;

use encspec::suite::load;
use rstest::rstest;
use small_manual::{DEVICE, TOPIC, refuses, sources};

#[rstest]
// records of the start-up that some modules have
#[case(
    "probe/device.yaml",
    "start: true, fields",
    "start: true, with: [lnog], fields",
    "lnog",
    "unknown module `lnog`"
)]
#[case(
    "probe/device.yaml",
    "start: true, fields",
    "with: [long], fields",
    "[long]",
    "only a record of the start-up goes `with` modules"
)]
#[case(
    "probe/topic.yaml",
    "module: short, scaling",
    "module: short, level: 1, scaling",
    "level: 1",
    "the record `only_long` is not sent with the module `short`"
)]
// device.yaml
#[case("probe/device.yaml", "device: probe", "device: prob", "prob", "this is the folder `probe`")]
#[case("probe/device.yaml", "bus: profinet", "bus: profibsu", "profibsu", "unknown word for bus `profibsu`")]
#[case("probe/device.yaml", "octets: { out: 2, in: 8 }", "octets: { out: 2, in: 6 }", "{", "the inputs have 8 octets")]
#[case("probe/device.yaml", "inputs: [ZSW, POS, SPD]", "inputs: [ZSW, POZ, SPD]", "POZ", "unknown signal `POZ`")]
#[case("probe/device.yaml", "outputs: [STW]", "outputs: [ZSW]", "ZSW", "`ZSW` goes the other way")]
#[case("probe/device.yaml", "submodules: [pap, long]", "submodules: [pap, lng]", "lng", "unknown submodule `lng`")]
#[case("probe/device.yaml", "park: 14", "park: 16", "16", "bit 16 is beyond the 16 bits")]
#[case("probe/device.yaml", "{ octets: [1, 4]", "{ octets: [1, 5]", "{", "octet 5 is beyond the 5 octets")]
#[case("probe/device.yaml", "default: =steps", "default: =setps", "setps", "there is no name `setps`")]
#[case("probe/device.yaml", "default: disabled", "default: disable", "disable", "`disable` is no word of `switch`")]
#[case(
    "probe/device.yaml",
    "{ one: 4096, two: 8192 }",
    "{ one: 4096 }",
    "{",
    "there is no value for the variant `two`"
)]
#[case("probe/device.yaml", "signed: true", "signed: yes", "yes", "`signed` is `true` or left out")]
#[case("probe/device.yaml", "then range else", "then rnage else", "rnage else steps", "there is no name `rnage`")]
#[case("probe/device.yaml", "position_in: circle", "position_in: cirle", "cirle", "there is no name `cirle`")]
#[case(
    "probe/device.yaml",
    "from_source: invented",
    "from_source: invnted",
    "invnted",
    "unknown word for from_source `invnted`"
)]
#[case("probe/device.yaml", "position: [POS]", "position: [PSO]", "PSO", "unknown signal `PSO`")]
#[case("probe/device.yaml", "type: u16", "type: u17", "u17", "unknown word for type `u17`")]
#[case(
    "probe/device.yaml",
    "codes: {",
    "parameter_access: { indx: 5 }\ncodes: {",
    "indx",
    "unknown key of parameter_access `indx`"
)]
#[case(
    "probe/device.yaml",
    "codes: {",
    "parameter_access: { index: 65536 }\ncodes: {",
    "65536",
    "65536 is out of range"
)]
#[case("probe/device.yaml", "codes: {", "parameter_access: { at: papp }\ncodes: {", "papp", "unknown submodule `papp`")]
#[case("probe/device.yaml", "codes: {", "parameter_access: { do_id: 0 }\ncodes: {", "0", "0 is no drive object")]
#[case(
    "probe/device.yaml",
    "codes: {",
    "parameter_access: { save: P970 }\ncodes: {",
    "P970",
    "unknown parameter `P970`"
)]
#[case(
    "probe/device.yaml",
    "codes: {",
    "parameter_access: { save: P922 }\ncodes: {",
    "P922",
    "`P922` can only be read"
)]
#[case("probe/device.yaml", "constants: { steps", "constants: { POS", "POS: {", "`POS` is a name already")]
#[case("probe/device.yaml", "range: { octets", "shaft: { octets", "shaft: {", "`shaft` is a name already")]
// the lists
#[case("probe/requirements.yaml", "level: should", "level: shuold", "shuold", "unknown variant `shuold`")]
#[case(
    "probe/requirements.yaml",
    "source: manual,",
    "source: profile,",
    "PRB-1",
    "only what the manual says without ambiguity is `must`"
)]
#[case("probe/requirements.yaml", "id: PRB-2", "id: PRB-1", "PRB-1", "duplicate id `PRB-1`")]
#[case("probe/bugs.yaml", "breaks: [PRB-1]", "breaks: [PRB-9]", "PRB-9", "unknown requirement `PRB-9`")]
#[case(
    "probe/bugs.yaml",
    "  stuck:",
    "  lazy: { why: It is., breaks: [PRB-1] }\n  stuck:",
    "lazy:",
    "no case catches the bug `lazy`"
)]
fn refused(#[case] path: &str, #[case] old: &str, #[case] new: &str, #[case] points_at: &str, #[case] message: &str) {
    refuses(path, old, new, points_at, message);
}

/// A record may be part of the start-up of some modules only, two may go to one submodule, and one index may be written with
/// one layout and read with another.
#[test]
fn records_of_the_start_up() {
    let topic = TOPIC.replacen("connect: { module: short, scaling", "connect: { module: long, level: 3, scaling", 1);
    let topic =
        topic.replacen("- read: { page.level: 3 }", "- read: { longer.scaling_in_use: enabled, longer.state: 1 }", 1);
    let manuals = load(&sources().with("probe/topic.yaml", topic), None).unwrap_or_else(|errors| panic!("{errors}"));
    let device = &manuals[0].device;
    let fields = |start: &encspec::suite::model::Start| -> Vec<(String, i128)> {
        let field =
            |of: &encspec::suite::model::StartParameter| device.records[of.record].fields[of.field].name.clone();
        start.parameters.iter().map(|of| (field(of), of.value)).collect()
    };
    let trials = &manuals[0].variants[0].trials;
    let first = trials.iter().find(|trial| trial.id == "topic/first[on]").and_then(|trial| trial.start());
    let wanted = [("scaling".to_owned(), 0), ("range".to_owned(), 4096), ("level".to_owned(), 7)];
    assert_eq!(fields(first.expect("it connects")), wanted);
    let short = load(&sources(), None).expect("it loads");
    let second = short[0].variants[0].trials.iter().find(|trial| trial.id == "topic/second").expect("it is there");
    let Some(encspec::suite::model::Verb::Connect { start, .. }) = second.how().steps.first().map(|step| &step.verb)
    else {
        panic!("it connects first")
    };
    assert_eq!(
        fields(start),
        wanted[..2].iter().map(|(name, value)| (name.clone(), if *value == 0 { 1 } else { 100 })).collect::<Vec<_>>()
    );
}

/// Parameters are reached as the drive profile has it, and each part of that can be said otherwise.
#[rstest]
#[case("", (0xB02E, None, 1, 971))]
#[case("parameter_access: { at: pap }", (0xB02E, Some("pap"), 1, 971))]
#[case("parameter_access: { index: 47, do_id: 255 }", (47, None, 255, 971))]
#[case("parameter_access: { save: P972 }", (0xB02E, None, 1, 972))]
fn the_parameter_access(#[case] says: &str, #[case] wanted: (u16, Option<&str>, u8, u16)) {
    let device =
        DEVICE.replacen("codes: {", &format!("  P972: {{ type: u16, access: read_write }}\n{says}\ncodes: {{"), 1);
    let manuals = load(&sources().with("probe/device.yaml", device), None).unwrap_or_else(|errors| panic!("{errors}"));
    let device = &manuals[0].device;
    let access = device.parameter_access;
    let at = device.profinet().and_then(|facts| facts.parameter_point).map(|at| device.submodules[at].name.as_str());
    assert_eq!((access.index, at, access.do_id, access.save), wanted);
}
