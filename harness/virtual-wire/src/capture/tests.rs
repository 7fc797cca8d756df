//! Small files built byte by byte from the descriptions of the two formats.

use std::io::{self, Read};

use rstest::rstest;
use station::Time;

use super::*;
use crate::damage::{every_flipped_bit, every_prefix};

#[derive(Clone, Debug, PartialEq, Eq)]
struct PacketCopy {
    number: usize,
    nanos: u64,
    place: (u32, u32),
    link_type: u16,
    captured: Vec<u8>,
    original: u32,
    comment: Option<String>,
}

/// The packets before the first damage, those after it, and all damage.
#[derive(Debug, Default)]
struct CaptureContent {
    before: Vec<PacketCopy>,
    after: Vec<PacketCopy>,
    damage: Vec<(u64, String)>,
}

fn read(file: &[u8]) -> CaptureContent {
    let mut content = CaptureContent::default();
    let Ok(mut reader) = CaptureReader::new(file) else { return content };
    let mut items = 0;
    while let Some(item) = reader.next() {
        items += 1;
        assert!(items <= file.len(), "more items than bytes");
        match item {
            CaptureItem::Damage(damage) => content.damage.push((damage.at, damage.what)),
            CaptureItem::Packet(packet) => {
                let kept = PacketCopy {
                    number: packet.number,
                    nanos: packet.time.as_nanos(),
                    place: (packet.section, packet.interface),
                    link_type: packet.link_type.0,
                    captured: packet.captured.to_vec(),
                    original: packet.original_length,
                    comment: packet.comment.map(|comment| comment.into_owned()),
                };
                if content.damage.is_empty() { content.before.push(kept) } else { content.after.push(kept) }
            }
        }
    }
    content
}

/// Integers in the byte order of a file under construction.
#[derive(Clone, Copy, Debug, PartialEq)]
enum TestByteOrder {
    Little,
    Big,
}

impl TestByteOrder {
    fn half(self, value: u16) -> [u8; 2] {
        if self == TestByteOrder::Big { value.to_be_bytes() } else { value.to_le_bytes() }
    }

    fn words(self, values: &[u32]) -> Vec<u8> {
        let octets = |value: &u32| if self == TestByteOrder::Big { value.to_be_bytes() } else { value.to_le_bytes() };
        values.iter().flat_map(octets).collect()
    }

    fn block(self, block_type: u32, content: &[u8]) -> Vec<u8> {
        let mut content = content.to_vec();
        content.resize(content.len().next_multiple_of(4), 0);
        let length = content.len() as u32 + 12;
        [self.words(&[block_type, length]), content, self.words(&[length])].concat()
    }

    fn option(self, code: u16, value: &[u8]) -> Vec<u8> {
        let mut octets = [self.half(code), self.half(value.len() as u16)].concat();
        octets.extend_from_slice(value);
        octets.resize(octets.len().next_multiple_of(4), 0);
        octets
    }

    fn section(self) -> Vec<u8> {
        let version = [self.half(1), self.half(0)].concat();
        self.block(0x0A0D_0D0A, &[self.words(&[0x1A2B_3C4D]), version, self.words(&[!0, !0])].concat())
    }

    fn interface(self, link_type: u16, snap: u32, options: &[u8]) -> Vec<u8> {
        let link = [self.half(link_type), self.half(0)].concat();
        self.block(1, &[link, self.words(&[snap]), options.to_vec()].concat())
    }

    fn packet(self, interface: u32, low: u32, octets: &[u8], original: u32, options: &[u8]) -> Vec<u8> {
        let mut content = self.words(&[interface, 1, low, octets.len() as u32, original]);
        content.extend_from_slice(octets);
        content.resize(content.len().next_multiple_of(4), 0);
        content.extend_from_slice(options);
        self.block(6, &content)
    }

    fn record(self, seconds: u32, fraction: u32, octets: &[u8], original: u32) -> Vec<u8> {
        [self.words(&[seconds, fraction, octets.len() as u32, original]), octets.to_vec()].concat()
    }

    /// A file header and six records.
    fn pcap(self, magic: u32) -> Vec<Vec<u8>> {
        let version = [self.half(2), self.half(4)].concat();
        let header = [self.words(&[magic]), version, self.words(&[0, 0, 262_144, 1])].concat();
        let mut parts = vec![header, self.record(1_000, 0, &[9; 10], 1_514)];
        parts.extend((1..=5u8).map(|n| self.record(1_000 + u32::from(n), 999_999, &[n; 20], 20)));
        parts
    }

