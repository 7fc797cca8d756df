//! The round axis: P1009. Manual, 3.2.2, 3.6.12 to 3.6.14 and table 34.
//!
//! Readings: what is written is in force at once. The range of positions is CMR, which the total measuring range of the
//! start-up sets where scaling is on; the resolution per revolution is ignored. Laps of the encoder are counted for the
//! axis and kept without power, and begin anew with another gear; the range offset tells what they make of the position
//! and shifts it where it is written. The AFS60 has no round axis: mode 2 is refused.

use super::knobs::Rules;
use super::limits::elements;
use super::{Live, State};
use crate::encoder::measuring;
use crate::encoder::{Gear, Hardware, Scaling, Settings};
use crate::encoder_object::double_words;
use crate::profidrive::parameters::Parameter;
use wire::profidrive::ErrorNumber;

/// Mode of P1009 without the function, and with it.
pub const OFF: u32 = 1;
/// The function is on.
pub const ON: u32 = 2;
/// Range offsets go on from 0 again here: above the largest one, 80000000h.
const RANGE_OFFSETS: u64 = 0x8000_0001;
/// The largest total resolution.
const LARGEST_RANGE: u64 = 1 << 30;

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
    /// The gear that laps are counted for, which survives without power, and the place where the encoder stood last.
    counted: Option<Gear>,
    laps: i64,
    place: Option<u64>,
    /// What was written to the range offset, beside what laps make of it.
    base: u64,
}

impl Axis {
    /// At delivery.
    pub fn new() -> Axis {
        let range = LARGEST_RANGE as u32;
        Axis {
            is_on: false,
            mode: OFF,
            nominator: 2048,
            divisor: 1,
            range,
            counted: None,
            laps: 0,
            place: None,
            base: 0,
        }
    }

    /// The supply has come: what is not stored is as at delivery.
    pub fn power_up(&mut self, rules: &Rules) {
        self.laps = (rules.laps)(self.laps);
        self.base = (rules.laps)(self.base as i64) as u64;
        self.begin(rules);
    }

    /// A connection begins, which brings its settings.
    pub fn begin(&mut self, rules: &Rules) {
        let Axis { counted, laps, place, nominator, divisor, base, .. } = *self;
        *self = Axis { counted, laps, place, base, ..Axis::new() };
        if rules.axis_survives {
            (self.nominator, self.divisor) = (nominator, divisor);
        }
    }

    /// Switches the function on or off.
    pub fn set_mode(&mut self, is_on: bool) {
        (self.is_on, self.mode) = (is_on, if is_on { ON } else { OFF });
    }

    /// The gear that is set, if the function is on.
    pub fn gear(&self) -> Option<Gear> {
        let gear = Gear { nominator: self.nominator.into(), divisor: self.divisor.into(), range: self.range.into() };
        self.is_on.then_some(gear)
    }
}

/// Units per revolution of the encoder, in whole units and thousandths.
fn units_per_revolution(axis: &Axis) -> [u64; 2] {
    let above = u64::from(axis.range) * u64::from(axis.divisor);
    let below = u64::from(axis.nominator).max(1);
    [above / below, above % below * 1000 / below]
}

