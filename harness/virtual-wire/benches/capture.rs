//! How many packets a second are read from a capture: 64-octet frames, as cyclic exchange leaves them.

use std::hint::black_box;

use divan::Bencher;
use divan::counter::ItemsCount;
use encspec_virtual_wire::capture::{Item, LinkType};
use encspec_virtual_wire::{CaptureReader, PcapngWriter};
use station::Time;

const PACKETS: usize = 1_000_000;
const FRAME: [u8; 64] = [0x5A; 64];

fn main() {
    divan::main();
}

fn pcapng(comment: Option<&str>) -> Vec<u8> {
    let mut writer = PcapngWriter::new(Vec::new(), "encspec").expect("memory");
    let wire = writer.interface("virtual", LinkType::ETHERNET).expect("memory");
    for packet in 0..PACKETS as u64 {
        writer.packet(wire, Time::from_nanos(packet * 1_000_000), &FRAME, comment).expect("memory");
    }
    writer.finish().expect("memory")
}

fn pcap() -> Vec<u8> {
    let mut file = vec![0xD4, 0xC3, 0xB2, 0xA1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 1, 0, 0, 0];
    for packet in 0..PACKETS as u32 {
        let length = FRAME.len() as u32;
        for word in [packet / 1_000, packet % 1_000 * 1_000, length, length] {
            file.extend_from_slice(&word.to_le_bytes());
        }
        file.extend_from_slice(&FRAME);
    }
    file
}

fn read(bencher: Bencher<'_, '_>, file: &[u8]) {
    bencher.counter(ItemsCount::new(PACKETS)).bench(|| {
        let mut reader = CaptureReader::new(file).expect("a capture");
        let mut packets = 0;
        while let Some(item) = reader.next() {
            if let Item::Packet(packet) = black_box(item) {
                packets += usize::from(packet.captured.len() == FRAME.len());
            }
        }
        assert_eq!(packets, PACKETS);
    });
}

#[divan::bench(sample_count = 10)]
fn read_pcap(bencher: Bencher<'_, '_>) {
    read(bencher, &pcap());
}

#[divan::bench(sample_count = 10)]
fn read_pcapng(bencher: Bencher<'_, '_>) {
    read(bencher, &pcapng(None));
}

#[divan::bench(sample_count = 10)]
fn read_pcapng_with_comments(bencher: Bencher<'_, '_>) {
    read(bencher, &pcapng(Some("step 1")));
}
