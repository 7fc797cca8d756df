//! Net load: frames for others and for all, one after the other, beside whatever else the controller does.

use super::context::ControllerContext;
use super::jobs::ControllerJob;
use crate::words::words;
use alloc::vec::Vec;
use core::net::{Ipv4Addr, SocketAddrV4};
use core::time::Duration;
use station::{Outbox, Time};
use wire::datagram::arp::Arp;
use wire::datagram::write_udp;
use wire::ethernet::{EtherType, FrameHeader, Mac, pad};
use wire::profinet::dcp::{Dcp, DcpValue};

/// The discard protocol (RFC 863).
const DISCARD: u16 = 9;
/// A multicast address of documentation (RFC 9542, 2.1.2).
const OTHER_MULTICAST: Mac = Mac([0x01, 0x00, 0x5E, 0x90, 0x10, 0x00]);
/// An EtherType for local experiments (IEEE 802).
const EXPERIMENTAL: EtherType = EtherType(0x88B5);
const BROADCAST: Mac = Mac([0xFF; 6]);
const MULTICAST_OCTETS: usize = 200;

words! {
    /// The frames of a load.
    pub enum LoadKind {
        ArpBroadcast "arp_broadcast" "ARP requests for an address that the device does not have.",
        DcpIdentify "dcp_identify" "DCP Identify for a name that the device does not have.",
        Multicast "multicast" "Frames to a multicast address that the device does not have.",
        IpBroadcast "ip_broadcast" "UDP datagrams to all stations.",
        Malformed "malformed" "DCP frames to all stations that end before their blocks.",
    }
}

impl LoadKind {
    /// The frames with this word.
    pub fn by_word(word: &str) -> Option<LoadKind> {
        LoadKind::TABLE.iter().find(|entry| entry.1 == word).map(|entry| entry.0)
    }
}

/// A load: frames of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NetLoad {
    /// Their kind.
    pub kind: LoadKind,
    /// How many there are.
    pub count: u32,
    /// The time from one to the next.
    pub gap: Duration,
}

/// A load that goes on.
#[derive(Debug)]
pub(super) struct LoadJob {
    frame: Vec<u8>,
    left: u32,
    gap: Duration,
    due: Time,
}

impl LoadJob {
    /// When the next frame is due.
    pub(super) fn due(&self) -> Time {
        self.due
    }

    /// Sends what is due; returns whether the load is over.
    pub(super) fn wake(&mut self, now: Time, out: &mut Outbox) -> bool {
        if now < self.due {
            return false;
        }
        // It ends a gap after the last frame, which is on the wire then.
        if self.left == 0 {
            return true;
        }
        out.push(&self.frame);
        self.left -= 1;
        // A host that stalled does not send in one burst what it has missed.
        self.due = (self.due + self.gap).max(now);
        false
    }
}

/// Begins a load.
pub(super) fn begin(context: &mut ControllerContext, now: Time, load: NetLoad) -> ControllerJob {
    let own = context.own;
    let mut frame = Vec::new();
    match load.kind {
        LoadKind::ArpBroadcast => Arp::request(own.mac, own.ip, own.ip).write_frame(&mut frame),
        LoadKind::DcpIdentify => {
            let name = DcpValue::NameOfStation(b"no-such-station".to_vec());
            Dcp::identify(context.ids.xid(), 1, [name].into()).write_frame(Mac::DCP_MULTICAST, own.mac, &mut frame);
        }
        LoadKind::Multicast => {
            FrameHeader::new(OTHER_MULTICAST, own.mac, EXPERIMENTAL).write(&mut frame);
            frame.resize(MULTICAST_OCTETS, 0);
        }
        LoadKind::IpBroadcast => {
            let end = |ip| SocketAddrV4::new(ip, DISCARD);
            let from = (own.mac, end(own.ip));
            let _fits = write_udp(from, (BROADCAST, end(Ipv4Addr::BROADCAST)), &[0; 64], &mut frame);
        }
        LoadKind::Malformed => {
            FrameHeader::new(BROADCAST, own.mac, EtherType::PROFINET).write(&mut frame);
            // FrameID of Identify, service, no xid, and a length of 255 bytes that do not follow.
            frame.extend([0xFE, 0xFE, 5, 0, 0, 0, 0, 0, 0, 1, 0, 0xFF, 2, 2]);
            pad(&mut frame, 0);
        }
    }
    ControllerJob::Load(LoadJob { frame, left: load.count, gap: load.gap, due: now })
}
