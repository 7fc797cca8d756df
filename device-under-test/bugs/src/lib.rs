//! The deliberate bugs of the reference devices; those of the DP slave behind them are in the crate `slave-bugs`. [`tables`] lists all by topic; the hooks to which they are attached are in the crate
//! `deviation-hooks`.
//!
//! Conforming behaviour does not belong in this crate. It is in the devices, which do not depend on bugs.
#![no_std]

extern crate alloc;
#[macro_use]
extern crate deviation_hooks;

pub mod tables;

use deviation_hooks::{needs, seams};
