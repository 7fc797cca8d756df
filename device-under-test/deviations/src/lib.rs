//! The deviations of the reference devices: deliberate bugs, and variations that a manual permits.
//!
//! The bugs are in the crate `bugs`; [`variations`] lists what a manual permits, by topic. A [`Subject`] is a manual with its
//! deviations; it builds devices that have some of them. This crate re-exports what a harness needs from `reference-devices`.
//!
//! Conforming behaviour does not belong in this crate. It is in the devices, which do not depend on deviations.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod manuals;
mod random;
mod subject;
#[cfg(test)]
mod tests;
pub mod variations;

pub use deviation_hooks::{Deviation, DeviationKind};
pub use manuals::{build, sentence, subject, subjects};
pub use reference_devices::{DeviceManual, Line, ManualBus, ReferenceDevice};
pub use seams::idents::IdentMask;
pub use seams::start_layout::{Place, StartLayout};
pub use subject::{BuildError, Setup, Subject, persona_bugs};
pub use variations::{DescriptionChange, VendorRecord};

use bugs::tables;
use deviation_hooks::{needs, seams};
