//! The deviations of the reference devices: deliberate bugs, and variations that a manual permits.
//!
//! [`tables`] has them by topic, [`seams`] the hooks that they attach to, [`needs`] what of a device makes them possible. A
//! [`Subject`] is a manual with its deviations, and builds a device that has some of them. What a harness needs of
//! `reference-devices` besides is re-exported here.
//!
//! Conforming behaviour must not stand in this crate: that is in the devices, which know nothing of deviations.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod manuals;
pub mod needs;
pub mod seams;
mod subject;
pub mod tables;
#[cfg(test)]
mod tests;

pub use manuals::{build, sentence, subject, subjects};
pub use reference_devices::{Bus, Line, Manual, ReferenceDevice};
pub use subject::{BuildError, Setup, Subject, bugs_of_the_field};
pub use tables::{Deviation, Kind};
