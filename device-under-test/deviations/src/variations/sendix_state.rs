//! Variations of the Sendix 58xx that have state, or that take more than a line.

use crate::seams::Deviations;
use crate::tables::signal_image::is_parked;
use crate::tables::start::USER_PARAMETERS;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use core::time::Duration;
use device_stack::profinet::{ArKey, RecordAccess};
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::{CountingDirection, Hardware, MeasuringSettings, PresetMode, Scaling};
use encoder_profile::hooks::{EncoderHooks, EncoderView};
use encoder_profile::profidrive::preset_trigger::TRIGGER;
use encoder_profile::profidrive::sensor::SensorError;
use encoder_profile::profidrive::telegram::{OutputValues, OutputWord, PreviousCycle, SignalImage, Telegram, parts};
use encoder_profile::profidrive::user_parameters::{OCTETS, UserParameterData};
use station::Time;

/// Some errors are reported some time after their cause appears, and until some time after it has gone.
pub struct LateErrors {
    by: Duration,
    concerns: fn(Option<u16>) -> bool,
    shown: Vec<SensorError>,
    /// The causes as they last were, and since when.
    present: Vec<SensorError>,
    since: Option<Time>,
}

impl LateErrors {
    /// Errors whose code `concerns` selects are late by this time.
    pub fn new(by: Duration, concerns: fn(Option<u16>) -> bool) -> LateErrors {
        LateErrors { by, concerns, shown: Vec::new(), present: Vec::new(), since: None }
    }
}

impl EncoderHooks for LateErrors {
    fn causes(&mut self, view: &EncoderView<'_>, right: Vec<SensorError>) -> Vec<SensorError> {
        let concerns = self.concerns;
        let (present, others): (Vec<_>, Vec<_>) = right.into_iter().partition(|error| concerns(error.code));
        if present != self.present {
            (self.present, self.since) = (present, Some(view.now));
        }
        if self.since.is_some_and(|since| view.now.since(since) >= self.by) {
            self.shown.clone_from(&self.present);
        }
        others.into_iter().chain(self.shown.iter().copied()).collect()
    }

    fn powered_up(&mut self) {
        (self.shown, self.present, self.since) = (Vec::new(), Vec::new(), None);
    }
}

/// Warnings are reported some time after their cause appears, and until some time after it has gone.
pub struct LateWarnings {
    by: Duration,
    shown: u32,
    present: u32,
    since: Option<Time>,
}

impl LateWarnings {
    /// Warnings are late by this time.
    pub fn new(by: Duration) -> LateWarnings {
        LateWarnings { by, shown: 0, present: 0, since: None }
    }
}

impl EncoderHooks for LateWarnings {
    fn warnings(&mut self, view: &EncoderView<'_>, right: u32) -> u32 {
        if right != self.present {
            (self.present, self.since) = (right, Some(view.now));
        }
        if self.since.is_some_and(|since| view.now.since(since) >= self.by) {
            self.shown = self.present;
        }
        self.shown
    }

    fn powered_up(&mut self) {
        (self.shown, self.present, self.since) = (0, 0, None);
    }
}

/// The velocity changes once per second and is held in between.
#[derive(Default)]
pub struct HeldVelocity {
    held: Option<(Time, i64)>,
}

impl EncoderHooks for HeldVelocity {
    fn image(&mut self, view: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
        let (since, velocity) = match self.held {
            Some((since, held)) if view.now.since(since) < Duration::from_secs(1) => (since, held),
            _ => (view.now, now.velocity),
        };
        self.held = Some((since, velocity));
        SignalImage { velocity, ..now }
    }

    fn starts(&mut self, _: &EncoderView<'_>) {
        self.held = None;
    }
}

/// A request that was set without Control by PLC does not count until it was reset.
#[derive(Default)]
pub struct HeldRequest {
    is_held: bool,
}

const CONTROL: u16 = 1 << 10;
const REQUEST: u16 = 1 << 12;

