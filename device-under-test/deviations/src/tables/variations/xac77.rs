//! What the manual of the XAC77 leaves free.

use crate::tables::Group;

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[];
