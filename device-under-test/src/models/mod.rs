//! The encoders, one manual each: what its user reads is what stands here. And a device after no manual at all.
//!
//! A model is one file or folder here and one word in [`MANUALS`].

use crate::registry::Manual;

pub mod datalogic_amt58;
pub mod kuebler_sendix58xx;
pub mod lika_xac77;
pub mod plain;
pub mod sick;
pub mod sick_a3m60;
pub mod sick_afx60;

/// The manuals that there is a reference device for.
pub static MANUALS: &[&Manual] = &[
    &lika_xac77::MANUAL,
    &kuebler_sendix58xx::MANUAL,
    &sick_afx60::MANUAL,
    &sick_a3m60::MANUAL,
    &datalogic_amt58::MANUAL,
    &plain::MANUAL,
];
