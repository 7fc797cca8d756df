//! Cyclic outputs: which bits are set, and what they change.

use super::{FrameLimits, LastingFrameChanges};
use std::ops::Range;
use suite::device::{Changed, DeviceSignal, is_reserved};
use wire::octets::mask;

/// Where the outputs of a device are in cyclic data.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct OutputLayout {
    /// Length of the data in bytes.
    pub octets: usize,
    pub areas: Vec<OutputArea>,
    /// The positions of the status of outputs and inputs (PROFINET).
    pub statuses: Vec<usize>,
}

/// The outputs of a submodule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct OutputArea {
    pub at: Range<usize>,
    /// Its signals in order; `None` if the device description has no such submodule.
    pub signals: Option<Vec<usize>>,
}

/// The bits of a signal that have a name.
fn named_bits(signal: &DeviceSignal) -> u64 {
    if signal.fields.is_empty() {
        return if is_reserved(&signal.name) { 0 } else { mask(0, signal.width) };
    }
    let named = signal.fields.iter().filter(|field| !is_reserved(&field.name));
    named.fold(0, |bits, field| bits | field.mask())
}

/// The number in the bytes of a signal.
fn number(signal: &DeviceSignal, octets: &[u8]) -> u64 {
    let add = |number: u64, octet: &u8| number << 8 | u64::from(*octet);
    if signal.little_endian { octets.iter().rev().fold(0, add) } else { octets.iter().fold(0, add) }
}

impl FrameLimits {
    /// Judges outputs, and counts what they change. `is_taken`: the status says that the device may use them.
    pub(super) fn judge_outputs(&mut self, layout: &OutputLayout, data: &[u8], is_taken: bool) -> Result<(), String> {
        let mut set: Vec<Changed> = Vec::new();
        for area in &layout.areas {
            let octets = data.get(area.at.clone()).ok_or("outputs that are shorter than the connection says")?;
            let Some(signals) = &area.signals else {
                if octets.iter().any(|octet| *octet != 0) {
                    return Err("outputs that are not zero, of a submodule that the manual does not name".to_owned());
                }
                continue;
            };
            let mut rest = octets;
            for index in signals {
                let Some(signal) = self.device.signals.get(*index) else { continue };
                let length = (signal.width as usize / 8).min(rest.len());
                let (own, more) = rest.split_at(length);
                rest = more;
                let value = number(signal, own);
                if value & !named_bits(signal) != 0 {
                    return Err(format!("an output bit of {} without a name", signal.name));
                }
                let changes = &self.device.changes;
                let all = [&changes.position_reference, &changes.nvm_write, &changes.factory_reset, &changes.firmware];
                set.extend(all.into_iter().flatten().filter(|changed| sets(changed, *index, value)));
            }
            if rest.iter().any(|octet| *octet != 0) {
                return Err("an output byte without a name".to_owned());
            }
        }
        let changes = set.iter().fold(LastingFrameChanges::default(), |changes, one| {
            let declared = self.declared(|changed| changed == one);
            changes.and(LastingFrameChanges { writes: 0, ..declared })
        });
        // A bit that stays set does not write again; one that the device did not take in before may.
        let begins = |of: &&Changed| set.contains(of) && (!self.held.contains(of) || is_taken && !self.is_held_taken);
        let writes = self.device.changes.nvm_write.iter().filter(begins).count() as u32;
        self.permit(LastingFrameChanges { writes, ..changes })?;
        (self.held, self.is_held_taken) = (set, is_taken);
        Ok(())
    }
}

/// Whether this value of a signal makes the change.
fn sets(changed: &Changed, index: usize, value: u64) -> bool {
    match changed {
        Changed::Signal { signal, low, width } => *signal == index && value & mask(*low, *width) != 0,
        Changed::Parameter(_) | Changed::Record(_) | Changed::Page(_) => false,
    }
}
