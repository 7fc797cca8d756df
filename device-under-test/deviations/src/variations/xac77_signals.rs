//! What the manual of the XAC77 leaves free in handshakes, positions and velocities.

use crate::tables::Deviation;
use crate::tables::cyclic_state::LastControlWord;
use crate::tables::handshakes::{IN_PROCESS, error_bit_one_frame_late};
use crate::tables::signal_image::{
    ERROR, EXECUTED, PARKED, POSITION, has_error, is_parked, velocity_before, without_transfer,
};
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::velocity::Sampling;
use encoder_profile::encoder::{CountingDirection, MeasuringSettings, Scaling};
use encoder_profile::hooks::EncoderView;
use encoder_profile::profidrive::telegram::{InputSignal, OutputValues, PreviousCycle, SignalImage};

/// Bit 10 of STW2_ENC.
const CONTROL_BY_PLC: u16 = 0x0400;
/// Bit 12 of G1_STW.
const HOME: u16 = 0x1000;

/// Handshakes of the control and status words.
pub static HANDSHAKES: &[Deviation] = permitted! {
    "parks-step-by-step" "On parking, bit 14 is set first, then bit 12 is cleared, then the positions, then bit 13."
        "16.3: the boxes stand one below the other, without frames"
        => |d| {
            let mut parked_for = 0;
            d.encoder.signals(move |before, now| {
                parked_for = if is_parked(&now) { parked_for + 1 } else { 0 };
                parks_step_by_step(parked_for, before, now)
            });
        };
    "positions-before-bit-14" "After parking the positions are refreshed two frames before bit 14 falls."
        "16.3: the refresh stands above the box that clears bit 14"
        => |d| {
            let mut refreshed_for = 0;
            d.encoder.signals(move |before, now| {
                let begins = is_parked(&before.unhooked) && !is_parked(&now) && before.unhooked.good;
                refreshed_for = if begins { 1 } else if refreshed_for > 0 && !is_parked(&now) { refreshed_for + 1 } else { 0 };
                if (1..=2).contains(&refreshed_for) {
                    return SignalImage { g1_zsw: PARKED, ..now };
                }
                refreshed_for = 0;
                now
            });
        };
    "held-preset-renewed-by-parking" "A preset request that is held through parking is carried out again afterwards."
        "16.3: 'restore request'"
        => |d| {
            let mut was_parked = false;
            d.checks.check(move |check, right| match check {
                EncoderCheck::BeginsPreset { now, parked, .. } => {
                    let is_renewed = core::mem::replace(&mut was_parked, parked) && !parked && now.home;
                    right || is_renewed
                }
                _ => right,
            });
        };
    "parked-while-turning" "The encoder parks while the shaft turns."
        "12.3 lists no code 03h, and an encoder has no drive that runs; against 10.1, bit 14"
        => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::Parks { .. }));
    "velocity-goes-on-while-parked" "The velocity is measured while the encoder is parked."
        "16.3 does not name the velocity"
        => |d| d.encoder.image(|view, _, now| SignalImage {
            velocity: if is_parked(&now) { velocity_before(view) } else { now.velocity },
            ..now
        });
    "long-position-goes-on-while-parked" "G1_XIST3 is the position while the encoder is parked."
        "16.3 names G1_XIST1 and G1_XIST2 only"
        => |d| d.encoder.signals(|_, now| SignalImage { g1_xist3: if is_parked(&now) { now.position } else { now.g1_xist3 }, ..now });
    "last-control-word-held" "Without Control by PLC the last valid control word remains in force."
        "10.1, bit 10, and 16.1: 'not valid' does not say whether running requests are dropped"
        => |d| {
            d.encoder.add(LastControlWord::default());
            d.checks.check(|check, right| right || matches!(check, EncoderCheck::ControlByPlc { .. }));
        };
    "control-always-requested" "Bit 9 of ZSW2_ENC is set without compatibility mode, whatever bit 10 of STW2_ENC is."
        "10.1, ZSW2_ENC bit 9: the device asks to be controlled; against the diagram of 16.1"
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::RequestsControl { compatible, .. } => right || !compatible,
            _ => right,
        });
    "held-preset-needs-a-new-edge" "A preset request that is set before Control by PLC has to be set again."
        "7.1.3: what happens to a request that is already set is not said"
        => |d| {
            let mut is_void = false;
            d.encoder.outputs(move |view, _, arrived| held_preset(&mut is_void, view, arrived));
        };
    "presets-wait-for-the-end-of-errors" "While there is an error a preset is neither carried out nor acknowledged."
        "16, Figure 73: whether presets are possible in the state ALARM is not said"
        => |d| {
            let mut is_blocked = false;
            d.checks.check(move |check, right| match check {
                EncoderCheck::CarriesOutPreset { by_request: true, has_error } => {
                    is_blocked = has_error;
                    right && !has_error
                }
                EncoderCheck::AnswersPreset { .. } => right && !core::mem::take(&mut is_blocked),
                _ => right,
            });
        };
    "blocked-preset-not-acknowledged" "With class 4 off a preset request is not acknowledged."
        "11.4: whether bit 12 answers with class 4 off is not said"
        => |d| {
            let mut is_blocked = false;
            d.checks.check(move |check, right| match check {
                EncoderCheck::CarriesOutPreset { by_request: true, .. } => {
                    is_blocked = !right;
                    right
                }
                EncoderCheck::AnswersPreset { .. } => right && !core::mem::take(&mut is_blocked),
                _ => right,
            });
        };
    "error-code-before-its-bit" "An error code appears one frame before bit 15."
        "16.4.1 draws the code above the bit"
        => |d| d.encoder.signals(|before, now| {
            if before.sent.good { error_bit_one_frame_late(before, now) } else { now }
        });
    "error-cleared-step-by-step" "After an acknowledgement G1_XIST2 returns one frame before bit 15 falls."
        "16.4.1 draws G1_XIST2 above bit 15"
        => |d| d.encoder.signals(|before, now| {
            let is_cleared = has_error(&before.unhooked) && !has_error(&now) && !is_parked(&now);
            if is_cleared && now.g1_zsw & IN_PROCESS != 0 {
                SignalImage { g1_zsw: now.g1_zsw & !POSITION | ERROR, ..now }
            } else {
                now
            }
        });
    "error-cleared-with-the-request" "An acknowledgement clears an error whose cause has gone while its request is still set."
        "16.4.1 draws controller and encoder side by side; PROFIdrive has this order"
        => |d| d.encoder.image(error_cleared_with_the_request);
    "transfer-resumes-later" "After an error the transfer of the position resumes two frames later."
        "10.1, G1_ZSW: no frames are given"
        => |d| {
            let mut wait = 0;
            d.encoder.signals(move |before, now| {
                wait = if has_error(&before.unhooked) && !has_error(&now) { 2 } else { u32::saturating_sub(wait, 1) };
                if wait > 0 { without_transfer(now) } else { now }
            });
        };
    "sign-of-life-each-millisecond" "The sign of life of the encoder counts each millisecond."
        "10.1, ZSW2_ENC: how often it counts is not said"
        => |d| d.life_sign.count(|elapsed, _, _| elapsed.as_millis() as u64 + 1);
    "sign-of-life-every-second-frame" "The sign of life of the encoder counts with every second frame."
        "10.1, ZSW2_ENC: how often it counts is not said"
        => |d| d.life_sign.count(|_, frames, _| frames.div_ceil(2));
    "life-sign-failures-counted-slowly" "Of two repeated signs of life in sequence one counts as a failure."
        "11.4: how failures are counted is not said; without isochronous mode controller and encoder have clocks of their own"
        => |d| {
            let mut is_skipped = false;
            d.checks.check(move |check, right| match check {
                EncoderCheck::FollowsLifeSign { last, sign, .. } => {
                    is_skipped = !right && last == sign && !is_skipped;
                    right || is_skipped
                }
                _ => right,
            });
        };
};

