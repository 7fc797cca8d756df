//! Packets per second that the capture reader reads: 64-byte frames, typical for cyclic exchange.

mod rate;

use encspec_virtual_wire::capture::{CaptureItem, LinkType};
use encspec_virtual_wire::{CaptureReader, PcapngWriter};
use rate::rate;
use station::Time;
use std::hint::black_box;

const PACKETS: usize = 1_000_000;
const FRAME: [u8; 64] = [0x5A; 64];

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

fn read(name: &str, file: &[u8]) {
    rate(name, "packets", PACKETS, || {
        let mut reader = CaptureReader::new(file).expect("a capture");
        let mut packets = 0;
        while let Some(item) = reader.next() {
            if let CaptureItem::Packet(packet) = black_box(item) {
                packets += usize::from(packet.captured.len() == FRAME.len());
            }
        }
        assert_eq!(packets, PACKETS);
    });
}

fn main() {
    read("pcap", &pcap());
    read("pcapng", &pcapng(None));
    read("pcapng with comments", &pcapng(Some("step 1")));
}
