//! The two signs of life: generating that of the encoder and monitoring that of the controller.
//!
//! Sources: XAC77 manual, chapter 10, STW2_ENC and ZSW2_ENC, and the PROFIdrive profile, to which it refers for both.

use super::user_parameters::UserParameterData;
use crate::profidrive::checks::{AttachedChecks, EncoderCheck};
use core::time::Duration;
use device_stack::Attached;
use station::Time;

/// When the sign of life of the encoder is incremented.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LifeSignPace {
    /// With each frame.
    EachFrame,
    /// With each send clock of 1 ms, independent of the update time.
    EachSendClock,
}

/// The steps of the signs of life that a deviation may change. Each default changes nothing.
#[allow(unused_variables, reason = "the names document the step")]
pub trait LifeSignSteps {
    /// The number of increments of the encoder's sign of life, from the time since its first frame and the number of
    /// frames.
    fn count(&mut self, elapsed: Duration, frames: u64, right: u64) -> u64 {
        right
    }

    /// The number of tolerated failures of the controller's sign of life.
    fn tolerated(&mut self, user: &UserParameterData, right: i32) -> i32 {
        right
    }
}

/// How much a failure increments the failure counter. A good sign of life decrements it by 1 (PROFIdrive).
pub const FAILURE: i32 = 10;

/// The send clock of [`LifeSignPace::EachSendClock`] in microseconds (Kübler Sendix 58xx, 8.2).
const SEND_CLOCK_MICROS: u64 = 1000;

/// The successor of a sign of life: 1 to 15, then 1 again. 0 means that the sender does not count.
pub fn next(sign: u8) -> u8 {
    sign % 15 + 1
}

/// The number of tolerated failures of the controller's sign of life: one without compatibility mode, the user's
/// setting with it (XAC77 manual, 11.4, Maximum Master Sign-Of-Life failures).
pub fn tolerated(user: &UserParameterData) -> u8 {
    if user.compatible { user.life_sign_failures } else { 1 }
}

/// The sign of life of the encoder.
#[derive(Clone, Copy, Debug, Default)]
pub struct EncoderLifeSign {
    begin: Option<Time>,
    frames: u64,
}

impl EncoderLifeSign {
    /// The sign of life of the frame that is sent now. It starts with 1.
    pub fn advance(&mut self, now: Time, counts: LifeSignPace, steps: &Attached<dyn LifeSignSteps>) -> u8 {
        let elapsed = now.since(*self.begin.get_or_insert(now));
        self.frames += 1;
        let right = match counts {
            LifeSignPace::EachFrame => self.frames,
            LifeSignPace::EachSendClock => (elapsed.as_micros() as u64 + SEND_CLOCK_MICROS / 2) / SEND_CLOCK_MICROS + 1,
        };
        let count = steps.apply(right, |steps, right| steps.count(elapsed, self.frames, right));
        (count.saturating_sub(1) % 15) as u8 + 1
    }
}

/// Monitors the sign of life of the controller.
///
/// Monitoring starts with the first sign that is not 0, because a controller may send none. From then on each frame
/// whose sign is not the successor is a failure. The manuals specify the number of tolerated failures, and PROFIdrive
/// how they are counted: a failure weighs ten times as much as a good sign of life. The counter is limited to just
/// above the tolerated value, so that the first good sign after a long failure ends it.
#[derive(Clone, Copy, Debug, Default)]
pub struct ControllerLifeSign {
    last: u8,
    watching: bool,
    account: i32,
    failed: bool,
}

impl ControllerLifeSign {
    /// Processes the sign of life of one frame. `tolerated` failures are allowed.
    pub fn take(&mut self, sign: u8, tolerated: i32, checks: &AttachedChecks) {
        let last = core::mem::replace(&mut self.last, sign);
        if !self.watching {
            self.watching = checks.check(EncoderCheck::StartsMonitoring { sign }, sign != 0);
            return;
        }
        let limit = tolerated * FAILURE;
        let check = EncoderCheck::FollowsLifeSign { last, sign, has_failed: self.failed };
        self.account = if checks.check(check, sign == next(last)) {
            (self.account - 1).max(0)
        } else {
            (self.account + FAILURE).min(limit + 1)
        };
        self.failed = self.account > limit;
    }

