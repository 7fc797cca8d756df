//! The round axis: P1009. Manual, 3.2.2, 3.6.12 to 3.6.14 and table 34.
//!
//! Readings: what is written is in force at once. The range of positions is CMR, which the total measuring range of the
//! start-up sets where scaling is on; the resolution per revolution is ignored. Laps of the encoder are counted for the
//! axis and kept without power, and begin anew with another gear; the range offset tells what they make of the position
//! and shifts it where it is written. The AFS60 has no round axis: mode 2 is refused.

use super::limits;
use super::{Live, State};
use crate::models::sick::axis::{self, LARGEST_FRACTION, LARGEST_RANGE, Laps, RANGE_OFFSETS};
use crate::models::sick::knobs::Rules;
use crate::models::sick::settings::elements;
use encoder_profile::encoder::measuring;
use encoder_profile::encoder::{Gear, Hardware, Settings};
use encoder_profile::encoder_object::double_words;
use encoder_profile::profidrive::parameters::Parameter;
use wire::profidrive::ErrorNumber;

/// Mode of P1009 without the function, and with it.
pub const OFF: u32 = 1;
/// The function is on.
pub const ON: u32 = 2;

/// Inputs of P1009, and what is kept of the axis.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Whether the function is on.
    pub is_on: bool,
    /// Its mode as it was written.
    mode: u32,
    /// CNR_N.
    pub nominator: u32,
    /// CNR_D.
    pub divisor: u32,
    /// CMR.
    pub range: u32,
    /// The laps, which survive without power.
    laps: Laps,
    /// What was written to the range offset, beside what laps make of it.
    base: u64,
}

impl Axis {
    /// At delivery.
    pub fn new() -> Axis {
        let range = LARGEST_RANGE as u32;
        Axis { is_on: false, mode: OFF, nominator: 2048, divisor: 1, range, laps: Laps::default(), base: 0 }
    }

    /// The supply has come: what is not stored is as at delivery.
    pub fn power_up(&mut self, rules: &Rules) {
        self.laps.change(rules.laps);
        self.base = (rules.laps)(self.base as i64) as u64;
        self.begin(rules);
    }

    /// A connection begins, which brings its settings.
    pub fn begin(&mut self, rules: &Rules) {
        let Axis { laps, nominator, divisor, base, .. } = *self;
        *self = Axis { laps, base, ..Axis::new() };
        if rules.axis_survives {
            (self.nominator, self.divisor) = (nominator, divisor);
        }
    }

    /// Switches the function on or off.
    pub fn set_mode(&mut self, is_on: bool) {
        (self.is_on, self.mode) = (is_on, if is_on { ON } else { OFF });
    }

    /// The gear that is set, whether or not the function is on.
    fn gear(&self) -> Gear {
        Gear { nominator: self.nominator.into(), divisor: self.divisor.into(), range: self.range.into() }
    }
}

/// Whether there is a round axis.
pub fn has_axis(live: &Live<'_, State>) -> bool {
    let Hardware { revolutions, .. } = live.hardware;
    revolutions > 1
}

/// Whether the round axis can be switched on.
pub fn can_have_axis(live: &Live<'_, State>) -> bool {
    has_axis(live) || live.rules.own.breaks_without_axis
}

/// The settings with the gear of the axis, if it is on.
fn geared(live: &Live<'_, State>, settings: Settings, axis: &Axis) -> Settings {
    let rules = &live.rules.sick;
    if !axis.is_on || !rules.axis_acts {
        return settings;
    }
    // One position is all that is left of a round axis on an encoder that has none.
    let broken = live.rules.own.breaks_without_axis && !has_axis(live);
    let gear = match broken {
        true => Gear { nominator: 1, divisor: 1, range: 1 },
        false => (rules.gear)(axis.gear(), &live.ram.user),
    };
    axis::geared(settings, gear)
}

/// CMR of a start: the total range of the user parameters, where it is in force.
fn range_of_start(live: &Live<'_, State>) -> Option<u64> {
    let user = &live.ram.user;
    user.scales(&live.behaviour.checks).then_some(user.range)
}

/// Whether the axis has a range that it can have, at a start.
pub fn axis_is_right(live: &Live<'_, State>) -> bool {
    let right = range_of_start(live).is_none_or(|range| (1..=LARGEST_RANGE).contains(&range));
    (live.rules.sick.judges_axis)(right, &live.ram.user)
}

/// The settings at a start, from those of the user parameters.
pub fn with_axis(live: &Live<'_, State>, settings: Settings) -> Settings {
    let mut axis = live.model.axis;
    if let (true, Some(range)) = (axis_is_right(live), range_of_start(live)) {
        axis.range = range.max(1) as u32;
    }
    geared(live, settings, &axis)
}

