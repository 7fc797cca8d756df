//! Deviations of diagnoses and warnings that have state.

use super::signal_image::{ERROR, has_error};
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use device_stack::profinet::DiagnosisSeverity;
use encoder_profile::checks::{EncoderCheck, EncoderChecks};
use encoder_profile::hooks::{EncoderHooks, EncoderView};
use encoder_profile::profidrive::telegram::{PreviousCycle, SignalImage};
use station::Time;

/// Returns a diagnosis for each present error and warning, all with the same error type.
pub fn with_error_type(view: &EncoderView<'_>) -> Vec<(u16, DiagnosisSeverity)> {
    let errors = view.errors.iter().map(|_| (0x9000, DiagnosisSeverity::Fault));
    let warnings =
        (0..32).filter(|bit| view.warnings >> bit & 1 != 0).map(|_| (0x9000, DiagnosisSeverity::MaintenanceRequired));
    let mut all: Vec<_> = errors.chain(warnings).collect();
    all.dedup();
    all
}

/// While there is an error or a warning, its diagnosis disappears and appears again every 100 ms.
#[derive(Default)]
pub struct AlarmStorm {
    since: Option<Time>,
}

impl EncoderHooks for AlarmStorm {
    fn diagnoses(
        &mut self,
        view: &EncoderView<'_>,
        right: Vec<(u16, DiagnosisSeverity)>,
    ) -> Vec<(u16, DiagnosisSeverity)> {
        let is_reported = !view.user.compatible || view.user.alarm_channel;
        let all = with_error_type(view);
        if all.is_empty() || !is_reported {
            self.since = None;
            return right;
        }
        let since = *self.since.get_or_insert(view.now);
        if view.now.since(since).as_millis() % 100 < 50 { all } else { right }
    }

    fn powered_up(&mut self) {
        self.since = None;
    }
}

/// A diagnosis stays after its fault has disappeared.
#[derive(Default)]
pub struct StayingDiagnoses(Vec<(u16, DiagnosisSeverity)>);

impl EncoderHooks for StayingDiagnoses {
    fn diagnoses(
        &mut self,
        _: &EncoderView<'_>,
        right: Vec<(u16, DiagnosisSeverity)>,
    ) -> Vec<(u16, DiagnosisSeverity)> {
        for new in right {
            if !self.0.contains(&new) {
                self.0.push(new);
            }
        }
        self.0.clone()
    }

    fn powered_up(&mut self) {
        self.0.clear();
    }
}

/// A warning stays until the next connection.
#[derive(Default)]
pub struct StayingWarnings(u32);

impl EncoderHooks for StayingWarnings {
    fn warnings(&mut self, view: &EncoderView<'_>, right: u32) -> u32 {
        self.0 = if view.is_starting { right } else { self.0 | right };
        self.0
    }

    fn powered_up(&mut self) {
        self.0 = 0;
    }
}

/// While diagnoses are not reported, error codes are not shown either.
#[derive(Clone, Default)]
pub struct SilencedErrorCodes(Rc<Cell<bool>>);

impl EncoderChecks for SilencedErrorCodes {
    fn check(&mut self, check: EncoderCheck, verdict: bool) -> bool {
        if matches!(check, EncoderCheck::AlarmChannel { .. }) {
            self.0.set(!verdict);
        }
        verdict
    }
}

impl EncoderHooks for SilencedErrorCodes {
    fn image(&mut self, _: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
        if !self.0.get() || !has_error(&now) {
            return now;
        }
        let transfers = now.request.absolute;
        let position = if transfers { now.position as u32 } else { 0 };
        SignalImage { g1_zsw: now.g1_zsw & !ERROR | u16::from(transfers) << 13, g1_xist2: position, ..now }
    }
}
