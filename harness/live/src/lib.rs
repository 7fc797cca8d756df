//! Benches with real wires and with programs: preflight, filters before the wire, stand, journal and serving of reference devices.
//!
//! This crate must not know suites, nor how anything is judged.
#![allow(missing_docs, reason = "used inside this workspace only")]

pub mod application;
pub mod control;
pub mod device;
pub mod device_discovery;
pub mod discover;
pub mod fdl;
pub mod fence;
pub mod frame_limits;
pub mod guard;
pub mod journal;
pub mod line;
pub mod lock;
mod permanence;
pub mod preflight;
pub mod profibus;
pub mod serve;
pub mod soak;
pub mod stand;
mod ticker;
pub mod unusable;
pub mod withheld;
