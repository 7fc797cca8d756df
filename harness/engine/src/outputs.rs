//! The outputs of a trial: what `set` gave them holds until the trial ends, over reconnects too.

use controllers::profinet_io::{Counter, CounterMode, Outputs};
use suite::device::{Device, From, NameKind};

/// The value of every output signal, and how its counting fields count.
#[derive(Clone, Debug)]
pub struct OutputImage {
    values: Vec<u64>,
    counters: Vec<(usize, usize, CounterMode)>,
    octets: Option<Vec<u8>>,
}

impl OutputImage {
    /// All outputs 0, signs of life counting.
    pub fn new(device: &Device) -> OutputImage {
        let mut counters = Vec::new();
        for (signal, of) in device.signals.iter().enumerate().filter(|(_, of)| of.from == From::Controller) {
            for (field, _) in of.fields.iter().enumerate().filter(|(_, field)| field.counts.is_some()) {
                counters.push((signal, field, CounterMode::Counting));
            }
        }
        OutputImage { values: vec![0; device.signals.len()], counters, octets: None }
    }

    /// Sets a signal, its bit or its field to a number; a number in a counting field stands still.
    pub fn set(&mut self, name: &NameKind, number: i128) {
        let NameKind::Signal { signal, low, width, field, .. } = name else { return };
        let Some(value) = self.values.get_mut(*signal) else { return };
        let mask = if *width >= 64 { u64::MAX } else { (1u64 << width) - 1 };
        let number = (number as u64) & mask;
        *value = (*value & !(mask << low)) | (number << low);
        self.octets = None;
        self.count(*signal, *field, CounterMode::Fixed(number as u16));
    }

    /// Says how the counting field `name` counts from now on.
    pub fn set_counting(&mut self, name: &NameKind, mode: CounterMode) {
        if let NameKind::Signal { signal, field, .. } = name {
            self.count(*signal, *field, mode);
        }
    }

    fn count(&mut self, signal: usize, field: Option<usize>, mode: CounterMode) {
        let Some(field) = field else { return };
        match self.counters.iter_mut().find(|counter| (counter.0, counter.1) == (signal, field)) {
            Some(counter) => counter.2 = mode,
            None if mode == CounterMode::Counting => self.counters.push((signal, field, mode)),
            None => {}
        }
    }

    /// Sets all output octets of the module at once; nothing counts any more.
    pub fn set_octets(&mut self, octets: &[u8]) {
        self.octets = Some(octets.to_vec());
        self.counters.clear();
    }

    /// Puts the values where the submodules of `module` have them.
    pub fn apply(&self, device: &Device, module: usize, outputs: &mut Outputs) {
        let Some(module) = device.modules.get(module) else { return };
        let mut given = self.octets.as_deref();
        if given.is_some() {
            outputs.no_counters();
        }
        for submodule in module.submodules.iter().filter_map(|&index| device.submodules.get(index)) {
            let mut octets = Vec::with_capacity(submodule.output_octets.into());
            let before = outputs.octets(submodule.slot, submodule.subslot).to_vec();
            let mut counted = Vec::new();
            for &signal in &submodule.outputs {
                let of = &device.signals[signal];
                counted.extend(self.counters_of(device, signal, (submodule.slot, submodule.subslot, octets.len())));
                let width = of.width as usize / 8;
                octets.extend_from_slice(&self.values[signal].to_be_bytes()[8 - width..]);
            }
            if let Some(all) = &mut given {
                let length = octets.len().min(all.len());
                octets[..length].copy_from_slice(&all[..length]);
                *all = &all[length..];
            }
            for counter in counted {
                keep(&counter, &before, &mut octets);
                outputs.count(counter);
            }
            outputs.set(submodule.slot, submodule.subslot, 0, &octets);
        }
    }

    /// The counting fields of a signal that begins at octet `at`; they lie in the last two octets of it.
    fn counters_of(&self, device: &Device, signal: usize, (slot, subslot, at): (u16, u16, usize)) -> Vec<Counter> {
        let of = &device.signals[signal];
        let octet = at + (of.width as usize / 8).saturating_sub(2);
        let counters = self.counters.iter().filter(|counter| counter.0 == signal);
        counters
            .filter_map(|(_, field, mode)| {
                let field = of.fields.get(*field).filter(|field| field.low + field.width <= 16)?;
                let (first, last) = field.counts?;
                Some(Counter {
                    slot,
                    subslot,
                    octet: octet as u16,
                    mask: (((1u32 << field.width) - 1) << field.low) as u16,
                    first: first as u16,
                    last: last as u16,
                    mode: *mode,
                })
            })
            .collect()
    }
}

/// A field that counts by itself goes on from where it stands.
fn keep(counter: &Counter, before: &[u8], octets: &mut [u8]) {
    let at = usize::from(counter.octet);
    for (index, mask) in counter.mask.to_be_bytes().into_iter().enumerate() {
        if let (Some(old), Some(new)) = (before.get(at + index), octets.get_mut(at + index)) {
            *new = (*new & !mask) | (old & mask);
        }
    }
}
