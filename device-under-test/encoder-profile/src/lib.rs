//! The common part of all encoders of the encoder profile.
//!
//! [`encoder`] is the measuring task: shaft, scaling, presets, velocity. [`profidrive`] is the encoder profile:
//! telegrams, sensor interface, parameters. [`facts`] are the data of a manual. [`encoder_object`] combines them to
//! an application of a PROFINET stack. A model provides its facts, and functions for what no other manual has. The
//! [`deviations`] attached to an encoder can flip its decisions ([`checks`]) and change what enters or leaves it
//! ([`hooks`]). A conforming encoder has none.
//!
//! This crate must not depend on models. Of the stacks it uses only the application traits.
#![no_std]
#![allow(missing_docs, reason = "an internal crate: many names need no comment")]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod encoder;
pub mod encoder_object;
pub mod facts;
pub mod profidrive;

pub use encoder_object::{deviations, hooks};
pub use profidrive::checks;
