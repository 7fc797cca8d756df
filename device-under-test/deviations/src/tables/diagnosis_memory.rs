//! Deviations of diagnoses and warnings that remember something of what was reported before.

use super::image::{ERROR, has_error};
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use device_stack::profinet::Severity;
use encoder_profile::checks::{Check, EncoderChecks};
use encoder_profile::hooks::{EncoderHooks, View};
use encoder_profile::profidrive::telegram::{Before, Image};

/// A diagnosis stays when its fault has gone.
#[derive(Default)]
pub struct StayingDiagnoses(Vec<(u16, Severity)>);

impl EncoderHooks for StayingDiagnoses {
    fn diagnoses(&mut self, _: &View<'_>, right: Vec<(u16, Severity)>) -> Vec<(u16, Severity)> {
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
    fn warnings(&mut self, view: &View<'_>, right: u32) -> u32 {
        self.0 = if view.is_starting { right } else { self.0 | right };
        self.0
    }

    fn powered_up(&mut self) {
        self.0 = 0;
    }
}

/// While diagnoses are not reported there are no error codes either.
#[derive(Clone, Default)]
pub struct Silence(Rc<Cell<bool>>);

impl EncoderChecks for Silence {
    fn check(&mut self, check: Check, verdict: bool) -> bool {
        if matches!(check, Check::AlarmChannel { .. }) {
            self.0.set(!verdict);
        }
        verdict
    }
}

impl EncoderHooks for Silence {
    fn image(&mut self, _: &Before, now: Image) -> Image {
        if !self.0.get() || !has_error(&now) {
            return now;
        }
        let transfers = now.request.absolute;
        let position = if transfers { now.position as u32 } else { 0 };
        Image { g1_zsw: now.g1_zsw & !ERROR | u16::from(transfers) << 13, g1_xist2: position, ..now }
    }
}
