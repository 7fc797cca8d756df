//! SNMPv1 and SNMPv2c: messages, and names of objects, in the basic encoding rules.
//!
//! RFC 1157 and RFC 3416 for the PDUs, X.690 for the encoding. A value stays as the bytes of its type; this module must not know objects.

use crate::codes::codes;
use crate::error::Result;
use crate::octets::ByteReader;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::fmt::{self, Write};

/// The UDP port of an agent (RFC 1157, 4).
pub const PORT: u16 = 161;

const INTEGER: u8 = 0x02;
const OCTET_STRING: u8 = 0x04;
/// The tag of a value that is not given, as in requests.
pub const NULL: u8 = 0x05;
const OBJECT_IDENTIFIER: u8 = 0x06;
const SEQUENCE: u8 = 0x30;
const COUNTER: u8 = 0x41;
const GAUGE: u8 = 0x42;
const TIME_TICKS: u8 = 0x43;
/// Bit 7 of each byte of a number in an object identifier but its last.
const MORE: u8 = 0x80;
/// The arcs below the first one, if that is 0 or 1.
const SECOND_ARCS: u32 = 40;

codes! {
    /// The version of a message (RFC 1157, 4; RFC 1901, 3).
    pub struct SnmpVersion(u8) {
        0 V1 v1 "SNMPv1.",
        1 V2C v2c "SNMPv2 with communities.",
    }
}

codes! {
    /// The kind of a PDU: the tag of its sequence (RFC 1157, 4.1; RFC 3416, 3).
    pub struct SnmpPduKind(u8) {
        0xA0 GET get "Requests the values of objects.",
        0xA1 GET_NEXT get_next "Requests the objects that follow, with their values.",
        0xA2 RESPONSE response "Answers a request.",
        0xA3 SET set "Changes the values of objects.",
        0xA4 TRAP trap "Reports an event, in SNMPv1.",
        0xA5 GET_BULK get_bulk "Requests several objects that follow, in SNMPv2.",
    }
}

/// An object identifier, as the bytes of its content.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObjectIdentifier(pub Vec<u8>);

impl ObjectIdentifier {
    /// Reads numbers with dots between; `None` if the text is no object identifier (X.690, 8.19).
    pub fn from_dotted(text: &str) -> Option<ObjectIdentifier> {
        let arcs: Option<Vec<u32>> = text.trim_start_matches('.').split('.').map(|arc| arc.parse().ok()).collect();
        let arcs = arcs?;
        let [first, second, rest @ ..] = arcs.as_slice() else { return None };
        if *first > 2 || *first < 2 && *second >= SECOND_ARCS {
            return None;
        }
        let joined = second.checked_add(first * SECOND_ARCS)?;
        let mut octets = Vec::new();
        core::iter::once(&joined).chain(rest).for_each(|arc| put_arc(&mut octets, *arc));
        Some(ObjectIdentifier(octets))
    }
}

impl fmt::Display for ObjectIdentifier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        let mut arc: u64 = 0;
        for octet in &self.0 {
            arc = arc << 7 & 0xFFFF_FFFF | u64::from(octet & !MORE);
            if octet & MORE != 0 {
                continue;
            }
            if text.is_empty() {
                let first = (arc / u64::from(SECOND_ARCS)).min(2);
                write!(text, "{first}.{}", arc - first * u64::from(SECOND_ARCS))?;
            } else {
                write!(text, ".{arc}")?;
            }
            arc = 0;
        }
        f.pad(&text)
    }
}

fn put_arc(out: &mut Vec<u8>, arc: u32) {
    let groups = (1..5).rev().filter(|group| arc >> (7 * group) != 0);
    groups.for_each(|group| out.push(MORE | (arc >> (7 * group)) as u8));
    out.push(arc as u8 & !MORE);
}

/// An object and its value, or the exception instead of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VarBind {
    /// The name of the object.
    pub name: ObjectIdentifier,
    /// The tag of the value: its type, or the exception.
    pub tag: u8,
    /// The content of the value.
    pub value: Vec<u8>,
}

impl VarBind {
    /// The value as a number: that of an INTEGER, a Counter, a Gauge or TimeTicks (RFC 2578, 7.1), as far as it is not negative and has
    /// 32 bits.
    pub fn number(&self) -> Option<u32> {
        let has_number = matches!(self.tag, INTEGER | COUNTER | GAUGE | TIME_TICKS);
        let is_negative = self.value.first().is_none_or(|first| first & 0x80 != 0);
        let number = |octets: &[u8]| {
            octets.iter().try_fold(0, |number, octet| u32::checked_mul(number, 0x100)?.checked_add(u32::from(*octet)))
        };
        Some(&self.value[..]).filter(|_| has_number && !is_negative).and_then(number)
    }

    /// Appends name and value, each with the shortest length that holds it.
    pub fn put(&self, out: &mut Vec<u8>) {
        put_element(out, OBJECT_IDENTIFIER, &self.name.0);
        put_element(out, self.tag, &self.value);
    }
}

