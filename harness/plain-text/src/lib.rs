//! Text for people: octets in hexadecimal, harmless text from devices, counts, and the word that was probably meant.
//!
//! Every message, report and page of the workspace uses these, so that the same thing always looks the same.
//! This crate must not know what the text is about.
#![no_std]

extern crate alloc;

mod count;
mod escape;
mod hex;
mod nearest;

pub use count::count;
pub use escape::{escaped, printable, steers};
pub use hex::{hex, hex_start};
pub use nearest::{Nearest, nearest};
