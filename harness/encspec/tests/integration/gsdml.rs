//! GSDML: reading, comparison with a manual and a device, and the idents that a start-up uses.

use crate::built_in::{self, manuals};
use crate::common::program::{self, ProgramOutput};
use crate::sample_run;
use controllers::profinet_io::{
    Controller, ControllerOutcome, ControllerRequest, ControllerSettings, IoRecordOutcome, Partner, RecordAddress,
};
use deviations::{DescriptionChange, IdentMask, Line, Setup, build};
use encspec::engine::described;
use encspec::gsdml::{self, Gsdml, GsdmlError, PluggedSubmodule, ReportedIdentity};
use encspec::report::{ExitStatus, ReportFormat, status};
use encspec::result::{CaseKind, DescriptionKind, DeviceFinding, FindingSeverity};
use encspec::suite::device::{DeviceDescription, Origin};
use encspec::suite::model::Level;
use encspec::verdict::Verdict;
use rstest::rstest;
use station::{Duration, Station, Time};
use std::fs;
use std::net::Ipv4Addr;
use std::path::Path;
use testing::Folder;
use virtual_wire::VirtualWire;
use wire::ethernet::Mac;
use wire::profinet::rpc::ObjectUuid;

const MANUAL: &str = "lika-xac77-profinet";

fn device(manual: &str) -> &'static DeviceDescription {
    &manuals().iter().find(|of| of.device.name == manual).expect("a shipped manual").device
}

/// The built-in GSDML of the single-turn device.
fn shipped() -> &'static str {
    let found = suites::gsdml().iter().find(|(path, _)| path.contains("XAC7718"));
    found.expect("a shipped GSDML").1
}

fn read(text: &str) -> Gsdml {
    gsdml::read(text).expect("a GSDML")
}

/// The built-in GSDML with `from` replaced by `to`.
fn changed(from: &str, to: &str) -> Gsdml {
    assert!(shipped().contains(from), "{from} is not in the shipped file");
    read(&shipped().replace(from, to))
}

fn shown(findings: &[DeviceFinding]) -> Vec<String> {
    findings.iter().map(encspec::report::finding).collect()
}

/// What a device reports of itself, read over the virtual wire with implicit reads. DCP is left out.
pub(crate) fn reported(manual: &str, variant: &str) -> ReportedIdentity {
    let ip = Ipv4Addr::new(192, 168, 0, 20);
    let mask = Ipv4Addr::new(255, 255, 255, 0);
    let setup = Setup {
        mac: [2, 0, 0, 0, 1, 1],
        bugs: &[],
        shaft: 0,
        station_name: "device-1",
        ip: ip.octets(),
        mask: mask.octets(),
        gateway: [0; 4],
        line: Line::default(),
    };
    let mut device = build(manual, variant, &setup).expect("a reference device");
    let mut controller = Controller::new(ControllerSettings {
        mac: Mac([2, 0, 0, 0, 2, 1]),
        ip: Ipv4Addr::new(192, 168, 0, 100),
        mask,
        gateway: Ipv4Addr::UNSPECIFIED,
        station_name: b"controller-1".to_vec(),
        vendor_id: 0xFEED,
        device_id: 1,
        seed: 1,
    });
    let mut wire = VirtualWire::new();
    // The device boots first.
    let mut now = Time::ZERO + Duration::from_secs(3);
    wire.run(&mut [&mut controller as &mut dyn Station, &mut *device], now, &mut |_| {});
    let (vendor_id, device_id) = self::device(manual).ids().expect("it is on PROFINET");
    let object = ObjectUuid { instance: 1, device_id, vendor_id };
    let partner = Partner { mac: Mac([2, 0, 0, 0, 1, 1]), ip };
    let mut record = |api: u32, index: u16| -> Vec<u8> {
        let target = RecordAddress { api, slot: 0, subslot: 1, index };
        let request = ControllerRequest::ReadImplicit { partner, object, target, length: 4096 };
        controller.request(now, request).expect("an idle controller");
        now += Duration::from_secs(5);
        wire.run(&mut [&mut controller as &mut dyn Station, &mut *device], now, &mut |_| {});
        match controller.take_outcome() {
            Some(ControllerOutcome::Record(IoRecordOutcome::Accepted { data })) => data,
            outcome => panic!("record 0x{index:04X}: {outcome:?}"),
        }
    };
    let mut says = ReportedIdentity::default();
    for api in says.take_apis(&record(0, 0xF821)).expect("a list of APIs") {
        let octets = record(api, 0xF000);
        says.take_real(api, &octets).expect("the real identification data");
    }
    says.take_im0(&record(0, 0xAFF0)).expect("I&M0");
    says
}

