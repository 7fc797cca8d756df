//! The seams of an encoder, as the rows of the tables use them.
//!
//! Whatever has no state is a function here; a deviation that remembers something stands beside its row as a
//! [`Deviation`] of its own and is [`add`](Encoder::add)ed.

use alloc::boxed::Box;
use alloc::vec::Vec;
use encoder_profile::deviation::{Check, Deviation};
use encoder_profile::deviation::{Lit, View};
use encoder_profile::profidrive::telegram::{Before, Image};

/// Everybody who stands beside one encoder.
#[derive(Default)]
pub struct Encoder(Vec<Box<dyn Deviation>>);

impl Encoder {
    /// Puts somebody beside the encoder.
    pub fn add(&mut self, deviation: impl Deviation + 'static) {
        self.0.push(Box::new(deviation));
    }

    /// Whether nobody is there.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Decides otherwise than the encoder: from what it is about and what the encoder has decided.
    pub fn check(&mut self, decide: impl FnMut(Check, bool) -> bool + 'static) {
        self.add(Decides(decide));
    }

    /// Changes the signals of a frame, from the cycle before and what is right now.
    pub fn image(&mut self, change: impl FnMut(&Before, Image) -> Image + 'static) {
        self.add(Shows(change));
    }

    /// Changes elements of parameters, from the number of the parameter and the place of the element, and the right value.
    pub fn element(&mut self, change: impl FnMut(&View<'_>, (u16, usize), u64) -> u64 + 'static) {
        self.add(Says(change));
    }

    /// Changes what an LED shows.
    pub fn led(&mut self, change: impl FnMut(&Lit<'_>) -> &'static str + 'static) {
        self.add(Lights(change));
    }
}

impl Deviation for Encoder {
    fn check(&mut self, check: Check, verdict: bool) -> bool {
        self.0.iter_mut().fold(verdict, |verdict, of| of.check(check, verdict))
    }

    fn image(&mut self, before: &Before, now: Image) -> Image {
        self.0.iter_mut().fold(now, |now, of| of.image(before, now))
    }

    fn element(&mut self, view: &View<'_>, at: (u16, usize), right: u64) -> u64 {
        self.0.iter_mut().fold(right, |right, of| of.element(view, at, right))
    }

    fn led(&mut self, lit: &Lit<'_>, right: &'static str) -> &'static str {
        self.0.iter_mut().fold(right, |right, of| of.led(&Lit { right, ..*lit }, right))
    }
}

struct Decides<F>(F);

impl<F: FnMut(Check, bool) -> bool> Deviation for Decides<F> {
    fn check(&mut self, check: Check, verdict: bool) -> bool {
        (self.0)(check, verdict)
    }
}

struct Shows<F>(F);

impl<F: FnMut(&Before, Image) -> Image> Deviation for Shows<F> {
    fn image(&mut self, before: &Before, now: Image) -> Image {
        (self.0)(before, now)
    }
}

struct Says<F>(F);

impl<F: FnMut(&View<'_>, (u16, usize), u64) -> u64> Deviation for Says<F> {
    fn element(&mut self, view: &View<'_>, at: (u16, usize), right: u64) -> u64 {
        (self.0)(view, at, right)
    }
}

struct Lights<F>(F);

impl<F: FnMut(&Lit<'_>) -> &'static str> Deviation for Lights<F> {
    fn led(&mut self, lit: &Lit<'_>, _: &'static str) -> &'static str {
        (self.0)(lit)
    }
}
