//! What switches and network adapters between device and controller do to frames.

use super::state::{pad_with, untagged};
use crate::needs::Need;
use crate::seams::late::FrameTopic;
use crate::tables::Group;
use wire::ethernet::{EtherType, FrameHeader};

/// What some adapters hand over behind a frame.
const TRAILER: [u8; 4] = [0xDE, 0xAD, 0xBE, 0xEF];
/// The bytes of the longest frame without check sequence: IEEE 802.3, 3.2.7.
const LONGEST: usize = 1514;

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Profinet],
    deviations: permitted! {
        "tag-stripped" "The VLAN tag of each frame is stripped on its way."
            "IEEE 802.1Q: a bridge may remove the priority tag; IEC 61158-6-10: a receiver accepts both"
            => |d| d.stack.on_the_way(untagged);
        "trailer-of-four-bytes" "Each frame has four more bytes after its contents, as with an adapter that passes on the checksum."
            "IEEE 802.3: what follows the length of the contents is ignored"
            => |d| d.stack.on_the_way(|frame| {
                // No switch forwards a frame that is longer than the longest.
                if !frame.is_empty() && frame.len() + TRAILER.len() <= LONGEST {
                    frame.extend(TRAILER);
                }
            });
        "padding-not-zero" "The padding of short frames has other bytes than 0."
            "IEEE 802.3, 3.2.7: the contents of the padding are not specified"
            => |d| d.stack.on_the_way(|frame| pad_with(frame, 0xA5));
        "dcp-tagged" "DCP frames carry a priority tag."
            "IEC 61158-6-10, DCP-PDU: with or without a VLAN tag"
            => |d| d.stack.on_the_way(|frame| {
                let is_dcp = matches!(FrameTopic::of(frame), FrameTopic::Identify | FrameTopic::Dcp(_));
                if is_dcp && let Ok((header, _)) = FrameHeader::parse(frame) && header.tag.is_none() {
                    frame.splice(12..12, EtherType::VLAN.0.to_be_bytes().into_iter().chain([0x00, 0x00]));
                }
            });
    },
}];
