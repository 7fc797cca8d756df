//! What a station of ours sends cyclically, on either bus; it outlives every connection.
//!
//! Whoever sets outputs declares their signals once and says for each connection which submodules carry them. The values, and what
//! counts by itself, are kept here and nowhere else. This module must not know frames: which byte of a frame belongs to which
//! submodule is for the bus to say.

use alloc::vec::Vec;

/// The output signals, the submodules that carry them with their status, and whether anything is sent.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    signals: Vec<Output>,
    submodules: Vec<Submodule>,
    /// All output bytes at once, in place of the values of the signals.
    bytes: Option<Vec<u8>>,
    all_bad: bool,
    paused: bool,
}

/// An output signal as it is declared: a number, most significant byte first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OutputSignal {
    /// How many bytes it has, at most eight.
    pub bytes: usize,
    /// The fields in it that count by themselves, such as a sign of life.
    pub counters: Vec<Counter>,
}

/// A field that goes up by one with each frame that is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counter {
    /// The lowest bit, 0 is the least significant of the signal.
    pub low: u32,
    /// How many bits.
    pub width: u32,
    /// The first number, which also follows the last one.
    pub first: u64,
    /// The last number.
    pub last: u64,
}

/// What a [`Counter`] does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CounterMode {
    /// It goes up by one with each frame.
    #[default]
    Counting,
    /// It keeps the number that was last sent.
    Held,
    /// It is the number that was set, in range or not.
    AsSet,
}

#[derive(Clone, Debug)]
struct Output {
    bytes: usize,
    /// What was set.
    set: u64,
    /// What the last frame carried.
    sent: u64,
    counters: Vec<(Counter, CounterMode)>,
    /// Where it begins in the output bytes of the connection; none where no submodule carries it.
    at: Option<usize>,
}

#[derive(Clone, Debug)]
struct Submodule {
    slot: u16,
    subslot: u16,
    signals: Vec<usize>,
    bad: bool,
}

impl Outputs {
    /// Declares the signals, all 0 and every counter counting; they are numbered in this order.
    pub fn declare(&mut self, signals: impl IntoIterator<Item = OutputSignal>) {
        let output = |OutputSignal { bytes, counters }| Output {
            bytes: usize::min(bytes, 8),
            set: 0,
            sent: 0,
            counters: counters.into_iter().map(|counter| (counter, CounterMode::default())).collect(),
            at: None,
        };
        self.signals = signals.into_iter().map(output).collect();
    }

