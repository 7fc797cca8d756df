//! What the frames of drawn sequences may change of a device.
//!
//! A sequence is drawn at random, so that what a step changes is not known from its name: a preset may hide in any byte of outputs.
//! [`FrameLimits`] therefore judges each frame to the device, as it is about to be sent, after the filter of the wire or the bus. What it
//! cannot read is not sent, nor an output bit without a name, nor a record or a parameter that neither manual nor description names.

mod ethernet;
mod fieldbus;
mod outputs;
mod parameters;
#[cfg(test)]
mod tests;

use outputs::OutputLayout;
use results::bench_file::{BenchFile, Consents};
use results::journal::change;
use std::sync::Arc;
use suite::device::{Changed, DeviceDescription, DeviceRecord, is_reserved};
use wire::ethernet::Mac;
use wire::profinet::rpc::Reassembler;

/// The most calls whose fragments are collected at the same time.
const MOST_CALLS: usize = 4;
/// The longest call in bytes.
const LONGEST_CALL: usize = 65_536;

/// What one frame changes that lasts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct LastingFrameChanges {
    position_reference: bool,
    factory_reset: bool,
    firmware: bool,
    im_records: bool,
    parameters: bool,
    name: bool,
    ip: bool,
    address: bool,
    /// Number of writes to non-volatile memory.
    writes: u32,
}

impl LastingFrameChanges {
    fn and(self, other: LastingFrameChanges) -> LastingFrameChanges {
        LastingFrameChanges {
            position_reference: self.position_reference || other.position_reference,
            factory_reset: self.factory_reset || other.factory_reset,
            firmware: self.firmware || other.firmware,
            im_records: self.im_records || other.im_records,
            parameters: self.parameters || other.parameters,
            name: self.name || other.name,
            ip: self.ip || other.ip,
            address: self.address || other.address,
            writes: self.writes.saturating_add(other.writes),
        }
    }

    /// The words of the journal.
    fn words(self) -> impl Iterator<Item = &'static str> {
        let words = [
            (self.position_reference, change::POSITION_REFERENCE),
            (self.factory_reset, change::FACTORY_RESET),
            (self.im_records, change::IM_RECORDS),
            (self.parameters, change::PARAMETERS),
            (self.name, change::NAME),
            (self.ip, change::IP),
            (self.address, "set_address"),
            (self.writes > 0, change::MEMORY),
        ];
        words.into_iter().filter(|(is, _)| *is).map(|(_, word)| word)
    }
}

/// The last filter for the frames of drawn sequences.
#[derive(Clone, Debug)]
pub struct FrameLimits {
    device: Arc<DeviceDescription>,
    consent: Consents,
    /// Whether nothing is driven by the position.
    is_uncoupled: bool,
    direct_cable: bool,
    writes_left: u32,
    /// The changes whose output bits were set in the last frame, so that they do not begin again in the next one.
    held: Vec<Changed>,
    /// Whether the status of that frame said that the device may use it.
    is_held_taken: bool,
    /// The outputs in the last Connect of each controller (PROFINET).
    layouts: Vec<(Mac, OutputLayout)>,
    calls: Reassembler,
    /// The outputs in the last Chk_Cfg (PROFIBUS).
    configured: Option<OutputLayout>,
    /// The words of the changes so far.
    changes: Vec<&'static str>,
    /// How many of them have been taken by [`FrameLimits::take_new_changes`].
    taken: usize,
}

impl FrameLimits {
    /// The limits of a device on its bench, with this number of permitted memory writes.
    pub fn new(device: &Arc<DeviceDescription>, bench: &BenchFile, writes: u32) -> FrameLimits {
        FrameLimits {
            device: device.clone(),
            consent: bench.consent,
            is_uncoupled: bench.stand.shaft.uncoupled,
            direct_cable: bench.direct_cable,
            writes_left: writes,
            held: Vec::new(),
            is_held_taken: false,
            layouts: Vec::new(),
            calls: Reassembler::new(MOST_CALLS, LONGEST_CALL),
            configured: None,
            changes: Vec::new(),
            taken: 0,
        }
    }

    /// How many memory writes are left.
    pub fn writes_left(&self) -> u32 {
        self.writes_left
    }

    /// The changes, in the words of the journal, that a frame makes which has just been allowed, and no frame before.
    pub fn take_new_changes(&mut self) -> &[&'static str] {
        let from = std::mem::replace(&mut self.taken, self.changes.len());
        self.changes.get(from..).unwrap_or_default()
    }

    /// Counts the changes of a frame; fails if one is not permitted.
    fn permit(&mut self, changes: LastingFrameChanges) -> Result<(), String> {
        let consent = &self.consent;
        let without = |what: &str, consent: &str| Err(format!("{what} without the consent {consent}"));
        if changes.firmware {
            return Err("a change that waits for another firmware, which no sequence makes".to_owned());
        }
        if changes.position_reference && !consent.position_reference {
            return without("a preset", "position_reference");
        }
        if changes.position_reference && !self.is_uncoupled {
            return Err("a preset, and the stand does not say `shaft: [uncoupled]`".to_owned());
        }
        if changes.factory_reset && !consent.factory_reset {
            return without("a reset to factory settings", "factory_reset");
        }
        if changes.im_records && !consent.im_records {
            return without("a write of I&M1 to I&M4", "im_records");
        }
        if changes.name && !consent.set_name {
            return without("a station name", "set_name");
        }
        if changes.ip && !consent.set_ip {
            return without("a permanent IP address", "set_ip");
        }
        if changes.address && !consent.set_address {
            return without("a station address", "set_address");
        }
        if changes.writes > self.writes_left {
            return Err(format!("a memory write, and {} of those of the bench are left", self.writes_left));
        }
        self.writes_left -= changes.writes;
        for word in changes.words() {
            if !self.changes.contains(&word) {
                self.changes.push(word);
            }
        }
        Ok(())
    }

    /// What setting or writing this changes according to the manual.
    fn declared(&self, hit: impl Fn(&Changed) -> bool) -> LastingFrameChanges {
        let changes = &self.device.changes;
        LastingFrameChanges {
            position_reference: changes.position_reference.iter().any(&hit),
            factory_reset: changes.factory_reset.iter().any(&hit),
            firmware: changes.firmware.iter().any(&hit),
            writes: u32::from(changes.nvm_write.iter().any(&hit)),
            ..LastingFrameChanges::default()
        }
    }
}

/// Why these bytes are not those of a record: another length, or bits set that no field has.
fn objection_to_record(record: &DeviceRecord, data: &[u8]) -> Option<String> {
    if data.len() != record.octets {
        return Some(format!("{} with {} bytes", record.name, data.len()));
    }
    let mut named = vec![0_u8; record.octets];
    for field in record.fields.iter().filter(|field| field.absent.is_none() && !is_reserved(&field.name)) {
        let bits = match field.bits {
            Some((low, width)) => (u16::from(u8::MAX) >> (8 - width.clamp(1, 8)) << low) as u8,
            None => u8::MAX,
        };
        let end = named.len().min(field.octet.saturating_add(field.octets));
        named.get_mut(field.octet.min(end)..end).unwrap_or_default().iter_mut().for_each(|octet| *octet |= bits);
    }
    let usual = record.bytes();
    let differs = data.iter().zip(usual).zip(named).any(|((octet, usual), named)| (octet ^ usual) & !named != 0);
    differs.then(|| format!("a bit of {} without a name", record.name))
}
