//! Identifies which positions can be compared with each other.

use serde::{Deserialize, Serialize};

/// The circle that a position belongs to; two signals with the same `position_in` share it.
///
/// Comparing or subtracting positions of different circles is a compile-time error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub struct Circle(pub u32);