    /// Whether the tolerated number of failures is exceeded.
    pub fn has_failed(&self) -> bool {
        self.failed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;
    use rstest::rstest;

    fn watch(signs: impl IntoIterator<Item = u8>, tolerated: i32) -> ControllerLifeSign {
        let mut watch = ControllerLifeSign::default();
        let checks = AttachedChecks::default();
        signs.into_iter().for_each(|sign| watch.take(sign, tolerated, &checks));
        watch
    }

    fn counting(n: usize) -> impl Iterator<Item = u8> {
        core::iter::successors(Some(1), |sign| Some(next(*sign))).take(n)
    }

    #[test]
    fn the_count_runs_from_1_to_15_and_skips_0() {
        assert!(counting(31).eq((1..=15).chain(1..=15).chain([1])));
        assert_eq!(next(0), 1);
    }

    // Catalogue SOL-005 to SOL-007: the tolerated number of repetitions is no failure, one more is.
    #[rstest]
    #[case(1, 1, false)]
    #[case(1, 2, true)]
    #[case(10, 10, false)]
    #[case(10, 11, true)]
    #[case(255, 255, false)]
    #[case(255, 256, true)]
    fn tolerance(#[case] tolerated: i32, #[case] repetitions: usize, #[case] failed: bool) {
        let held = counting(7).chain(core::iter::repeat_n(7, repetitions));
        assert_eq!(watch(held, tolerated).has_failed(), failed);
    }

    #[test]
    fn ten_good_signs_compensate_one_failure() {
        let once = |good| counting(5).chain([5]).chain((5..).map(|n| (n % 15 + 1) as u8).take(good));
        let last = |good: usize| once(good).last().into_iter();
        assert!(!watch(once(10).chain(last(10)), 1).has_failed());
        assert!(watch(once(9).chain(last(9)), 1).has_failed());
    }

    #[rstest]
    #[case::never_counted(&[0, 0, 0, 0], false)]
    #[case::wrap(&[14, 15, 1, 2], false)]
    #[case::stopped(&[3, 4, 0, 0], true)]
    #[case::jumped_twice(&[3, 5, 9], true)]
    #[case::backwards(&[3, 2, 1], true)]
    fn sequences(#[case] signs: &[u8], #[case] failed: bool) {
        assert_eq!(watch(signs.iter().copied(), 1).has_failed(), failed);
    }

    #[test]
    fn the_next_good_sign_ends_the_failure() {
        let mut watch = watch([1].into_iter().chain(core::iter::repeat_n(2, 100)), 3);
        assert!(watch.has_failed());
        watch.take(3, 3, &AttachedChecks::default());
        assert!(!watch.has_failed());
        watch.take(3, 3, &AttachedChecks::default());
        assert!(watch.has_failed());
    }

    fn given(counts: LifeSignPace, at: &[u64]) -> Vec<u8> {
        let mut given = EncoderLifeSign::default();
        at.iter().map(|ms| given.advance(Time::from_nanos(ms * 1_000_000), counts, &Attached::NONE)).collect()
    }

    // Kübler Sendix 58xx, 8.2: one increment per send clock of 1 ms, modulo 15, independent of the update time.
    #[rstest]
    #[case::frames(LifeSignPace::EachFrame, &[0, 4, 8, 500], &[1, 2, 3, 4])]
    #[case::send_clocks(LifeSignPace::EachSendClock, &[5, 9, 13, 19, 20, 35, 36], &[1, 5, 9, 15, 1, 1, 2])]
    fn the_encoder_counts(#[case] counts: LifeSignPace, #[case] at: &[u64], #[case] expected: &[u8]) {
        assert_eq!(given(counts, at), expected);
    }
}
