//! Tests of the monitor on frames made by hand.

mod findings;
mod machine;
mod ring;
