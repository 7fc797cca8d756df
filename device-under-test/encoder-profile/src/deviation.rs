//! What may stand beside an encoder and let it deviate from what is right, at each of its seams.
//!
//! An encoder is plain: it knows what is right, and says so at its decisions ([`Check`]). Whoever stands beside it may turn a
//! decision round, and change what comes to the encoder and what goes out. Without the feature `deviations` nobody does.

use crate::behaviour::{Lit, View};
use crate::profidrive::telegram::{Before, Image};

/// A yes or no that the encoder decides, with what it decides about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {}

/// Who stands beside an encoder; each default is to leave it as it is.
#[allow(unused_variables, reason = "the names tell what a seam is about")]
pub trait Deviation {
    /// What the encoder has decided about this.
    fn check(&mut self, check: Check, verdict: bool) -> bool {
        verdict
    }

    /// The signals of a frame, from those that are right now and the cycle before.
    fn image(&mut self, before: &Before, now: Image) -> Image {
        now
    }

    /// The value of an element of a parameter, by the number of the parameter and the place of the element.
    fn element(&mut self, view: &View<'_>, at: (u16, usize), right: u64) -> u64 {
        right
    }

    /// What an LED shows to who looks at it.
    fn led(&mut self, lit: &Lit<'_>, right: &'static str) -> &'static str {
        right
    }
}
