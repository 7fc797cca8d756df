//! Bugs of telegrams and their signals that only some encoders can have.

use super::Group;
use super::cyclic_state::{CombinedCodes, preset_lost_with_its_request};
use super::handshakes::presets_while_parked;
use super::presets::after_parking;
use super::signal_image::{ERROR, EXECUTED, PARKED, POSITION, has_error, has_position, is_parked};
use super::signals::{control_since, hide_error, put};
use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::encoder::SentSignal;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use device_stack::profinet::PluggableSubmodule;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::measuring::PresetBasis;
use encoder_profile::encoder::{Hardware, PresetMode, Scaling};
use encoder_profile::hooks::EncoderHooks;
use encoder_profile::profidrive::telegram::{InputSignal, OutputWord, PreviousCycle, SignalImage, Telegram};
use encoder_profile::profidrive::user_parameters::UserParameterData;
use reference_devices::manuals;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    // The sensor interface
    Group {
        needs: &[Need::Output(OutputWord::Stw2Enc)],
        deviations: bugs! {
            "status-words-swapped" "ZSW2_ENC and G1_ZSW are swapped in every telegram."
                => |d| d.encoder.order(status_words_swapped);
            "telegram-latched" "The telegram of the first connection after power-up is used until power-off."
                => |d| d.encoder.add(LatchedTelegram::default());
            "control-by-plc-at-bit-9" "Bit 9 of STW2_ENC is used as Control by PLC instead of bit 10."
                => |d| d.encoder.control_words(|_, [a, b]| [a & !0x0400 | (a & 0x0200) << 1, b]);
            "sign-of-life-carries" "Bit 11 of ZSW2_ENC is set when the sign of life wraps from 15 to 1."
                => |d| d.encoder.signals(sign_of_life_carries);
            "control-edge-in-compatibility-mode" "In compatibility mode G1_STW is ignored in the frame in which Control by PLC ends."
                => |d| d.checks.check(control_since(|compatible, was_set, set| set || compatible && !was_set));
            "v41-mode-without-requests" "Without compatibility mode G1_STW is never obeyed."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::ControlByPlc { compatible, .. } => compatible,
                    _ => right,
                });
            "transfer-blocks-preset" "Presets are ignored while the position is requested in G1_XIST2."
                => |d| d.encoder.control_words(|_, [a, b]| [a, if b & POSITION == 0 { b } else { b & !EXECUTED }]);
            "preset-lost-with-its-request" "When the request of a preset is withdrawn, the previous offset is restored."
                => |d| d.encoder.working_preset(preset_lost_with_its_request());
            "zero-is-no-preset" "A preset to 0 is acknowledged and not carried out."
                => |d| d.measuring.absolute(|preset| if preset.value == 0 { preset.offset } else { preset.new_offset() });
            "preset-on-zero-while-parked" "A preset while parked is carried out as if the position were 0."
                => |d| {
                    d.checks.check(presets_while_parked);
                    preset_on_zero_while_parked(d);
                };
            "position-stays-after-parking" "After parking the position continues from the one before parking."
                => |d| d.encoder.working_preset(after_parking(|view, position| view.measuring.preset(PresetMode::Absolute, position)));
            "held-acknowledgement-hides-errors" "Errors are not shown while bit 15 of G1_STW is 1."
                => |d| d.encoder.signals(|_, now| if now.request.acknowledge { without_error(now) } else { now });
            "error-codes-combined" "The codes of several errors are combined bit by bit."
                => |d| d.encoder.add(CombinedCodes::default());
        },
    },
    // The sign of life of the controller, if it is not monitored or only in isochronous operation
    Group {
        needs: &[Need::Output(OutputWord::Stw2Enc)],
        deviations: bugs! {
            "sign-of-life-watched" "A sign of life of the controller that does not change for 15 frames raises an error."
                => |d| {
                    d.checks.check(|check, right| match check {
                        EncoderCheck::MonitorsController { parked, .. } => !parked,
                        _ => right,
                    });
                    d.life_sign.tolerated(|_, _| 15);
                };
        },
    },
    // Positions and their signals
    Group {
        needs: &[Need::Input(InputSignal::G1Xist2)],
        deviations: bugs! {
            "xist2-freezes-without-control" "When Control by PLC ends, G1_XIST2 is frozen and bit 13 of G1_ZSW stays set."
                => |d| d.encoder.signals(xist2_freezes_without_control);
            "preset-shown-in-xist2-too-early" "While a preset is requested G1_XIST2 shows the position."
                => |d| d.encoder.signals(|_, now| shows_position(now, now.request.home));
            "revolution-missing" "The last revolution is missing from the range."
                => |d| d.measuring.range(revolution_missing);
            "xist1-moves-while-parked" "G1_XIST1 follows the position while parked."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_xist1: if is_parked(&now) { now.position as u32 } else { now.g1_xist1 }, ..now });
        },
    },
    // G1_XIST1 shifted to the left
    Group {
        needs: &[Need::ShiftedXist1],
        deviations: bugs! {
            "xist1-saturates" "G1_XIST1 is limited to 7FFFFFFFh."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::G1Xist1 && octets[0] > 0x7F { put(octets, 0x7FFF_FFFF) });
            "xist1-right-aligned" "G1_XIST1 is not shifted."
                => |d| d.encoder.signals(|_, now| SignalImage { shift: 0, ..now });
            "shift-follows-scaling" "G1_XIST1 is shifted so that the highest bit of the range is bit 31."
                => |d| d.encoder.image(|view, _, now| SignalImage { shift: (view.positions.max(2) - 1).leading_zeros().saturating_sub(32), ..now });
        },
    },
    Group {
        needs: &[Need::Profinet, Need::ShiftedXist1],
        deviations: bugs! {
            "shift-of-the-other-variant" "G1_XIST1 is shifted by the factor of the other variant, also in P979."
                => |d| {
                    d.encoder.signals(|_, now| SignalImage { shift: 16 - now.shift, ..now });
                    d.encoder.element(|_, at, right| if at == (979, 3) { 16 - right } else { right });
                };
            "xist1-shift-of-the-other-variant" "G1_XIST1 is shifted by the factor of the other variant."
                => |d| d.encoder.signals(|_, now| SignalImage { shift: 16 - now.shift, ..now });
        },
    },
    // Signals of 32 bits and velocities
    Group {
        needs: &[Need::Profinet, Need::EncoderProfile],
        deviations: bugs! {
            "signal-words-swapped" "The two words of each 32-bit signal are swapped."
                => |d| d.encoder.signal(|_, octets| swap_words(octets));
            "velocity-left-aligned" "NIST_A is shifted to the left by 4 bits, NIST_B by 16."
                => |d| d.encoder.signal(velocity_left_aligned);
        },
    },
    // Telegrams of the profile with a velocity
    Group {
        needs: &[Need::Telegram(82)],
        deviations: bugs! {
            "nist-a-before-positions" "In telegram 82 NIST_A comes before G1_XIST1."
                => |d| d.encoder.order(nist_a_before_positions);
            "codes-in-two-telegrams-only" "In telegrams 82 and 84 G1_XIST2 contains no error codes."
                => |d| d.encoder.signal(|of, octets| if matches!(of.telegram.number, 82 | 84) { hide_error(of, octets) });
        },
    },
    Group {
        needs: &[Need::Telegram(84)],
        deviations: bugs! {
            "xist2-before-xist3" "In telegram 84 G1_XIST2 comes before G1_XIST3."
                => |d| d.encoder.order(xist2_before_xist3);
            "telegram-84-without-velocity" "Telegram 84 ends after G1_XIST2."
                => |d| {
                    d.encoder.order(without_velocity);
                    d.encoder.input_octets(without_velocity_octets);
                };
            "telegram-84-does-not-park" "With telegram 84 a request to park has no effect."
                => |d| d.encoder.control_words(|t, [a, b]| [a, if t.number == 84 { b & !PARKED } else { b }]);
        },
    },
    // Supply errors and defaults of the AFS60 and AFM60
    Group {
        needs: &[Need::Of(&manuals::SICK_AFX60)],
        deviations: bugs! {
            "default-speed-unit-steps" "Without a record the velocity is in steps per second."
                => |d| d.start.factory_parameters(|_, right| UserParameterData { speed_unit: 0, ..right });
            "acknowledgement-lost-while-parked" "An acknowledgement while parked has no effect."
                => |d| d.checks.set(EncoderCheck::Acknowledges { parked: true }, false);
            "limits-not-checked-again" "An acknowledgement clears supply errors even while the voltage is beyond its limits."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::ClearsError { code: Some(0x1003 | 0x1004), .. } => true,
                    _ => right,
                });
        },
    },
];

