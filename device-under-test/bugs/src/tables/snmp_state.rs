//! Deviations of the SNMP agent with state.

use alloc::vec::Vec;
use device_stack::profinet::{MibName, MibObject, MibValue, SnmpAnswer, StackHooks, StackView};
use wire::datagram::Datagram;
use wire::snmp::{self, SnmpMessage};

const SET: u8 = 0xA3;
const REMOTE: &[u32] = &[1, 0, 8802, 1, 1, 2, 1, 4];

/// Gives objects the values of each Set.
#[derive(Default)]
pub struct WritesObjects {
    written: Vec<(MibName, MibValue)>,
}

impl StackHooks for WritesObjects {
    fn snmp_objects(&mut self, objects: &mut Vec<MibObject>) {
        for object in objects {
            if let Some((_, value)) = self.written.iter().rev().find(|(name, _)| *name == object.name) {
                object.value = value.clone();
            }
        }
    }

    fn snmp_answer(&mut self, answer: &mut SnmpAnswer) {
        if answer.request == SET {
            (answer.error_status, answer.error_index) = (0, 0);
            self.written.extend(answer.bindings.iter().cloned());
        }
    }
}

/// Keeps the last neighbour in LLDP-MIB.
#[derive(Default)]
pub struct KeepsNeighbour {
    kept: Vec<MibObject>,
}

impl StackHooks for KeepsNeighbour {
    fn snmp_objects(&mut self, objects: &mut Vec<MibObject>) {
        let of_neighbour: Vec<MibObject> =
            objects.iter().filter(|object| object.name.starts_with(REMOTE)).cloned().collect();
        if of_neighbour.is_empty() {
            objects.extend(self.kept.iter().cloned());
            objects.sort_by(|one, other| one.name.cmp(&other.name));
        } else {
            self.kept = of_neighbour;
        }
    }
}

/// Answers nothing after a message that cannot be read.
#[derive(Default)]
pub struct StopsAfterDamage {
    has_stopped: bool,
}

impl StackHooks for StopsAfterDamage {
    fn received_frames(&mut self, _: &StackView<'_>, mut frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        frames.retain(|frame| {
            let datagram = Datagram::parse(frame).ok().filter(|of| of.destination.port() == snmp::PORT);
            let Some(datagram) = datagram else { return true };
            self.has_stopped |= SnmpMessage::parse(datagram.payload).is_err();
            !self.has_stopped
        });
        frames
    }
}
