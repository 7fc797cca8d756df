//! The encoders, one manual each: what its user reads is what stands here. And a device after no manual at all.
//!
//! A model is one file or folder here and one word in [`MANUALS`].

use crate::registry::Manual;

pub mod kuebler_sendix58xx;
pub mod lika_xac77;
pub mod plain;
pub mod sick_afx60;

/// The manuals that there is a reference device for.
pub static MANUALS: &[&Manual] =
    &[&lika_xac77::MANUAL, &kuebler_sendix58xx::MANUAL, &sick_afx60::MANUAL, &plain::MANUAL];
