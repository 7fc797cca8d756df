//! Datalogic AMT58 HS58 and HM58 with PROFIBUS DP.
//!
//! Source: Datalogic AMT58...16x14 PB, Profibus-DP Profile for Encoders, instruction manual of 2017. Classes 1, 2 and 2 with
//! velocity are chosen by Set_Prm; the only thing that is stored is the offset of presets, and the address if the bus has given it.
//! What the manual does not print is marked as invented where it stands.

mod encoder;
pub mod knobs;
pub mod lights;
pub mod preset;
pub mod program;
mod slave;
mod switches;
pub mod told;

#[cfg(test)]
mod tests;

pub use encoder::Amt58;

use core::time::Duration;
use device_stack::profibus::Identity;
use encoder_profile::encoder::Hardware;

/// The address at delivery: manual, 4.8.
pub const ADDRESS: u8 = 1;

/// The variants and their hardware (manual, 6.4.3).
pub const VARIANTS: [(&str, Hardware); 2] = [
    ("hs5818", Hardware { steps_per_revolution: 262_144, revolutions: 1 }),
    ("hm5816-16384", Hardware { steps_per_revolution: 65_536, revolutions: 16_384 }),
];

/// The ident number (manual, 5.2); the rest is invented.
fn identity() -> Identity {
    Identity {
        ident: 0x1655,
        boot_time: Duration::from_millis(500),
        freeze: true,
        sync: true,
        fail_safe: true,
        dpv1: true,
        ms1: false,
        ms2: 0,
        abilities: None,
        set_ext_prm: false,
    }
}
