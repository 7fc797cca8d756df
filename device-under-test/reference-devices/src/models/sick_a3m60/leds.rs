//! The LEDs of the bus and of the encoder. Manual, 5.3.
//!
//! Interpretation: the print does not distinguish steady from flashing, so an LED with two colours has one pattern.

use super::hooks::A3m60Check;
use super::{A3m60State, status};
use device_stack::profinet::StackStatus;
use encoder_profile::encoder_object::PoweredEncoder;

/// Below this voltage in millivolts the supply is too low: manual, table 29.
const LOWEST_VOLTAGE: u64 = 10_000;

/// Returns what the LED of this name shows; `None` if it does not exist.
pub fn led(live: &PoweredEncoder<'_, A3m60State>, name: &str, status: &StackStatus) -> Option<&'static str> {
    let controls = &live.model.controls;
    let millivolts = controls.millivolts();
    let has_low_supply = !live.model.hooks.check(A3m60Check::Supply(millivolts), millivolts >= LOWEST_VOLTAGE);
    let pattern = match name {
        "bus" | "encoder" if !status.has_supply => "dark",
        "bus" | "encoder" if controls.is_badly_initialized() || has_low_supply => "red_green",
        "bus" if status.is_booting => "dark",
        "bus" if status.exchanges_data => "green",
        "bus" if status.module_differs => "orange",
        "bus" => "red",
        "encoder" if status::words(live).a & status::POSITION != 0 => "orange",
        "encoder" => "green",
        _ => return None,
    };
    Some(pattern)
}
