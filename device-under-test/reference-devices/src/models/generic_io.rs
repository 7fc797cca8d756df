//! A generic PROFINET IO device that follows no manual: it returns its outputs as inputs.
//!
//! It is the reference for rules that hold for every PROFINET IO device. Slot 1 receives four bytes and sends them back, or
//! zeros while its outputs are bad. Slot 2 sends the number of frames that it has sent. The device has I&M0 to I&M3, no
//! parameters, and two faults that it reports as channel diagnoses. The module in slot 2 can be pulled, and another one can be
//! plugged there. Two controllers can share the slots. Vendor, device and ident numbers are invented.
//!
//! This module must not depend on encoders.

use alloc::collections::VecDeque;
use alloc::format;
use core::time::Duration;
use device_stack::profinet::{
    ArKey, DiagnosisChange, DiagnosisSeverity, IoApplication, IoIdentity, PlugChange, PluggableSubmodule, RecordAccess,
    RecordRefusal, ResetScope, StationData, SubmoduleDiagnosis,
};
use station::{StandAction, Time};
use wire::profinet::dcp::station_name;

/// Time without any answer after power-up.
const BOOT: Duration = Duration::from_secs(1);
/// Time from the end of the parameters to the first good data.
const READY: Duration = Duration::from_millis(5);
/// Slot that returns its outputs.
const MIRROR: u16 = 1;
/// Slot with the frame counter.
const COUNTER: u16 = 2;
/// The faults: the name for the stand, and the ChannelErrorType.
const FAULTS: [(&str, u16); 2] = [("passing", 0x0001), ("standing", 0x0006)];

const COUNTER_MODULE: PluggableSubmodule = plug(COUNTER, 0x0030, 0x0031, 2, 0);
/// A module that can be plugged in the slot of the counter and does not belong there.
const WRONG_MODULE: PluggableSubmodule = plug(COUNTER, 0x0040, 0x0041, 2, 0);

const PLUGS: [PluggableSubmodule; 3] =
    [plug(0, 0x0001, 0x0001, 0, 0), plug(MIRROR, 0x0020, 0x0021, 4, 4), COUNTER_MODULE];

const fn plug(
    slot: u16,
    module_ident: u32,
    submodule_ident: u32,
    input_octets: u16,
    output_octets: u16,
) -> PluggableSubmodule {
    PluggableSubmodule { api: 0, slot, module_ident, subslot: 1, submodule_ident, input_octets, output_octets }
}

/// The application of the device, for a PROFINET stack.
pub struct GenericIoDevice {
    identity: IoIdentity,
    stored: StationData,
    outputs: [u8; 4],
    sent: u16,
    faults: [bool; FAULTS.len()],
    changes: VecDeque<DiagnosisChange>,
    /// Whether the module of slot 2 is pulled, and whether the wrong one is plugged instead.
    pulled: bool,
    wrong: bool,
    plugs: VecDeque<PlugChange>,
    /// Events in the process of slot 1 that are not reported yet.
    events: usize,
}

impl GenericIoDevice {
    /// Creates a device in factory state except for its station data. The serial number is derived from `mac`.
    pub fn new(mac: [u8; 6], station: StationData) -> GenericIoDevice {
        let [.., a, b, c] = mac;
        let identity = IoIdentity {
            vendor_id: 0xFEED,
            device_id: 0x00D0,
            station_type: "PLAIN IO",
            order_id: "PLAIN-1",
            serial_number: format!("{a:02X}{b:02X}{c:02X}"),
            ports: 2,
            hardware_revision: 1,
            software_revision: [b'V', 1, 0, 0],
            revision_counter: 0,
            profile_id: 0,
            profile_specific_type: 0,
            im_version: [1, 1],
            im_supported: 0b1110,
            boot_time: BOOT,
            has_fast_start_up: true,
        };
        GenericIoDevice {
            identity,
            stored: station,
            outputs: [0; 4],
            sent: 0,
            faults: [false; FAULTS.len()],
            changes: VecDeque::new(),
            pulled: false,
            wrong: false,
            plugs: VecDeque::new(),
            events: 0,
        }
    }

    /// The module in slot 2.
    fn plugged(&self) -> Option<PluggableSubmodule> {
        match (self.pulled, self.wrong) {
            (true, _) => None,
            (false, true) => Some(WRONG_MODULE),
            (false, false) => Some(COUNTER_MODULE),
        }
    }

    /// Reports that slot 2 no longer has the module `before`.
    fn queue_exchange(&mut self, before: Option<PluggableSubmodule>) {
        let after = self.plugged();
        if before != after {
            self.plugs.extend(before.map(PlugChange::Pulled));
            self.plugs.extend(after.map(PlugChange::Plugged));
        }
    }

    fn queue_diagnosis(&mut self, fault: usize, appears: bool) {
        let Some((_, error_type)) = FAULTS.get(fault) else { return };
        let diagnosis = SubmoduleDiagnosis {
            api: 0,
            slot: MIRROR,
            subslot: 1,
            channel: 0,
            error_type: *error_type,
            extended: None,
            severity: DiagnosisSeverity::Fault,
        };
        self.changes.push_back(DiagnosisChange { appears, diagnosis });
    }
}

impl IoApplication for GenericIoDevice {
    fn identity(&self) -> &IoIdentity {
        &self.identity
    }

    fn plugs(&self) -> &[PluggableSubmodule] {
        &PLUGS
    }

    fn stored_station(&self) -> StationData {
        self.stored.clone()
    }

    fn set_station(&mut self, _: Time, _: &StationData, stored: &StationData) {
        self.stored = stored.clone();
    }

    fn accepts_name(&self, name: &[u8]) -> bool {
        name.is_empty() || station_name::check(name).is_ok()
    }

