//! The two signs of life: the one that the encoder gives, and the watch over the one of the controller.

use core::time::Duration;
use station::Time;

/// Where bugs can be put into the signs of life.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// The value after this one of the sign of life of the encoder.
    pub next: fn(u8) -> u8,
    /// How many values the sign of life of the encoder has gone on, from the time since its first frame and the number
    /// of frames, that one included.
    pub advances: fn(Duration, u64) -> u64,
    /// Whether the encoder counts while it is parked.
    pub counts_while_parked: bool,
    /// Whether the encoder counts while it shows an error.
    pub counts_with_error: bool,
    /// Whether the encoder counts while a preset is being carried out.
    pub counts_during_preset: bool,
    /// Whether the sign of life of the controller is watched, from whether the manual says so.
    pub is_watched: fn(bool) -> bool,
    /// The sign of life of the controller, in STW2_ENC.
    pub read: fn(u16) -> u8,
    /// Whether the second of two signs of life follows the first.
    pub follows: fn(u8, u8) -> bool,
    /// Whether the controller is watched from this sign of life on.
    pub begins: fn(u8) -> bool,
    /// How many failures are tolerated, from the number that the user has set.
    pub tolerated: fn(u8) -> i32,
    /// What a good sign of life takes off the account, where a failure puts [`FAILURE`] on it.
    pub good: i32,
    /// Whether a good sign of life ends a loss.
    pub recovers: fn(u8) -> bool,
    /// Whether the controller is watched without Control by PLC.
    pub watches_without_control: bool,
    /// Failures that are tolerated without compatibility mode, where the user has set this number.
    pub tolerated_without_compatibility: fn(u8) -> u8,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            next,
            advances: |_, frames| frames,
            counts_while_parked: true,
            counts_with_error: true,
            counts_during_preset: true,
            is_watched: |right| right,
            read: |stw2_enc| (stw2_enc >> 12) as u8,
            follows: |last, sign| sign == next(last),
            begins: |sign| sign != 0,
            tolerated: i32::from,
            good: 1,
            recovers: |_| true,
            watches_without_control: true,
            tolerated_without_compatibility: |_| 1,
        }
    }
}

/// What a failure puts on the account: ten good signs of life make up for it, as PROFIdrive has it.
pub const FAILURE: i32 = 10;

/// The sign of life after this one: 1 to 15 and again from 1; 0 says that nobody counts.
pub fn next(sign: u8) -> u8 {
    sign % 15 + 1
}

/// The sign of life that the encoder gives: 0 before the first frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    sign: u8,
    begin: Option<Time>,
    frames: u64,
    steps: u64,
}

impl Given {
    /// The sign of life of the frame that is sent now; it stands still where it does not count.
    pub fn advance(&mut self, now: Time, counts: bool, rules: &Rules) -> u8 {
        let begin = *self.begin.get_or_insert(now);
        self.frames += 1;
        let steps = (rules.advances)(now.since(begin), self.frames);
        let more = steps.saturating_sub(core::mem::replace(&mut self.steps, steps));
        if counts {
            // As many steps as come back to the same value, whether 0 is left out or not, are none.
            (0..more % (15 * 16)).for_each(|_| self.sign = (rules.next)(self.sign));
        }
        self.sign
    }
}

/// Watches the sign of life of the controller.
///
/// It begins to watch at the first sign that is not 0, since a controller may go without. From then on each frame whose
/// sign is not the next one is a failure. The manuals say how many failures are tolerated and PROFIdrive how they are
/// counted: a failure weighs ten times as much as a good sign of life. The account goes up to just beyond what is
/// tolerated, so that the first good sign after a long failure ends it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch {
    last: u8,
    watching: bool,
    account: i32,
    failed: bool,
}

impl Watch {
    /// Takes the sign of life of one frame, where `tolerated` failures are allowed.
    pub fn take(&mut self, sign: u8, tolerated: i32, rules: &Rules) {
        let last = core::mem::replace(&mut self.last, sign);
        if !self.watching {
            self.watching = (rules.begins)(sign);
            return;
        }
        let limit = tolerated * FAILURE;
        let is_good = (rules.follows)(last, sign) && (!self.failed || (rules.recovers)(sign));
        self.account = match is_good {
            true => (self.account - rules.good).max(0),
            false => (self.account + FAILURE).min(limit.max(0) + 1),
        };
        self.failed = self.account > limit;
    }

    /// Whether there are more failures than are tolerated.
    pub fn has_failed(&self) -> bool {
        self.failed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;
    use rstest::rstest;

    fn watch(signs: impl IntoIterator<Item = u8>, tolerated: i32) -> Watch {
        let mut watch = Watch::default();
        let rules = Rules::default();
        signs.into_iter().for_each(|sign| watch.take(sign, tolerated, &rules));
        watch
    }

    fn counting(n: usize) -> impl Iterator<Item = u8> {
        core::iter::successors(Some(1), |sign| Some(next(*sign))).take(n)
    }

    #[test]
    fn the_count_goes_from_1_to_15_and_never_through_0() {
        assert!(counting(31).eq((1..=15).chain(1..=15).chain([1])));
        assert_eq!(next(0), 1);
    }

    // Catalogue SOL-005 to SOL-007: as many repetitions as are tolerated do no harm, more do.
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
    fn failures_are_forgotten_after_ten_good_signs() {
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
    fn it_recovers_with_the_next_good_sign() {
        let mut watch = watch([1].into_iter().chain(core::iter::repeat_n(2, 100)), 3);
        assert!(watch.has_failed());
        watch.take(3, 3, &Rules::default());
        assert!(!watch.has_failed());
        watch.take(3, 3, &Rules::default());
        assert!(watch.has_failed());
    }

    fn given(rules: &Rules, at: &[u64]) -> Vec<u8> {
        let mut given = Given::default();
        at.iter().map(|ms| given.advance(Time::from_nanos(ms * 1_000_000), true, rules)).collect()
    }

    #[test]
    fn one_step_a_frame() {
        assert_eq!(given(&Rules::default(), &[0, 4, 8, 500]), [1, 2, 3, 4]);
        let mut given = Given::default();
        let counts = [true, false, false, true].map(|counts| given.advance(Time::ZERO, counts, &Rules::default()));
        assert_eq!(counts, [1, 1, 1, 2]);
    }

    // Kübler Sendix 58xx: one step per send clock of 1 ms, modulo 15, whatever the update time.
    #[test]
    fn one_step_a_send_clock() {
        let rules = Rules { advances: |elapsed, _| elapsed.as_millis() as u64 + 1, ..Rules::default() };
        assert_eq!(given(&rules, &[5, 9, 13, 19, 20, 35, 36]), [1, 5, 9, 15, 1, 1, 2]);
    }
}
