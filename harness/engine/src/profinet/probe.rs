//! Reads firmware, name, address and records of a live device on PROFINET, and restores name and address.
//!
//! It judges no requirement.

use crate::live::ParameterBackup;
use crate::trial::RunningTrial;
use controllers::profinet_io::{
    ControllerOutcome, ControllerRequest, DcpOutcome, IoParameterOutcome, IoRecordOutcome, RecordAddress,
};
use results::journal::InitialDevice;
use suite::device;
use wire::profinet::blocks::im::Im0;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, DcpBlock, DcpValue};

/// Index of I&M0.
const IM0: u16 = 0xAFF0;
/// The longest record that is read, in bytes.
const LENGTH: u32 = 1024;

impl RunningTrial<'_> {
    /// The firmware revision in I&M0, read in the present connection.
    pub(super) fn firmware_in_im0(&mut self) -> Option<String> {
        let target = RecordAddress { api: 0, slot: 0, subslot: 1, index: IM0 };
        let Ok(ControllerOutcome::Record(IoRecordOutcome::Accepted { data })) =
            self.ask(false, ControllerRequest::Read { target, length: LENGTH })
        else {
            return None;
        };
        let revision = Im0::parse(&data).ok()?.software_revision;
        Some(format!("{}.{}.{}", revision.functional_enhancement, revision.bug_fix, revision.internal_change))
    }

    /// The response to a parameter request in the present connection.
    pub(super) fn record_response(&mut self, request: Vec<u8>) -> Option<Vec<u8>> {
        let at = self.parameter_access_point()?;
        match self.ask(false, ControllerRequest::Parameter { at, request }) {
            Ok(ControllerOutcome::Parameter(IoParameterOutcome::Answer(octets))) => Some(octets),
            _ => None,
        }
    }

    /// Whether the device accepts reading a record.
    pub(super) fn answers_record(&mut self, record: &device::DeviceRecord) -> Option<bool> {
        let at = self.world.manual.device.submodules.get(record.at)?;
        let target = RecordAddress { api: at.api, slot: at.slot, subslot: at.subslot, index: record.index };
        let outcome = self.ask(false, ControllerRequest::Read { target, length: LENGTH });
        Some(matches!(outcome, Ok(ControllerOutcome::Record(IoRecordOutcome::Accepted { .. }))))
    }

    /// Restores the state of the device before the run; returns what could not be restored, in words.
    pub(super) fn restore_all(&mut self, found: &InitialDevice, kept: &ParameterBackup<'_>) -> Vec<String> {
        let mut left = Vec::new();
        let Some(mac) = self.environment.mac else { return vec!["anything, since the device is not known".into()] };
        self.mac = mac;
        // A connection needs a station name: an old name is restored before it, an empty one after it.
        let has_name = !found.name.is_empty();
        if has_name {
            self.restore_name(found, &mut left);
        }
        self.restore_parameters(kept, &mut left);
        if !has_name {
            self.restore_name(found, &mut left);
        }
        // A connection has given it the IP address of the bench.
        self.restore_ip(found, &mut left);
        left
    }

    fn restore_name(&mut self, found: &InitialDevice, left: &mut Vec<String>) {
        self.renamed = true;
        let consent = self.environment.bench.as_ref().is_some_and(|bench| bench.consent.set_name);
        let name = || DcpValue::NameOfStation(found.name.clone());
        match self.identify_device() {
            Ok(Some(now)) if now.name == found.name => {}
            Ok(Some(_)) if consent && self.give(BlockQualifier::PERMANENT, name()) => {}
            _ => left.push(format!("the station name `{}`", String::from_utf8_lossy(&found.name).escape_debug())),
        }
    }

    fn restore_ip(&mut self, found: &InitialDevice, left: &mut Vec<String>) {
        // A device without an IP address got one for the run only.
        if found.ip.is_unspecified() {
            return;
        }
        let consent = self.environment.bench.as_ref().is_some_and(|bench| bench.consent.set_ip);
        let address = IpParameter { address: found.ip, mask: found.mask, gateway: found.gateway };
        match self.identify_device() {
            Ok(Some(now)) if now.ip == address => {}
            Ok(Some(_)) if consent && self.give(BlockQualifier::PERMANENT, DcpValue::IpParameter(address)) => {}
            _ => left.push(format!("the IP address {}", found.ip)),
        }
    }

    fn give(&mut self, qualifier: BlockQualifier, value: DcpValue) -> bool {
        let blocks = vec![DcpBlock::set(qualifier, value)];
        let outcome = self.ask(false, ControllerRequest::DcpSet { to: self.mac, blocks });
        matches!(outcome, Ok(ControllerOutcome::Dcp(DcpOutcome::Accepted)))
    }
}