fn reference_devices() -> Vec<(&'static str, &'static str)> {
    let all = deviations::subjects().iter();
    let all =
        all.map(|subject| subject.manual).filter(|manual| matches!(manual.bus, deviations::ManualBus::Profinet(_)));
    all.flat_map(|manual| manual.variants.iter().map(|variant| (manual.name, *variant))).collect()
}

#[test]
fn each_reference_device_agrees_with_its_gsdml() {
    let mut devices = 0;
    for (manual, variant) in reference_devices() {
        devices += 1;
        let device = device(manual);
        let index = device.variants.iter().position(|of| of == variant).expect("a variant of the manual");
        let (_, own) = suites::gsdml_for(manual, variant).unwrap_or_else(|| panic!("{manual}/{variant} has no GSDML"));
        assert_eq!(own.remarks, [""; 0], "{manual}/{variant}");
        let mut says = reported(manual, variant);
        says.ids(own.vendor_id, identity(device).device_id);
        assert!(says.plugged.len() >= 2, "{manual}/{variant}: {says:?}");
        let findings = gsdml::compare(device, index, Some(&own), Some(&says));
        assert_eq!(shown(&findings), [""; 0], "{manual}/{variant}");
        // Idents that device.yaml invents are the same in the GSDML.
        let mut known = device.clone();
        let overlay = gsdml::overlay(&mut known, index, Some(&own), None, &[]);
        assert_eq!(overlay.missing, [""; 0], "{manual}/{variant}");
        assert!(!overlay.taken.is_empty(), "{manual}/{variant}");
        assert_eq!(idents(&known, index), idents(device, index), "{manual}/{variant}");
        assert!(invented(&known).is_empty(), "{manual}/{variant}: {:?}", invented(&known));
    }
    assert_eq!(devices, suites::gsdml().len(), "each built-in GSDML belongs to a reference device");
}

fn identity(device: &DeviceDescription) -> &suite::device::ProfinetIdentity {
    &device.profinet().expect("it is on PROFINET").identity
}

/// Every ident of a description for a variant, and the device ID.
fn idents(device: &DeviceDescription, variant: usize) -> Vec<(String, u32, Option<u32>)> {
    let submodules = device.submodules.iter().map(|of| (of.name.clone(), of.ident, of.module_ident(variant)));
    let modules = device.modules.iter().map(|of| (of.name.clone(), of.ident().expect("it is on PROFINET"), None));
    let id = ("device ID".to_owned(), identity(device).device_id.into(), None);
    let network = of_network(device).iter().map(|(subslot, ident)| (format!("subslot 0x{subslot:04X}"), *ident, None));
    submodules.chain(modules).chain([id]).chain(network).collect()
}

/// The subslots and idents of interface and ports.
fn of_network(device: &DeviceDescription) -> &[(u16, u32)] {
    &device.profinet().expect("it is on PROFINET").network
}

/// The text of a GSDML whose modules and submodules outside slot 0, interface and ports have other idents.
fn with_other_idents(text: &str, mask: IdentMask) -> String {
    let mut changed = String::new();
    for (index, part) in text.split("IdentNumber=\"0x").enumerate() {
        if index == 0 {
            changed.push_str(part);
            continue;
        }
        let element = changed.rsplit('<').next().expect("an element");
        let is_of_access_point = !changed.contains("<ModuleList>");
        let flipped = match element.split_once(' ').expect("attributes").0 {
            "InterfaceSubmoduleItem" | "PortSubmoduleItem" => mask.network,
            _ if is_of_access_point => 0,
            _ if changed.ends_with("Submodule") => mask.submodule,
            _ => mask.module,
        };
        let (ident, rest) = part.split_once('"').expect("an attribute");
        let ident = u32::from_str_radix(ident, 16).expect("hexadecimal") ^ flipped;
        changed.push_str(&format!("IdentNumber=\"0x{ident:08X}\"{rest}"));
    }
    changed
}

/// A device with other idents and the GSDML that its vendor would give with it are described alike.
#[test]
fn a_varied_description_is_that_of_its_gsdml() {
    for (manual, variant) in reference_devices() {
        let of = built_in::manual(manual);
        let index = of.device.variants.iter().position(|of| of == variant).expect("a variant of the manual");
        let (file, _) = suites::gsdml_for(manual, variant).expect("a GSDML");
        let (_, text) = suites::gsdml().iter().find(|(path, _)| path.ends_with(file)).expect("a GSDML");
        for name in ["idents-of-32-bits", "idents-of-another-list", "idents-of-interface-and-ports"] {
            let subject = deviations::subject(manual).expect("a reference device");
            if !subject.permitted().any(|known| known.name == name) {
                continue;
            }
            let changes = subject.description_changes([name].into_iter());
            let &[DescriptionChange::Idents(mask)] = &changes[..] else { panic!("{name}: {changes:?}") };
            let varied = described(of, &built_in::model(of, &of.variants[index], &[name])).expect("other idents");
            let mut overlaid = (*of.device).clone();
            gsdml::overlay(&mut overlaid, index, Some(&read(&with_other_idents(text, mask))), None, &[]);
            assert_eq!(idents(&varied.device, index), idents(&overlaid, index), "{manual}/{variant} {name}");
            assert_ne!(idents(&varied.device, index), idents(&of.device, index), "{manual}/{variant} {name}");
        }
    }
}

