//! Captures made by hand.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../../encspec/tests/common/handmade/mod.rs"]
#[allow(dead_code, reason = "the tests of another package use the rest")]
mod handmade;

mod blame;
mod bus;
mod causes;
mod console;
mod running_machine;
