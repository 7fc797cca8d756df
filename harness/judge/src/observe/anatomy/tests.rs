use super::*;
use rstest::rstest;

const DCP: &str = "02 00 00 00 00 02 02 00 00 00 00 01 88 92 FE FD 04 00 00 00 00 2A 00 00 00 0C \
    02 02 00 07 00 01 65 6E 63 2D 31 00 00 00 00 00";
const RT: &str = "02 00 00 00 00 01 02 00 00 00 00 02 81 00 C0 00 88 92 C0 01 80 01 02 03 04 80 \
    00 40 35 00";
const ABORT: &str = "02 00 00 00 00 01 02 00 00 00 00 02 88 92 FE 01 00 01 00 02 14 01 FF FF FF FE 00 04 \
    CF 81 FD 05";
/// Set_Prm of station 3 by master 2, from SAP 62 to SAP 61, seven bytes.
const SET_PRM: &str = "68 0C 0C 68 83 82 5D 3D 3E B8 01 64 0B F3 7E 00 76 16";

fn octets(text: &str) -> Vec<u8> {
    text.split_whitespace().filter_map(|pair| u8::from_str_radix(pair, 16).ok()).collect()
}

/// Checks that the parts cover all bytes in order.
fn is_whole(octets: &[u8], parts: &[FramePart]) {
    let mut at = 0;
    for part in parts {
        assert_eq!(part.octets.start, at, "{parts:?}");
        assert!(part.octets.end > at, "{parts:?}");
        at = part.octets.end;
    }
    assert_eq!(at, octets.len(), "{parts:?}");
}

#[rstest]
#[case(LinkType::ETHERNET, DCP, &[(14..16, "frame id", "0xFEFD"), (16..17, "service", "Set"), (32..37, "name-of-station", "")])]
#[case(LinkType::ETHERNET, RT, &[(12..14, "VLAN tag", ""), (20..26, "data", ""), (28..29, "data status", "primary, valid, run, no problem")])]
#[case(LinkType::ETHERNET, ABORT, &[(20..21, "version and PDU type", "error"), (28..32, "PNIO status", "")])]
#[case(LinkType::PROFIBUS, SET_PRM, &[(4..5, "destination", "station 3"), (7..8, "destination SAP", "SAP 61"), (9..16, "data", "")])]
fn parts_of_a_frame(
    #[case] link: LinkType,
    #[case] text: &str,
    #[case] expected: &[(std::ops::Range<usize>, &str, &str)],
) {
    let frame = octets(text);
    let parts = anatomy(link, &frame, &[]);
    is_whole(&frame, &parts);
    for (place, name, value) in expected {
        let part = parts.iter().find(|part| part.octets == *place).unwrap_or_else(|| panic!("{place:?} in {parts:#?}"));
        if !name.starts_with("name") {
            assert_eq!(part.name, *name);
        }
        assert!(part.value.contains(value), "{part:?}");
    }
}

/// In cut and corrupted frames every byte still belongs to exactly one part.
#[rstest]
#[case(LinkType::ETHERNET, DCP)]
#[case(LinkType::ETHERNET, RT)]
#[case(LinkType::ETHERNET, ABORT)]
#[case(LinkType::PROFIBUS, SET_PRM)]
fn damaged_frames_have_parts_too(#[case] link: LinkType, #[case] text: &str) {
    let frame = octets(text);
    for end in 0..frame.len() {
        is_whole(&frame[..end], &anatomy(link, &frame[..end], &[]));
    }
    for bit in 0..frame.len() * 8 {
        let mut frame = frame.clone();
        frame[bit / 8] ^= 1 << (bit % 8);
        is_whole(&frame, &anatomy(link, &frame, &[]));
    }
}
