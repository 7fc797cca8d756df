//! Requests to the agent and its answers.

use super::super::hooks::{AttachedStackHooks, StackCheck};
use super::ber::{Elements, INTEGER, MibName, MibValue, OCTETS, SEQUENCE, element, integer, put_name};
use super::objects::MibObject;
use alloc::vec::Vec;

const GET: u8 = 0xA0;
const GET_NEXT: u8 = 0xA1;
const RESPONSE: u8 = 0xA2;
const SET: u8 = 0xA3;
const GET_BULK: u8 = 0xA5;

const V1: i32 = 0;
const V2C: i32 = 1;

const TOO_BIG: i32 = 1;
const NO_SUCH_NAME: i32 = 2;
const NO_ACCESS: i32 = 6;
const NO_CREATION: i32 = 11;
const NOT_WRITABLE: i32 = 17;

const NO_SUCH_OBJECT: [u8; 2] = [0x80, 0];
const NO_SUCH_INSTANCE: [u8; 2] = [0x81, 0];
const END_OF_MIB_VIEW: [u8; 2] = [0x82, 0];

/// The community that may read, and the one that may write.
const READERS: &[u8] = b"public";
const WRITERS: &[u8] = b"private";
/// The longest response in bytes: one datagram in one frame.
const LONGEST: usize = 1472;

/// A response before it is encoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SnmpAnswer {
    /// The kind of the request: the tag of its PDU.
    pub request: u8,
    /// The version: 0 is SNMPv1, 1 is SNMPv2c.
    pub version: i32,
    /// The community.
    pub community: Vec<u8>,
    /// The request ID.
    pub request_id: i32,
    /// The error, 0 for none.
    pub error_status: i32,
    /// The object with the error, from 1; 0 for none.
    pub error_index: i32,
    /// The objects.
    pub bindings: Vec<(MibName, MibValue)>,
}

impl SnmpAnswer {
    fn encode(&self) -> Vec<u8> {
        let mut list = Vec::new();
        for (name, value) in &self.bindings {
            let mut binding = Vec::new();
            put_name(&mut binding, name);
            value.put(&mut binding);
            element(&mut list, SEQUENCE, &binding);
        }
        let mut pdu = Vec::new();
        for number in [self.request_id, self.error_status, self.error_index] {
            element(&mut pdu, INTEGER, &integer(i64::from(number)));
        }
        element(&mut pdu, SEQUENCE, &list);
        let mut content = Vec::new();
        element(&mut content, INTEGER, &integer(i64::from(self.version)));
        element(&mut content, OCTETS, &self.community);
        element(&mut content, RESPONSE, &pdu);
        let mut message = Vec::new();
        element(&mut message, SEQUENCE, &content);
        message
    }

    fn fail(&mut self, error: i32, index: usize) {
        (self.error_status, self.error_index) = (error, i32::try_from(index + 1).unwrap_or(i32::MAX));
    }
}

/// A request: an answer that still has its objects, and the two numbers before them.
struct SnmpQuestion {
    answer: SnmpAnswer,
    non_repeaters: usize,
    repetitions: usize,
}

/// Reads a message; `None` for what is no request of a manager.
fn parse(payload: &[u8]) -> Option<SnmpQuestion> {
    let mut message = Elements(Elements(payload).of(SEQUENCE)?);
    let version = message.number()?;
    let community = message.of(OCTETS)?.to_vec();
    let (request, content, _) = message.next()?;
    if !matches!(request, GET | GET_NEXT | SET | GET_BULK) {
        return None;
    }
    let mut pdu = Elements(content);
    let (request_id, second, third) = (pdu.number()?, pdu.number()?, pdu.number()?);
    let mut list = Elements(pdu.of(SEQUENCE)?);
    let mut bindings = Vec::new();
    while !list.0.is_empty() {
        let mut binding = Elements(list.of(SEQUENCE)?);
        let name = binding.name()?;
        let (_, _, value) = binding.next()?;
        bindings.push((name, MibValue::Raw(value.to_vec())));
    }
    let answer = SnmpAnswer { request, version, community, request_id, error_status: 0, error_index: 0, bindings };
    let count = |number: i32| usize::try_from(number).unwrap_or(0);
    Some(SnmpQuestion { answer, non_repeaters: count(second), repetitions: count(third) })
}

