//! The service log: P1002 since delivery, P1003 since its last reset, and P1004, which counts how often each bit of S_STAT_A
//! was set. Manual, tables 34 and 44.
//!
//! Interpretation: P1003 is reset by writing 0 to any of its elements; no other value can be written. A turn counts when it
//! begins and with each full revolution. Counters stop at 255. All data survive power-off and factory reset.

use super::hooks::{Afx60Check, Afx60Event};
use super::{Afx60State, PoweredEncoder, RetainedVendorData, controls, sensor_status};
use crate::models::sick::hooks::SickDeviations;
use crate::models::sick::log::{Log, LogReading, ShaftRecorder, ShaftSample};
use core::time::Duration;
use device_stack::Attached;
use encoder_profile::encoder::velocity::{Sampling, Velocity, VelocityUnit};
use encoder_profile::encoder_object::{double_words, words};
use encoder_profile::profidrive::parameters::ParameterContent;
use station::Time;
use wire::profidrive::ErrorNumber;

/// The lowest speed that counts as motion, in revolutions per minute.
const MOTION: u64 = 6;
/// Current of the sensor LED in microamperes, normal and critical; invented.
const LED_CURRENT: [u32; 2] = [10_000, 25_000];
/// Time to save diagnostic data; invented.
const SAVE: Duration = Duration::from_millis(50);
const HIGHEST_COUNT: u16 = 255;
/// Sampling of the acceleration, long enough that a single step is no acceleration; invented.
const METER: Sampling = Sampling { interval: Duration::from_millis(20), count: 5 };

/// One of the two logs.
#[derive(Clone, Copy, Debug, Default)]
pub struct ServiceLogBook {
    /// The counters that the SICK encoders share.
    pub log: Log,
    /// The extremes since delivery or since the reset; `None` before the first sample.
    pub extremes: Option<Extremes>,
}

/// The highest and lowest measured values.
#[derive(Clone, Copy, Debug)]
pub struct Extremes {
    led: [u32; 2],
    volts: u32,
    celsius: [i32; 2],
}

/// The service log.
#[derive(Clone, Debug)]
pub struct ServiceLog {
    /// The log since delivery, P1002.
    pub absolute: ServiceLogBook,
    /// The log since its last reset, P1003.
    pub relative: ServiceLogBook,
    /// The counters of status bits, P1004.
    pub counters: [u16; 16],
    /// S_STAT_A at the last sample.
    status: u16,
    recorder: ShaftRecorder,
    /// Measures the acceleration.
    meter: Option<Velocity>,
}

impl Default for ServiceLog {
    fn default() -> ServiceLog {
        let new = ServiceLogBook { log: Log::new(), extremes: None };
        let recorder = ShaftRecorder::default();
        ServiceLog { absolute: new, relative: new, counters: [0; 16], status: 0, recorder, meter: None }
    }
}

impl ServiceLog {
    /// Counts a power-up.
    pub fn power_up(&mut self, now: Time, hooks: &SickDeviations) {
        self.both(|book| book.log.power_up(hooks));
        self.recorder.power_up(now);
        (self.status, self.meter) = (0, None);
    }

    fn both(&mut self, change: impl Fn(&mut ServiceLogBook)) {
        change(&mut self.absolute);
        change(&mut self.relative);
    }

    /// Returns the seconds with power since delivery.
    pub fn operating_seconds(&self) -> u64 {
        self.absolute.log.operating.as_secs()
    }
}

/// Updates the log.
pub fn log(live: &mut PoweredEncoder<'_, Afx60State>) {
    log_motion(live);
    let meter = &mut live.model.service.meter;
    let meter = meter.get_or_insert_with(|| {
        Velocity::sampled(METER, VelocityUnit::Rpm, live.hardware, live.now, live.shaft, Attached::NONE)
    });
    meter.advance(live.now, live.shaft);
    let critical = usize::from(live.faults.has("led_current"));
    let measured = controls::measured(live);
    let (led, volts) = (LED_CURRENT[critical], (measured.volts + 0.5).max(0.0) as u32);
    let degrees = measured.degrees() as i32;
    live.model.service.both(|book| {
        let before = book.extremes.unwrap_or(Extremes { led: [led; 2], volts, celsius: [degrees; 2] });
        book.extremes = Some(Extremes {
            led: [before.led[0].max(led), before.led[1].min(led)],
            volts: before.volts.max(volts),
            celsius: [before.celsius[0].max(degrees), before.celsius[1].min(degrees)],
        });
    });
    count(live);
    live.model.hooks.0.notify(|hooks| hooks.logged(live.now, &live.model.service));
}

fn log_motion(live: &mut PoweredEncoder<'_, Afx60State>) {
    let look = ShaftSample {
        now: live.now,
        rpm: live.ram.velocity.rounded_rpm(),
        sense: live.ram.velocity.steps().signum(),
        place: live.shaft.position(live.now),
        steps_per_revolution: live.hardware.steps_per_revolution,
        slowest: MOTION,
    };
    let Afx60State { service, shared, .. } = &mut *live.model;
    let news = service.recorder.sample(&look, shared);
    service.both(|book| book.log.add(&news, shared));
}

fn count(live: &mut PoweredEncoder<'_, Afx60State>) {
    let status = sensor_status::status_a(live);
    let Afx60State { service, hooks, .. } = &mut *live.model;
    let came = status & !core::mem::replace(&mut service.status, status);
    for (bit, counter) in service.counters.iter_mut().enumerate().skip(1) {
        if came >> bit & 1 != 0 && hooks.check(Afx60Check::Counts(*counter), *counter < HIGHEST_COUNT) {
            *counter += 1;
        }
    }
    if came != 0 {
        live.model.status.diagnosis_saved_at = Some(live.now + SAVE);
    }
}

/// Returns P1002 or P1003.
pub fn log_parameter(live: &PoweredEncoder<'_, Afx60State>, number: u16) -> ParameterContent {
    let service = &live.model.service;
    let book = if number == 1002 { service.absolute } else { service.relative };
    let ServiceLogBook { log, extremes } = book;
    let extremes = extremes.unwrap_or(Extremes { led: [0; 2], volts: 0, celsius: [0; 2] });
    let right = [
        log.power_ups,
        log.operating.as_secs() as u32,
        log.highest_speed,
        log.forward,
        log.reverse,
        log.direction_changes,
        log.motion.as_secs() as u32,
        service.meter.as_ref().map_or(0, Velocity::acceleration) as u32,
        extremes.led[0],
        extremes.led[1],
        extremes.volts,
        extremes.celsius[0] as u32,
        extremes.celsius[1] as u32,
    ]
    .map(u64::from);
    let reading = LogReading { number, rpm: live.ram.velocity.rounded_rpm(), operating: log.operating };
    let elements = live.model.shared.seams.apply(right, |hooks, right| hooks.log(&reading, right));
    let parameter = double_words(elements.to_vec());
    if number == 1003 { parameter.writable() } else { parameter }
}

/// Resets P1003.
pub fn reset_log(live: &mut PoweredEncoder<'_, Afx60State>, values: &[u64]) -> Result<(), ErrorNumber> {
    if values.iter().any(|value| *value != 0) {
        return Err(ErrorNumber::RESET_ONLY);
    }
    let before = RetainedVendorData::of(live);
    live.model.service.relative = ServiceLogBook::default();
    before.keep(live, Afx60Event::LogReset);
    log(live);
    Ok(())
}

/// Returns P1004.
pub fn counters_parameter(live: &PoweredEncoder<'_, Afx60State>) -> ParameterContent {
    words(live.model.service.counters.map(u64::from).to_vec())
}
