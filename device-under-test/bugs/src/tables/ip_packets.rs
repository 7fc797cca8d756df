//! Deviations of the PROFINET stack in IP: the echo of ICMP, and packets in fragments.

use super::ip_packets_state::{PacketsInOrder, WaitsForEver};
use super::{Deviation, Group};
use crate::needs::Need;
use alloc::vec::Vec;
use device_stack::profinet::StackView;
use wire::datagram::Ipv4;
use wire::datagram::fragments::{LONGEST_FRAGMENT, OutgoingPacket};
use wire::datagram::icmp::IcmpEcho;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Profinet], deviations: BUGS }];

/// The longest data of an echo request that one frame holds is 1472 bytes; a stack with short buffers takes less.
const SHORT_BUFFER: usize = 512;

const BUGS: &[Deviation] = bugs! {
    "echo-ignored" "ICMP echo requests are not answered." => |d| d.stack.filter_frames(|_, frame| !is_icmp(frame));
    "long-echo-ignored" "ICMP echo requests with more than 512 bytes are not answered."
        => |d| d.stack.filter_frames(|_, frame| !(is_icmp(frame) && frame.len() > SHORT_BUFFER));
    "echo-without-data" "The data of an echo reply are zeros." => |d| d.stack.sent_frame(|_, frame| change_reply(frame, |echo| {
        echo.data.fill(0);
    }));
    "echo-of-another-sequence" "An echo reply has another sequence number." => |d| d.stack.sent_frame(|_, frame| {
        change_reply(frame, |echo| echo.sequence ^= 1);
    });
    "echo-cut-short" "An echo reply has no more than 8 bytes of data." => |d| d.stack.sent_frame(|_, frame| {
        change_reply(frame, |echo| echo.data.truncate(8));
    });
    "echo-checksum-not-checked" "Echo requests with a wrong checksum are answered." => |d| d.stack.received_frames(|view, frames| {
        frames.into_iter().map(|frame| repaired(view, frame, false)).collect()
    });
    "echo-of-others" "Echo requests to other addresses are answered." => |d| d.stack.received_frames(|view, frames| {
        frames.into_iter().map(|frame| repaired(view, frame, true)).collect()
    });
    "ip-fragments-ignored" "IP packets in fragments are ignored." => |d| d.stack.filter_frames(|_, frame| !is_fragment(frame));
    "ip-fragments-in-order-only" "IP fragments that come in another order are dropped." => |d| d.stack.add(PacketsInOrder::default());
    "ip-fragment-awaited-for-ever" "While a fragment of a packet is missing all other packets are dropped."
        => |d| d.stack.add(WaitsForEver::default());
};

/// Whether a frame has a fragment of an IP packet.
pub(super) fn is_fragment(frame: &[u8]) -> bool {
    Ipv4::of_frame(frame).is_some_and(|(_, packet)| packet.is_fragment())
}

fn is_icmp(frame: &[u8]) -> bool {
    Ipv4::of_frame(frame).is_some_and(|(_, packet)| packet.protocol == Ipv4::ICMP)
}

/// Changes an echo reply in one frame.
fn change_reply(frame: &mut Vec<u8>, change: impl FnOnce(&mut IcmpEcho)) {
    let Some((header, packet)) = Ipv4::of_frame(frame).filter(|(_, packet)| packet.protocol == Ipv4::ICMP) else {
        return;
    };
    let Some(mut echo) = IcmpEcho::parse(packet.payload).ok().filter(|echo| echo.is_reply && !packet.is_fragment())
    else {
        return;
    };
    change(&mut echo);
    let changed = OutgoingPacket {
        source: (header.source, packet.source),
        destination: (header.destination, packet.destination),
        protocol: Ipv4::ICMP,
        identification: packet.identification,
        payload: &echo.to_vec(),
    };
    *frame = changed.frames(LONGEST_FRAGMENT).swap_remove(0);
}

/// A frame whose ICMP message has the right checksum, and with `is_to_us` the address of the device.
fn repaired(view: &StackView<'_>, frame: Vec<u8>, is_to_us: bool) -> Vec<u8> {
    let found = Ipv4::of_frame(&frame).filter(|(_, packet)| packet.protocol == Ipv4::ICMP && !packet.is_fragment());
    let Some((header, packet)) = found else { return frame };
    let [kind, code, _, _, identifier @ ..] = packet.payload else { return frame };
    let [a, b, c, d, data @ ..] = identifier else { return frame };
    let number = |high: u8, low: u8| u16::from_be_bytes([high, low]);
    if (*kind, *code) != (8, 0) || !is_to_us && packet.destination.octets() != view.station.ip {
        return frame;
    }
    if is_to_us && IcmpEcho::parse(packet.payload).is_err() {
        return frame;
    }
    let echo = IcmpEcho { is_reply: false, identifier: number(*a, *b), sequence: number(*c, *d), data: data.to_vec() };
    let destination = if is_to_us { view.station.ip.into() } else { packet.destination };
    let changed = OutgoingPacket {
        source: (header.source, packet.source),
        destination: (header.destination, destination),
        protocol: Ipv4::ICMP,
        identification: packet.identification,
        payload: &echo.to_vec(),
    };
    changed.frames(LONGEST_FRAGMENT).swap_remove(0)
}
