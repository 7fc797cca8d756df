//! Personas: each has the Connect of its capture, each reaches data exchange with every module, and none makes a conforming device
//! fail.

use crate::built_in;
use controllers::profinet_io::{ArConfig, ConnectSubmodule, ControllerSettings, DeviceAddress, connect_blocks};
use encspec::engine::{DutKind, DutSpec, RunOptions, TrialOutcome, apply_persona, run, run_trial};
use encspec::report::{self, ConsoleOptions, ExitStatus};
use encspec::result::RunResult;
use encspec::suite::model::{ConnectionStart, Manual, Requirement, RequirementClass};
use encspec::suite::persona::{ExpectedSubmodules, Persona};
use encspec::suite_yaml::persona::load_personas;
use encspec::suite_yaml::{Sources, load};
use encspec::verdict::Verdict;
use rstest::rstest;
use std::fs::File;
use std::net::Ipv4Addr;
use std::sync::Arc;
use testing::DailySample;
use virtual_wire::CaptureReader;
use virtual_wire::capture::CaptureItem;
use wire::datagram::Datagram;
use wire::octets::ByteOrder;
use wire::profinet::blocks::connect::{Connect, ConnectContent, ExpectedSubmoduleBlockReq, IocrBlockReq};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::rpc::{NdrRequest, Opnum, PacketType, RpcPdu, Uuid};

fn personas() -> Vec<Persona> {
    load_personas(&suites::sources()).unwrap_or_else(|errors| panic!("the shipped personas load:\n{errors}"))
}

fn persona(name: &str) -> Arc<Persona> {
    let found = personas().into_iter().find(|persona| persona.name == name);
    Arc::new(found.unwrap_or_else(|| panic!("there is a persona {name}")))
}

/// The manuals of PROFINET devices: a persona is a PROFINET controller.
fn manuals() -> impl Iterator<Item = &'static Manual> {
    built_in::manuals().iter().filter(|manual| manual.device.profinet().is_some())
}

fn conforming(manual: &Manual, variant: &str) -> DutSpec {
    let kind = DutKind::Model { deviations: Vec::new() };
    DutSpec { manual: manual.device.name.clone(), variant: variant.to_owned(), kind }
}

fn options(duts: Vec<DutSpec>, persona: Arc<Persona>) -> RunOptions {
    RunOptions { duts, persona: Some(persona), ..RunOptions::default() }
}

/// The Connect in a packet of a capture, counted from 1: RPC byte order, NDR header, blocks. None if there is no such capture.
fn captured(file: &str, number: usize) -> Option<(ByteOrder, NdrRequest, Vec<u8>)> {
    let file = File::open(testing::shared(file)?).expect("the capture can be read");
    let mut reader = CaptureReader::new(file).expect("a capture");
    let mut at = 0;
    while let Some(item) = reader.next() {
        let CaptureItem::Packet(packet) = item else { continue };
        at += 1;
        if at < number {
            continue;
        }
        let datagram = Datagram::parse(packet.captured).expect("a datagram");
        let pdu = RpcPdu::parse(datagram.payload).expect("a PDU");
        assert_eq!(
            (pdu.header.packet_type, pdu.header.opnum),
            (PacketType::REQUEST, Opnum::CONNECT),
            "packet {number}"
        );
        let (ndr, blocks) = NdrRequest::parse(pdu.header.order(), pdu.body).expect("the head of the blocks");
        return Some((pdu.header.order(), ndr, blocks.to_vec()));
    }
    panic!("the capture has no packet {number}");
}

/// The submodules that a Connect expects.
fn expected(connect: &Connect) -> Vec<ConnectSubmodule> {
    let mut submodules = Vec::new();
    for block in &connect.blocks {
        let ConnectContent::ExpectedSubmodule(ExpectedSubmoduleBlockReq { modules }) = &block.content else { continue };
        for module in modules {
            for of in &module.submodules {
                let length = |output: bool| {
                    let mut described = of.data_descriptions.iter().filter(|one| one.is_output() == output);
                    described.next().map_or(0, |one| one.submodule_data_length)
                };
                submodules.push(ConnectSubmodule {
                    api: module.api,
                    slot: module.slot_number,
                    module_ident: module.module_ident_number,
                    subslot: of.subslot_number,
                    submodule_ident: of.submodule_ident_number,
                    input_octets: length(false),
                    output_octets: length(true),
                });
            }
        }
    }
    submodules
}

