//! Variations of the A3M60 that remember something: delays, held values, and what memory keeps.

use crate::seams::Deviations;
use crate::tables::signal_image::{PARKED, has_error, has_position, is_parked};
use alloc::collections::{BTreeMap, VecDeque};
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::{Cell, RefCell};
use core::time::Duration;
use device_stack::profibus::{SlaveApplication, SlaveHooks};
use device_stack::profinet::ArKey;
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::facts::ErrorCause;
use encoder_profile::hooks::{EncoderHooks, EncoderView};
use encoder_profile::profidrive::parameters::ParameterExchange;
use encoder_profile::profidrive::sensor::SensorError;
use encoder_profile::profidrive::telegram::{OutputValues, OutputWord, PreviousCycle, SignalImage, Telegram};
use reference_devices::models::sick::hooks::SickHooks;
use reference_devices::models::sick::log::Log;
use reference_devices::models::sick_a3m60::hooks::{A3m60Check, A3m60Event, A3m60Hooks, A3m60Memory};
use reference_devices::models::sick_a3m60::set_prm::OCTETS;
use reference_devices::models::sick_a3m60::status::{self, SensorStatusWords, noticed};
use reference_devices::models::sick_a3m60::{A3m60State, CONFIGURATIONS, SpeedCalculation};
use station::Time;
use wire::profibus::cfg::IoLengths;
use wire::profibus::prm::{PrmBlock, PrmBlockType, SetPrm};

/// Notices each fault of the stand later than its cause.
pub struct DelayedFaults {
    by: Duration,
    now: Time,
    /// When each present fault began.
    since: BTreeMap<&'static str, Time>,
}

/// The part of [`DelayedFaults`] at one of the two hooks.
struct DelayedFaultHook(Rc<RefCell<DelayedFaults>>);

impl DelayedFaults {
    /// Attaches the delay to both places where faults are noticed.
    pub fn attach(d: &mut Deviations, by: Duration) {
        let faults = Rc::new(RefCell::new(DelayedFaults { by, now: Time::ZERO, since: BTreeMap::new() }));
        d.encoder.add(DelayedFaultHook(Rc::clone(&faults)));
        d.a3m60.add(DelayedFaultHook(faults));
    }

    fn is_noticed(&self, name: &str) -> bool {
        self.since.get(name).is_some_and(|since| self.now.since(*since) >= self.by)
    }
}

