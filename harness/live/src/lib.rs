//! Benches with real wires: what is found there, what holds the device, what was changed and is put back.
//!
//! This room must not know suites, nor how anything is judged.

pub mod control;
pub mod device;
pub mod discover;
pub mod fdl;
pub mod fence;
pub mod guard;
pub mod held_back;
pub mod journal;
pub mod line;
pub mod lock;
pub mod preflight;
pub mod profibus;
pub mod scout;
pub mod serve;
pub mod stand;
mod ticker;
pub mod unusable;
