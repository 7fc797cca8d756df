//! The state of an AFS60 or AFM60 in addition to the encoder object, and the model for the encoder object.

use super::hooks::{Afx60Deviations, Afx60Event, RetainedVendorData};
use super::{FREQUENCY, HOT, OVERVOLTAGE, TEMPERATURE, UNDERVOLTAGE};
use super::{controls, leds, limits, parameters, round_axis, sensor_status, service_log, start_record};
use crate::models::sick;
use alloc::vec::Vec;
use device_stack::profinet::{RecordAccess, RecordRefusal, StackStatus};
use encoder_profile::encoder::{MeasuringSettings, PresetMode};
use encoder_profile::encoder_object::{EncoderModel, PoweredEncoder};
use encoder_profile::facts::{ClearedData, ErrorFact};
use encoder_profile::profidrive::parameters::ParameterContent;
use station::{StandAction, Time};
use wire::ethernet::Mac;
use wire::profidrive::ErrorNumber;

/// The state of an AFS60 or AFM60 in addition to the encoder object.
#[derive(Clone, Debug)]
pub struct Afx60State {
    /// The deviations at the parts that the SICK encoders share.
    pub(super) shared: sick::hooks::SickDeviations,
    /// The deviations at the parts that only these encoders have.
    pub(super) hooks: Afx60Deviations,
    pub(super) mac: Mac,
    pub(super) inputs: controls::StandInputs,
    pub(super) limits: limits::LimitSettings,
    pub(super) status: sensor_status::SensorStatusFlags,
    pub(super) service: service_log::ServiceLog,
    pub(super) axis: round_axis::RoundAxisState,
    /// The save mode: whether P1006, P1007 and P65000 are stored with each change.
    pub(super) saves_each_change: bool,
    /// Whether the vendor record of this start had a value out of its limits.
    pub(super) record_is_wrong: bool,
}

impl Afx60State {
    /// Creates the factory state.
    pub fn new(mac: [u8; 6], shared: sick::hooks::SickDeviations, hooks: Afx60Deviations) -> Afx60State {
        Afx60State {
            shared,
            hooks,
            mac: Mac(mac),
            inputs: controls::StandInputs::default(),
            limits: limits::LimitSettings::default(),
            status: sensor_status::SensorStatusFlags::default(),
            service: service_log::ServiceLog::default(),
            axis: round_axis::RoundAxisState::default(),
            saves_each_change: false,
            record_is_wrong: false,
        }
    }
}

impl EncoderModel for Afx60State {
    fn parameter(live: &PoweredEncoder<'_, Afx60State>, number: u16) -> Option<ParameterContent> {
        parameters::own_parameter(live, number)
    }

    fn write(
        live: &mut PoweredEncoder<'_, Afx60State>,
        number: u16,
        subindex: u16,
        values: &[u64],
    ) -> Option<Result<(), ErrorNumber>> {
        parameters::write_own(live, number, subindex, values)
    }

    fn write_record(
        live: &mut PoweredEncoder<'_, Afx60State>,
        access: RecordAccess,
        data: &[u8],
    ) -> Option<Result<(), RecordRefusal>> {
        (access.index == start_record::RECORD).then(|| start_record::write_start_record(live, access, data))
    }

    fn read_record(
        live: &mut PoweredEncoder<'_, Afx60State>,
        access: RecordAccess,
        _: &mut Vec<u8>,
    ) -> Option<Result<(), RecordRefusal>> {
        (access.index == start_record::RECORD && live.is_at_access_point(&access))
            .then_some(Err(RecordRefusal::AccessDenied))
    }

    fn is_caused(live: &PoweredEncoder<'_, Afx60State>, error: &ErrorFact) -> bool {
        match error.code {
            Some(UNDERVOLTAGE) => limits::supply_is_wrong(live)[0],
            Some(OVERVOLTAGE) => limits::supply_is_wrong(live)[1],
            Some(HOT) => controls::measured(live).celsius > controls::HIGHEST_TEMPERATURE,
            _ => false,
        }
    }

