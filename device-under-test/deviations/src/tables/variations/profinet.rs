//! What a PROFINET device may do, whatever the manual of the encoder says.

use crate::tables::Group;

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[];
