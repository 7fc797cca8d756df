//! Captures of independent tools, compared with what tshark 4.0.17 and capinfos read from them.
//!
//! The expected numbers come from those tools. Without the captures each test is skipped and says so.

use encspec_virtual_wire::capture::{CaptureItem, CapturedPacket, LinkType};
use encspec_virtual_wire::damage::{every_flipped_bit, every_prefix, random_flips};
use encspec_virtual_wire::{CaptureReader, PcapngWriter};
use rstest::rstest;
use station::Time;
use std::fs::{self, File};
use std::process::Command;

/// The compared fields of a packet: number, nanoseconds, section, interface, link type, captured and original length.
type PacketRow = (usize, u64, u32, u32, u16, usize, u32);

#[derive(Debug, Default, PartialEq)]
struct CaptureSummary {
    rows: Vec<PacketRow>,
    octets: Vec<Vec<u8>>,
    damage: Vec<(u64, String)>,
    /// Number of packets before the first damage.
    before: usize,
}

fn row(packet: &CapturedPacket<'_>) -> PacketRow {
    let nanos = packet.time.as_nanos();
    let CapturedPacket { number, section, interface, link_type, captured, original_length, .. } = packet;
    (*number, nanos, *section, *interface, link_type.0, captured.len(), *original_length)
}

fn read(file: &[u8]) -> CaptureSummary {
    let mut content = CaptureSummary::default();
    let Ok(mut reader) = CaptureReader::new(file) else { return content };
    while let Some(item) = reader.next() {
        match item {
            CaptureItem::Damage(damage) => content.damage.push((damage.at, damage.what)),
            CaptureItem::Packet(packet) => {
                content.rows.push(row(&packet));
                content.octets.push(packet.captured.to_vec());
                content.before += usize::from(content.damage.is_empty());
            }
        }
        assert!(content.rows.len() + content.damage.len() <= file.len(), "more items than bytes");
    }
    content
}

fn shared(name: &str) -> Option<Vec<u8>> {
    Some(fs::read(testing::shared(&format!("captures/{name}"))?).expect("a file that exists can be read"))
}

const T: u64 = 1_340_954_905_298_858_000;
const MS: u64 = 1_000_000;

#[rstest]
#[case::sections_and_options("advanced_test100", &[
    (1, 0, 1, 0, 1, 314, 314),
    (2, T, 1, 0, 1, 342, 342),
    (3, 0, 1, 0, 1, 314, 314),
    (4, T + 2 * MS, 1, 0, 1, 342, 342),
    (5, T + 3 * MS, 1, 1, 0, 168, 168),
])]
#[case::interfaces_and_limits("advanced_test101", &[
    (1, T, 1, 0, 1, 96, 314),
    (2, T, 1, 2, 1, 128, 342),
    (3, 0, 1, 0, 1, 96, 314),
    (4, T + 3 * MS, 1, 1, 0, 168, 168),
])]
// Numbers 1, 3 and 8 are custom blocks.
#[case::blocks_between("advanced_test102", &[
    (2, T, 1, 0, 1, 96, 314),
    (4, T, 1, 2, 1, 342, 342),
    (5, 0, 1, 0, 1, 96, 314),
    (6, T + 2 * MS, 1, 0, 1, 96, 342),
    (7, T + 3 * MS, 1, 1, 0, 168, 168),
])]
#[case::no_packet_at_all("difficult_test200", &[])]
#[case::byte_order_per_section("difficult_test201", &[
    (1, T, 1, 0, 1, 96, 314),
    (2, T, 2, 0, 1, 128, 342),
    (3, 0, 2, 0, 1, 128, 314),
    (4, T + 3 * MS, 3, 1, 0, 168, 168),
])]
// Numbers 1, 7 and 10 are custom blocks.
#[case::everything("difficult_test202", &[
    (2, T, 1, 0, 1, 96, 314),
    (3, T, 1, 0, 1, 96, 342),
    (4, T + 3 * MS, 1, 1, 0, 168, 168),
    (5, 0, 2, 0, 1, 128, 314),
    (6, T, 2, 0, 1, 128, 342),
    (8, 0, 2, 0, 1, 128, 314),
    (9, T, 2, 0, 1, 128, 342),
    (11, T + 3 * MS, 3, 1, 0, 168, 168),
])]
fn nasty_containers_are_read_in_both_byte_orders(#[case] name: &str, #[case] rows: &[PacketRow]) {
    let Some(little) = shared(&format!("containers/le-{name}.pcapng")) else { return };
    let Some(big) = shared(&format!("containers/be-{name}.pcapng")) else { return };
    let content = read(&little);
    assert_eq!(content.rows, rows);
    assert_eq!(content.damage, []);
    assert_eq!(read(&big), content);
}

