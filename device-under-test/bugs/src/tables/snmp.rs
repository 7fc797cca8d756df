//! Deviations of the SNMP agent: what it answers, and what its objects say.

use super::snmp_state::{KeepsNeighbour, StopsAfterDamage, WritesObjects};
use super::{Deviation, Group};
use crate::needs::Need;
use crate::seams::stack::Stack;
use alloc::vec::Vec;
use device_stack::profinet::{MibObject, MibValue, SnmpAnswer, StackCheck};
use reference_devices::manuals;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Of(&manuals::PROFINET_IO)], deviations: BUGS }];

const GET_NEXT: u8 = 0xA1;
const GET_BULK: u8 = 0xA5;
const V1: i32 = 0;
const NO_SUCH_NAME: i32 = 2;
const GENERAL_ERROR: i32 = 5;

const SYSTEM: &[u32] = &[1, 3, 6, 1, 2, 1, 1];
const INTERFACES: &[u32] = &[1, 3, 6, 1, 2, 1, 2];
const LLDP: &[u32] = &[1, 0, 8802, 1, 1, 2, 1];
const LLDP_LOCAL_PORT: &[u32] = &[1, 0, 8802, 1, 1, 2, 1, 3, 7];
const LLDP_REMOTE: &[u32] = &[1, 0, 8802, 1, 1, 2, 1, 4];
const LLDP_PNO: &[u32] = &[1, 0, 8802, 1, 1, 2, 1, 5];

