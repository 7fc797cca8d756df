//! The descriptions that a vendor gives of a device, GSDML on PROFINET and GSD on PROFIBUS, and where they differ from the manual.
//!
//! This crate must not know how the device is driven.

pub mod gsd;
pub mod gsdml;
