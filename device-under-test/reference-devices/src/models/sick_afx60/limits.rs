//! Speed calculation and the limits of speed, temperature and supply voltage: P1005, P1006 and P1007.
//! Manual, table 34, 3.6.15 and 3.6.16.
//!
//! Readings: a value equal to a limit is inside; the speed is looked at without its sign. The refresh time of the AFS60
//! is 2 ms, and 100 ms at most on the AFM60; up to 200 measurements make a mean. Defaults but for the unit are
//! invented.

use super::{Live, State};
use crate::models::sick::settings::elements;
use alloc::vec::Vec;
use core::time::Duration;
use encoder_profile::checks::Check;
use encoder_profile::encoder::Cell;
use encoder_profile::encoder::velocity::Sampling;
use encoder_profile::encoder_object::words;
use encoder_profile::profidrive::parameters::Parameter;
use wire::profidrive::ErrorNumber;

/// P1005 but for the unit, which is that of the user parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Speed {
    /// Whether the speed is calculated.
    pub is_active: bool,
    /// T1 in milliseconds.
    pub refresh_time: u16,
    /// T2: how many measurements make a mean.
    pub measurements: u16,
    highest: u16,
    lowest: u16,
}

impl Default for Speed {
    fn default() -> Speed {
        Speed { is_active: true, refresh_time: 2, measurements: 10, highest: 10_000, lowest: 0 }
    }
}

impl Speed {
    /// A connection begins, which brings times and numbers.
    pub fn begin(&mut self) {
        let Speed { refresh_time, measurements, .. } = Speed::default();
        (self.refresh_time, self.measurements) = (refresh_time, measurements);
    }

    /// When the speed is measured.
    pub fn sampling(&self) -> Sampling {
        Sampling { every: Duration::from_millis(self.refresh_time.into()), of: self.measurements.into() }
    }
}

/// P1006 and P1007, which can be saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// In degrees Celsius, lower and upper.
    pub temperature: [i16; 2],
    /// In millivolts, lower and upper.
    pub voltage: [u16; 2],
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { temperature: [-40, 100], voltage: [9000, 30_000] }
    }
}

/// What is in force and what is in memory.
#[derive(Clone, Debug)]
pub struct Stored {
    /// In force.
    pub speed: Speed,
    /// In force.
    pub limits: Limits,
    /// In memory.
    pub memory: Cell<Limits>,
}

impl Default for Stored {
    fn default() -> Stored {
        Stored { speed: Speed::default(), limits: Limits::default(), memory: Cell::new(Limits::default()) }
    }
}

/// What a speed is judged by.
#[derive(Clone, Copy, Debug)]
pub struct Speeds {
    /// Revolutions per minute, clockwise positive.
    pub rpm: i64,
    /// The velocity in the unit in force.
    pub shown: i64,
    /// P1005.4.
    pub highest: i64,
    /// P1005.5.
    pub lowest: i64,
}

/// P1005.
pub fn speed_parameter(live: &Live<'_, State>) -> Parameter {
    let Speed { is_active, refresh_time, measurements, highest, lowest } = live.model.limits.speed;
    let unit = u64::from(live.ram.user.speed_unit);
    let rest = [refresh_time, measurements, highest, lowest].map(u64::from);
    words([u64::from(is_active), unit].into_iter().chain(rest).collect()).writable()
}

/// Writes elements of P1005.
pub fn write_speed(live: &mut Live<'_, State>, subindex: u16, values: &[u64]) -> Result<(), ErrorNumber> {
    let rules = &live.rules.own;
    let mut speed = live.model.limits.speed;
    let mut new_unit = None;
    for (at, value) in elements(subindex, values) {
        let value = (live.rules.sick.settled)((1005, at), value, &live.hardware) as u16;
        let is_singleturn = live.hardware.revolutions == 1;
        let (range, refusal) = match at {
            0 => ([0, 1], ErrorNumber::VALUE_NOT_ALLOWED),
            1 => ([0, 4], ErrorNumber::VALUE_NOT_ALLOWED),
            2 if is_singleturn => ([2, 2], ErrorNumber::LIMIT),
            2 => ([1, 100], ErrorNumber::LIMIT),
            3 => ([1, 200], ErrorNumber::LIMIT),
            4 => ([1, 10_000], ErrorNumber::LIMIT),
            _ => ([0, 9000], ErrorNumber::LIMIT),
        };
        check(live, (1005, at), value.into(), range, refusal)?;
        match at {
            0 => speed.is_active = value != 0,
            1 => new_unit = Some((value as u8, (rules.unit)(value))),
            2 => speed.refresh_time = value,
            3 => speed.measurements = value,
            4 => speed.highest = value,
            _ => speed.lowest = value,
        }
    }
    if rules.exchanges_speed_limits && speed.lowest > speed.highest {
        (speed.lowest, speed.highest) = (speed.highest, speed.lowest);
    }
    if !live.rules.sick.keeps_settings {
        return Ok(());
    }
    live.model.limits.speed = speed;
    if let Some((number, unit)) = new_unit {
        live.ram.user.speed_unit = number;
        live.ram.velocity.set_unit(unit.unwrap_or(live.ram.velocity.unit()));
    }
    measure_speed(live);
    Ok(())
}