/// Interface and ports that no source describes are in no connection of a live device.
#[test]
fn without_a_source_there_are_no_idents_of_interface_and_ports() {
    let mut overlaid = device(MANUAL).clone();
    assert_ne!(of_network(&overlaid), []);
    let done = gsdml::overlay(&mut overlaid, 0, None, None, &[]);
    assert_eq!(of_network(&overlaid), []);
    let about = "the idents of interface and ports, which no connection expects therefore: there is no GSDML";
    assert!(done.missing.iter().any(|line| line.starts_with(about)), "{:?}", done.missing);
}

/// The names whose idents are still invented.
fn invented(device: &DeviceDescription) -> Vec<&str> {
    let submodules = device.submodules.iter().map(|of| (of.name.as_str(), of.ident_origin));
    let modules = device.modules.iter().map(|of| (of.name.as_str(), of.ident_origin));
    let id = [("device ID", device.bus.number_origin())];
    let all = submodules.chain(modules).chain(id);
    all.filter(|(_, origin)| *origin == Origin::Invented).map(|(name, _)| name).collect()
}

#[rstest]
#[case::vendor("VendorID=\"0x0239\"", "VendorID=\"0x0240\"", "vendor_id", "0x0239", "0x0240")]
#[case::shorter(
    "<DataItem DataType=\"Unsigned64\" TextId=\"S_G1_XIST3\"/>",
    "",
    "telegram_84.inputs",
    "20 bytes",
    "12 bytes"
)]
#[case::api(
    "SubmoduleIdentNumber=\"0x00000053\" API=\"15616\"",
    "SubmoduleIdentNumber=\"0x00000053\" API=\"0\"",
    "telegram_83.api",
    "0x3D00",
    "0x0"
)]
#[case::no_api_at_all(
    "SubmoduleIdentNumber=\"0x00000053\" API=\"15616\"",
    "SubmoduleIdentNumber=\"0x00000053\"",
    "telegram_83.api",
    "0x3D00",
    "0x0"
)]
#[case::record_length("Length=\"31\"", "Length=\"32\"", "bf00.octets", "31 bytes", "32 bytes")]
#[case::record_gone("Index=\"48896\"", "Index=\"48897\"", "bf00", "31 bytes, index 0xBF00", "no such record")]
#[case::default_of_a_bit(
    "BitOffset=\"5\" DefaultValue=\"1\"",
    "BitOffset=\"5\" DefaultValue=\"0\"",
    "bf00.compatibility.default",
    "disabled (1)",
    "enabled (0)"
)]
#[case::default_of_a_number(
    "ByteOffset=\"17\" DefaultValue=\"1\"",
    "ByteOffset=\"17\" DefaultValue=\"2\"",
    "bf00.life_sign_failures.default",
    "1",
    "2"
)]
#[case::range_of_another_variant(
    "ByteOffset=\"9\" DefaultValue=\"262144\"",
    "ByteOffset=\"9\" DefaultValue=\"1073741824\"",
    "bf00.total_range.default",
    "262144",
    "1073741824"
)]
fn a_disagreement_with_the_manual_is_an_error_with_both_values(
    #[case] from: &str,
    #[case] to: &str,
    #[case] id: &str,
    #[case] manual: &str,
    #[case] described: &str,
) {
    let findings = gsdml::compare(device(MANUAL), 0, Some(&changed(from, to)), None);
    let errors: Vec<&DeviceFinding> = findings.iter().filter(|of| of.severity == FindingSeverity::Error).collect();
    let [found] = errors.as_slice() else { panic!("{:#?}", shown(&findings)) };
    assert_eq!(
        (found.id.as_str(), found.manual.as_deref(), found.described_by(DescriptionKind::Gsdml)),
        (id, Some(manual), Some(described))
    );
    assert_eq!(found.device, None);
    assert!(found.text.ends_with('.'), "{}", found.text);
}

