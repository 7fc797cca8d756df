//! Frames from a stream without timing, address extensions, and the duration of frames.
#![allow(clippy::unwrap_used, reason = "an unwrap fails the test")]

use encspec_wire::profibus::fdl::{BaudRate, BitTimes, FdlFrame, FdlPiece, Splitter};
use rstest::rstest;
use testing::{golden, hex};

fn pieces(parts: &[&str]) -> Vec<String> {
    let mut splitter = Splitter::new();
    let mut said = Vec::new();
    let mut say = |piece| {
        let digits = |octets: Vec<u8>| octets.iter().map(|octet| format!("{octet:02x}")).collect::<String>();
        said.push(match piece {
            FdlPiece::Frame(octets) => digits(octets),
            FdlPiece::Damaged { octets, why } => format!("{}: {why}", digits(octets)),
        });
    };
    for part in parts {
        match *part {
            "silence" => std::iter::from_fn(|| splitter.silence()).for_each(&mut say),
            part => {
                splitter.push(&hex(part));
                std::iter::from_fn(|| splitter.next_piece()).for_each(&mut say);
            }
        }
    }
    said
}

#[test]
fn complete_frames_in_sequence() {
    let frames = golden("pyprofibus.txt");
    let stream: Vec<u8> = frames.iter().flat_map(|(_, octets)| octets.clone()).collect();
    for part in [1, 2, 5, stream.len()] {
        let mut splitter = Splitter::new();
        let mut found = Vec::new();
        for part in stream.chunks(part) {
            splitter.push(part);
            found.extend(std::iter::from_fn(|| splitter.next_piece()));
        }
        let expected: Vec<_> = frames.iter().map(|(_, octets)| FdlPiece::Frame(octets.clone())).collect();
        assert_eq!(found, expected);
        assert_eq!((splitter.is_waiting(), splitter.silence()), (false, None));
    }
}

#[rstest]
#[case::in_parts(&["1008", "02495316", "e5"], &["100802495316", "e5"])]
#[case::noise(&["ff00", "100802495316"], &["ff00: PROFIBUS FDL: byte 0: SD is 0xff, expected 10, 68, A2, DC or E5", "100802495316"])]
#[case::checksum(
    &["100802495416", "100802495316"],
    &["100802495416: PROFIBUS FDL: byte 4: FCS is 0x54, expected the sum of the bytes from DA on", "100802495316"]
)]
#[case::token_in_noise(
    &["ff", "dc0202", "e5", "silence", "dc0202"],
    &["ffdc0202e5: PROFIBUS FDL: byte 0: SD is 0xff, expected 10, 68, A2, DC or E5", "dc0202"]
)]
#[case::cut_off(&["68050568", "silence", "e5"], &["68050568: PROFIBUS FDL: byte 4: expected 5 bytes, 0 left", "e5"])]
#[case::found_in_silence(
    &["ff6809", "100802495316", "silence"],
    &["ff6809: PROFIBUS FDL: byte 0: SD is 0xff, expected 10, 68, A2, DC or E5", "100802495316"]
)]
#[case::waits_for_more(
    &["ffa2", "100802495316", "e5"],
    &[]
)]
#[case::lengths(
    &["68050668888200", "silence"],
    &["68050668888200: PROFIBUS FDL: byte 2: LEr is 0x6, expected the same as LE"]
)]
#[case::too_short(&["680303680802", "silence"], &["680303680802: PROFIBUS FDL: byte 1: LE is 0x3, expected 4 to 249"])]
#[case::no_end(
    &["100802495317", "silence"],
    &["100802495317: PROFIBUS FDL: byte 5: ED is 0x17, expected 16"]
)]
fn streams(#[case] parts: &[&str], #[case] expected: &[&str]) {
    assert_eq!(pieces(parts), expected);
}

#[rstest]
#[case::nothing("", "byte 0: expected 1 bytes, 0 left")]
#[case::second_start("6805050088826d3c3ef116", "byte 3: second SD is 0x0, expected 68")]
#[case::left_over("e5e5", "byte 1: number of remaining bytes is 0x1, expected nothing after the frame")]
#[case::no_space_for_an_extension("108802498316aa", "byte 4")]
#[case::extension_cut("108802 49 d3 16", "byte 4: expected 1 bytes, 0 left")]
#[case::third_extension(
    "68060668 8802 4c ffc53c d6 16",
    "byte 8: address extension is 0xc5, expected an access point, 0 to 63"
)]
#[case::after_an_access_point("68060668 8802 4c bc0000 92 16", "byte 7: address extension is 0xbc")]
fn the_error_of_a_damaged_frame_has_field_and_offset(#[case] octets: &str, #[case] says: &str) {
    let error = FdlFrame::parse(&hex(octets)).unwrap_err().to_string();
    assert!(error.starts_with("PROFIBUS FDL: ") && error.contains(says), "{error}");
}

#[rstest]
#[case(9_600, 11, 1_145_834)]
#[case(500_000, 66, 132_000)]
#[case(12_000_000, 1, 84)]
#[case(12_000_000, 12_000_000, 1_000_000_000)]
#[case(0, 1, 1_000_000_000)]
fn bit_times(#[case] rate: u32, #[case] bits: u64, #[case] nanoseconds: u64) {
    assert_eq!(BaudRate(rate).nanoseconds(BitTimes(bits)), nanoseconds);
}

#[test]
fn frames_last_eleven_bits_per_byte() {
    assert_eq!(BitTimes::of_octets(6) + BitTimes::TSYN, BitTimes(99));
    assert_eq!(BitTimes(u64::MAX) + BitTimes(1), BitTimes(u64::MAX));
    assert_eq!(BaudRate(1).nanoseconds(BitTimes(u64::MAX)), u64::MAX);
    assert!(BaudRate::STANDARD.is_sorted());
}