/// A message with a PDU other than a trap of SNMPv1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SnmpMessage {
    /// The version.
    pub version: SnmpVersion,
    /// The community.
    pub community: Vec<u8>,
    /// The kind of the PDU.
    pub kind: SnmpPduKind,
    /// Relates a response to its request.
    pub request_id: i32,
    /// The error of a response; in a GetBulk the number of objects that are not repeated.
    pub error_status: i32,
    /// The object with the error, from 1; in a GetBulk the number of repetitions.
    pub error_index: i32,
    /// The objects.
    pub bindings: Vec<VarBind>,
}

impl SnmpMessage {
    /// Parses the payload of a datagram.
    pub fn parse(payload: &[u8]) -> Result<SnmpMessage> {
        let mut message = element(&mut ByteReader::new("SNMP", payload), SEQUENCE, "SEQUENCE")?;
        let version = SnmpVersion(number(&mut message)? as u8);
        let community = element(&mut message, OCTET_STRING, "OCTET STRING")?.rest().to_vec();
        let (tag, mut pdu) = any_element(&mut message)?;
        let (request_id, error_status, error_index) = (number(&mut pdu)?, number(&mut pdu)?, number(&mut pdu)?);
        let mut list = element(&mut pdu, SEQUENCE, "SEQUENCE")?;
        let mut bindings = Vec::new();
        while !list.is_empty() {
            let mut binding = element(&mut list, SEQUENCE, "SEQUENCE")?;
            let name = element(&mut binding, OBJECT_IDENTIFIER, "OBJECT IDENTIFIER")?.rest().to_vec();
            let (tag, mut value) = any_element(&mut binding)?;
            bindings.push(VarBind { name: ObjectIdentifier(name), tag, value: value.rest().to_vec() });
        }
        pdu.end("nothing after the objects")?;
        message.end("nothing after the PDU")?;
        let kind = SnmpPduKind(tag);
        Ok(SnmpMessage { version, community, kind, request_id, error_status, error_index, bindings })
    }

    /// The payload of a datagram, with the shortest lengths.
    pub fn to_vec(&self) -> Vec<u8> {
        let mut list = Vec::new();
        for binding in &self.bindings {
            let mut octets = Vec::new();
            binding.put(&mut octets);
            put_element(&mut list, SEQUENCE, &octets);
        }
        let mut pdu = Vec::new();
        [self.request_id, self.error_status, self.error_index].into_iter().for_each(|of| put_number(&mut pdu, of));
        put_element(&mut pdu, SEQUENCE, &list);
        let mut message = Vec::new();
        put_number(&mut message, self.version.0.into());
        put_element(&mut message, OCTET_STRING, &self.community);
        put_element(&mut message, self.kind.0, &pdu);
        let mut payload = Vec::new();
        put_element(&mut payload, SEQUENCE, &message);
        payload
    }
}

impl fmt::Display for SnmpMessage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = self.kind.word().map_or_else(|| "PDU".to_string(), |word| word.replace('_', "-"));
        write!(f, "SNMP {kind}")?;
        if self.kind == SnmpPduKind::RESPONSE && self.error_status != 0 {
            write!(f, " error {} of object {}", self.error_status, self.error_index)?;
        }
        self.bindings.iter().try_for_each(|binding| write!(f, " {}", binding.name))
    }
}

/// The next element and its tag (X.690, 8.1).
fn any_element<'a>(reader: &mut ByteReader<'a>) -> Result<(u8, ByteReader<'a>)> {
    let tag = reader.u8()?;
    let length = match reader.u8()? {
        short @ ..=0x7F => usize::from(short),
        0x81 => usize::from(reader.u8()?),
        0x82 => usize::from(reader.u16()?),
        other => return Err(reader.wrong("length", 1, "a length of at most two bytes", other.into())),
    };
    Ok((tag, reader.sub(length)?))
}

fn element<'a>(reader: &mut ByteReader<'a>, tag: u8, name: &'static str) -> Result<ByteReader<'a>> {
    let mut ahead = *reader;
    let observed = ahead.u8()?;
    if observed != tag {
        return Err(ahead.wrong("tag", 1, name, observed.into()));
    }
    Ok(any_element(reader)?.1)
}

/// An INTEGER of at most 32 bits.
fn number(reader: &mut ByteReader<'_>) -> Result<i32> {
    let mut content = element(reader, INTEGER, "INTEGER")?;
    let octets = content.rest();
    match octets {
        [] | [_, _, _, _, _, ..] => {
            Err(content.wrong("INTEGER", octets.len(), "one to four bytes", octets.len() as u64))
        }
        [first, rest @ ..] => {
            Ok(rest.iter().fold(i32::from(*first as i8), |number, octet| number << 8 | i32::from(*octet)))
        }
    }
}

fn put_number(out: &mut Vec<u8>, number: i32) {
    let octets = number.to_be_bytes();
    let is_redundant = |at: &usize| {
        let sign = octets[*at + 1] & 0x80 != 0;
        octets[*at] == if sign { 0xFF } else { 0 }
    };
    let skipped = (0..3).take_while(is_redundant).count();
    put_element(out, INTEGER, &octets[skipped..]);
}

