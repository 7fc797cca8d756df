//! Helpers of the test and benchmark binaries.
#![allow(dead_code, reason = "each binary uses a part of it")]

pub mod handmade;
pub mod program;
pub mod served;
