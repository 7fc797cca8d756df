//! What the binaries of the tests and the benches share.
#![allow(dead_code, reason = "each binary uses a part of it")]

pub mod made;
pub mod program;
pub mod served;
