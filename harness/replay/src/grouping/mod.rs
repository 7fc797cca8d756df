//! One cause is one finding, and what repeats is one finding: findings that follow from others are listed under them, and the same
//! finding again is counted.
//!
//! This module must not know how a finding was made.

mod causes;
mod fold;

pub(super) use causes::under_their_causes;
pub(super) use fold::folded;
