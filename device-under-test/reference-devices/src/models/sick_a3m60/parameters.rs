//! The parameters of the station, the profile and the vendor. Manual, tables 23 to 25.
//!
//! Interpretation: P971 accepts any value and reads 0. P1007 has no effect. P1008 is volatile and in force at once. P1009
//! shows the data of the start, in force or not; its range offset is the shift of the position by laps.

use super::controls::NOWHERE;
use super::hooks::{self, A3m60Check};
use super::status;
use super::{A3m60State, PoweredEncoder};
use crate::models::sick::axis::{self, RANGE_OFFSETS};
use crate::models::sick::log::LogReading;
use crate::models::sick::settings::{SettingWrite, elements};
use core::time::Duration;
use encoder_profile::encoder::{Sampling, velocity};
use encoder_profile::encoder_object::{double_words, word, words};
use encoder_profile::profidrive::life_sign::tolerated;
use encoder_profile::profidrive::parameters::ParameterContent;
use wire::profidrive::ErrorNumber;

/// Unit of the operating time in P65001 in seconds: 0.1 h.
const OPERATING_TIME_UNIT: u64 = 360;
/// Bit of the alarm channel in the operating status, followed by the bit for V4.1 of the profile.
const ALARM_CHANNEL: u64 = 1 << 4;
const NOT_COMPATIBLE: u64 = 1 << 5;

/// P1008: the speed calculation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpeedCalculation {
    /// Time between measurements in milliseconds, number of measurements per mean, and number of clock cycles per mean.
    pub values: [u16; 3],
}

impl Default for SpeedCalculation {
    fn default() -> SpeedCalculation {
        SpeedCalculation { values: [5, 200, 10] }
    }
}

impl SpeedCalculation {
    /// Returns the sampling of the speed, free-running or with a clock of this cycle.
    pub fn sampling(&self, cycle: Option<Duration>) -> Sampling {
        let [every, of, clocks] = self.values;
        match cycle {
            Some(cycle) => Sampling { interval: cycle, count: clocks.max(1).into() },
            None => Sampling { interval: Duration::from_millis(every.max(1).into()), count: of.max(1).into() },
        }
    }
}

/// Returns a parameter that the encoder object does not have, or that differs here.
pub fn own_parameter(live: &PoweredEncoder<'_, A3m60State>, number: u16) -> Option<ParameterContent> {
    Some(match number {
        918 => word(live.model.controls.address().unwrap_or(NOWHERE).into()),
        925 => word(tolerated(&live.ram.user).into()),
        // Profile 3Dh, version 41.
        965 => word(0x3D29),
        971 => word(0).writable(),
        1000 => word(status::words(live).a.into()),
        1001 => word(status::words(live).b.into()),
        1002 => log_parameter(live),
        1007 => double_words(live.model.test.map(u64::from).to_vec()).writable(),
        1008 => words([0].into_iter().chain(live.model.speed.values).map(u64::from).collect()).writable(),
        1009 => axis_parameter(live),
        65001 => double_words(status(live).to_vec()),
        _ => return None,
    })
}

/// The operating status, P65001.
fn status(live: &PoweredEncoder<'_, A3m60State>) -> [u64; 12] {
    let mut status = live.operating_status();
    let words = status::words(live);
    let [low, high] = live.model.fields.switches.map(u64::from);
    status[1] = high << 8 | low;
    if status[1] & NOT_COMPATIBLE != 0 {
        status[1] |= ALARM_CHANNEL;
    }
    let bit = |n: u32, set: bool| u64::from(set) << n;
    let faults = bit(0, words.a & super::status::POSITION != 0) | bit(5, words.a & super::status::MEMORY != 0);
    status[2] = faults;
    status[4] = bit(0, words.a & super::status::OVERSPEED != 0);
    status[7] = live.model.log.operating.as_secs() / OPERATING_TIME_UNIT;
    status
}

