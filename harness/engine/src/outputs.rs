//! The outputs of a device as our stations keep them: what a `set` gives them holds until the trial ends, over reconnects too.

use controllers::outputs::{Counter, CounterMode, OutputSignal, Outputs};
use suite::device::{Device, From, NameKind};

/// A change of the outputs by a `set`.
#[derive(Clone, Debug)]
pub enum OutputChange<'a> {
    /// A signal, its bit or its field gets a number; a counting field stands still.
    Number(&'a NameKind, i128),
    /// A counting field counts from now on, or is held.
    Counting(&'a NameKind, CounterMode),
    /// All output octets of the module at once; nothing counts any more.
    Octets(Vec<u8>),
}

impl OutputChange<'_> {
    /// Makes the change.
    pub fn apply(self, outputs: &mut Outputs) {
        match self {
            OutputChange::Number(NameKind::Signal { signal, low, width, .. }, number) => {
                outputs.set(*signal, *low, *width, number as u64);
            }
            OutputChange::Counting(NameKind::Signal { signal, low, width, .. }, mode) => {
                outputs.count(*signal, *low, *width, mode);
            }
            OutputChange::Number(..) | OutputChange::Counting(..) => {}
            OutputChange::Octets(octets) => outputs.set_bytes(&octets),
        }
    }
}

/// Declares the signals of a device, by their numbers there; its inputs are none of ours and have no counters.
pub fn declare(device: &Device, outputs: &mut Outputs) {
    outputs.declare(device.signals.iter().map(|of| {
        let counting = of.fields.iter().filter(|field| of.from == From::Controller && field.low + field.width <= 16);
        let counter = |field: &suite::device::Field| {
            let (first, last) = field.counts?;
            Some(Counter { low: field.low, width: field.width, first: first.into(), last: last.into() })
        };
        OutputSignal { bytes: of.width as usize / 8, counters: counting.filter_map(counter).collect() }
    }));
}

/// Says where the submodules of `module` have the signals.
pub fn lay_out(device: &Device, module: usize, outputs: &mut Outputs) {
    let Some(module) = device.modules.get(module) else { return };
    let submodules = module.submodules.iter().filter_map(|&index| device.submodules.get(index));
    outputs.lay_out(submodules.map(|of| ((of.slot, of.subslot), &*of.outputs)));
}