#[test]
fn a_missing_telegram_is_an_error() {
    let reference = "<SubmoduleItemRef SubmoduleItemTarget=\"TEL_84\" AllowedInSubslots=\"2\"/>";
    let findings = gsdml::compare(device(MANUAL), 0, Some(&changed(reference, "")), None);
    let ids: Vec<&str> = findings.iter().map(|of| of.id.as_str()).collect();
    assert_eq!(ids, ["telegram_84"], "{:#?}", shown(&findings));
}

#[test]
fn a_slot_without_modules_lacks_every_telegram() {
    let findings =
        gsdml::compare(device(MANUAL), 0, Some(&changed("FixedInSlots=\"1\"/>", "FixedInSlots=\"2\"/>")), None);
    let errors: Vec<&str> = findings.iter().map(|of| of.id.as_str()).collect();
    assert_eq!(errors, ["telegram_81", "telegram_82", "telegram_83", "telegram_84"], "{:#?}", shown(&findings));
}

#[test]
fn invented_numbers_never_disagree() {
    // Other idents and another device ID; the manual prints none of them.
    let text = shipped()
        .replace("IdentNumber=\"0x000000", "IdentNumber=\"0x00AB00")
        .replace("DeviceID=\"0x0001\"", "DeviceID=\"0x0302\"");
    let other = read(&text);
    assert_eq!(shown(&gsdml::compare(device(MANUAL), 0, Some(&other), None)), [""; 0]);
    let mut known = device(MANUAL).clone();
    let overlay = gsdml::overlay(&mut known, 0, Some(&other), None, &[]);
    assert_eq!(overlay.missing, [""; 0]);
    let ident =
        |name: &str| known.submodules.iter().find(|of| of.name == name).map(|of| (of.ident, of.module_ident(0)));
    assert_eq!(ident("dap"), Some((0x00AB_0001, Some(0x00AB_0002))));
    assert_eq!(ident("parameter_access_point"), Some((0x00AB_0002, None)));
    assert_eq!(ident("telegram_83"), Some((0x00AB_0053, None)));
    assert!(known.modules.iter().all(|of| of.ident() == Some(0x00AB_0001)));
    assert_eq!(identity(&known).device_id, 0x0302);
    // A device that agrees with the GSDML has no findings either.
    let mut says = ReportedIdentity::default();
    says.ids(0x0239, 0x0302);
    says.plugged = vec![plugged(0, 1, 0, 0x00AB_0002, 0x00AB_0001)];
    says.plugged.extend((0x8000..=0x8001).map(|of| plugged(0, of, 0, 0x00AB_0002, of.into())));
    assert_eq!(shown(&gsdml::compare(device(MANUAL), 0, Some(&other), Some(&says))), [""; 0]);
}

fn plugged(slot: u16, subslot: u16, api: u32, module_ident: u32, submodule_ident: u32) -> PluggedSubmodule {
    PluggedSubmodule { api, slot, module_ident, subslot, submodule_ident, octets: None }
}

#[test]
fn the_device_is_compared_with_manual_and_gsdml() {
    let mut says = ReportedIdentity::default();
    says.ids(0x0239, 0x0007);
    says.apis = Some(vec![0]);
    says.plugged = vec![
        plugged(0, 1, 0, 2, 1),
        plugged(1, 1, 0x3D00, 1, 2),
        plugged(1, 2, 0x3D00, 1, 99),
        plugged(0, 0x8000, 0, 2, 0x8000),
    ];
    let own = read(shipped());
    let findings = gsdml::compare(device(MANUAL), 0, Some(&own), Some(&says));
    let columns = |of: &DeviceFinding| {
        [
            Some(of.id.clone()),
            of.manual.clone(),
            of.described_by(DescriptionKind::Gsdml).map(str::to_owned),
            of.device.clone(),
        ]
    };
    let rows: Vec<[Option<String>; 4]> = findings.iter().map(columns).collect();
    assert_eq!(
        rows,
        [
            [Some("device_id"), None, Some("0x0001"), Some("0x0007")],
            [Some("api_0x3d00"), Some("has it"), Some("has it"), Some("does not have it")],
            [Some("slot_1.subslot_2"), None, Some("0x51, 0x52, 0x53, 0x54"), Some("0x63")],
            [Some("slot_0.subslot_0x8001"), None, Some("`Port 1` is built in"), Some("no submodule")],
        ]
        .map(|row| row.map(|cell: Option<&str>| cell.map(str::to_owned))),
        "{:#?}",
        shown(&findings)
    );
}

