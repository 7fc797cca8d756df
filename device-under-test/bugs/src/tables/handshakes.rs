//! Deviations of parking, errors and their acknowledgement.

use super::cyclic_state::{
    ForgottenInPark, KeptAnswer, KeptErrors, NoPresetsAfterParking, OneAcknowledgement, RememberedControl,
};
use super::signal_image::{
    ERROR, EXECUTED, PARKED, POSITION, has_error, is_executed, is_lost, is_parked, velocity_before, without_transfer,
};
use super::{Deviation, Group};
use crate::needs::Need;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::hooks::EncoderView;
use encoder_profile::profidrive::telegram::{OutputWord, PreviousCycle, SignalImage};
use reference_devices::manuals;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    Group { needs: &[Need::Output(OutputWord::G1Stw)], deviations: HANDSHAKES },
    Group { needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)], deviations: OF_THE_SENDIX },
];

/// The deviations of every sensor interface.
static HANDSHAKES: &[Deviation] = bugs! {
    // Parking
    "park-clears-position-first" "Positions are 0 one frame before the status bits change."
        => |d| d.encoder.signals(park_clears_position_first);
    "parking-ignored" "A request to park has no effect."
        => |d| d.encoder.control_words(|_, [a, b]| [a, b & !PARKED]);
    "park-never-ends" "The encoder stays parked when the request is withdrawn."
        => |d| d.encoder.signals(park_never_ends);
    "velocity-halved-while-parked" "While parked the velocity is half of the measured one."
        => |d| d.encoder.image(|view, _, now| SignalImage { velocity: if is_parked(&now) { velocity_before(view) / 2 } else { now.velocity }, ..now });
    "absolute-value-lost-in-park" "After parking the position has to be requested again."
        => |d| d.encoder.signals(absolute_value_lost_in_park);
    "unpark-status-first" "The parked bit is cleared one frame before the position is updated."
        => |d| d.encoder.signals(unpark_status_first);
    "park-keeps-preset-bit" "The acknowledgement of a preset stays set while parked."
        => |d| d.encoder.image(park_keeps_preset_bit);
    "park-freezes-position" "G1_XIST1 and G1_XIST3 keep their last value while parked."
        => |d| d.encoder.signals(park_freezes_position);
    "errors-while-parked" "New errors are raised while parked."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::RaisesError { .. } => true,
            _ => right,
        });
    "error-survives-parking" "Parking does not clear an error."
        => |d| d.checks.set(EncoderCheck::ParkingClearsErrors, false);
    "park-wipes-persistent-error" "An error whose cause is still present is not raised again after parking."
        => |d| d.checks.add(ForgottenInPark::default());
    "preset-while-parked" "A preset is carried out while parked."
        => |d| d.checks.check(presets_while_parked);
    "parked-bit-never-set" "Bit 14 of G1_ZSW is never set."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw & !PARKED, ..now });
    "parked-bit-is-a-pulse" "Bit 14 of G1_ZSW is set for one frame only."
        => |d| d.encoder.signals(|before, now| SignalImage { g1_zsw: now.g1_zsw & !(before.unhooked.g1_zsw & PARKED), ..now });
    "transfer-goes-on-while-parked" "G1_XIST2 follows the position while parked."
        => |d| d.encoder.signals(transfer_goes_on_while_parked);
    "long-position-all-ones-while-parked" "All bits of G1_XIST3 are 1 while parked."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_xist3: if is_parked(&now) { u64::MAX } else { now.g1_xist3 }, ..now });
    "half-parked-without-control" "Without Control by PLC the parked bit is cleared and the positions stay 0."
        => |d| d.encoder.signals(half_parked_without_control);
    "sensor-loss-latched-while-parked" "A sensor that is removed while parked raises an error."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::RaisesError { code: Some(0x0001), .. } => true,
            _ => right,
        });
    "no-presets-after-parking" "Presets are ignored after the encoder has been parked."
        => |d| d.encoder.add(NoPresetsAfterParking::default());
    "parking-code-wrong" "Refused parking has the error code 0001h."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_xist2: if has_error(&now) && now.g1_xist2 == 0x0003 { 0x0001 } else { now.g1_xist2 }, ..now });
    "parking-refused-with-error" "Parking is refused while there is an error."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::Parks { has_error: true, .. } => false,
            _ => right,
        });

    // Errors and their acknowledgement
    "error-without-code" "G1_XIST2 keeps the position while bit 15 shows an error."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_xist2: if has_error(&now) { now.position as u32 } else { now.g1_xist2 }, ..now });
    "error-code-without-bit" "G1_XIST2 contains an error code while bit 15 is 0."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw & !ERROR, ..now });
    "error-code-one-frame-late" "The error code is set one frame after its bit."
        => |d| d.encoder.signals(error_code_one_frame_late);
    "code-mixed-with-position" "G1_XIST2 contains the error code combined with the position."
        => |d| d.encoder.signals(code_mixed_with_position);
    "position-before-error" "A requested position takes precedence over an error."
        => |d| d.encoder.signals(position_before_error);
    "persistent-error-not-cyclic" "Memory and parameter faults are shown only in P65001."
        => |d| d.encoder.signals(|_, now| if is_persistent(&now) { without_error(now) } else { now });
    "acknowledgement-ignored" "An acknowledgement request has no effect."
        => |d| d.encoder.control_words(|_, [a, b]| [a, b & !ERROR]);
    "acknowledge-answer-is-a-pulse" "Bit 11 of G1_ZSW is set for one frame only."
        => |d| d.encoder.signals(|before, now| SignalImage { g1_zsw: now.g1_zsw & !(before.unhooked.g1_zsw & IN_PROCESS), ..now });
    "failed-acknowledgement-not-answered" "Bit 11 of G1_ZSW is not set if the error persists."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw & if is_persistent(&now) { !IN_PROCESS } else { !0 }, ..now });
    "code-stays-after-acknowledgement" "G1_XIST2 keeps the error code after the acknowledgement."
        => |d| d.encoder.signals(code_stays_after_acknowledgement);
    "error-bit-stays" "Bit 15 of G1_ZSW stays set after the code has been cleared."
        => |d| d.encoder.signals(|before, now| SignalImage { g1_zsw: now.g1_zsw | before.sent.g1_zsw & ERROR, ..now });
    "error-again-after-acknowledgement" "The end of an acknowledgement raises the error again."
        => |d| d.encoder.signals(error_again_after_acknowledgement);
    "only-first-acknowledgement" "After a failed acknowledgement no other one is answered."
        => |d| d.encoder.add(OneAcknowledgement::default());
    "faults-survive-restart" "Errors survive a new connection and a loss of power."
        => |d| d.encoder.add(KeptErrors::default());
    "acknowledge-clears-persistent" "Acknowledging clears an error whose cause is still present."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::ClearsError { .. } => true,
            _ => right,
        });
    "sensor-error-drops-for-a-frame" "The error bit is 0 for one frame during an acknowledgement."
        => |d| d.encoder.signals(sensor_error_drops_for_a_frame);
    "error-bit-one-frame-late" "The error bit is set one frame after its code."
        => |d| d.encoder.signals(error_bit_one_frame_late);
    "acknowledge-without-answer" "Bit 11 of G1_ZSW is never set."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw & !IN_PROCESS, ..now });
    "acknowledge-answer-stays" "Bit 11 of G1_ZSW is never cleared."
        => |d| d.encoder.signals(|before, now| SignalImage { g1_zsw: now.g1_zsw | before.sent.g1_zsw & IN_PROCESS, ..now });
    "acknowledge-answer-ends-first" "Bit 11 of G1_ZSW is cleared one frame before the error."
        => |d| d.encoder.signals(acknowledge_answer_ends_first);
    "acknowledge-answer-without-request" "Bit 11 of G1_ZSW is set with each error."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw | if has_error(&now) { IN_PROCESS } else { 0 }, ..now });
    "acknowledge-stops-transfer" "An acknowledgement without an error ends the transfer of the position."
        => |d| d.encoder.signals(|_, now| if now.request.acknowledge { without_transfer(now) } else { now });
    "stw2-bit-7-acknowledges" "Bit 7 of STW2_ENC acknowledges errors."
        => |d| d.encoder.control_words(|_, [a, b]| [a, b | (a & 0x0080) << 8]);
    "error-clears-itself" "A latched error is cleared together with its cause."
        => |d| d.checks.check(|check, right| match check {
            EncoderCheck::LatchesError { .. } => false,
            _ => right,
        });
    "error-needs-request" "The error code is shown only while the position is requested."
        => |d| d.encoder.signals(error_needs_request);
    "life-sign-shown-as-bus-cycle" "A failed sign of life has the error code of a missed bus cycle."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_xist2: if has_error(&now) && now.g1_xist2 == 0x0F02 { 0x0F04 } else { now.g1_xist2 }, ..now });
};

