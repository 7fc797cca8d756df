//! The manuals that have reference devices, each with its deviations.

use crate::subject::{BuildError, Setup, Subject};
use alloc::boxed::Box;
use alloc::string::ToString;
use reference_devices::{ReferenceDevice, manuals};

static SUBJECTS: &[Subject] = &[
    Subject { manual: &manuals::LIKA_XAC77 },
    Subject { manual: &manuals::KUEBLER_SENDIX58XX },
    Subject { manual: &manuals::SICK_AFX60 },
    Subject { manual: &manuals::SICK_A3M60 },
    Subject { manual: &manuals::DATALOGIC_AMT58 },
    Subject { manual: &manuals::PROFINET_IO },
    Subject { manual: &manuals::DP_SLAVE },
    Subject { manual: &manuals::DP_ENCODER },
    Subject { manual: &manuals::PROFIDRIVE_ENCODER },
];

/// Returns every manual that has a reference device.
pub fn subjects() -> &'static [Subject] {
    SUBJECTS
}

/// Finds a manual by its name.
///
/// # Errors
///
/// [`BuildError::UnknownManual`] if no reference device follows this manual.
pub fn subject(name: &str) -> Result<&'static Subject, BuildError> {
    SUBJECTS
        .iter()
        .find(|subject| subject.manual.name == name)
        .ok_or_else(|| BuildError::UnknownManual(name.to_string()))
}

/// Describes in one sentence what devices of a manual do with this bug; `None` if they cannot have it.
pub fn sentence(manual: &str, bug: &str) -> Option<&'static str> {
    let subject = subject(manual).ok()?;
    subject.bugs().find(|known| known.name == bug).map(|known| known.sentence)
}

/// Builds a device of this manual and variant, with power on and the cable plugged in.
pub fn build(name: &str, variant: &str, setup: &Setup<'_>) -> Result<Box<dyn ReferenceDevice>, BuildError> {
    subject(name)?.build(variant, setup)
}
