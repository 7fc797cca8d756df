//! The identity that a device reports: DCP, records 0xF821 and 0xF000, I&M0.

use std::fmt;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::identification::{ApiData, IdentificationData};
use wire::profinet::blocks::im::Im0;

/// The identity that a device reports; parts that were not read are empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReportedIdentity {
    /// Vendor ID and device ID, from DCP.
    pub ids: Option<(u16, u16)>,
    /// Its APIs, from record 0xF821.
    pub apis: Option<Vec<u32>>,
    /// The plugged submodules, from record 0xF000 of each API.
    pub plugged: Vec<PluggedSubmodule>,
    /// I&M0 of the device.
    pub im0: Option<Im0>,
}

/// A plugged submodule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PluggedSubmodule {
    /// API.
    pub api: u32,
    /// Slot number.
    pub slot: u16,
    /// Ident number of the module.
    pub module_ident: u32,
    /// Subslot number.
    pub subslot: u16,
    /// Ident number of the submodule.
    pub submodule_ident: u32,
    /// Bytes of input and output data, if known (records 0x8028 and 0x8029, or an accepted connection).
    pub octets: Option<(u16, u16)>,
}

/// Why a record of a device cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the device's answer to record 0x{index:04X} cannot be used: {why}")]
pub struct ReportedIdentityError {
    /// The index of the record.
    pub index: u16,
    /// What is wrong.
    pub why: String,
}

/// A connection accepted without difference; it shows the lengths of a plugged submodule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AcceptedSubmodule {
    /// Slot number.
    pub slot: u16,
    /// Subslot number.
    pub subslot: u16,
    /// Ident number of the submodule.
    pub ident: u32,
    /// Bytes of input data.
    pub input: u16,
    /// Bytes of output data.
    pub output: u16,
}

impl ReportedIdentity {
    /// Takes vendor ID and device ID from a DCP answer.
    pub fn ids(&mut self, vendor_id: u16, device_id: u16) {
        self.ids = Some((vendor_id, device_id));
    }

    /// Takes the answer to record 0xF821; returns the APIs, for each of which record 0xF000 can be read.
    ///
    /// # Errors
    ///
    /// The answer is not a list of APIs.
    pub fn take_apis(&mut self, octets: &[u8]) -> Result<Vec<u32>, ReportedIdentityError> {
        let data = ApiData::parse(octets).map_err(|error| wrong(0xF821, &error))?;
        self.apis = Some(data.apis.clone());
        Ok(data.apis)
    }

    /// Takes the answer to record 0xF000, read for one API; a block version without an API means `api`.
    ///
    /// # Errors
    ///
    /// The answer is not a RealIdentificationData.
    pub fn take_real(&mut self, api: u32, octets: &[u8]) -> Result<(), ReportedIdentityError> {
        let blocks = IdentificationData::parse_record(octets).map_err(|error| wrong(0xF000, &error))?;
        if let Some(other) = blocks.iter().find(|block| block.kind != BlockType::REAL_IDENTIFICATION) {
            return Err(wrong(0xF000, &format_args!("it contains a block of type 0x{:04X}", other.kind.0)));
        }
        for block in blocks {
            for of in block.apis {
                let api = if block.with_apis { of.api } else { api };
                for slot in of.slots {
                    for subslot in slot.subslots {
                        let plugged = PluggedSubmodule {
                            api,
                            slot: slot.slot,
                            module_ident: slot.module_ident,
                            subslot: subslot.subslot,
                            submodule_ident: subslot.submodule_ident,
                            octets: None,
                        };
                        let place = |known: &&mut PluggedSubmodule| {
                            (known.api, known.slot, known.subslot) == (api, plugged.slot, plugged.subslot)
                        };
                        match self.plugged.iter_mut().find(place) {
                            Some(known) => *known = plugged,
                            None => self.plugged.push(plugged),
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Takes I&M0 (record 0xAFF0).
    ///
    /// # Errors
    ///
    /// The answer is not I&M0.
    pub fn take_im0(&mut self, octets: &[u8]) -> Result<(), ReportedIdentityError> {
        let mut reader = wire::octets::ByteReader::new("I&M0", octets);
        self.im0 = Some(Im0::read(&mut reader).map_err(|error| wrong(0xAFF0, &error))?);
        Ok(())
    }

    /// Takes the lengths of a plugged submodule from an accepted connection.
    pub fn take_connected(&mut self, connected: AcceptedSubmodule) {
        let AcceptedSubmodule { slot, subslot, ident, input, output } = connected;
        let is_same = |of: &&mut PluggedSubmodule| (of.slot, of.subslot, of.submodule_ident) == (slot, subslot, ident);
        for plugged in self.plugged.iter_mut().filter(is_same) {
            plugged.octets = Some((input, output));
        }
    }
}

fn wrong(index: u16, why: &dyn fmt::Display) -> ReportedIdentityError {
    ReportedIdentityError { index, why: why.to_string() }
}
