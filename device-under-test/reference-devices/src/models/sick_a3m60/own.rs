//! What is the own of this encoder: what it keeps beside the encoder object, and its hooks into it.

use super::clock::{Clock, Times, Wrong};
use super::knobs::Knobs;
use super::knobs::Seconds;
use super::parameters;
use super::parameters::{Speed, Test};
use super::presets;
use super::presets::Presets;
use super::samples::Samples;
use super::start::{Brought, Fields, OCTETS};
use super::station;
use super::station::Hands;
use super::status;
use super::status::Words;
use super::{CLOCK_DEVIATES, ENCODER_SIGNAL, FREQUENCY, NO_CLOCK, is_of_vendor, samples, start};
use crate::models::sick::axis::{self, Laps};
use crate::models::sick::log::{Log, Look, Recorder};
use ::station::{StandAction, Time};
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::Attached;
use device_stack::profinet::Seen;
use encoder_profile::encoder::velocity::{Sampling, Unit, Velocity};
use encoder_profile::encoder::{PresetMode, Settings};
use encoder_profile::encoder_object::{Live, Model};
use encoder_profile::facts::ErrorFact;
use encoder_profile::profidrive::parameters::Parameter;
use encoder_profile::profidrive::telegram::Image;
use wire::profidrive::ErrorNumber;

/// The slowest turn that counts as operation, in whole revolutions per minute: manual, table 24, above 6.
const MOTION: u64 = 7;
/// How the speed is measured that the encoder itself looks at; invented.
const METER: Sampling = Sampling { every: Duration::from_millis(20), of: 5 };

/// What is the own of this encoder.
#[derive(Clone, Debug)]
pub struct State {
    pub(super) hands: Hands,
    /// What the start in force has brought.
    pub(super) fields: Fields,
    /// What the last Set_Prm has brought.
    pub(super) brought: Brought,
    pub(super) clock: Clock,
    pub(super) samples: Samples,
    pub(super) has_noise: bool,
    pub(super) speed: Speed,
    pub(super) test: Test,
    pub(super) laps: Laps,
    pub(super) log: Log,
    recorder: Recorder,
    pub(super) meter: Option<Velocity>,
    powered_since: Time,
    connected_since: Time,
    /// Motion before the supply came.
    moved_before: Duration,
    /// What was wrong since the connection began, and since when it is so that something is.
    pub(super) seen: Words,
    pub(super) had_several: bool,
    faulty: Duration,
    last: Time,
    /// The telegram of the start before.
    pub(super) telegram_before: u16,
    telegram: u16,
    pub(super) presets: Presets,
    /// When P1007 was written.
    pub(super) disturbed_at: Option<Time>,
    /// What was written to constants, where that can be.
    pub(super) constants: Vec<(u16, usize, u64)>,
    begins_with_error: bool,
    /// The user octets of the last Set_Prm.
    pub(super) octets: [u8; OCTETS],
    /// The faults that were there when the supply came.
    pub(super) faults_at_power_up: Vec<&'static str>,
    /// What was wrong when the connection began.
    pub(super) at_start: Words,
    /// Where the shaft was when the inputs were frozen, and the way that was lost so, where that can be.
    frozen_at: Option<i64>,
    lost: i64,
}

impl State {
    /// As delivered, with this address.
    pub fn new(address: u8) -> State {
        State {
            hands: Hands::new(address),
            fields: Fields::DELIVERED,
            brought: Brought { fields: Fields::DELIVERED, isochronous: None },
            clock: Clock::default(),
            samples: Samples::default(),
            has_noise: false,
            speed: Speed::default(),
            test: Test::default(),
            laps: Laps::default(),
            log: Log::new(),
            recorder: Recorder::default(),
            meter: None,
            powered_since: Time::ZERO,
            connected_since: Time::ZERO,
            moved_before: Duration::ZERO,
            seen: Words::default(),
            had_several: false,
            faulty: Duration::ZERO,
            last: Time::ZERO,
            telegram_before: 0,
            telegram: 0,
            presets: Presets::default(),
            disturbed_at: None,
            constants: Vec::new(),
            begins_with_error: false,
            octets: start::DELIVERED,
            faults_at_power_up: Vec::new(),
            at_start: Words::default(),
            frozen_at: None,
            lost: 0,
        }
    }
}

/// The settings with the gear of the round axis, if it is in force.
pub fn with_axis(live: &Live<'_, State>, settings: Settings) -> Settings {
    let (fields, rules) = (&live.model.fields, &live.rules.sick);
    match fields.has_axis() && rules.axis_acts {
        true => axis::geared(settings, (rules.gear)(fields.gear(), &live.ram.user)),
        false => settings,
    }
}

