//! The controls under the screw cover (address switches, preset push-button, bus termination), and the power supply. Manual, 3.7,
//! 4.2.1 and 4.3.
//!
//! Interpretation: the address is read at power-up; with an address that is not permitted the encoder stays off the bus. A
//! short press (below 3 s, invented) makes an absolute preset when the button is released.

use super::A3m60State;
use super::hooks::{A3m60Check, A3m60Deviations};
use crate::models::sick::hooks::SickCheck;
use core::time::Duration;
use encoder_profile::encoder::PresetMode;
use encoder_profile::encoder_object::{PoweredEncoder, PresetSource};
use station::{StandAction, Time};

/// Below this voltage the encoder is down; invented.
const LOWEST_SUPPLY: f64 = 7.0;
/// A press is short below this time; invented.
const SHORT_PRESS: Duration = Duration::from_secs(3);
/// An address at which no station answers.
pub const NOWHERE: u8 = 255;

/// Switches, button and power supply.
#[derive(Clone, Debug)]
pub struct Controls {
    volts: f64,
    is_badly_initialized: bool,
    has_power: bool,
    /// The hex switch and the decimal switch.
    switches: [u32; 2],
    termination: [u32; 2],
    pressed_since: Option<Time>,
    address: Option<u8>,
}

impl Controls {
    /// Creates the controls in factory state except for the address.
    pub fn new(address: u8) -> Controls {
        let switches = [u32::from(address) / 10, u32::from(address) % 10];
        Controls {
            volts: 24.0,
            is_badly_initialized: false,
            has_power: true,
            switches,
            termination: [0; 2],
            pressed_since: None,
            address: Some(address),
        }
    }

    /// Returns the address in use; `None` if the address of the switches is not permitted.
    pub fn address(&self) -> Option<u8> {
        self.address
    }

    /// Processes power-up or power-off.
    pub fn power(&mut self, has_power: bool, hooks: &A3m60Deviations) {
        (self.has_power, self.pressed_since) = (has_power, None);
        if has_power {
            self.address = address(self.switches, hooks);
        }
    }

    /// Returns whether the bus is terminated: manual, 4.3.1.
    pub fn is_terminated(&self, hooks: &A3m60Deviations) -> bool {
        hooks.check(A3m60Check::Terminated(self.termination), self.termination == [1; 2])
    }

    /// Returns whether the initialization fails.
    pub fn is_badly_initialized(&self) -> bool {
        self.is_badly_initialized
    }

    /// Returns whether the supply voltage is high enough for the encoder to work.
    pub fn is_alive(&self) -> bool {
        self.volts >= LOWEST_SUPPLY
    }

    /// Returns the supply voltage in whole millivolts.
    pub fn millivolts(&self) -> u64 {
        (self.volts * 1000.0 + 0.5).max(0.0) as u64
    }
}

/// Returns the address that the switches set: manual, 4.3.2.
pub fn address(switches: [u32; 2], hooks: &A3m60Deviations) -> Option<u8> {
    let [tens, ones] = hooks.0.apply(switches, |hooks, switches| hooks.switches(switches));
    let address = tens.checked_mul(10)?.checked_add(ones)?;
    let is_permitted = hooks.check(A3m60Check::Address(address), (1..=125).contains(&address));
    u8::try_from(address).ok().filter(|_| is_permitted)
}

/// Carries out actions of the stand on supply, switches and button.
pub fn handle(live: &mut PoweredEncoder<'_, A3m60State>, action: &StandAction<'_>) -> Option<Time> {
    let controls = &mut live.model.controls;
    match *action {
        StandAction::SupplyVoltage(volts) => controls.volts = volts,
        StandAction::Fault("initialization", present) => controls.is_badly_initialized = present,
        StandAction::Fault("noise", present) => live.model.has_noise = present,
        StandAction::Switch("tens", place) => controls.switches[0] = place,
        StandAction::Switch("ones", place) => controls.switches[1] = place,
        StandAction::Switch("termination_a", place) => controls.termination[0] = place,
        StandAction::Switch("termination_b", place) => controls.termination[1] = place,
        StandAction::Button("preset", true) => controls.pressed_since = Some(live.now),
        StandAction::Button("preset", false) => {
            if let Some(since) = controls.pressed_since.take().filter(|_| controls.has_power) {
                release(live, live.now.since(since));
            }
        }
        _ => return None,
    }
    Some(live.now)
}

/// Processes the release of the button: a short press makes an absolute preset.
fn release(live: &mut PoweredEncoder<'_, A3m60State>, held: Duration) {
    let shared = &live.model.shared;
    if shared.check(SickCheck::ButtonPresets(held), held < SHORT_PRESS) {
        let value = shared.seams.apply(live.ram.preset_value, |hooks, value| hooks.button(value));
        live.preset(PresetSource::Value(PresetMode::Absolute, value));
    }
}
