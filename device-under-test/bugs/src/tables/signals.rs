//! Bugs of telegrams, their signals, Control by PLC and signs of life.

use super::Group;
use super::cyclic_state::{LifeSignFailures, SignOfLifeDeviation, as_set};
use super::signal_image::{ERROR, PARKED, POSITION, has_error, has_position, is_lost, is_parked, without_transfer};
use crate::needs::Need;
use crate::seams::encoder::SentSignal;
use alloc::vec::Vec;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::{MeasuringSettings, Scaling};
use encoder_profile::hooks::{EncoderView, SubmoduleInputs};
use encoder_profile::profidrive::sensor::SensorError;
use encoder_profile::profidrive::telegram::{
    self, InputSignal, OutputValues, OutputWord, PreviousCycle, SignalImage, Telegram,
};
use reference_devices::manuals;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    // Control words, status words and the sign of life of the encoder
    Group {
        needs: &[Need::Output(OutputWord::Stw2Enc)],
        deviations: bugs! {
            "control-words-swapped" "STW2_ENC and G1_STW are swapped on reception."
                => |d| d.encoder.control_words(|_, [a, b]| [b, a]);
            "position-little-endian" "The positions are sent least significant byte first."
                => |d| d.encoder.signal(|of, octets| if is_position(of.signal) { octets.reverse() });
            "inputs-padded-to-four" "The inputs are padded to a multiple of four bytes."
                => |d| d.encoder.input_octets(|_, right| right.next_multiple_of(4));
            "gray-code" "Positions are sent in Gray code."
                => |d| d.encoder.signals(|_, now| each_position(now, |position| position ^ position >> 1));
            "position-left-aligned" "Positions are left-aligned in their signal."
                => |d| d.encoder.signals(|_, now| each_position(now, |position| position << 2));
            "control-by-plc-not-noticed" "Only the low byte of STW2_ENC is used, so Control by PLC is ignored."
                => |d| d.encoder.control_words(|_, [a, b]| [a & 0x00FF, b]);
            "control-word-bytes-swapped" "The bytes of G1_STW are swapped."
                => |d| d.encoder.control_words(|_, [a, b]| [a, b.swap_bytes()]);
            "status-word-bytes-swapped" "The bytes of G1_ZSW are swapped."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw.swap_bytes(), ..now });
            "inputs-bad-with-sensor-error" "The provider status is bad during a sensor error."
                => |d| d.encoder.signals(|_, now| SignalImage { good: !has_error(&now), ..now });
            "reserved-bit-acts" "The reserved bit 10 of G1_STW parks the encoder, like bit 14."
                => |d| d.encoder.control_words(|_, [a, b]| [a, b | (b & 0x0400) << 4]);
            "reference-search-starts" "Bits 0 to 3 of G1_STW start a search for the home position."
                => |d| d.encoder.control_words(|_, [a, b]| [a, if b & 0x000F == 0 { b } else { b | 0x1000 }]);
            "not-used-bits-mirrored" "Bits 0 to 10 of G1_STW are mirrored in G1_ZSW."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw | now.outputs[1] & 0x07FF, ..now });
            "internal-state-in-status-word" "The reserved bits 0, 4 and 11 of ZSW2_ENC are set while the encoder is parked."
                => |d| d.encoder.signals(|_, now| SignalImage { zsw2_enc: now.zsw2_enc | if is_parked(&now) { 0x0811 } else { 0 }, ..now });
            "status-bit-3-shows-error" "The unused bit 3 of ZSW2_ENC is set during an error."
                => |d| d.encoder.signals(|_, now| SignalImage { zsw2_enc: now.zsw2_enc | if has_error(&now) { 0x0008 } else { 0 }, ..now });
            "control-by-plc-ignored" "G1_STW is obeyed without Control by PLC."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::ControlByPlc { .. } => true,
                    _ => right,
                });
            "control-by-plc-needed-in-compatibility-mode" "Control by PLC is required even in compatibility mode."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::ControlByPlc { set, .. } => set,
                    _ => right,
                });
            "control-requested-never-set" "Bit 9 of ZSW2_ENC is always 0."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::RequestsControl { .. } => false,
                    _ => right,
                });
            "control-requested-follows-control" "Bit 9 of ZSW2_ENC follows Control by PLC, whatever the mode."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::RequestsControl { set, .. } => set,
                    _ => right,
                });
            "control-requested-latches" "Bit 9 of ZSW2_ENC stays set after it was set."
                => |d| d.encoder.signals(|before, now| SignalImage { zsw2_enc: now.zsw2_enc | before.sent.zsw2_enc & 0x0200, ..now });
            "control-by-plc-inverted" "G1_STW is obeyed while Control by PLC is 0, and ignored while it is 1."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::ControlByPlc { compatible, set } => compatible || !set,
                    _ => right,
                });
            "control-valid-for-a-frame" "G1_STW is obeyed only in the first frame of Control by PLC."
                => |d| d.checks.check(control_since(|compatible, was_set, set| compatible || set && !was_set));
            "inputs-freeze-without-control" "The inputs are frozen while Control by PLC is 0."
                => |d| d.encoder.signals(inputs_freeze_without_control);
            "sign-of-life-in-low-nibble" "The sign of life of the encoder is in bits 0 to 3."
                => |d| d.encoder.signals(|_, now| SignalImage { zsw2_enc: now.zsw2_enc & 0x0FFF | now.zsw2_enc >> 12, ..now });
            "sign-of-life-constant-0" "The sign of life of the encoder is always 0."
                => |d| d.encoder.signals(|_, now| SignalImage { zsw2_enc: now.zsw2_enc & 0x0FFF, ..now });
            "sign-of-life-stands-still" "The sign of life of the encoder is always 3."
                => |d| d.encoder.add(SignOfLifeDeviation::by(|_| 3));
            "sign-of-life-through-zero" "The sign of life counts from 0 to 15."
                => |d| d.encoder.add(SignOfLifeDeviation::by(|sign| (sign + 1) % 16));
            "sign-of-life-stops-in-park" "The sign of life of the encoder is frozen while it is parked."
                => |d| d.encoder.add(SignOfLifeDeviation::counting_while(|_, now| !is_parked(now)));
            "sign-of-life-stops-on-error" "The sign of life of the encoder is frozen during an error."
                => |d| d.encoder.add(SignOfLifeDeviation::counting_while(|_, now| !has_error(now)));
            "sign-of-life-stops-during-preset" "The sign of life of the encoder is frozen during a preset."
                => |d| d.encoder.add(SignOfLifeDeviation::counting_while(|view, _| view.next_offset.is_none()));
        },
    },
    // The Sendix, whose manual differs from the profile
    Group {
        needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)],
        deviations: bugs! {
            "sign-of-life-at-half-rate" "The sign of life changes only with every second send clock."
                => |d| d.life_sign.count(|elapsed, _, _| (elapsed.as_micros() as u64 + 500) / 2000 + 1);
            "sign-of-life-counts-frames" "The sign of life counts frames instead of send clocks."
                => |d| d.life_sign.count(|_, frames, _| frames);
            "position-needs-request" "G1_XIST2 shows the position only while it is requested."
                => |d| d.encoder.signals(|_, now| if now.request.absolute { now } else { without_transfer(now) });
            "compatibility-mode-works" "G1_STW is obeyed without Control by PLC in compatibility mode."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::ControlByPlc { compatible, set } => compatible || set,
                    _ => right,
                });
            "fault-present-never-set" "Bit 3 of ZSW2_ENC is never set."
                => |d| d.encoder.signals(|_, now| SignalImage { zsw2_enc: now.zsw2_enc & !0x0008, ..now });
        },
    },
    // The same on PROFINET; the A3M60 has other bugs with these names
    Group {
        needs: &[Need::Profinet, Need::Output(OutputWord::Stw2Enc)],
        deviations: bugs! {
            "reserved-stw2-bits-act" "Each reserved bit of STW2_ENC takes control away from the PLC."
                => |d| d.encoder.control_words(|_, [a, b]| [if a & 0x0B7F == 0 { a } else { a & !0x0400 }, b]);
            "status-bit-10-shows-motion" "The reserved bit 10 of G1_ZSW is set while the shaft turns."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw | if now.velocity == 0 { 0 } else { 0x0400 }, ..now });
        },
    },
    // The sign of life of the controller, if it is monitored
    Group {
        needs: &[Need::WatchedController],
        deviations: bugs! {
            "controller-sign-of-life-in-low-nibble" "The sign of life of the controller is read from bits 0 to 3."
                => |d| d.encoder.control_words(|_, [a, b]| [a & 0x0FFF | a << 12, b]);
            "sign-of-life-not-watched" "The sign of life of the controller is not monitored."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::MonitorsController { .. } => false,
                    _ => right,
                });
            "life-sign-ends-at-14" "The sign of life of the controller is expected to wrap from 14 to 1."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::FollowsLifeSign { last, sign, .. } => sign == last % 14 + 1,
                    _ => right,
                });
            "tolerance-ignored" "One failure is tolerated, whatever byte 17 of the start-up record is."
                => |d| d.life_sign.tolerated(|_, _| 1);
            "life-sign-error-not-acknowledged" "Only a restart clears the sign of life error."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::ClearsError { code: Some(0x0F02), .. } => false,
                    _ => right,
                });
            "missing-synchronization-is-error" "A bus cycle that is not synchronized raises an error."
                => |d| d.encoder.causes(|_, right| right.into_iter().chain([SensorError::of(0x0F04)]).collect());
            "zero-life-sign-is-failure" "A controller whose sign of life is always 0 raises an error."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::StartsMonitoring { .. } => true,
                    _ => right,
                });
            "life-sign-tolerance-off-by-one" "The error comes one failure too early."
                => |d| d.life_sign.tolerated(|_, right| right - 1);
            "life-sign-255-is-minus-one" "A tolerance of 255 is treated as -1."
                => |d| d.life_sign.tolerated(|_, right| (right as i8).into());
            "life-sign-failures-add-up" "The count of tolerated failures is never reset."
                => |d| {
                    let failures = LifeSignFailures::default();
                    d.checks.add(failures.clone());
                    d.life_sign.tolerated(move |_, right| failures.tolerated(right));
                };
            "life-sign-needs-control" "The sign of life of the controller is monitored only under Control by PLC."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::MonitorsController { has_control: false, .. } => false,
                    _ => right,
                });
            "life-sign-tolerance-in-v41-mode" "Byte 17 of the start-up record is used even without compatibility mode."
                => |d| d.life_sign.tolerated(as_set);
        },
    },
    Group {
        needs: &[Need::Profinet, Need::WatchedController],
        deviations: bugs! {
            "life-sign-wrap-is-failure" "The step from 15 to 1 counts as a failure."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::FollowsLifeSign { last, sign, .. } => sign == last + 1,
                    _ => right,
                });
        },
    },
    // G1_XIST1 and G1_XIST2
    Group {
        needs: &[Need::Input(InputSignal::G1Xist2)],
        deviations: bugs! {
            "positions-swapped" "G1_XIST1 and G1_XIST2 are swapped in telegrams 81 to 83."
                => |d| d.encoder.order(positions_swapped);
            "error-code-in-upper-word" "Error codes are in the upper half of G1_XIST2."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_xist2: if has_error(&now) { now.g1_xist2 << 16 } else { now.g1_xist2 }, ..now });
            "telegram-81-with-velocity" "Telegram 81 ends with NIST_A, like telegram 82."
                => |d| {
                    d.encoder.input_octets(with_velocity_octets);
                    d.encoder.order(with_velocity);
                };
            "error-code-for-status-word" "An error code is sent instead of G1_ZSW."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: if has_error(&now) { now.g1_xist2 as u16 } else { now.g1_zsw }, ..now });
            "position-of-24-bits" "G1_XIST1 has only 24 bits."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_xist1: now.g1_xist1 & 0x00FF_FFFF, ..now });
            "xist2-of-16-bits" "G1_XIST2 has only 16 bits, without revolutions."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_xist2: now.g1_xist2 & 0xFFFF, ..now });
            "xist1-needs-request" "G1_XIST1 is 0 unless the position is requested in G1_XIST2."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_xist1: if now.is_transferred { now.g1_xist1 } else { 0 }, ..now });
            "xist2-with-fine-bits" "The position in G1_XIST2 is shifted by three bits for a fine resolution."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_xist2: if has_position(&now) { now.g1_xist2 << 3 } else { now.g1_xist2 }, ..now });
            "xist1-shows-error" "The error code is also in G1_XIST1."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_xist1: if has_error(&now) { now.g1_xist2 } else { now.g1_xist1 }, ..now });
            "xist2-always-shows-position" "G1_XIST2 shows the position although it is not requested."
                => |d| d.encoder.signals(xist2_always_shows_position);
            "xist2-keeps-last-value" "G1_XIST2 keeps its last value when neither position nor error is shown."
                => |d| d.encoder.signals(xist2_keeps_last_value);
            "xist2-only-at-the-edge" "G1_XIST2 is updated only once, at the request."
                => |d| d.encoder.signals(xist2_only_at_the_edge);
            "position-bit-before-position" "Bit 13 of G1_ZSW is set one frame before G1_XIST2 has the position."
                => |d| d.encoder.signals(position_bit_before_position);
            "transfer-needs-preset" "The position is transferred in G1_XIST2 only while a preset is requested too."
                => |d| d.encoder.control_words(|_, [a, b]| [a, if b & 0x1000 == 0 { b & !POSITION } else { b }]);
            "xist2-one-frame-late" "G1_XIST2 shows the position of the previous frame."
                => |d| d.encoder.signals(xist2_one_frame_late);
            "absolute-value-not-served" "The request for the position in G1_XIST2 has no effect."
                => |d| d.encoder.signals(|_, now| without_transfer(now));
            "absolute-value-never-ends" "The transfer of the position continues after the request is withdrawn."
                => |d| d.encoder.signals(absolute_value_never_ends);
            "position-bit-stays-with-error" "Bit 13 of G1_ZSW stays set when an error code replaces the position."
                => |d| d.encoder.signals(position_bit_stays_with_error);
            "position-bit-lost-after-error" "After an error the position has to be requested again."
                => |d| d.encoder.signals(position_bit_lost_after_error);
            "position-unrequested-after-error" "After an error the position is shown although it is not requested."
                => |d| d.encoder.signals(position_unrequested_after_error);
        },
    },
    // G1_XIST3
    Group {
        needs: &[Need::Input(InputSignal::G1Xist3)],
        deviations: bugs! {
            "xist3-halves-swapped" "The two halves of G1_XIST3 are swapped."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::G1Xist3 { octets.rotate_left(4) });
            "xist3-of-four-bytes" "G1_XIST3 has four bytes."
                => |d| {
                    d.encoder.input_octets(|telegram, right| if telegram.number == 84 { 16 } else { right });
                    d.encoder.signal(|of, octets| if of.signal == InputSignal::G1Xist3 { octets.drain(..4); });
                };
            "xist3-upper-half-ones" "All bits of the upper half of G1_XIST3 are set."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_xist3: now.g1_xist3 | 0xFFFF_FFFF << 32, ..now });
        },
    },
    // Velocities
    Group {
        needs: &[Need::Input(InputSignal::NistA)],
        deviations: bugs! {
            "nist-a-from-upper-half" "NIST_A is the upper half of the 32-bit velocity."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::NistA { *octets = (of.image.velocity as i32).to_be_bytes()[..2].into() });
        },
    },
    Group {
        needs: &[Need::Input(InputSignal::NistB)],
        deviations: bugs! {
            "velocity-before-xist2" "NIST_B comes before G1_XIST2 in telegrams 83 and 84."
                => |d| d.encoder.order(velocity_before_xist2);
            "nist-b-not-sign-extended" "The upper half of NIST_B is 0 for negative velocities."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::NistB && of.image.velocity < 0 { octets[..2].fill(0) });
        },
    },
    // Telegrams of the profile with a velocity
    Group {
        needs: &[Need::Telegram(82)],
        deviations: bugs! {
            "velocity-of-the-other-width" "Telegram 82 contains NIST_B and telegram 83 NIST_A."
                => |d| {
                    d.encoder.input_octets(other_width_octets);
                    d.encoder.order(other_width);
                };
            "setpoint-word-inserted" "Telegrams 82 and 83 expect a setpoint between STW2_ENC and G1_STW."
                => |d| d.encoder.control_words(|t, [a, b]| [a, if matches!(t.number, 82 | 83) { 0 } else { b }]);
        },
    },
    Group {
        needs: &[Need::Telegram(84)],
        deviations: bugs! {
            "telegram-84-without-g1-stw" "G1_STW is ignored in telegram 84."
                => |d| d.encoder.control_words(|t, [a, b]| [a, if t.number == 84 { 0 } else { b }]);
            "telegram-84-hides-errors" "G1_XIST2 of telegram 84 contains no error code."
                => |d| d.encoder.signal(|of, octets| if of.telegram.number == 84 { hide_error(of, octets) });
        },
    },
    // The telegram of position and velocity
    Group {
        needs: &[Need::Telegram(860)],
        deviations: bugs! {
            "mantel-without-velocity" "Telegram 860 contains only the position."
                => |d| {
                    d.encoder.input_octets(mantel_without_velocity_octets);
                    d.encoder.order(mantel_without_velocity);
                };
            "velocity-before-position" "The velocity comes before the position in telegram 860."
                => |d| d.encoder.order(velocity_before_position);
            "mantel-position-in-front" "A 16-bit position is in the first two of the four bytes of telegram 860."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::Position && of.view.positions <= 1 << 16 { octets.rotate_left(2) });
            "mantel-position-unscaled" "The position of telegram 860 is in hardware steps although scaling is on."
                => |d| d.telegram.acts_on(|signal, hardware, settings| match signal {
                    InputSignal::Position => MeasuringSettings { scaling: Scaling::hardware(hardware), ..settings },
                    _ => settings,
                });
            "extension-shifts-the-telegram" "With a submodule for the velocity telegram 81 begins two bytes later."
                => |d| d.encoder.signal(|of, octets| {
                    let has_speed = of.view.submodules.iter().any(|one| one.telegram.inputs == [InputSignal::NistA]);
                    if of.signal == InputSignal::Zsw2Enc && has_speed {
                        octets.splice(..0, [0, 0]);
                    }
                });
        },
    },
    // The plain position
    Group {
        needs: &[Need::Input(InputSignal::Position)],
        deviations: bugs! {
            "position-torn" "While the position changes, its upper half in telegram 860 is that of the previous frame."
                => |d| d.encoder.signals(|before, now| SignalImage {
                    plain_position: before.unhooked.plain_position & 0xFFFF_0000 | now.plain_position & 0xFFFF,
                    ..now
                });
        },
    },
    // Additional submodules
    Group {
        needs: &[Need::Input(InputSignal::SingleTurn)],
        deviations: bugs! {
            "speed-bytes-swapped" "The 16-bit velocity is sent least significant byte first."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::NistA { octets.reverse() });
            "st-pos-in-upper-bytes" "The position within the revolution is in the upper half of its signal."
                => |d| d.encoder.signals(|_, now| SignalImage { single_turn: now.single_turn << 16, ..now });
            "st-pos-reaches-mur" "The position within the revolution is the units per revolution instead of 0."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::SingleTurn && of.image.single_turn == 0 { put(octets, units(of) as u32) });
            "st-pos-modulo-range" "The position within the revolution is the position in the range."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::SingleTurn { put(octets, of.image.plain_position) });
            "provider-status-bad" "The provider status of the last submodule with inputs stays bad."
                => |d| d.encoder.inputs(|view, submodule, _, right| {
                    let last = view.submodules.iter().rfind(|one| one.telegram.input_octets > 0);
                    SubmoduleInputs { are_good: right.are_good && last.is_none_or(|last| *last != submodule), ..right }
                });
        },
    },
    Group {
        needs: &[Need::Input(InputSignal::MultiTurn)],
        deviations: bugs! {
            "mt-pos-in-upper-bytes" "The revolutions are in the upper half of their signal."
                => |d| d.encoder.signals(|_, now| SignalImage { multi_turn: now.multi_turn << 16, ..now });
            "mt-pos-rounded-up" "The revolutions are rounded up."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::MultiTurn && of.image.single_turn > 0 { put(octets, of.image.multi_turn + 1) });
            "mt-pos-of-the-hardware" "The revolutions are those of the hardware."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::MultiTurn { put(octets, turns_of_the_hardware(of.view) as u32) });
            "mt-pos-counts-turns" "The revolutions are counted beyond those of the range."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::MultiTurn {
                    let laps = of.view.measuring.laps * of.view.hardware.revolutions as i64;
                    put(octets, (laps + turns_of_the_hardware(of.view) as i64) as u32);
                });
            "mt-pos-underflows" "If the range is below a revolution, all bits of the revolutions are set."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::MultiTurn && of.view.measuring.settings.scaling.range < units(of) { octets.fill(0xFF) });
        },
    },
    Group {
        needs: &[Need::Output(OutputWord::SeparateG1Stw)],
        deviations: bugs! {
            "separate-g1-stw-obeyed" "The bits of G1_STW in its separate submodule are obeyed."
                => |d| {
                    let mut bits = 0;
                    d.encoder.outputs(move |_, telegram, arrived| {
                        if telegram.outputs.contains(&OutputWord::SeparateG1Stw) {
                            bits = arrived.separate.unwrap_or(0);
                        }
                        OutputValues { words: arrived.words.map(|[a, b]| [a, b | bits]), ..arrived }
                    });
                };
        },
    },
    Group {
        needs: &[Need::Input(InputSignal::SeparateG1Zsw)],
        deviations: bugs! {
            "separate-g1-zsw-zero" "G1_ZSW in its separate submodule is always 0."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::SeparateG1Zsw { octets.fill(0) });
        },
    },
];