impl EncoderHooks for HeldRequest {
    fn starts(&mut self, _: &EncoderView<'_>) {
        self.is_held = false;
    }

    fn outputs(&mut self, _: &EncoderView<'_>, telegram: &Telegram, arrived: OutputValues) -> OutputValues {
        let Some([stw2_enc, g1_stw]) = arrived.words.filter(|_| telegram.outputs.contains(&OutputWord::G1Stw)) else {
            return arrived;
        };
        let is_requested = g1_stw & REQUEST != 0;
        self.is_held = is_requested && (self.is_held || stw2_enc & CONTROL == 0);
        let g1_stw = if self.is_held { g1_stw & !REQUEST } else { g1_stw };
        OutputValues { words: Some([stw2_enc, g1_stw]), ..arrived }
    }
}

/// A parameter response can be fetched twice.
#[derive(Default)]
pub struct ReadTwice(Option<(ArKey, Vec<u8>)>);

impl EncoderHooks for ReadTwice {
    fn fetched_response(&mut self, by: ArKey, waiting: Option<Vec<u8>>) -> Option<Vec<u8>> {
        match waiting {
            Some(response) => {
                self.0 = Some((by, response.clone()));
                Some(response)
            }
            None => self.0.take().filter(|(of, _)| *of == by).map(|(_, response)| response),
        }
    }
}

/// The shift of a relative preset that does not leave the range: limited to it, or none at all.
pub fn relative_preset(view: &EncoderView<'_>, mode: PresetMode, right: u64, is_limited: bool) -> u64 {
    let positions = view.positions as i64;
    if mode != PresetMode::Relative || positions <= 0 {
        return right;
    }
    let position = view.measuring.shifted() as i64;
    let target = position + i64::from(view.preset_value as i32);
    match (0..positions).contains(&target) {
        true => right,
        false if is_limited => (target.clamp(0, positions - 1) - position).rem_euclid(positions) as u64,
        false => 0,
    }
}

/// Presets that class 4 blocks are acknowledged.
pub fn blocked_preset_is_acknowledged(d: &mut Deviations) {
    let is_blocked = Rc::new(Cell::new(false));
    let of_record = Rc::clone(&is_blocked);
    d.encoder.user_parameters(move |_, user| {
        is_blocked.set(!user.class_4);
        user
    });
    d.checks.check(move |check, right| match check {
        EncoderCheck::AnswersPreset { carried_out: false, requested, parked } if of_record.get() => {
            requested && !parked
        }
        _ => right,
    });
}

/// A request in the frame of a trigger bit sets the position to the value of the trigger.
pub fn both_presets(d: &mut Deviations) {
    let triggered = Rc::new(Cell::new(None));
    let at_once = Rc::clone(&triggered);
    d.encoder.outputs(move |view, telegram, arrived| {
        if telegram.outputs.contains(&OutputWord::Preset) {
            let was_set = view.outputs.preset.unwrap_or(0) & TRIGGER != 0;
            triggered.set(arrived.preset.filter(|word| !was_set && word & TRIGGER != 0));
        }
        arrived
    });
    d.encoder.preset_units(move |view, mode, right| match at_once.get() {
        Some(word) if mode == PresetMode::Absolute => u64::from(word & 0x0FFF_FFFF).min(view.positions.max(1) - 1),
        _ => right,
    });
}

/// With scaling off a preset by the trigger bit is limited by the range of the record.
pub fn limit_of_the_record(d: &mut Deviations) {
    let unused = Rc::new(Cell::new(None));
    let range = Rc::clone(&unused);
    d.encoder.user_parameters(move |_, user| {
        unused.set(Some(user.range).filter(|_| !user.scaling));
        user
    });
    d.trigger.value(move |_, _, right| range.get().map_or(right, |range: u64| right.min(range.max(1) - 1)));
}

/// Without preset control G1_XIST1 has the offset of all presets but the last one.
#[derive(Default)]
pub struct EarlierPresets {
    /// The offset before the last preset, and that after it.
    offsets: Option<(u64, u64)>,
}

