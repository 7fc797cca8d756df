//! Datalogic AMT58 HS58 and HM58 with PROFIBUS DP.
//!
//! Source: Datalogic AMT58...16x14 PB, Profibus-DP Profile for Encoders, instruction manual of 2017. Set_Prm selects Class 1,
//! Class 2, or Class 2 with velocity. Only the preset offset is stored, and the node number if the bus has set it. Whatever is not
//! printed in the manual is marked as invented.
//!
//! By chapter: [`node_number`] 4.8 and 6.8, [`leds`] 4.9, [`set_prm`] and [`scaling`] 6.4, [`data_exchange`] 6.5 and 6.6,
//! [`preset`] 6.6, `slave_diag` 6.7, [`red_zone`] 6.9.

pub mod data_exchange;
mod encoder;
pub mod hooks;
pub mod leds;
pub mod node_number;
pub mod preset;
pub mod red_zone;
pub mod scaling;
pub mod set_prm;
mod slave;
mod slave_diag;

#[cfg(test)]
mod tests;

pub use encoder::Amt58;

use core::time::Duration;
use device_stack::profibus::SlaveIdentity;
use encoder_profile::encoder::Hardware;

/// The node number in factory state: manual, 4.8.
pub const ADDRESS: u8 = 1;

/// The variants and their hardware (manual, 6.4.3).
pub const VARIANTS: [(&str, Hardware); 2] = [
    ("hs5818", Hardware { steps_per_revolution: 262_144, revolutions: 1 }),
    ("hm5816-16384", Hardware { steps_per_revolution: 65_536, revolutions: 16_384 }),
];

/// The ident number (manual, 5.2).
pub const IDENT: u16 = 0x1655;

/// What the slave can do; invented.
fn identity(ident: u16) -> SlaveIdentity {
    SlaveIdentity {
        ident,
        boot_time: Duration::from_millis(500),
        freeze: true,
        sync: true,
        fail_safe: true,
        dpv1: true,
        ms1: false,
        extra_alarm_sap: false,
        ms2: 0,
        abilities: None,
        isochronous: false,
        set_ext_prm: false,
    }
}
