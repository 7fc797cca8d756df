//! What we send cyclically; it outlives every AR.
//!
//! This room must not know frames: which octet of a frame is whose stands in `layout`.

use alloc::vec::Vec;
use wire::profinet::rt::{Instance, IoxS};

/// The output data of all submodules, their status, and the fields that count by themselves.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    images: Vec<Image>,
    counters: Vec<(Counter, usize)>,
    all_bad: bool,
    paused: bool,
}

#[derive(Clone, Debug)]
struct Image {
    slot: u16,
    subslot: u16,
    octets: Vec<u8>,
    bad: bool,
}

/// A field that goes up by one with each frame that is sent, such as a sign of life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counter {
    /// The slot of the submodule.
    pub slot: u16,
    /// The subslot of the submodule.
    pub subslot: u16,
    /// Where its 16-bit word begins in the outputs of the submodule.
    pub octet: u16,
    /// The bits of the field in that word, without a gap.
    pub mask: u16,
    /// The first number, which also follows the last one.
    pub first: u16,
    /// The last number.
    pub last: u16,
    /// What it does.
    pub mode: CounterMode,
}

/// What a [`Counter`] does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CounterMode {
    /// It goes up by one with each frame.
    #[default]
    Counting,
    /// It keeps the number that was last sent.
    Held,
    /// It is this number, in range or not.
    Fixed(u16),
}

impl Outputs {
    /// Puts `octets` into the outputs of a submodule from octet `at` on; the others keep what they have, 0 at first.
    pub fn set(&mut self, slot: u16, subslot: u16, at: usize, octets: &[u8]) {
        self.octets_mut(slot, subslot, at + octets.len())[at..at + octets.len()].copy_from_slice(octets);
    }

    /// The outputs of a submodule as they are set; empty where nothing was ever set.
    pub fn octets(&self, slot: u16, subslot: u16) -> &[u8] {
        self.images.iter().find(|image| image.is(slot, subslot)).map_or(&[], |image| &image.octets)
    }

    /// The outputs of a submodule, made at least `length` octets long.
    pub fn octets_mut(&mut self, slot: u16, subslot: u16, length: usize) -> &mut [u8] {
        let at = self.place(slot, subslot);
        let octets = &mut self.images[at].octets;
        if octets.len() < length {
            octets.resize(length, 0);
        }
        octets
    }

    /// Makes the provider status of one submodule, or of all, good or bad; bad means found bad by the controller.
    ///
    /// A submodule is good if it and all are.
    pub fn status(&mut self, submodule: Option<(u16, u16)>, good: bool) {
        match submodule {
            Some((slot, subslot)) => {
                let at = self.place(slot, subslot);
                self.images[at].bad = !good;
            }
            None => self.all_bad = !good,
        }
    }

    /// Stops (`true`) or resumes sending cyclic frames; an AR that is not fed soon ends.
    pub fn pause(&mut self, paused: bool) {
        self.paused = paused;
    }

    /// Whether no cyclic frames are sent.
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// Adds a counting field, or gives the one at the same bits its new numbers and mode; it goes on from where it stands.
    pub fn count(&mut self, counter: Counter) {
        let at = self.place(counter.slot, counter.subslot);
        match self.counters.iter_mut().find(|(known, _)| known.is_at_place_of(&counter)) {
            Some((known, _)) => *known = counter,
            None => self.counters.push((counter, at)),
        }
    }

    /// Takes the counting fields away, so that their bits can be set like all others.
    pub fn no_counters(&mut self) {
        self.counters.clear();
    }

    /// Zeros all outputs, makes all good, takes away pause and counting fields.
    pub fn clear(&mut self) {
        self.images.iter_mut().for_each(|image| {
            image.octets.fill(0);
            image.bad = false;
        });
        self.counters.clear();
        (self.all_bad, self.paused) = (false, false);
    }

    /// Where the outputs of a submodule are kept; the place never changes.
    pub(crate) fn place(&mut self, slot: u16, subslot: u16) -> usize {
        if let Some(at) = self.images.iter().position(|image| image.is(slot, subslot)) {
            return at;
        }
        self.images.push(Image { slot, subslot, octets: Vec::new(), bad: false });
        self.images.len() - 1
    }

    /// Copies the outputs kept at `place` into `frame`; octets that were never set are 0.
    pub(crate) fn copy(&self, place: usize, frame: &mut [u8]) {
        frame.fill(0);
        if let Some(image) = self.images.get(place) {
            let length = frame.len().min(image.octets.len());
            frame[..length].copy_from_slice(&image.octets[..length]);
        }
    }

    /// The provider status of the outputs kept at `place`.
    pub(super) fn provider_status(&self, place: usize) -> IoxS {
        let bad = self.all_bad || self.images.get(place).is_some_and(|image| image.bad);
        if bad { IoxS::bad(Instance::Controller) } else { IoxS::GOOD }
    }

    /// Lets the counting fields take their next number, for the frame that is about to be sent.
    pub(crate) fn step(&mut self) {
        let Outputs { images, counters, .. } = self;
        for (counter, place) in counters {
            if let Some(image) = images.get_mut(*place) {
                counter.step(&mut image.octets);
            }
        }
    }
}

impl Image {
    fn is(&self, slot: u16, subslot: u16) -> bool {
        (self.slot, self.subslot) == (slot, subslot)
    }
}

impl Counter {
    fn is_at_place_of(&self, other: &Counter) -> bool {
        (self.slot, self.subslot, self.octet, self.mask) == (other.slot, other.subslot, other.octet, other.mask)
    }

    fn step(&self, octets: &mut Vec<u8>) {
        let at = usize::from(self.octet);
        if octets.len() < at + 2 {
            octets.resize(at + 2, 0);
        }
        let shift = self.mask.trailing_zeros().min(15);
        let word = u16::from_be_bytes([octets[at], octets[at + 1]]);
        let now = (word & self.mask) >> shift;
        let next = match self.mode {
            CounterMode::Held => return,
            CounterMode::Fixed(number) => number,
            CounterMode::Counting if (self.first..self.last).contains(&now) => now + 1,
            CounterMode::Counting => self.first,
        };
        let word = word & !self.mask | next << shift & self.mask;
        octets[at..at + 2].copy_from_slice(&word.to_be_bytes());
    }
}