#[rstest]
#[case(
    "containers/big-endian-nanoseconds.pcap",
    28,
    1_522_943_936_736_189_007,
    1_522_944_740_361_986_007,
    2_060,
    2_060
)]
#[case("damaged/bit-rot.pcap", 28, 1_522_943_936_736_189_000, 1_522_944_740_361_986_000, 2_060, 2_060)]
#[case("damaged/sliced-48.pcap", 28, 1_522_943_936_736_189_000, 1_522_944_740_361_986_000, 1_344, 2_060)]
#[case("profinet/dcp-name-ip-reset.pcap", 28, 1_522_943_936_736_189_000, 1_522_944_740_361_986_000, 2_060, 2_060)]
#[case("profinet/duplicate-station-name.pcap", 25, 1_636_977_600_787_752_000, 1_636_977_622_338_737_000, 1_650, 1_650)]
#[case("profinet/implicit-reads-ns.pcapng", 20, 1_675_171_859_192_836_274, 1_675_171_865_959_451_670, 3_068, 3_068)]
#[case(
    "profinet/merged-many-devices.pcapng",
    960,
    1_287_088_627_587_076_000,
    1_689_619_037_794_768_654,
    277_778,
    277_778
)]
#[case("profinet/odd-station-name.pcap", 4, 1_200_565_398_895_639_000, 1_200_565_399_971_394_000, 362, 362)]
#[case(
    "profinet/office-noise-versamax.pcap",
    1_635,
    1_614_578_399_979_607_000,
    1_614_578_733_172_828_000,
    193_495,
    193_495
)]
#[case("profinet/one-ar-life.pcapng", 10, 1_375_458_865_311_733_000, 1_375_458_865_682_704_000, 3_048, 3_048)]
#[case("profinet/record-reads.pcapng", 18, 1_287_088_627_587_076_000, 1_614_578_459_652_418_000, 4_736, 4_736)]
#[case("profinet/zero-timestamps.pcap", 7, 1_681_414_623_464_553_000, 1_681_414_624_745_138_000, 711, 711)]
fn field_captures_are_read_as_a_whole(
    #[case] name: &str,
    #[case] packets: usize,
    #[case] first: u64,
    #[case] last: u64,
    #[case] captured: usize,
    #[case] original: u64,
) {
    let Some(file) = shared(name) else { return };
    let content = read(&file);
    assert_eq!(content.damage, []);
    assert_eq!(content.rows.iter().map(|row| row.0).collect::<Vec<_>>(), (1..=packets).collect::<Vec<_>>());
    assert_eq!((content.rows[0].1, content.rows[packets - 1].1), (first, last));
    assert_eq!(content.rows.iter().map(|row| row.5).sum::<usize>(), captured);
    assert_eq!(content.rows.iter().map(|row| u64::from(row.6)).sum::<u64>(), original);
    assert!(content.rows.iter().all(|row| row.4 == LinkType::ETHERNET.0));
}

#[test]
fn merged_interfaces_keep_their_own_clocks_and_times_may_go_back() {
    let Some(file) = shared("profinet/merged-many-devices.pcapng") else { return };
    let rows = read(&file).rows;
    let of_interface = |interface| rows.iter().filter(|row| row.3 == interface).count();
    assert_eq!((of_interface(0), of_interface(1)), (216, 744));
    assert_eq!(rows.windows(2).filter(|pair| pair[1].1 < pair[0].1).count(), 3);
}

#[test]
fn a_time_of_zero_stays_zero() {
    let Some(file) = shared("profinet/zero-timestamps.pcap") else { return };
    let zeros: Vec<(usize, usize)> =
        read(&file).rows.iter().filter(|row| row.1 == 0).map(|row| (row.0, row.5)).collect();
    assert_eq!(zeros, [(2, 37), (4, 34), (6, 42)]);
}

/// tshark stops at the damage; `before` is the number of packets it reads. The undamaged twin shows the rest.
#[rstest]
#[case::captured_length("captured-length-huge.pcap", "dcp-name-ip-reset.pcap", 7, 28, 688, "taken as 60")]
#[case::trailer("block-trailer-mismatch.pcapng", "record-reads.pcapng", 3, 18, 1_028, "taken as 464")]
// Packet 901 has 166 bytes, so its record has 182.
#[case::cut("cut-mid-record.pcap", "office-noise-versamax.pcap", 900, 900, 115_864, "36 of 182 bytes")]
#[case::header_only(
    "header-only.pcap",
    "office-noise-versamax.pcap",
    0,
    0,
    0,
    "ends after its header and holds no packet"
)]
fn damage_is_reported_and_what_can_be_read_is_read(
    #[case] damaged: &str,
    #[case] twin: &str,
    #[case] before: usize,
    #[case] packets: usize,
    #[case] at: u64,
    #[case] what: &str,
) {
    let Some(file) = shared(&format!("damaged/{damaged}")) else { return };
    let Some(twin) = shared(&format!("profinet/{twin}")) else { return };
    let (content, twin) = (read(&file), read(&twin));
    assert_eq!(content.damage.len(), 1, "{:?}", content.damage);
    assert_eq!(content.damage[0].0, at);
    assert!(content.damage[0].1.ends_with(what), "{:?}", content.damage);
    assert_eq!((content.before, content.rows.len()), (before, packets));
    assert_eq!(content.rows, twin.rows[..packets]);
    assert_eq!(content.octets, twin.octets[..packets]);
}

