//! The controls under the screw cover (preset push-button and address switches), supply and temperature. Manual, 3.7, 4.2 and 5.5.
//!
//! Interpretation: a short press (below 3 s, invented) makes an absolute preset unless the switches request the reset; a
//! longer press has no effect except for the reset.

use super::hooks::{Afx60Check, Afx60Deviations, MeasuredSupply};
use super::{Afx60State, PoweredEncoder, limits};
use crate::models::sick::hooks;
use core::time::Duration;
use encoder_profile::encoder::PresetMode;
use encoder_profile::encoder_object::PresetSource;
use station::{StandAction, Time};

/// Time for which the button has to be held for the reset: manual, 5.5.
const RESET_TAKES: Duration = Duration::from_secs(5);
/// A press is short below this time; invented.
const SHORT_PRESS: Duration = Duration::from_secs(3);
/// Below this voltage the encoder is down; invented.
const LOWEST_SUPPLY: f64 = 7.0;
/// Above this temperature in degrees Celsius the encoder has an error, whatever the limits of the warning; invented.
pub const HIGHEST_TEMPERATURE: f64 = 120.0;

/// The inputs of the encoder that the stand controls.
#[derive(Clone, Debug)]
pub struct StandInputs {
    /// The supply voltage in volts.
    pub volts: f64,
    /// The temperature in degrees Celsius.
    pub celsius: f64,
    /// Whether an error occurred during start-up.
    pub has_start_up_error: bool,
    has_power: bool,
    /// Whether the supply has returned from below its limit: then the encoder restarts. Manual, table 53.
    pub comes_back: bool,
    switches: [u32; 3],
    pressed_since: Option<Time>,
    /// Whether the button has been held for long enough and this has been processed.
    was_held: bool,
    /// Whether the next power-up resets the encoder to factory settings.
    pub reset_is_due: bool,
}

impl Default for StandInputs {
    fn default() -> StandInputs {
        StandInputs {
            volts: 24.0,
            celsius: 25.0,
            has_start_up_error: false,
            has_power: true,
            comes_back: false,
            switches: [0; 3],
            pressed_since: None,
            was_held: false,
            reset_is_due: false,
        }
    }
}

impl StandInputs {
    /// Returns whether the supply voltage is high enough and the encoder does not restart.
    pub fn is_alive(&self, hooks: &Afx60Deviations) -> bool {
        let check = Afx60Check::Works { is_reset_due: self.has_power && self.reset_is_due };
        hooks.check(check, self.volts >= LOWEST_SUPPLY && !self.comes_back)
    }

    /// Returns since when the button is held, if this counts for the reset.
    fn held_since(&self) -> Option<Time> {
        self.pressed_since.filter(|_| self.has_power && !self.reset_is_due)
    }

    /// Returns when the button will have been held for long enough, until this has been processed.
    pub fn deadline(&self) -> Option<Time> {
        self.held_since().filter(|_| !self.was_held).map(|since| since + RESET_TAKES)
    }

    /// Processes power-up or power-off.
    pub fn power(&mut self, has_power: bool) {
        (self.has_power, self.pressed_since, self.comes_back, self.was_held) = (has_power, None, false, false);
    }
}

/// Returns the supply voltage and the temperature that the encoder measures.
pub fn measured(live: &PoweredEncoder<'_, Afx60State>) -> MeasuredSupply {
    let Afx60State { inputs: StandInputs { volts, celsius, .. }, hooks, .. } = &*live.model;
    let right = MeasuredSupply { volts: *volts, celsius: *celsius };
    hooks.0.apply(right, |hooks, right| hooks.measured(live.now, right))
}

/// Carries out actions of the stand on supply, temperature, switches and button.
pub fn handle(live: &mut PoweredEncoder<'_, Afx60State>, action: &StandAction<'_>) -> Option<Time> {
    let [was_low, _] = limits::voltage_is_outside(live);
    let around = &mut live.model.inputs;
    match *action {
        StandAction::SupplyVoltage(volts) => {
            around.volts = volts;
            let [is_low, _] = limits::voltage_is_outside(live);
            let Afx60State { inputs: around, hooks, .. } = &mut *live.model;
            around.comes_back = hooks.check(Afx60Check::Restarts, around.has_power && was_low && !is_low);
        }
        StandAction::Fault("start_up", present) => around.has_start_up_error = present,
        StandAction::Temperature(celsius) => around.celsius = celsius,
        StandAction::Switch(name, place) => {
            let at = ["hundreds", "tens", "ones"].iter().position(|known| *known == name)?;
            around.switches[at] = place;
        }
        StandAction::Button("preset", true) => (around.pressed_since, around.was_held) = (Some(live.now), false),
        StandAction::Button("preset", false) => {
            if let Some(since) = around.pressed_since.take().filter(|_| around.has_power) {
                release(live, live.now.since(since));
            }
        }
        _ => return None,
    }
    Some(live.now)
}

/// Whether the address switches are set to 888: manual, 5.5.
fn requests_reset(model: &Afx60State) -> bool {
    let switches = model.inputs.switches;
    model.hooks.check(Afx60Check::ResetSwitches(switches), switches == [8; 3])
}

/// Prepares the reset once the button has been held for long enough.
pub fn update_button(live: &mut PoweredEncoder<'_, Afx60State>) {
    let Some(since) = live.model.inputs.held_since() else { return };
    let held = live.now.since(since);
    let is_long = held >= RESET_TAKES;
    live.model.inputs.was_held |= is_long;
    if live.model.hooks.check(Afx60Check::ResetIsHeld(held), is_long) && requests_reset(live.model) {
        live.model.inputs.reset_is_due = true;
    }
}

/// Processes the release of the button: a short press makes an absolute preset, unless the switches request the reset.
fn release(live: &mut PoweredEncoder<'_, Afx60State>, held: Duration) {
    let is_preset = held < SHORT_PRESS && !requests_reset(live.model);
    let shared = &live.model.shared;
    if shared.check(hooks::SickCheck::ButtonPresets(held), is_preset) {
        let value = shared.seams.apply(live.ram.preset_value, |hooks, value| hooks.button(value));
        live.preset(PresetSource::Value(PresetMode::Absolute, value));
    }
}
