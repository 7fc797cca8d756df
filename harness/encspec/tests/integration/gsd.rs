//! GSD files: both readers agree on the built-in files, errors have a line, and disagreements with a manual are found.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use crate::built_in::manuals;
use encspec::gsd::{self, FieldType, Gsd, GsdModule};
use encspec::result::FindingSeverity;
use encspec::suite::model::ConnectionStart;
use gsd_parser::UserPrmDataType;
use std::time::Duration;

fn files() -> impl Iterator<Item = (&'static str, &'static str, Gsd)> {
    let read = |text: &str| gsd::read(text).expect("a shipped GSD is read");
    suites::gsd().iter().map(move |(path, text)| (*path, *text, read(text)))
}

/// Length in bytes and bit range of a field as read by encspec.
fn extent(kind: FieldType) -> (usize, Option<(u8, u8)>) {
    match kind {
        FieldType::Octets { octets, .. } => (octets, None),
        FieldType::Bits { low, high } => (1, Some((low, high))),
    }
}

/// Length in bytes and bit range of a field as read by gsd-parser.
fn extent_of_gsd_parser(kind: UserPrmDataType) -> (usize, Option<(u8, u8)>) {
    match kind {
        UserPrmDataType::Bit(bit) => (1, Some((bit, bit))),
        UserPrmDataType::BitArea(low, high) => (1, Some((low, high))),
        kind => (kind.size(), None),
    }
}

#[test]
fn gsd_parser_agrees() {
    assert!(files().count() >= 3, "each encoder on PROFIBUS has one");
    for (path, text, ours) in files() {
        let reference = gsd_parser::parser::parse(path.as_ref(), text).expect("gsd-parser reads it");
        assert_eq!(reference.ident_number, ours.ident, "{path}");
        assert_eq!((reference.vendor, reference.model), (ours.vendor.clone(), ours.model.clone()), "{path}");
        assert_eq!(Some(usize::from(reference.max_diag_data_length)), ours.max_diagnosis, "{path}");
        assert_eq!(Some(usize::from(reference.max_input_length)), ours.max_inputs, "{path}");
        assert_eq!(Some(usize::from(reference.max_output_length)), ours.max_outputs, "{path}");
        assert_eq!(reference.supported_speeds.bits().count_ones() as usize, ours.bauds.len(), "{path}");
        let theirs = &reference.max_tsdr;
        let theirs = [
            (9_600, theirs.b9600),
            (45_450, theirs.b45450),
            (1_500_000, theirs.b1500000),
            (12_000_000, theirs.b12000000),
        ];
        for (baud, bits) in theirs {
            let own = ours.max_tsdr.iter().find(|(rate, _)| rate.0 == baud).map(|(_, bits)| bits.0);
            assert_eq!(own, Some(u64::from(bits)), "{path} at {baud} bit/s");
        }
        let flags = [reference.freeze_mode_supported, reference.sync_mode_supported, reference.auto_baud_supported];
        assert_eq!(flags, [ours.freeze, ours.sync, ours.auto_baud], "{path}");
        assert_eq!(
            (reference.fail_safe, reference.set_slave_addr_supported),
            (ours.fail_safe, ours.set_slave_address),
            "{path}"
        );
        assert_eq!(reference.available_modules.len(), ours.modules.len(), "{path}");
        for (theirs, own) in reference.available_modules.iter().zip(&ours.modules) {
            assert_eq!((&theirs.name, &theirs.config), (&own.name, &own.cfg), "{path}");
            let fields = own.parameters.fields.iter();
            let fields: Vec<_> = fields.map(|(at, of)| (*at, of.name.clone(), extent(of.kind), of.default)).collect();
            let expected = theirs
                .module_prm_data
                .data_ref
                .iter()
                .map(|(at, of)| (*at, of.name.clone(), extent_of_gsd_parser(of.data_type), of.default_value));
            assert_eq!(fields, expected.collect::<Vec<_>>(), "{path}, {}", own.name);
        }
    }
}

#[test]
fn built_in_files_agree_with_the_manuals() {
    let manuals = manuals();
    for (path, _, read) in files() {
        let (folder, file) = path.split_once('/').unwrap();
        let manual = manuals.iter().find(|of| of.device.name == folder).expect("it lies beside its manual");
        let device = &manual.device;
        let variant = device.variants.iter().position(|name| file.contains(name.as_str())).unwrap_or_default();
        let findings = gsd::compare(device, variant, &read);
        assert!(findings.is_empty(), "{path}: {findings:?}");
        let overlay = gsd::overlay(&mut (**device).clone(), Some(&read), &[]);
        assert!(overlay.missing.is_empty(), "{path}: {:?}", overlay.missing);
        for module in &device.modules {
            assert!(read.modules.iter().any(|known| known.cfg == module.cfg()), "{path} lacks {}", module.name);
        }
    }
}