    /// Two sections; every kind of block that holds a packet, and some that hold none.
    fn pcapng(self) -> Vec<Vec<u8>> {
        let nanoseconds = self.option(9, &[9]);
        let comments = [
            self.option(1, b"first"),
            self.option(2, &[0; 4]),
            self.option(1, b"second"),
            vec![0; 4],
            self.option(1, b"beyond the end"),
        ];
        let old = [self.half(1), self.half(77)].concat();
        vec![
            self.section(),
            self.interface(1, 8, &[]),
            self.interface(257, 0, &nanoseconds),
            self.packet(0, 7, &[1; 5], 5, &comments.concat()),
            self.block(4, &self.words(&[0])),
            self.block(0x4242, b"who knows?"),
            self.block(0xBAD, &self.words(&[32_473])),
            self.packet(1, 7, &[2; 6], 100, &[]),
            self.block(3, &[self.words(&[9]), vec![3; 8]].concat()),
            self.block(2, &[old, self.words(&[1, 7, 2, 2]), vec![4; 2]].concat()),
            self.section(),
            self.interface(1, 0, &[]),
            self.packet(0, 8, &[5; 4], 4, &[]),
        ]
    }
}

fn kept(number: usize, nanos: u64, captured: &[u8], original: u32) -> PacketCopy {
    PacketCopy { number, nanos, place: (1, 0), link_type: 1, captured: captured.to_vec(), original, comment: None }
}

#[rstest]
#[case::microseconds(0xA1B2_C3D4, 1_000)]
#[case::nanoseconds(0xA1B2_3C4D, 1)]
fn pcap_is_read_in_both_byte_orders_and_units(
    #[case] magic: u32,
    #[case] unit: u64,
    #[values(TestByteOrder::Little, TestByteOrder::Big)] end: TestByteOrder,
) {
    let content = read(&end.pcap(magic).concat());
    assert_eq!(content.damage, []);
    assert_eq!(content.before.len(), 6);
    assert_eq!(content.before[0], kept(1, 1_000_000_000_000, &[9; 10], 1_514));
    assert_eq!(content.before[5], kept(6, 1_005_000_000_000 + 999_999 * unit, &[5; 20], 20));
}

#[rstest]
fn pcapng_is_read_with_all_its_kinds_of_packets(
    #[values(TestByteOrder::Little, TestByteOrder::Big)] end: TestByteOrder,
) {
    let content = read(&end.pcapng().concat());
    assert_eq!(content.damage, []);
    let ticks = 0x1_0000_0007;
    let expected = [
        PacketCopy { comment: Some("first\nsecond".to_string()), ..kept(1, ticks * 1_000, &[1; 5], 5) },
        // Number 2 is the custom block, which Wireshark counts.
        PacketCopy { place: (1, 1), link_type: 257, ..kept(3, ticks, &[2; 6], 100) },
        kept(4, 0, &[3; 8], 9),
        PacketCopy { place: (1, 1), link_type: 257, ..kept(5, ticks, &[4; 2], 2) },
        PacketCopy { place: (2, 0), ..kept(6, (ticks + 1) * 1_000, &[5; 4], 4) },
    ];
    assert_eq!(content.before, expected);
}

#[rstest]
#[case::pcap(TestByteOrder::Little.pcap(0xA1B2_C3D4))]
#[case::pcap_big_endian(TestByteOrder::Big.pcap(0xA1B2_3C4D))]
#[case::pcapng(TestByteOrder::Little.pcapng())]
#[case::pcapng_big_endian(TestByteOrder::Big.pcapng())]
fn a_prefix_yields_its_complete_packets_and_reports_the_cut(#[case] parts: Vec<Vec<u8>>) {
    let file = parts.concat();
    let whole = read(&file).before;
    every_prefix(&file, |prefix| {
        let content = read(prefix);
        let (mut start, mut rest) = (0, &parts[..]);
        while let [part, behind @ ..] = rest
            && start + part.len() <= prefix.len()
        {
            (start, rest) = (start + part.len(), behind);
        }
        let read_whole = parts.len() - rest.len();
        assert!(whole.starts_with(&content.before) && content.after.is_empty(), "{} bytes", prefix.len());
        let damage: Vec<u64> = content.damage.iter().map(|(at, _)| *at).collect();
        if prefix.len() < 4 {
            assert!(CaptureReader::new(prefix).is_err());
        } else if start == prefix.len() && read_whole > 1 {
            assert_eq!(damage, [], "cut between two parts at {start}");
        } else if start == prefix.len() {
            assert!(content.damage[0].1.contains("holds no packet"), "{:?}", content.damage);
        } else {
            assert_eq!(damage, [start as u64], "cut at {}: {:?}", prefix.len(), content.damage);
        }
    });
}

