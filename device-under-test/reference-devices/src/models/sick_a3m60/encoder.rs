//! The state of the A3M60 in addition to the encoder object, and the model for the encoder object.

use super::clock::{BusClock, IsochronousTimes};
use super::controls::{self, Controls};
use super::hooks::{self, A3m60Check, A3m60Deviations, A3m60Event};
use super::parameters::{self, SpeedCalculation, TestParameter};
use super::samples::{self, Samples};
use super::set_prm::{self, SetPrmContents, UserByteFields};
use super::status;
use super::{CLOCK_DEVIATES, FREQUENCY, NO_CLOCK, is_of_vendor, leds};
use crate::models::sick;
use crate::models::sick::axis::{self, Laps};
use crate::models::sick::log::{Log, ShaftRecorder, ShaftSample};
use core::time::Duration;
use device_stack::Attached;
use device_stack::profinet::StackStatus;
use encoder_profile::encoder::velocity::{Sampling, Velocity, VelocityUnit};
use encoder_profile::encoder::{MeasuringSettings, Shaft};
use encoder_profile::encoder_object::{EncoderModel, PoweredEncoder};
use encoder_profile::facts::ErrorFact;
use encoder_profile::profidrive::parameters::ParameterContent;
use encoder_profile::profidrive::telegram::SignalImage;
use station::{StandAction, Time};
use wire::profidrive::ErrorNumber;

/// The lowest speed that counts as operation, in whole revolutions per minute: manual, table 24, above 6.
const MOTION: u64 = 7;
/// Sampling of the speed that the encoder itself monitors; invented.
const METER: Sampling = Sampling { interval: Duration::from_millis(20), count: 5 };

/// The state of the A3M60 in addition to the encoder object, volatile and stored.
#[derive(Clone, Debug)]
pub struct A3m60State {
    /// Switches, button and power supply.
    pub controls: Controls,
    /// The user bytes in force.
    pub fields: UserByteFields,
    /// The contents of the last Set_Prm.
    pub(super) set_prm: SetPrmContents,
    /// The clock of isochronous operation.
    pub clock: BusClock,
    /// The last samples of the position.
    pub samples: Samples,
    /// Whether the sensor has noise.
    pub(super) has_noise: bool,
    /// P1008, the speed calculation.
    pub speed: SpeedCalculation,
    /// P1007, which has no effect.
    pub(super) test: TestParameter,
    pub(super) laps: Laps,
    /// The service log.
    pub log: Log,
    recorder: ShaftRecorder,
    /// Measures the speed that the encoder itself monitors.
    pub(super) meter: Option<Velocity>,
    powered_since: Time,
    /// The deviations at the parts that the SICK encoders share.
    pub(super) shared: sick::hooks::SickDeviations,
    /// The deviations at the A3M60.
    pub hooks: A3m60Deviations,
}

impl A3m60State {
    /// Creates the factory state with this address.
    pub fn new(address: u8, shared: sick::hooks::SickDeviations, hooks: A3m60Deviations) -> A3m60State {
        A3m60State {
            controls: Controls::new(address),
            fields: UserByteFields::DELIVERED,
            set_prm: SetPrmContents::DELIVERED,
            clock: BusClock::default(),
            samples: Samples::default(),
            has_noise: false,
            speed: SpeedCalculation::default(),
            test: TestParameter::default(),
            laps: Laps::default(),
            log: Log::new(),
            recorder: ShaftRecorder::default(),
            meter: None,
            powered_since: Time::ZERO,
            shared,
            hooks,
        }
    }
}

/// The reading of a sensor with or without noise at a time, in steps over all revolutions.
fn reading(shaft: &Shaft, has_noise: bool, at: Time) -> i64 {
    shaft.position(at) + if has_noise { samples::noise(at) } else { 0 }
}

/// Returns the settings with the gear of the round axis, if it is in force.
pub fn with_axis(live: &PoweredEncoder<'_, A3m60State>, settings: MeasuringSettings) -> MeasuringSettings {
    let A3m60State { fields, shared, .. } = &*live.model;
    axis::geared(settings, fields.has_axis(), fields.gear(), &live.ram.user, &live.hardware, shared)
}

/// Processes a clock of the bus.
pub fn clock(live: &mut PoweredEncoder<'_, A3m60State>) {
    let hooks = live.model.hooks.clone();
    let place = reading(live.shaft, live.model.has_noise, live.now);
    live.model.clock.tick(live.now, place, &hooks);
}

fn advance_clock(live: &mut PoweredEncoder<'_, A3m60State>) {
    let (shaft, hooks) = (live.shaft, live.model.hooks.clone());
    live.model.clock.advance(live.now, |at| shaft.position(at), &hooks);
}

fn log(live: &mut PoweredEncoder<'_, A3m60State>) {
    let meter = live.model.meter.get_or_insert_with(|| {
        Velocity::sampled(METER, VelocityUnit::Rpm, live.hardware, live.now, live.shaft, Attached::NONE)
    });
    meter.advance(live.now, live.shaft);
    let look = ShaftSample {
        now: live.now,
        rpm: meter.rounded_rpm(),
        sense: meter.steps().signum(),
        place: live.shaft.position(live.now),
        steps_per_revolution: live.hardware.steps_per_revolution,
        slowest: MOTION,
    };
    let A3m60State { recorder, log, shared, .. } = &mut *live.model;
    let news = recorder.sample(&look, shared);
    log.add(&news, shared);
}

/// Returns the time since power-up.
pub fn powered(live: &PoweredEncoder<'_, A3m60State>) -> Duration {
    live.now.since(live.model.powered_since)
}

impl EncoderModel for A3m60State {
    fn parameter(live: &PoweredEncoder<'_, A3m60State>, number: u16) -> Option<ParameterContent> {
        parameters::own_parameter(live, number)
    }

