//! A generic PROFIBUS DP slave that follows no manual: it returns its outputs as inputs.
//!
//! It is the reference for rules that hold for every DP slave. The module `B3 D0` receives four bytes and sends them back, followed by
//! a counter of two bytes; the module `B3` has no counter. The slave has Freeze, Sync, Fail_Safe, Set_Slave_Address, records for
//! masters of both classes, I&M0 and I&M1, alarms, and three faults: two that its diagnosis names, and one that makes its inputs
//! unusable. Ident number, identifiers, records, diagnoses and alarms are invented.
//!
//! This module must not depend on encoders.

mod alarms;

use alarms::AlarmSender;
use alloc::vec::Vec;
use core::mem;
use core::time::Duration;
use device_stack::profibus::{
    AcknowledgedAlarm, DiagnosisBits, Dpv1Access, Dpv1Channel, Dpv1RecordRefusal, ExchangeEnd, SlaveApplication,
    SlaveIdentity,
};
use station::{StandAction, Time};
use wire::profibus::call::{CALL_INDEX, Call, DpIm0, ExtendedFunction, FunctionIndex};
use wire::profibus::cfg::IoLengths;
use wire::profibus::diag::{DpAlarmType, SpecifierChange};
use wire::profibus::dpv1::RecordError;
use wire::profibus::prm::SetPrm;
use wire::profinet::blocks::im::{Im0, SoftwareRevision};

/// The factory address: the slave waits for Set_Slave_Address.
pub const ADDRESS: u8 = 126;
/// The configurations that the slave accepts: the mirror with the counter, and the mirror alone.
pub const CONFIGURATIONS: [&[u8]; 2] = [&[0xB3, 0xD0], &[0xB3]];

const IDENT: u16 = 0xFEED;
/// Bytes that the mirror receives and sends.
const MIRROR: usize = 4;
/// Bytes of the counter.
const COUNTER: usize = 2;
/// The three bytes of DP-V1 and the step of the counter.
const USER_OCTETS: usize = 4;
/// The steps by which the counter may count.
const STEPS: core::ops::RangeInclusive<u8> = 1..=16;
/// The slot of the records.
const SLOT: u8 = 0;
/// Index of the note, which can be read and written.
const NOTE: u8 = 1;
/// Index of the counter, which can be read.
const COUNT: u8 = 2;
/// Bytes of I&M1: function and location.
const IM1_OCTETS: usize = 54;

/// The faults: the name for the stand and the channel-related diagnosis: identifier number, channel, kind and error.
const FAULTS: [(&str, [u8; 3]); 2] = [("passing", [0x80, 0xC0, 0x81]), ("standing", [0x81, 0x40, 0xA6])];
/// The fault that makes the inputs unusable, which sets Stat_Diag.
const UNUSABLE: &str = "unusable";
/// The event of the process, which is a process alarm when it comes.
const EVENT: &str = "event";
/// The spare module without data, which is pulled or plugged.
const PULLED: &str = "pulled";
/// The slot of the first module; the second has the next one.
const FIRST_MODULE: u8 = 1;
/// The slot of the spare module.
const SPARE_MODULE: u8 = 3;

/// I&M0 of the slave.
const IDENTIFICATION: DpIm0 = DpIm0 {
    header: [b' '; 10],
    im0: Im0 {
        vendor_id: IDENT,
        order_id: *b"PLAIN-DP-1          ",
        serial_number: *b"0000000000000001",
        hardware_revision: 1,
        software_revision: SoftwareRevision { prefix: b'V', functional_enhancement: 1, bug_fix: 0, internal_change: 0 },
        revision_counter: 0,
        profile_id: 0,
        profile_specific_type: 0,
        im_version: [1, 1],
        im_supported: 0b10,
    },
};

/// The application of the slave, for a PROFIBUS stack.
pub struct GenericSlave {
    identity: SlaveIdentity,
    stored_address: u8,
    is_address_final: bool,
    ram: PlainSlaveData,
    im1: [u8; IM1_OCTETS],
    faults: [bool; FAULTS.len()],
    is_unusable: bool,
    has_event: bool,
    is_pulled: bool,
    has_changed: bool,
}

/// What a power failure erases.
struct PlainSlaveData {
    configuration: &'static [u8],
    step: u8,
    outputs: [u8; MIRROR],
    count: u16,
    note: [u8; 4],
    /// The function that each master has called and not read yet.
    called: Vec<(Dpv1Channel, FunctionIndex)>,
    is_exchanging: bool,
    alarms: AlarmSender,
}