#[rstest]
#[case::pcap(TestByteOrder::Little.pcap(0xA1B2_C3D4))]
#[case::pcap_big_endian(TestByteOrder::Big.pcap(0xA1B2_3C4D))]
#[case::pcapng(TestByteOrder::Little.pcapng())]
#[case::pcapng_big_endian(TestByteOrder::Big.pcapng())]
fn a_flipped_bit_leaves_the_packets_before_it_alone(#[case] parts: Vec<Vec<u8>>) {
    let file = parts.concat();
    let starts: Vec<usize> = (0..parts.len()).map(|count| parts[..count].iter().map(Vec::len).sum()).collect();
    every_flipped_bit(&file, |index, damaged| {
        let start = starts.iter().rfind(|start| **start <= index).expect("the first part starts at 0");
        let undamaged = read(&file[..*start]).before;
        let content = read(damaged);
        assert!(content.before.starts_with(&undamaged), "byte {index}: {:?}", content.damage);
    });
}

/// The first byte of each packet, with or without damage.
fn firsts(content: &CaptureContent) -> Vec<u8> {
    content.before.iter().chain(&content.after).map(|packet| packet.captured[0]).collect()
}

#[rstest]
// The other length gives the length of the record: no packet is lost.
#[case::captured_length_huge(3, 8, &[0xFF, 0xFF, 0xFF, 0x7F], &[9, 1, 2, 3, 4, 5], "2147483647 bytes, taken as 20")]
#[case::captured_length_huge_at_the_end(6, 8, &[0xFF, 0xFF, 0xFF, 0x7F], &[9, 1, 2, 3, 4, 5], "taken as 20")]
#[case::both_lengths_huge(3, 8, &[0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF], &[9, 1, 3, 4, 5], "; 36 bytes skipped")]
#[case::zeros(3, 0, &[0; 36], &[9, 1, 3, 4, 5], "0 bytes; 36 bytes skipped")]
#[case::reaches_into_the_next(3, 8, &[30], &[9, 1, 3, 4, 5], "reaches into the next ones; 36 bytes skipped")]
#[case::reaches_beyond_the_end(3, 9, &[0xFF], &[9, 1, 3, 4, 5], "beyond the end of the file; 36 bytes skipped")]
// The short record is read as a sliced one; its remaining bytes are skipped.
#[case::too_short(3, 8, &[11], &[9, 1, 2, 3, 4, 5], "; 9 bytes skipped")]
fn pcap_resumes_after_a_damaged_record(
    #[case] record: usize,
    #[case] at: usize,
    #[case] octets: &[u8],
    #[case] packets: &[u8],
    #[case] what: &str,
) {
    let mut parts = TestByteOrder::Little.pcap(0xA1B2_C3D4);
    parts[record][at..at + octets.len()].copy_from_slice(octets);
    let content = read(&parts.concat());
    assert_eq!(firsts(&content), packets);
    assert_eq!(content.damage.len(), 1, "{:?}", content.damage);
    assert!(content.damage[0].1.ends_with(what), "{:?}", content.damage);
    let numbers: Vec<usize> = content.before.iter().chain(&content.after).map(|packet| packet.number).collect();
    assert_eq!(numbers, (1..=packets.len()).collect::<Vec<_>>());
}

#[rstest]
#[case::trailer(3, -4, &[99], &[1, 2, 3, 4, 5], "and 99 at its end, taken as 96")]
#[case::trailer_of_the_last(12, -4, &[99], &[1, 2, 3, 4, 5], "and 99 at its end, taken as 36")]
#[case::length(3, 4, &[99], &[2, 3, 4, 5], "; 96 bytes skipped")]
#[case::length_beyond_the_end(3, 5, &[9], &[2, 3, 4, 5], "beyond the end of the file; 96 bytes skipped")]
#[case::length_of_nothing(3, 4, &[0], &[2, 3, 4, 5], "claims 0 bytes; 96 bytes skipped")]
#[case::captured_length(3, 20, &[99], &[2, 3, 4, 5], "a packet claims 99 bytes in a block of 96")]
#[case::captured_length_of_an_old_packet(9, 20, &[99], &[1, 2, 3, 5], "a packet claims 99 bytes in a block of 36")]
#[case::interface(3, 8, &[2], &[2, 3, 4, 5], "packets of interface 2 are left out: no block of the section describes it")]
#[case::byte_order_mark(0, 8, &[0], &[1, 2, 3, 4, 5], "")]
fn pcapng_resumes_after_a_damaged_block(
    #[case] block: usize,
    #[case] at: isize,
    #[case] octets: &[u8],
    #[case] packets: &[u8],
    #[case] what: &str,
) {
    let mut parts = TestByteOrder::Little.pcapng();
    let at = at.rem_euclid(parts[block].len() as isize) as usize;
    parts[block][at..at + octets.len()].copy_from_slice(octets);
    let start: usize = parts[..block].iter().map(Vec::len).sum();
    let content = read(&parts.concat());
    assert_eq!(firsts(&content), packets);
    assert_eq!(content.damage.len(), 1, "{:?}", content.damage);
    assert_eq!(content.damage[0].0, start as u64);
    assert!(content.damage[0].1.ends_with(what), "{:?}", content.damage);
}