    fn write(
        live: &mut PoweredEncoder<'_, A3m60State>,
        number: u16,
        subindex: u16,
        values: &[u64],
    ) -> Option<Result<(), ErrorNumber>> {
        parameters::write_own(live, number, subindex, values)
    }

    fn is_caused(live: &PoweredEncoder<'_, A3m60State>, error: &ErrorFact) -> bool {
        let bus = || status::words(live).b;
        match error.code {
            Some(CLOCK_DEVIATES) => bus() & status::CLOCK_DEVIATING != 0,
            Some(NO_CLOCK) => bus() & status::CLOCK_MISSING != 0,
            _ => false,
        }
    }

    fn warnings(live: &PoweredEncoder<'_, A3m60State>) -> u32 {
        if status::is_too_fast(live) { FREQUENCY } else { 0 }
    }

    fn settings(live: &PoweredEncoder<'_, A3m60State>, settings: MeasuringSettings) -> MeasuringSettings {
        with_axis(live, settings)
    }

    fn shaft_position(live: &mut PoweredEncoder<'_, A3m60State>) -> i64 {
        advance_clock(live);
        let (shaft, has_noise) = (live.shaft, live.model.has_noise);
        live.model.samples.take(live.now, |at| reading(shaft, has_noise, at));
        let live = &*live;
        let A3m60State { clock, samples, fields, hooks, .. } = &*live.model;
        let place = match clock.place() {
            Some(place) => place,
            None if clock.times().is_some() => samples.mean(1),
            None => samples.mean(fields.samples.into()),
        };
        hooks.0.apply(place, |hooks, place| hooks.place(live, place))
    }

    fn shaft_moved(live: &mut PoweredEncoder<'_, A3m60State>) {
        live.model.samples.restart();
        live.model.clock.put(live.shaft.position(live.now));
    }

    fn sends_sign_of_life(live: &PoweredEncoder<'_, A3m60State>) -> bool {
        let clock = &live.model.clock;
        let is_isochronous = clock.times().is_some();
        let sign = A3m60Check::SignOfLife { is_isochronous, wrong: clock.wrong() };
        live.model.hooks.check(sign, is_isochronous && clock.is_synchronized())
    }

    fn monitors_controller(live: &PoweredEncoder<'_, A3m60State>) -> bool {
        live.model.clock.times().is_some()
    }

    fn frame_signals(live: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
        let code = if is_of_vendor(live.ram.telegram()) { status::shown_code(live) } else { None };
        let plain_position = code.map_or(image.plain_position, |code| code as u32);
        let image = SignalImage { time_stamp: powered(live).as_secs() as u16, plain_position, ..image };
        live.model.hooks.0.apply(image, |hooks, image| hooks.image(live, image))
    }

    fn advance(live: &mut PoweredEncoder<'_, A3m60State>) {
        advance_clock(live);
        parameters::measure_speed(live);
        log(live);
        let place = live.hardware.sense(live.shaft.position(live.now));
        live.model.laps.store(&live.ram.measuring, place);
        hooks::report(live, A3m60Event::Advance);
    }

    fn started(live: &mut PoweredEncoder<'_, A3m60State>) {
        let SetPrmContents { fields, isochronous } = live.model.set_prm;
        let times = isochronous.map(|times| IsochronousTimes {
            cycle: set_prm::cycle(&times),
            window: Duration::from_nanos((u64::from(times.t_pll_w) * 1000 / 12).max(1000)),
            is_simulated: fields.simulates(),
        });
        let times = live.model.hooks.0.apply(times, |hooks, times| hooks.times(times));
        live.model.fields = fields;
        live.model.clock.begin(live.now, times);
        hooks::report(live, A3m60Event::Start);
    }

    fn parametrized(live: &mut PoweredEncoder<'_, A3m60State>) {
        if is_of_vendor(live.ram.telegram()) {
            live.ram.velocity.set_unit(VelocityUnit::Rpm);
        }
        parameters::measure_speed(live);
        let place = live.hardware.sense(live.shaft.position(live.now));
        live.model.laps.count_for(&mut live.ram.measuring, place);
    }

    fn act(live: &mut PoweredEncoder<'_, A3m60State>, action: &StandAction<'_>) -> Option<Time> {
        controls::handle(live, action)
    }

    fn led(live: &PoweredEncoder<'_, A3m60State>, name: &str, status: &StackStatus) -> Option<&'static str> {
        leds::led(live, name, status)
    }

    fn counter(live: &PoweredEncoder<'_, A3m60State>, name: &str) -> Option<u64> {
        (name == "termination").then(|| live.model.controls.is_terminated(&live.model.hooks).into())
    }

    fn power_up(live: &mut PoweredEncoder<'_, A3m60State>) {
        let (now, place) = (live.now, live.hardware.sense(live.shaft.position(live.now)));
        let model = &mut *live.model;
        model.controls.power(true, &model.hooks);
        model.log.power_up(&model.shared);
        model.recorder.power_up(now);
        (model.meter, model.powered_since) = (None, now);
        (model.fields, model.set_prm) = (UserByteFields::DELIVERED, SetPrmContents::DELIVERED);
        (model.test, model.speed) = (TestParameter::default(), SpeedCalculation::default());
        model.clock.begin(now, None);
        model.samples.restart();
        model.laps.restore(&mut live.ram.measuring, place, &model.shared);
        hooks::report(live, A3m60Event::PowerUp);
    }

    fn power_down(live: &mut PoweredEncoder<'_, A3m60State>) {
        let model = &mut *live.model;
        model.controls.power(false, &model.hooks);
        hooks::report(live, A3m60Event::PowerDown);
    }

    fn is_alive(&self) -> bool {
        self.controls.is_alive()
    }
}
