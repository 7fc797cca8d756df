//! A minimal application: it stores one record and the last outputs.

use crate::profinet::{
    ArKey, DiagnosisChange, DiagnosisSeverity, IoApplication, IoIdentity, PlugChange, PluggableSubmodule, RecordAccess,
    RecordRefusal, ResetScope, StackStatus, StationData, SubmoduleDiagnosis,
};
use alloc::collections::VecDeque;
use alloc::string::String;
use alloc::vec::Vec;
use station::{Duration, StandAction, Time};

/// The application. Its fields record the calls.
pub struct ToyIoApplication {
    pub identity: IoIdentity,
    pub plugs: Vec<PluggableSubmodule>,
    pub stored: StationData,
    pub record: Vec<u8>,
    pub changes: VecDeque<DiagnosisChange>,
    pub plug_changes: VecDeque<PlugChange>,
    pub good: bool,
    pub preparation: Duration,
    pub log: Vec<String>,
    pub outputs: Option<Vec<u8>>,
    pub writes: usize,
    pub inputs: u8,
    /// Number of [`frame`](Application::frame) calls.
    pub frames: u8,
    pub clock: Time,
    /// Supply in volts; below 9 the device does not work.
    pub supply: f64,
    /// The actions by buttons, switches and temperature.
    pub actions: Vec<String>,
    /// The status of the last `led` call.
    pub status: StackStatus,
}

pub const API: u32 = 0x3D00;

fn plug(
    slot: u16,
    module_ident: u32,
    subslot: u16,
    submodule_ident: u32,
    input: u16,
    output: u16,
) -> PluggableSubmodule {
    let api = if slot == 1 { API } else { 0 };
    PluggableSubmodule { api, slot, module_ident, subslot, submodule_ident, input_octets: input, output_octets: output }
}

impl ToyIoApplication {
    pub fn new() -> ToyIoApplication {
        ToyIoApplication {
            identity: IoIdentity {
                vendor_id: 0x0239,
                device_id: 0x0001,
                station_type: "TOY",
                order_id: "TOY-1",
                serial_number: String::from("0042"),
                ports: 2,
                hardware_revision: 3,
                software_revision: [b'V', 1, 2, 3],
                revision_counter: 0,
                profile_id: 0x3D00,
                profile_specific_type: 0,
                im_version: [1, 1],
                im_supported: 0b1110,
                boot_time: Duration::from_secs(2),
                has_fast_start_up: false,
            },
            plugs: alloc::vec![
                plug(0, 1, 1, 1, 0, 0),
                plug(1, 1, 1, 2, 0, 0),
                plug(1, 1, 2, 81, 12, 4),
                plug(1, 1, 2, 83, 16, 4),
                plug(2, 0x20, 1, 0x201, 2, 0),
                plug(2, 0x21, 1, 0x211, 0, 2),
            ],
            stored: StationData {
                name: b"toy".to_vec(),
                ip: [192, 168, 0, 10],
                mask: [255, 255, 255, 0],
                gateway: [0; 4],
            },
            record: alloc::vec![1, 2, 3, 4],
            changes: VecDeque::new(),
            plug_changes: VecDeque::new(),
            good: true,
            preparation: Duration::from_millis(5),
            log: Vec::new(),
            outputs: None,
            writes: 0,
            inputs: 0,
            frames: 0,
            clock: Time::ZERO,
            supply: 24.0,
            actions: Vec::new(),
            status: StackStatus::default(),
        }
    }

    /// A fault of the telegram submodule appears or disappears.
    pub fn change(&mut self, error_type: u16, appears: bool) {
        let diagnosis = SubmoduleDiagnosis {
            api: API,
            slot: 1,
            subslot: 2,
            channel: 0x8000,
            error_type,
            extended: None,
            severity: DiagnosisSeverity::Fault,
        };
        self.changes.push_back(DiagnosisChange { appears, diagnosis });
    }
}

impl IoApplication for ToyIoApplication {
    fn identity(&self) -> &IoIdentity {
        &self.identity
    }
    fn plugs(&self) -> &[PluggableSubmodule] {
        &self.plugs
    }
    fn stored_station(&self) -> StationData {
        self.stored.clone()
    }
    fn set_station(&mut self, _: Time, _: &StationData, stored: &StationData) {
        self.stored = stored.clone();
    }
    fn accepts_name(&self, name: &[u8]) -> bool {
        name.is_empty() || wire::profinet::dcp::station_name::check(name).is_ok()
    }
    fn factory_reset(&mut self, _: Time, scope: ResetScope) -> bool {
        let knows = matches!(scope, ResetScope::Factory | ResetScope::Communication);
        if knows {
            self.stored = StationData::default();
        }
        knows
    }
    fn power_up(&mut self, _: Time) {
        self.log.push(String::from("up"));
    }
    fn power_down(&mut self, _: Time) {
        self.log.push(String::from("down"));
    }
    fn started(&mut self, _: Time, _: ArKey, plugged: &[PluggableSubmodule]) {
        self.log.push(alloc::format!("started {}", plugged.len()));
    }
    fn parameter_end(&mut self, now: Time, _: ArKey) -> Time {
        self.log.push(String::from("parameters"));
        now + self.preparation
    }
    fn ended(&mut self, _: Time, _: ArKey) {
        self.log.push(String::from("ended"));
    }
    fn write_record(&mut self, _: Time, access: RecordAccess, data: &[u8]) -> Result<(), RecordRefusal> {
        self.writes += 1;
        match access.index {
            0x100 if data.len() > 4000 => Err(RecordRefusal::WriteLength),
            0x100 => {
                self.record = data.to_vec();
                Ok(())
            }
            _ => Err(RecordRefusal::InvalidIndex),
        }
    }
    fn read_record(&mut self, _: Time, access: RecordAccess, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        if access.index != 0x100 {
            return Err(RecordRefusal::InvalidIndex);
        }
        out.extend_from_slice(&self.record);
        Ok(())
    }
    fn outputs(&mut self, _: Time, _: u16, _: u16, data: Option<&[u8]>) {
        self.outputs = data.map(<[u8]>::to_vec);
    }
    fn frame(&mut self, _: Time) {
        self.frames = self.frames.wrapping_add(1);
    }
    fn inputs(&mut self, now: Time, _: u16, _: u16, data: &mut [u8]) -> bool {
        self.clock = now;
        self.inputs = self.inputs.wrapping_add(1);
        data.fill(0xA5);
        self.good
    }
    fn next_diagnosis(&mut self) -> Option<DiagnosisChange> {
        self.changes.pop_front()
    }
    fn next_plug(&mut self) -> Option<PlugChange> {
        self.plug_changes.pop_front()
    }
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        match action {
            StandAction::ShaftSpeed(_) => {}
            StandAction::SupplyVoltage(volts) => self.supply = *volts,
            StandAction::Button(..) | StandAction::Switch(..) | StandAction::Temperature(_) => {
                self.actions.push(alloc::format!("{action:?}"));
            }
            _ => return None,
        }
        Some(now)
    }
    fn is_alive(&self) -> bool {
        self.supply >= 9.0
    }
    fn led(&mut self, _: Time, name: &str, status: &StackStatus) -> Option<&'static str> {
        self.status = *status;
        (name == "led").then_some(if status.is_signalling { "flashing" } else { "dark" })
    }
}
