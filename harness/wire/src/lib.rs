//! Wire formats: PROFINET, PROFIBUS, PROFIdrive, and the subset of HTTP that devices use.
//!
//! Each wire format is defined once, for parsing and writing. Unknown values and reserved bits are preserved: a tester that
//! drops them hides the finding. Parsers never panic, whatever the bytes.
//!
//! This crate must not know time, I/O, controllers or devices.
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
pub mod snmp;

pub use error::{Result, WireError};
