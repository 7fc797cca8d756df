//! Speed calculation and the limits of speed, temperature and supply voltage: P1005, P1006 and P1007.
//! Manual, table 34, 3.6.15 and 3.6.16.
//!
//! Interpretation: a value equal to a limit is inside; the speed is compared without its sign. The refresh time is 2 ms on
//! the AFS60 and at most 100 ms on the AFM60; a mean has up to 200 measurements. Defaults except for the unit are invented.

use super::hooks::Afx60Check;
use super::{Afx60State, PoweredEncoder, controls};
use crate::models::sick::settings::{self, SettingWrite};
use core::time::Duration;
use encoder_profile::checks;
use encoder_profile::encoder::NvmCell;
use encoder_profile::encoder::velocity::Sampling;
use encoder_profile::encoder_object::words;
use encoder_profile::profidrive::parameters::ParameterContent;
use wire::profidrive::ErrorNumber;

/// P1005 without the unit, which is that of the user parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpeedSettings {
    /// Whether the speed is calculated.
    pub is_active: bool,
    /// T1, the refresh time in milliseconds.
    pub refresh_time: u16,
    /// T2, the number of measurements per mean.
    pub measurements: u16,
    highest: u16,
    lowest: u16,
}

impl Default for SpeedSettings {
    fn default() -> SpeedSettings {
        SpeedSettings { is_active: true, refresh_time: 2, measurements: 10, highest: 10_000, lowest: 0 }
    }
}

impl SpeedSettings {
    /// Resets times and numbers at the start of a connection.
    pub fn begin(&mut self) {
        let SpeedSettings { refresh_time, measurements, .. } = SpeedSettings::default();
        (self.refresh_time, self.measurements) = (refresh_time, measurements);
    }

    /// Returns the sampling of the speed.
    pub fn sampling(&self) -> Sampling {
        Sampling { interval: Duration::from_millis(self.refresh_time.into()), count: self.measurements.into() }
    }
}

/// P1006 and P1007, which can be saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Lower and upper temperature limit in degrees Celsius.
    pub temperature: [i16; 2],
    /// Lower and upper supply limit in millivolts.
    pub voltage: [u16; 2],
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { temperature: [-40, 100], voltage: [9000, 30_000] }
    }
}

/// The settings in force and in memory.
#[derive(Clone, Debug)]
pub struct LimitSettings {
    /// The speed calculation in force.
    pub speed: SpeedSettings,
    /// The limits in force.
    pub limits: Limits,
    /// The limits in memory.
    pub memory: NvmCell<Limits>,
}

impl Default for LimitSettings {
    fn default() -> LimitSettings {
        LimitSettings {
            speed: SpeedSettings::default(),
            limits: Limits::default(),
            memory: NvmCell::new(Limits::default()),
        }
    }
}

/// The speed and its limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MonitoredSpeed {
    /// Revolutions per minute, clockwise positive.
    pub rpm: i64,
    /// The velocity in the unit in force.
    pub shown: i64,
    /// The highest speed, P1005.4.
    pub highest: i64,
    /// The lowest speed, P1005.5.
    pub lowest: i64,
}

/// The elements of P1005 in order.
fn speed_settings(live: &PoweredEncoder<'_, Afx60State>) -> [i64; 6] {
    let SpeedSettings { is_active, refresh_time, measurements, highest, lowest } = live.model.limits.speed;
    let unit = live.ram.user.speed_unit;
    [is_active.into(), unit.into(), refresh_time.into(), measurements.into(), highest.into(), lowest.into()]
}

/// Returns P1005.
pub fn speed_parameter(live: &PoweredEncoder<'_, Afx60State>) -> ParameterContent {
    words(speed_settings(live).map(|element| element as u64).to_vec()).writable()
}

/// Writes elements of P1005.
pub fn write_speed(
    live: &mut PoweredEncoder<'_, Afx60State>,
    subindex: u16,
    values: &[u64],
) -> Result<(), ErrorNumber> {
    let hardware = live.hardware;
    let limits = |at| match at {
        0 => (0..=1, ErrorNumber::VALUE_NOT_ALLOWED),
        1 => (0..=4, ErrorNumber::VALUE_NOT_ALLOWED),
        2 if hardware.revolutions == 1 => (2..=2, ErrorNumber::LIMIT),
        2 => (1..=100, ErrorNumber::LIMIT),
        3 => (1..=200, ErrorNumber::LIMIT),
        4 => (1..=10_000, ErrorNumber::LIMIT),
        _ => (0..=9000, ErrorNumber::LIMIT),
    };
    let values = values.iter().map(|value| i64::from(*value as u16));
    let before = SettingWrite { number: 1005, elements: speed_settings(live).to_vec(), hardware: &hardware };
    let written = before.written(subindex, values, limits, &live.model.shared)?;
    let element = |at: usize| written.get(at).map_or(0, |element| *element as u16);
    live.model.limits.speed = SpeedSettings {
        is_active: element(0) != 0,
        refresh_time: element(2),
        measurements: element(3),
        highest: element(4),
        lowest: element(5),
    };
    live.ram.user.speed_unit = element(1) as u8;
    if let Some(unit) = settings::unit(element(1)) {
        live.ram.velocity.set_unit(unit);
    }
    measure_speed(live);
    Ok(())
}

/// Applies P1005 to the speed calculation.
pub fn measure_speed(live: &mut PoweredEncoder<'_, Afx60State>) {
    let speed = live.model.limits.speed;
    live.ram.velocity.sample(speed.sampling(), live.now, live.shaft);
    live.ram.velocity_is_off = !live.model.hooks.check(Afx60Check::VelocityIsCalculated, speed.is_active);
}

