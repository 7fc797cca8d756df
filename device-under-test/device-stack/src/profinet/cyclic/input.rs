//! The place of a submodule in the frames that the device sends.

/// The position of the data of a submodule in the frame. Its IOPS follows them.
#[derive(Clone, Copy, Debug)]
pub(super) struct InputOffset {
    pub slot: u16,
    pub subslot: u16,
    pub at: usize,
    pub octets: usize,
    pub is_usable: bool,
}

/// The position of the IOCS of a submodule in the frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct IocsOffset {
    pub slot: u16,
    pub subslot: u16,
    pub at: usize,
    pub is_usable: bool,
}
