//! What the manual of the A3M60 leaves free.

use crate::tables::Group;

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[];