/// Returns P1006 or P1007.
pub fn limits_parameter(live: &PoweredEncoder<'_, Afx60State>, number: u16) -> ParameterContent {
    let Limits { temperature, voltage } = live.model.limits.limits;
    let values = if number == 1006 { temperature.map(|degrees| degrees as u16) } else { voltage };
    words(values.map(u64::from).to_vec()).writable()
}

/// Writes elements of P1006 or P1007.
pub fn write_limits(
    live: &mut PoweredEncoder<'_, Afx60State>,
    number: u16,
    subindex: u16,
    values: &[u64],
) -> Result<(), ErrorNumber> {
    let (hardware, Limits { temperature, voltage }) = (live.hardware, live.model.limits.limits);
    let elements = if number == 1006 { temperature.map(i64::from) } else { voltage.map(i64::from) };
    let limits = |at| match (number, at) {
        (1006, 0) => (-40..=80, ErrorNumber::LIMIT),
        (1006, _) => (-20..=120, ErrorNumber::LIMIT),
        (_, 0) => (9000..=24_000, ErrorNumber::LIMIT),
        _ => (10_000..=30_000, ErrorNumber::LIMIT),
    };
    let number_of =
        |value: &u64| if number == 1006 { i64::from(*value as u16 as i16) } else { i64::from(*value as u16) };
    let before = SettingWrite { number, elements: elements.to_vec(), hardware: &hardware };
    let written = before.written(subindex, values.iter().map(number_of), limits, &live.model.shared)?;
    if let [lower, upper] = written[..] {
        match number {
            1006 => live.model.limits.limits.temperature = [lower as i16, upper as i16],
            _ => live.model.limits.limits.voltage = [lower as u16, upper as u16],
        }
    }
    if live.model.hooks.check(Afx60Check::Stores(number), live.model.saves_each_change) {
        store_limits(live);
    }
    Ok(())
}

/// Returns how long a save takes.
pub fn save_takes(live: &PoweredEncoder<'_, Afx60State>) -> Duration {
    live.model.hooks.0.apply(live.facts.timing.save, |hooks, right| hooks.save_takes(right))
}

/// Starts storing P1006 and P1007.
pub fn store_limits(live: &mut PoweredEncoder<'_, Afx60State>) {
    let takes = save_takes(live);
    let limits = &mut live.model.limits;
    limits.memory.write(live.now, limits.limits, takes);
}

fn speeds(live: &PoweredEncoder<'_, Afx60State>) -> MonitoredSpeed {
    let speed = &live.model.limits.speed;
    let settings = &live.ram.measuring.settings;
    MonitoredSpeed {
        rpm: live.ram.velocity.rounded_rpm(),
        shown: live.ram.velocity.value(&settings.scaling, settings.direction),
        highest: speed.highest.into(),
        lowest: speed.lowest.into(),
    }
}

/// Returns whether the speed is above its limit.
pub fn is_too_fast(live: &PoweredEncoder<'_, Afx60State>) -> bool {
    too_fast(live, speeds(live))
}

fn too_fast(live: &PoweredEncoder<'_, Afx60State>, speeds: MonitoredSpeed) -> bool {
    let is_above = live.model.hooks.check(Afx60Check::TooFast(speeds), speeds.rpm.abs() > speeds.highest);
    live.deviations.checks.check(checks::EncoderCheck::TooFast(speeds.rpm), is_above)
}

/// Returns whether the speed is above or below its limits.
pub fn speed_is_outside(live: &PoweredEncoder<'_, Afx60State>) -> bool {
    let speeds = speeds(live);
    let is_below = live.model.hooks.check(Afx60Check::TooSlow(speeds), speeds.rpm.abs() < speeds.lowest);
    too_fast(live, speeds) || is_below
}

/// Returns whether the temperature is above or below its limits.
pub fn temperature_is_outside(live: &PoweredEncoder<'_, Afx60State>) -> bool {
    let limits @ [lower, upper] = live.model.limits.limits.temperature.map(f64::from);
    let celsius = controls::measured(live).celsius;
    let is_outside = celsius < lower || celsius > upper;
    live.model.hooks.check(Afx60Check::TemperatureIsOutside(celsius, limits), is_outside)
}

/// Returns whether the supply is below its lower limit, and whether it is above its upper limit.
pub fn voltage_is_outside(live: &PoweredEncoder<'_, Afx60State>) -> [bool; 2] {
    let [lower, upper] = live.model.limits.limits.voltage.map(u64::from);
    let (hooks, millivolts) = (&live.model.hooks, controls::measured(live).millivolts());
    [
        hooks.check(Afx60Check::Undervoltage(millivolts, lower), millivolts < lower),
        hooks.check(Afx60Check::Overvoltage(millivolts, upper), millivolts > upper),
    ]
}

/// Returns whether undervoltage and overvoltage are errors now.
pub fn supply_is_wrong(live: &PoweredEncoder<'_, Afx60State>) -> [bool; 2] {
    let millivolts = controls::measured(live).millivolts();
    let check = Afx60Check::SupplyIsWrong(millivolts);
    voltage_is_outside(live).map(|is_outside| live.model.hooks.check(check, is_outside))
}

/// Returns whether speed, temperature, supply or LED current are beyond their limits.
pub fn is_beyond_limits(live: &PoweredEncoder<'_, Afx60State>) -> bool {
    speed_is_outside(live)
        || temperature_is_outside(live)
        || voltage_is_outside(live).contains(&true)
        || live.faults.has("led_current")
}
