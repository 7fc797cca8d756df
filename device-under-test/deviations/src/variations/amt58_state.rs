//! Permitted variations of the AMT58 that have state.

use crate::tables::amt58::diagnosis::patch;
use alloc::vec::Vec;
use device_stack::profibus::DiagnosisBits;
use encoder_profile::encoder::Scaling;
use reference_devices::models::datalogic_amt58::hooks::{Amt58Check, Amt58Hooks, Amt58View};
use reference_devices::models::datalogic_amt58::leds::{self, Leds, Situation};
use reference_devices::models::datalogic_amt58::set_prm::{COUNTS, EncoderParameters, RESOLUTION, number};

/// Shows the values of Set_Prm in the diagnosis while scaling is off.
#[derive(Default)]
pub(super) struct SentValues {
    sent: Option<[u32; 2]>,
}

impl Amt58Hooks for SentValues {
    fn parameters(&mut self, _: &Amt58View<'_>, user: &[u8], parameters: EncoderParameters) -> EncoderParameters {
        let is_shown = parameters.is_class_2 && !parameters.scales;
        self.sent = is_shown.then(|| [number(user, COUNTS), number(user, RESOLUTION)]);
        parameters
    }

    fn diagnosis(&mut self, _: &Amt58View<'_>, octets: &mut Vec<u8>, bits: DiagnosisBits) -> DiagnosisBits {
        if let Some([counts, resolution]) = self.sent {
            patch(octets, 39, &counts.to_be_bytes());
            patch(octets, 43, &resolution.to_be_bytes());
        }
        bits
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.sent = None;
        offset
    }
}

/// Works in hardware steps with an impossible scaling, and shows it by the LEDs.
#[derive(Default)]
pub(super) struct RefusedOnLeds {
    is_impossible: bool,
}

impl Amt58Hooks for RefusedOnLeds {
    fn check(&mut self, _: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        match check {
            Amt58Check::UserOctets(_) => {
                self.is_impossible = false;
                verdict
            }
            Amt58Check::Scaling(_) => {
                self.is_impossible = !verdict;
                true
            }
            _ => verdict,
        }
    }

    fn parameters(&mut self, view: &Amt58View<'_>, _: &[u8], parameters: EncoderParameters) -> EncoderParameters {
        if self.is_impossible {
            EncoderParameters { scaling: Scaling::hardware(&view.hardware), ..parameters }
        } else {
            parameters
        }
    }

    fn leds(&mut self, _: &Amt58View<'_>, _: &Situation, right: Leds) -> Leds {
        let is_right = right == leds::OPERATION || right == leds::RED_ZONE;
        if self.is_impossible && is_right { leds::INVALID_PARAMETERS } else { right }
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.is_impossible = false;
        offset
    }
}