/// The user parameters that a start-up sends by default, byte by byte; manual and GSD are independent sources.
#[test]
fn default_user_parameters_are_those_of_the_manual() {
    let (_, _, read) = files().find(|(path, ..)| path.contains("hs5818")).expect("the GSD of the AMT58");
    let class_2: Vec<&GsdModule> = read.modules.iter().filter(|of| of.cfg == [0xD1, 0xE1]).collect();
    let octets = read.default_octets(class_2.last().expect("class 2"));
    assert_eq!(&octets[..3], [0, 0, 0], "DP-V1");
    assert_eq!(octets[3] & 0x0A, 0x0A, "scaling and class 2 are on");
    assert_eq!(octets[4..12], [0x00, 0x04, 0x00, 0x00, 0x00, 0x04, 0x00, 0x00], "262144 steps of 262144");
}

#[test]
fn disagreements_are_found() {
    let manuals = manuals();
    let manual = manuals.iter().find(|of| of.device.name == "datalogic-amt58-profibus").unwrap();
    let (_, text, _) = files().find(|(path, ..)| path.contains("hs5818")).unwrap();
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from), "the GSD has `{from}`");
        gsd::compare(&manual.device, 0, &gsd::read(&text.replace(from, to)).unwrap())
    };
    let ident = changed("Ident_Number=0x1655", "Ident_Number=0x1656");
    assert_eq!((ident[0].id.as_str(), ident[0].severity), ("ident_number", FindingSeverity::Error));
    assert_eq!(ident[0].text, "Ident number: the manual says 0x1655, the GSD says 0x1656.");
    let longest = changed("Max_Diag_Data_Len=63", "Max_Diag_Data_Len=16");
    assert_eq!((longest[0].id.as_str(), longest[0].severity), ("diagnosis.octets", FindingSeverity::Warning));
    let module = changed("0xD1,0xE1", "0xD0,0xE1");
    assert!(module.iter().any(|of| of.id.ends_with(".cfg") && of.severity == FindingSeverity::Warning), "{module:?}");
}

#[test]
fn invalid_files_are_reported_with_a_line() {
    let wrong = |text: &str| gsd::read(text).expect_err("it is broken").to_string();
    assert_eq!(wrong(""), "line 1: not a GSD file: the line `#Profibus_DP` is missing");
    assert_eq!(wrong("#Profibus_DP\n"), "line 1: `Ident_Number` is missing");
    assert_eq!(wrong("#Profibus_DP\nIdent_Number=0x12345\n"), "line 2: the ident number is not a 16-bit number");
    assert_eq!(wrong("#Profibus_DP\nIdent_Number=x\n"), "line 2: `x` is not a number");
    assert_eq!(wrong("#Profibus_DP\nModule=\"A\" 0x100\n"), "line 2: `0x100` is not a byte");
    assert_eq!(wrong("#Profibus_DP\nModule=\"A\" 0x10\n"), "line 2: `EndModule` is missing");
    assert_eq!(
        wrong("#Profibus_DP\nExtUserPrmData=1 \"A\"\nUnsigned9 0 0-1\nEndExtUserPrmData\n"),
        "line 3: `Unsigned9` is not a field type"
    );
    assert_eq!(
        wrong("#Profibus_DP\nExt_User_Prm_Data_Ref(0)=7\n"),
        "line 2: `ExtUserPrmData=7` is not defined before this line"
    );
}

/// No prefix and no flipped bit makes the reader panic or hang.
#[test]
fn damaged_files_do_not_panic() {
    for (_, text, _) in files() {
        let octets = text.as_bytes();
        for end in (0..octets.len()).step_by(7) {
            let _ = gsd::read_octets(&octets[..end]);
        }
        for at in (0..octets.len()).step_by(3) {
            let mut damaged = octets.to_vec();
            damaged[at] ^= 1 << (at % 8);
            let _ = gsd::read_octets(&damaged);
        }
    }
}

/// Guideline 2.122, Min_Slave_Intervall: in units of 100 us.
#[test]
fn polls_are_at_least_min_slave_interval_apart() {
    let (_, text, _) = files().find(|(path, ..)| path.starts_with("dp-slave/")).expect("it is shipped");
    assert!(text.contains("Min_Slave_Intervall=1\n"));
    let manual = manuals().iter().find(|of| of.device.name == "dp-slave").unwrap();
    let usual = manual.variants[0].trials.iter().find_map(|trial| trial.start()).unwrap();
    let polls = |interval: &str, cycle: u64| {
        let text = text.replace("Min_Slave_Intervall=1\n", &format!("Min_Slave_Intervall={interval}\n"));
        let mut device = (*manual.device).clone();
        gsd::overlay(&mut device, Some(&gsd::read(&text).expect("it is read")), &[]);
        ConnectionStart { cycle: Some(Duration::from_millis(cycle)), ..usual.clone() }.cycle(&device)
    };
    assert_eq!(polls("200", 1), Duration::from_millis(20));
    assert_eq!(polls("200", 30), Duration::from_millis(30));
    assert_eq!(polls("1", 1), Duration::from_millis(1));
}
