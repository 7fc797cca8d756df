//! RPC calls in fragmented IP datagrams: a reassembled datagram is judged like an unfragmented one, an incomplete one is reported and
//! blamed on no station. The fragments are hand-made (RFC 791, 3.1 and 3.2).

use crate::built_in::manuals;
use crate::common::handmade::ConnectionFrames;
use encspec::replay::{CaptureEvent, CaptureReport, EventKind, IpReassembler, Reassembled, capture};
use rstest::rstest;
use station::{Duration, Time};
use virtual_wire::PcapngWriter;
use virtual_wire::capture::LinkType;
use wire::datagram::Datagram;
use wire::profinet::status::{ErrorCode, PnioStatus, RecordError};

const REFUSED: PnioStatus = PnioStatus::record(ErrorCode::READ_RESPONSE, RecordError::INVALID_INDEX);

const LINK: usize = 14;
const HEADER: usize = 20;

type TimedFrames = Vec<(Time, Vec<u8>)>;

fn is_packet(frame: &[u8]) -> bool {
    frame.get(12..14) == Some(&[8, 0])
}

/// A fragment: the headers of `frame` followed by `payload`.
fn fragment(frame: &[u8], identification: u16, offset: usize, more: bool, payload: &[u8]) -> Vec<u8> {
    assert_eq!(offset % 8, 0);
    let mut made = frame[..LINK + HEADER].to_vec();
    let mut put = |at: usize, value: u16| made[LINK + at..LINK + at + 2].copy_from_slice(&value.to_be_bytes());
    put(2, (HEADER + payload.len()) as u16);
    put(4, identification);
    put(6, u16::from(more) << 13 | (offset / 8) as u16);
    put(10, 0);
    let sum: u32 = made[LINK..].chunks(2).map(|pair| u32::from(u16::from_be_bytes([pair[0], pair[1]]))).sum();
    let sum = (sum & 0xFFFF) + (sum >> 16);
    let sum = !(((sum & 0xFFFF) + (sum >> 16)) as u16);
    made[LINK + 10..LINK + 12].copy_from_slice(&sum.to_be_bytes());
    made.extend_from_slice(payload);
    made.resize(made.len().max(60), 0);
    made
}

/// The payload of an IPv4 packet, without the padding of the frame.
fn payload(frame: &[u8]) -> &[u8] {
    let total = usize::from(u16::from_be_bytes([frame[LINK + 2], frame[LINK + 3]]));
    &frame[LINK + HEADER..LINK + total]
}

/// Splits a frame into fragments of at most `most` bytes. A shorter frame stays whole.
fn cut(frame: &[u8], identification: u16, most: usize) -> Vec<Vec<u8>> {
    let payload = payload(frame);
    if payload.len() <= most {
        return vec![frame.to_vec()];
    }
    let pieces = payload.len().div_ceil(most);
    let piece =
        |(index, octets): (usize, &[u8])| fragment(frame, identification, index * most, index + 1 < pieces, octets);
    payload.chunks(most).enumerate().map(piece).collect()
}

/// A connection with a refused record, cyclic data and a release.
fn line() -> ConnectionFrames {
    let mut line = ConnectionFrames::new();
    line.start().exchange(5);
    line.write(&[(1, 2, 0xBF00, &[1; 100])], false, &[PnioStatus::OK]);
    line.read(0xB000, Err(REFUSED), false);
    line.read(0xAFF0, Ok(&[1; 54]), false);
    line.exchange(5).release();
    line
}

fn replay(frames: &TimedFrames) -> CaptureReport {
    let mut writer = PcapngWriter::new(Vec::new(), "made by a test").expect("a vector takes all");
    let interface = writer.interface("wire", LinkType::ETHERNET).expect("a vector takes all");
    for (time, frame) in frames {
        writer.packet(interface, *time, frame, None).expect("a vector takes all");
    }
    let file = writer.finish().expect("a vector takes all");
    capture("made", &file[..], manuals()).expect("a capture")
}

fn unreadable(report: &CaptureReport) -> Vec<&CaptureEvent> {
    report.events.iter().filter(|event| event.kind == EventKind::Unreadable).collect()
}

type FragmentList = Vec<Vec<u8>>;

fn as_sent(pieces: FragmentList) -> FragmentList {
    pieces
}

fn reversed(pieces: FragmentList) -> FragmentList {
    pieces.into_iter().rev().collect()
}

fn last_first(mut pieces: FragmentList) -> FragmentList {
    pieces.rotate_right(1);
    pieces
}

