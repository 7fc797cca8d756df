//! A minimal application: it stores outputs and one record.

use super::bench::SlaveBench;
use core::time::Duration;
use device_stack::Attached;
use device_stack::profibus::{
    AcknowledgedAlarm, DiagnosisBits, DpDevice, Dpv1Access, Dpv1RecordRefusal, ExchangeEnd, SlaveApplication,
    SlaveHooks, SlaveIdentity,
};
use station::{StandAction, Time};
use std::vec::Vec;
use wire::profibus::cfg::IoLengths;
use wire::profibus::diag::Specifier;
use wire::profibus::dpv1::RecordError;
use wire::profibus::fdl::BaudRate;
use wire::profibus::prm::SetPrm;

/// An application with two input bytes and two output bytes.
pub struct ToySlaveApplication {
    identity: SlaveIdentity,
    pub address: u8,
    pub outputs: Option<Vec<u8>>,
    pub inputs_given: u8,
    pub ends: Vec<ExchangeEnd>,
    pub clocks: u32,
    pub changed: bool,
    pub record: Vec<u8>,
}

pub const IDENT: u16 = 0xABCD;
pub const CFG: [u8; 2] = [0x11, 0x21];
/// Lock_Req, watchdog 100 ms, min TSDR 11, ident number, group 1, DP-V1 enabled, one byte for the application.
pub const PRM: [u8; 11] = [0x88, 10, 1, 11, 0xAB, 0xCD, 1, 0x80, 0, 0, 7];

/// I&M0: the header of the manufacturer, then manufacturer 1, order number, serial number, revisions, profile, version 1.1.
pub const IM0: [u8; 64] = *b"          \x00\x01TOY-1               0000000000000042\x00\x01V\x01\x00\x00\x00\x00\x3D\x00\x00\x00\x01\x01\x00\x00";

pub fn bench(hooks: Attached<dyn SlaveHooks>) -> SlaveBench<DpDevice<ToySlaveApplication>> {
    let identity = SlaveIdentity {
        ident: IDENT,
        boot_time: Duration::from_millis(100),
        freeze: true,
        sync: true,
        fail_safe: true,
        dpv1: true,
        ms1: true,
        extra_alarm_sap: true,
        ms2: 1,
        abilities: None,
        isochronous: false,
        set_ext_prm: false,
    };
    let toy = ToySlaveApplication {
        identity,
        address: 5,
        outputs: None,
        inputs_given: 0,
        ends: Vec::new(),
        clocks: 0,
        changed: false,
        record: std::vec![1, 2, 3],
    };
    SlaveBench::new(DpDevice::new(toy, BaudRate(1_500_000), hooks), 5)
}

impl SlaveApplication for ToySlaveApplication {
    fn identity(&self) -> &SlaveIdentity {
        &self.identity
    }
    fn power_up(&mut self, _: Time) {
        self.outputs = None;
    }
    fn power_down(&mut self, _: Time) {}
    fn address(&self) -> u8 {
        self.address
    }
    fn takes_address(&self) -> bool {
        true
    }
    fn set_address(&mut self, _: Time, address: u8, _: bool) {
        self.address = address;
    }
    fn parameters(&mut self, _: Time, parameters: &SetPrm) -> bool {
        parameters.user_after_dpv1() == [7]
    }
    fn check_configuration(&mut self, _: Time, identifiers: &[u8]) -> Option<IoLengths> {
        (identifiers == CFG).then_some(IoLengths { inputs: 2, outputs: 2 })
    }
    fn configuration(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&CFG);
    }
    fn exchange_begins(&mut self, _: Time) {}
    fn exchange_ends(&mut self, _: Time, end: ExchangeEnd) {
        self.ends.push(end);
    }
    fn outputs(&mut self, _: Time, data: Option<&[u8]>) {
        self.outputs = data.map(<[u8]>::to_vec);
    }
    fn inputs(&mut self, _: Time, data: &mut [u8]) {
        self.inputs_given += 1;
        data.fill(self.inputs_given);
    }
    fn clock(&mut self, _: Time) {
        self.clocks += 1;
    }
    fn diagnosis(&mut self, _: Time, out: &mut Vec<u8>) -> DiagnosisBits {
        out.extend_from_slice(&[2, 0x55]);
        DiagnosisBits { ext_diag: true, ..DiagnosisBits::default() }
    }
    fn diagnosis_changed(&mut self) -> bool {
        core::mem::take(&mut self.changed)
    }
    fn write(&mut self, _: Time, access: Dpv1Access, data: &[u8]) -> Result<(), Dpv1RecordRefusal> {
        match access.index {
            47 => {
                self.record = data.to_vec();
                Ok(())
            }
            // CALL of I&M0.
            255 if data == [0x08, 0, 0xFD, 0xE8] => Ok(()),
            _ => Err(Dpv1RecordRefusal::error(RecordError::ACCESS_DENIED)),
        }
    }
    fn acknowledge_alarm(&mut self, _: Time, alarm: AcknowledgedAlarm) -> Result<(), Dpv1RecordRefusal> {
        let waits = AcknowledgedAlarm { slot: 1, alarm_type: 2, specifier: Specifier(0x19) };
        if alarm == waits { Ok(()) } else { Err(Dpv1RecordRefusal::error(RecordError::STATE_CONFLICT)) }
    }
    fn read(&mut self, _: Time, access: Dpv1Access, out: &mut Vec<u8>) -> Result<(), Dpv1RecordRefusal> {
        match access.index {
            47 => {
                out.extend_from_slice(&self.record);
                Ok(())
            }
            255 => {
                out.extend_from_slice(&[0x08, 0, 0xFD, 0xE8]);
                out.extend_from_slice(&IM0);
                Ok(())
            }
            _ => Err(Dpv1RecordRefusal::error(RecordError::INVALID_INDEX)),
        }
    }
    fn act(&mut self, _: Time, action: &StandAction<'_>) -> Option<Time> {
        let StandAction::Fault(_, present) = action else { return None };
        self.changed = *present;
        Some(Time::ZERO)
    }
}
