//! Bytes and their meaning: PROFINET, PROFIBUS, PROFIdrive and what of HTTP devices have.
//!
//! Every wire format stands here once and serves both reading and writing. Unknown values and reserved bits are kept:
//! a tester that drops them hides the finding. Parsers never panic, whatever the octets.
//!
//! This room must not know time, I/O, controllers or devices.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

mod codes;
pub mod error;
pub mod octets;

pub mod datagram;
pub mod ethernet;
pub mod http;
pub mod lldp;
pub mod profibus;
pub mod profidrive;
pub mod profinet;

pub use error::{Result, WireError};
