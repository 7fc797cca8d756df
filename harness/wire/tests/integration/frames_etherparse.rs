//! Ethernet, IPv4 and UDP compared with the library etherparse, on every frame of real captures.

use encspec_wire as wire;
use etherparse::{NetSlice, SlicedPacket, TransportSlice};
use rstest::rstest;
use testing::{packets, shared};
use wire::datagram::Datagram;
use wire::ethernet::FrameHeader;

#[rstest]
#[case("captures/profinet/office-noise-versamax.pcap", 100)]
#[case("captures/profinet/merged-many-devices.pcapng", 500)]
#[case("captures/profinet/dcp-name-ip-reset.pcap", 0)]
fn both_parsers_agree(#[case] file: &str, #[case] at_least: usize) {
    let Some(path) = shared(file) else { return };
    let mut datagrams = 0;
    for (index, packet) in packets(&path).iter().enumerate() {
        let number = index + 1;
        let Ok(sliced) = SlicedPacket::from_ethernet(packet) else { continue };
        let link = sliced.link.as_ref().and_then(|link| link.to_header()).and_then(|link| link.ethernet2());
        let Some(link) = link else { continue };
        let (header, _) = FrameHeader::parse(packet).unwrap_or_else(|error| panic!("packet {number}: {error}"));
        assert_eq!((header.source.0, header.destination.0), (link.source, link.destination), "packet {number}");
        let tags = usize::from(header.tag.is_some()) + usize::from(header.inner_tag.is_some());
        assert_eq!(tags, sliced.link_exts.len(), "tags of packet {number}");
        let (Some(NetSlice::Ipv4(ip)), Some(TransportSlice::Udp(udp))) = (&sliced.net, &sliced.transport) else {
            continue;
        };
        if ip.header().more_fragments() || ip.header().fragments_offset().value() > 0 {
            continue;
        }
        let parsed = Datagram::parse(packet).unwrap_or_else(|error| panic!("packet {number}: {error}"));
        assert_eq!(*parsed.source.ip(), ip.header().source_addr(), "packet {number}");
        assert_eq!(*parsed.destination.ip(), ip.header().destination_addr(), "packet {number}");
        assert_eq!((parsed.source.port(), parsed.destination.port()), (udp.source_port(), udp.destination_port()));
        assert_eq!(parsed.payload, udp.payload(), "packet {number}");
        datagrams += 1;
    }
    assert!(datagrams >= at_least, "only {datagrams} datagrams in {file}");
}