/// Answers the payload of a datagram; `objects` are all objects of the device.
///
/// A message that cannot be read, of another version or of an unknown community has no answer (RFC 1157, 4.1).
pub(in super::super) fn answer(
    payload: &[u8],
    hooks: &AttachedStackHooks,
    objects: impl FnOnce() -> Vec<MibObject>,
) -> Option<Vec<u8>> {
    let question = parse(payload)?;
    let SnmpAnswer { version, request, community, .. } = &question.answer;
    let is_known = matches!((*version, *request), (V1, GET | GET_NEXT | SET) | (V2C, _));
    let is_member = [READERS, WRITERS].contains(&community.as_slice());
    if !hooks.check(StackCheck::SnmpVersion(*version), is_known)
        || !hooks.check(StackCheck::SnmpCommunity(community), is_member)
    {
        return None;
    }
    let mut objects = objects();
    objects.sort_by(|one, other| one.name.cmp(&other.name));
    let objects = hooks.apply(objects, |hooks, mut objects| {
        hooks.snmp_objects(&mut objects);
        objects
    });
    let asked = question.answer.bindings.clone();
    let mut answer = question.answer;
    match answer.request {
        GET_BULK => get_bulk(&mut answer, (question.non_repeaters, question.repetitions), &objects),
        SET => refuse_set(&mut answer, &objects),
        _ => get(&mut answer, &objects),
    }
    let answer = hooks.apply(answer, |hooks, mut answer| {
        hooks.snmp_answer(&mut answer);
        answer
    });
    Some(fitted(answer, asked))
}

/// The encoded response; one that is too long becomes an error (RFC 1157, 4.1.2; RFC 3416, 4.2.1).
fn fitted(mut answer: SnmpAnswer, asked: Vec<(MibName, MibValue)>) -> Vec<u8> {
    let mut octets = answer.encode();
    while octets.len() > LONGEST && answer.request == GET_BULK && answer.bindings.len() > 1 {
        answer.bindings.pop();
        octets = answer.encode();
    }
    if octets.len() <= LONGEST {
        return octets;
    }
    let bindings = if answer.version == V1 { asked } else { Vec::new() };
    SnmpAnswer { error_status: TOO_BIG, error_index: 0, bindings, ..answer }.encode()
}

/// The first object after `name`.
fn next<'o>(objects: &'o [MibObject], name: &[u32]) -> Option<&'o MibObject> {
    objects.iter().find(|object| object.name.as_slice() > name)
}

/// Get and GetNext.
fn get(answer: &mut SnmpAnswer, objects: &[MibObject]) {
    let mut values = Vec::new();
    for (index, (name, _)) in answer.bindings.iter().enumerate() {
        let found = match answer.request {
            GET_NEXT => next(objects, name),
            _ => objects.iter().find(|object| object.name == *name),
        };
        match found {
            Some(object) => values.push((object.name.clone(), object.value.clone())),
            None if answer.version == V1 => return answer.fail(NO_SUCH_NAME, index),
            None => values.push((name.clone(), MibValue::Raw(exception(answer.request, name, objects).to_vec()))),
        }
    }
    answer.bindings = values;
}

/// What SNMPv2 has instead of the value of an object that does not exist (RFC 3416, 4.2.1 and 4.2.2).
fn exception(request: u8, name: &[u32], objects: &[MibObject]) -> [u8; 2] {
    let has_object = objects.iter().any(|object| name.starts_with(object.object()));
    match request {
        GET if has_object => NO_SUCH_INSTANCE,
        GET => NO_SUCH_OBJECT,
        _ => END_OF_MIB_VIEW,
    }
}

fn get_bulk(answer: &mut SnmpAnswer, (non_repeaters, repetitions): (usize, usize), objects: &[MibObject]) {
    let value_after = |name: &MibName| match next(objects, name) {
        Some(object) => (object.name.clone(), object.value.clone()),
        None => (name.clone(), MibValue::Raw(END_OF_MIB_VIEW.to_vec())),
    };
    let (once, repeated) = answer.bindings.split_at(non_repeaters.min(answer.bindings.len()));
    let mut values: Vec<(MibName, MibValue)> = once.iter().map(|(name, _)| value_after(name)).collect();
    let mut names: Vec<MibName> = repeated.iter().map(|(name, _)| name.clone()).collect();
    // No response holds more objects than the device has, once for each name.
    for _ in 0..repetitions.min(objects.len() + 1) {
        for name in &mut names {
            let value = value_after(name);
            name.clone_from(&value.0);
            values.push(value);
        }
    }
    answer.bindings = values;
}

