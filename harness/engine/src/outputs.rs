//! The outputs of a device in the harness's stations: the effect of a `set` lasts until the trial ends, also over reconnects.

use controllers::outputs::{CounterMode, CyclicOutputs, OutputSignal, SignalCounter};
use suite::device::{DeviceDescription, NameKind, SignalSender};

/// A change of the outputs by a `set`.
#[derive(Clone, Debug)]
pub enum OutputChange<'a> {
    /// A number for a signal, a bit or a field; a counting field stops.
    Number(&'a NameKind, i128),
    /// A counting field starts to count, or is held.
    Counting(&'a NameKind, CounterMode),
    /// All output bytes of the module at once; all counters stop.
    Octets(Vec<u8>),
}

impl OutputChange<'_> {
    /// Makes the change.
    pub fn apply(self, outputs: &mut CyclicOutputs) {
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

/// Declares the output signals of a device by their indices; inputs are declared without counters.
pub fn declare(device: &DeviceDescription, outputs: &mut CyclicOutputs) {
    outputs.declare(device.signals.iter().map(|of| {
        let counting =
            of.fields.iter().filter(|field| of.from == SignalSender::Controller && field.low + field.width <= 16);
        let counter = |field: &suite::device::SignalField| {
            let (first, last) = field.counts?;
            Some(SignalCounter { low: field.low, width: field.width, first: first.into(), last: last.into() })
        };
        let (bytes, counters) = (of.width as usize / 8, counting.filter_map(counter).collect());
        OutputSignal { bytes, little_endian: of.little_endian, counters }
    }));
}

/// Sets the offsets of the signals in the submodules of `module`.
pub fn lay_out(device: &DeviceDescription, module: usize, outputs: &mut CyclicOutputs) {
    let Some(module) = device.modules.get(module) else { return };
    let submodules = module.submodules.iter().filter_map(|&index| device.submodules.get(index));
    outputs.lay_out(submodules.map(|of| ((of.slot, of.subslot), &*of.outputs)));
}