/// The deviations of an encoder whose errors are not latched and whose positions are frozen by parking.
static OF_THE_SENDIX: &[Deviation] = bugs! {
    "parked-positions-disagree" "The plain position follows the shaft while parked; its single-turn and multi-turn parts are frozen."
        => |d| d.encoder.signals(|_, now| if is_parked(&now) { SignalImage { plain_position: now.position as u32, ..now } } else { now });
    "acknowledge-answered-without-error" "Bit 11 of G1_ZSW follows bit 15 of G1_STW, with or without an error."
        => |d| d.encoder.signals(acknowledge_answered);
    "xist1-zero-with-error" "G1_XIST1 is 0 while there is an error."
        => |d| d.encoder.signals(|_, now| SignalImage { g1_xist1: if has_error(&now) { 0 } else { now.g1_xist1 }, ..now });
    "control-remembered" "For a second after bad outputs Control by PLC keeps its value from before."
        => |d| d.encoder.add(RememberedControl::default());
    "confirmation-kept-over-link-loss" "Bit 12 of G1_ZSW stays set in the next connection if it was set at the end of a connection."
        => |d| d.encoder.add(KeptAnswer::default());
};

fn acknowledge_answered(_: &PreviousCycle, now: SignalImage) -> SignalImage {
    SignalImage { g1_zsw: now.g1_zsw & !IN_PROCESS | if now.request.acknowledge { IN_PROCESS } else { 0 }, ..now }
}

