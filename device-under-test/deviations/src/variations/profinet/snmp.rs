//! What the SNMP agent of a PROFINET device may have and refuse, beyond the objects that tools read.

use crate::needs::Need;
use crate::seams::stack::Stack;
use crate::tables::Group;
use alloc::vec::Vec;
use device_stack::profinet::{MibObject, MibValue};
use reference_devices::manuals::PROFINET_IO;
use wire::datagram::Datagram;
use wire::snmp::{PORT, SnmpMessage, SnmpPduKind};

const MIB_2: &[u32] = &[1, 3, 6, 1, 2, 1];
const OBJECT_ID: &[u32] = &[1, 3, 6, 1, 2, 1, 1, 2, 0];
const UP_TIME: &[u32] = &[1, 3, 6, 1, 2, 1, 1, 3, 0];
const CONTACT: &[u32] = &[1, 3, 6, 1, 2, 1, 1, 4, 0];
const NAME: &[u32] = &[1, 3, 6, 1, 2, 1, 1, 5, 0];
const LOCATION: &[u32] = &[1, 3, 6, 1, 2, 1, 1, 6, 0];
const IF_NUMBER: &[u32] = &[1, 3, 6, 1, 2, 1, 2, 1, 0];
const IF_TABLE: &[u32] = &[1, 3, 6, 1, 2, 1, 2, 2, 1];
const IF_INDEX: &[u32] = &[1, 3, 6, 1, 2, 1, 2, 2, 1, 1];
/// lldpLocManAddrIfId: the number of an interface, too.
const OF_ADDRESS: &[u32] = &[1, 0, 8802, 1, 1, 2, 1, 3, 8, 1, 5];
/// The subtree of a manufacturer: 32473 is the number for documentation (RFC 5612).
const MAKER: &[u32] = &[1, 3, 6, 1, 4, 1, 32473];
/// How far the numbers of the interfaces are moved.
const MOVED: u32 = 100;

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&PROFINET_IO)],
    deviations: permitted! {
        "snmp-more-groups" "The agent also has the groups ip and snmp of MIB-II and objects of the manufacturer."
            "RFC 1213, 3.11: an agent has the groups of what it implements; RFC 1155, 3.1.4: below enterprises each vendor has its own objects"
            => |d| more_groups(&mut d.stack);
        "snmp-set-unanswered" "A Set is not answered."
            "RFC 1157, 4.1: a message of a community that may not do what it asks is discarded"
            => |d| d.stack.filter_frames(|_, frame| !is_set(frame));
        "snmp-name-of-its-own" "The objects sysContact, sysName and sysLocation have texts of their own; sysName is not the name of the station."
            "RFC 1213, 6.1: these texts are assigned by an administrator"
            => |d| texts(&mut d.stack);
        "snmp-up-time-by-the-second" "The object sysUpTime is updated once a second."
            "RFC 1155, 3.2.3.5 gives the unit of TimeTicks; how often sysUpTime is updated is said nowhere"
            => |d| d.stack.snmp_objects(|objects| objects.iter_mut().for_each(|object| {
                if let (UP_TIME, MibValue::Ticks(ticks)) = (&object.name[..], &mut object.value) {
                    *ticks -= *ticks % 100;
                }
            }));
        "snmp-object-of-the-vendor" "The object sysObjectID is in the subtree of the manufacturer."
            "RFC 1213, 6.1: sysObjectID is a name that the vendor assigned"
            => |d| d.stack.snmp_objects(|objects| set(objects, OBJECT_ID, &MibValue::Name([MAKER, &[1, 17]].concat())));
        "snmp-interfaces-from-101" "The interfaces have the numbers from 101 on."
            "RFC 2863, 3.1.5: the numbers of interfaces need not be contiguous nor end at ifNumber"
            => |d| d.stack.snmp_objects(|objects| renumber(objects));
        "snmp-loopback" "The last interface is a loopback, without MAC address."
            "RFC 2863, 3.1.8: which interfaces a device has is its own; ifPhysAddress is empty where there is none"
            => |d| d.stack.snmp_objects(loopback);
    },
}];

fn is_set(frame: &[u8]) -> bool {
    Datagram::parse(frame).is_ok_and(|datagram| {
        datagram.destination.port() == PORT
            && SnmpMessage::parse(datagram.payload).is_ok_and(|message| message.kind == SnmpPduKind::SET)
    })
}

fn set(objects: &mut [MibObject], name: &[u32], value: &MibValue) {
    objects.iter_mut().filter(|object| object.name == name).for_each(|object| object.value = value.clone());
}

fn in_order(objects: &mut [MibObject]) {
    objects.sort_by(|one, other| one.name.cmp(&other.name));
}

fn scalar(parts: &[&[u32]], value: MibValue) -> MibObject {
    MibObject { name: [parts.concat(), Vec::from([0])].concat(), instance: 1, value }
}

fn more_groups(stack: &mut Stack) {
    stack.snmp_objects(|objects| {
        objects.extend([
            // ipForwarding, ipDefaultTTL and snmpInPkts.
            scalar(&[MIB_2, &[4, 1]], MibValue::Integer(2)),
            scalar(&[MIB_2, &[4, 2]], MibValue::Integer(64)),
            scalar(&[MIB_2, &[11, 1]], MibValue::Counter(17)),
            scalar(&[MAKER, &[1, 1]], MibValue::Octets(b"V1.2".to_vec())),
            scalar(&[MAKER, &[1, 2]], MibValue::Gauge(312)),
        ]);
        in_order(objects);
    });
}

fn texts(stack: &mut Stack) {
    stack.snmp_objects(|objects| {
        for (name, text) in [(CONTACT, "service@example.org"), (NAME, "Encoder 17"), (LOCATION, "hall 3")] {
            set(objects, name, &MibValue::Octets(text.as_bytes().to_vec()));
        }
    });
}

/// The objects of the interfaces.
fn of_interfaces(objects: &mut [MibObject]) -> impl Iterator<Item = &mut MibObject> {
    objects.iter_mut().filter(|object| object.name.starts_with(IF_TABLE))
}

fn renumber(objects: &mut [MibObject]) {
    for object in of_interfaces(objects) {
        if let Some(last) = object.name.last_mut() {
            *last += MOVED;
        }
    }
    let numbers = objects.iter_mut().filter(|of| of.name.starts_with(IF_INDEX) || of.name.starts_with(OF_ADDRESS));
    for object in numbers {
        if let MibValue::Integer(number) = &mut object.value {
            *number += MOVED as i32;
        }
    }
    in_order(objects);
}

/// Adds an interface of the type softwareLoopback(24) after the others.
fn loopback(objects: &mut Vec<MibObject>) {
    let Some(last) = of_interfaces(objects).filter_map(|object| object.name.last().copied()).max() else { return };
    let mut row: Vec<MibObject> = of_interfaces(objects)
        .filter(|object| object.name.last() == Some(&last))
        .map(|object| object.clone())
        .collect();
    for object in &mut row {
        let column = object.name.get(IF_TABLE.len()).copied();
        if let Some(number) = object.name.last_mut() {
            *number += 1;
        }
        object.value = match column {
            Some(1) => MibValue::Integer(last as i32 + 1),
            Some(2) => MibValue::Octets(b"lo".to_vec()),
            Some(3) => MibValue::Integer(24),
            Some(6) => MibValue::Octets(Vec::new()),
            _ => object.value.clone(),
        };
    }
    objects.extend(row);
    for object in objects.iter_mut().filter(|object| object.name == IF_NUMBER) {
        if let MibValue::Integer(count) = &mut object.value {
            *count += 1;
        }
    }
    in_order(objects);
}
