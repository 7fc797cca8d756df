//! Bugs of isochronous operation: the clock of the bus and the two signs of life.

use super::Group;
use super::cyclic_state::as_set;
use crate::needs::Need;
use alloc::rc::Rc;
use core::cell::Cell;
use core::mem;
use core::time::Duration;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder_object::PoweredEncoder;
use reference_devices::manuals;
use reference_devices::models::sick_a3m60::hooks::{A3m60Check, A3m60Event, A3m60Hooks, A3m60Memory};
use reference_devices::models::sick_a3m60::status::{CLOCK_DEVIATING, CLOCK_MISSING, SensorStatusWords};
use reference_devices::models::sick_a3m60::{A3m60State, ClockErrors, IsochronousTimes};
use station::Time;
use wire::profibus::dpv1::Dpv1Pdu;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::SICK_A3M60)],
    deviations: bugs! {
        // Clock
        "never-synchronised" "The encoder never synchronizes with the clock."
            => |d| d.a3m60.check(|check, right| right && !matches!(check, A3m60Check::Synchronizes(_)));
        "time-base-of-the-block-misread" "The time base of the block is read as microseconds."
            => |d| d.a3m60.times(|times| times.map(|times| IsochronousTimes { cycle: times.cycle * 12, ..times }));
        "cycle-of-1-ms-only" "Every cycle time other than 1 ms is reported as a deviating clock."
            => |d| d.a3m60.status(|encoder, words| match encoder.model.clock.times() {
                Some(times) if times.cycle != Duration::from_millis(1) => SensorStatusWords { b: words.b | CLOCK_DEVIATING, ..words },
                _ => words,
            });
        "any-cycle-accepted" "Any cycle time is accepted."
            => |d| d.a3m60.check(|check, right| right || matches!(check, A3m60Check::Cycle(_)));
        "free-runs-without-notice" "A missing clock is not detected."
            => |d| d.a3m60.check(|check, right| right && check != A3m60Check::ClockMissing);
        "missing-clock-never-reported" "Bit 5 of P1001 is never set."
            => |d| d.encoder.element(|_, at, right| if at == S_STAT_B { right & !0x20 } else { right });
        "deviating-clock-as-missing" "A deviating clock is reported as a missing clock."
            => |d| d.a3m60.status(|_, words| SensorStatusWords { b: words.b & !CLOCK_DEVIATING | (words.b & CLOCK_DEVIATING) >> 1, ..words });
        "synchronisation-codes-exchanged" "The error codes of a missing and a deviating clock are swapped."
            => |d| d.encoder.code(|error| match error.code { Some(0x0F03) => Some(0x0F04), Some(0x0F04) => Some(0x0F03), other => other });
        "bus-status-bits-exchanged" "Bits 5 and 6 of P1001 are swapped."
            => |d| d.encoder.element(|_, at, right| if at == S_STAT_B { right & !0x60 | (right & 0x20) << 1 | (right & 0x40) >> 1 } else { right });
        "inner-state-in-bus-status" "Bit 0 of P1001 is set in isochronous operation."
            => |d| {
                let is_isochronous = d.track(false, |encoder, _, _| encoder.model.clock.times().is_some());
                d.encoder.element(move |_, at, right| if at == S_STAT_B { right | u64::from(is_isochronous.get()) } else { right });
            };
        "only-power-off-helps" "Errors of the clock and of the sign of life are never cleared."
            => |d| {
                d.a3m60.check(|check, right| right && !matches!(check, A3m60Check::Synchronizes(wrong) if wrong != ClockErrors::default()));
                d.checks.check(|check, right| right && !matches!(check, EncoderCheck::FollowsLifeSign { has_failed: true, .. }));
            };
        "simulated-clock-ignored" "The clock is never simulated."
            => |d| d.a3m60.times(|times| times.map(|times| IsochronousTimes { is_simulated: false, ..times }));
        "samples-averaged-in-isochronous-mode" "The position is the mean of several samples even in isochronous operation."
            => |d| d.a3m60.place(|encoder, place| match encoder.model.clock.times() {
                Some(_) => encoder.model.samples.mean(encoder.model.fields.samples.into()),
                None => place,
            });
        "sampled-beside-the-clock" "The position is sampled every 1.3 ms instead of at the clock."
            => |d| d.a3m60.place(|encoder, place| match encoder.model.clock.place() {
                Some(_) => encoder.shaft.position(Time::from_nanos(encoder.now.as_nanos() / 1_300_000 * 1_300_000)),
                None => place,
            });
        "acyclic-access-disturbs-the-clock" "After each parameter request the next clock is treated as missing."
            => |d| {
                let has_request = Rc::new(Cell::new(false));
                let comes = has_request.clone();
                d.slave.record(move |pdu| comes.set(comes.get() || matches!(pdu, Dpv1Pdu::Write(_))));
                d.a3m60.add(Disturbed { has_request, is_next: false, clocks: 0 });
            };

        // Sign of life of the master
        "controller-sign-of-life-in-bits-8-to-11" "The sign of life of the master is read from bits 8 to 11."
            => |d| d.encoder.control_words(|_, [a, b]| [a & 0x0FFF | (a & 0x0F00) << 4, b]);
        "life-sign-wrap-is-failure" "A sign of life of 0 is expected after 15, so the step from 15 to 1 is a failure."
            => |d| d.checks.check(|check, right| match check {
                EncoderCheck::FollowsLifeSign { last, sign, .. } => last != 1 && sign == last + 1,
                _ => right,
            });
        "life-sign-of-three-bits" "A sign of life of the master above 7 counts as a failure."
            => |d| d.checks.check(|check, right| match check {
                EncoderCheck::FollowsLifeSign { sign, .. } => right && sign < 8,
                _ => right,
            });
        "zero-life-sign-accepted" "A sign of life of 0 never counts as a failure."
            => |d| d.checks.check(|check, right| match check {
                EncoderCheck::FollowsLifeSign { last, sign, .. } => right || sign == 0 || last == 0,
                _ => right,
            });
        "tolerance-without-compatibility-mode" "The configured tolerance is used even without compatibility mode."
            => |d| {
                d.life_sign.tolerated(as_set);
                d.encoder.element(|view, at, right| if at.0 == 925 { view.user.life_sign_failures.into() } else { right });
            };
        "single-failure-is-error" "Without compatibility mode no failure is tolerated."
            => |d| {
                d.life_sign.tolerated(|user, right| if user.compatible { right } else { 0 });
                d.encoder.element(|view, at, right| if at.0 == 925 && !view.user.compatible { 0 } else { right });
            };
        "life-sign-tolerance-ignored" "One failure is tolerated, whatever the configured tolerance."
            => |d| d.life_sign.tolerated(|_, _| 1);
        "tolerance-of-4-bits" "Only the lower four bits of the tolerance are used, and any value is accepted."
            => |d| {
                d.checks.check(|check, right| right || matches!(check, EncoderCheck::ToleranceIsRight(_)));
                d.life_sign.tolerated(|_, right| right & 15);
            };
        "life-sign-error-not-reported" "Bit 4 of P1001 is never set."
            => |d| d.encoder.element(|_, at, right| if at == S_STAT_B { right & !0x10 } else { right });
        "error-code-bytes-swapped" "The bytes of the error code of a failed sign of life are swapped."
            => |d| d.encoder.code(|error| error.code.map(|code| if code == 0x0F02 { code.swap_bytes() } else { code }));

        // Sign of life of the encoder
        "sign-of-life-before-synchronisation" "The sign of life of the encoder counts before it is synchronized."
            => |d| d.a3m60.check(|check, right| match check {
                A3m60Check::SignOfLife { is_isochronous, .. } => is_isochronous,
                _ => right,
            });
        "sign-of-life-counts-frames" "The sign of life of the encoder counts every 5 ms."
            => |d| d.life_sign.count(|elapsed, _, _| elapsed.as_millis() as u64 / 5 + 1);
        "sign-of-life-at-half-rate" "The sign of life of the encoder counts every second cycle."
            => |d| d.life_sign.count(|_, frames, _| frames.div_ceil(2));
        "sign-of-life-goes-on-without-clock" "The sign of life of the encoder continues when the clock is missing."
            => |d| d.a3m60.check(|check, right| match check {
                A3m60Check::SignOfLife { is_isochronous, wrong } => right || is_isochronous && wrong != ClockErrors::default(),
                _ => right,
            });
    },
}];

