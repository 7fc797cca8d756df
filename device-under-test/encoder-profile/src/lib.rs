//! What encoders of the encoder profile share, whatever their manual and whichever their bus.
//!
//! From the shaft outwards: [`encoder`] measures, [`profidrive`] speaks the encoder profile, [`facts`] are what a manual says
//! in words and numbers, and [`encoder_object`] is the measuring task as a device stack sees it. A model gives its facts, and
//! functions for what no other has. Whatever an encoder decides can be flipped ([`checks`]) and whatever enters or leaves it changed
//! ([`hooks`]) by the [`deviations`] attached to it; a conforming encoder has none.
//!
//! This crate must not know any model, and of the stacks only the traits behind which an application stands.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate std;

pub mod encoder;
pub mod encoder_object;
pub mod facts;
pub mod profidrive;

pub use encoder_object::{deviations, hooks};
pub use profidrive::checks;
