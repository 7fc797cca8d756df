//! Reference encoders written from the manuals: conforming devices.
//!
//! [`models`] is one encoder per manual, of the parts that all share (`encoder-profile`); [`manuals`] puts each behind its
//! stack (`device-stack`). [`behaviour`] is what a device does at the places where it could do something else; what it can
//! be told to do wrong stands in `deviations`.
//!
//! This crate must not know the harness, neither its controllers nor its suites, nor the bugs. It is the second telling of
//! each manual.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate self as reference_devices;
#[cfg(test)]
extern crate std;

pub mod behaviour;
pub mod manual;
pub mod manuals;
pub mod models;

pub use manual::{Bus, Line, Manual, Profibus, Profinet, ReferenceDevice};
