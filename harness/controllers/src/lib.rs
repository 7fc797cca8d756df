//! Our side of the wire: controllers as state machines.
//!
//! A controller is a [`station::Station`]: it is given requests, frames and deadlines, and hands back frames and outcomes.
//! This room must not know any device: no model, no bug, no signal name. It does no I/O and has no clock.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod outputs;
pub mod profibus_dp;
pub mod profinet_io;
mod words;
