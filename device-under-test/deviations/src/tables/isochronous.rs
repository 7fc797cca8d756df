//! Bugs of isochronous operation: the clock of the bus and the two signs of life.

use super::Deviation;
use super::sensor_memory::as_set;
use core::time::Duration;
use encoder_profile::checks::Check;
use reference_devices::models::sick_a3m60::Wrong;
use reference_devices::models::sick_a3m60::knobs::{Times, Words};
use station::Time;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Clock
    "never-synchronised" "The encoder never gets in step with the clock."
        => |b| b.a3m60.synchronizes = false;
    "time-base-of-the-block-misread" "The time base is read in microseconds."
        => |b| b.a3m60.times = |times| times.map(|times| Times { cycle: times.cycle * 12, ..times });
    "cycle-of-1-ms-only" "Each other cycle than 1 ms is a deviating clock."
        => |b| b.a3m60.wrong = |right, times| Wrong { is_deviating: right.is_deviating || times.is_some_and(|times| times.cycle != Duration::from_millis(1)), ..right };
    "any-cycle-accepted" "Any cycle of the clock is taken."
        => |b| b.a3m60.judges_cycle = |_| true;
    "free-runs-without-notice" "A missing clock is not noticed."
        => |b| b.a3m60.misses = |_| None;
    "missing-clock-never-told" "Bit 5 of P1001 is never set."
        => |b| b.a3m60.words = |known| Words { b: known.words.b & !0x20, ..known.words };
    "deviating-clock-as-missing" "A deviating clock is told as a missing one."
        => |b| b.a3m60.wrong = |right, _| Wrong { is_missing: right.is_missing || right.is_deviating, is_deviating: false };
    "synchronisation-codes-exchanged" "The codes of a missing and of a deviating clock are exchanged."
        => |b| b.at_encoder.code(|error| match error.code { Some(0x0F03) => Some(0x0F04), Some(0x0F04) => Some(0x0F03), other => other });
    "bus-status-bits-exchanged" "Bits 5 and 6 of P1001 are exchanged."
        => |b| b.a3m60.words = |known| Words { b: known.words.b & !0x60 | (known.words.b & 0x20) << 1 | (known.words.b & 0x40) >> 1, ..known.words };
    "inner-state-in-bus-status" "Bit 0 of P1001 is set in isochronous operation."
        => |b| b.a3m60.words = |known| Words { b: known.words.b | u16::from(known.is_isochronous), ..known.words };
    "only-power-off-helps" "Errors of the clock and of the sign of life never go."
        => |b| {
            b.a3m60.recovers = |wrong| wrong == Wrong::default();
            b.checks.check(|check, right| right && !matches!(check, Check::FollowsLifeSign { has_failed: true, .. }));
        };
    "simulated-clock-ignored" "The clock is never simulated."
        => |b| b.a3m60.times = |times| times.map(|times| Times { is_simulated: false, ..times });
    "samples-averaged-in-isochronous-mode" "The position is the mean of several samples in isochronous operation too."
        => |b| (b.a3m60.samples, b.a3m60.samples_at_clock) = (|count, _| count, false);
    "sampled-beside-the-clock" "The position is taken each 1.3 ms, whatever the clock says."
        => |b| (b.a3m60.samples_at_clock, b.a3m60.looks_at) = (false, |now: Time| Time::from_nanos(now.as_nanos() / 1_300_000 * 1_300_000));
    "acyclic-access-disturbs-the-clock" "Each parameter request makes the next clock a missing one."
        => |b| b.a3m60.requests_disturb_clock = true;

    // Sign of life of the master
    "controller-sign-of-life-in-bits-8-to-11" "The sign of life of the master is looked for in bits 8 to 11."
        => |b| b.at_encoder.control_words(|_, [a, b]| [a & 0x0FFF | (a & 0x0F00) << 4, b]);
    "life-sign-starts-with-1-only" "After a loss the sign of life of the master counts from 1 on only."
        => |b| b.checks.check(|check, right| match check {
            Check::FollowsLifeSign { sign, has_failed: true, .. } => right && sign == 1,
            _ => right,
        });
    "life-sign-wrap-is-failure" "A 0 is expected behind 15, so that both 15 and 1 are followed by a failure."
        => |b| b.checks.check(|check, right| match check {
            Check::FollowsLifeSign { last, sign, .. } => last != 1 && sign == last + 1,
            _ => right,
        });
    "zero-life-sign-accepted" "A sign of life of 0 is never a failure."
        => |b| b.checks.check(|check, right| match check {
            Check::FollowsLifeSign { last, sign, .. } => right || sign == 0 || last == 0,
            _ => right,
        });
    "tolerance-without-compatibility-mode" "The tolerance that is set holds without compatibility mode too."
        => |b| {
            b.life_sign.tolerated(as_set);
            b.at_encoder.element(|view, at, right| if at.0 == 925 { view.user.life_sign_failures.into() } else { right });
        };
    "single-failure-is-error" "Without compatibility mode no failure is tolerated."
        => |b| {
            b.life_sign.tolerated(|user, right| if user.compatible { right } else { 0 });
            b.at_encoder.element(|view, at, right| if at.0 == 925 && !view.user.compatible { 0 } else { right });
        };
    "life-sign-tolerance-ignored" "One failure is tolerated, whatever is set."
        => |b| b.life_sign.tolerated(|_, _| 1);
    "tolerance-of-4-bits" "Of the tolerance the lower four bits count, and any number is taken."
        => |b| {
            b.checks.check(|check, right| right || matches!(check, Check::ToleranceIsRight(_)));
            b.life_sign.tolerated(|_, right| right & 15);
        };
    "life-sign-error-not-told" "Bit 4 of P1001 is never set."
        => |b| b.a3m60.words = |known| Words { b: known.words.b & !0x10, ..known.words };
    "error-code-octets-swapped" "The octets of the code of a lost sign of life are exchanged."
        => |b| b.at_encoder.code(|error| error.code.map(|code| if code == 0x0F02 { code.swap_bytes() } else { code }));

    // Sign of life of the encoder
    "sign-of-life-free-running" "The sign of life of the encoder counts without isochronous operation too."
        => |b| b.a3m60.gives_sign_of_life = |is_isochronous, is_synchronized, _| is_synchronized || !is_isochronous;
    "sign-of-life-before-synchronisation" "The sign of life of the encoder counts before it is in step."
        => |b| b.a3m60.gives_sign_of_life = |is_isochronous, _, _| is_isochronous;
    "sign-of-life-counts-frames" "The sign of life of the encoder counts each 5 ms."
        => |b| b.life_sign.count(|elapsed, _, _| elapsed.as_millis() as u64 / 5 + 1);
    "sign-of-life-at-half-rate" "The sign of life of the encoder counts each second cycle."
        => |b| b.life_sign.count(|_, frames, _| frames.div_ceil(2));
    "sign-of-life-goes-on-without-clock" "The sign of life of the encoder counts on when the clock is lost."
        => |b| b.a3m60.gives_sign_of_life = |is_isochronous, is_synchronized, is_lost| is_isochronous && (is_synchronized || is_lost);
};