/// Positions and velocities.
pub static POSITIONS: &[Deviation] = permitted! {
    "telegram-84-without-position" "In telegram 84 G1_XIST2 is used for error codes only."
        "9.1.4, NOTE: positions in G1_XIST2 are optional"
        => |d| d.encoder.image(|view, _, now| {
            if view.submodules.first().is_some_and(|one| one.telegram.number == 84) { without_transfer(now) } else { now }
        });
    "scaling-rounded-to-nearest" "Scaled positions are rounded to the nearest unit."
        "11.4: how a scaled position is rounded is not said"
        => |d| d.measuring.scale(|scaling, hardware, place| {
            let (units, steps) = (u128::from(scaling.units_per_revolution), u128::from(hardware.steps_per_revolution));
            let all = units * u128::from(hardware.revolutions);
            scaling.within_range((u128::from(place) * units + steps / 2) / steps % all.max(1))
        });
    "velocity-in-hardware-steps" "The velocity counts steps of the hardware, scaled or not."
        "11.4, Velocity measuring units: steps are not defined as scaled or physical"
        => |d| d.telegram.acts_on(|signal, hardware, settings| match signal {
            InputSignal::NistA | InputSignal::NistB => MeasuringSettings { scaling: Scaling::hardware(hardware), ..settings },
            _ => settings,
        });
    "velocity-of-the-shaft" "The sign of the velocity is that of the shaft, whatever the code sequence is."
        "11.4: the sign of the velocity is not given"
        => |d| d.encoder.image(|view, _, now| {
            let reversed = view.measuring.settings.direction == CountingDirection::Counterclockwise;
            SignalImage { velocity: if reversed { -now.velocity } else { now.velocity }, ..now }
        });
    "velocity-of-two-intervals" "The velocity is the mean of the last two intervals of 100 ms."
        "10.1: 'calculated every 100 ms' says nothing about a filter"
        => |d| d.velocity.sampling(|_, right| Sampling { count: right.count * 2, ..right });
    "short-velocity-without-its-lowest-value" "NIST_A is limited to -32767 and 32767."
        "10.1 and 11.4: the overflow of NIST_A is not described"
        => |d| d.encoder.signal(|of, octets| {
            if of.signal == InputSignal::NistA {
                let velocity = of.image.velocity.clamp(-i64::from(i16::MAX), i16::MAX.into());
                *octets = (velocity as u16).to_be_bytes().into();
            }
        });
};

