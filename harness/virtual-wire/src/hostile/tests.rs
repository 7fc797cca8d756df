use super::*;
use crate::null::Silent;

fn spoilt(name: &str, frames: &[&[u8]]) -> Vec<Vec<u8>> {
    let how = HOSTILE_DEVICES.iter().find(|of| of.name == name).expect("a hostile device");
    let mut device = SpoiltDevice::new(Silent, how);
    let mut out = Outbox::new();
    for frame in frames {
        device.sent.push(frame);
        device.pass_on(Time::ZERO, &mut out);
    }
    out.frames().map(<[u8]>::to_vec).collect()
}

/// A DCP answer with the name `abc` between two other blocks.
const ANSWER: [u8; 46] = [
    2, 0, 0, 0, 0, 1, 2, 0, 0, 0, 1, 0, 0x88, 0x92, 0xFE, 0xFF, 5, 1, 0, 0, 0, 7, 0, 0, 0, 20, 2, 4, 0, 4, 0, 0, 1, 0,
    2, 2, 0, 5, 0, 0, b'a', b'b', b'c', 0, 0, 0,
];

#[test]
fn names_are_unique_and_words() {
    for (index, device) in HOSTILE_DEVICES.iter().enumerate() {
        assert!(HOSTILE_DEVICES[..index].iter().all(|before| before.name != device.name), "{}", device.name);
        assert!(device.name.bytes().all(|octet| octet.is_ascii_lowercase() || octet == b'-'), "{}", device.name);
    }
}

#[test]
fn a_name_is_replaced_with_the_lengths_around_it() {
    let [frame] = &spoilt("other-device", &[&ANSWER[..44]])[..] else { panic!("one frame") };
    assert_eq!(frame[24..26], [0, 28]);
    assert_eq!(frame[34..40], [2, 2, 0, 16, 0, 0]);
    assert_eq!(&frame[40..], b"another-device");
}

#[test]
fn only_the_frames_of_its_kind_are_spoilt() {
    let cyclic = [&ANSWER[..14], &[0xC0, 0x00, 1, 2, 3, 0x80, 0, 32, 0x35, 0]].concat();
    assert_eq!(spoilt("dcp-cut", &[&cyclic, &ANSWER]), [cyclic.clone(), ANSWER[..20].to_vec()]);
    assert_eq!(spoilt("transfer-status", &[&cyclic])[0][20..], [0, 32, 0x35, 1]);
}

#[test]
fn the_checksum_of_a_telegram_is_right_unless_it_is_what_is_wrong() {
    let telegram = [0x68, 0x05, 0x05, 0x68, 0x01, 0x03, 0x08, 0x11, 0x22, 0x3F, 0x16];
    assert_eq!(spoilt("dp-sender", &[&telegram])[0][5..], [0x55, 0x08, 0x11, 0x22, 0x91, 0x16]);
    assert_eq!(spoilt("dp-checksum", &[&telegram])[0][9..], [0x5A, 0x16]);
}