const BUGS: &[Deviation] = bugs! {
    "snmp-silent" "The SNMP agent does not answer." => |d| d.stack.drop_snmp();
    "snmp-v1-ignored" "Messages of SNMPv1 are not answered." => |d| d.stack.set(StackCheck::SnmpVersion(0), false);
    "snmp-v2c-ignored" "Messages of SNMPv2c are not answered." => |d| d.stack.set(StackCheck::SnmpVersion(1), false);
    "snmp-v3-answered" "Messages of an unknown version are answered." => |d| d.stack.check(|check, right| match check {
        StackCheck::SnmpVersion(_) => true,
        _ => right,
    });
    "snmp-every-community" "Every community is answered." => |d| d.stack.check(|check, right| match check {
        StackCheck::SnmpCommunity(_) => true,
        _ => right,
    });
    "snmp-public-ignored" "The community public is not answered."
        => |d| d.stack.set(StackCheck::SnmpCommunity(b"public"), false);
    "snmp-without-system" "The group system is missing." => |d| lacks(&mut d.stack, SYSTEM);
    "snmp-without-interfaces" "The group interfaces is missing." => |d| lacks(&mut d.stack, INTERFACES);
    "snmp-without-lldp" "LLDP-MIB is missing." => |d| lacks(&mut d.stack, LLDP);
    "snmp-without-pno" "The extension of LLDP-MIB for PROFINET is missing." => |d| lacks(&mut d.stack, LLDP_PNO);
    "snmp-neighbour-missing" "The neighbour is not in LLDP-MIB." => |d| lacks(&mut d.stack, LLDP_REMOTE);
    "snmp-neighbour-kept" "The neighbour stays in LLDP-MIB when its announcement is no longer valid."
        => |d| d.stack.add(KeepsNeighbour::default());
    "snmp-description-empty" "The object sysDescr is empty." => |d| is(&mut d.stack, &[SYSTEM, &[1]], MibValue::Octets(Vec::new()));
    "snmp-object-id-zero" "The object sysObjectID is 0.0." => |d| is(&mut d.stack, &[SYSTEM, &[2]], MibValue::Name(Vec::from([0, 0])));
    "snmp-up-time-as-counter" "The object sysUpTime is a counter." => |d| is(&mut d.stack, &[SYSTEM, &[3]], MibValue::Counter(1));
    "snmp-up-time-in-milliseconds" "The object sysUpTime counts milliseconds."
        => |d| up_time(&mut d.stack, |ticks| ticks * 10);
    "snmp-up-time-in-seconds" "The object sysUpTime counts seconds." => |d| up_time(&mut d.stack, |ticks| ticks / 100);
    "snmp-up-time-frozen" "The object sysUpTime does not advance." => |d| is(&mut d.stack, &[SYSTEM, &[3]], MibValue::Ticks(1));
    "snmp-services-as-gauge" "The object sysServices is a gauge." => |d| is(&mut d.stack, &[SYSTEM, &[7]], MibValue::Gauge(78));
    "snmp-texts-as-numbers" "The objects sysContact, sysName and sysLocation are numbers." => |d| [4, 5, 6].into_iter().for_each(|number| {
        is(&mut d.stack, &[SYSTEM, &[number]], MibValue::Integer(0));
    });
    "snmp-no-interfaces" "The object ifNumber is 0." => |d| is(&mut d.stack, &[INTERFACES, &[1]], MibValue::Integer(0));
    "snmp-interfaces-of-other-types" "The values of the interfaces are TimeTicks."
        => |d| is(&mut d.stack, &[INTERFACES, &[2]], MibValue::Ticks(1));
    "snmp-stops-after-damage" "After a message that cannot be read the agent answers no more."
        => |d| d.stack.add(StopsAfterDamage::default());
    "snmp-traffic-as-integer" "The counters of octets are INTEGER." => |d| [10, 16].into_iter().for_each(|column| {
        is(&mut d.stack, &[INTERFACES, &[2, 1, column]], MibValue::Integer(7));
    });
    "snmp-chassis-of-another-subtype" "The object lldpLocChassisIdSubtype is networkAddress(5)."
        => |d| is(&mut d.stack, &[LLDP, &[3, 1]], MibValue::Integer(5));
    "snmp-chassis-empty" "The object lldpLocChassisId is empty." => |d| is(&mut d.stack, &[LLDP, &[3, 2]], MibValue::Octets(Vec::new()));
    "snmp-ports-by-interface-name" "The object lldpLocPortId is the name of the interface in the operating system."
        => |d| is(&mut d.stack, &[LLDP_LOCAL_PORT, &[1, 3]], MibValue::Octets(Vec::from(*b"eth0")));
    "snmp-port-of-another-subtype" "The object lldpLocPortIdSubtype is interfaceName(5)."
        => |d| is(&mut d.stack, &[LLDP_LOCAL_PORT, &[1, 2]], MibValue::Integer(5));
    "snmp-interval-of-30-s" "The object lldpMessageTxInterval is 30 s." => |d| is(&mut d.stack, &[LLDP, &[1, 1]], MibValue::Integer(30));
    "snmp-neighbour-of-another-port" "The neighbour in LLDP-MIB has another port."
        => |d| is(&mut d.stack, &[LLDP_REMOTE, &[1, 1, 7]], MibValue::Octets(Vec::from(*b"port-001")));
    "snmp-neighbour-of-another-name" "The neighbour in LLDP-MIB has another chassis ID."
        => |d| is(&mut d.stack, &[LLDP_REMOTE, &[1, 1, 5]], MibValue::Octets(Vec::from(*b"another")));
    "snmp-station-name-missing" "The object lldpXPnoLocPortNoS is empty."
        => |d| is(&mut d.stack, &[LLDP_PNO, &[3791, 1, 2, 1, 1, 6]], MibValue::Octets(Vec::new()));
    "snmp-another-request-id" "A response has another request ID." => |d| d.stack.snmp_answer(|answer| answer.request_id ^= 1);
    "snmp-v1-exceptions" "SNMPv1 has the exceptions of SNMPv2." => |d| d.stack.snmp_answer(|answer| {
        if answer.version == V1 && answer.error_status == NO_SUCH_NAME {
            (answer.error_status, answer.error_index) = (0, 0);
            answer.bindings.iter_mut().for_each(|(_, value)| *value = MibValue::Raw(Vec::from([0x80, 0])));
        }
    });
    "snmp-v2c-errors-of-v1" "SNMPv2c has the error noSuchName in place of exceptions." => |d| d.stack.snmp_answer(|answer| {
        let exception = |value: &MibValue| matches!(value, MibValue::Raw(octets) if octets.len() == 2 && octets[0] & 0x80 != 0);
        if let Some(at) = answer.bindings.iter().position(|(_, value)| exception(value)) {
            (answer.error_status, answer.error_index) = (NO_SUCH_NAME, at as i32 + 1);
        }
    });
    "snmp-error-index-0" "The error of a response names no object." => |d| d.stack.snmp_answer(|answer| answer.error_index = 0);
    "snmp-general-errors" "Each error is genErr." => |d| d.stack.snmp_answer(|answer| {
        if answer.error_status != 0 {
            answer.error_status = GENERAL_ERROR;
        }
    });
    "snmp-only-the-first-object" "Only the first object of a request is answered."
        => |d| d.stack.snmp_answer(|answer| answer.bindings.truncate(1));
    "snmp-instance-is-no-object" "A wrong instance of an object is reported as noSuchObject." => |d| d.stack.snmp_answer(|answer| {
        replace(answer, &[0x81, 0], &[0x80, 0]);
    });
    "snmp-end-is-no-object" "The end of the objects is reported as noSuchObject." => |d| d.stack.snmp_answer(|answer| {
        replace(answer, &[0x82, 0], &[0x80, 0]);
    });
    "snmp-walk-stops" "GetNext finds nothing after the group system." => |d| d.stack.snmp_answer(|answer| {
        if answer.request == GET_NEXT {
            let is_later = |name: &[u32]| name > SYSTEM && !name.starts_with(SYSTEM);
            answer.bindings.iter_mut().filter(|(name, _)| is_later(name)).for_each(|(_, value)| {
                *value = MibValue::Raw(Vec::from([0x82, 0]));
            });
        }
    });
    "snmp-walk-out-of-order" "GetNext returns the objects in the order of their addition." => |d| d.stack.snmp_objects(|objects| {
        objects.reverse();
    });
    "snmp-bulk-as-get-next" "GetBulk returns each object once." => |d| d.stack.snmp_answer(|answer| {
        if answer.request == GET_BULK {
            answer.bindings.truncate(1);
        }
    });
    "snmp-objects-writable" "A Set is carried out, also where an object can only be read." => |d| d.stack.add(WritesObjects::default());
};

