//! Puts a live device on PROFINET back as it was found: parameters and I&M over its present address, then the name, the IP address last.
//!
//! A connection sets no address here, since a temporary one erases a stored one. This module judges no requirement.

use super::startup;
use crate::live::{DeviceBackup, RestoreOutcome};
use crate::trial::RunningTrial;
use controllers::profinet_io::{
    ControllerOutcome, ControllerRequest, DcpOutcome, IdentifiedStation, IoRecordOutcome, RecordAddress,
};
use results::bench_file::DcpPermanence;
use results::journal::{InitialDevice, InitialImRecord};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, DcpBlock, DcpValue};

impl RunningTrial<'_> {
    /// Restores the device; both of the harness's connections are ended first.
    pub(super) fn restore_device(&mut self, found: &InitialDevice, kept: &DeviceBackup<'_>) -> RestoreOutcome {
        let mut outcome = RestoreOutcome::default();
        let Some(mac) = self.environment.mac else {
            outcome.left.push("anything, since the device is not known".to_owned());
            return outcome;
        };
        self.mac = mac;
        let Some(present) = self.present_station() else {
            outcome.left.push(format!("anything: {mac} does not answer DCP Identify; check its power and cable"));
            return outcome;
        };
        // No device without a name can be connected.
        let needs_name = present.name.is_empty() && !found.name.is_empty();
        if needs_name {
            self.restore_name(found, kept, &mut outcome);
        }
        self.renamed = present.name.is_empty() || present.name != self.environment.name.as_bytes();
        self.keeps_address = !present.ip.address.is_unspecified();
        self.restore_values(kept, &mut outcome);
        // What was temporary is set again: a name that looks the same may be stored now.
        if !needs_name || found.name_permanence == DcpPermanence::Temporary {
            self.restore_name(found, kept, &mut outcome);
        }
        self.restore_ip(found, kept, &mut outcome);
        outcome
    }

    /// The device as it answers now.
    fn present_station(&mut self) -> Option<IdentifiedStation> {
        self.identify_device().ok().flatten()
    }

    fn restore_name(&mut self, found: &InitialDevice, kept: &DeviceBackup<'_>, outcome: &mut RestoreOutcome) {
        let is_back = |now: Option<IdentifiedStation>| now.is_some_and(|now| now.name == found.name);
        let is_temporary = found.name_permanence == DcpPermanence::Temporary;
        if is_back(self.present_station()) && !(is_temporary && kept.set_name()) {
            return;
        }
        let qualifier = if is_temporary { BlockQualifier::TEMPORARY } else { BlockQualifier::PERMANENT };
        let set = self.give(qualifier, DcpValue::NameOfStation(found.name.clone()));
        if let Err(why) = set.and_then(|()| has_taken(is_back(self.present_station()))) {
            outcome
                .left
                .push(format!("the station name `{}`: {why}", String::from_utf8_lossy(&found.name).escape_debug()));
        }
    }

    /// Sets address, mask and gateway by one block, with the permanence that they had.
    fn restore_ip(&mut self, found: &InitialDevice, kept: &DeviceBackup<'_>, outcome: &mut RestoreOutcome) {
        let address = IpParameter { address: found.ip, mask: found.mask, gateway: found.gateway };
        let is_back = |now: Option<IdentifiedStation>| now.is_some_and(|now| now.ip == address);
        let present = self.present_station();
        // The address that a power cycle before any change has erased was temporary.
        let was_erased =
            kept.only_cycled_power() && present.as_ref().is_some_and(|now| now.ip.address.is_unspecified());
        if !kept.set_ip() && is_back(present) {
            return;
        }
        let had_none = address.address.is_unspecified();
        let qualifier = match found.ip_permanence {
            _ if had_none && !kept.stored_ip() => BlockQualifier::TEMPORARY,
            DcpPermanence::Temporary => BlockQualifier::TEMPORARY,
            DcpPermanence::Unknown if was_erased => BlockQualifier::TEMPORARY,
            DcpPermanence::Permanent | DcpPermanence::Unknown => BlockQualifier::PERMANENT,
        };
        let text = if had_none {
            "the IP address, of which it had none".to_owned()
        } else {
            format!("the IP address {} with mask {} and gateway {}", found.ip, found.mask, found.gateway)
        };
        let set = self.give(qualifier, DcpValue::IpParameter(address));
        match set.and_then(|()| has_taken(is_back(self.present_station()))) {
            Ok(()) if !had_none && !was_erased && found.ip_permanence == DcpPermanence::Unknown => outcome.remarks.push(format!(
                "{text}: whether it was stored is not known, so it was stored; say so by `ip_permanence` in the bench file"
            )),
            Ok(()) => {}
            Err(why) if had_none && !kept.stored_ip() => {
                outcome.remarks.push(format!("the IP address of the run stays until power-off: {why}"));
            }
            Err(why) => outcome.left.push(format!("{text}: {why}")),
        }
    }

    /// Sends a DCP Set of one block; the error is the device's refusal with its block error.
    fn give(&mut self, qualifier: BlockQualifier, value: DcpValue) -> Result<(), String> {
        let blocks = vec![DcpBlock::set(qualifier, value)];
        match self.ask(false, ControllerRequest::DcpSet { to: self.mac, blocks }) {
            Ok(ControllerOutcome::Dcp(DcpOutcome::Accepted)) => Ok(()),
            Ok(outcome) => Err(refusal(&outcome)),
            Err(trouble) => Err(trouble.what),
        }
    }

    /// Writes one of I&M1 to I&M4, unless it is as before.
    pub(super) fn write_back_im_record(&mut self, record: &InitialImRecord) -> Result<(), String> {
        let InitialImRecord { api, slot, subslot, index, octets } = record;
        let target = RecordAddress { api: *api, slot: *slot, subslot: *subslot, index: *index };
        if self.record_now(target).as_ref() == Some(octets) {
            return Ok(());
        }
        match self.ask(false, ControllerRequest::Write { target, data: octets.clone() }) {
            Ok(ControllerOutcome::Record(IoRecordOutcome::Accepted { .. })) => {}
            Ok(ControllerOutcome::Record(outcome)) => return Err(startup::record(&outcome, true).to_string()),
            Ok(outcome) => return Err(refusal(&outcome)),
            Err(trouble) => return Err(trouble.what),
        }
        has_taken(self.record_now(target).as_ref() == Some(octets))
    }
}

/// Why a request has no effect, with the block error of a refused DCP Set.
fn refusal(outcome: &ControllerOutcome) -> String {
    match outcome {
        ControllerOutcome::Dcp(outcome) => outcome.to_string(),
        ControllerOutcome::Impossible(why) => (*why).to_owned(),
        _ => "another request is running".to_owned(),
    }
}

/// The error of a value that a device accepts and does not have afterwards.
fn has_taken(is_there: bool) -> Result<(), String> {
    if is_there { Ok(()) } else { Err("the device accepts it and reports another value".to_owned()) }
}
