//! PROFINET and PROFIBUS controllers as state machines: the harness's side of the wire.
//!
//! A controller is a [`station::Station`]: it receives requests, frames and deadlines, and returns frames and outcomes.
//! This crate must not know any device: no model, no bug, no signal name. It does no I/O and has no clock.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod outputs;
pub mod profibus_dp;
pub mod profinet_io;
pub mod random;
mod words;
