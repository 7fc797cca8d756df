//! Control words, status words and positions.

use crate::needs::Need;
use crate::seams::Deviations;
use crate::tables::Group;
use alloc::rc::Rc;
use core::cell::Cell;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::hooks::{EncoderHooks, EncoderView};
use encoder_profile::profidrive::control::CONTROL_BY_PLC;
use encoder_profile::profidrive::telegram::{InputSignal, OutputValues, PreviousCycle, SignalImage, Telegram};
use reference_devices::manuals;
use reference_devices::models::sick_afx60::hooks::Afx60Check;

/// The variations.
pub const GROUP: Group = Group {
    needs: &[Need::Of(&manuals::SICK_AFX60)],
    deviations: permitted! {
        "preset-bit-ends-with-the-preset" "Bit 12 of G1_ZSW falls in the frame after the preset, though the preset is still requested."
            "3.4.3, Table 15 bit 12: the bit is set to 0 on conclusion of the preset function"
            => |d| d.encoder.signals(|before, now| SignalImage { g1_zsw: now.g1_zsw & !(before.unhooked.g1_zsw & EXECUTED), ..now });
        "acknowledgement-answered-in-one-frame" "Bit 11 of G1_ZSW is set in the first frame of an acknowledgement only."
            "3.4.3, Table 15 bit 11 is silent about the end of the bit"
            => |d| d.encoder.signals(|before, now| SignalImage { g1_zsw: now.g1_zsw & !(before.unhooked.g1_zsw & IN_PROCESS), ..now });
        "control-makes-a-preset-of-a-held-request" "A preset that is requested before Control by PLC is executed once control is given."
            "3.4.3, note to Table 14, names both bits and not their order"
            => |d| d.encoder.outputs(|view, _, arrived| change_words(arrived, |[stw2, g1]| {
                [stw2, if has_control(view, stw2) { g1 } else { g1 & !HOME }]
            }));
        "functions-stay-without-control" "When Control by PLC ends, the functions of G1_STW stay as they are until it is given again."
            "3.4.3, Table 21 bit 10 enables to activate and deactivate functions; it is silent about those that are active"
            => |d| d.encoder.add(StayWithoutControl::default());
        "preset-shows-the-second-position" "While bit 12 of G1_ZSW is set G1_XIST2 contains the new position, requested or not."
            "3.4.3, Table 15 bit 12: the new position is output in G1_XIST1 and G1_XIST2; 4.4.2, Figure 18 prints 0"
            => |d| d.encoder.signals(|_, now| if now.g1_zsw & (EXECUTED | ERROR) == EXECUTED {
                SignalImage { g1_xist2: now.position as u32, ..now }
            } else {
                now
            });
        "preset-control-acts-on-the-third-position" "With G1_XIST1 preset control off a preset does not act on G1_XIST3."
            "3.6.3: otherwise the preset acts on G1_XIST2 only; 3.4.3, signal 39 says that it always does"
            => |d| d.checks.check(|check, right| match check {
                EncoderCheck::PresetActsOn(InputSignal::G1Xist3, user) => right && user.preset_acts_on_xist1,
                _ => right,
            });
        "no-sign-of-life" "The sign of life in ZSW2_ENC stays 0."
            "3.4.3, Table 22: the sign of life is not relevant"
            => |d| d.encoder.signals(|_, now| SignalImage { zsw2_enc: now.zsw2_enc & 0x0FFF, ..now });
        "parked-positions-stand-still" "While parked the positions keep their last values."
            "3.4.3, Table 15 bit 14: no output of position data; the values are not printed"
            => |d| d.encoder.add(StandStill { bit: PARKED, second_too: true, held: None });
        "third-position-goes-on-while-parked" "While parked G1_XIST3 follows the shaft."
            "3.4.3, Table 15 bit 14 names G1_XIST1 and G1_XIST2 only"
            => |d| d.encoder.signals(|_, now| if now.g1_zsw & PARKED == 0 { now } else { SignalImage { g1_xist3: now.position, ..now } });
        "velocity-goes-on-while-parked" "While parked the velocity follows the shaft."
            "3.4.3, Table 15 bit 14 names the positions only"
            => |d| d.encoder.image(|view, _, now| if now.g1_zsw & PARKED == 0 { now } else {
                let settings = &view.measuring.settings;
                SignalImage { velocity: view.velocity.value(&settings.scaling, settings.direction), ..now }
            });
        "parking-clears-errors" "Parking clears the errors, and none is shown while parked."
            "3.4.3, Tables 14 and 15 are silent about errors while parked"
            => |d| d.checks.check(|check, right| match check {
                EncoderCheck::ParkingClearsErrors => true,
                EncoderCheck::RaisesError { parked: true, .. } => false,
                _ => right,
            });
        "position-stands-still-during-an-error" "During an error G1_XIST1 and G1_XIST3 keep the values of its begin."
            "5.4.4, Table 53: an error leads to an invalid position; whether the position goes on is not printed"
            => |d| d.encoder.add(StandStill { bit: ERROR, second_too: false, held: None });
        "newest-error-shown" "Of several errors G1_XIST2 shows the newest one."
            "5.4.4 is silent about several errors"
            => |d| d.encoder.image(|view, _, now| match view.errors.iter().rev().find_map(|error| error.code) {
                Some(code) if now.g1_zsw & ERROR != 0 => SignalImage { g1_xist2: code.into(), ..now },
                _ => now,
            });
        "calculation-off-holds-the-velocity" "Without the speed calculation the velocity keeps its last value."
            "3.5.5, Table 34 (1005.0): the velocity while the calculation is off is not printed"
            => |d| calculation_off_holds_the_velocity(d);
        "short-speed-wraps" "A speed beyond 16 bits is cut in NIST_A."
            "3.4.3, note to signal 6: the value that can be represented may be exceeded; what is then sent is not printed"
            => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::NistA {
                *octets = (of.image.velocity as u16).to_be_bytes().into();
            });
    },
};