/// No object can be written. The error says why (RFC 1157, 4.1.5; RFC 3416, 4.2.5).
fn refuse_set(answer: &mut SnmpAnswer, objects: &[MibObject]) {
    let Some((name, _)) = answer.bindings.first() else { return };
    let error = match answer.version {
        V1 => NO_SUCH_NAME,
        _ if answer.community != WRITERS => NO_ACCESS,
        _ if objects.iter().any(|object| object.name == *name) => NOT_WRITABLE,
        _ => NO_CREATION,
    };
    answer.fail(error, 0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attached::Attached;
    use rstest::rstest;

    /// A Get for sysDescr.0 as `snmpget -v2c -c public` of net-snmp 5.9.3 sends it.
    const REQUEST: [u8; 43] = [
        0x30, 0x29, 2, 1, 1, 4, 6, b'p', b'u', b'b', b'l', b'i', b'c', 0xA0, 0x1C, 2, 4, 0x28, 0x75, 0xAE, 0xAD, 2, 1,
        0, 2, 1, 0, 0x30, 0x0E, 0x30, 0x0C, 6, 8, 0x2B, 6, 1, 2, 1, 1, 1, 0, 5, 0,
    ];
    const VERSION: usize = 4;
    const COMMUNITY: usize = 7;
    const KIND: usize = 13;
    /// The last number of the object but one.
    const OBJECT: usize = 39;

    fn objects() -> Vec<MibObject> {
        let object = |number: u32, text: &[u8]| MibObject {
            name: Vec::from([1, 3, 6, 1, 2, 1, 1, number, 0]),
            instance: 1,
            value: MibValue::Octets(text.to_vec()),
        };
        Vec::from([object(1, b"x"), object(4, b"yz")])
    }

    /// The response from the PDU on, after request ID, to the request with these bytes changed.
    fn response(changes: &[(usize, u8)]) -> Option<Vec<u8>> {
        let mut request = REQUEST;
        changes.iter().for_each(|(at, octet)| request[*at] = *octet);
        let response = answer(&request, &Attached::NONE, objects)?;
        assert_eq!((response[KIND], &response[15..21]), (RESPONSE, &REQUEST[15..21]));
        Some(response[21..].to_vec())
    }

    const NAME_1: [u8; 10] = [6, 8, 0x2B, 6, 1, 2, 1, 1, 1, 0];
    const NAME_2: [u8; 10] = [6, 8, 0x2B, 6, 1, 2, 1, 1, 2, 0];
    const NAME_4: [u8; 10] = [6, 8, 0x2B, 6, 1, 2, 1, 1, 4, 0];

    #[rstest]
    #[case::get(&[], [2, 1, 0, 2, 1, 0, 0x30, 15, 0x30, 13], NAME_1, &[4, 1, b'x'])]
    #[case::get_next(&[(KIND, GET_NEXT)], [2, 1, 0, 2, 1, 0, 0x30, 16, 0x30, 14], NAME_4, &[4, 2, b'y', b'z'])]
    #[case::unknown(&[(OBJECT, 2)], [2, 1, 0, 2, 1, 0, 0x30, 14, 0x30, 12], NAME_2, &[0x80, 0])]
    #[case::unknown_in_v1(&[(VERSION, 0), (OBJECT, 2)], [2, 1, 2, 2, 1, 1, 0x30, 14, 0x30, 12], NAME_2, &[5, 0])]
    #[case::set(&[(KIND, SET)], [2, 1, 6, 2, 1, 1, 0x30, 14, 0x30, 12], NAME_1, &[5, 0])]
    #[case::set_in_v1(&[(VERSION, 0), (KIND, SET)], [2, 1, 2, 2, 1, 1, 0x30, 14, 0x30, 12], NAME_1, &[5, 0])]
    fn requests_are_answered(
        #[case] changes: &[(usize, u8)],
        #[case] head: [u8; 10],
        #[case] name: [u8; 10],
        #[case] value: &[u8],
    ) {
        assert_eq!(response(changes), Some([&head[..], &name, value].concat()));
    }

    #[rstest]
    #[case::version(&[(VERSION, 3)])]
    #[case::community(&[(COMMUNITY, b'P')])]
    #[case::response(&[(KIND, RESPONSE)])]
    #[case::bulk_in_v1(&[(VERSION, 0), (KIND, GET_BULK)])]
    fn others_have_no_answer(#[case] changes: &[(usize, u8)]) {
        assert_eq!(response(changes), None);
    }

    #[test]
    fn a_cut_request_has_no_answer() {
        (0..REQUEST.len()).for_each(|length| assert_eq!(answer(&REQUEST[..length], &Attached::NONE, objects), None));
    }
}