impl PlainSlaveData {
    /// After power-up.
    const START: PlainSlaveData = PlainSlaveData {
        configuration: CONFIGURATIONS[0],
        step: 1,
        outputs: [0; MIRROR],
        count: 0,
        note: [0; 4],
        called: Vec::new(),
        is_exchanging: false,
        alarms: AlarmSender::new(),
    };
}

impl GenericSlave {
    /// Creates a slave in factory state except for its station address.
    pub fn new(address: u8) -> GenericSlave {
        let identity = SlaveIdentity {
            ident: IDENT,
            boot_time: Duration::from_millis(500),
            freeze: true,
            sync: true,
            fail_safe: true,
            dpv1: true,
            ms1: true,
            ms2: 1,
            extra_alarm_sap: true,
            abilities: None,
            isochronous: false,
            set_ext_prm: false,
        };
        GenericSlave {
            identity,
            stored_address: address,
            is_address_final: false,
            ram: PlainSlaveData::START,
            im1: [b' '; IM1_OCTETS],
            faults: [false; FAULTS.len()],
            is_unusable: false,
            has_event: false,
            is_pulled: false,
            has_changed: false,
        }
    }

    /// Raises an alarm, which exists in data exchange only.
    fn raise(&mut self, alarm_type: DpAlarmType, slot: u8, change: SpecifierChange) {
        if self.ram.is_exchanging {
            self.has_changed |= self.ram.alarms.raise(alarm_type, slot, change);
        }
    }

    fn answer_call(&mut self, channel: Dpv1Channel, out: &mut Vec<u8>) -> Result<(), Dpv1RecordRefusal> {
        let called = self.ram.called.iter().position(|(known, _)| *known == channel);
        let Some((_, index)) = called.map(|at| self.ram.called.swap_remove(at)) else {
            return Err(Dpv1RecordRefusal::error(RecordError::STATE_CONFLICT));
        };
        let mut data = Vec::new();
        if index == FunctionIndex::IM0 {
            IDENTIFICATION.write(&mut data);
        } else {
            data.extend_from_slice(&[b' '; 10]);
            data.extend_from_slice(&self.im1);
        }
        Call { function: ExtendedFunction::CALL, reserved: 0, index, data }.write(out);
        Ok(())
    }

    fn take_call(&mut self, channel: Dpv1Channel, data: &[u8]) -> Result<(), Dpv1RecordRefusal> {
        let call = Call::parse(data).map_err(|_| Dpv1RecordRefusal::error(RecordError::WRITE_LENGTH_ERROR))?;
        let is_known = [FunctionIndex::IM0, FunctionIndex::IM1].contains(&call.index);
        if call.function != ExtendedFunction::CALL || !is_known {
            return Err(Dpv1RecordRefusal::error(RecordError::INVALID_INDEX));
        }
        if call.data.is_empty() {
            self.ram.called.retain(|(known, _)| *known != channel);
            self.ram.called.push((channel, call.index));
            return Ok(());
        }
        if call.index == FunctionIndex::IM0 {
            return Err(Dpv1RecordRefusal::error(RecordError::ACCESS_DENIED));
        }
        let tags = call.data.get(10..).and_then(|tags| tags.try_into().ok());
        self.im1 = tags.ok_or(Dpv1RecordRefusal::error(RecordError::WRITE_LENGTH_ERROR))?;
        Ok(())
    }
}

impl SlaveApplication for GenericSlave {
    fn identity(&self) -> &SlaveIdentity {
        &self.identity
    }

    fn power_up(&mut self, _: Time) {
        self.ram = PlainSlaveData::START;
    }

    fn power_down(&mut self, _: Time) {}

    fn address(&self) -> u8 {
        self.stored_address
    }

    fn takes_address(&self) -> bool {
        !self.is_address_final
    }

    fn set_address(&mut self, _: Time, address: u8, is_final: bool) {
        self.stored_address = address;
        self.is_address_final = is_final;
    }

    fn parameters(&mut self, _: Time, parameters: &SetPrm) -> bool {
        let [_, _, _, step] = match <[u8; USER_OCTETS]>::try_from(parameters.user.as_slice()) {
            Ok(user) => user,
            Err(_) => return false,
        };
        let is_valid = STEPS.contains(&step);
        if is_valid {
            self.ram.step = step;
            self.ram.alarms.begin(parameters.dpv1().unwrap_or_default());
        }
        is_valid
    }

