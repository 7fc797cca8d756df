//! Output of `encspec dissect` and `encspec replay` for PROFIBUS captures.

use crate::common::program::encspec;
use encspec::observe::ProfibusWords;
use rstest::rstest;
use station::Time;
use testing::{Folder, golden, hex};
use virtual_wire::capture::{LinkType, PcapngWriter};

/// A data frame in the format SD2.
fn frame(da: u8, sa: u8, fc: u8, rest: &str) -> Vec<u8> {
    let mut counted = vec![da, sa, fc];
    counted.extend(hex(rest));
    let length = u8::try_from(counted.len()).expect("a short frame");
    let sum = counted.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
    [&[0x68, length, length, 0x68], counted.as_slice(), &[sum, 0x16]].concat()
}

fn words(octets: &[u8]) -> String {
    ProfibusWords::default().lines(octets).join("\n")
}

#[rstest]
#[case("token", &["126 -> 2 token"])]
#[case("short_acknowledgement", &["short acknowledgement"])]
#[case("fdl_status_request", &["2 -> 8 fdl_status request (fdl_status)"])]
#[case("fdl_status_answer", &["8 -> 2 answer (ok, slave)"])]
#[case("segments", &["2 -> 8 slave_diag request (srd_low) to segment 5 SAP 60 from segment 63"])]
#[case("slave_diag_request_first", &["2 -> 8 slave_diag request (srd_high, first count) to SAP 60 from SAP 62"])]
#[case("set_prm_plain", &[
    "2 -> 8 set_prm request (srd_high, count 0) to SAP 61 from SAP 62",
    "wd_on freeze_req sync_req lock_req",
    "watchdog 1000 ms, min TSDR 11 bits, ident 0x1655, groups 1 8",
])]
#[case("set_prm_dpv1", &[
    "2 -> 8 set_prm request (srd_high, count 1) to SAP 61 from SAP 62",
    "wd_on freeze_req sync_req lock_req",
    "watchdog 100 ms, min TSDR 11 bits, ident 0x1655, groups 1 8",
    "wd_base_1ms fail_safe dpv1_enable",
    "alarms: check_cfg_mode diagnosis_alarm pull_plug_alarm",
    "alarm mode 4 structured blocks isochronous",
    "isochronous slot 0: cycle 1000000 ns",
    "  T_BASE_DP 1500 T_DP 8 T_MAPC 1 T_BASE_IO 1500 T_I 1 T_O 2 T_DX 750 T_PLL_W 12 T_PLL_D 0",
])]
#[case("chk_cfg", &[
    "2 -> 8 chk_cfg request (srd_high, count 0) to SAP 62 from SAP 62",
    "4 words of inputs, consistent as a whole",
    "2 bytes of outputs",
    "16 words of outputs; 16 words of inputs",
    "2 words of outputs, consistent as a whole; 6 words of inputs, consistent as a whole; manufacturer data fd 00 51",
    "64 bytes of inputs",
    "8 words of outputs",
    "an empty slot",
    "total 54 bytes of outputs, 116 bytes of inputs",
])]
#[case("slave_diag_answer", &[
    "8 -> 2 slave_diag answer (data_low, slave) to SAP 62 from SAP 60",
    "station_not_ready prm_fault prm_req fixed_one wd_on ext_diag_overflow",
    "no master, ident 0x1655",
])]
#[case("data_exchange_answer", &["8 -> 2 data_exchange answer (data_low, slave)", "data 00 05 50 00"])]
#[case("global_control", &["2 -> 127 global_control request (sdn_high) to SAP 58 from SAP 62", "freeze sync to groups 1 8"])]
#[case("global_control_clear", &["2 -> 127 global_control request (sdn_high) to SAP 58 from SAP 62", "clear_data to all slaves"])]
#[case("set_slave_address", &[
    "2 -> 8 set_slave_address request (srd_low) to SAP 55 from SAP 62",
    "new address 5, ident 0x1655, further changes allowed",
])]
#[case("set_ext_prm", &["2 -> 8 set_ext_prm request (srd_low) to SAP 53 from SAP 62", "user_prm_data slot 0: 01 ff"])]
#[case("ms1_read", &["2 -> 8 server request (srd_low) to SAP 51 from SAP 51", "read slot 0 index 47 length 240"])]
#[case("ms1_alarm_ack", &["2 -> 8 alarm request (srd_low) to SAP 50 from SAP 51", "alarm_ack slot 1 alarm type 1, sequence 1"])]
#[case("ms2_initiate", &[
    "2 -> 8 resource_manager request (srd_low) to SAP 49 from SAP 50",
    "initiate, 1000 ms",
    "features 01 00, profile features 00 00, profile 0x0303, from 00 00 to 00 00",
])]
fn frames_are_described(#[case] name: &str, #[case] expected: &[&str]) {
    let octets = golden("pyprofibus.txt").into_iter().find(|(other, _)| other == name).expect("a golden frame").1;
    assert_eq!(ProfibusWords::default().lines(&octets), expected);
}

