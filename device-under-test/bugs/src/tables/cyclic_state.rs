//! Deviations of the cyclic exchange that have state.

use super::signal_image::{ERROR, EXECUTED, PARKED, has_error, is_executed, is_parked};
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use core::time::Duration;
use encoder_profile::checks::{EncoderCheck, EncoderChecks};
use encoder_profile::hooks::{EncoderHooks, EncoderView, WorkingPreset};
use encoder_profile::profidrive::control::CONTROL_BY_PLC;
use encoder_profile::profidrive::preset_trigger::TRIGGER;
use encoder_profile::profidrive::sensor::SensorError;
use encoder_profile::profidrive::telegram::{OutputValues, PreviousCycle, SignalImage, Telegram};
use encoder_profile::profidrive::user_parameters::UserParameterData;
use station::Time;

/// A deviating sign of life of the encoder, derived from the right one step by step.
pub struct SignOfLifeDeviation {
    right: u8,
    sent: u8,
    next: fn(u8) -> u8,
    counts: fn(&EncoderView<'_>, &SignalImage) -> bool,
}

impl SignOfLifeDeviation {
    /// A sign of life that counts by `next`.
    pub fn by(next: fn(u8) -> u8) -> SignOfLifeDeviation {
        SignOfLifeDeviation { right: 0, sent: 0, next, counts: |_, _| true }
    }

    /// A sign of life that counts only in frames for which `counts` returns `true`.
    pub fn counting_while(counts: fn(&EncoderView<'_>, &SignalImage) -> bool) -> SignOfLifeDeviation {
        SignOfLifeDeviation { counts, ..SignOfLifeDeviation::by(encoder_profile::profidrive::life_sign::next) }
    }
}

impl EncoderHooks for SignOfLifeDeviation {
    fn image(&mut self, view: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
        let right = (now.zsw2_enc >> 12) as u8;
        let steps = (15 + right - self.right) % 15;
        self.right = right;
        if right == 0 {
            self.sent = 0;
        } else if (self.counts)(view, &now) {
            (0..steps).for_each(|_| self.sent = (self.next)(self.sent));
        }
        SignalImage { zsw2_enc: now.zsw2_enc & 0x0FFF | u16::from(self.sent) << 12, ..now }
    }
}

/// Counts failures of the sign of life of the controller and never resets the count.
#[derive(Clone, Default)]
pub struct LifeSignFailures(Rc<Cell<i32>>);

impl LifeSignFailures {
    /// Returns how many failures are tolerated: `right` until there were more failures, then none.
    pub fn tolerated(&self, right: i32) -> i32 {
        if self.0.get() > right { -1 } else { right }
    }
}

impl EncoderChecks for LifeSignFailures {
    fn check(&mut self, check: EncoderCheck, verdict: bool) -> bool {
        match check {
            EncoderCheck::StartsMonitoring { .. } => self.0.set(0),
            EncoderCheck::FollowsLifeSign { .. } if !verdict => self.0.set(self.0.get() + 1),
            _ => {}
        }
        verdict
    }
}

/// Keeps the last valid G1_STW in force without Control by PLC.
#[derive(Default)]
pub struct LastControlWord(u16);

impl EncoderHooks for LastControlWord {
    fn starts(&mut self, _: &EncoderView<'_>) {
        self.0 = 0;
    }

    fn outputs(&mut self, view: &EncoderView<'_>, _: &Telegram, arrived: OutputValues) -> OutputValues {
        let [stw2_enc, g1_stw] = arrived.words.unwrap_or_default();
        if view.user.compatible && arrived.words.is_some() || stw2_enc & CONTROL_BY_PLC != 0 {
            self.0 = g1_stw;
        }
        OutputValues { words: Some([stw2_enc, self.0]), ..arrived }
    }
}

/// Keeps the value of Control by PLC from before bad outputs for a second.
#[derive(Default)]
pub struct RememberedControl {
    good_since: Option<Time>,
    last: bool,
    before: bool,
}

impl EncoderHooks for RememberedControl {
    fn starts(&mut self, _: &EncoderView<'_>) {
        *self = RememberedControl::default();
    }

    fn outputs(&mut self, view: &EncoderView<'_>, telegram: &Telegram, arrived: OutputValues) -> OutputValues {
        if !telegram.outputs.contains(&encoder_profile::profidrive::telegram::OutputWord::Stw2Enc) {
            return arrived;
        }
        let Some([stw2_enc, g1_stw]) = arrived.words else {
            self.good_since = None;
            return arrived;
        };
        if self.good_since.is_none() {
            (self.good_since, self.before) = (Some(view.now), self.last);
        }
        self.last = stw2_enc & CONTROL_BY_PLC != 0;
        let is_fresh = self.good_since.is_some_and(|since| view.now < since + Duration::from_secs(1));
        let remembered = if is_fresh && self.before { CONTROL_BY_PLC } else { 0 };
        OutputValues { words: Some([stw2_enc | remembered, g1_stw]), ..arrived }
    }
}

/// Ignores requests that are held across connections or a power cycle.
#[derive(Default)]
pub struct HeldRequests {
    /// Whether requests, including parking, are held across connections; otherwise across a power cycle.
    over_connections: bool,
    last: (u16, u32),
    held: (u16, u32),
    is_parked: bool,
}

impl HeldRequests {
    /// Requests held across connections.
    pub fn over_connections() -> HeldRequests {
        HeldRequests { over_connections: true, ..HeldRequests::default() }
    }

