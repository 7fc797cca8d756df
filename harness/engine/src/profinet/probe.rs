//! Reads firmware and records of a live device on PROFINET.
//!
//! It judges no requirement.

use crate::trial::RunningTrial;
use controllers::profinet_io::{
    ControllerOutcome, ControllerRequest, IoParameterOutcome, IoRecordOutcome, Partner, RecordAddress,
};
use results::journal::InitialImRecord;
use std::ops::RangeInclusive;
use suite::device;
use wire::profinet::blocks::im::Im0;
use wire::profinet::rpc::ObjectUuid;

/// Index of I&M0.
const IM0: u16 = 0xAFF0;
/// Indices of I&M1 to I&M4, which are stored in the device.
const STORED_IM: RangeInclusive<u16> = 0xAFF1..=0xAFF4;
/// The longest record that is read, in bytes.
const LENGTH: u32 = 1024;

impl RunningTrial<'_> {
    /// I&M0, read in the present connection.
    fn im0(&mut self) -> Option<Im0> {
        let target = RecordAddress { api: 0, slot: 0, subslot: 1, index: IM0 };
        let Ok(ControllerOutcome::Record(IoRecordOutcome::Accepted { data })) =
            self.ask(false, ControllerRequest::Read { target, length: LENGTH })
        else {
            return None;
        };
        Im0::parse(&data).ok()
    }

    /// The order number in I&M0.
    pub(super) fn order_number_in_im0(&mut self) -> Option<String> {
        let im0 = self.im0()?;
        Some(String::from_utf8_lossy(&im0.order_id).trim_end_matches(['\0', ' ']).to_owned())
    }

    /// Order number, serial number and hardware revision in I&M0.
    pub(super) fn identification_in_im0(&mut self) -> Vec<(String, String)> {
        let Some(im0) = self.im0() else { return Vec::new() };
        let text = |octets: &[u8]| {
            let end = octets.iter().rposition(|octet| ![0, b' '].contains(octet)).map_or(0, |at| at + 1);
            plain_text::escaped(&octets[..end])
        };
        vec![
            ("order number".to_owned(), text(&im0.order_id)),
            ("serial number".to_owned(), text(&im0.serial_number)),
            ("hardware revision".to_owned(), im0.hardware_revision.to_string()),
        ]
    }

    /// The firmware revision in I&M0.
    pub(super) fn firmware_in_im0(&mut self) -> Option<String> {
        let revision = self.im0()?.software_revision;
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

    /// I&M1 to I&M4 of every submodule that the manual knows and the device has.
    pub(super) fn im_records_now(&mut self) -> Vec<InitialImRecord> {
        let mut places: Vec<(u32, u16, u16)> = Vec::new();
        for of in &self.world.manual.device.submodules {
            let place = (of.api, of.slot, of.subslot);
            if !places.contains(&place) {
                places.push(place);
            }
        }
        let each = places.into_iter().flat_map(|place| STORED_IM.map(move |index| (place, index)));
        let mut records = Vec::new();
        for ((api, slot, subslot), index) in each {
            if let Some(octets) = self.record_now(RecordAddress { api, slot, subslot, index }) {
                records.push(InitialImRecord { api, slot, subslot, index, octets });
            }
        }
        records
    }

    /// A record, read in the present connection or without one.
    pub(super) fn record_now(&mut self, target: RecordAddress) -> Option<Vec<u8>> {
        let request = if self.world.stations.is_connected(0) {
            ControllerRequest::Read { target, length: LENGTH }
        } else {
            let partner = Partner { mac: self.mac, ip: self.environment.ip.address };
            let (vendor_id, device_id) = self.world.manual.device.ids().unwrap_or_default();
            let object = ObjectUuid { instance: 1, device_id, vendor_id };
            ControllerRequest::ReadImplicit { partner, object, target, length: LENGTH }
        };
        match self.ask(false, request) {
            Ok(ControllerOutcome::Record(IoRecordOutcome::Accepted { data })) => Some(data),
            _ => None,
        }
    }
}
