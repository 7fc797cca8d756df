//! Text for people: bytes in hexadecimal, escaped text from devices, counts, and suggestions for misspelled words.
//!
//! Every message, report and page of the workspace uses these functions, so the format is the same everywhere.
//! This crate must not know what the text is about.
#![no_std]

extern crate alloc;

mod count;
mod escape;
mod hex;
mod nearest;
mod span;

pub use count::count;
pub use escape::{escaped, printable, steers};
pub use hex::{hex, hex_start};
pub use nearest::{Nearest, nearest};
pub use span::span;