#[test]
fn without_a_gsdml_the_device_is_compared_with_the_manual() {
    let mut printed = device(MANUAL).clone();
    printed.submodules.iter_mut().for_each(|of| of.ident_origin = Origin::Manual);
    let mut says = ReportedIdentity::default();
    says.ids(0x0240, 0x0001);
    says.plugged = vec![plugged(0, 1, 0, 1, 7), plugged(1, 2, 0x3D00, 1, 83), plugged(1, 1, 0x3D00, 1, 3)];
    let findings = gsdml::compare(&printed, 0, None, Some(&says));
    let ids: Vec<&str> = findings.iter().map(|of| of.id.as_str()).collect();
    assert_eq!(ids, ["vendor_id", "slot_0.subslot_1", "slot_1.subslot_1"], "{:#?}", shown(&findings));
}

#[test]
fn a_device_alone_gives_only_certain_idents() {
    let mut says = ReportedIdentity::default();
    says.ids(0x0239, 0x0302);
    says.plugged =
        vec![plugged(0, 1, 0, 0x10, 0x11), plugged(1, 1, 0x3D00, 0x20, 0x21), plugged(1, 2, 0x3D00, 0x20, 0x22)];
    let mut known = device(MANUAL).clone();
    gsdml::overlay(&mut known, 0, None, Some(&says), &[]);
    // Which telegram has the ident 0x22 is not known.
    assert_eq!(invented(&known), ["telegram_81", "telegram_82", "telegram_83", "telegram_84"].repeat(2));
    let of = |name: &str, known: &DeviceDescription| {
        known.submodules.iter().find(|of| of.name == name).map(|of| (of.ident, of.module_ident(0)))
    };
    assert_eq!(of("dap", &known), Some((0x11, Some(0x10))));
    assert_eq!(of("parameter_access_point", &known), Some((0x21, None)));
    assert_eq!(identity(&known).device_id, 0x0302);
    // Its length identifies it as telegram 83.
    says.plugged[2].octets = Some((16, 4));
    let mut known = device(MANUAL).clone();
    gsdml::overlay(&mut known, 0, None, Some(&says), &[]);
    assert_eq!(of("telegram_83", &known), Some((0x22, None)));
    assert_eq!(invented(&known), ["telegram_81", "telegram_82", "telegram_84"].repeat(2));
    let module = known.modules.iter().find(|of| of.name == "telegram_83").expect("telegram 83");
    assert_eq!((module.ident(), module.ident_origin), (Some(0x20), Origin::Description));
    // The device ID of another vendor's device is not used.
    says.ids(0x0240, 0x0302);
    let mut known = device(MANUAL).clone();
    let overlay = gsdml::overlay(&mut known, 0, None, Some(&says), &[]);
    assert_eq!(known.bus.number_origin(), Origin::Invented);
    assert!(overlay.missing[0].starts_with("the device ID"), "{:?}", overlay.missing);
}

#[test]
fn a_start_up_with_invented_idents_needs_a_description() {
    let manual = manuals().iter().find(|of| of.device.name == MANUAL).expect("a manual");
    let start = manual.variants[0].trials.iter().find_map(|trial| trial.start()).expect("a trial that connects");
    let why = gsdml::needs_description(&manual.device, start).expect("the manual prints no idents");
    assert_eq!(
        why,
        "the manual prints no device ID, and neither a GSDML nor the device has it: name a GSDML in the bench file"
    );
    let mut known = (*manual.device).clone();
    known.bus.profinet_mut().expect("it is on PROFINET").identity.device_id_origin = Origin::Description;
    let why = gsdml::needs_description(&known, start).expect("the manual prints no idents");
    assert!(why.starts_with("the manual prints no ident of dap,"), "{why}");
    gsdml::overlay(&mut known, 0, Some(&read(shipped())), None, &[]);
    assert_eq!(gsdml::needs_description(&known, start), None);
}

/// A GSDML in the style of vendors: an older schema, one module for each telegram, other access points, hexadecimal and decimal
/// numbers, and unknown elements.
const OF_A_VENDOR: &str = include_str!("../gsdml/of-a-vendor.xml");