/// The parts of a block that a persona decides, without the identity of the connection and the layout of the data.
fn decided_by_persona(content: &ConnectContent) -> ConnectContent {
    match content.clone() {
        ConnectContent::ArReq(mut ar) => {
            (ar.ar_uuid, ar.session_key) = (Uuid::NIL, 0);
            (ar.cm_initiator_mac_add, ar.cm_initiator_object_uuid) = Default::default();
            ConnectContent::ArReq(ar)
        }
        ConnectContent::IocrReq(iocr) => {
            ConnectContent::IocrReq(IocrBlockReq { data_length: 0, apis: Vec::new(), ..iocr })
        }
        ConnectContent::ExpectedSubmodule(_) => ConnectContent::ExpectedSubmodule(ExpectedSubmoduleBlockReq::default()),
        other => other,
    }
}

#[test]
fn each_persona_has_the_connect_of_its_capture() {
    let personas = personas();
    assert!(personas.len() >= 8);
    for persona in personas {
        if persona.source == "invented" {
            continue;
        }
        let (file, frame) = persona.source.split_once(" frame ").expect("a capture and its frame");
        let Some((order, ndr, theirs)) = captured(file, frame.parse().expect("a number")) else { return };
        let theirs = Connect::parse(&theirs).expect("blocks");
        let ip = IpParameter { address: Ipv4Addr::LOCALHOST, mask: Ipv4Addr::BROADCAST, gateway: Ipv4Addr::LOCALHOST };
        let mut connection = ArConfig::new(DeviceAddress::Name("device".into()), ip);
        connection.submodules = expected(&theirs);
        let start = ConnectionStart {
            module: 0,
            cycle: None,
            watchdog: None,
            unwatched: false,
            baud: None,
            isochronous: None,
            parameters: Vec::new(),
            instead: Vec::new(),
        };
        apply_persona(&persona, &start, &mut connection);
        let settings = ControllerSettings {
            mac: wire::ethernet::Mac::ZERO,
            ip: Ipv4Addr::LOCALHOST,
            mask: Ipv4Addr::BROADCAST,
            gateway: Ipv4Addr::LOCALHOST,
            station_name: b"controller".to_vec(),
            vendor_id: 0,
            device_id: 0,
            seed: 0,
        };
        let ours = Connect::parse(&connect_blocks(&connection, &settings, Uuid::NIL)).expect("blocks");
        let of = |connect: &Connect| {
            connect.blocks.iter().map(|block| decided_by_persona(&block.content)).collect::<Vec<_>>()
        };
        assert_eq!(of(&ours), of(&theirs), "{}", persona.name);
        assert_eq!(connection.check(), Ok(()), "{}", persona.name);
        assert_eq!(persona.little_endian == Some(true), order == ByteOrder::Little, "{}", persona.name);
        assert_eq!(persona.args_max, Some(ndr.args_maximum), "{}", persona.name);
        let has = |slot: u16, network: bool| {
            expected(&theirs).iter().any(|one| one.slot == slot && (one.subslot >= 0x8000) == network)
        };
        let expects = match (has(0, true), has(0, false)) {
            (true, _) => ExpectedSubmodules::InterfaceAndPorts,
            (false, true) => ExpectedSubmodules::AccessPoint,
            (false, false) => ExpectedSubmodules::Module,
        };
        assert_eq!(persona.expects, expects, "{}", persona.name);
    }
}