fn parks_step_by_step(parked_for: u32, before: &PreviousCycle, now: SignalImage) -> SignalImage {
    let SignalImage { g1_xist1, g1_xist2, g1_xist3, .. } = before.sent;
    let last = before.sent.g1_zsw & (EXECUTED | POSITION | ERROR);
    match parked_for {
        1 => SignalImage { g1_zsw: now.g1_zsw | last, g1_xist1, g1_xist2, g1_xist3, ..now },
        2 => SignalImage { g1_zsw: now.g1_zsw | last & !EXECUTED, g1_xist1, g1_xist2, g1_xist3, ..now },
        3 => SignalImage { g1_zsw: now.g1_zsw | last & POSITION, ..now },
        _ => now,
    }
}

fn held_preset(is_void: &mut bool, view: &EncoderView<'_>, arrived: OutputValues) -> OutputValues {
    let Some([stw2_enc, g1_stw]) = arrived.words else { return arrived };
    let is_valid = view.user.compatible || stw2_enc & CONTROL_BY_PLC != 0;
    *is_void = g1_stw & HOME != 0 && (*is_void || !is_valid);
    OutputValues { words: Some([stw2_enc, if *is_void { g1_stw & !HOME } else { g1_stw }]), ..arrived }
}

fn error_cleared_with_the_request(view: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
    let is_refused = now.g1_xist2 == 0x0003;
    if !has_error(&now) || now.g1_zsw & IN_PROCESS == 0 || view.faults != 0 || is_refused {
        return now;
    }
    let cleared = SignalImage { g1_zsw: now.g1_zsw & !ERROR, g1_xist2: 0, ..now };
    if now.is_transferred {
        SignalImage { g1_zsw: cleared.g1_zsw | POSITION, g1_xist2: now.position as u32, ..cleared }
    } else {
        cleared
    }
}
