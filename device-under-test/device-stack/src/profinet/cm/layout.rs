//! Checks that the frames of a Connect contain every expected submodule once and that nothing overlaps.

use super::super::plugged::{ExpectedSubmoduleData, SubmoduleAddress};
use super::check::{demand, fault};
use alloc::vec;
use alloc::vec::Vec;
use wire::profinet::blocks::connect::{FrameObject, IocrApi, IocrBlockReq, IocrType, SubmoduleType};
use wire::profinet::status::{ErrorSource, PnioStatus};

/// Numbers of the fields of an IOCRBlockReq.
const NUMBER_OF_APIS: u8 = 19;
const API: u8 = 20;
/// Fields of the data: number, slot, subslot, offset.
const DATA: [u8; 4] = [21, 22, 23, 24];
/// Fields of the consumer status: number, slot, subslot, offset.
const CONSUMER_STATUS: [u8; 4] = [25, 26, 27, 28];

/// Checks the frame layout of `iocr`, whose other fields are already checked.
pub(super) fn check(iocr: &IocrBlockReq, expected: &[ExpectedSubmoduleData]) -> Result<(), PnioStatus> {
    let is_output = iocr.iocr_type == IocrType::OUTPUT;
    let apis_known = iocr.apis.iter().all(|api| expected.iter().any(|submodule| submodule.place.api == api.api));
    demand(ErrorSource::IOCR_BLOCK, [(NUMBER_OF_APIS, !iocr.apis.is_empty()), (API, apis_known)])?;
    let mut frame = OccupiedBytes { taken: vec![false; iocr.data_length.into()] };
    let objects = |list: fn(&IocrApi) -> &Vec<FrameObject>| {
        iocr.apis.iter().flat_map(move |api| list(api).iter().map(move |object| (api.api, *object)))
    };
    let status = |submodule: &ExpectedSubmoduleData| usize::from(!submodule.discards_status);
    let octets = |submodule: &ExpectedSubmoduleData| {
        status(submodule) + usize::from(if is_output { submodule.output_octets } else { submodule.input_octets })
    };
    let provided: Vec<&ExpectedSubmoduleData> =
        expected.iter().filter(|submodule| submodule.provides(is_output)).collect();
    frame.place_objects(objects(|api| &api.io_data_objects), &provided, octets, DATA)?;
    let consumed: Vec<&ExpectedSubmoduleData> =
        expected.iter().filter(|submodule| submodule.provides(!is_output)).collect();
    frame.place_objects(objects(|api| &api.iocs), &consumed, status, CONSUMER_STATUS)
}

/// The occupied bytes of a frame.
struct OccupiedBytes {
    taken: Vec<bool>,
}

impl OccupiedBytes {
    /// Places all `objects` in the frame. Each must belong to one of `required`, and each of `required` that has data
    /// must have an object.
    ///
    /// Some controllers leave submodules without data out of both frames.
    fn place_objects(
        &mut self,
        objects: impl Iterator<Item = (u32, FrameObject)>,
        required: &[&ExpectedSubmoduleData],
        octets: impl Fn(&ExpectedSubmoduleData) -> usize,
        [number_field, slot_field, subslot_field, offset_field]: [u8; 4],
    ) -> Result<(), PnioStatus> {
        let mut placed = Vec::new();
        for (api, object) in objects {
            let place = SubmoduleAddress { api, slot: object.slot_number, subslot: object.subslot_number };
            let in_slot =
                |submodule: &&ExpectedSubmoduleData| (submodule.place.api, submodule.place.slot) == (api, place.slot);
            let submodule = required.iter().find(|submodule| submodule.place == place && !placed.contains(&place));
            let Some(submodule) = submodule else {
                let knows_slot = required.iter().any(in_slot);
                return Err(fault(ErrorSource::IOCR_BLOCK, if knows_slot { subslot_field } else { slot_field }));
            };
            let is_free = self.occupy(object.frame_offset.into(), octets(submodule));
            demand(ErrorSource::IOCR_BLOCK, [(offset_field, is_free)])?;
            placed.push(place);
        }
        let has_data = |submodule: &&&ExpectedSubmoduleData| submodule.kind != SubmoduleType::NO_IO;
        let is_complete = required.iter().filter(has_data).all(|submodule| placed.contains(&submodule.place));
        demand(ErrorSource::IOCR_BLOCK, [(number_field, is_complete)])
    }

    /// Occupies `octets` bytes from `offset` on. Returns `false` if one is occupied or outside the frame.
    fn occupy(&mut self, offset: usize, octets: usize) -> bool {
        match self.taken.get_mut(offset..offset + octets) {
            Some(bytes) if bytes.iter().all(|taken| !taken) => {
                bytes.fill(true);
                true
            }
            Some(_) | None => false,
        }
    }
}
