//! Frames on PROFIBUS: outputs, parameter data, records, addresses.

use super::outputs::{OutputArea, OutputLayout};
use super::{FrameLimits, LastingFrameChanges, objection_to_record};
use suite::device::{DeviceModule, DeviceRecord, ModuleBus, UserPrmLayout};
use wire::profibus::call::CALL_INDEX;
use wire::profibus::dpv1::{Dpv1Pdu, PduDirection};
use wire::profibus::fdl::{BROADCAST, DataFrame, FdlFrame};
use wire::profibus::global_control::GlobalControl;
use wire::profibus::prm::SetPrm;
use wire::profibus::sap::{SapService, SlaveSap};

/// The header of CALL in bytes; I&M1 to I&M4 follow it when they are written.
const CALL_HEADER: usize = 4;
/// The length of the DP-V1 bytes in the parameter data.
const DPV1_BYTES: usize = 3;

impl FrameLimits {
    /// Judges the bytes of a frame and counts what it changes; the error says why it may not be sent. `has_others`: there are other
    /// slaves on the bus.
    pub fn judge_bytes(&mut self, octets: &[u8], has_others: bool) -> Result<(), String> {
        match FdlFrame::parse(octets) {
            Ok(FdlFrame::Data(frame)) => self.judge_bus_frame(&frame, has_others),
            Ok(FdlFrame::Token { .. } | FdlFrame::ShortAcknowledgement) => Ok(()),
            Err(_) => Err("bytes that are no frame".to_owned()),
        }
    }

    fn judge_bus_frame(&mut self, frame: &DataFrame<'_>, has_others: bool) -> Result<(), String> {
        if !frame.fc.is_request() {
            return Ok(());
        }
        let data = frame.data;
        match SapService::of(frame) {
            SapService::Link(_) | SapService::BareAnswer => Ok(()),
            SapService::DataExchange => self.judge_data_exchange(data),
            SapService::Slave(SlaveSap::GLOBAL_CONTROL) => self.judge_control(frame, has_others),
            SapService::Slave(SlaveSap::SET_PRM) => self.judge_set_prm(data),
            SapService::Slave(SlaveSap::CHK_CFG) => {
                self.configured = self.configuration(data);
                self.held.clear();
                Ok(())
            }
            SapService::Slave(SlaveSap::SET_SLAVE_ADDRESS) => {
                self.permit(LastingFrameChanges { address: true, writes: 1, ..LastingFrameChanges::default() })
            }
            SapService::Slave(SlaveSap::SERVER | SlaveSap::ALARM | SlaveSap::RESOURCE_MANAGER)
            | SapService::Connection(_) => self.judge_acyclic(data),
            SapService::Slave(_) if data.is_empty() => Ok(()),
            SapService::Slave(sap) => Err(format!("data to the access point {}", sap.0)),
            SapService::MasterMaster => Err("a frame to another master".to_owned()),
        }
    }

    fn judge_control(&self, frame: &DataFrame<'_>, has_others: bool) -> Result<(), String> {
        let control = GlobalControl::parse(frame.data).map_err(|_| "a Global_Control that cannot be read")?;
        let reaches_others = frame.da == BROADCAST && has_others && control.command.0 != 0;
        if reaches_others && !self.consent.alone {
            return Err("a Global_Control that other slaves obey, without the consent alone".to_owned());
        }
        Ok(())
    }

    fn judge_data_exchange(&mut self, data: &[u8]) -> Result<(), String> {
        match self.configured.clone().filter(|layout| layout.octets == data.len()) {
            Some(layout) => self.judge_outputs(&layout, data, true),
            None if data.iter().all(|octet| *octet == 0) => Ok(()),
            None => Err("outputs that are not those of the configuration".to_owned()),
        }
    }

    /// The outputs with this configuration; `None` if no module has it.
    fn configuration(&self, cfg: &[u8]) -> Option<OutputLayout> {
        let has = |module: &&DeviceModule| matches!(&module.bus, ModuleBus::Profibus { cfg: of, .. } if of == cfg);
        let module = self.device.modules.iter().find(has)?;
        let mut layout = OutputLayout::default();
        for submodule in module.submodules.iter().filter_map(|index| self.device.submodules.get(*index)) {
            let end = layout.octets + usize::from(submodule.output_octets);
            let signals = Some(submodule.outputs.clone());
            layout.areas.push(OutputArea { at: layout.octets..end, signals });
            layout.octets = end;
        }
        Some(layout)
    }

    fn judge_set_prm(&self, data: &[u8]) -> Result<(), String> {
        let prm = SetPrm::parse(data).map_err(|_| "a Set_Prm that cannot be read")?;
        let dpv1 = self.device.profibus().is_some_and(|slave| slave.set_prm.dpv1.is_some());
        let user = prm.user.get(if dpv1 { DPV1_BYTES.min(prm.user.len()) } else { 0 }..).unwrap_or_default();
        let record = self.device.records.get(UserPrmLayout::RECORD);
        match record {
            _ if user.is_empty() => Ok(()),
            Some(record) => match objection_to_user_data(record, user) {
                Some(why) => Err(why),
                None => Ok(()),
            },
            None => Err("user parameter data, of which the manual names none".to_owned()),
        }
    }

    /// Records, of which only parameter requests and I&M1 to I&M4 are written.
    fn judge_acyclic(&mut self, data: &[u8]) -> Result<(), String> {
        if data.is_empty() {
            return Ok(());
        }
        let pdu = Dpv1Pdu::parse(data, PduDirection::Request).map_err(|_| "a DP-V1 request that cannot be read")?;
        let changes = match &pdu {
            Dpv1Pdu::Write(record) if u16::from(record.index) == self.device.parameter_access.index => {
                self.parameter_changes(&record.data)?
            }
            Dpv1Pdu::Write(record) if record.index == CALL_INDEX && record.data.len() <= CALL_HEADER => {
                LastingFrameChanges::default()
            }
            Dpv1Pdu::Write(record) if record.index == CALL_INDEX => {
                LastingFrameChanges { im_records: true, writes: 1, ..LastingFrameChanges::default() }
            }
            Dpv1Pdu::Write(record) => {
                return Err(format!("a write of record {}, which neither manual nor description has", record.index));
            }
            Dpv1Pdu::DataTransport(_) | Dpv1Pdu::Other(..) => {
                return Err(format!("a DP-V1 request of function 0x{:02X}", pdu.function().0));
            }
            _ => LastingFrameChanges::default(),
        };
        self.permit(changes)
    }
}

/// Why these are no user parameter data: more than the manual has, or bits set that no field has.
fn objection_to_user_data(record: &DeviceRecord, user: &[u8]) -> Option<String> {
    if user.len() > record.octets {
        return Some(format!("{} bytes of user parameter data", user.len()));
    }
    let mut whole = record.bytes();
    whole.get_mut(..user.len()).unwrap_or_default().copy_from_slice(user);
    objection_to_record(record, &whole)
}
