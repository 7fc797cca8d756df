//! What is under the screw cover and what shines: address switches, preset push-button, bus termination, LEDs; and the supply.
//! Manual, 3.7, 4.2.1 and 4.3.
//!
//! Readings: the address is read when the supply comes; with one that is not permitted the encoder stays off the bus. A
//! short press (below 3 s, invented) is an absolute preset when the button is let go. Steady and flashing are lost in the
//! print: a LED of two colours is one word.

use super::status;
use super::{Live, State};
use core::time::Duration;
use device_stack::profinet::Seen;
use encoder_profile::encoder::PresetMode;
use encoder_profile::encoder_object::{Phase, Source};
use station::{StandAction, Time};

/// Below this voltage the supply is too low: manual, table 29.
pub const LOWEST_VOLTAGE: u64 = 10_000;
/// Below this voltage the encoder goes down; invented.
const LOWEST_SUPPLY: f64 = 7.0;
/// What is still a short press.
const SHORT_PRESS: Duration = Duration::from_secs(3);
/// An address at which no station answers.
pub const NOWHERE: u8 = 255;

/// The encoder in the hands of the stand.
#[derive(Clone, Debug)]
pub struct Hands {
    volts: f64,
    is_badly_initialized: bool,
    has_power: bool,
    /// The hex switch and the decimal switch.
    switches: [u32; 2],
    termination: [u32; 2],
    pressed_since: Option<Time>,
    address: Option<u8>,
}

impl Hands {
    /// As delivered, but for the address.
    pub fn new(address: u8) -> Hands {
        let switches = [u32::from(address) / 10, u32::from(address) % 10];
        Hands {
            volts: 24.0,
            is_badly_initialized: false,
            has_power: true,
            switches,
            termination: [0; 2],
            pressed_since: None,
            address: Some(address),
        }
    }

    /// The address in use; none if the one that is set is not permitted.
    pub fn address(&self) -> Option<u8> {
        self.address
    }

    /// Takes another address than the one of the switches.
    pub fn set_address(&mut self, address: u8) {
        self.address = Some(address);
    }

    /// Whether there is enough supply for the encoder to work.
    pub fn is_alive(&self) -> bool {
        self.volts >= LOWEST_SUPPLY
    }

    /// The supply voltage in whole millivolts.
    pub fn millivolts(&self) -> u64 {
        (self.volts * 1000.0 + 0.5).max(0.0) as u64
    }
}

/// The address that the switches set: manual, 4.3.2.
pub fn address(switches: [u32; 2]) -> Option<u8> {
    let [tens, ones] = switches;
    u8::try_from(tens.checked_mul(10)?.checked_add(ones)?).ok().filter(|address| (1..=125).contains(address))
}

/// The supply has come or gone.
pub fn power(live: &mut Live<'_, State>, has_power: bool) {
    let read = live.rules.own.address;
    let hands = &mut live.model.hands;
    (hands.has_power, hands.pressed_since) = (has_power, None);
    if has_power {
        hands.address = read(hands.switches);
    }
}

/// Does what the stand does to supply, switches and button.
pub fn handle(live: &mut Live<'_, State>, action: &StandAction<'_>) -> Option<Time> {
    let rules = &live.rules.own;
    let hands = &mut live.model.hands;
    match *action {
        StandAction::SupplyVoltage(volts) => hands.volts = volts,
        StandAction::Fault("initialization", present) => hands.is_badly_initialized = present,
        StandAction::Fault("noise", present) => live.model.has_noise = present,
        StandAction::Switch("tens", place) => hands.switches[0] = place,
        StandAction::Switch("ones", place) => hands.switches[1] = place,
        StandAction::Switch("termination_a", place) => hands.termination[0] = place,
        StandAction::Switch("termination_b", place) => hands.termination[1] = place,
        StandAction::Button("preset", true) => hands.pressed_since = Some(live.now),
        StandAction::Button("preset", false) => {
            let pressed = hands.pressed_since.take().filter(|_| hands.has_power);
            if pressed.is_some_and(|since| live.now.since(since) < SHORT_PRESS) {
                press(live);
            }
        }
        _ => return None,
    }
    if rules.reads_switches_at_once {
        live.model.hands.address = (rules.address)(live.model.hands.switches);
    }
    Some(live.now)
}

/// A short press: an absolute preset.
fn press(live: &mut Live<'_, State>) {
    let rules = &live.rules.sick;
    let Some(value) = (rules.button)(live.ram.preset_value) else { return };
    if !(live.rules.own.button_works)(live.ram.phase != Phase::Alone) {
        return;
    }
    live.ram.user.preset_acts_on_xist1 |= live.rules.own.button_moves_xist1;
    live.model.presets.is_pressed = true;
    if !rules.button_needs_class_4 && !live.ram.user.class_4 {
        live.ram.measuring.offset = live.ram.measuring.preset(PresetMode::Absolute, value.into());
        live.ram.measuring.settings.offset_acts = true;
    } else {
        live.preset(Source::Value(PresetMode::Absolute, value));
    }
    live.model.presets.is_pressed = false;
}

/// Whether the bus is terminated: manual, 4.3.1.
pub fn is_terminated(live: &Live<'_, State>) -> bool {
    (live.rules.own.terminates)(live.model.hands.termination)
}

/// What a LED shows.
pub fn light(live: &Live<'_, State>, name: &str, seen: &Seen) -> Option<&'static str> {
    let hands = &live.model.hands;
    let rules = &live.rules.own;
    let has_low_supply = hands.millivolts() < rules.lowest_voltage;
    let light = match name {
        "bus" | "encoder" if !seen.has_supply => "dark",
        "bus" | "encoder" if hands.is_badly_initialized => rules.bad_start_light,
        "bus" | "encoder" if has_low_supply => "red_green",
        "bus" if seen.is_booting => "dark",
        "bus" if seen.exchanges_data => "green",
        "bus" if seen.module_differs => "orange",
        "bus" => "red",
        "encoder" => {
            let words = status::words(live);
            let is_orange = (rules.is_orange)(words.a & super::status::POSITION != 0, words);
            if is_orange { "orange" } else { "green" }
        }
        _ => return None,
    };
    Some(light)
}