/// A mirror port shows every frame twice.
fn twice(pieces: FragmentList) -> FragmentList {
    pieces.into_iter().flat_map(|piece| [piece.clone(), piece]).collect()
}

/// The second fragment begins with the last eight bytes of the first.
fn overlapping(mut pieces: FragmentList) -> FragmentList {
    if let [first, second, ..] = &mut pieces[..] {
        let offset = payload(first).len() - 8;
        let octets = [&payload(first)[offset..], payload(second)].concat();
        let identification = u16::from_be_bytes([second[LINK + 4], second[LINK + 5]]);
        *second = fragment(second, identification, offset, second[LINK + 6] & 0x20 != 0, &octets);
    }
    pieces
}

fn tagged(mut pieces: FragmentList) -> FragmentList {
    for piece in &mut pieces {
        piece.splice(12..12, [0x81, 0x00, 0xC0, 0x00]);
    }
    pieces
}

/// Compares a capture with fragments to one with the whole datagram in place of the completing fragment and unrelated frames in place
/// of the others: the reports are equal. The completing fragment is `before_the_end` fragments before the last.
#[rstest]
#[case::as_sent(as_sent, 0)]
#[case::reversed(reversed, 0)]
#[case::last_first(last_first, 0)]
#[case::twice(twice, 1)]
#[case::overlapping(overlapping, 0)]
#[case::tagged(tagged, 0)]
fn a_reassembled_datagram_is_judged_like_a_whole_one(
    #[case] order: fn(FragmentList) -> FragmentList,
    #[case] before_the_end: usize,
    #[values(64, 120, 200)] most: usize,
) {
    let (mut whole, mut in_fragments): (TimedFrames, TimedFrames) = (Vec::new(), Vec::new());
    let mut with_fragments = 0;
    for (number, (time, frame)) in line().frames.into_iter().enumerate() {
        let mut pieces = if is_packet(&frame) { cut(&frame, number as u16, most) } else { vec![frame.clone()] };
        let mut completing = 0;
        if pieces.len() > 1 {
            with_fragments += 1;
            pieces = order(pieces);
            completing = pieces.len() - 1 - before_the_end;
        }
        for (index, piece) in pieces.into_iter().enumerate() {
            let other = [&frame[..12], &[0x12, 0x34], &[0; 46]].concat();
            whole.push((time, if index == completing { frame.clone() } else { other }));
            in_fragments.push((time, piece));
        }
    }
    assert!(with_fragments >= 3, "only {with_fragments} datagrams were cut");
    let (mut whole, mut in_fragments) = (replay(&whole), replay(&in_fragments));
    assert!(whole.findings.iter().any(|finding| finding.text.contains("0xB000")), "{:#?}", whole.findings);
    assert_eq!(unreadable(&in_fragments), [] as [&CaptureEvent; 0]);
    for finding in whole.findings.iter_mut().chain(&mut in_fragments.findings) {
        // The frames around a finding differ.
        (finding.context.before, finding.context.after) = (Vec::new(), Vec::new());
    }
    assert_eq!(in_fragments, whole);
}

/// The response to the Connect is incomplete: the device is not blamed, not even for a missing response.
#[rstest]
#[case::the_first(0)]
#[case::one_in_the_middle(1)]
#[case::the_last(99)]
fn an_incomplete_datagram_is_blamed_on_no_station(#[case] missing: usize) {
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    let (time, response) = line.frames.pop().expect("the response");
    let mut pieces = cut(&response, 7, 64);
    pieces.remove(missing.min(pieces.len() - 1));
    let last = line.frames.len() + pieces.len();
    line.frames.extend(pieces.into_iter().map(|piece| (time, piece)));
    // The controller repeats its call, gives up and requests another connection.
    let request = line.frames[0].1.clone();
    for again in 1..=3 {
        line.frames.push((time + Duration::from_secs(2 * again), request.clone()));
    }
    line.now = time + Duration::from_secs(10);
    line.start().exchange(5);
    let report = replay(&line.frames);
    let events = unreadable(&report);
    if missing == 0 {
        assert_eq!(events, [] as [&CaptureEvent; 0], "the ports are unknown");
    } else {
        let [event] = events[..] else { panic!("one event: {events:#?}") };
        assert_eq!(event.frame, last as u64);
        let begin =
            "IPv4: datagram 0x0007 from 192.168.0.10 to 192.168.0.1, fragmented since frame 2, cannot be reassembled: ";
        assert!(event.text.starts_with(begin), "{}", event.text);
        let gap = if missing == 1 { "bytes 64 to 127 missing; the rest did not follow" } else { "what follows byte" };
        assert!(event.text.contains(gap), "{}", event.text);
        let accused: Vec<_> = report.findings.iter().filter(|finding| finding.frame <= last as u64).collect();
        assert!(accused.is_empty(), "{accused:#?}");
    }
    assert_eq!(report.ars.last().map(|ar| ar.stage), Some("ready"));
}

