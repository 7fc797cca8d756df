//! Reference encoders written from the manuals, with deliberate bugs to switch on.
//!
//! From the shaft outwards: [`encoder`] measures, [`profidrive`] speaks the encoder profile, [`encoder_object`] is the
//! measuring task that the manuals share, [`models`] is one encoder per manual, [`application`] is the seam to [`profinet`], the stack; [`profibus`] is the other bus, with a seam of its own. [`bugs`] says how a device can be told to be wrong.
//!
//! This crate must not know the harness: neither its controllers nor its suites. It is the second telling of each manual.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod application;
pub mod behaviour;
pub mod bugs;
pub mod encoder;
pub mod encoder_object;
pub mod models;
pub mod profibus;
pub mod profidrive;
pub mod profinet;
mod registry;

pub use registry::{
    BuildError, Bus, Line, Manual, Profibus, Profinet, ReferenceDevice, Setup, behaviour, bugs_of_the_field, build,
    build_delivered, build_manual, manual, manuals, manuals_with,
};