const IN_PROCESS: u16 = 1 << 11;
const EXECUTED: u16 = 1 << 12;
const PARKED: u16 = 1 << 14;
const ERROR: u16 = 1 << 15;
/// Bit 12 of G1_STW, which requests a preset.
const HOME: u16 = 1 << 12;

fn has_control(view: &EncoderView<'_>, stw2: u16) -> bool {
    view.user.compatible || stw2 & CONTROL_BY_PLC != 0
}

fn change_words(arrived: OutputValues, change: impl FnOnce([u16; 2]) -> [u16; 2]) -> OutputValues {
    OutputValues { words: arrived.words.map(change), ..arrived }
}

/// Keeps G1_STW as it was when Control by PLC ended.
#[derive(Default)]
struct StayWithoutControl {
    last: u16,
}

impl EncoderHooks for StayWithoutControl {
    fn starts(&mut self, _: &EncoderView<'_>) {
        self.last = 0;
    }

    fn outputs(&mut self, view: &EncoderView<'_>, _: &Telegram, arrived: OutputValues) -> OutputValues {
        change_words(arrived, |[stw2, g1]| {
            if has_control(view, stw2) {
                self.last = g1;
                [stw2, g1]
            } else {
                [stw2 | CONTROL_BY_PLC, self.last]
            }
        })
    }
}

/// Keeps the positions while a bit of G1_ZSW is set.
struct StandStill {
    bit: u16,
    second_too: bool,
    held: Option<SignalImage>,
}

impl EncoderHooks for StandStill {
    fn image(&mut self, _: &EncoderView<'_>, before: &PreviousCycle, now: SignalImage) -> SignalImage {
        if now.g1_zsw & self.bit == 0 {
            self.held = None;
            return now;
        }
        let held = self.held.get_or_insert(before.sent);
        let g1_xist2 = if self.second_too && now.g1_zsw & ERROR == 0 { held.g1_xist2 } else { now.g1_xist2 };
        SignalImage { g1_xist1: held.g1_xist1, g1_xist3: held.g1_xist3, g1_xist2, ..now }
    }
}

fn calculation_off_holds_the_velocity(d: &mut Deviations) {
    let is_measured = Rc::new(Cell::new(true));
    let measures = is_measured.clone();
    d.afx60.check(move |check, right| {
        if check == Afx60Check::VelocityIsCalculated {
            measures.set(right);
        }
        right
    });
    let mut held = 0;
    d.encoder.signals(move |_, now| {
        if is_measured.get() {
            held = now.velocity;
        }
        SignalImage { velocity: held, ..now }
    });
}
