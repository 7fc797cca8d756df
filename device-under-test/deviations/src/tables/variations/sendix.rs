//! What the manual of the Sendix 58xx leaves free.

use crate::tables::Group;

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[];