/// A UDP datagram with `length` bytes of payload, from port 34964.
fn datagram(length: usize, fill: u8) -> Vec<u8> {
    let frame = line().frames[0].1.clone();
    let mut udp = vec![0x88, 0x94, 0x88, 0x94];
    udp.extend_from_slice(&((8 + length) as u16).to_be_bytes());
    udp.extend_from_slice(&[0; 2]);
    udp.extend((0..length).map(|at| fill ^ at as u8));
    // The pseudo header: addresses, protocol, length of UDP.
    let mut pseudo = frame[LINK + 12..LINK + 20].to_vec();
    pseudo.extend_from_slice(&[0, 17]);
    pseudo.extend_from_slice(&((8 + length) as u16).to_be_bytes());
    let all = [&pseudo[..], &udp, &[0][..udp.len() % 2]].concat();
    let mut sum: u32 = all.chunks(2).map(|pair| u32::from(u16::from_be_bytes([pair[0], pair[1]]))).sum();
    while sum > 0xFFFF {
        sum = (sum & 0xFFFF) + (sum >> 16);
    }
    udp[6..8].copy_from_slice(&(!(sum as u16)).to_be_bytes());
    let mut made = fragment(&frame, 0, 0, false, &[]);
    made.truncate(LINK + HEADER);
    made[LINK + 2..LINK + 4].copy_from_slice(&((HEADER + udp.len()) as u16).to_be_bytes());
    made.extend_from_slice(&udp);
    made
}

fn at(millis: u64) -> Time {
    Time::from_nanos(millis * 1_000_000)
}

fn take(reassembler: &mut IpReassembler, frames: &[Vec<u8>], millis: u64) -> Vec<Reassembled> {
    let number = |index: usize| 1 + index as u64;
    frames.iter().enumerate().map(|(index, frame)| reassembler.take(number(index), at(millis), frame)).collect()
}

#[test]
fn the_longest_datagram_and_one_that_is_too_long() {
    let mut reassembler = IpReassembler::default();
    let longest = datagram(65_507, 1);
    let pieces = cut(&longest, 1, 1_480);
    let took = take(&mut reassembler, &pieces, 0);
    assert_eq!(took.last(), Some(&Reassembled::Whole));
    assert!(took[..took.len() - 1].iter().all(|one| *one == Reassembled::Part));
    let parsed = Datagram::parse(reassembler.whole()).expect("a datagram");
    assert!(parsed.checksum_ok());
    assert_eq!(parsed.payload, &payload(&longest)[8..]);
    let too_long = fragment(&longest, 2, 65_512, false, &[0; 8]);
    assert_eq!(reassembler.take(50, at(0), &too_long), Reassembled::Untouched);
}

#[test]
fn an_identification_may_be_reused() {
    let mut reassembler = IpReassembler::default();
    for round in 0..5 {
        let sent = datagram(300, round);
        let took = take(&mut reassembler, &cut(&sent, 9, 160), u64::from(round) * 10);
        assert_eq!(took, [Reassembled::Part, Reassembled::Whole], "round {round}");
        assert_eq!(payload(reassembler.whole()), payload(&sent));
    }
    assert_eq!(reassembler.lost().count(), 0);
}

#[rstest]
#[case::too_late(1_001, "bytes 160 to")]
#[case::in_time(1_000, "")]
fn fragments_expire_after_a_second(#[case] later: u64, #[case] why: &str) {
    let mut reassembler = IpReassembler::default();
    let pieces = cut(&datagram(500, 1), 9, 160);
    take(&mut reassembler, &[pieces[0].clone(), pieces[2].clone(), pieces[3].clone()], 0);
    let took = reassembler.take(4, at(later), &pieces[1]);
    let lost: Vec<_> = reassembler.lost().collect();
    if why.is_empty() {
        assert_eq!((took, lost.len()), (Reassembled::Whole, 0));
    } else {
        assert_eq!((took, lost.len()), (Reassembled::Part, 1));
        assert!(lost[0].why.contains(why) && lost[0].frame == 3, "{:?}", lost[0]);
    }
}