/// Parameter and element of S_STAT-B: P1001.
const S_STAT_B: (u16, usize) = (1001, 0);

/// Treats the clock as missing after each request, until four clocks were in time.
struct Disturbed {
    has_request: Rc<Cell<bool>>,
    is_next: bool,
    /// Number of clocks until the encoder is synchronized again.
    clocks: u32,
}

impl Disturbed {
    fn begin(&mut self) {
        if mem::take(&mut self.is_next) {
            self.clocks = 4;
        }
    }
}

impl A3m60Hooks for Disturbed {
    fn check(&mut self, check: A3m60Check, verdict: bool) -> bool {
        match check {
            A3m60Check::Synchronizes(_) => {
                self.begin();
                self.clocks = self.clocks.saturating_sub(1);
                verdict
            }
            A3m60Check::SignOfLife { .. } => verdict && self.clocks == 0,
            _ => verdict,
        }
    }

    fn happens(&mut self, event: A3m60Event, _: &mut A3m60Memory<'_>) {
        match event {
            A3m60Event::Advance => {
                self.begin();
                self.is_next = self.has_request.take();
            }
            A3m60Event::Start | A3m60Event::PowerUp => (self.is_next, self.clocks) = (false, 0),
            A3m60Event::PowerDown => {}
        }
    }

    fn status(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, words: SensorStatusWords) -> SensorStatusWords {
        let is_missing = self.clocks > 0 && encoder.model.clock.times().is_some();
        SensorStatusWords { b: words.b | if is_missing { CLOCK_MISSING } else { 0 }, ..words }
    }
}