    fn warnings(live: &PoweredEncoder<'_, Afx60State>) -> u32 {
        let bit = |bit: u32, set: bool| if set { bit } else { 0 };
        bit(FREQUENCY, limits::is_too_fast(live)) | bit(TEMPERATURE, limits::temperature_is_outside(live))
    }

    fn settings(live: &PoweredEncoder<'_, Afx60State>, settings: MeasuringSettings) -> MeasuringSettings {
        round_axis::with_axis(live, settings)
    }

    fn takes_preset(live: &mut PoweredEncoder<'_, Afx60State>, mode: PresetMode, value: u64) -> bool {
        sensor_status::check_preset(live, mode, value)
    }

    fn advance(live: &mut PoweredEncoder<'_, Afx60State>) {
        limits::measure_speed(live);
        service_log::log(live);
        sensor_status::end_saves(live);
        controls::update_button(live);
        round_axis::store_laps(live);
    }

    fn started(live: &mut PoweredEncoder<'_, Afx60State>) {
        let before = RetainedVendorData::of(live);
        let Afx60State { saves_each_change, record_is_wrong, axis, limits, status, .. } = &mut *live.model;
        (*saves_each_change, *record_is_wrong) = (false, false);
        (status.has_invalid_preset, status.has_accepted_preset) = (false, false);
        axis.begin();
        limits.speed.begin();
        before.keep(live, Afx60Event::Start);
    }

    fn parametrized(live: &mut PoweredEncoder<'_, Afx60State>) {
        round_axis::apply_start_range(live);
        let range_is_wrong = if live.model.axis.is_on {
            !round_axis::axis_is_right(live) || !live.ram.user.has_unit(&live.encoder())
        } else {
            live.ram.wrong_parameters
        };
        live.model.status.has_invalid_parameter = range_is_wrong || live.model.record_is_wrong;
    }

    fn act(live: &mut PoweredEncoder<'_, Afx60State>, action: &StandAction<'_>) -> Option<Time> {
        controls::handle(live, action)
    }

    fn led(live: &PoweredEncoder<'_, Afx60State>, name: &str, status: &StackStatus) -> Option<&'static str> {
        leds::led(live, name, status)
    }

    fn power_up(live: &mut PoweredEncoder<'_, Afx60State>) {
        let before = RetainedVendorData::of(live);
        let Afx60State { inputs: around, limits, status, service, axis, shared, .. } = &mut *live.model;
        around.power(true);
        (limits.speed, limits.limits) = (limits::SpeedSettings::default(), *limits.memory.stored());
        *status = sensor_status::SensorStatusFlags::default();
        service.power_up(live.now, shared);
        axis.begin();
        (live.model.saves_each_change, live.model.record_is_wrong) = (false, false);
        before.keep(live, Afx60Event::PowerUp);
        round_axis::restore_laps(live);
    }

    fn power_down(live: &mut PoweredEncoder<'_, Afx60State>) {
        let before = RetainedVendorData::of(live);
        let is_saving = live.model.status.saving == sensor_status::SaveProgress::Running;
        live.model.limits.memory.power_down();
        live.model.inputs.power(false);
        before.keep(live, Afx60Event::PowerDown { is_saving });
    }

    fn reset(live: &mut PoweredEncoder<'_, Afx60State>) {
        let before = RetainedVendorData::of(live);
        let Afx60State { mac, inputs: around, service, shared, hooks, .. } = live.model.clone();
        *live.model = Afx60State { inputs: around, service, ..Afx60State::new(mac.0, shared, hooks) };
        before.keep(live, Afx60Event::Reset);
    }

    fn reset_at_power_up(&mut self) -> Option<ClearedData> {
        let is_due = core::mem::take(&mut self.inputs.reset_is_due);
        is_due.then_some(ClearedData { application: true, station: true })
    }

    fn is_alive(&self) -> bool {
        self.inputs.is_alive(&self.hooks)
    }

    fn deadline(&self) -> Option<Time> {
        [self.inputs.deadline(), self.limits.memory.deadline()].into_iter().flatten().min()
    }
}