#[test]
fn an_interface_without_description_is_reported_once_in_each_section() {
    let mut parts = TestByteOrder::Little.pcapng();
    for block in [3, 7, 12] {
        parts[block][8] = 2;
    }
    let content = read(&parts.concat());
    assert_eq!(firsts(&content), [3, 4]);
    assert_eq!(content.damage.len(), 2, "{:?}", content.damage);
}

#[rstest]
#[case::empty(&[], "is empty, a capture begins with a header")]
#[case::gzip(&[0x1F, 0x8B, 8, 0], "cannot be read: the compressed file is damaged at or before byte 4: it ends too soon")]
#[case::text(b"device: xac77", "is neither pcap nor pcapng: it begins with 64 65 76 69")]
fn a_file_that_is_not_a_capture_is_refused_in_one_sentence(#[case] file: &[u8], #[case] sentence: &str) {
    let refused = CaptureReader::new(file).expect_err("no capture");
    assert_eq!(refused.to_string(), sentence);
}

/// Returns the bytes one by one and then an error.
struct Dripping<'a>(&'a [u8]);

impl Read for Dripping<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match (self.0.split_first(), into.first_mut()) {
            (Some((first, rest)), Some(place)) => {
                *place = *first;
                self.0 = rest;
                Ok(1)
            }
            _ => Err(io::Error::other("the disk is gone")),
        }
    }
}

#[test]
fn a_read_error_is_damage_after_the_readable_part() {
    let file = TestByteOrder::Little.pcapng().concat();
    let mut reader = CaptureReader::new(Dripping(&file)).expect("a section header");
    let mut packets = 0;
    let mut damage = Vec::new();
    while let Some(item) = reader.next() {
        match item {
            CaptureItem::Packet(_) => packets += 1,
            CaptureItem::Damage(found) => damage.push(found),
        }
    }
    assert_eq!(packets, 5);
    let what = "reading stopped: the disk is gone".to_string();
    assert_eq!(damage, [Damage { at: file.len() as u64, what, effect: DamageEffect::Missing }]);
    assert!(CaptureReader::new(Dripping(&[])).is_err_and(|refused| matches!(refused, NotACapture::Unreadable(_))));
}

#[test]
fn written_files_match_the_format_byte_by_byte() {
    let mut writer = PcapngWriter::new(Vec::new(), "encspec").expect("memory");
    let wire = writer.interface("virtual", LinkType::ETHERNET).expect("memory");
    writer.packet(wire, Time::from_nanos(0x1_0000_0007), &[1; 5], Some("first")).expect("memory");
    writer.packet(wire, Time::from_nanos(0x1_0000_0008), &[2; 4], None).expect("memory");
    assert!(writer.packet(1, Time::ZERO, &[], None).is_err(), "there is no interface 1");
    let file = writer.finish().expect("memory");

    let end = TestByteOrder::Little;
    let application = [end.option(4, b"encspec"), vec![0; 4]].concat();
    let section = [end.words(&[0x1A2B_3C4D, 1, !0, !0]), application].concat();
    let options = [end.option(2, b"virtual"), end.option(9, &[9]), vec![0; 4]].concat();
    let comment = [end.option(1, b"first"), vec![0; 4]].concat();
    let expected = [
        end.block(0x0A0D_0D0A, &section),
        end.interface(1, 0, &options),
        end.packet(0, 7, &[1; 5], 5, &comment),
        end.packet(0, 8, &[2; 4], 4, &[]),
    ];
    assert_eq!(file, expected.concat());
}

#[test]
fn a_comment_too_long_for_the_format_is_cut_between_two_characters() {
    let mut writer = PcapngWriter::new(Vec::new(), "encspec").expect("memory");
    let wire = writer.interface("virtual", LinkType::PROFIBUS).expect("memory");
    writer.packet(wire, Time::ZERO, &[1], Some(&"ü".repeat(40_000))).expect("memory");
    let content = read(&writer.finish().expect("memory"));
    assert_eq!(content.damage, []);
    assert_eq!(content.before[0].comment, Some("ü".repeat(32_767)));
    assert_eq!(content.before[0].link_type, 257);
}