    /// Says which submodules carry which signals from now on, in order; all others carry none. Values stay.
    pub fn lay_out<'s>(&mut self, submodules: impl IntoIterator<Item = ((u16, u16), &'s [usize])>) {
        self.submodules.iter_mut().for_each(|submodule| submodule.signals.clear());
        self.signals.iter_mut().for_each(|signal| signal.at = None);
        let mut at = 0;
        for ((slot, subslot), signals) in submodules {
            let place = self.place(slot, subslot);
            for &number in signals {
                let Some(signal) = self.signals.get_mut(number) else { continue };
                signal.at = signal.at.or(Some(at));
                at += signal.bytes;
                self.submodules[place].signals.push(number);
            }
        }
    }

    /// Declares `length` signals of one byte each, and lays them out in one submodule.
    pub fn declare_bytes(&mut self, slot: u16, subslot: u16, length: usize) {
        self.declare((0..length).map(|_| OutputSignal { bytes: 1, counters: Vec::new() }));
        self.lay_out([((slot, subslot), &*(0..length).collect::<Vec<_>>())]);
    }

    /// Sets `width` bits of a signal from `low` on; a counter at these bits stands still. Bytes that were set at once are forgotten.
    pub fn set(&mut self, signal: usize, low: u32, width: u32, number: u64) {
        let Some(signal) = self.signals.get_mut(signal) else { return };
        let bits = mask(low, width);
        signal.set = signal.set & !bits | number.checked_shl(low).unwrap_or(0) & bits;
        self.bytes = None;
        signal.count(low, width, CounterMode::AsSet);
    }

    /// Says how the counter at these bits of a signal counts from now on.
    pub fn count(&mut self, signal: usize, low: u32, width: u32, mode: CounterMode) {
        if let Some(signal) = self.signals.get_mut(signal) {
            signal.count(low, width, mode);
        }
    }

    /// Sets all output bytes of the connection at once, those that are missing to what was set before; nothing counts any more.
    pub fn set_bytes(&mut self, bytes: &[u8]) {
        self.bytes = Some(bytes.to_vec());
        let counters = self.signals.iter_mut().flat_map(|signal| &mut signal.counters);
        counters.for_each(|(_, mode)| *mode = CounterMode::AsSet);
    }

    /// Sets every signal to 0 and lets every counter count again.
    pub fn reset(&mut self) {
        self.bytes = None;
        for signal in &mut self.signals {
            signal.set = 0;
            signal.counters.iter_mut().for_each(|(_, mode)| *mode = CounterMode::Counting);
        }
    }

    /// Makes the provider status of one submodule, or of all, good or bad; bad means found bad by the controller.
    ///
    /// A submodule is good if it and all are.
    pub fn status(&mut self, submodule: Option<(u16, u16)>, good: bool) {
        match submodule {
            Some((slot, subslot)) => {
                let at = self.place(slot, subslot);
                self.submodules[at].bad = !good;
            }
            None => self.all_bad = !good,
        }
    }

    /// Stops (`true`) or resumes sending cyclic frames; a connection that is not fed soon ends.
    pub fn pause(&mut self, paused: bool) {
        self.paused = paused;
    }

    /// Whether no cyclic frames are sent.
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// Where the outputs of a submodule are kept; the place never changes.
    pub(crate) fn place(&mut self, slot: u16, subslot: u16) -> usize {
        let is_it = |of: &Submodule| (of.slot, of.subslot) == (slot, subslot);
        if let Some(at) = self.submodules.iter().position(is_it) {
            return at;
        }
        self.submodules.push(Submodule { slot, subslot, signals: Vec::new(), bad: false });
        self.submodules.len() - 1
    }

    /// Writes the outputs kept at `place` into `frame`, as [`step`](Outputs::step) made them; bytes of no signal are 0.
    pub(crate) fn copy(&self, place: usize, frame: &mut [u8]) {
        frame.fill(0);
        let signals = self.submodules.get(place).map_or(&[][..], |submodule| &submodule.signals);
        let mut rest = frame;
        for signal in signals.iter().filter_map(|number| self.signals.get(*number)) {
            let length = rest.len().min(signal.bytes);
            let (own, behind) = rest.split_at_mut(length);
            own.copy_from_slice(&signal.sent.to_be_bytes()[8 - signal.bytes..][..length]);
            rest = behind;
        }
    }

    /// Whether the outputs kept at `place` are good.
    pub(crate) fn is_good(&self, place: usize) -> bool {
        !self.all_bad && !self.submodules.get(place).is_some_and(|submodule| submodule.bad)
    }

    /// Takes what was set and lets the counters take their next number, for the frame that is about to be sent.
    pub(crate) fn step(&mut self) {
        let Outputs { signals, bytes, .. } = self;
        for signal in signals {
            if let Some(at) = signal.at {
                let given = bytes.as_deref().and_then(|bytes| bytes.get(at..));
                signal.step(given.unwrap_or_default());
            }
        }
    }
}

/// The bits of a number that a field lies in.
fn mask(low: u32, width: u32) -> u64 {
    let all = if width >= 64 { u64::MAX } else { (1 << width) - 1 };
    all.checked_shl(low).unwrap_or(0)
}

impl Output {
    fn count(&mut self, low: u32, width: u32, mode: CounterMode) {
        let at_bits = self.counters.iter_mut().filter(|(counter, _)| (counter.low, counter.width) == (low, width));
        at_bits.for_each(|(_, now)| *now = mode);
    }

    /// The next number; `given` bytes stand in the place of what was set.
    fn step(&mut self, given: &[u8]) {
        let mut bytes = self.set.to_be_bytes();
        let length = given.len().min(self.bytes);
        if length > 0 {
            bytes[8 - self.bytes..][..length].copy_from_slice(&given[..length]);
        }
        let mut next = u64::from_be_bytes(bytes);
        for (counter, mode) in &self.counters {
            let bits = mask(counter.low, counter.width);
            let last = (self.sent & bits).checked_shr(counter.low).unwrap_or(0);
            let number = match mode {
                CounterMode::AsSet => continue,
                CounterMode::Held => last,
                CounterMode::Counting if (counter.first..counter.last).contains(&last) => last + 1,
                CounterMode::Counting => counter.first,
            };
            next = next & !bits | number.checked_shl(counter.low).unwrap_or(0) & bits;
        }
        self.sent = next;
    }
}