/// Bit 11 of G1_ZSW: an acknowledgement is in process.
pub const IN_PROCESS: u16 = 0x0800;

/// Carries out and answers presets, parked or not.
pub fn presets_while_parked(check: EncoderCheck, right: bool) -> bool {
    match check {
        EncoderCheck::BeginsPreset { before, now, .. } => now.home && !before.home,
        EncoderCheck::AnswersPreset { carried_out, requested, .. } => carried_out && requested,
        _ => right,
    }
}

fn park_keeps_preset_bit(view: &EncoderView<'_>, before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if is_executed(&before.sent) && now.request.home && view.next_offset.is_none() {
        SignalImage { g1_zsw: now.g1_zsw | EXECUTED, ..now }
    } else {
        now
    }
}

fn without_positions(image: SignalImage) -> SignalImage {
    SignalImage { g1_xist1: 0, g1_xist2: 0, g1_xist3: 0, ..image }
}

fn park_clears_position_first(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if is_parked(&now) && !is_parked(&before.unhooked) {
        without_positions(SignalImage { g1_zsw: before.unhooked.g1_zsw, ..now })
    } else {
        now
    }
}

fn unpark_status_first(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if !is_parked(&now) && is_parked(&before.unhooked) { without_positions(now) } else { now }
}

fn park_freezes_position(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if is_parked(&now) {
        SignalImage { g1_xist1: before.sent.g1_xist1, g1_xist3: before.sent.g1_xist3, ..now }
    } else {
        now
    }
}

