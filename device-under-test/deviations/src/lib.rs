//! The deviations of the reference devices: deliberate bugs, and variations that a manual permits.
//!
//! [`tables`] lists the deviations by topic, [`seams`] the hooks to which they are attached, [`needs`] what a device must have for
//! them. A [`Subject`] is a manual with its deviations; it builds devices that have some of them. This crate re-exports what a harness
//! needs from `reference-devices`.
//!
//! Conforming behaviour does not belong in this crate. It is in the devices, which do not depend on deviations.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod manuals;
pub mod needs;
mod random;
pub mod seams;
mod subject;
pub mod tables;
#[cfg(test)]
mod tests;

pub use manuals::{build, sentence, subject, subjects};
pub use reference_devices::{DeviceManual, Line, ManualBus, ReferenceDevice};
pub use subject::{BuildError, Setup, Subject, persona_bugs};
pub use tables::{Deviation, DeviationKind};