#[test]
fn a_gsdml_with_other_modules_is_read() {
    let vendor = read(OF_A_VENDOR);
    assert_eq!(vendor.version, "2.3");
    let names: Vec<&str> = vendor.access_points.iter().map(|point| point.info.name.as_str()).collect();
    assert_eq!(names, ["EMx13/16384PT", "XAC7718 1PT", "XAC7716/16384PT"]);
    let mut known = device(MANUAL).clone();
    let overlay = gsdml::overlay(&mut known, 1, Some(&vendor), None, &[]);
    assert_eq!(overlay.missing, [""; 0]);
    let submodule =
        |name: &str| known.submodules.iter().find(|of| of.name == name).map(|of| (of.ident, of.module_ident(1)));
    assert_eq!(submodule("dap"), Some((0x0101, Some(0x0003))), "the access point of the variant");
    assert_eq!(submodule("parameter_access_point"), Some((0xFFFF, None)));
    let module =
        |name: &str| known.modules.iter().find(|of| of.name == name).map(|of| of.ident().expect("it is on PROFINET"));
    assert_eq!(module("telegram_81"), Some(0x5081));
    assert_eq!(module("telegram_83"), Some(0x5083));
    assert_eq!(submodule("telegram_83"), Some((0x0083, None)), "not telegram 860, which has the same length");
    // The file has a wrong length for telegram 84; its name identifies it.
    assert_eq!(module("telegram_84"), Some(0x5084));
    let findings = gsdml::compare(device(MANUAL), 1, Some(&vendor), None);
    let errors: Vec<&str> =
        findings.iter().filter(|of| of.severity == FindingSeverity::Error).map(|of| of.id.as_str()).collect();
    assert_eq!(errors, ["telegram_84.inputs"], "{:#?}", shown(&findings));
    let warnings: Vec<&str> =
        findings.iter().filter(|of| of.severity == FindingSeverity::Warning).map(|of| of.text.as_str()).collect();
    assert_eq!(warnings.len(), 2, "{warnings:#?}");
    assert!(warnings[0].contains("there is no text `T_Gone` in the primary language"), "{}", warnings[0]);
    assert!(warnings[1].contains("`ModuleItemTarget` names nothing in this file"), "{}", warnings[1]);
    let infos: Vec<&str> =
        findings.iter().filter(|of| of.severity == FindingSeverity::Info).map(|of| of.id.as_str()).collect();
    assert_eq!(infos, ["record_0x64"]);
}

#[test]
fn the_plugged_access_point_overrides_the_claimed_one() {
    let vendor = read(OF_A_VENDOR);
    let says = ReportedIdentity { plugged: vec![plugged(0, 1, 0, 0x0002, 0x0101)], ..ReportedIdentity::default() };
    let mut known = device(MANUAL).clone();
    gsdml::overlay(&mut known, 1, Some(&vendor), Some(&says), &[]);
    let dap = known.submodules.iter().find(|of| of.slot == 0).expect("the access point");
    assert_eq!((dap.ident, dap.module_ident(1)), (0x0101, Some(0x0002)));
}

#[test]
fn all_items_of_a_record_are_read() {
    let own = read(shipped());
    let module = &own.modules[0];
    let record = &module.submodules[0].records[0];
    assert_eq!((record.index, record.octets, record.items.len()), (0xBF00, 31, 10));
    // Class 4 on, preset control on (inverted), compatibility off (inverted); units and range 2^18; one failure.
    let mut expected = vec![0; 31];
    expected[0] = 0b0010_0010;
    expected[6] = 0x04;
    expected[14] = 0x04;
    expected[17] = 1;
    assert_eq!(record.default, expected);
    let speed = record.items.last().expect("ten items");
    let words: Vec<(i128, &str)> = speed.words.iter().map(|(number, word)| (*number, word.as_str())).collect();
    assert_eq!(speed.name, "Unit of the velocity");
    assert_eq!(words.last(), Some(&(3, "Revolutions per minute")));
    assert_eq!(speed.allowed, [0..=3]);
}

#[rstest]
#[case::no_xml("hello", 1, 1, "not well-formed XML")]
#[case::empty("", 1, 1, "not well-formed XML")]
#[case::unclosed("<a>\n<b>\n", 2, 4, "not well-formed XML")]
#[case::wrong_end("<a>\n  <b></c>\n</a>", 2, 6, "expected 'b' tag, not 'c'; use the vendor's original file")]
#[case::attribute_twice("<a>\n<b x='1' x='2'/></a>", 2, 10, "attribute 'x'")]
#[case::dtd("<!DOCTYPE a [<!ENTITY x 'y'>]><a>&x;</a>", 1, 1, "not well-formed XML: XML with DTD detected")]
#[case::other_xml("<svg/>", 1, 1, "`ProfileBody` is missing; check that this is the vendor's GSDML file")]
#[case::no_identity("<a><ProfileBody>\n</ProfileBody></a>", 1, 4, "`DeviceIdentity` is missing")]
#[case::vendor_id(
    "<a><ProfileBody>\n <DeviceIdentity VendorID='0x10000'/></ProfileBody></a>",
    2,
    2,
    "`VendorID` is not a 16-bit number"
)]
#[case::no_access_point(
    "<a><ProfileBody><DeviceIdentity VendorID='1' DeviceID='2'/>\n<ApplicationProcess/></ProfileBody></a>",
    2,
    1,
    "there is no device access point with an ident number"
)]
fn an_invalid_file_is_reported_with_line_and_column(
    #[case] text: &str,
    #[case] line: u32,
    #[case] column: u32,
    #[case] says: &str,
) {
    let GsdmlError { line: at, column: in_line, message } = gsdml::read(text).expect_err("a broken file");
    assert!(message.contains(says), "{message}");
    assert_eq!((at, in_line), (line, column), "{message}");
}