fn stand_causes(view: &EncoderView<'_>, error: &SensorError) -> Vec<&'static str> {
    let Some(fact) = view.facts.errors.get(usize::from(error.number)) else { return Vec::new() };
    let name = |cause: &ErrorCause| if let ErrorCause::Stand(name) = cause { Some(*name) } else { None };
    fact.causes.iter().filter_map(name).collect()
}

impl EncoderHooks for DelayedFaultHook {
    fn causes(&mut self, view: &EncoderView<'_>, right: Vec<SensorError>) -> Vec<SensorError> {
        let mut faults = self.0.borrow_mut();
        faults.now = view.now;
        let present: Vec<&'static str> = right.iter().flat_map(|error| stand_causes(view, error)).collect();
        faults.since.retain(|name, _| present.contains(name));
        for name in present {
            faults.since.entry(name).or_insert(view.now);
        }
        let is_shown = |error: &SensorError| stand_causes(view, error).iter().all(|name| faults.is_noticed(name));
        right.into_iter().filter(is_shown).collect()
    }

    fn powered_up(&mut self) {
        self.0.borrow_mut().since.clear();
    }
}

impl A3m60Hooks for DelayedFaultHook {
    fn check(&mut self, check: A3m60Check, verdict: bool) -> bool {
        match check {
            A3m60Check::Fault(name) => verdict && self.0.borrow().is_noticed(name),
            _ => verdict,
        }
    }
}

/// Takes the requests of presets later than they arrive: bits 11 and 12 of G1_STW, and the preset word.
pub struct DelayedPresetRequests {
    by: Duration,
    /// Arrival of each G1_STW with its bits.
    bits: VecDeque<(Time, u16)>,
    /// Arrival of each preset word.
    words: VecDeque<(Time, Option<u32>)>,
}

/// Bits 11 and 12 of G1_STW.
const PRESET_BITS: u16 = 0x1800;

impl DelayedPresetRequests {
    /// Delays by this time.
    pub fn new(by: Duration) -> DelayedPresetRequests {
        DelayedPresetRequests { by, bits: VecDeque::new(), words: VecDeque::new() }
    }
}

/// Adds a value, and returns the one that is due: the latest that is old enough, or the first.
fn due<T: Copy>(queue: &mut VecDeque<(Time, T)>, now: Time, by: Duration, value: T) -> T {
    queue.push_back((now, value));
    while queue.get(1).is_some_and(|(arrived, _)| now.since(*arrived) >= by) {
        queue.pop_front();
    }
    queue.front().map_or(value, |(_, value)| *value)
}

impl EncoderHooks for DelayedPresetRequests {
    fn starts(&mut self, _: &EncoderView<'_>) {
        self.bits.clear();
        self.words.clear();
    }

    fn outputs(&mut self, view: &EncoderView<'_>, telegram: &Telegram, arrived: OutputValues) -> OutputValues {
        if telegram.outputs.contains(&OutputWord::Preset) {
            return OutputValues { preset: due(&mut self.words, view.now, self.by, arrived.preset), ..arrived };
        }
        let Some([stw2_enc, g1_stw]) = arrived.words else { return arrived };
        let bits = due(&mut self.bits, view.now, self.by, g1_stw & PRESET_BITS);
        OutputValues { words: Some([stw2_enc, g1_stw & !PRESET_BITS | bits]), ..arrived }
    }
}

/// Gives the response to a parameter request only after a time; until then there is none.
pub struct LateResponses {
    by: Duration,
    now: Rc<Cell<Time>>,
    due: Time,
    held: Option<Vec<u8>>,
}

impl LateResponses {
    /// Attaches the delay.
    pub fn attach(d: &mut Deviations, by: Duration) {
        let now = d.track(Time::ZERO, |encoder, _, _| encoder.now);
        d.encoder.add(LateResponses { by, now, due: Time::ZERO, held: None });
    }
}

impl EncoderHooks for LateResponses {
    fn parameter_response(&mut self, _: &ParameterExchange, octets: Vec<u8>) -> Vec<u8> {
        (self.due, self.held) = (self.now.get() + self.by, None);
        octets
    }

    fn fetched_response(&mut self, _: ArKey, waiting: Option<Vec<u8>>) -> Option<Vec<u8>> {
        self.held = waiting.or(self.held.take());
        if self.now.get() >= self.due { self.held.take() } else { None }
    }

    fn ends(&mut self, _: &EncoderView<'_>) {
        self.held = None;
    }

    fn powered_up(&mut self) {
        self.held = None;
    }
}

/// Determines the position at intervals only, without a clock.
pub struct HeldPosition {
    every: Duration,
    held: Option<(Time, i64)>,
}

impl HeldPosition {
    /// Determines it at these intervals.
    pub fn new(every: Duration) -> HeldPosition {
        HeldPosition { every, held: None }
    }
}

impl A3m60Hooks for HeldPosition {
    fn place(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, place: i64) -> i64 {
        let is_due = self.held.is_none_or(|(since, _)| encoder.now.since(since) >= self.every);
        if is_due || encoder.model.clock.times().is_some() {
            self.held = Some((encoder.now, place));
        }
        self.held.map_or(place, |(_, place)| place)
    }
}

/// Keeps the last position in G1_XIST2 without a request.
#[derive(Default)]
pub struct Xist2Stays {
    last: u32,
}

impl EncoderHooks for Xist2Stays {
    fn starts(&mut self, _: &EncoderView<'_>) {
        self.last = 0;
    }

    fn image(&mut self, _: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
        if has_position(&now) {
            self.last = now.g1_xist2;
        }
        if has_position(&now) || has_error(&now) || is_parked(&now) || now.g1_xist2 != 0 {
            now
        } else {
            SignalImage { g1_xist2: self.last, ..now }
        }
    }
}

/// Keeps G1_XIST1 while parked.
#[derive(Default)]
pub struct ParkedPositionsStay {
    held: SignalImage,
}

impl EncoderHooks for ParkedPositionsStay {
    fn image(&mut self, _: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
        if now.g1_zsw & PARKED == 0 {
            self.held = now;
        }
        if now.g1_zsw & PARKED == 0 || now.g1_xist1 != 0 {
            return now;
        }
        SignalImage { g1_xist1: self.held.g1_xist1, shift: self.held.shift, ..now }
    }
}

/// Keeps sending the code of several errors after there were several, until power-off.
#[derive(Default)]
pub struct CodesUntilPowerOff {
    had_several: bool,
}

impl A3m60Hooks for CodesUntilPowerOff {
    fn happens(&mut self, event: A3m60Event, _: &mut A3m60Memory<'_>) {
        self.had_several &= event != A3m60Event::PowerUp;
    }

    fn status(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, words: SensorStatusWords) -> SensorStatusWords {
        let codes: Vec<i32> = noticed(encoder).map(|fault| fault.code).collect();
        self.had_several |= status::code(&codes) == Some(status::SEVERAL);
        words
    }

    fn fault_code(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, code: Option<i32>) -> Option<i32> {
        if self.had_several && encoder.model.fields.shows_codes() { Some(status::SEVERAL) } else { code }
    }
}

/// Refuses the configuration of the IO modules after parameters of isochronous mode.
#[derive(Default)]
pub struct RefusesClockWithIoModules {
    is_isochronous: bool,
}

impl SlaveHooks for RefusesClockWithIoModules {
    fn parameters(&mut self, parameters: &mut SetPrm) -> bool {
        let user = parameters.user_after_dpv1();
        let blocks = PrmBlock::parse_all(user).or_else(|_| PrmBlock::parse_all(&user[user.len().min(OCTETS)..]));
        let is_clock = |block: &PrmBlock| block.kind == PrmBlockType::ISOCHRONOUS;
        self.is_isochronous = blocks.is_ok_and(|blocks| blocks.iter().any(is_clock));
        true
    }

    fn configuration(
        &mut self,
        _: &dyn SlaveApplication,
        identifiers: &[u8],
        right: Option<IoLengths>,
    ) -> Option<IoLengths> {
        right.filter(|_| !self.is_isochronous || !CONFIGURATIONS[..2].contains(&identifiers))
    }
}

/// Loses the seconds of motion since the last full ten of them at power-off.
pub struct RoundedLog;

impl SickHooks for RoundedLog {
    fn log_loaded(&mut self, log: &mut Log) {
        log.motion = Duration::from_secs(log.motion.as_secs() / 10 * 10);
    }
}

/// Keeps P1008 without power.
#[derive(Default)]
pub struct KeptSpeedSettings {
    kept: Option<SpeedCalculation>,
}

impl A3m60Hooks for KeptSpeedSettings {
    fn happens(&mut self, event: A3m60Event, memory: &mut A3m60Memory<'_>) {
        match event {
            A3m60Event::PowerDown => self.kept = Some(*memory.speed),
            A3m60Event::PowerUp => *memory.speed = self.kept.unwrap_or(*memory.speed),
            A3m60Event::Start | A3m60Event::Advance => {}
        }
    }
}