/// Appends an element with the shortest length.
fn put_element(out: &mut Vec<u8>, tag: u8, content: &[u8]) {
    out.push(tag);
    match content.len() {
        length @ ..0x80 => out.push(length as u8),
        length @ ..0x100 => out.extend([0x81, length as u8]),
        length => {
            out.push(0x82);
            out.extend((length as u16).to_be_bytes());
        }
    }
    out.extend(content);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    /// Object identifiers: X.690, 8.19.5 has the example {2 100 3}.
    #[rstest]
    #[case::of_x690("2.100.3", &[0x81, 0x34, 0x03])]
    #[case::sys_descr("1.3.6.1.2.1.1.1.0", &[0x2B, 6, 1, 2, 1, 1, 1, 0])]
    #[case::lldp("1.0.8802.1.1.2", &[0x28, 0xC4, 0x62, 1, 1, 2])]
    #[case::highest("1.3.4294967295", &[0x2B, 0x8F, 0xFF, 0xFF, 0xFF, 0x7F])]
    fn object_identifiers_are_encoded(#[case] dotted: &str, #[case] octets: &[u8]) {
        let name = ObjectIdentifier::from_dotted(dotted).expect("an object identifier");
        assert_eq!(name.0, octets);
        assert_eq!(name.to_string(), dotted);
    }

    #[rstest]
    #[case("")]
    #[case("1")]
    #[case("1.40")]
    #[case("3.1")]
    #[case("1.3.x")]
    fn other_texts_are_no_object_identifiers(#[case] text: &str) {
        assert_eq!(ObjectIdentifier::from_dotted(text), None);
    }

    /// Numbers: X.690, 8.3, two's complement with the fewest bytes.
    #[rstest]
    #[case(0, &[2, 1, 0])]
    #[case(127, &[2, 1, 0x7F])]
    #[case(128, &[2, 2, 0, 0x80])]
    #[case(-1, &[2, 1, 0xFF])]
    #[case(-129, &[2, 2, 0xFF, 0x7F])]
    #[case(i32::MAX, &[2, 4, 0x7F, 0xFF, 0xFF, 0xFF])]
    fn numbers_have_the_fewest_bytes(#[case] value: i32, #[case] octets: &[u8]) {
        let mut out = Vec::new();
        put_number(&mut out, value);
        assert_eq!(out, octets);
        assert_eq!(number(&mut ByteReader::new("SNMP", octets)), Ok(value));
    }

    /// A Get for sysDescr.0 as `snmpget -v2c -c public` of net-snmp 5.9.3 sends it.
    const GET: &[u8] = &[
        0x30, 0x29, 2, 1, 1, 4, 6, b'p', b'u', b'b', b'l', b'i', b'c', 0xA0, 0x1C, 2, 4, 0x28, 0x75, 0xAE, 0xAD, 2, 1,
        0, 2, 1, 0, 0x30, 0x0E, 0x30, 0x0C, 6, 8, 0x2B, 6, 1, 2, 1, 1, 1, 0, 5, 0,
    ];

    #[test]
    fn a_request_is_read_and_written() {
        let message = SnmpMessage::parse(GET).expect("a message");
        assert_eq!((message.version, message.kind), (SnmpVersion::V2C, SnmpPduKind::GET));
        assert_eq!((message.community.as_slice(), message.request_id), (&b"public"[..], 0x2875_AEAD));
        assert_eq!(message.to_string(), "SNMP get 1.3.6.1.2.1.1.1.0");
        assert_eq!(message.to_vec(), GET);
    }

    /// RFC 2578, 7.1: a Counter32, a Gauge32 and TimeTicks have up to 32 bits without sign, so up to five bytes; an INTEGER has a sign.
    #[rstest]
    #[case::time_ticks(0x43, &[0x0B, 0xB8], Some(3000))]
    #[case::of_five_bytes(0x41, &[0, 0xFF, 0xFF, 0xFF, 0xFF], Some(u32::MAX))]
    #[case::integer(0x02, &[0x7F], Some(127))]
    #[case::negative(0x02, &[0xFF], None)]
    #[case::too_long(0x42, &[1, 0, 0, 0, 0], None)]
    #[case::empty(0x43, &[], None)]
    #[case::a_text(0x04, &[1], None)]
    fn numbers_of_objects(#[case] tag: u8, #[case] value: &[u8], #[case] number: Option<u32>) {
        let binding = VarBind { name: ObjectIdentifier::default(), tag, value: value.to_vec() };
        assert_eq!(binding.number(), number);
    }

    /// Lengths may be longer than needed (X.690, 8.1.3.5, note 2); a writer uses the shortest.
    #[test]
    fn long_lengths_are_read() {
        let mut long = GET.to_vec();
        long.splice(1..2, [0x82, 0x00, 0x29]);
        assert_eq!(SnmpMessage::parse(&long).map(|message| message.to_vec()), Ok(GET.to_vec()));
    }

    #[test]
    fn every_shorter_message_is_an_error() {
        (0..GET.len()).for_each(|length| assert!(SnmpMessage::parse(&GET[..length]).is_err()));
    }
}