/// Removes the objects below `group`.
fn lacks(stack: &mut Stack, group: &'static [u32]) {
    stack.snmp_objects(move |objects| objects.retain(|object| !object.name.starts_with(group)));
}

/// Changes the values of the objects below a name.
fn is(stack: &mut Stack, name: &[&[u32]], value: MibValue) {
    change(stack, name, move |old| *old = value.clone());
}

/// Changes the value of sysUpTime.
fn up_time(stack: &mut Stack, of: fn(u32) -> u32) {
    change(stack, &[SYSTEM, &[3]], move |value| {
        if let MibValue::Ticks(ticks) = value {
            *ticks = of(*ticks);
        }
    });
}

/// Changes the values of the objects whose names begin so.
fn change(stack: &mut Stack, name: &[&[u32]], mut change: impl FnMut(&mut MibValue) + 'static) {
    let name = name.concat();
    stack.snmp_objects(move |objects| {
        let found = objects.iter_mut().filter(|object: &&mut MibObject| object.name.starts_with(&name));
        found.for_each(|object| change(&mut object.value));
    });
}

/// Replaces the values with these bytes.
fn replace(answer: &mut SnmpAnswer, from: &[u8], to: &[u8]) {
    for (_, value) in &mut answer.bindings {
        if matches!(value, MibValue::Raw(octets) if octets == from) {
            *value = MibValue::Raw(to.to_vec());
        }
    }
}
