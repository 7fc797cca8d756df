//! Deviations of the PROFINET stack with state about the options of DCP.

use crate::seams::stack::change_dcp;
use alloc::vec::Vec;
use device_stack::profinet::{StackHooks, StackView, StationData, StationLoad};
use wire::profinet::dcp::{DcpBlock, DcpValue, ServiceId, ServiceType};

/// Changes the blocks of each DCP Set that is received.
fn change_sets(mut frames: Vec<Vec<u8>>, change: fn(&mut Vec<DcpBlock>)) -> Vec<Vec<u8>> {
    for frame in &mut frames {
        change_dcp(frame, |of, blocks| {
            if (of.service_id, of.service_type) == (ServiceId::SET, ServiceType::REQUEST) {
                change(blocks);
            }
        });
    }
    frames
}

/// Carries out only the first block of a DCP Set.
pub struct OnlyFirstBlock;

impl StackHooks for OnlyFirstBlock {
    fn received_frames(&mut self, _: &StackView<'_>, frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        change_sets(frames, |blocks| blocks.truncate(1))
    }
}

/// Carries out what is set within a transaction at once.
pub struct StartsAndStopsIgnored;

impl StackHooks for StartsAndStopsIgnored {
    fn received_frames(&mut self, _: &StackView<'_>, frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        change_sets(frames, |blocks| blocks.retain(|block| !matches!(block.value, DcpValue::Start | DcpValue::Stop)))
    }
}

/// Uses the address from before a reset again.
#[derive(Default)]
pub struct AddressReturns {
    last: StationData,
}

impl StackHooks for AddressReturns {
    fn set_station(&mut self, _: &StationData, station: &mut StationData, _: &mut StationData) {
        self.last = station.clone();
    }

    fn load_station(&mut self, start: StationLoad, station: &mut StationData) {
        if start == StationLoad::Reset {
            (station.ip, station.mask, station.gateway) = (self.last.ip, self.last.mask, self.last.gateway);
        }
    }
}
