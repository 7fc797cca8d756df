//! Which places can be compared.

use serde::{Deserialize, Serialize};

/// A circle on which places lie; two signals with the same `position_in` share it.
///
/// Places of different circles are never compared or subtracted: that is an error when the expression is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub struct Circle(pub u32);
