//! Parameter requests and records that are written.

use super::{FrameLimits, LastingFrameChanges, objection_to_record};
use std::ops::RangeInclusive;
use suite::device::Changed;
use wire::profidrive::parameter::{ParameterRequest, RequestId};

/// The parameter accesses of PROFIdrive that a device may have beside that of its manual: base mode local and global, and the older one.
const PARAMETER_ACCESS: [u16; 3] = [0xB02E, 0xB02F, 0x002F];
/// P971: transfer into the non-volatile memory.
const SAVE: u16 = 971;
/// P970: load the factory settings.
const LOAD_FACTORY_SETTINGS: u16 = 970;
/// P972: reset of the drive, for which no consent exists.
const RESET: u16 = 972;
/// The records I&M1 to I&M4.
const IM_RECORDS: RangeInclusive<u16> = 0xAFF1..=0xAFF4;
/// From here on the standard says what a record is; those that are no start records are identification or diagnosis.
const FIRST_STANDARD: u16 = 0x8000;
/// The most bytes of I&M1 to I&M4 with their header.
const LONGEST_IM: usize = 64;

impl FrameLimits {
    /// What writing a record changes; `at` is slot, subslot and index.
    pub(super) fn record_changes(&self, at: (u16, u16, u16), data: &[u8]) -> Result<LastingFrameChanges, String> {
        let (slot, subslot, index) = at;
        if index == self.device.parameter_access.index || PARAMETER_ACCESS.contains(&index) {
            return self.parameter_changes(data);
        }
        let is_there =
            |of: usize| self.device.submodules.get(of).is_some_and(|of| (of.slot, of.subslot) == (slot, subslot));
        let mut known = self.device.records.iter().enumerate().filter(|(_, of)| of.index == index && is_there(of.at));
        let Some((number, record)) = known.next() else {
            return Err(format!("a write of record 0x{index:X}, which neither manual nor description has there"));
        };
        let declared = self.declared(|changed| *changed == Changed::Record(number));
        if IM_RECORDS.contains(&index) {
            if data.len() > LONGEST_IM {
                return Err(format!("{} with {} bytes", record.name, data.len()));
            }
            return Ok(LastingFrameChanges { im_records: true, writes: declared.writes.max(1), ..declared });
        }
        if !record.start && index >= FIRST_STANDARD {
            return Err(format!("a write of {}, which is only read", record.name));
        }
        match objection_to_record(record, data) {
            Some(why) => Err(why),
            None => Ok(declared),
        }
    }

    /// What a parameter request changes.
    pub(super) fn parameter_changes(&self, request: &[u8]) -> Result<LastingFrameChanges, String> {
        // The second byte says what is requested; every other value than reading may be taken for a change.
        if request.get(1) == Some(&RequestId::REQUEST.0) {
            return Ok(LastingFrameChanges::default());
        }
        let parsed = ParameterRequest::parse(request).ok().filter(|parsed| parsed.rest.is_empty());
        let Some(parsed) = parsed else {
            return Err("a parameter request that cannot be read and does not read".to_owned());
        };
        let mut changes = LastingFrameChanges { parameters: true, ..LastingFrameChanges::default() };
        for address in &parsed.addresses {
            let number = address.number;
            if number == RESET {
                return Err("a write of P972, which no sequence makes".to_owned());
            }
            let known = self.device.parameters.iter().enumerate().find(|(_, of)| of.number == number && of.writable);
            let Some((index, parameter)) = known else {
                return Err(format!(
                    "a write of P{number}, which neither manual nor description has as a writable one"
                ));
            };
            let saves = [SAVE, self.device.parameter_access.save].contains(&number) || parameter.permanent;
            let declared = self.declared(|changed| *changed == Changed::Parameter(index));
            let writes = declared.writes.max(u32::from(saves));
            let factory_reset = declared.factory_reset || number == LOAD_FACTORY_SETTINGS;
            changes = changes.and(LastingFrameChanges { writes, factory_reset, ..declared });
        }
        Ok(changes)
    }
}
