//! Captures made by hand.

#![allow(clippy::expect_used, clippy::unwrap_used, reason = "a test fails by panicking")]

mod running_machine;