/// A suite with a case for each module of a manual: data are exchanged with IOPS and IOCS good.
fn reach(manual: &Manual) -> String {
    let of_all =
        |of: &&Requirement| of.class == RequirementClass::Testable && of.variants.len() == manual.device.variants.len();
    let covered = &manual.requirements.iter().find(of_all).expect("a requirement of every variant").id;
    let mut text = "suite: reach\ncases:\n".to_owned();
    for module in &manual.device.modules {
        let (name, id) = (&module.name, module.name.replace('_', "-"));
        text += &format!(
            "  - id: {id}
    why: Data are exchanged.
    covers: [{covered}]
    start: {{ module: {name} }}
    steps:
      - expect: {{ connection: data, io.input_status: good, io.consumer_status: good }}
        within: 5s
        for: 2s
"
        );
    }
    text
}

#[test]
fn each_persona_reaches_data_exchange_with_each_module_of_each_device() {
    let personas: Vec<Arc<Persona>> = personas().into_iter().map(Arc::new).collect();
    let mut reached = 0;
    for plain in manuals() {
        let name = &plain.device.name;
        let sources = suites::sources().with(&format!("{name}/reach.yaml"), reach(plain));
        let manual = load(&sources, Some(name)).unwrap_or_else(|errors| panic!("{errors}")).remove(0);
        for variant in &manual.variants {
            let duts = vec![conforming(&manual, &variant.name)];
            for persona in &personas {
                let options = RunOptions { selection: "/reach/".into(), ..options(duts.clone(), Arc::clone(persona)) };
                let result = run(std::slice::from_ref(&manual), &options, &|_, _, _| {}).expect("a model can be run");
                let cases = result.runs[0].cases.iter().filter(|case| case.id.contains("/reach/"));
                for case in cases {
                    let what = format!("{} {} {}: {:?}", persona.name, variant.name, case.id, case.reason);
                    assert_eq!(case.verdict, Verdict::Pass, "{what}");
                    reached += 1;
                }
            }
        }
    }
    let modules: usize = manuals().map(|of| of.device.modules.len() * of.variants.len()).sum();
    assert_eq!(reached, modules * personas.len());
}

fn whole(persona: &Arc<Persona>) -> RunResult {
    let duts = manuals().flat_map(|of| of.variants.iter().map(|variant| conforming(of, &variant.name))).collect();
    run(built_in::manuals(), &options(duts, Arc::clone(persona)), &|_, _, _| {}).expect("models can be run")
}

#[test]
fn no_persona_makes_a_conforming_device_fail() {
    for persona in DailySample::one_of(3).items(personas()).into_iter().map(Arc::new) {
        let result = whole(&persona);
        let slow = persona.cycle.is_some_and(|cycle| cycle.time() > std::time::Duration::from_millis(2));
        let cases = || result.runs.iter().flat_map(|run| &run.cases);
        for case in cases().filter(|case| case.verdict != Verdict::Pass) {
            let what = format!("{} {}: {} {:?}", persona.name, case.id, case.verdict, case.reason);
            assert_eq!(case.verdict, Verdict::NotApplicable, "{what}");
            let why = case.reason.clone().unwrap_or_default();
            assert!(why.starts_with(&format!("persona {}: ", persona.name)), "{what}");
            assert!(slow, "only a slower cycle excludes cases: {what}");
        }
        let not_judged = cases().filter(|case| case.verdict == Verdict::NotApplicable).count();
        assert!(not_judged * 4 < cases().count() * 3, "{}: {not_judged} are not judged", persona.name);
        assert_eq!(report::status(&result), ExitStatus::Green, "{}", persona.name);
        for run in &result.runs {
            // A requirement passes only if one of its cases passed.
            let passed = |id: &String| run.cases.iter().any(|case| case.id == *id && case.verdict == Verdict::Pass);
            for of in run.requirements.iter().filter(|of| of.verdict == Verdict::Pass) {
                assert!(of.cases.iter().any(passed), "{} {}", persona.name, of.id);
            }
        }
    }
}

/// The verdict of a connection with the module `data` of a plain device with these deviations.
fn meets(deviations: &[&str], persona: Option<&str>) -> Verdict {
    connection(deviations, persona).case.verdict
}