fn preset_on_zero_while_parked(d: &mut Deviations) {
    let is_parked = Rc::new(Cell::new(false));
    let known = is_parked.clone();
    d.encoder.working_preset(move |view, held| {
        known.set(view.sensor.is_parked());
        held
    });
    d.measuring.preset(
        move |preset, right| if is_parked.get() { PresetBasis { position: 0, ..*preset }.new_offset() } else { right },
    );
}

fn status_words_swapped(telegram: &'static Telegram) -> &'static [InputSignal] {
    use InputSignal::{G1Xist1, G1Xist2, G1Xist3, G1Zsw, NistA, NistB, Zsw2Enc};
    match telegram.number {
        81 => &[G1Zsw, Zsw2Enc, G1Xist1, G1Xist2],
        82 => &[G1Zsw, Zsw2Enc, G1Xist1, G1Xist2, NistA],
        83 => &[G1Zsw, Zsw2Enc, G1Xist1, G1Xist2, NistB],
        84 => &[G1Zsw, Zsw2Enc, G1Xist3, G1Xist2, NistB],
        _ => telegram.inputs,
    }
}

fn nist_a_before_positions(telegram: &'static Telegram) -> &'static [InputSignal] {
    use InputSignal::{G1Xist1, G1Xist2, G1Zsw, NistA, Zsw2Enc};
    if telegram.number == 82 { &[Zsw2Enc, G1Zsw, NistA, G1Xist1, G1Xist2] } else { telegram.inputs }
}

fn xist2_before_xist3(telegram: &'static Telegram) -> &'static [InputSignal] {
    use InputSignal::{G1Xist2, G1Xist3, G1Zsw, NistB, Zsw2Enc};
    if telegram.number == 84 { &[Zsw2Enc, G1Zsw, G1Xist2, G1Xist3, NistB] } else { telegram.inputs }
}

fn without_velocity(telegram: &'static Telegram) -> &'static [InputSignal] {
    if telegram.number == 84 { &telegram.inputs[..4] } else { telegram.inputs }
}

fn without_velocity_octets(telegram: &Telegram, right: u16) -> u16 {
    if telegram.number == 84 { 16 } else { right }
}

fn xist2_freezes_without_control(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if now.outputs[0] & 0x0400 == 0 && has_position(&before.sent) {
        SignalImage { g1_zsw: now.g1_zsw | POSITION, g1_xist2: before.sent.g1_xist2, ..now }
    } else {
        now
    }
}

fn sign_of_life_carries(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    let wraps = before.unhooked.zsw2_enc >> 12 == 15 && now.zsw2_enc >> 12 == 1;
    SignalImage { zsw2_enc: now.zsw2_enc | if wraps { 0x0800 } else { 0 }, ..now }
}

fn shows_position(now: SignalImage, shows: bool) -> SignalImage {
    if shows && now.g1_zsw & (POSITION | PARKED | ERROR) == 0 {
        SignalImage { g1_xist2: now.position as u32, ..now }
    } else {
        now
    }
}

fn without_error(image: SignalImage) -> SignalImage {
    let xist2 = if has_error(&image) { 0 } else { image.g1_xist2 };
    SignalImage { g1_zsw: image.g1_zsw & !ERROR, g1_xist2: xist2, ..image }
}

fn revolution_missing(scaling: &Scaling, hardware: &Hardware, _: u64) -> u64 {
    if *scaling == Scaling::hardware(hardware) && hardware.revolutions > 1 {
        scaling.range - hardware.steps_per_revolution
    } else {
        scaling.range
    }
}

/// Swaps the two words of a 32-bit signal.
pub fn swap_words(octets: &mut [u8]) {
    if octets.len() == 4 {
        octets.rotate_left(2);
    }
}

fn velocity_left_aligned(of: &SentSignal<'_>, octets: &mut Vec<u8>) {
    match of.signal {
        InputSignal::NistA => *octets = ((of.image.velocity << 4) as u16).to_be_bytes().into(),
        InputSignal::NistB => put(octets, (of.image.velocity << 16) as u32),
        _ => {}
    }
}

/// The submodules of the first connection.
#[derive(Default)]
struct LatchedTelegram(Option<Vec<PluggableSubmodule>>);

impl EncoderHooks for LatchedTelegram {
    fn plugged(&mut self, plugged: Vec<PluggableSubmodule>) -> Vec<PluggableSubmodule> {
        self.0.get_or_insert(plugged).clone()
    }

    fn powered_up(&mut self) {
        self.0 = None;
    }
}