/// Contradictory fragments are not combined.
#[test]
fn fragments_that_contradict_each_other_are_not_mixed() {
    let (one, other) = (cut(&datagram(300, 1), 9, 160), cut(&datagram(300, 2), 9, 160));
    let mut reassembler = IpReassembler::default();
    assert_eq!(take(&mut reassembler, &[one[0].clone(), other[0].clone()], 0), [Reassembled::Part; 2]);
    let lost: Vec<_> = reassembler.lost().collect();
    assert!(lost.len() == 1 && lost[0].why.contains("contradict"), "{lost:?}");
    // The later datagram can still be completed.
    assert_eq!(reassembler.take(3, at(1), &other[1]), Reassembled::Whole);
    assert_eq!(payload(reassembler.whole()), payload(&datagram(300, 2)));

    // Halves of two datagrams with the same identification: only the checksum shows it.
    let mut reassembler = IpReassembler::default();
    assert_eq!(take(&mut reassembler, &[one[0].clone(), other[1].clone()], 0), [Reassembled::Part; 2]);
    let lost: Vec<_> = reassembler.lost().collect();
    assert!(lost.len() == 1 && lost[0].why.contains("checksum"), "{lost:?}");
}

#[test]
fn fragments_of_other_stations_and_vlans_are_kept_apart() {
    let pieces = cut(&datagram(300, 1), 9, 160);
    let change = |at: usize| {
        let mut other = pieces[1].clone();
        other[at] ^= 1;
        other
    };
    let mut other_vlan = pieces[1].clone();
    other_vlan.splice(12..12, [0x81, 0x00, 0x00, 0x05]);
    // A MAC address, the identification, both IP addresses.
    let others = [change(3), change(LINK + 5), change(LINK + 15), change(LINK + 19), other_vlan];
    let mut reassembler = IpReassembler::default();
    assert_eq!(reassembler.take(1, at(0), &pieces[0]), Reassembled::Part);
    assert_eq!(take(&mut reassembler, &others, 0), [Reassembled::Part; 5]);
    assert_eq!(reassembler.take(7, at(0), &pieces[1]), Reassembled::Whole);
}

/// Memory is bounded: the oldest incomplete datagram is dropped and reported.
#[test]
fn the_number_of_incomplete_datagrams_is_bounded() {
    let mut reassembler = IpReassembler::default();
    let whole = datagram(3_000, 1);
    for number in 0..10_000_u64 {
        let begin = fragment(&whole, number as u16, 0, true, &payload(&whole)[..1_480]);
        assert_eq!(reassembler.take(number + 1, at(0), &begin), Reassembled::Part);
        assert_eq!(reassembler.lost().count(), usize::from(number >= 32), "datagram {number}");
    }
    reassembler.interrupt();
    assert_eq!(reassembler.lost().count(), 32);
}

/// Arbitrary fragments do not cause a panic.
#[test]
fn arbitrary_fragments_do_not_panic() {
    let mut reassembler = IpReassembler::default();
    let frame = datagram(100, 1);
    let octets: Vec<u8> = (0..4_096_u32).map(|at| (at / 8) as u8).collect();
    let mut state = 1_u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as usize % below
    };
    let mut wholes = 0;
    for number in 0..200_000_u64 {
        let (offset, length) = (next(40) * 8, next(60) * 8 + if next(9) == 0 { 3 } else { 0 });
        // Mostly consistent bytes, and a checksum that was not computed.
        let mut piece = octets[offset..offset + length].to_vec();
        if next(50) == 0 {
            piece.iter_mut().for_each(|octet| *octet ^= 0x55);
        }
        let made = fragment(&frame, next(4) as u16, offset, next(3) > 0, &piece);
        let kept = next(made.len() * 20).min(made.len());
        if reassembler.take(number + 1, at(number / 50), &made[..kept]) == Reassembled::Whole {
            wholes += 1;
            let whole = payload(reassembler.whole());
            assert!(whole.len() < 800);
        }
    }
    assert!(wholes > 100, "only {wholes} were whole");
    assert!(reassembler.lost().count() > 0);
}

/// The report depends only on the capture.
#[test]
fn two_replays_of_a_capture_with_fragments_are_equal() {
    let mut frames: TimedFrames = Vec::new();
    for (number, (time, frame)) in line().frames.into_iter().enumerate() {
        let pieces = if is_packet(&frame) { cut(&frame, number as u16 % 3, 64) } else { vec![frame] };
        let lossy = pieces.into_iter().enumerate().filter(|(index, _)| number % 4 != 2 || *index != 1);
        frames.extend(lossy.map(|(_, piece)| (time, piece)));
    }
    let (one, two) = (replay(&frames), replay(&frames));
    assert_eq!(one, two);
    assert!(!unreadable(&one).is_empty());
}
