//! Reference encoders written from the manuals: conforming devices.
//!
//! [`models`] is one encoder per manual, of the parts that all share (`encoder-profile`); [`manuals`] puts each behind its
//! stack (`device-stack`). A device is built with the [`deviations`] that are attached to its parts, none if it conforms; what they
//! are stands in the crate `deviations`.
//!
//! This crate must not know the harness, neither its controllers nor its suites, nor any deviation. It implements each manual a
//! second time, independently of the suites.
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

pub use manual::{Bus, Line, Manual, Profibus, Profinet, ReferenceDevice};
