//! Deviations of the PROFINET stack that have state about names, addresses and resets.

use crate::seams::stack::{change_dcp, change_lldp, dcp, rename};
use alloc::vec;
use alloc::vec::Vec;
use core::mem;
use core::time::Duration;
use device_stack::profinet::{StackCheck, StackHooks, StackView, StationData, StationLoad};
use station::Time;
use wire::datagram::Ipv4;
use wire::ethernet::Mac;
use wire::http;
use wire::profinet::dcp::{BlockError, BlockQualifier, Dcp, DcpBlock, DcpValue, Element, ServiceId, ServiceType};

/// Announces the name from power-up by LLDP.
#[derive(Default)]
pub struct AnnouncesFirstName {
    name: Vec<u8>,
}

impl StackHooks for AnnouncesFirstName {
    fn load_station(&mut self, start: StationLoad, station: &mut StationData) {
        if start == StationLoad::PowerUp {
            self.name.clone_from(&station.name);
        }
    }

    fn sent_frame(&mut self, _: &StackView<'_>, frame: &mut Vec<u8>) {
        change_lldp(frame, |lldp| {
            rename(lldp, &self.name);
            true
        });
    }
}

/// Drops all frames between a reset and the next power-up.
#[derive(Default)]
pub struct SilentAfterReset {
    was_reset: bool,
}

impl StackHooks for SilentAfterReset {
    fn load_station(&mut self, start: StationLoad, _: &mut StationData) {
        self.was_reset = start == StationLoad::Reset;
    }

    fn received_frames(&mut self, _: &StackView<'_>, frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        if self.was_reset { Vec::new() } else { frames }
    }
}

/// Refuses every name between a reset and the next power-up.
#[derive(Default)]
pub struct NoNameAfterReset {
    was_reset: bool,
}

impl StackHooks for NoNameAfterReset {
    fn load_station(&mut self, start: StationLoad, _: &mut StationData) {
        self.was_reset = start == StationLoad::Reset;
    }

    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        verdict && !(self.was_reset && matches!(check, StackCheck::Name(_)))
    }
}

/// Answers a reset positively without carrying it out: the stack receives an unknown DCP element instead.
#[derive(Default)]
pub struct OnlyAnswersReset {
    reset: Option<Element>,
}

impl OnlyAnswersReset {
    const UNKNOWN: Element = Element { option: 0x80, suboption: 1 };
}

impl StackHooks for OnlyAnswersReset {
    fn received_frames(&mut self, _: &StackView<'_>, mut frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        for frame in &mut frames {
            change_dcp(frame, |of, blocks| {
                if (of.service_id, of.service_type) != (ServiceId::SET, ServiceType::REQUEST) {
                    return;
                }
                for block in blocks {
                    if matches!(block.value, DcpValue::FactoryReset | DcpValue::ResetToFactory) {
                        self.reset = Some(block.value.element());
                        block.value = DcpValue::Raw { element: OnlyAnswersReset::UNKNOWN, octets: Vec::new() };
                    }
                }
            });
        }
        frames
    }

    fn sent_frame(&mut self, _: &StackView<'_>, frame: &mut Vec<u8>) {
        let Some(reset) = self.reset else { return };
        change_dcp(frame, |_, blocks| {
            for block in blocks {
                if matches!(block.value, DcpValue::Response { element: OnlyAnswersReset::UNKNOWN, .. }) {
                    *block = DcpBlock::outcome(reset, BlockError::OK);
                }
            }
        });
    }
}

/// Restores the name from before a reset, by a DCP Set to itself.
#[derive(Default)]
pub struct NameReturns {
    now: Time,
    name: Vec<u8>,
    returns: Option<(Time, Vec<u8>)>,
}

impl NameReturns {
    /// Time from the reset to the DCP Set.
    const AFTER: Duration = Duration::from_secs(5);
    /// Source address of the DCP Set.
    const SETTER: Mac = Mac([2, 0, 0, 0, 0xFF, 0xFE]);
}

impl StackHooks for NameReturns {
    fn received_frames(&mut self, view: &StackView<'_>, frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        self.now = view.now;
        self.name.clone_from(&view.station.name);
        let Some((_, name)) = self.returns.take_if(|(due, _)| *due <= view.now) else { return frames };
        let set = DcpBlock::set(BlockQualifier::PERMANENT, DcpValue::NameOfStation(name));
        let mut frame = Vec::new();
        Dcp::set(0, vec![set]).write_frame(view.mac, NameReturns::SETTER, &mut frame);
        [vec![frame], frames].concat()
    }

    fn load_station(&mut self, start: StationLoad, _: &mut StationData) {
        self.returns =
            (start == StationLoad::Reset).then(|| (self.now + NameReturns::AFTER, mem::take(&mut self.name)));
    }

    fn sent_frame(&mut self, _: &StackView<'_>, frame: &mut Vec<u8>) {
        if dcp(frame).is_some_and(|(header, _)| header.destination == NameReturns::SETTER) {
            frame.clear();
        }
    }
}

/// Serves web pages only at the first IP address since power-up.
#[derive(Default)]
pub struct PagesStay {
    first: [u8; 4],
}

impl StackHooks for PagesStay {
    fn load_station(&mut self, start: StationLoad, _: &mut StationData) {
        if start == StationLoad::PowerUp {
            self.first = [0; 4];
        }
    }

    fn received_frames(&mut self, view: &StackView<'_>, mut frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        if self.first == [0; 4] {
            self.first = view.station.ip;
        }
        if self.first != view.station.ip {
            frames.retain(|frame| !is_for_pages(frame));
        }
        frames
    }
}

/// Whether a frame is addressed to the web server.
fn is_for_pages(frame: &[u8]) -> bool {
    Ipv4::of_frame(frame).is_some_and(|(_, packet)| {
        packet.protocol == Ipv4::TCP && packet.payload.get(2..4) == Some(&http::PORT.to_be_bytes())
    })
}
