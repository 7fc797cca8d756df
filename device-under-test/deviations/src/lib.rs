//! Deliberate bugs that the reference devices can be told to have.
//!
//! [`tables`] are the bugs by seam, each with the knob that it turns; [`manuals`] says which of them the devices of a manual
//! take. A [`Subject`] is a manual with its bugs, and builds a device that has some of them. What a harness needs of
//! `reference-devices` besides is handed on from here.
//!
//! This crate must not hold healthy behaviour: that stands in the devices, which know nothing of it.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod manuals;
pub mod seams;
mod subject;
pub mod tables;
#[cfg(test)]
mod tests;

pub use manuals::{build, sentence, subject, subjects};
pub use reference_devices::{Bus, Line, Manual, ReferenceDevice};
pub use subject::{BuildError, Setup, Subject, bugs_of_the_field};