fn sensor_error_drops_for_a_frame(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if before.unhooked.g1_zsw & !now.g1_zsw & IN_PROCESS != 0 {
        SignalImage { g1_zsw: now.g1_zsw & !ERROR, ..now }
    } else {
        now
    }
}

fn acknowledge_answer_ends_first(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    let is_answered = (before.unhooked.g1_zsw | now.g1_zsw) & IN_PROCESS != 0;
    if is_answered && has_error(&before.sent) && !has_error(&now) {
        SignalImage { g1_zsw: now.g1_zsw & !POSITION | ERROR, g1_xist2: before.sent.g1_xist2, ..now }
    } else {
        now
    }
}

/// Sets the error bit one frame after its code.
pub fn error_bit_one_frame_late(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if has_error(&now) && !has_error(&before.unhooked) {
        SignalImage { g1_zsw: now.g1_zsw & !ERROR, ..now }
    } else {
        now
    }
}

fn absolute_value_lost_in_park(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if is_lost(before) && !has_error(&before.unhooked) { without_transfer(now) } else { now }
}

fn error_needs_request(_: &PreviousCycle, now: SignalImage) -> SignalImage {
    if has_error(&now) && !now.is_transferred { SignalImage { g1_xist2: 0, ..now } } else { now }
}

fn park_never_ends(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if is_parked(&before.sent) { without_positions(SignalImage { g1_zsw: PARKED, ..now }) } else { now }
}

fn transfer_goes_on_while_parked(_: &PreviousCycle, now: SignalImage) -> SignalImage {
    if is_parked(&now) && now.is_transferred {
        SignalImage { g1_zsw: now.g1_zsw | POSITION, g1_xist2: now.position as u32, ..now }
    } else {
        now
    }
}

fn half_parked_without_control(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    let was_parked = is_parked(&before.unhooked) || before.sent.good && before.sent.g1_xist1 == 0;
    if now.outputs[0] & 0x0400 == 0 && was_parked { without_positions(SignalImage { g1_zsw: 0, ..now }) } else { now }
}

fn error_code_one_frame_late(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if has_error(&now) && !has_error(&before.unhooked) {
        SignalImage { g1_xist2: before.sent.g1_xist2, ..now }
    } else {
        now
    }
}

fn code_mixed_with_position(_: &PreviousCycle, now: SignalImage) -> SignalImage {
    if has_error(&now) && now.is_transferred {
        SignalImage { g1_xist2: now.g1_xist2 | now.position as u32, ..now }
    } else {
        now
    }
}

fn without_error(image: SignalImage) -> SignalImage {
    SignalImage { g1_zsw: image.g1_zsw & !ERROR, g1_xist2: 0, ..image }
}

fn position_before_error(_: &PreviousCycle, now: SignalImage) -> SignalImage {
    if has_error(&now) && now.is_transferred {
        SignalImage { g1_zsw: now.g1_zsw & !ERROR | POSITION, g1_xist2: now.position as u32, ..now }
    } else {
        now
    }
}

/// Codes from 1000h on are those of the manuals; 0020h is a memory error.
fn is_persistent(image: &SignalImage) -> bool {
    has_error(image) && (image.g1_xist2 >= 0x1000 || image.g1_xist2 == 0x0020)
}

fn code_stays_after_acknowledgement(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    let shows_code = has_error(&before.unhooked) || before.sent.g1_xist2 != before.unhooked.g1_xist2;
    if shows_code && !has_error(&now) && !is_parked(&now) {
        SignalImage { g1_xist2: before.sent.g1_xist2, ..now }
    } else {
        now
    }
}

fn error_again_after_acknowledgement(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    let ends = before.unhooked.g1_zsw & !now.g1_zsw & IN_PROCESS != 0;
    let goes_on = has_error(&before.sent) && !has_error(&before.unhooked);
    if (ends || goes_on) && !has_error(&now) && !is_parked(&now) {
        SignalImage { g1_zsw: now.g1_zsw & !POSITION | ERROR, g1_xist2: 0x0F02, ..now }
    } else {
        now
    }
}