fn connection(deviations: &[&str], persona: Option<&str>) -> TrialOutcome {
    const SUITE: &str = "\
suite: meets
cases:
  - id: data
    why: Data go both ways.
    covers: [PNIO-CON-001]
    start: none
    steps:
      - connect: { module: data }
      - set: { given: 0x01020304 }
      - expect: { connection: data, io.input_status: good, io.consumer_status: good, mirrored: 0x01020304 }
        within: 5s
        for: 2s
";
    let sources = suites::sources().with("profinet-io/meets.yaml", SUITE);
    let manuals = load(&sources, Some("profinet-io")).unwrap_or_else(|errors| panic!("{errors}"));
    let variant = &manuals[0].variants[0];
    let trial = variant.trials.iter().find(|trial| trial.id == "meets/data").expect("the case");
    let kind = DutKind::Model { deviations: deviations.iter().map(|name| (*name).to_owned()).collect() };
    let dut = DutSpec { kind, ..conforming(&manuals[0], &variant.name) };
    let options = RunOptions { persona: persona.map(self::persona), ..RunOptions::default() };
    run_trial(&manuals[0], variant, &dut, trial, &options).expect("a model can be run")
}

/// Each of these field bugs shows only with the persona, not with the default controller.
#[rstest]
#[case("advanced-start-refused", "advanced-alarm-first")]
#[case("little-endian-refused", "legacy-little-multiple")]
#[case("block-order-fixed", "single-writes-alarm-first")]
#[case("unknown-block-refused", "advanced-fast")]
#[case("phase-not-1-refused", "legacy-little-multiple")]
#[case("reduction-of-512-refused", "legacy-512ms")]
#[case("output-frame-id-not-taken", "soft-plc")]
#[case("output-frame-id-not-taken", "output-id-proposed")]
#[case("tag-needed", "untagged-rt")]
fn a_field_bug_shows_with_a_persona(#[case] bug: &str, #[case] persona: &str) {
    assert_eq!(meets(&[], Some(persona)), Verdict::Pass);
    assert_eq!(meets(&[bug], None), Verdict::Pass);
    assert_eq!(meets(&[bug], Some(persona)), Verdict::Fail);
}

/// Real controllers expect interface and ports, with the idents of the vendor's description.
#[test]
fn a_persona_expects_the_idents_of_the_description() {
    let outcome = connection(&["idents-of-interface-and-ports"], Some("advanced-fast"));
    assert_eq!(outcome.case.verdict, Verdict::Pass);
    let has = |entry: [u8; 6]| outcome.trace.iter().any(|frame| frame.octets.windows(6).any(|octets| *octets == entry));
    // An entry of the ExpectedSubmoduleBlockReq begins with subslot and ident.
    assert!(has([0x80, 0x00, 0x00, 0x53, 0x0A, 0x10]));
    assert!(!has([0x80, 0x00, 0x00, 0x00, 0x80, 0x00]));
}

/// The verdict of a start-up whose second record is a parameter request that changes P65000 to 0x77, with these bugs.
fn second_record(bugs: &[&str], persona: Option<&str>) -> Verdict {
    const RECORD: &str = "  second_record:
    index: 0xB02E
    at: parameter_access_point
    octets: 16
    start: true
    fields:
      second_address: { octets: [0, 7], default: 0x010201011001FDE8 }
      second_value: { octets: [8, 15], default: 0x0000430100000077 }
  im0: ";
    const SUITE: &str = "\
suite: several
cases:
  - id: both
    why: Each record of the start-up is taken.
    covers: [XAC77-PRE-010]
    start: { module: telegram_81 }
    steps:
      - read: { P65000: 0x77 }
";
    const MANUAL: &str = "lika-xac77-profinet";
    let folder = testing::workspace().join("suites").join(MANUAL);
    let device = std::fs::read_to_string(folder.join("device.yaml")).expect("a shipped manual");
    let device = device.replacen("  im0: ", RECORD, 1);
    let sources = suites::sources().with(&format!("{MANUAL}/device.yaml"), device);
    let sources = sources.with(&format!("{MANUAL}/several.yaml"), SUITE);
    let manuals = load(&sources, Some(MANUAL)).unwrap_or_else(|errors| panic!("{errors}"));
    let variant = &manuals[0].variants[0];
    let trial = variant.trials.iter().find(|trial| trial.id == "several/both").expect("the case");
    let kind = DutKind::Model { deviations: bugs.iter().map(|bug| (*bug).to_owned()).collect() };
    let dut = DutSpec { kind, ..conforming(&manuals[0], &variant.name) };
    let options = RunOptions { persona: persona.map(self::persona), ..RunOptions::default() };
    run_trial(&manuals[0], variant, &dut, trial, &options).expect("a model can be run").case.verdict
}

