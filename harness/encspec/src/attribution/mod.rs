//! Measures whether a failure names the requirement that is broken: which requirements no check tells apart ([`shared`]), and what
//! else fails when a bug breaks one requirement ([`bugs`]).

pub mod bugs;
pub mod shared;

/// A percentage of a manual's requirements that may have no check of their own.
pub const SHARED_GOAL: f64 = 5.0;
/// How many requirements a bug may fail beyond those that it breaks: half of the bugs, and nine of ten.
pub const BEYOND_GOALS: (usize, usize) = (6, 30);
