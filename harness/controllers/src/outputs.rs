//! The cyclic outputs of a controller or master, on either bus. They outlive every connection.
//!
//! The caller declares its signals once and says for each connection which submodules carry them. Only this module stores the
//! values and the automatic counters. It must not know frames: the bus modules know which byte of a frame belongs to which
//! submodule.

use alloc::vec::Vec;
use wire::octets::mask;

/// The output signals, the submodules that carry them with their status, and whether frames are sent.
#[derive(Clone, Debug, Default)]
pub struct CyclicOutputs {
    signals: Vec<OutputState>,
    submodules: Vec<OutputSubmodule>,
    /// All output bytes at once; they replace the values of the signals.
    bytes: Option<Vec<u8>>,
    all_bad: bool,
    /// DataStatus of the frames on PROFINET, if it is not the usual one.
    data_status: Option<u8>,
    paused: bool,
}

/// An output signal: a number, most significant byte first unless it says otherwise.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OutputSignal {
    /// Length in bytes, at most eight.
    pub bytes: usize,
    /// Whether the least significant byte comes first.
    pub little_endian: bool,
    /// Fields that count by themselves, such as a sign of life.
    pub counters: Vec<SignalCounter>,
}

/// A field that is incremented with each frame sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignalCounter {
    /// The lowest bit; 0 is the least significant bit of the signal.
    pub low: u32,
    /// Width in bits.
    pub width: u32,
    /// The first value, which also follows the last one.
    pub first: u64,
    /// The last value.
    pub last: u64,
}

/// The mode of a [`SignalCounter`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CounterMode {
    /// It is incremented with each frame.
    #[default]
    Counting,
    /// It repeats the value last sent.
    Held,
    /// It sends the value that was set, in range or not.
    AsSet,
}

#[derive(Clone, Debug)]
struct OutputState {
    bytes: usize,
    little_endian: bool,
    /// The value that was set.
    set: u64,
    /// The value in the last frame.
    sent: u64,
    counters: Vec<(SignalCounter, CounterMode)>,
    /// Offset in the output bytes of the connection; `None` if no submodule carries the signal.
    at: Option<usize>,
}

#[derive(Clone, Debug)]
struct OutputSubmodule {
    slot: u16,
    subslot: u16,
    signals: Vec<usize>,
    bad: bool,
}

impl CyclicOutputs {
    /// Declares the signals, numbered in this order, all 0 and with all counters counting.
    pub fn declare(&mut self, signals: impl IntoIterator<Item = OutputSignal>) {
        let output = |OutputSignal { bytes, little_endian, counters }| OutputState {
            bytes: usize::min(bytes, 8),
            little_endian,
            set: 0,
            sent: 0,
            counters: counters.into_iter().map(|counter| (counter, CounterMode::default())).collect(),
            at: None,
        };
        self.signals = signals.into_iter().map(output).collect();
    }

