//! What the manual of the AMT58 leaves free.

use crate::tables::Group;

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[];
