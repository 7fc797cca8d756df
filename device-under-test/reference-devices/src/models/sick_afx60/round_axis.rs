//! The round axis: P1009. Manual, 3.2.2, 3.6.12 to 3.6.14 and table 34.
//!
//! Interpretation: written values are in force at once. The range of positions is CMR, which the total measuring range of the
//! start-up sets if scaling is on; the resolution per revolution is ignored. Laps of the encoder are counted for the
//! axis and retained without power, and restart with another gear. The range offset is the shift of the position by laps;
//! writing it shifts the position. The AFS60 has no round axis: mode 2 is refused.

use super::hooks::Afx60Check;
use super::{Afx60State, PoweredEncoder};
use crate::models::sick::axis::{self, LARGEST_FRACTION, LARGEST_RANGE, Laps, RANGE_OFFSETS};
use crate::models::sick::hooks;
use crate::models::sick::settings;
use encoder_profile::encoder::measuring;
use encoder_profile::encoder::{Gear, MeasuringSettings};
use encoder_profile::encoder_object::double_words;
use encoder_profile::profidrive::parameters::ParameterContent;
use encoder_profile::profidrive::user_parameters::UserParameterData;
use wire::profidrive::ErrorNumber;

/// Mode of P1009: the function is off.
pub const OFF: u32 = 1;
/// Mode of P1009: the function is on.
pub const ON: u32 = 2;

/// The inputs of P1009 and the retained data of the axis.
#[derive(Clone, Copy, Debug)]
pub struct RoundAxisState {
    /// Whether the function is on.
    pub is_on: bool,
    /// The mode as it was written.
    mode: u32,
    /// CNR_N, the nominator.
    pub nominator: u32,
    /// CNR_D, the divisor.
    pub divisor: u32,
    /// CMR, the range.
    pub range: u32,
    /// The laps, which are retained without power.
    laps: Laps,
    /// The written part of the range offset, to which the laps are added.
    pub base: u64,
}

impl Default for RoundAxisState {
    /// The factory settings.
    fn default() -> RoundAxisState {
        let range = LARGEST_RANGE as u32;
        RoundAxisState { is_on: false, mode: OFF, nominator: 2048, divisor: 1, range, laps: Laps::default(), base: 0 }
    }
}

impl RoundAxisState {
    /// Resets everything that is not stored to factory settings, at power-up and at the start of a connection.
    pub fn begin(&mut self) {
        let RoundAxisState { laps, base, .. } = *self;
        *self = RoundAxisState { laps, base, ..RoundAxisState::default() };
    }

    /// Switches the function on or off.
    pub fn set_mode(&mut self, is_on: bool) {
        (self.is_on, self.mode) = (is_on, if is_on { ON } else { OFF });
    }

    /// The configured gear, whether or not the function is on.
    fn gear(&self) -> Gear {
        Gear { nominator: self.nominator.into(), divisor: self.divisor.into(), range: self.range.into() }
    }
}

/// Returns whether the encoder has a round axis; only the AFM60 has one.
pub fn has_axis(live: &PoweredEncoder<'_, Afx60State>) -> bool {
    live.model.hooks.check(Afx60Check::HasRoundAxis, live.hardware.revolutions > 1)
}

/// The settings with the gear of the axis, if it is on.
fn geared(
    live: &PoweredEncoder<'_, Afx60State>,
    settings: MeasuringSettings,
    axis: &RoundAxisState,
) -> MeasuringSettings {
    axis::geared(settings, axis.is_on, axis.gear(), &live.ram.user, &live.hardware, &live.model.shared)
}

/// CMR of a start: the total range of the user parameters if scaling is in force.
fn range_of_start(live: &PoweredEncoder<'_, Afx60State>) -> Option<u64> {
    let user = &live.ram.user;
    user.scales(&live.deviations.checks).then_some(user.range)
}

/// Returns whether the range of a start is valid for the axis.
pub fn axis_is_right(live: &PoweredEncoder<'_, Afx60State>) -> bool {
    let is_right = range_of_start(live).is_none_or(|range| (1..=LARGEST_RANGE).contains(&range));
    let UserParameterData { range, units_per_revolution, .. } = live.ram.user;
    live.model.shared.check(hooks::SickCheck::RoundAxisRange { range, units_per_revolution }, is_right)
}

/// Returns the settings at a start, given those of the user parameters.
pub fn with_axis(live: &PoweredEncoder<'_, Afx60State>, settings: MeasuringSettings) -> MeasuringSettings {
    let mut axis = live.model.axis;
    if let (true, Some(range)) = (axis_is_right(live), range_of_start(live)) {
        axis.range = range.max(1) as u32;
    }
    geared(live, settings, &axis)
}