/// A clock of the bus has come.
pub fn clock(live: &mut Live<'_, State>) {
    let rules = &live.rules.own;
    let beside = if live.model.has_noise { samples::scatter(live.now, rules) } else { 0 };
    live.model.clock.tick(live.now, live.shaft.place(live.now) + beside, rules);
}

fn follow_clock(live: &mut Live<'_, State>) {
    let shaft = live.shaft;
    live.model.clock.advance(live.now, |at| shaft.place(at), &live.rules.own);
}

fn log(live: &mut Live<'_, State>) {
    let meter = live.model.meter.get_or_insert_with(|| {
        Velocity::sampled(METER, Unit::Rpm, live.hardware, live.now, live.shaft, Attached::NONE)
    });
    meter.advance(live.now, live.shaft);
    let look = Look {
        now: live.now,
        rpm: meter.rounded_rpm(),
        sense: meter.steps().signum(),
        place: live.shaft.place(live.now),
        steps_per_revolution: live.hardware.steps_per_revolution,
        slowest: MOTION,
    };
    let news = live.model.recorder.look(&look, &live.rules.sick);
    live.model.log.take(&news);
}

/// The inputs are held from now on, or no longer: the encoder measures all the same.
pub fn freeze(live: &mut Live<'_, State>, is_frozen: bool) {
    if live.rules.own.measures_while_frozen {
        return;
    }
    let place = live.shaft.place(live.now);
    match is_frozen {
        true => live.model.frozen_at = live.model.frozen_at.or(Some(place)),
        false => live.model.lost += live.model.frozen_at.take().map_or(0, |frozen| place - frozen),
    }
}

/// Milliseconds since power-up.
pub fn powered(live: &Live<'_, State>) -> u64 {
    live.now.since(live.model.powered_since).as_millis() as u64
}

