//! What the manual of the AFS60 and AFM60 leaves free.

use crate::tables::Group;

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[];