#[rstest]
#[case::diagnosis("3E3C 080C0002 1655 814036 4203 06810001 1011 C5", &[
    "8 -> 2 slave_diag answer (data_low, slave) to SAP 62 from SAP 60",
    "ext_diag fixed_one wd_on",
    "master 2, ident 0x1655",
    "channel 0 of identifier 1: input, bit, error type 22",
    "identifiers: 0 1",
    "device: 81 00 01 10 11",
    "  with DP-V1: status status_message, slot 0, sequence 0, appears: 10 11",
    "revision 5",
])]
#[case::block_length("3E3C 080C0002 1655 814036 00", &[
    "8 -> 2 slave_diag answer (data_low, slave) to SAP 62 from SAP 60",
    "ext_diag fixed_one wd_on",
    "master 2, ident 0x1655",
    "channel 0 of identifier 1: input, bit, error type 22",
    "damaged: diagnosis block: byte 18: block length is 0x0, expected 1 to 63, with the header",
    "bytes 08 0c 00 02 16 55 81 40 36 00",
])]
#[case::refused("3333 DE80B500", &[
    "8 -> 2 server answer (data_low, slave) to SAP 51 from SAP 51",
    "read_refused: state_conflict (de 80 b5 00)",
])]
#[case::resource_manager("3231 56300064", &[
    "8 -> 2 resource_manager answer (data_low, slave) to SAP 50 from SAP 49",
    "resource_manager: use SAP 48, 1000 ms",
])]
#[case::connection("3230 5E002F0401020304", &[
    "8 -> 2 ms2 by SAP 48 answer (data_low, slave) to SAP 50 from SAP 48",
    "read slot 0 index 47 length 4",
    "record 01 02 03 04",
])]
#[case::record_cut("3230 5E002F0801020304", &[
    "8 -> 2 ms2 by SAP 48 answer (data_low, slave) to SAP 50 from SAP 48",
    "damaged: DP-V1: byte 13: expected 8 bytes, 4 left",
    "bytes 5e 00 2f 08 01 02 03 04",
])]
#[case::abort("3230 580113", &[
    "8 -> 2 ms2 by SAP 48 answer (data_low, slave) to SAP 50 from SAP 48",
    "abort: timeout, subnet local",
])]
fn answers_are_described(#[case] rest: &str, #[case] expected: &[&str]) {
    assert_eq!(ProfibusWords::default().lines(&frame(0x82, 0x88, 0x08, rest)), expected);
}

#[test]
fn damaged_frames_are_described_with_the_offset() {
    let wrong_sum = words(&hex("100802495416"));
    assert!(wrong_sum.starts_with("damaged: PROFIBUS FDL: byte 4: FCS is 0x54"), "{wrong_sum}");
    assert!(wrong_sum.ends_with("\nbytes 10 08 02 49 54 16"), "{wrong_sum}");
    assert!(words(&hex("68050668")).starts_with("damaged: PROFIBUS FDL: byte 2: LEr is 0x6"));
    assert!(words(&[]).starts_with("damaged: PROFIBUS FDL: byte 0: expected 1 bytes, 0 left"));
}