#[rstest]
#[case("containers/be-difficult_test202.pcapng")]
#[case("containers/le-advanced_test100.pcapng")]
#[case("containers/big-endian-nanoseconds.pcap")]
#[case("profinet/dcp-name-ip-reset.pcap")]
#[case("profinet/zero-timestamps.pcap")]
#[case("profinet/one-ar-life.pcapng")]
fn every_prefix_of_a_real_file_is_read_up_to_the_cut(#[case] name: &str) {
    let Some(file) = shared(name) else { return };
    let whole = read(&file);
    let mut before = 0;
    every_prefix(&file, |prefix| {
        let content = read(prefix);
        assert_eq!(content.rows, whole.rows[..content.rows.len()], "{} bytes", prefix.len());
        assert_eq!(content.before, content.rows.len(), "packets after a cut at {}", prefix.len());
        assert!(content.rows.len() >= before && content.damage.len() <= 1, "{} bytes", prefix.len());
        before = content.rows.len();
    });
    assert!(before + 1 >= whole.rows.len());
}

#[rstest]
#[case("containers/be-difficult_test202.pcapng")]
#[case("containers/le-advanced_test100.pcapng")]
#[case("containers/big-endian-nanoseconds.pcap")]
#[case("profinet/zero-timestamps.pcap")]
fn every_flipped_bit_in_a_real_file_leaves_the_packets_before_it_alone(#[case] name: &str) {
    let Some(file) = shared(name) else { return };
    every_flipped_bit(&file, |index, damaged| {
        // A damaged file must yield at least what a file cut before the damage yields.
        let sound = read(&file[..index]);
        let content = read(damaged);
        let kept = &content.rows[..content.before.min(sound.before)];
        assert_eq!(kept, &sound.rows[..sound.before], "byte {index}: {:?}", content.damage);
    });
}

#[rstest]
#[case("profinet/office-noise-versamax.pcap")]
#[case("profinet/merged-many-devices.pcapng")]
#[case("containers/le-difficult_test202.pcapng")]
fn many_flipped_bits_end_in_damage_and_never_in_a_panic(#[case] name: &str) {
    let Some(file) = shared(name) else { return };
    let mut damaged = 0;
    random_flips(&file, 42, 100, file.len() / 50, |octets| damaged += usize::from(!read(octets).damage.is_empty()));
    assert!(damaged > 50, "only {damaged} of 100 were detected");
}

#[test]
fn tshark_reads_what_is_written() {
    let folder = testing::Folder::new("written");
    let path = folder.join("written.pcapng");
    let mut writer = PcapngWriter::new(File::create(&path).expect("a new file"), "encspec").expect("a disk");
    let controller = writer.interface("controller", LinkType::ETHERNET).expect("a disk");
    let device = writer.interface("device", LinkType::ETHERNET).expect("a disk");
    let mut frame = [0u8; 61];
    frame[12] = 0x88;
    frame[13] = 0xB5;
    for (interface, nanos, comment) in [(controller, T + 1, Some("step 1: write")), (device, T + 2, None)] {
        writer.packet(interface, Time::from_nanos(nanos), &frame, comment).expect("a disk");
    }
    writer.finish().expect("a disk");

    let fields = ["frame.number", "frame.time_epoch", "frame.interface_name", "frame.len", "frame.comment"];
    let mut tshark = Command::new("tshark");
    tshark.arg("-r").arg(&path).args(["-T", "fields", "-E", "separator=|"]);
    let output = tshark.args(fields.iter().flat_map(|field| ["-e", field])).output();
    match output {
        Ok(output) => assert_eq!(
            String::from_utf8_lossy(&output.stdout),
            "1|1340954905.298858001|controller|61|step 1: write\n2|1340954905.298858002|device|61|\n",
            "{}",
            String::from_utf8_lossy(&output.stderr)
        ),
        Err(why) => testing::skip(&format!("tshark is needed, {why}")),
    }
}