#[test]
fn encodings_are_detected() {
    let wide: Vec<u8> = [0xFEFF]
        .into_iter()
        .chain(shipped().replace("utf-8", "utf-16").encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect();
    assert_eq!(gsdml::read_octets(&wide).expect("UTF-16"), read(shipped()));
    let with_mark = [b"\xEF\xBB\xBF", shipped().as_bytes()].concat();
    assert_eq!(gsdml::read_octets(&with_mark).expect("UTF-8 with a mark"), read(shipped()));
    let error = gsdml::read_octets(b"<a>\n<b x='\xE4'/></a>").expect_err("Latin 1");
    assert_eq!((error.line, error.column), (2, 7));
    assert!(error.message.contains("UTF-8"), "{error}");
}

#[test]
fn unknown_elements_are_ignored() {
    let with = shipped()
        .replace("<ModuleList>", "<Novelty Kind=\"7\"><Inner/></Novelty><ModuleList>")
        .replace("<Output Consistency", "<Sideways/><Output Consistency")
        .replace("MinDeviceInterval=", "Antigravity=\"true\" MinDeviceInterval=");
    let known = read(&with);
    let own = read(shipped());
    assert_eq!((&known.modules, &known.submodules), (&own.modules, &own.submodules));
    assert!(known.access_points[0].features.contains(&("Antigravity".into(), "true".into())));
    assert!(gsdml::show(&known).contains("Antigravity = true"));
}

#[test]
fn damaged_files_do_not_panic() {
    let text = shipped().trim_end();
    let mut readable = 0;
    for end in (0..text.len()).filter(|end| text.is_char_boundary(*end)).step_by(7) {
        let error = gsdml::read(&text[..end]).expect_err("an incomplete file");
        assert!(error.line >= 1 && error.column >= 1 && error.line as usize <= text.lines().count(), "{error}");
    }
    for place in (0..text.len()).step_by(5) {
        let mut octets = text.as_bytes().to_vec();
        octets[place] ^= 1 << (place % 8);
        if let Ok(gsdml) = gsdml::read_octets(&octets) {
            readable += 1;
            let findings = gsdml::compare(device(MANUAL), 0, Some(&gsdml), None);
            findings.iter().for_each(|of| assert!(!of.id.is_empty()));
            gsdml::overlay(&mut device(MANUAL).clone(), 0, Some(&gsdml), None, &[]);
            gsdml::show(&gsdml);
        }
    }
    assert!(readable > 100, "only {readable} files with a flipped bit were readable");
}

#[test]
fn out_of_range_numbers_are_remarks() {
    let odd = changed(
        "ByteOffset=\"18\" DefaultValue=\"0\" AllowedValues=\"0..3\"",
        "ByteOffset=\"18446744073709551615\" DefaultValue=\"9999999999999999999999999999999999999999999\" AllowedValues=\"5..3 x\"",
    );
    assert!(odd.remarks.iter().any(|of| of.contains("not a valid number here")), "{:?}", odd.remarks);
    assert!(
        odd.remarks.iter().any(|of| of.contains("`5..3` in `AllowedValues` is not a valid range")),
        "{:?}",
        odd.remarks
    );
    let odd = changed("BitOffset=\"5\"", "BitOffset=\"4294967295\"");
    assert!(odd.remarks.iter().any(|of| of.contains("`BitOffset` is out of range")), "{:?}", odd.remarks);
    let deep = format!("{}{}", "<a>".repeat(50_000), "</a>".repeat(50_000));
    gsdml::read(&deep).expect_err("no GSDML");
}

#[test]
fn invalid_answers_of_a_device_are_errors() {
    let mut says = ReportedIdentity::default();
    let error = says.take_apis(&[0, 0x1A, 0, 8, 1, 0, 0, 2, 0, 0]).expect_err("cut off");
    assert!(error.to_string().starts_with("the device's answer to record 0xF821 cannot be used: "), "{error}");
    // One API, 0x3D00, one slot with one subslot; expected instead of real identification.
    let mut octets = vec![0, 0x13, 0, 26, 1, 1, 0, 1, 0, 0, 0x3D, 0, 0, 1, 0, 1, 0, 0, 0, 5, 0, 1, 0, 2, 0, 0, 0, 83];
    octets[3] = (octets.len() - 4) as u8;
    let mut good = ReportedIdentity::default();
    good.take_real(0, &octets).expect("a real identification");
    assert_eq!(good.plugged, [plugged(1, 2, 0x3D00, 5, 83)]);
    octets[1] = 0x12;
    let error = says.take_real(0, &octets).expect_err("an expected identification");
    assert!(error.to_string().contains("it contains a block of type 0x0012"), "{error}");
    for end in 0..octets.len() {
        let _ = says.take_real(0, &octets[..end]);
        let _ = says.take_im0(&octets[..end]);
        let _ = says.take_apis(&octets[..end]);
    }
}

#[test]
fn an_error_finding_makes_the_run_red_in_every_report() {
    let of = |severity| {
        let mut result = sample_run::run(vec![sample_run::case("a/b", CaseKind::Trial, Verdict::Pass, Level::Must)]);
        result.runs[0].findings = vec![DeviceFinding {
            id: "telegram_83.inputs".into(),
            severity,
            text: "Input data of telegram_83: the manual says 16 octets, the GSDML says 14 octets.".into(),
            manual: Some("16 bytes".into()),
            description: Some((DescriptionKind::Gsdml, "14 bytes".into())),
            device: None,
        }];
        result
    };
    for severity in [FindingSeverity::Warning, FindingSeverity::Info] {
        assert_eq!(status(&of(severity)), ExitStatus::Green);
        assert!(!ReportFormat::Tap.write(&of(severity)).contains("not ok"));
    }
    let red = of(FindingSeverity::Error);
    assert_eq!(status(&red), ExitStatus::Red);
    let json: serde_json::Value = serde_json::from_str(&ReportFormat::Json.write(&red)).expect("JSON");
    assert_eq!(json["green"], false);
    let found = &json["runs"][0]["findings"][0];
    assert_eq!(found["severity"], "error");
    assert_eq!((&found["manual"], &found["gsdml"]), (&"16 bytes".into(), &"14 bytes".into()));
    assert_eq!(found["device"], serde_json::Value::Null);
    let reason = "1 finding on model:acme-profinet/single: telegram_83.inputs";
    assert!(
        ReportFormat::Tap.write(&red).contains(&format!("not ok 2 - {reason}")),
        "{}",
        ReportFormat::Tap.write(&red)
    );
    assert!(ReportFormat::Junit.write(&red).contains(reason));
    for format in [ReportFormat::Console, ReportFormat::Text] {
        let text = format.write(&red);
        for line in [
            "error telegram_83.inputs: Input data",
            "manual     16 bytes",
            "GSDML      14 bytes",
            "device     no value",
        ] {
            assert!(text.contains(line), "{text}");
        }
    }
}

/// Exit status, standard output and standard error.
fn encspec(arguments: &[&str]) -> (Option<i32>, String, String) {
    let ProgramOutput { status, out, err } = program::encspec(Path::new("."), arguments);
    (status, out, err)
}

#[test]
fn the_command_prints_compares_and_saves() {
    let folder = Folder::new("gsdml");
    let folder = folder.join("saved");
    let folder = folder.to_str().expect("a path in UTF-8");
    let (status, out, _) = encspec(&["gsdml", "--save", folder]);
    assert_eq!(status, Some(0));
    let saved: Vec<&str> = out.lines().collect();
    assert_eq!(saved.len(), suites::gsdml().len());
    let single = saved.iter().find(|path| path.contains("XAC7718")).expect("the single-turn device");
    assert_eq!(fs::read_to_string(single).expect("a saved file"), shipped());
    let (status, out, err) = encspec(&["gsdml", single, "--device", "lika-xac77-profinet/xac7718"]);
    assert_eq!((status, err.as_str()), (Some(0), ""));
    assert!(out.contains("Standard telegram 83 (TEL_83), ident 0x53, API 0x3D00, 16 bytes in, 4 out"), "{out}");
    assert!(out.ends_with("  no disagreements\n"), "{out}");
    // The multiturn device has other defaults.
    let (status, out, _) = encspec(&["gsdml", single, "--device", "lika-xac77-profinet/xac7716-16384"]);
    assert_eq!(status, Some(1));
    assert!(out.contains("error bf00.units_per_revolution.default"), "{out}");
    let broken = format!("{folder}/broken.xml");
    fs::write(&broken, "<a>\n  <b\u{9b}></a>").expect("a file");
    let (status, out, err) = encspec(&["gsdml", &broken]);
    assert_eq!((status, out.as_str()), (Some(2), ""));
    assert!(err.contains("broken.xml:2:") && !err.contains('\u{9b}'), "{err}");
    let (status, _, err) = encspec(&["gsdml", &format!("{folder}/none.xml")]);
    assert_eq!(status, Some(2));
    assert!(err.contains("none.xml: "), "{err}");
}