/// What a time stamp could be made of.
pub fn seconds(live: &Live<'_, State>) -> Seconds {
    let milliseconds = |time: Duration| time.as_millis() as u64;
    let State { log, powered_since, connected_since, moved_before, faulty, presets, .. } = &*live.model;
    let powered = live.now.since(*powered_since);
    Seconds {
        powered: milliseconds(powered),
        preset: milliseconds(live.now.since(presets.since)),
        healthy: milliseconds(powered.saturating_sub(*faulty)),
        connected: milliseconds(live.now.since(*connected_since)),
        moved: milliseconds(log.motion.saturating_sub(*moved_before)),
        operated: milliseconds(log.operating),
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

    fn is_caused(live: &Live<'_, State>, error: &ErrorFact) -> bool {
        let wrong = || live.model.clock.wrong(&live.rules.own);
        match error.code {
            Some(ENCODER_SIGNAL) => live.model.begins_with_error,
            Some(CLOCK_DEVIATES) => wrong().is_deviating,
            Some(NO_CLOCK) => wrong().is_missing,
            _ => false,
        }
    }

    fn warnings(live: &Live<'_, State>) -> u32 {
        if status::is_too_fast(live) { FREQUENCY } else { 0 }
    }

    fn settings(live: &Live<'_, State>, settings: Settings) -> Settings {
        let is_of_vendor = is_of_vendor(live.ram.telegram());
        (live.rules.own.settings)(with_axis(live, settings), is_of_vendor, &live.hardware)
    }

    fn takes_preset(live: &mut Live<'_, State>, mode: PresetMode, value: u64) -> bool {
        presets::begin_preset(live, mode, value)
    }

    fn place(live: &mut Live<'_, State>) -> i64 {
        follow_clock(live);
        let rules = &live.rules.own;
        let is_isochronous = live.model.clock.times().is_some();
        let count = (rules.samples)(live.model.fields.samples, is_isochronous);
        let (now, shaft, has_noise) = (live.now, live.shaft, live.model.has_noise);
        let sampled = live.model.samples.place(now, count.into(), |at| shaft.place(at), has_noise, rules);
        match live.model.clock.place() {
            Some(place) if rules.samples_at_clock && count == 1 => place,
            Some(_) if count == 1 => shaft.place((rules.looks_at)(now)),
            _ => live.model.frozen_at.unwrap_or(sampled) - live.model.lost,
        }
    }

    fn placed(live: &mut Live<'_, State>) {
        live.model.samples.restart();
        live.model.clock.put(live.shaft.place(live.now));
    }

    fn gives_sign_of_life(live: &Live<'_, State>) -> bool {
        let clock = &live.model.clock;
        let rules = &live.rules.own;
        let is_lost = clock.wrong(rules) != Wrong::default();
        (rules.gives_sign_of_life)(clock.times().is_some(), clock.is_synchronized(), is_lost)
    }

    fn watches_controller(live: &Live<'_, State>) -> bool {
        (live.rules.own.watches_master)(live.model.clock.times().is_some())
    }

    fn shown(live: &Live<'_, State>, image: Image) -> Image {
        let time_stamp = (live.rules.own.time_stamp)(&seconds(live));
        let known = status::known(live);
        let code = known.is_of_vendor.then(|| status::shown_code(live, &known)).flatten();
        let plain_position = code.map_or(image.plain_position, |code| code as u32);
        let image = Image { time_stamp, plain_position, ..image };
        let is_disturbed = live.rules.own.test_disturbs
            && live.model.disturbed_at.is_some_and(|at| live.now < at + Duration::from_secs(1));
        let image = match is_disturbed {
            true => Image { g1_xist1: 0, g1_xist2: 0, plain_position: 0, ..image },
            false => image,
        };
        (live.rules.own.image)(&known, image)
    }

    fn advance(live: &mut Live<'_, State>) {
        follow_clock(live);
        parameters::measure_speed(live);
        log(live);
        let place = live.hardware.sense(live.shaft.place(live.now));
        live.model.laps.keep(&live.ram.measuring, place);
        live.model.begins_with_error = false;
        let passed = live.now.since(core::mem::replace(&mut live.model.last, live.now));
        let words = status::words(live);
        if words != Words::default() {
            live.model.faulty += passed;
        }
        status::note_status(live, words);
        presets::carry_out_queue(live);
        presets::look_for_falling_edge(live);
    }

    fn started(live: &mut Live<'_, State>) {
        let rules = &live.rules.own;
        live.model.at_start = status::words(live);
        let before = Brought { fields: live.model.fields, isochronous: None };
        let Brought { fields, isochronous } = (rules.starts)(before, live.model.brought);
        let times = (rules.times)(isochronous.map(|times| Times {
            cycle: start::cycle(&times),
            window: Duration::from_nanos((u64::from(times.t_pll_w) * 1000 / 12).max(1000)),
            is_simulated: fields.simulates(),
        }));
        let model = &mut *live.model;
        (model.seen, model.begins_with_error) = (Words::default(), rules.begins_with_error);
        model.presets.word = 0;
        model.telegram_before = core::mem::replace(&mut model.telegram, live.ram.telegram().number);
        if rules.counts_starts {
            model.log.power_ups += 1;
        }
        live.model.fields = fields;
        live.model.clock.begin(live.now, times);
        live.model.connected_since = live.now;
    }

    fn parametrized(live: &mut Live<'_, State>) {
        if is_of_vendor(live.ram.telegram()) {
            let unit = (live.rules.own.vendor_unit)(live.ram.velocity.unit());
            live.ram.velocity.set_unit(unit);
        }
        parameters::measure_speed(live);
        let place = live.hardware.sense(live.shaft.place(live.now));
        live.model.laps.count_for(&mut live.ram.measuring, place);
    }

    fn act(live: &mut Live<'_, State>, action: &StandAction<'_>) -> Option<Time> {
        station::handle(live, action)
    }

    fn led(live: &Live<'_, State>, name: &str, seen: &Seen) -> Option<&'static str> {
        station::light(live, name, seen)
    }

    fn counter(live: &Live<'_, State>, name: &str) -> Option<u64> {
        (name == "termination").then(|| station::is_terminated(live).into())
    }

    fn power_up(live: &mut Live<'_, State>) {
        station::power(live, true);
        let now = live.now;
        let rules = &live.rules.sick;
        let model = &mut *live.model;
        model.log.power_up(rules);
        (live.rules.own.log_at_power_up)(&mut model.log);
        model.recorder.power_up(now);
        model.laps.change(rules.laps);
        (model.meter, model.powered_since, model.connected_since) = (None, now, now);
        model.moved_before = model.log.motion;
        (model.fields, model.test) = (Fields::DELIVERED, Test::default());
        model.speed.power_up(live.rules.own.keeps_setting);
        (model.had_several, model.faulty, model.last) = (false, Duration::ZERO, now);
        (model.telegram_before, model.telegram, model.disturbed_at) = (0, 0, None);
        model.octets = start::DELIVERED;
        model.constants.clear();
        model.presets.power_up(now);
        model.brought = Brought { fields: Fields::DELIVERED, isochronous: None };
        model.clock.begin(now, None);
        model.samples.restart();
        model.laps.recall(&mut live.ram.measuring, rules);
        status::note_faults(live);
    }

    fn power_down(live: &mut Live<'_, State>) {
        station::power(live, false);
        if let Some(offset) = live.model.presets.kept_offset.take() {
            live.store.offset.replace(offset);
        }
        if live.rules.own.tears_preset_value && live.store.preset_value.deadline().is_some() {
            let old = *live.store.preset_value.stored();
            live.store.preset_value.replace(live.ram.preset_value & 0xFFFF_0000 | old & 0xFFFF);
        }
    }

    fn is_alive(&self) -> bool {
        self.hands.is_alive()
    }
}