impl EncoderHooks for EarlierPresets {
    fn image(&mut self, view: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
        let offset = view.measuring.offset;
        let (before, after) = self.offsets.unwrap_or((0, offset));
        let (before, after) = if after == offset { (before, after) } else { (after, offset) };
        self.offsets = Some((before, after));
        if view.user.preset_acts_on_xist1 || !view.measuring.settings.offset_acts || is_parked(&now) {
            return now;
        }
        let range = view.measuring.range().max(1);
        SignalImage { g1_xist1: ((u64::from(now.g1_xist1) + before) % range) as u32, ..now }
    }

    fn powered_up(&mut self) {
        self.offsets = None;
    }
}

/// Without preset control G1_XIST1 counts over all revolutions.
pub fn first_position_over_all_revolutions(view: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
    let measuring = view.measuring;
    let is_scaled = view.user.class_4 && view.user.scaling;
    if view.user.preset_acts_on_xist1 || !is_scaled || is_parked(&now) || measuring.settings.saturates_at.is_some() {
        return now;
    }
    let units = measuring.settings.scaling.units(&view.hardware, measuring.in_direction(measuring.place));
    SignalImage { g1_xist1: units as u32, ..now }
}

/// With class 4 off scaling and direction stay as they were.
pub struct SettingsOfClass4(Cell<Scaling>, Cell<CountingDirection>);

impl Default for SettingsOfClass4 {
    fn default() -> SettingsOfClass4 {
        let scaling = Scaling { units_per_revolution: 8192, range: 8192 };
        SettingsOfClass4(Cell::new(scaling), Cell::new(CountingDirection::Clockwise))
    }
}

impl SettingsOfClass4 {
    /// The settings that result from user parameters.
    pub fn settings(&self, user: &UserParameterData, _: &Hardware, right: MeasuringSettings) -> MeasuringSettings {
        if user.class_4 {
            self.0.set(right.scaling);
            self.1.set(right.direction);
            return right;
        }
        MeasuringSettings { scaling: self.0.get(), direction: self.1.get(), ..right }
    }
}

/// While parked the positions outside StdTel81 follow the shaft.
pub fn other_positions_go_on(view: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
    if !is_parked(&now) {
        return now;
    }
    let position = view.measuring.shifted();
    let [single_turn, multi_turn] = parts(position, &view.measuring.settings.scaling);
    SignalImage { plain_position: position as u32, single_turn, multi_turn, ..now }
}

/// Whether an access is to the record of user parameters.
pub fn is_record(access: RecordAccess) -> bool {
    access.index == USER_PARAMETERS
}

/// Whether the values of a record are valid; a record of another length is left to the encoder.
pub fn within_limits(octets: &[u8], view: &EncoderView<'_>) -> bool {
    let Some(user) = UserParameterData::parse(octets) else { return true };
    let (units, range, hardware) = (user.units_per_revolution, user.range, view.hardware);
    if user.speed_unit > 3 {
        return false;
    }
    if !user.class_4 || !user.scaling {
        return true;
    }
    let (small, great) = (units.min(range).max(1), units.max(range));
    let is_cyclic = great % small == 0 && (great / small).is_power_of_two();
    (1..=hardware.steps_per_revolution).contains(&units)
        && (1..=hardware.range()).contains(&range)
        && range <= units * hardware.revolutions
        && (is_cyclic || !user.preset_acts_on_xist1)
}

/// A record of the right length that no encoder can serve.
pub fn invalid_record() -> Vec<u8> {
    let mut octets = alloc::vec![0; OCTETS];
    octets[0] = 0x2A;
    octets
}

/// Whether a record has reserved bits or bytes set.
pub fn reported(octets: &[u8]) -> bool {
    octets.first().is_some_and(|bits| bits & 0xC0 != 0)
        || octets.get(19..OCTETS).is_some_and(|rest| rest != [0; OCTETS - 19])
}
