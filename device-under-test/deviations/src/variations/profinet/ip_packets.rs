//! How a PROFINET device forms its IP packets.

use crate::needs::Need;
use crate::seams::late::FrameTopic;
use crate::tables::Group;
use alloc::vec;
use core::time::Duration;
use reference_devices::manuals::PROFINET_IO;
use wire::datagram::Ipv4;
use wire::datagram::fragments::checksum;
use wire::ethernet::FrameHeader;

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profinet],
        deviations: permitted! {
            "ip-packets-numbered" "IP packets are numbered, leave with time to live 128 and must not be fragmented."
                "RFC 1122, 3.2.1.7: the time to live is configurable; RFC 6864: the number of a whole packet is of no meaning"
                => |d| {
                    let mut number: u16 = 0x7FFF;
                    d.stack.sent_frame(move |_, frame| {
                        number = number.wrapping_add(1);
                        with_ip_header(frame, number);
                    });
                };
        },
    },
    Group {
        needs: &[Need::Of(&PROFINET_IO)],
        deviations: permitted! {
            "echo-reply-twice" "The reply to an echo request comes twice, the second time after 20 ms."
                "RFC 792 and RFC 1122, 3.2.2.6: nothing forbids a second reply, and a network may duplicate packets"
                => |d| d.late.added(|topic, frame| match topic {
                    FrameTopic::Other if is_icmp(frame) => vec![(Duration::from_millis(20), frame.to_vec())],
                    _ => vec![],
                });
        },
    },
];

fn is_icmp(frame: &[u8]) -> bool {
    Ipv4::of_frame(frame).is_some_and(|(_, packet)| packet.protocol == Ipv4::ICMP)
}

/// Gives a whole packet a number, the flag against fragments and another time to live.
fn with_ip_header(frame: &mut [u8], number: u16) {
    if Ipv4::of_frame(frame).is_none_or(|(_, packet)| packet.is_fragment()) {
        return;
    }
    let Ok((_, payload)) = FrameHeader::parse(frame) else { return };
    let start = frame.len() - payload.len();
    let header_length = usize::from(frame[start] & 0x0F) * 4;
    let header = &mut frame[start..start + header_length];
    header[4..6].copy_from_slice(&number.to_be_bytes());
    // Don't Fragment, time to live, and the checksum.
    header[6..8].copy_from_slice(&[0x40, 0]);
    header[8] = 128;
    header[10..12].fill(0);
    let sum = checksum(header);
    header[10..12].copy_from_slice(&sum.to_be_bytes());
}
