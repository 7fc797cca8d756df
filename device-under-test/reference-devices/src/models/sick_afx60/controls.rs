//! What is under the screw cover: preset push-button and address switches; and supply and temperature. Manual, 3.7, 4.2 and 5.5.
//!
//! Readings: a short press (below 3 s, invented) is an absolute preset unless the switches ask for the reset; any
//! longer one does nothing but the reset.

use super::hooks::{Check, Hooks};
use super::{PoweredEncoder, State, limits};
use crate::models::sick::hooks;
use core::time::Duration;
use encoder_profile::encoder::PresetMode;
use encoder_profile::encoder_object::PresetSource;
use station::{StandAction, Time};

/// For how long the button is held for the reset: manual, 5.5.
const RESET_TAKES: Duration = Duration::from_secs(5);
/// What is still a short press.
const SHORT_PRESS: Duration = Duration::from_secs(3);
/// Below this voltage the encoder goes down; invented.
const LOWEST_SUPPLY: f64 = 7.0;
/// Above this temperature the encoder has an error, wherever the limits of the warning stand; invented.
pub const HIGHEST_TEMPERATURE: f64 = 120.0;

/// The encoder in the hands of the stand.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// Supply voltage in volts.
    pub volts: f64,
    /// Temperature in degrees Celsius.
    pub celsius: f64,
    /// Whether an error was found while starting.
    pub has_start_up_error: bool,
    has_power: bool,
    /// Whether the supply has come back from below its limit: then the encoder starts anew. Manual, table 53.
    pub comes_back: bool,
    switches: [u32; 3],
    pressed_since: Option<Time>,
    /// Whether the button was found to have been held for long enough: then nothing more is due for it.
    was_held: bool,
    /// Whether the next start begins with the factory settings.
    pub reset_is_due: bool,
}

impl Default for Surroundings {
    fn default() -> Surroundings {
        Surroundings {
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

impl Surroundings {
    /// Whether there is enough supply for the encoder to work, and it does not start anew.
    pub fn is_alive(&self, hooks: &Hooks) -> bool {
        let check = Check::Works { is_reset_due: self.has_power && self.reset_is_due };
        hooks.check(check, self.volts >= LOWEST_SUPPLY && !self.comes_back)
    }

    /// The supply voltage in whole millivolts.
    pub fn millivolts(&self) -> u64 {
        (self.volts * 1000.0 + 0.5).max(0.0) as u64
    }

    /// The temperature in whole degrees.
    pub fn degrees(&self) -> i64 {
        (self.celsius + if self.celsius < 0.0 { -0.5 } else { 0.5 }) as i64
    }

    /// Since when the button is held, as far as it counts for the reset.
    fn held_since(&self) -> Option<Time> {
        self.pressed_since.filter(|_| self.has_power && !self.reset_is_due)
    }

    /// When the button will have been held for long enough, until that was found.
    pub fn deadline(&self) -> Option<Time> {
        self.held_since().filter(|_| !self.was_held).map(|since| since + RESET_TAKES)
    }

    /// The supply has come or gone.
    pub fn power(&mut self, has_power: bool) {
        (self.has_power, self.pressed_since, self.comes_back, self.was_held) = (has_power, None, false, false);
    }
}

/// Does what the stand does to supply, temperature, switches and button.
pub fn handle(live: &mut PoweredEncoder<'_, State>, action: &StandAction<'_>) -> Option<Time> {
    let [was_low, _] = limits::voltage_is_outside(live);
    let around = &mut live.model.around;
    match *action {
        StandAction::SupplyVoltage(volts) => {
            around.volts = volts;
            let [is_low, _] = limits::voltage_is_outside(live);
            let State { around, hooks, .. } = &mut *live.model;
            around.comes_back = hooks.check(Check::Restarts, around.has_power && was_low && !is_low);
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

/// Whether the address switches stand at 888: manual, 5.5.
fn request_reset(model: &State) -> bool {
    let switches = model.around.switches;
    model.hooks.check(Check::ResetSwitches(switches), switches == [8; 3])
}

/// Looks at how long the button has been held.
pub fn watch_button(live: &mut PoweredEncoder<'_, State>) {
    let Some(since) = live.model.around.held_since() else { return };
    let held = live.now.since(since);
    let is_long = held >= RESET_TAKES;
    live.model.around.was_held |= is_long;
    if live.model.hooks.check(Check::ResetIsHeld(held), is_long) && request_reset(live.model) {
        live.model.around.reset_is_due = true;
    }
}

/// The button is let go: a short press is an absolute preset, unless the switches request the reset.
fn release(live: &mut PoweredEncoder<'_, State>, held: Duration) {
    let is_preset = held < SHORT_PRESS && !request_reset(live.model);
    let shared = &live.model.shared;
    if shared.check(hooks::Check::ButtonPresets(held), is_preset) {
        let value = shared.seams.apply(live.ram.preset_value, |hooks, value| hooks.button(value));
        live.preset(PresetSource::Value(PresetMode::Absolute, value));
    }
}
