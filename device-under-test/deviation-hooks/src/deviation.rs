//! A deviation, and the needs that several share.

use crate::needs::Need;
use crate::seams::Deviations;

/// A deviation of a reference device from the behaviour of the conforming device.
#[derive(Debug)]
pub struct Deviation {
    /// The name. For a bug it is the name that suites list under `catches`.
    pub name: &'static str,
    /// What the device does, in one sentence.
    pub sentence: &'static str,
    /// Whether it is a bug or permitted by the manual.
    pub kind: DeviationKind,
    /// Attaches the deviation to the hooks of a device.
    pub attach: fn(&mut Deviations),
}

/// Whether a manual forbids or permits a deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviationKind {
    /// Forbidden: at least one case has to fail.
    Bug,
    /// Permitted: no case may fail.
    Permitted {
        /// The clause that permits it, or a note that the manual is silent.
        clause: &'static str,
    },
}

/// Deviations that are possible if all needs are met.
#[derive(Debug)]
pub struct Group {
    /// The needs of all these deviations.
    pub needs: &'static [Need],
    /// The deviations.
    pub deviations: &'static [Deviation],
}

/// Defines bugs, one per line: `"name" "Sentence." => |d| attach;`.
#[macro_export]
macro_rules! bugs {
    ($($name:literal $sentence:literal => |$deviations:ident| $attach:expr;)*) => {
        &[$($crate::Deviation {
            name: $name,
            sentence: $sentence,
            kind: $crate::DeviationKind::Bug,
            attach: |$deviations: &mut $crate::seams::Deviations| { $attach; },
        }),*]
    };
}