/// Applies the range of a start to the axis.
pub fn apply_start_range(live: &mut PoweredEncoder<'_, Afx60State>) {
    if let (true, Some(range)) = (live.model.axis.is_on && axis_is_right(live), range_of_start(live)) {
        live.model.axis.range = range.max(1) as u32;
    }
    count_for_axis(live);
}

/// Applies P1009 to the measuring task.
pub fn set_axis(live: &mut PoweredEncoder<'_, Afx60State>) {
    let user = live.ram.user.settings(&live.encoder());
    live.ram.measuring.settings = geared(live, user, &live.model.axis);
    count_for_axis(live);
}

/// Restarts the lap count if the laps were counted for another gear.
fn count_for_axis(live: &mut PoweredEncoder<'_, Afx60State>) {
    let place = live.hardware.sense(live.shaft.position(live.now));
    live.model.axis.laps.count_for(&mut live.ram.measuring, place);
}

/// Stores the laps.
pub fn store_laps(live: &mut PoweredEncoder<'_, Afx60State>) {
    live.model.axis.laps.store(&live.ram.measuring, live.hardware.sense(live.shaft.position(live.now)));
}

/// Restores the stored laps.
pub fn restore_laps(live: &mut PoweredEncoder<'_, Afx60State>) {
    let place = live.hardware.sense(live.shaft.position(live.now));
    live.model.axis.laps.restore(&mut live.ram.measuring, place, &live.model.shared);
}

/// By how many units the laps shift the position of the axis.
fn range_of_laps(live: &PoweredEncoder<'_, Afx60State>) -> u64 {
    axis::range_of_laps(&live.model.axis.gear(), &live.hardware, live.ram.measuring.laps)
}

/// Sets the range offset and shifts the position of the axis accordingly.
fn set_range_offset(live: &mut PoweredEncoder<'_, Afx60State>, value: u64) {
    let before = range_offset(live);
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

/// The range offset: the laps and the written part.
fn range_offset(live: &PoweredEncoder<'_, Afx60State>) -> u64 {
    measuring::shift(range_of_laps(live), live.model.axis.base, RANGE_OFFSETS)
}

/// Returns P1009: table 34.
pub fn axis_parameter(live: &PoweredEncoder<'_, Afx60State>) -> ParameterContent {
    let axis = &live.model.axis;
    let inputs @ [nominator, divisor, range] = [axis.nominator, axis.divisor, axis.range].map(u64::from);
    let settings = [axis.mode.into(), nominator, divisor, range, range_offset(live)];
    let in_use = [live.ram.measuring.offset].into_iter().chain(inputs).chain(axis::units_per_revolution(&axis.gear()));
    let parameter = double_words(settings.into_iter().chain(in_use).collect());
    ParameterContent { writable: 0..settings.len(), ..parameter }
}

/// Writes elements of P1009.
pub fn write_axis(live: &mut PoweredEncoder<'_, Afx60State>, subindex: u16, values: &[u64]) -> Result<(), ErrorNumber> {
    let (hardware, has_axis) = (live.hardware, has_axis(live));
    let limits = |at| match at {
        0 => (OFF.into()..=if has_axis { ON } else { OFF }.into(), ErrorNumber::VALUE_NOT_ALLOWED),
        1 | 2 => (1..=LARGEST_FRACTION as i64, ErrorNumber::LIMIT),
        3 => (1..=LARGEST_RANGE as i64, ErrorNumber::LIMIT),
        _ => (0..=RANGE_OFFSETS as i64 - 1, ErrorNumber::LIMIT),
    };
    let values = values.iter().map(|value| *value as i64);
    let elements = axis_parameter(live).values.into_iter().map(|element| element as i64).collect();
    let before = settings::SettingWrite { number: 1009, elements, hardware: &hardware };
    let written = before.written(subindex, values, limits, &live.model.shared)?;
    let element = |at: usize| written.get(at).map_or(0, |element| *element as u32);
    let offset_before = range_offset(live);
    let axis = &mut live.model.axis;
    (axis.is_on, axis.mode) = (element(0) == ON, element(0));
    (axis.nominator, axis.divisor, axis.range) = (element(1), element(2), element(3));
    set_axis(live);
    if u64::from(element(4)) != offset_before {
        set_range_offset(live, element(4).into());
    }
    Ok(())
}
