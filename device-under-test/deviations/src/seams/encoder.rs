//! The hooks of an encoder, as the rows of the tables attach to them.

use alloc::vec::Vec;
use encoder_profile::checks::{Check, EncoderChecks};
use encoder_profile::hooks::{EncoderHooks, Held, Lit, View};
use encoder_profile::profidrive::sensor::Error;
use encoder_profile::profidrive::telegram::{Before, Image, Outputs, Telegram};

hooks! { Decisions: EncoderChecks
    /// Flips a decision: from what it is about and what the encoder has decided.
    check(check: Check) -> bool;
}

impl Decisions {
    /// Decides about this always so, whatever the manual says.
    pub fn set(&mut self, of: Check, verdict: bool) {
        self.check(move |check, right| if check == of { verdict } else { right });
    }
}

hooks! { Encoder: EncoderHooks
    /// Changes what the controller sends in one telegram, as it arrives.
    outputs(view: &View<'_>, telegram: &Telegram) -> Outputs;
    /// Changes the errors whose cause is there.
    causes(view: &View<'_>) -> Vec<Error>;
    /// Changes the signals of a frame, from the cycle before and the signals of the manual.
    image(before: &Before) -> Image;
    /// Changes an element of a parameter, by the number of the parameter and the index of the element.
    element(view: &View<'_>, at: (u16, usize)) -> u64;
    /// Changes what the working memory holds of a preset, in each cycle.
    held(view: &View<'_>) -> Held;
    /// Changes what an LED shows.
    led(lit: &Lit<'_>) -> &'static str;
}
