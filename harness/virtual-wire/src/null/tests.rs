use super::*;
use crate::wire::VirtualWire;

const VICTIM: [u8; 6] = [2, 0, 0, 0, 0, 1];
const OWN: [u8; 6] = [2, 0, 0, 0, 1, 0];

fn frames(out: &Outbox) -> Vec<Vec<u8>> {
    out.frames().map(<[u8]>::to_vec).collect()
}

#[test]
fn the_reflector_returns_the_frame_unchanged_and_with_exchanged_addresses() {
    let mut out = Outbox::new();
    Reflector.receive(Time::ZERO, &[1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 0x88, 0x92, 5], &mut out);
    let sent = frames(&out);
    assert_eq!(sent[0], [1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 0x88, 0x92, 5]);
    assert_eq!(sent[1], [2, 2, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1, 0x88, 0x92, 5]);
    assert_eq!(sent.len(), 2);
}

#[test]
fn the_babbler_sends_valid_ethernet_of_every_kind_to_its_victim_at_its_rate() {
    let babble = |seed| {
        let mut babbler = Babbler::new(seed, Duration::from_millis(1), OWN, VICTIM);
        let mut wire = VirtualWire::new();
        let mut seen = Vec::new();
        wire.run(&mut [&mut babbler], Time::from_nanos(999_500_000), &mut |frame| seen.push(frame.frame.to_vec()));
        assert_eq!(wire.violations(), []);
        seen
    };
    let seen = babble(7);
    assert_eq!(seen.len(), 1_000);
    assert!(seen.iter().all(|frame| frame[..6] == VICTIM && frame[6..12] == OWN));
    for kind in [&[0x88, 0x92, 0x80][..], &[0x81, 0x00], &[0x88, 0x92, 0xFE, 0xFF], &[0x88, 0x92, 0xFE, 0xFD], &[8, 6]]
    {
        assert!(seen.iter().any(|frame| frame[12..].starts_with(kind)), "no frame with {kind:02X?}");
    }
    assert_eq!(seen, babble(7));
    assert_ne!(seen, babble(8));
}

#[test]
fn a_station_that_dies_sends_its_last_frame_and_then_nothing() {
    let mut dying = DiesAfter::new(Reflector, 3);
    let mut out = Outbox::new();
    dying.receive(Time::ZERO, &[0; 60], &mut out);
    assert!(!dying.is_dead());
    dying.receive(Time::ZERO, &[1; 60], &mut out);
    dying.receive(Time::ZERO, &[2; 60], &mut out);
    assert!(dying.is_dead());
    assert_eq!(frames(&out), [vec![0; 60], vec![0; 60], vec![1; 60]]);

    let mut stillborn = DiesAfter::new(Babbler::new(1, Duration::from_millis(1), OWN, VICTIM), 0);
    assert_eq!(stillborn.deadline(), None);
    out.clear();
    stillborn.wake(Time::ZERO, &mut out);
    assert!(out.is_empty());
}