fn mantel_without_velocity(telegram: &'static Telegram) -> &'static [InputSignal] {
    if telegram.number == 860 { &[InputSignal::Position] } else { telegram.inputs }
}

fn mantel_without_velocity_octets(telegram: &Telegram, right: u16) -> u16 {
    if telegram.number == 860 { 4 } else { right }
}

fn velocity_before_position(telegram: &'static Telegram) -> &'static [InputSignal] {
    if telegram.number == 860 { &[InputSignal::NistB, InputSignal::Position] } else { telegram.inputs }
}

fn positions_swapped(telegram: &'static Telegram) -> &'static [InputSignal] {
    use InputSignal::{G1Xist1, G1Xist2, G1Zsw, NistA, NistB, Zsw2Enc};
    match telegram.number {
        81 => &[Zsw2Enc, G1Zsw, G1Xist2, G1Xist1],
        82 => &[Zsw2Enc, G1Zsw, G1Xist2, G1Xist1, NistA],
        83 => &[Zsw2Enc, G1Zsw, G1Xist2, G1Xist1, NistB],
        _ => telegram.inputs,
    }
}

fn velocity_before_xist2(telegram: &'static Telegram) -> &'static [InputSignal] {
    use InputSignal::{G1Xist1, G1Xist2, G1Xist3, G1Zsw, NistB, Zsw2Enc};
    match telegram.number {
        83 => &[Zsw2Enc, G1Zsw, G1Xist1, NistB, G1Xist2],
        84 => &[Zsw2Enc, G1Zsw, G1Xist3, NistB, G1Xist2],
        _ => telegram.inputs,
    }
}

fn with_velocity(telegram: &'static Telegram) -> &'static [InputSignal] {
    if telegram.number == 81 { telegram::STANDARD[1].inputs } else { telegram.inputs }
}

fn with_velocity_octets(telegram: &Telegram, right: u16) -> u16 {
    if telegram.number == 81 { 14 } else { right }
}

fn other_width(telegram: &'static Telegram) -> &'static [InputSignal] {
    match telegram.number {
        82 => telegram::STANDARD[2].inputs,
        83 => telegram::STANDARD[1].inputs,
        _ => telegram.inputs,
    }
}

fn other_width_octets(telegram: &Telegram, right: u16) -> u16 {
    match telegram.number {
        82 => 16,
        83 => 14,
        _ => right,
    }
}

fn each_position(image: SignalImage, change: fn(u64) -> u64) -> SignalImage {
    let shown = |value: u32| change(value.into()) as u32;
    SignalImage {
        g1_xist1: shown(image.g1_xist1),
        g1_xist2: if has_position(&image) { shown(image.g1_xist2) } else { image.g1_xist2 },
        g1_xist3: change(image.g1_xist3),
        ..image
    }
}

fn inputs_freeze_without_control(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if now.outputs[0] & 0x0400 == 0 && before.sent.good {
        SignalImage { zsw2_enc: now.zsw2_enc, outputs: now.outputs, ..before.sent }
    } else {
        now
    }
}

fn xist2_only_at_the_edge(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if has_position(&now) && has_position(&before.unhooked) {
        SignalImage { g1_xist2: before.sent.g1_xist2, ..now }
    } else {
        now
    }
}

fn position_bit_before_position(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if has_position(&now) && !has_position(&before.unhooked) { SignalImage { g1_xist2: 0, ..now } } else { now }
}

/// Sets the value of a signal.
pub fn put(octets: &mut Vec<u8>, value: u32) {
    *octets = value.to_be_bytes().into();
}

/// Removes an error code from G1_XIST2.
pub fn hide_error(of: &SentSignal<'_>, octets: &mut [u8]) {
    if of.signal == InputSignal::G1Xist2 && has_error(of.image) {
        octets.fill(0);
    }
}

fn units(of: &SentSignal<'_>) -> u64 {
    of.view.measuring.settings.scaling.units_per_revolution
}

/// The revolutions that the sensor distinguishes, without scaling, offset and code sequence.
fn turns_of_the_hardware(view: &EncoderView<'_>) -> u64 {
    view.measuring.with_settings(MeasuringSettings::hardware(&view.hardware)).position()
        / view.hardware.steps_per_revolution
}

fn is_position(signal: InputSignal) -> bool {
    use InputSignal::{G1Xist1, G1Xist2, G1Xist3, MultiTurn, Position, SingleTurn};
    matches!(signal, G1Xist1 | G1Xist2 | G1Xist3 | Position | SingleTurn | MultiTurn)
}

fn xist2_always_shows_position(_: &PreviousCycle, now: SignalImage) -> SignalImage {
    match now.g1_zsw & (POSITION | PARKED | ERROR) {
        0 => SignalImage { g1_xist2: now.position as u32, ..now },
        _ => now,
    }
}

fn xist2_keeps_last_value(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    match now.g1_zsw & (POSITION | PARKED | ERROR) {
        0 => SignalImage { g1_xist2: before.sent.g1_xist2, ..now },
        _ => now,
    }
}

fn position_bit_stays_with_error(_: &PreviousCycle, now: SignalImage) -> SignalImage {
    if has_error(&now) && now.is_transferred { SignalImage { g1_zsw: now.g1_zsw | POSITION, ..now } } else { now }
}

fn position_bit_lost_after_error(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if is_lost(before) && !is_parked(&before.unhooked) { without_transfer(now) } else { now }
}

fn with_transfer(image: SignalImage) -> SignalImage {
    match image.g1_zsw & (PARKED | ERROR) {
        0 => SignalImage { g1_zsw: image.g1_zsw | POSITION, g1_xist2: image.position as u32, ..image },
        _ => image,
    }
}

fn absolute_value_never_ends(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if before.sent.g1_zsw & POSITION != 0 { with_transfer(now) } else { now }
}

fn position_unrequested_after_error(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    let goes_on = before.sent.g1_zsw & !before.unhooked.g1_zsw & POSITION != 0;
    if has_error(&before.unhooked) || goes_on { with_transfer(now) } else { now }
}

fn xist2_one_frame_late(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if now.g1_zsw & before.unhooked.g1_zsw & POSITION != 0 {
        SignalImage { g1_xist2: before.unhooked.g1_xist2, ..now }
    } else {
        now
    }
}

/// Changes whether G1_STW is obeyed, given compatibility mode and Control by PLC in the previous frame and in this one.
pub fn control_since(counts: fn(bool, bool, bool) -> bool) -> impl FnMut(EncoderCheck, bool) -> bool {
    let mut before = false;
    move |check, right| match check {
        EncoderCheck::ControlByPlc { compatible, set } => {
            let was_set = core::mem::replace(&mut before, set);
            counts(compatible, was_set, set)
        }
        _ => right,
    }
}
