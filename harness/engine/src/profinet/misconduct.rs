//! Frames that a device must not send whatever a step asks: answers to a group of stations, the same frame again and again, and cyclic
//! frames whose counters do not advance.
//!
//! No requirement of a manual is about them, but a device that floods a network or whose frames overtake each other passes nothing.

use super::super::trial::RunningTrial;
use station::{Duration, Time};
use wire::ethernet::{EtherType, FrameHeader};
use wire::profinet::rt::FrameId;

/// So many copies of a frame within [`SOON`] are no repetition of an unanswered request.
const MOST_COPIES: usize = 5;
/// Repetitions of the protocols come later.
const SOON: Duration = Duration::from_millis(100);
/// Fewer cyclic frames that came twice, or in another order than they were sent, may be the network's.
const MOST_ODD: u64 = 3;

/// What a device must not send.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sent {
    Arp,
    DcpAnswer,
    Datagram,
}

/// What the device sent in a trial that it must not send; none: nothing.
pub fn misconduct(run: &RunningTrial<'_>) -> Option<String> {
    acyclic(run).or_else(|| cyclic(run))
}

fn acyclic(run: &RunningTrial<'_>) -> Option<String> {
    let mut last: (&[u8], Time, usize) = (&[], Time::ZERO, 0);
    for frame in run.world.trace.iter() {
        if frame.octets.get(6..12) != Some(&run.mac.0) {
            continue;
        }
        let Some((sent, is_to_group)) = kind(frame.octets) else { continue };
        if is_to_group && sent != Sent::Arp {
            let what = if sent == Sent::DcpAnswer { "a DCP answer" } else { "a datagram" };
            return Some(format!("{what} went to a group of stations (frame {})", frame.number));
        }
        last = match last {
            (octets, since, copies) if octets == frame.octets && frame.time.since(since) < SOON => {
                (octets, since, copies + 1)
            }
            _ => (frame.octets, frame.time, 0),
        };
        if last.2 > MOST_COPIES {
            return Some(format!("the same frame came more than {MOST_COPIES} times (frame {})", frame.number));
        }
    }
    None
}

/// What a frame of the device is, and whether it is for a group; none: a frame that may be for a group and may be repeated.
fn kind(octets: &[u8]) -> Option<(Sent, bool)> {
    let (header, payload) = FrameHeader::parse(octets).ok()?;
    let sent = match header.ether_type {
        EtherType::ARP => Sent::Arp,
        EtherType::IPV4 => Sent::Datagram,
        EtherType::PROFINET => match (FrameId::peek(payload).ok()?, payload.get(3)) {
            (FrameId(0xFEFD | 0xFEFF), Some(service)) if service & 1 == 1 => Sent::DcpAnswer,
            _ => return None,
        },
        _ => return None,
    };
    Some((sent, header.destination.0[0] & 1 == 1))
}

fn cyclic(run: &RunningTrial<'_>) -> Option<String> {
    let of_device = run.world.ars().iter().filter(|ar| ar.device.mac() == run.mac);
    of_device.map(|ar| &ar.inputs).find_map(|inputs| {
        let frames = inputs.frames;
        let odd = |count: u64, what: &str| Some(format!("of {frames} cyclic frames {count} {what}"));
        if inputs.repeated > MOST_ODD {
            odd(inputs.repeated, "came twice")
        } else if inputs.out_of_order > MOST_ODD {
            odd(inputs.out_of_order, "came behind one that was sent later")
        } else if run.world.segment.is_virtual() && inputs.lost > frames {
            Some(format!("{frames} cyclic frames came, and {} between them did not", inputs.lost))
        } else {
            None
        }
    })
}
