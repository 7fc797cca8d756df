//! Start records of a vendor that the manual does not list: the GSDML has them, with their defaults.

use device_stack::profinet::{RecordAccess, StackCheck, StackHooks};
use wire::profinet::status::RecordError;

/// A start record that only the GSDML describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VendorRecord {
    /// The slot of its submodule.
    pub slot: u16,
    /// The subslot of its submodule.
    pub subslot: u16,
    /// The index of the record.
    pub index: u16,
    /// The default of each byte, which a controller without other values sends.
    pub default: &'static [u8],
}

/// One record of the access point and one of the first module.
pub(super) static RECORDS: [VendorRecord; 2] = [
    VendorRecord { slot: 0, subslot: 1, index: 0x0200, default: &[0x12, 0x34, 0x56] },
    VendorRecord { slot: 1, subslot: 1, index: 0x0201, default: &[0xA5, 0x00, 0x5A, 0x01] },
];

/// A device that needs these records in each start-up.
#[derive(Default)]
pub struct VendorRecords {
    written: [bool; RECORDS.len()],
}

impl StackHooks for VendorRecords {
    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        match check {
            // What is written stays with the device while another controller shares it.
            StackCheck::ConnectionLimit { is_exchange: true, others: 0 } => {
                if verdict {
                    self.written = Default::default();
                }
                verdict
            }
            // Another controller may have the modules of other slots alone, to which no record belongs.
            StackCheck::Usable(slot, _) if RECORDS.iter().any(|of| of.slot == slot) => {
                verdict && self.written.iter().all(|is_written| *is_written)
            }
            _ => verdict,
        }
    }

    fn written(&mut self, access: RecordAccess, data: &[u8], result: &mut Result<(), RecordError>) {
        let is_it = |of: &VendorRecord| (of.slot, of.subslot, of.index) == (access.slot, access.subslot, access.index);
        let Some(at) = RECORDS.iter().position(is_it) else { return };
        let is_right = RECORDS.get(at).is_some_and(|of| of.default == data);
        if let Some(written) = self.written.get_mut(at) {
            *written = is_right;
        }
        *result = if is_right { Ok(()) } else { Err(RecordError::INVALID_PARAMETER) };
    }
}