/// Notes what has been brought into force at a start.
pub fn note_axis(live: &mut Live<'_, State>) {
    if let (true, Some(range)) = (live.model.axis.is_on && axis_is_right(live), range_of_start(live)) {
        live.model.axis.range = range.max(1) as u32;
    }
    count_for_axis(live);
}

/// Brings P1009 into force.
pub fn set_axis(live: &mut Live<'_, State>) {
    let user = live.ram.user.settings(&live.encoder());
    live.ram.measuring.settings = geared(live, user, &live.model.axis);
    count_for_axis(live);
}

/// Counts laps from now on, if they were counted for another gear.
fn count_for_axis(live: &mut Live<'_, State>) {
    let place = live.hardware.sense(live.shaft.place(live.now));
    live.model.axis.laps.count_for(&mut live.ram.measuring, place);
}

/// Keeps the laps.
pub fn keep_laps(live: &mut Live<'_, State>) {
    live.model.axis.laps.keep(&live.ram.measuring, live.hardware.sense(live.shaft.place(live.now)));
}

/// Goes on with the laps that were kept.
pub fn recall_laps(live: &mut Live<'_, State>) {
    live.model.axis.laps.recall(&mut live.ram.measuring, &live.rules.sick);
}

/// By how much the laps shift the position of the axis.
fn range_of_laps(live: &Live<'_, State>) -> u64 {
    axis::range_of_laps(&live.model.axis.gear(), &live.hardware, live.ram.measuring.laps)
}

/// Gives the range offset another value: the position of the axis goes with it.
fn set_range_offset(live: &mut Live<'_, State>, value: u64) {
    let before = measuring::shift(range_of_laps(live), live.model.axis.base, RANGE_OFFSETS);
    let more = measuring::shift(value, RANGE_OFFSETS - before % RANGE_OFFSETS, RANGE_OFFSETS);
    live.model.axis.base = measuring::shift(live.model.axis.base, more, RANGE_OFFSETS);
    let range = live.ram.measuring.range();
    if live.ram.measuring.settings.gear.is_some() {
        let way = (i128::from(value) - i128::from(before)).rem_euclid(i128::from(range.max(1))) as u64;
        let offset = measuring::shift(live.ram.measuring.offset, way, range);
        live.ram.measuring.offset = offset;
        live.store.offset.replace(offset);
    }
}

/// P1009.
pub fn axis_parameter(live: &Live<'_, State>) -> Parameter {
    let axis = &live.model.axis;
    let inputs = [axis.nominator, axis.divisor, axis.range].map(u64::from);
    let [nominator, divisor, range] = inputs;
    let [units, fraction] = axis::units_per_revolution(&axis.gear());
    let shift = measuring::shift(range_of_laps(live), axis.base, RANGE_OFFSETS);
    let all =
        [axis.mode.into(), nominator, divisor, range, shift, live.ram.measuring.offset, nominator, divisor, range];
    let mut parameter = double_words(all.into_iter().chain([units, fraction]).collect());
    live.model.outputs.iter().for_each(|(at, value)| parameter.values[*at] = *value);
    Parameter { writable: if live.rules.sick.outputs_are_writable { 0..11 } else { 0..5 }, ..parameter }
}

/// Writes elements of P1009.
pub fn write_axis(live: &mut Live<'_, State>, subindex: u16, values: &[u64]) -> Result<(), ErrorNumber> {
    let rules = &live.rules.sick;
    let mut axis = live.model.axis;
    let mut range_offset = None;
    for (at, value) in elements(subindex, values) {
        let value = (rules.settled)((1009, at), value, &live.hardware);
        let number = i64::try_from(value).unwrap_or(i64::MAX);
        match at {
            0 => {
                let highest = if can_have_axis(live) { ON } else { OFF };
                limits::check(live, (1009, 0), number, [OFF.into(), highest.into()], ErrorNumber::VALUE_NOT_ALLOWED)?;
                axis.is_on = value == u64::from(ON);
                axis.mode = value as u32;
            }
            1 | 2 => {
                limits::check(live, (1009, at), number, [1, LARGEST_FRACTION as i64], ErrorNumber::LIMIT)?;
                *(if at == 1 { &mut axis.nominator } else { &mut axis.divisor }) = value as u32;
            }
            3 => {
                limits::check(live, (1009, 3), number, [1, LARGEST_RANGE as i64], ErrorNumber::LIMIT)?;
                axis.range = value as u32;
            }
            4 => {
                limits::check(live, (1009, 4), number, [0, 0x8000_0000], ErrorNumber::LIMIT)?;
                range_offset = Some(value);
            }
            // Only where it can be written against the manual.
            _ => live.model.outputs.push((at, value)),
        }
    }
    if rules.keeps_settings {
        live.model.axis = axis;
        set_axis(live);
        if let Some(value) = range_offset {
            set_range_offset(live, value);
        }
    }
    Ok(())
}