    fn factory_reset(&mut self, _: Time, scope: ResetScope) -> bool {
        match scope {
            ResetScope::Factory | ResetScope::AllData | ResetScope::Device | ResetScope::Communication => {
                self.stored = StationData::default();
                true
            }
            ResetScope::ApplicationData => true,
            ResetScope::Engineering | ResetScope::FactoryImage | ResetScope::Other(_) => false,
        }
    }

    fn power_up(&mut self, _: Time) {
        self.outputs = [0; 4];
        self.sent = 0;
        for fault in 0..FAULTS.len() {
            if self.faults[fault] {
                self.queue_diagnosis(fault, true);
            }
        }
        self.queue_exchange(Some(COUNTER_MODULE));
    }

    fn power_down(&mut self, _: Time) {
        self.changes.clear();
        self.plugs.clear();
        self.events = 0;
    }

    fn started(&mut self, _: Time, _: ArKey, plugged: &[PluggableSubmodule]) {
        if plugged.iter().any(|plug| plug.slot == MIRROR) {
            self.outputs = [0; 4];
        }
    }

    fn parameter_end(&mut self, now: Time, _: ArKey) -> Time {
        now + READY
    }

    fn ended(&mut self, _: Time, _: ArKey) {}

    fn controllers(&self) -> usize {
        2
    }

    fn supervisors(&self) -> usize {
        1
    }

    fn next_event(&mut self) -> Option<(u16, u16)> {
        self.events = self.events.checked_sub(1)?;
        Some((MIRROR, 1))
    }

    fn next_plug(&mut self) -> Option<PlugChange> {
        self.plugs.pop_front()
    }

    fn write_record(&mut self, _: Time, _: RecordAccess, _: &[u8]) -> Result<(), RecordRefusal> {
        Err(RecordRefusal::InvalidIndex)
    }

    fn read_record(&mut self, _: Time, _: RecordAccess, _: &mut alloc::vec::Vec<u8>) -> Result<(), RecordRefusal> {
        Err(RecordRefusal::InvalidIndex)
    }

    fn outputs(&mut self, _: Time, slot: u16, _: u16, data: Option<&[u8]>) {
        if slot == MIRROR {
            self.outputs = data.and_then(|data| data.try_into().ok()).unwrap_or_default();
        }
    }

    fn inputs(&mut self, _: Time, slot: u16, _: u16, data: &mut [u8]) -> bool {
        if slot == COUNTER {
            self.sent = self.sent.wrapping_add(1);
        }
        match (slot, data.len()) {
            (MIRROR, 4) => data.copy_from_slice(&self.outputs),
            (COUNTER, 2) => data.copy_from_slice(&self.sent.to_be_bytes()),
            _ => data.fill(0),
        }
        true
    }

    fn next_diagnosis(&mut self) -> Option<DiagnosisChange> {
        self.changes.pop_front()
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        let StandAction::Fault(name, present) = *action else { return None };
        let before = self.plugged();
        match name {
            "pulled" => self.pulled = present,
            "wrong" => self.wrong = present,
            "event" if present => self.events += 1,
            "event" => {}
            _ => return self.act_on_fault(now, name, present),
        }
        self.queue_exchange(before);
        Some(now)
    }
}

impl GenericIoDevice {
    /// Causes or ends a fault that is reported as a diagnosis; `None` for an unknown name.
    fn act_on_fault(&mut self, now: Time, name: &str, present: bool) -> Option<Time> {
        let fault = FAULTS.iter().position(|(known, _)| *known == name)?;
        if self.faults[fault] != present {
            self.faults[fault] = present;
            self.queue_diagnosis(fault, present);
        }
        Some(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    fn device() -> GenericIoDevice {
        GenericIoDevice::new([2, 0, 0, 0, 1, 0], StationData::default())
    }

    fn sent(device: &mut GenericIoDevice) -> [u8; 4] {
        let mut octets = [0xFF; 4];
        assert!(device.inputs(Time::ZERO, MIRROR, 1, &mut octets));
        octets
    }

    #[test]
    fn good_outputs_come_back_as_inputs() {
        let mut device = device();
        assert_eq!(sent(&mut device), [0; 4]);
        device.outputs(Time::ZERO, MIRROR, 1, Some(&[1, 2, 3, 4]));
        assert_eq!(sent(&mut device), [1, 2, 3, 4]);
        device.outputs(Time::ZERO, MIRROR, 1, None);
        assert_eq!(sent(&mut device), [0; 4]);
    }

    #[test]
    fn the_counter_counts_frames() {
        let mut device = device();
        for count in 1..=3 {
            let mut octets = [0; 2];
            assert!(device.inputs(Time::ZERO, COUNTER, 1, &mut octets));
            assert_eq!(octets, [0, count]);
        }
    }

    #[test]
    fn fault_is_reported_once_and_again_at_power_up() {
        let mut device = device();
        for (present, reported) in [(true, Some(true)), (true, None), (false, Some(false)), (false, None)] {
            assert_eq!(device.act(Time::ZERO, &StandAction::Fault("passing", present)), Some(Time::ZERO));
            assert_eq!(device.next_diagnosis().map(|change| change.appears), reported);
        }
        assert_eq!(device.act(Time::ZERO, &StandAction::Fault("memory", true)), None);
        assert_eq!(device.act(Time::ZERO, &StandAction::Fault("standing", true)), Some(Time::ZERO));
        device.power_down(Time::ZERO);
        assert_eq!(device.next_diagnosis(), None);
        device.power_up(Time::ZERO);
        let reported: Vec<u16> =
            core::iter::from_fn(|| device.next_diagnosis()).map(|of| of.diagnosis.error_type).collect();
        assert_eq!(reported, [0x0006]);
    }
}