#[test]
fn a_write_multiple_of_which_only_the_first_record_is_taken_is_found() {
    const BUG: &[&str] = &["write-multiple-first-only"];
    assert_eq!(second_record(&[], Some("legacy-little-multiple")), Verdict::Pass);
    assert_eq!(second_record(BUG, None), Verdict::Pass);
    assert_eq!(second_record(BUG, Some("legacy-little-multiple")), Verdict::Fail);
}

#[test]
fn the_reports_name_the_persona_and_repeat_it() {
    let manual = manuals().next().expect("a manual of PROFINET");
    let duts = vec![conforming(manual, &manual.variants[0].name)];
    let selection = "parking/stays-parked".into();
    let options = RunOptions { selection, ..options(duts, persona("legacy-512ms")) };
    let result = run(built_in::manuals(), &options, &|_, _, _| {}).expect("a model can be run");
    assert_eq!(result.runs[0].persona.as_deref(), Some("legacy-512ms"));
    let json: serde_json::Value = serde_json::from_str(&report::json(&result)).expect("JSON");
    assert_eq!(json["runs"][0]["persona"], "legacy-512ms");
    let line = json["runs"][0]["cases"][0]["reproduce"].as_str().expect("a line").to_owned();
    assert!(line.contains(" --persona legacy-512ms "), "{line}");
    assert!(report::junit(&result).contains("<property name=\"persona\" value=\"legacy-512ms\"/>"));
    assert!(report::console(&result, ConsoleOptions::default()).contains("  persona       legacy-512ms\n"));
    let case = &result.runs[0].cases[0];
    assert_eq!(case.verdict, Verdict::NotApplicable);
    assert!(case.reason.as_deref().is_some_and(|why| why.starts_with("persona legacy-512ms: a deadline of 100ms")));
}

/// Reconnects after a link loss. Returns the ARUUIDs of all Connects in the order in which they were sent.
fn uuids_around_a_loss(persona: &str) -> Vec<Uuid> {
    const SUITE: &str = "\
suite: loss
cases:
  - id: again
    why: It connects again.
    covers: [PNIO-CON-001]
    start: { module: data }
    steps:
      - set: { link: down }
      - expect: { connection: none }
        within: 10s
      - set: { link: up }
      - connect: { module: data }
      - expect: { connection: data, io.input_status: good }
        within: 10s
";
    let sources = suites::sources().with("profinet-io/loss.yaml", SUITE);
    let manuals = load(&sources, Some("profinet-io")).unwrap_or_else(|errors| panic!("{errors}"));
    let variant = &manuals[0].variants[0];
    let trial = variant.trials.iter().find(|trial| trial.id == "loss/again").expect("the case");
    let dut = conforming(&manuals[0], &variant.name);
    let options = options(vec![dut.clone()], self::persona(persona));
    let outcome = run_trial(&manuals[0], variant, &dut, trial, &options).expect("a model can be run");
    assert_eq!(outcome.case.verdict, Verdict::Pass, "{:?}", outcome.case.reason);
    let mut uuids = Vec::new();
    for at in 0..outcome.trace.len() {
        let Some(frame) = outcome.trace.get(at) else { continue };
        let Ok(datagram) = Datagram::parse(frame.octets) else { continue };
        let Ok(pdu) = RpcPdu::parse(datagram.payload) else { continue };
        if (pdu.header.packet_type, pdu.header.opnum) != (PacketType::REQUEST, Opnum::CONNECT) {
            continue;
        }
        let (_, blocks) = NdrRequest::parse(pdu.header.order(), pdu.body).expect("the head of the blocks");
        let connect = Connect::parse(blocks).expect("blocks");
        let ar = connect.blocks.iter().find_map(|block| match &block.content {
            ConnectContent::ArReq(ar) => Some(ar.ar_uuid),
            _ => None,
        });
        uuids.extend(ar);
    }
    uuids.dedup();
    uuids
}

