//! The position of each submodule in the two cyclic frames, and the matching blocks of the Connect.
//!
//! In a frame, each IO data object is followed by its IOPS; then come the IOCS for the data of the other frame. A submodule
//! without data counts as an input of no bytes, as the standard requires. This module must not know time, addresses or state.

use super::connection::ConnectSubmodule;
use alloc::vec::Vec;
use wire::profinet::blocks::connect::{
    DataDescription, ExpectedModule, ExpectedSubmodule, ExpectedSubmoduleBlockReq, FrameObject, IocrApi, SubmoduleType,
};
use wire::profinet::rt::SHORTEST_DATA;

/// Both frames of an AR.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// From the device to the controller.
    pub input: FrameLayout,
    /// From the controller to the device.
    pub output: FrameLayout,
}

/// The layout of one frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameLayout {
    /// Data that the sender provides.
    pub data: Vec<IoDataPosition>,
    /// Status of the data that the sender consumes.
    pub iocs: Vec<IoDataPosition>,
    /// Total length in bytes, padded to the minimum of a frame.
    pub data_length: usize,
}

/// The position of a submodule's data or IOCS in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IoDataPosition {
    /// API of the submodule.
    pub api: u32,
    /// Slot number.
    pub slot: u16,
    /// Subslot number.
    pub subslot: u16,
    /// Offset from the first byte of the data.
    pub at: usize,
    /// Length of the data in bytes; its IOPS follows them. 0 in a list of IOCS.
    pub octets: usize,
}

impl IoDataPosition {
    /// The offset of the IOPS of this data.
    pub fn iops(&self) -> usize {
        self.at + self.octets
    }
}

impl Layout {
    /// The frames for these submodules, in their order.
    pub fn of(submodules: &[ConnectSubmodule]) -> Layout {
        let mut layout = Layout::default();
        let inputs = |one: &&ConnectSubmodule| one.has_input();
        let outputs = |one: &&ConnectSubmodule| one.output_octets > 0;
        for submodule in submodules.iter().filter(inputs) {
            layout.input.put_data(submodule, submodule.input_octets);
        }
        for submodule in submodules.iter().filter(outputs) {
            layout.output.put_data(submodule, submodule.output_octets);
            layout.input.put_iocs(submodule);
        }
        for submodule in submodules.iter().filter(inputs) {
            layout.output.put_iocs(submodule);
        }
        for frame in [&mut layout.input, &mut layout.output] {
            frame.data_length = frame.data_length.max(SHORTEST_DATA);
        }
        layout
    }
}

impl FrameLayout {
    fn put_data(&mut self, submodule: &ConnectSubmodule, octets: u16) {
        let place = submodule.place(self.data_length, octets);
        self.data_length = place.iops() + 1;
        self.data.push(place);
    }

    fn put_iocs(&mut self, submodule: &ConnectSubmodule) {
        self.iocs.push(submodule.place(self.data_length, 0));
        self.data_length += 1;
    }

    /// The lists of this frame as in an IOCRBlockReq: grouped by API, in the order in which the APIs first appear.
    pub fn apis(&self) -> Vec<IocrApi> {
        let mut apis: Vec<IocrApi> = Vec::new();
        for (place, is_data) in
            self.data.iter().map(|place| (place, true)).chain(self.iocs.iter().map(|place| (place, false)))
        {
            let at = apis.iter().position(|api| api.api == place.api).unwrap_or_else(|| {
                apis.push(IocrApi { api: place.api, ..IocrApi::default() });
                apis.len() - 1
            });
            let object =
                FrameObject { slot_number: place.slot, subslot_number: place.subslot, frame_offset: place.at as u16 };
            let list = if is_data { &mut apis[at].io_data_objects } else { &mut apis[at].iocs };
            list.push(object);
        }
        apis
    }
}

impl ConnectSubmodule {
    /// Whether the submodule is in the input frame: it has input data, or no data at all.
    fn has_input(&self) -> bool {
        self.input_octets > 0 || self.output_octets == 0
    }

    fn place(&self, at: usize, octets: u16) -> IoDataPosition {
        IoDataPosition { api: self.api, slot: self.slot, subslot: self.subslot, at, octets: octets.into() }
    }

    fn expected(&self) -> ExpectedSubmodule {
        let (input, output) = (DataDescription::input(self.input_octets), DataDescription::output(self.output_octets));
        let (kind, data_descriptions) = match (self.input_octets, self.output_octets) {
            (0, 0) => (SubmoduleType::NO_IO, [input].into()),
            (_, 0) => (SubmoduleType::INPUT, [input].into()),
            (0, _) => (SubmoduleType::OUTPUT, [output].into()),
            _ => (SubmoduleType::INPUT_OUTPUT, [input, output].into()),
        };
        ExpectedSubmodule {
            subslot_number: self.subslot,
            submodule_ident_number: self.submodule_ident,
            submodule_properties: kind.into(),
            data_descriptions,
        }
    }
}

/// The ExpectedSubmoduleBlockReqs for these submodules: one block per slot, with one entry per API.
pub fn expected(submodules: &[ConnectSubmodule]) -> Vec<ExpectedSubmoduleBlockReq> {
    let mut blocks: Vec<ExpectedSubmoduleBlockReq> = Vec::new();
    for submodule in submodules {
        let slot = submodule.slot;
        let block = match blocks.iter().position(|block| block.modules.iter().any(|module| module.slot_number == slot))
        {
            Some(at) => at,
            None => {
                blocks.push(ExpectedSubmoduleBlockReq::default());
                blocks.len() - 1
            }
        };
        let modules = &mut blocks[block].modules;
        match modules.iter_mut().find(|module| module.api == submodule.api) {
            Some(module) => module.submodules.push(submodule.expected()),
            None => modules.push(ExpectedModule {
                api: submodule.api,
                slot_number: slot,
                module_ident_number: submodule.module_ident,
                module_properties: 0,
                submodules: [submodule.expected()].into(),
            }),
        }
    }
    blocks
}
