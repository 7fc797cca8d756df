//! The deliberate bugs of the reference devices. [`tables`] lists them by topic; the hooks to which they are attached are in the crate
//! `deviation-hooks`.
//!
//! Conforming behaviour does not belong in this crate. It is in the devices, which do not depend on bugs.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod tables;
#[cfg(test)]
mod tests;

use deviation_hooks::{needs, seams};