#[test]
fn a_reconnect_uses_the_same_ar_uuid_or_a_new_one() {
    assert_eq!(uuids_around_a_loss("untagged-rt").len(), 1);
    assert_eq!(uuids_around_a_loss("advanced-alarm-first").len(), 2);
}

#[rstest]
#[case::key("byteorder: big", ":4:1: unknown key of a persona `byteorder`", "did you mean `byte_order`?")]
#[case::word("start_up: advance", ":4:11: unknown word for start_up `advance`", "did you mean `advanced`?")]
#[case::part("blocks: { order: [input] }", ":4:19: unknown word for order `input`", "did you mean `inputs`?")]
#[case::twice("blocks: { order: [inputs, inputs] }", ":4:27: the block stands in the order already", "")]
#[case::missing("blocks: { order: [inputs] }", ":4:18: the order needs", "")]
#[case::no_place(
    "blocks: { order: [inputs, outputs, submodules, alarms], extra: ['010B0002 0100'] }",
    ":4:11: `extra` has no place in the order",
    "name it in `order`"
)]
#[case::length("blocks: { extra: ['010B0020 0100'] }", "the block has 6 bytes, its header says 36 bytes", "")]
#[case::digits("blocks: { extra: [nothing] }", "a block is written in hexadecimal bytes", "")]
#[case::reduction("cycle: { reduction: 3 }", "a reduction of 3 is no power of two", "write 1, 2, 4, 8 ... 512")]
#[case::long("cycle: { send_clock: 128, reduction: 512 }", "the cycle is longer than 512ms", "")]
#[case::phase("cycle: { reduction: 2, phase_in: 3 }", "`phase_in` is 3", "write a number from 1 to 2")]
#[case::hold("factors: { watchdog: 7000 }", "the time without frames is longer than 1.92s", "")]
#[case::hold_below("factors: { watchdog: 4, data_hold: 3 }", "`data_hold` is 3", "write a number from 4 to 7680")]
#[case::class("class: { rt: 3 }", "`rt` is 3", "write a number from 1 to 2")]
#[case::frame_id("class: { rt: 1, frame_id_in: 0x8000 }", "0x8000 is no frame id of class 1", "from 0xC000 to 0xF7FF")]
#[case::tag("tags: { alarm_low: 0xC000 }", "0xC000 has not the priority of such frames", "from 0xA000 to 0xAFFF")]
#[case::references("references: { inputs: 2 }", "have both the reference 2", "")]
#[case::alarm("rta: { max_alarm: 100 }", "`max_alarm` is 100", "write a number from 200 to 1432")]
#[case::retries("rta: { retries: 1 }", "`retries` is 1", "write a number from 3 to 15")]
#[case::activity("activity_timeout: 0", "`activity_timeout` is 0", "write a number from 1 to 1000")]
#[case::name("station_name: -x", "`-x` is no name of a station", "")]
#[case::again("reconnect: { after: 1s }", "reconnect needs the key `uuid`", "")]
fn an_error_in_a_persona_is_reported(#[case] line: &str, #[case] says: &str, #[case] help: &str) {
    let text = format!("persona: odd\nwhy: It is odd.\nsource: invented\n{line}\n");
    let errors = load_personas(&Sources::none().with("personas/odd.yaml", text)).expect_err(line).to_string();
    assert!(errors.contains(says) && errors.contains(help), "{errors}");
}

#[test]
fn a_persona_must_be_named_like_its_file() {
    let text = "persona: even\nwhy: It is even.\nsource: invented\n";
    let errors = load_personas(&Sources::none().with("personas/odd.yaml", text)).expect_err("another name").to_string();
    assert!(errors.contains("this is the file `odd.yaml`") && errors.contains("write `persona: odd`"), "{errors}");
}