    /// Assigns signals to submodules from now on, in order; other submodules carry none. Values are retained.
    pub fn lay_out<'s>(&mut self, submodules: impl IntoIterator<Item = ((u16, u16), &'s [usize])>) {
        self.submodules.iter_mut().for_each(|submodule| submodule.signals.clear());
        self.signals.iter_mut().for_each(|signal| signal.at = None);
        let mut at = 0;
        for ((slot, subslot), signals) in submodules {
            let place = self.submodule_index(slot, subslot);
            for &number in signals {
                let Some(signal) = self.signals.get_mut(number) else { continue };
                signal.at = signal.at.or(Some(at));
                at += signal.bytes;
                self.submodules[place].signals.push(number);
            }
        }
    }

    /// Declares `length` signals of one byte each and assigns them to one submodule.
    pub fn declare_bytes(&mut self, slot: u16, subslot: u16, length: usize) {
        self.declare((0..length).map(|_| OutputSignal { bytes: 1, ..OutputSignal::default() }));
        self.lay_out([((slot, subslot), &*(0..length).collect::<Vec<_>>())]);
    }

    /// Sets `width` bits of a signal from bit `low` on. A counter at these bits stops. Discards bytes set by
    /// [`set_bytes`](Self::set_bytes).
    pub fn set(&mut self, signal: usize, low: u32, width: u32, number: u64) {
        let Some(signal) = self.signals.get_mut(signal) else { return };
        let bits = mask(low, width);
        signal.set = signal.set & !bits | number.checked_shl(low).unwrap_or(0) & bits;
        self.bytes = None;
        signal.count(low, width, CounterMode::AsSet);
    }

    /// Sets the mode of the counter at these bits of a signal.
    pub fn count(&mut self, signal: usize, low: u32, width: u32, mode: CounterMode) {
        if let Some(signal) = self.signals.get_mut(signal) {
            signal.count(low, width, mode);
        }
    }

    /// Sets all output bytes of the connection at once; bytes beyond `bytes` keep the value of their signal. All counters stop.
    pub fn set_bytes(&mut self, bytes: &[u8]) {
        self.bytes = Some(bytes.to_vec());
        let counters = self.signals.iter_mut().flat_map(|signal| &mut signal.counters);
        counters.for_each(|(_, mode)| *mode = CounterMode::AsSet);
    }

    /// Sets every signal to 0 and restarts every counter.
    pub fn reset(&mut self) {
        self.bytes = None;
        for signal in &mut self.signals {
            signal.set = 0;
            signal.counters.iter_mut().for_each(|(_, mode)| *mode = CounterMode::Counting);
        }
    }

    /// Sets the provider status (IOPS) of one submodule, or of all. Bad means "bad, detected by the controller". A submodule is
    /// good only if its own status and the status of all are good.
    pub fn status(&mut self, submodule: Option<(u16, u16)>, good: bool) {
        match submodule {
            Some((slot, subslot)) => {
                let at = self.submodule_index(slot, subslot);
                self.submodules[at].bad = !good;
            }
            None => self.all_bad = !good,
        }
    }

    /// Sets DataStatus of the frames on PROFINET.
    pub fn data_status(&mut self, status: u8) {
        self.data_status = Some(status);
    }

    /// DataStatus of the frames on PROFINET; `None`: the usual one.
    pub fn sent_data_status(&self) -> Option<u8> {
        self.data_status
    }

    /// Stops (`true`) or resumes cyclic frames. The device ends a connection that receives no frames.
    pub fn pause(&mut self, paused: bool) {
        self.paused = paused;
    }

    /// Whether cyclic frames are stopped.
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// The index of a submodule's outputs; it never changes.
    pub(crate) fn submodule_index(&mut self, slot: u16, subslot: u16) -> usize {
        let is_it = |of: &OutputSubmodule| (of.slot, of.subslot) == (slot, subslot);
        if let Some(at) = self.submodules.iter().position(is_it) {
            return at;
        }
        self.submodules.push(OutputSubmodule { slot, subslot, signals: Vec::new(), bad: false });
        self.submodules.len() - 1
    }

    /// Writes the outputs of the submodule at index `submodule_index` into `frame`, as [`step`](Outputs::step) computed them. Bytes without
    /// a signal are 0.
    pub(crate) fn copy(&self, place: usize, frame: &mut [u8]) {
        frame.fill(0);
        let signals = self.submodules.get(place).map_or(&[][..], |submodule| &submodule.signals);
        let mut rest = frame;
        for signal in signals.iter().filter_map(|number| self.signals.get(*number)) {
            let length = rest.len().min(signal.bytes);
            let (own, behind) = rest.split_at_mut(length);
            own.copy_from_slice(&signal.encode(signal.sent)[..length]);
            rest = behind;
        }
    }

    /// Whether the submodule at index `submodule_index` has a good status.
    pub(crate) fn is_good(&self, place: usize) -> bool {
        !self.all_bad && !self.submodules.get(place).is_some_and(|submodule| submodule.bad)
    }

    /// Computes the values of the next frame: the values set, and the next value of each counter.
    pub(crate) fn step(&mut self) {
        let CyclicOutputs { signals, bytes, .. } = self;
        for signal in signals {
            if let Some(at) = signal.at {
                let given = bytes.as_deref().and_then(|bytes| bytes.get(at..));
                signal.step(given.unwrap_or_default());
            }
        }
    }
}

impl OutputState {
    fn count(&mut self, low: u32, width: u32, mode: CounterMode) {
        let at_bits = self.counters.iter_mut().filter(|(counter, _)| (counter.low, counter.width) == (low, width));
        at_bits.for_each(|(_, now)| *now = mode);
    }

    /// A number in the bytes of the wire; those beyond the length of the signal mean nothing.
    fn encode(&self, number: u64) -> [u8; 8] {
        if self.little_endian {
            number.to_le_bytes()
        } else {
            (number << (64 - 8 * self.bytes.clamp(1, 8))).to_be_bytes()
        }
    }

    fn decode(&self, bytes: [u8; 8]) -> u64 {
        let unused = 64 - 8 * self.bytes.clamp(1, 8);
        if self.little_endian {
            u64::from_le_bytes(bytes) << unused >> unused
        } else {
            u64::from_be_bytes(bytes) >> unused
        }
    }

    /// Computes the next value; `given` bytes replace the value that was set.
    fn step(&mut self, given: &[u8]) {
        let mut bytes = self.encode(self.set);
        let length = given.len().min(self.bytes);
        bytes[..length].copy_from_slice(&given[..length]);
        let mut next = self.decode(bytes);
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
