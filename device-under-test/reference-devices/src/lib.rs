//! Conforming reference devices, implemented from manuals.
//!
//! [`models`] has one encoder per manual, built from shared parts (`encoder-profile`). [`manuals`] connects each to its stack
//! (`device-stack`). A device is built with the [`deviations`] that are attached to its parts; a conforming device has none. The
//! deviations themselves are in the crate `deviations`.
//!
//! This crate depends neither on the harness (controllers, suites) nor on any deviation. Each manual is implemented twice,
//! independently: here and as suite data.
#![allow(missing_docs, reason = "an internal crate: many names need no comment")]
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate self as reference_devices;
#[cfg(test)]
extern crate std;

pub mod deviations;
pub mod manual;
pub mod manuals;
pub mod models;

pub use manual::{DeviceManual, Line, ManualBus, Profibus, Profinet, ReferenceDevice};
