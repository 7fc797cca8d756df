//! What is the own of these encoders: what they keep beside the encoder object, and its hooks into it.

use super::knobs::Knobs;
use super::parameters;
use super::{FREQUENCY, HOT, OVERVOLTAGE, POSITION, TEMPERATURE, UNDERVOLTAGE};
use super::{axis, limits, log, start, station, status};
use ::station::{StandAction, Time};
use alloc::vec::Vec;
use device_stack::profinet::{Access, RecordRefusal, Seen};
use encoder_profile::encoder::{PresetMode, Settings};
use encoder_profile::encoder_object::{Live, Model};
use encoder_profile::facts::{ErrorFact, Reset};
use encoder_profile::profidrive::parameters::Parameter;
use wire::ethernet::Mac;
use wire::profidrive::ErrorNumber;

/// What is the own of these encoders.
#[derive(Clone, Debug)]
pub struct State {
    pub(super) mac: Mac,
    pub(super) around: station::Surroundings,
    pub(super) limits: limits::Stored,
    pub(super) status: status::Status,
    pub(super) service: log::Service,
    pub(super) axis: axis::Axis,
    /// The save mode: whether P1006, P1007 and P65000 are stored with each change.
    pub(super) saves_each_change: bool,
    /// Whether the record of the vendor of this start had a value out of its limits.
    pub(super) record_is_wrong: bool,
    /// Whether the start transmitted the preset value.
    pub(super) transmits: bool,
    /// What was written to P980 and to the outputs of P1009, where that can be.
    pub(super) list: Vec<(usize, u64)>,
    pub(super) outputs: Vec<(usize, u64)>,
    /// Whether the error of a start is raised.
    pub(super) begins_with_error: bool,
}

impl State {
    /// As delivered.
    pub fn new(mac: [u8; 6]) -> State {
        State {
            mac: Mac(mac),
            around: station::Surroundings::default(),
            limits: limits::Stored::default(),
            status: status::Status::default(),
            service: log::Service::default(),
            axis: axis::Axis::new(),
            saves_each_change: false,
            record_is_wrong: false,
            transmits: false,
            list: Vec::new(),
            outputs: Vec::new(),
            begins_with_error: false,
        }
    }
}

impl Model for State {
    type Rules = Knobs;

    fn parameter(live: &Live<'_, State>, number: u16) -> Option<Parameter> {
        parameters::own_parameter(live, number)
    }

    fn write(
        live: &mut Live<'_, State>,
        number: u16,
        subindex: u16,
        values: &[u64],
    ) -> Option<Result<(), ErrorNumber>> {
        parameters::write_own(live, number, subindex, values)
    }

    fn write_record(live: &mut Live<'_, State>, access: Access, data: &[u8]) -> Option<Result<(), RecordRefusal>> {
        (access.index == start::RECORD).then(|| start::write_start_record(live, access, data))
    }

    fn read_record(live: &mut Live<'_, State>, access: Access, _: &mut Vec<u8>) -> Option<Result<(), RecordRefusal>> {
        (access.index == start::RECORD && live.is_here(&access)).then_some(Err(RecordRefusal::AccessDenied))
    }

    fn is_caused(live: &Live<'_, State>, error: &ErrorFact) -> bool {
        match error.code {
            Some(UNDERVOLTAGE) => limits::voltage_is_outside(live)[0] || live.model.around.stays_low,
            Some(OVERVOLTAGE) => limits::voltage_is_outside(live)[1],
            Some(POSITION) => live.model.begins_with_error,
            Some(HOT) => live.model.around.celsius > station::HIGHEST_TEMPERATURE,
            _ => false,
        }
    }

    fn warnings(live: &Live<'_, State>) -> u32 {
        let bit = |bit: u32, set: bool| if set { bit } else { 0 };
        bit(FREQUENCY, limits::is_too_fast(live)) | bit(TEMPERATURE, limits::temperature_is_outside(live))
    }

    fn settings(live: &Live<'_, State>, settings: Settings) -> Settings {
        axis::with_axis(live, settings)
    }

    fn takes_preset(live: &mut Live<'_, State>, mode: PresetMode, value: u64) -> bool {
        status::judge_preset(live, mode, value)
    }

    fn advance(live: &mut Live<'_, State>) {
        live.model.begins_with_error = false;
        live.model.status.faults_seen |= u64::from(live.fault_bits());
        limits::measure_speed(live);
        log::log(live);
        status::end_saves(live);
        station::watch_button(live);
        axis::keep_laps(live);
    }

    fn started(live: &mut Live<'_, State>) {
        let model = &mut *live.model;
        (model.saves_each_change, model.record_is_wrong, model.transmits) = (false, false, false);
        model.axis.begin(&live.rules.sick);
        model.limits.speed.begin();
        let status = &mut live.model.status;
        (status.faults_seen, status.has_invalid_preset, status.has_accepted_preset) = (0, false, false);
        live.model.begins_with_error = live.rules.own.begins_with_error;
    }

    fn parametrized(live: &mut Live<'_, State>) {
        axis::note_axis(live);
        let range_is_wrong = match live.model.axis.is_on {
            true => !axis::axis_is_right(live) || !live.ram.user.has_unit(&live.encoder()),
            false => live.ram.wrong_parameters,
        };
        live.model.status.has_invalid_parameter = range_is_wrong || live.model.record_is_wrong;
    }

    fn act(live: &mut Live<'_, State>, action: &StandAction<'_>) -> Option<Time> {
        station::handle(live, action)
    }

    fn led(live: &Live<'_, State>, name: &str, seen: &Seen) -> Option<&'static str> {
        station::light(live, name, seen)
    }

    fn power_up(live: &mut Live<'_, State>) {
        let rules = &live.rules.own;
        let model = &mut *live.model;
        model.around.power(true);
        (model.limits.speed, model.limits.limits) = (limits::Speed::default(), *model.limits.memory.stored());
        model.status = status::Status::default();
        model.service.power_up(live.now, &live.rules.sick);
        model.axis.power_up(&live.rules.sick);
        (model.saves_each_change, model.record_is_wrong, model.transmits) = (false, false, false);
        (model.list, model.outputs) = (Vec::new(), Vec::new());
        if !rules.stores_preset_value {
            live.ram.preset_value = 0;
        }
        axis::recall_laps(live);
    }

    fn power_down(live: &mut Live<'_, State>) {
        if live.rules.own.save_is_torn && live.model.status.saving == status::Saving::Running {
            live.store.preset_value.replace(live.ram.preset_value);
        }
        live.model.limits.memory.power_down();
        live.model.around.power(false);
    }

    fn reset(live: &mut Live<'_, State>) {
        let model = &mut *live.model;
        let rules = &live.rules.own;
        let around = model.around.clone();
        let mut new = State { around, ..State::new(model.mac.0) };
        if !rules.reset_clears_log {
            new.service = model.service.clone();
        } else {
            new.service.begin_anew();
        }
        if rules.reset_keeps_limits {
            new.limits = model.limits.clone();
        }
        if live.rules.sick.axis_survives {
            new.axis = model.axis;
        }
        *model = new;
    }

    fn reset_at_power_up(&mut self) -> Option<Reset> {
        let is_due = core::mem::take(&mut self.around.reset_is_due);
        is_due.then_some(Reset { application: true, station: true })
    }

    fn is_alive(&self) -> bool {
        self.around.is_alive()
    }

    fn deadline(&self) -> Option<Time> {
        [self.around.deadline(), self.limits.memory.deadline()].into_iter().flatten().min()
    }
}