    /// Requests held across a power cycle.
    pub fn over_power() -> HeldRequests {
        HeldRequests::default()
    }
}

impl EncoderHooks for HeldRequests {
    fn ends(&mut self, view: &EncoderView<'_>) {
        let last = core::mem::take(&mut self.last);
        if self.over_connections {
            (self.held, self.is_parked) = (last, is_parked(&view.previous.sent));
        }
    }

    fn powered_up(&mut self) {
        let last = core::mem::take(&mut self.last);
        (self.held, self.is_parked) = (if self.over_connections { (0, 0) } else { last }, false);
    }

    fn outputs(&mut self, _: &EncoderView<'_>, _: &Telegram, arrived: OutputValues) -> OutputValues {
        let words = arrived.words.map(|[stw2_enc, g1_stw]| {
            self.held.0 &= g1_stw;
            [stw2_enc, g1_stw & !self.held.0]
        });
        let preset = arrived.preset.map(|word| {
            self.held.1 &= word;
            word & !self.held.1
        });
        OutputValues { words, preset, ..arrived }
    }

    fn image(&mut self, _: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
        let request = now.request;
        let bit = |n: u32, set: bool| u16::from(set) << n;
        self.last.0 = self.held.0 | bit(12, request.home) | bit(15, request.acknowledge);
        self.last.1 = self.held.1 | now.trigger & TRIGGER;
        self.is_parked &= !request.park;
        if self.is_parked { parked(now) } else { now }
    }
}

/// The signals of a parked encoder.
fn parked(now: SignalImage) -> SignalImage {
    SignalImage { g1_zsw: PARKED, g1_xist1: 0, g1_xist2: 0, g1_xist3: 0, velocity: 0, ..now }
}

/// Keeps bit 12 of G1_ZSW set after the end of a connection, until a preset is requested and withdrawn.
#[derive(Default)]
pub struct KeptAnswer(bool);

impl EncoderHooks for KeptAnswer {
    fn powered_up(&mut self) {
        self.0 = false;
    }

    fn ends(&mut self, view: &EncoderView<'_>) {
        self.0 |= is_executed(&view.previous.unhooked);
    }

    fn image(&mut self, _: &EncoderView<'_>, before: &PreviousCycle, now: SignalImage) -> SignalImage {
        self.0 &= !is_executed(&before.unhooked) || is_executed(&now);
        SignalImage { g1_zsw: now.g1_zsw | if self.0 { EXECUTED } else { 0 }, ..now }
    }
}

/// Retains errors across connections and a power cycle.
#[derive(Default)]
pub struct KeptErrors {
    last: Vec<SensorError>,
    returning: Vec<SensorError>,
}

impl EncoderHooks for KeptErrors {
    fn power_down(&mut self, view: &EncoderView<'_>) {
        self.last = view.errors.to_vec();
    }

    fn powered_up(&mut self) {
        self.returning = core::mem::take(&mut self.last);
    }

    fn starts(&mut self, view: &EncoderView<'_>) {
        self.returning = view.errors.to_vec();
    }

    fn causes(&mut self, _: &EncoderView<'_>, right: Vec<SensorError>) -> Vec<SensorError> {
        let mut causes = core::mem::take(&mut self.returning);
        causes.extend(right.into_iter().filter(|error| !causes.contains(error)).collect::<Vec<_>>());
        causes
    }
}

/// Ignores presets by G1_STW after parking, until the next connection.
#[derive(Default)]
pub struct NoPresetsAfterParking(bool);

impl EncoderHooks for NoPresetsAfterParking {
    fn starts(&mut self, _: &EncoderView<'_>) {
        self.0 = false;
    }

    fn outputs(&mut self, view: &EncoderView<'_>, _: &Telegram, arrived: OutputValues) -> OutputValues {
        self.0 |= is_parked(&view.previous.unhooked);
        let words =
            arrived.words.map(|[stw2_enc, g1_stw]| [stw2_enc, if self.0 { g1_stw & !EXECUTED } else { g1_stw }]);
        OutputValues { words, ..arrived }
    }
}

/// Answers no acknowledgement after a failed one.
#[derive(Default)]
pub struct OneAcknowledgement {
    was_answered: bool,
    has_failed: bool,
}

impl EncoderHooks for OneAcknowledgement {
    fn starts(&mut self, _: &EncoderView<'_>) {
        *self = OneAcknowledgement::default();
    }