    fn check_configuration(&mut self, _: Time, identifiers: &[u8]) -> Option<IoLengths> {
        self.ram.configuration = CONFIGURATIONS.into_iter().find(|known| *known == identifiers)?;
        let counter = if self.ram.configuration.len() > 1 { COUNTER } else { 0 };
        Some(IoLengths { inputs: MIRROR + counter, outputs: MIRROR })
    }

    fn configuration(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(self.ram.configuration);
    }

    fn exchange_begins(&mut self, _: Time) {
        self.ram.is_exchanging = true;
        for (at, _) in self.faults.into_iter().enumerate().filter(|(_, is_present)| *is_present) {
            self.raise(DpAlarmType::DIAGNOSIS, FIRST_MODULE + at as u8, SpecifierChange::Appears);
        }
    }

    fn exchange_ends(&mut self, _: Time, _: ExchangeEnd) {
        self.ram.is_exchanging = false;
        self.ram.alarms.end();
    }

    fn outputs(&mut self, _: Time, data: Option<&[u8]>) {
        self.ram.outputs = data.and_then(|data| data.try_into().ok()).unwrap_or_default();
    }

    fn inputs(&mut self, _: Time, data: &mut [u8]) {
        self.ram.count = self.ram.count.wrapping_add(self.ram.step.into());
        let inputs = self.ram.outputs.into_iter().chain(self.ram.count.to_be_bytes());
        data.iter_mut().zip(inputs).for_each(|(to, from)| *to = from);
    }

    fn diagnosis(&mut self, _: Time, out: &mut Vec<u8>) -> DiagnosisBits {
        self.has_changed |= self.ram.alarms.write(out);
        let reported = || FAULTS.iter().zip(self.faults).enumerate().filter(|(_, (_, is_present))| *is_present);
        let ext_diag = reported().next().is_some();
        if ext_diag {
            let bits: u8 = reported().map(|(at, _)| 1 << at).sum();
            // A status message of slot 0 with a bit for each fault, then a bit for each module, then the channels.
            out.extend_from_slice(&[0x05, 0x81, SLOT, 0x00, bits]);
            out.extend_from_slice(&[0x42, bits]);
            reported().for_each(|(_, ((_, channel), _))| out.extend_from_slice(channel));
        }
        DiagnosisBits { ext_diag, stat_diag: self.is_unusable, overflow: false }
    }

    fn diagnosis_changed(&mut self) -> bool {
        mem::take(&mut self.has_changed)
    }

    fn write(&mut self, _: Time, access: Dpv1Access, data: &[u8]) -> Result<(), Dpv1RecordRefusal> {
        let refused = |error| Err(Dpv1RecordRefusal::error(error));
        match (access.slot, access.index) {
            (SLOT, NOTE) => match data.try_into() {
                Ok(note) => {
                    self.ram.note = note;
                    Ok(())
                }
                Err(_) => refused(RecordError::WRITE_LENGTH_ERROR),
            },
            (SLOT, COUNT) => refused(RecordError::ACCESS_DENIED),
            (SLOT, CALL_INDEX) => self.take_call(access.channel, data),
            (SLOT, _) => refused(RecordError::INVALID_INDEX),
            _ => refused(RecordError::INVALID_SLOT),
        }
    }

    fn read(&mut self, _: Time, access: Dpv1Access, out: &mut Vec<u8>) -> Result<(), Dpv1RecordRefusal> {
        match (access.slot, access.index) {
            (SLOT, NOTE) => out.extend_from_slice(&self.ram.note),
            (SLOT, COUNT) => out.extend_from_slice(&self.ram.count.to_be_bytes()),
            (SLOT, CALL_INDEX) => return self.answer_call(access.channel, out),
            (SLOT, _) => return Err(Dpv1RecordRefusal::error(RecordError::INVALID_INDEX)),
            _ => return Err(Dpv1RecordRefusal::error(RecordError::INVALID_SLOT)),
        }
        Ok(())
    }

    fn acknowledge_alarm(&mut self, _: Time, alarm: AcknowledgedAlarm) -> Result<(), Dpv1RecordRefusal> {
        self.has_changed |= self.ram.alarms.acknowledge(alarm)?;
        Ok(())
    }