/// An answer without SAPs is named after the request directly before it between the same two stations.
#[test]
fn answers_without_saps_are_named_after_their_request() {
    let frames = golden("pyprofibus.txt");
    let octets = |name: &str| frames.iter().find(|(other, _)| other == name).expect("a golden frame").1.clone();
    let mut words = ProfibusWords::default();
    let mut first = |octets: &[u8]| words.lines(octets).remove(0);
    first(&octets("set_prm_plain"));
    assert_eq!(first(&octets("short_acknowledgement")), "8 -> 2 set_prm short acknowledgement");
    assert_eq!(first(&octets("short_acknowledgement")), "short acknowledgement");
    first(&octets("get_cfg_request"));
    assert_eq!(first(&octets("answer_no_service")), "8 -> 2 get_cfg answer (no_service, slave)");
    first(&octets("get_cfg_request"));
    assert_eq!(first(&octets("answer_master_in_ring")), "3 -> 2 answer (ok, master_in_ring)");
    first(&octets("global_control"));
    assert_eq!(first(&octets("answer_no_data")), "8 -> 2 answer (no_data, slave)");
}

#[test]
fn any_flipped_bit_is_described() {
    let mut words = ProfibusWords::default();
    for (_, octets) in golden("pyprofibus.txt") {
        for at in 0..octets.len() * 8 {
            let mut damaged = octets.clone();
            damaged[at / 8] ^= 1 << (at % 8);
            assert!(!words.lines(&damaged).is_empty());
            // With a corrected FCS the damage reaches the services.
            let start = if damaged[0] == 0x68 { 4 } else { 1 };
            if let Some(end) = damaged.len().checked_sub(2).filter(|end| *end > start) {
                damaged[end] = damaged[start..end].iter().fold(0, |sum, octet| sum.wrapping_add(*octet));
                assert!(!words.lines(&damaged).is_empty());
            }
        }
    }
}

#[test]
fn a_capture_is_dissected_and_replayed() {
    let folder = Folder::new("dissect-profibus");
    let mut writer = PcapngWriter::new(Vec::new(), "made by a test").expect("a vector takes all");
    let wire = writer.interface("bus", LinkType::PROFIBUS).expect("a vector takes all");
    let frames = golden("pyprofibus.txt");
    for name in ["global_control", "token"] {
        let octets = &frames.iter().find(|(other, _)| other == name).expect("a golden frame").1;
        writer.packet(wire, Time::from_nanos(1_000), octets, None).expect("a vector takes all");
    }
    writer.packet(wire, Time::from_nanos(2_000), &hex("100802495416"), None).expect("a vector takes all");
    folder.write("bus.pcapng", writer.finish().expect("a vector takes all"));
    let encspec = |command: &str| {
        let said = encspec(&folder, &[command, "bus.pcapng"]);
        (said.status, said.out)
    };
    let (status, out) = encspec("dissect");
    assert_eq!(status, Some(0), "{out}");
    let lines: Vec<_> = out.lines().collect();
    assert_eq!(lines.len(), 5, "{out}");
    assert!(
        lines[0].starts_with("     1 ")
            && lines[0].ends_with(" 2 -> 127 global_control request (sdn_high) to SAP 58 from SAP 62"),
        "{out}"
    );
    assert_eq!(lines[1], "           freeze sync to groups 1 8");
    assert!(lines[2].starts_with("     2 ") && lines[2].ends_with(" 126 -> 2 token"), "{out}");
    assert!(lines[3].contains(" damaged: PROFIBUS FDL: byte 4: FCS is 0x54"), "{out}");
    assert_eq!(lines[4], "           bytes 10 08 02 49 54 16");
    let (_, out) = encspec("replay");
    assert!(out.starts_with("bus.pcapng: 3 frames, 0 connections"), "{out}");
    assert!(out.contains("global_control     master 2 commands all: freeze sync, groups 0x81"), "{out}");
    assert!(out.contains("unreadable         PROFIBUS FDL: byte 4: FCS is 0x54"), "{out}");
}
