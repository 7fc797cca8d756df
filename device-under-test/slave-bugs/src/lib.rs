//! The deliberate bugs of the PROFIBUS DP slave that each reference device on PROFIBUS has below its encoder, and of the plain slave.
//!
//! The bugs of the encoders are in the crate `bugs`, whose tables list these too.
#![no_std]

extern crate alloc;
#[macro_use]
extern crate deviation_hooks;
#[cfg(test)]
extern crate std;

pub mod dp_alarms;
mod dp_alarms_state;
pub mod dp_slave;
mod dp_slave_state;
pub mod slave;
pub mod slave_state;
#[cfg(test)]
mod tests;

use deviation_hooks::{Group, needs, seams};