/// Brings the calculation of the speed in line with P1005.
pub fn measure_speed(live: &mut Live<'_, State>) {
    let speed = live.model.limits.speed;
    live.ram.velocity.sample(speed.sampling(), live.now, live.shaft);
    live.ram.velocity_is_off = live.rules.own.mode_acts && !speed.is_active;
}

/// P1006 or P1007.
pub fn limits_parameter(live: &Live<'_, State>, number: u16) -> Parameter {
    let Limits { temperature, voltage } = live.model.limits.limits;
    let values: Vec<u64> = match number {
        1006 => temperature.map(|degrees| u64::from(degrees as u16)).to_vec(),
        _ => voltage.map(u64::from).to_vec(),
    };
    words(values).writable()
}

/// Writes elements of P1006 or P1007.
pub fn write_limits(live: &mut Live<'_, State>, number: u16, subindex: u16, values: &[u64]) -> Result<(), ErrorNumber> {
    let clips = live.rules.own.clips_limits;
    let mut limits = live.model.limits.limits;
    for (at, value) in elements(subindex, values) {
        match (number, at) {
            (1006, _) => {
                let range = [[-40, 80], [-20, 120]][at.min(1)];
                let degrees = value as u16 as i16;
                let degrees = if clips { degrees.clamp(range[0] as i16, range[1] as i16) } else { degrees };
                check(live, (1006, at), degrees.into(), range, ErrorNumber::LIMIT)?;
                limits.temperature[at.min(1)] = degrees;
            }
            _ => {
                let range = [[9000, 24_000], [10_000, 30_000]][at.min(1)];
                let millivolts = i64::from(value as u16);
                let millivolts = if clips { millivolts.clamp(range[0], range[1]) } else { millivolts };
                check(live, (1007, at), millivolts, range, ErrorNumber::LIMIT)?;
                limits.voltage[at.min(1)] = millivolts as u16;
            }
        }
    }
    if !live.rules.sick.keeps_settings {
        return Ok(());
    }
    live.model.limits.limits = limits;
    if live.model.saves_each_change && live.rules.own.saves_by_itself {
        store_limits(live);
    }
    Ok(())
}

/// Begins to store P1006 and P1007.
pub fn store_limits(live: &mut Live<'_, State>) {
    let limits = &mut live.model.limits;
    limits.memory.write(live.now, limits.limits, live.facts.timing.save);
}

fn speeds(live: &Live<'_, State>) -> Speeds {
    let speed = &live.model.limits.speed;
    let settings = &live.ram.measuring.settings;
    Speeds {
        rpm: live.ram.velocity.rounded_rpm(),
        shown: live.ram.velocity.value(&settings.scaling, settings.direction),
        highest: speed.highest.into(),
        lowest: speed.lowest.into(),
    }
}

/// Whether the speed is above its limit.
pub fn is_too_fast(live: &Live<'_, State>) -> bool {
    too_fast(live, &speeds(live))
}

fn too_fast(live: &Live<'_, State>, speeds: &Speeds) -> bool {
    live.behaviour.checks.check(Check::TooFast(speeds.rpm), (live.rules.own.is_too_fast)(speeds))
}

/// Whether the speed is below its limit.
pub fn is_too_slow(live: &Live<'_, State>) -> bool {
    (live.rules.own.is_too_slow)(&speeds(live))
}

/// Whether the speed is above or below its limits.
pub fn speed_is_outside(live: &Live<'_, State>) -> bool {
    let speeds = speeds(live);
    too_fast(live, &speeds) || (live.rules.own.is_too_slow)(&speeds)
}

/// Whether the temperature is above or below its limits.
pub fn temperature_is_outside(live: &Live<'_, State>) -> bool {
    let limits = live.model.limits.limits.temperature.map(f64::from);
    (live.rules.own.temperature_is_outside)(live.model.around.celsius, limits)
}

/// Whether the supply is below its limit, or above it.
pub fn voltage_is_outside(live: &Live<'_, State>) -> [bool; 2] {
    let limits = live.model.limits.limits.voltage.map(u64::from);
    (live.rules.own.voltage_is_outside)(live.model.around.millivolts(), limits)
}

/// Whether speed, temperature, supply or LED current are beyond their limits.
pub fn is_beyond_limits(live: &Live<'_, State>) -> bool {
    speed_is_outside(live)
        || temperature_is_outside(live)
        || voltage_is_outside(live).contains(&true)
        || live.faults.has("led_current")
}

/// Whether a setting takes a value.
pub fn check(
    live: &Live<'_, State>,
    at: (u16, usize),
    value: i64,
    [lowest, highest]: [i64; 2],
    refusal: ErrorNumber,
) -> Result<(), ErrorNumber> {
    let is_right = (lowest..=highest).contains(&value);
    match (live.rules.sick.takes)(at, value, is_right) {
        true => Ok(()),
        false => Err(refusal),
    }
}