impl Live<'_, State> {
    /// Whether there is a round axis.
    pub fn has_axis(&self) -> bool {
        let Hardware { revolutions, .. } = self.hardware;
        revolutions > 1
    }

    /// Whether the round axis can be switched on.
    pub fn can_have_axis(&self) -> bool {
        self.has_axis() || self.behaviour.afx60.breaks_without_axis
    }

    /// The settings with the gear of the axis, if it is on.
    fn geared(&self, settings: Settings, axis: &Axis) -> Settings {
        let rules = &self.behaviour.afx60;
        let Some(gear) = axis.gear().filter(|_| rules.axis_acts) else { return settings };
        // One position is all that is left of a round axis on an encoder that has none.
        let broken = rules.breaks_without_axis && !self.has_axis();
        let gear = match broken {
            true => Gear { nominator: 1, divisor: 1, range: 1 },
            false => (rules.gear)(gear, &self.ram.user),
        };
        let units = gear.range * gear.divisor / gear.nominator.max(1);
        let scaling = Scaling { units_per_revolution: units.max(1), range: gear.range };
        Settings { scaling, gear: Some(gear), ..settings }
    }

    /// CMR of a start: the total range of the user parameters, where it is in force.
    fn range_of_start(&self) -> Option<u64> {
        let user = &self.ram.user;
        (self.behaviour.user_parameters.scales)(user).then_some(user.range)
    }

    /// Whether the axis has a range that it can have, at a start.
    pub fn axis_is_right(&self) -> bool {
        let right = self.range_of_start().is_none_or(|range| (1..=LARGEST_RANGE).contains(&range));
        (self.behaviour.afx60.judges_axis)(right, &self.ram.user)
    }

    /// The settings at a start, from those of the user parameters.
    pub fn with_axis(&self, settings: Settings) -> Settings {
        let mut axis = self.model.axis;
        if let (true, Some(range)) = (self.axis_is_right(), self.range_of_start()) {
            axis.range = range.max(1) as u32;
        }
        self.geared(settings, &axis)
    }

    /// Notes what has been brought into force at a start.
    pub fn note_axis(&mut self) {
        if let (true, Some(range)) = (self.model.axis.is_on && self.axis_is_right(), self.range_of_start()) {
            self.model.axis.range = range.max(1) as u32;
        }
        self.count_for_axis();
    }

    /// Brings P1009 into force.
    pub fn set_axis(&mut self) {
        let user = self.ram.user.settings(&self.hardware, &self.behaviour.user_parameters);
        self.ram.measuring.settings = self.geared(user, &self.model.axis);
        self.count_for_axis();
    }

    /// Counts laps from now on, if they were counted for another gear.
    fn count_for_axis(&mut self) {
        let Some(gear) = self.ram.measuring.settings.gear else { return };
        if self.model.axis.counted.replace(gear) != Some(gear) {
            self.ram.measuring.laps = 0;
        }
        self.keep_laps();
    }

    /// Keeps the laps.
    pub fn keep_laps(&mut self) {
        self.model.axis.laps = self.ram.measuring.laps;
        self.model.axis.place = Some(self.hardware.sense(self.shaft.place(self.now)));
    }

    /// Goes on with the laps that were kept; a way without power is taken for the shorter one.
    pub fn recall_laps(&mut self) {
        let Axis { laps, place, .. } = self.model.axis;
        if let Some(place) = place {
            self.ram.measuring.recall(place, laps);
        }
    }

    /// By how much the laps shift the position of the axis.
    fn range_of_laps(&self) -> u64 {
        let Axis { nominator, divisor, range, .. } = self.model.axis;
        let gear = Gear { nominator: nominator.into(), divisor: divisor.into(), range: range.into() };
        let laps = i128::from(self.ram.measuring.laps) * i128::from(self.hardware.range());
        gear.position(&self.hardware, laps)
    }

    /// Gives the range offset another value: the position of the axis goes with it.
    fn set_range_offset(&mut self, value: u64) {
        let before = measuring::shift(self.range_of_laps(), self.model.axis.base, RANGE_OFFSETS);
        let more = measuring::shift(value, RANGE_OFFSETS - before % RANGE_OFFSETS, RANGE_OFFSETS);
        self.model.axis.base = measuring::shift(self.model.axis.base, more, RANGE_OFFSETS);
        let range = self.ram.measuring.range();
        if self.ram.measuring.settings.gear.is_some() {
            let way = (i128::from(value) - i128::from(before)).rem_euclid(i128::from(range.max(1))) as u64;
            let offset = measuring::shift(self.ram.measuring.offset, way, range);
            self.ram.measuring.offset = offset;
            self.store.offset.replace(offset);
        }
    }

    /// P1009.
    pub fn axis_parameter(&self) -> Parameter {
        let axis = &self.model.axis;
        let inputs = [axis.nominator, axis.divisor, axis.range].map(u64::from);
        let [nominator, divisor, range] = inputs;
        let [units, fraction] = units_per_revolution(axis);
        let shift = measuring::shift(self.range_of_laps(), axis.base, RANGE_OFFSETS);
        let all =
            [axis.mode.into(), nominator, divisor, range, shift, self.ram.measuring.offset, nominator, divisor, range];
        let mut parameter = double_words(all.into_iter().chain([units, fraction]).collect());
        self.model.outputs.iter().for_each(|(at, value)| parameter.values[*at] = *value);
        Parameter { writable: if self.behaviour.afx60.outputs_are_writable { 0..11 } else { 0..5 }, ..parameter }
    }

    /// Writes elements of P1009.
    pub fn write_axis(&mut self, subindex: u16, values: &[u64]) -> Result<(), ErrorNumber> {
        let rules = &self.behaviour.afx60;
        let mut axis = self.model.axis;
        let mut range_offset = None;
        for (at, value) in elements(subindex, values) {
            let value = (rules.settled)((1009, at), value, &self.hardware);
            let number = i64::try_from(value).unwrap_or(i64::MAX);
            match at {
                0 => {
                    let highest = if self.can_have_axis() { ON } else { OFF };
                    self.check((1009, 0), number, [OFF.into(), highest.into()], ErrorNumber::VALUE_NOT_ALLOWED)?;
                    axis.is_on = value == u64::from(ON);
                    axis.mode = value as u32;
                }
                1 | 2 => {
                    self.check((1009, at), number, [1, 0x1_0000], ErrorNumber::LIMIT)?;
                    *(if at == 1 { &mut axis.nominator } else { &mut axis.divisor }) = value as u32;
                }
                3 => {
                    self.check((1009, 3), number, [1, LARGEST_RANGE as i64], ErrorNumber::LIMIT)?;
                    axis.range = value as u32;
                }
                4 => {
                    self.check((1009, 4), number, [0, 0x8000_0000], ErrorNumber::LIMIT)?;
                    range_offset = Some(value);
                }
                // Only where it can be written against the manual.
                _ => self.model.outputs.push((at, value)),
            }
        }
        if rules.keeps_settings {
            self.model.axis = axis;
            self.set_axis();
            if let Some(value) = range_offset {
                self.set_range_offset(value);
            }
        }
        Ok(())
    }
}
