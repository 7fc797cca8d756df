//! Names of bytes in cyclic data: in `io.inputs: "G1_ZSW: 20 00 *"` each name is a signal, with as many bytes as it has.

use super::error::{Mistake, Read};
use super::frame::StepScope;
use super::yaml::{Node, NodeKind};
use suite::device::NameKind;

impl StepScope<'_, '_> {
    /// Checks the names of bytes in the value of `io.inputs` or `io.outputs`; other names have free words.
    pub(super) fn signals_of_octets(&self, node: &Node, kind: &NameKind) -> Read<()> {
        if !matches!(kind, NameKind::InputOctets(_) | NameKind::OutputOctets(_)) {
            return Ok(());
        }
        match &node.kind {
            NodeKind::Scalar { text, .. } => self.signals_named(node, text),
            NodeKind::Sequence(items) => items.iter().try_for_each(|item| self.signals_of_octets(item, kind)),
            NodeKind::Mapping(entries) => entries.iter().try_for_each(|(_, value)| self.signals_of_octets(value, kind)),
        }
    }

    fn signals_named(&self, node: &Node, text: &str) -> Read<()> {
        // What is wrong with the bytes themselves is found where they are read.
        let Ok(pattern) = expression::pattern(text) else { return Ok(()) };
        let signals = &self.names.device().signals;
        for (name, octets) in pattern.groups() {
            let Some(signal) = signals.iter().find(|signal| signal.name == name) else {
                return Err(Mistake::unknown(node.spot, "signal", name, signals.iter().map(|of| of.name.as_str())));
            };
            let width = signal.width as usize / 8;
            if let Some(octets) = octets.filter(|octets| *octets != width) {
                return Err(node.wrong(format!("`{name}` has {width} bytes, and {octets} are written")));
            }
            self.names.mark("signal", name);
        }
        Ok(())
    }
}
