//! The decisions of an encoder that a deviation may flip: every yes or no about what it is asked for goes through one call.

use device_stack::Attached;

/// A decision of an encoder, with what it is about; the comment says what `true` means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// Whether the position stands still now, as it may while a preset is being stored.
    PositionStandsStill,
}

/// Flips decisions; the default leaves them as the manual has them.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait EncoderChecks {
    /// The decision that counts, from what it is about and the decision of the manual.
    fn check(&mut self, check: Check, verdict: bool) -> bool {
        verdict
    }
}

/// The checks that are attached to the parts of an encoder.
#[derive(Clone, Debug, Default)]
pub struct Checks(pub Attached<dyn EncoderChecks>);

impl Checks {
    /// The decision that counts: `verdict`, unless a deviation flips it.
    #[inline]
    pub fn check(&self, check: Check, verdict: bool) -> bool {
        self.0.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}