    fn outputs(&mut self, view: &EncoderView<'_>, _: &Telegram, arrived: OutputValues) -> OutputValues {
        let before = &view.previous.unhooked;
        let is_answered = before.g1_zsw & 0x0800 != 0;
        self.has_failed |= self.was_answered && !is_answered && has_error(before);
        self.was_answered = is_answered;
        let words =
            arrived.words.map(|[stw2_enc, g1_stw]| [stw2_enc, if self.has_failed { g1_stw & !ERROR } else { g1_stw }]);
        OutputValues { words, ..arrived }
    }
}

/// Does not raise errors after parking whose cause appeared while parked.
#[derive(Default)]
pub struct ForgottenInPark(Vec<Option<u16>>);

impl EncoderChecks for ForgottenInPark {
    fn check(&mut self, check: EncoderCheck, verdict: bool) -> bool {
        match check {
            EncoderCheck::Parks { .. } => self.0.clear(),
            EncoderCheck::RaisesError { code, parked: true } if !self.0.contains(&code) => self.0.push(code),
            EncoderCheck::RaisesError { code, parked: false } => return verdict && !self.0.contains(&code),
            _ => {}
        }
        verdict
    }
}

/// Raises an error with each preset.
#[derive(Clone, Default)]
pub struct RaisedByPresets(Rc<Cell<bool>>);

impl EncoderChecks for RaisedByPresets {
    fn check(&mut self, check: EncoderCheck, verdict: bool) -> bool {
        if let EncoderCheck::AnswersPreset { carried_out: true, .. } = check {
            self.0.set(true);
        }
        verdict
    }
}

impl EncoderHooks for RaisedByPresets {
    fn causes(&mut self, _: &EncoderView<'_>, mut right: Vec<SensorError>) -> Vec<SensorError> {
        if self.0.take() {
            right.push(SensorError::of(0x1001));
        }
        right
    }
}

/// Combines the codes of all errors bit by bit.
#[derive(Default)]
pub struct CombinedCodes(u16);

impl EncoderHooks for CombinedCodes {
    fn causes(&mut self, view: &EncoderView<'_>, right: Vec<SensorError>) -> Vec<SensorError> {
        self.0 = view.errors.iter().chain(&right).filter_map(|error| error.code).fold(0, |all, code| all | code);
        right
    }

    fn image(&mut self, _: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
        if has_error(&now) { SignalImage { g1_xist2: self.0.into(), ..now } } else { now }
    }
}

/// Restores the offset from before a preset when its request is withdrawn.
pub fn preset_lost_with_its_request() -> impl FnMut(&EncoderView<'_>, WorkingPreset) -> WorkingPreset {
    let (mut executed_in, mut last, mut before_preset) = (None, 0, 0);
    move |view, held| {
        let is_executed = view.sensor.g1_zsw() & EXECUTED != 0;
        // The request can also end with the connection or at power-off.
        let was_executed = executed_in.is_some() && executed_in == view.data_since;
        if is_executed && !was_executed {
            before_preset = last;
        }
        let is_released = was_executed && !is_executed && !view.sensor.is_parked();
        executed_in = view.data_since.filter(|_| is_executed);
        last = if is_released { before_preset } else { held.offset };
        WorkingPreset { offset: last, ..held }
    }
}

/// Accepts a trigger again only after it has been 0 for three cycles.
pub struct RestedTrigger(u8);

impl Default for RestedTrigger {
    fn default() -> RestedTrigger {
        RestedTrigger(u8::MAX)
    }
}

impl EncoderChecks for RestedTrigger {
    fn check(&mut self, check: EncoderCheck, verdict: bool) -> bool {
        let EncoderCheck::TriggersPreset { before, now } = check else { return verdict };
        if before.is_none() {
            self.0 = u8::MAX;
        }
        let rested = self.0;
        self.0 = if now & TRIGGER == 0 { rested.saturating_add(1) } else { 0 };
        verdict && rested >= 3
    }
}

/// Keeps the word with the trigger while outputs are cleared.
#[derive(Default)]
pub struct KeptTrigger(Option<u32>);

impl EncoderHooks for KeptTrigger {
    fn starts(&mut self, _: &EncoderView<'_>) {
        self.0 = None;
    }

    fn outputs(&mut self, _: &EncoderView<'_>, telegram: &Telegram, arrived: OutputValues) -> OutputValues {
        if !telegram.outputs.contains(&encoder_profile::profidrive::telegram::OutputWord::Preset) {
            return arrived;
        }
        self.0 = arrived.preset.or(self.0);
        OutputValues { preset: self.0, ..arrived }
    }
}

/// Returns the configured tolerance of failures, whatever the mode.
pub fn as_set(user: &UserParameterData, _: i32) -> i32 {
    user.life_sign_failures.into()
}
