//! What deviations of the reference devices are made of: [`Deviation`] is one, [`seams`] has the hooks to which they are attached,
//! [`needs`] what a device must have for them.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

mod deviation;
pub mod needs;
pub mod seams;
#[cfg(test)]
mod tests;

pub use deviation::{Deviation, DeviationKind, Group};