fn log_parameter(live: &PoweredEncoder<'_, A3m60State>) -> ParameterContent {
    let log = &live.model.log;
    let mut right = [0; 13];
    let entries = [log.power_ups, log.motion.as_secs() as u32, log.highest_speed, log.forward, log.reverse];
    right.iter_mut().zip(entries).for_each(|(entry, value)| *entry = value.into());
    let reading = LogReading { number: 1002, rpm: rpm(live), operating: log.operating };
    let elements = live.model.shared.seams.apply(right, |hooks, right| hooks.log(&reading, right));
    double_words(elements[..entries.len()].to_vec())
}

fn axis_parameter(live: &PoweredEncoder<'_, A3m60State>) -> ParameterContent {
    let fields = &live.model.fields;
    let gear = fields.gear();
    let inputs = [gear.nominator, gear.divisor, gear.range];
    let offset = axis::range_of_laps(&gear, &live.hardware, live.ram.measuring.laps) % RANGE_OFFSETS;
    let mode = u64::from(fields.has_axis());
    let all = [mode].into_iter().chain(inputs).chain([offset, live.ram.measuring.offset]).chain(inputs);
    let mut elements = [0; 11];
    let all = all.chain(axis::units_per_revolution(&gear));
    elements.iter_mut().zip(all).for_each(|(element, value)| *element = value);
    double_words(elements.to_vec())
}

/// Writes a parameter that the encoder object does not have, or that does more here.
pub fn write_own(
    live: &mut PoweredEncoder<'_, A3m60State>,
    number: u16,
    subindex: u16,
    values: &[u64],
) -> Option<Result<(), ErrorNumber>> {
    let hooks::VendorWrite { number, subindex, values } = hooks::written(live, number, subindex, values);
    let values = values.as_slice();
    match number {
        971 => Some(Ok(())),
        1007 => {
            let test = &mut live.model.test;
            elements(subindex, values).into_iter().for_each(|(at, value)| test[at.min(4)] = value as u32);
            Some(Ok(()))
        }
        1008 => Some(write_speed(live, subindex, values)),
        65000 => {
            let value = values.first().copied().unwrap_or(0) as u32;
            live.set_preset_value(value);
            live.store.preset_value.write(live.now, value, live.facts.timing.save);
            Some(Ok(()))
        }
        _ => None,
    }
}

fn write_speed(live: &mut PoweredEncoder<'_, A3m60State>, subindex: u16, values: &[u64]) -> Result<(), ErrorNumber> {
    let hardware = live.hardware;
    let [every, of, clocks] = live.model.speed.values.map(i64::from);
    let limits = |at| match at {
        0 => (0..=0, ErrorNumber::LIMIT),
        1 => (1..=100, ErrorNumber::LIMIT),
        _ => (1..=200, ErrorNumber::LIMIT),
    };
    let before = SettingWrite { number: 1008, elements: [0, every, of, clocks].to_vec(), hardware: &hardware };
    let values = values.iter().map(|value| *value as i64);
    let written = before.written(subindex, values, limits, &live.model.shared)?;
    let settings = live.model.speed.values.iter_mut().zip(written.into_iter().skip(1));
    settings.for_each(|(setting, value)| *setting = value as u16);
    measure_speed(live);
    Ok(())
}

/// Applies P1008, the clock and the user bytes to the speed calculation.
pub fn measure_speed(live: &mut PoweredEncoder<'_, A3m60State>) {
    let cycle = live.model.clock.times().map(|times| times.cycle);
    let by_clock = live.model.hooks.check(A3m60Check::SpeedByClock, cycle.is_some());
    let sampling = live.model.speed.sampling(cycle.filter(|_| by_clock));
    live.ram.velocity.sample(sampling, live.now, live.shaft);
    let is_calculated = live.model.hooks.check(A3m60Check::SpeedCalculated, live.model.fields.measures_speed());
    live.ram.velocity_is_off = !is_calculated;
}

/// Returns the speed in revolutions per minute, measured fast enough for the monitoring by the encoder itself.
pub fn rpm(live: &PoweredEncoder<'_, A3m60State>) -> i64 {
    live.model.meter.as_ref().map_or(0, velocity::Velocity::rounded_rpm)
}

/// Elements of P1007.
pub type TestParameter = [u32; 5];