    fn forget(&mut self, _: Time, channel: Dpv1Channel) {
        self.ram.called.retain(|(known, _)| *known != channel);
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        let StandAction::Fault(name, is_present) = *action else { return None };
        if let Some(at) = FAULTS.iter().position(|(known, _)| *known == name) {
            if mem::replace(&mut self.faults[at], is_present) != is_present {
                self.has_changed = true;
                let change = match (is_present, self.faults.contains(&true)) {
                    (true, _) => SpecifierChange::Appears,
                    (false, false) => SpecifierChange::Disappears,
                    (false, true) => SpecifierChange::DisappearsOthersRemain,
                };
                self.raise(DpAlarmType::DIAGNOSIS, FIRST_MODULE + at as u8, change);
            }
            return Some(now);
        }
        match name {
            UNUSABLE => self.has_changed |= mem::replace(&mut self.is_unusable, is_present) != is_present,
            EVENT if mem::replace(&mut self.has_event, is_present) != is_present && is_present => {
                self.raise(DpAlarmType::PROCESS, FIRST_MODULE, SpecifierChange::NotDifferentiated);
            }
            PULLED if mem::replace(&mut self.is_pulled, is_present) != is_present => {
                let alarm_type = if is_present { DpAlarmType::PULL } else { DpAlarmType::PLUG };
                self.raise(alarm_type, SPARE_MODULE, SpecifierChange::NotDifferentiated);
            }
            EVENT | PULLED => {}
            _ => return None,
        }
        Some(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    const MS1: Dpv1Access = Dpv1Access { channel: Dpv1Channel::Ms1, slot: SLOT, index: CALL_INDEX };

    fn diagnosis(slave: &mut GenericSlave) -> (Vec<u8>, DiagnosisBits) {
        let mut out = Vec::new();
        let bits = slave.diagnosis(Time::ZERO, &mut out);
        (out, bits)
    }

    #[test]
    fn outputs_come_back_with_a_counter() {
        let mut slave = GenericSlave::new(5);
        slave.outputs(Time::ZERO, Some(&[1, 2, 3, 4]));
        let mut inputs = [0; 6];
        slave.inputs(Time::ZERO, &mut inputs);
        assert_eq!(inputs, [1, 2, 3, 4, 0, 1]);
        slave.outputs(Time::ZERO, None);
        slave.inputs(Time::ZERO, &mut inputs);
        assert_eq!(inputs, [0, 0, 0, 0, 0, 2]);
    }

    /// EN 50170, Slave_Diag: the header of a device-related block counts itself, identifier-related blocks have a bit for each module,
    /// channel-related ones have three bytes.
    #[test]
    fn faults_are_reported_in_blocks_of_all_three_kinds() {
        let mut slave = GenericSlave::new(5);
        assert_eq!(diagnosis(&mut slave), (vec![], DiagnosisBits::default()));
        slave.act(Time::ZERO, &StandAction::Fault("standing", true));
        assert!(slave.diagnosis_changed() && !slave.diagnosis_changed());
        let (blocks, bits) = diagnosis(&mut slave);
        assert_eq!(blocks, [0x05, 0x81, 0, 0, 0x02, 0x42, 0x02, 0x81, 0x40, 0xA6]);
        assert_eq!((bits.ext_diag, bits.stat_diag), (true, false));
        slave.act(Time::ZERO, &StandAction::Fault("unusable", true));
        assert!(diagnosis(&mut slave).1.stat_diag);
        assert_eq!(slave.act(Time::ZERO, &StandAction::Fault("memory", true)), None);
    }

    #[test]
    fn identification_is_read_once_for_each_call() {
        let mut slave = GenericSlave::new(5);
        let mut request = Vec::new();
        Call::read_of(FunctionIndex::IM0).write(&mut request);
        assert_eq!(slave.write(Time::ZERO, MS1, &request), Ok(()));
        let mut answer = Vec::new();
        assert_eq!(slave.read(Time::ZERO, MS1, &mut answer), Ok(()));
        assert_eq!((answer.len(), &answer[..4]), (68, &request[..]));
        assert_eq!(DpIm0::parse(&answer[4..]).map(|record| record.im0.vendor_id), Ok(IDENT));
        assert!(slave.read(Time::ZERO, MS1, &mut answer).is_err());
    }
}
