//! The part of the basic encoding rules that SNMP uses (X.690; RFC 3417, 8).

use alloc::vec::Vec;

/// The name of an object: the numbers of its object identifier.
pub type MibName = Vec<u32>;

pub(super) const INTEGER: u8 = 0x02;
pub(super) const OCTETS: u8 = 0x04;
pub(super) const NAME: u8 = 0x06;
pub(super) const SEQUENCE: u8 = 0x30;
const IP_ADDRESS: u8 = 0x40;
const COUNTER: u8 = 0x41;
const GAUGE: u8 = 0x42;
const TICKS: u8 = 0x43;

/// The value of an object (RFC 1155, 3.2; RFC 2578, 7.1).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MibValue {
    /// INTEGER.
    Integer(i32),
    /// OCTET STRING.
    Octets(Vec<u8>),
    /// OBJECT IDENTIFIER.
    Name(MibName),
    /// IpAddress.
    Address([u8; 4]),
    /// Counter.
    Counter(u32),
    /// Gauge, and Unsigned32.
    Gauge(u32),
    /// TimeTicks, in hundredths of a second.
    Ticks(u32),
    /// An element as it is: type, length and content.
    Raw(Vec<u8>),
}

impl MibValue {
    /// Appends the value as an element.
    pub(super) fn put(&self, out: &mut Vec<u8>) {
        match self {
            MibValue::Integer(number) => element(out, INTEGER, &integer(i64::from(*number))),
            MibValue::Octets(octets) => element(out, OCTETS, octets),
            MibValue::Name(name) => put_name(out, name),
            MibValue::Address(address) => element(out, IP_ADDRESS, address),
            MibValue::Counter(number) => element(out, COUNTER, &integer(i64::from(*number))),
            MibValue::Gauge(number) => element(out, GAUGE, &integer(i64::from(*number))),
            MibValue::Ticks(number) => element(out, TICKS, &integer(i64::from(*number))),
            MibValue::Raw(octets) => out.extend_from_slice(octets),
        }
    }
}

/// Appends an element whose length has as few bytes as possible.
pub(super) fn element(out: &mut Vec<u8>, tag: u8, content: &[u8]) {
    out.push(tag);
    let length = content.len().to_be_bytes();
    let significant = length.iter().skip_while(|octet| **octet == 0).count();
    if content.len() >= 0x80 {
        out.push(0x80 | significant as u8);
        out.extend_from_slice(&length[length.len() - significant..]);
    } else {
        out.push(content.len() as u8);
    }
    out.extend_from_slice(content);
}

/// The content of an INTEGER, without redundant leading bytes.
pub(super) fn integer(number: i64) -> Vec<u8> {
    let octets = number.to_be_bytes();
    let mut start = 0;
    while start < octets.len() - 1 {
        let is_negative = octets[start + 1] >= 0x80;
        if octets[start] != if is_negative { 0xFF } else { 0x00 } {
            break;
        }
        start += 1;
    }
    octets[start..].to_vec()
}

/// Appends an OBJECT IDENTIFIER.
pub(super) fn put_name(out: &mut Vec<u8>, name: &[u32]) {
    let mut content = Vec::new();
    let (head, rest) = name.split_at(name.len().min(2));
    let first = head.first().copied().unwrap_or(0) * 40 + head.get(1).copied().unwrap_or(0);
    for number in core::iter::once(&first).chain(rest) {
        let bits = (u32::BITS - number.leading_zeros()).max(1);
        for group in (0..bits.div_ceil(7)).rev() {
            let continues = if group > 0 { 0x80 } else { 0 };
            content.push(continues | (number >> (7 * group) & 0x7F) as u8);
        }
    }
    element(out, NAME, &content);
}

/// Reads elements one after the other; `None` where the bytes are none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Elements<'a>(pub &'a [u8]);

impl<'a> Elements<'a> {
    /// The next element: its tag, its content, and all of its bytes.
    pub(super) fn next(&mut self) -> Option<(u8, &'a [u8], &'a [u8])> {
        let all = self.0;
        let (&tag, rest) = all.split_first()?;
        let (&first, rest) = rest.split_first()?;
        let (length, rest) = if first < 0x80 {
            (usize::from(first), rest)
        } else {
            let count = usize::from(first & 0x7F);
            if !(1..=3).contains(&count) {
                return None;
            }
            let (octets, rest) = rest.split_at_checked(count)?;
            (octets.iter().fold(0, |length, octet| length << 8 | usize::from(*octet)), rest)
        };
        let (content, rest) = rest.split_at_checked(length)?;
        self.0 = rest;
        Some((tag, content, &all[..all.len() - rest.len()]))
    }

    /// The content of the next element, if that has this tag.
    pub(super) fn of(&mut self, wanted: u8) -> Option<&'a [u8]> {
        self.next().filter(|(tag, ..)| *tag == wanted).map(|(_, content, _)| content)
    }

    /// The next element as a number of 32 bits.
    pub(super) fn number(&mut self) -> Option<i32> {
        let content = self.of(INTEGER)?;
        let (&first, rest) = content.split_first()?;
        if content.len() > 4 {
            return None;
        }
        Some(rest.iter().fold(i32::from(first.cast_signed()), |number, octet| number << 8 | i32::from(*octet)))
    }

    /// The next element as an object identifier.
    pub(super) fn name(&mut self) -> Option<MibName> {
        let content = self.of(NAME)?;
        let mut name = Vec::new();
        let mut number: u32 = 0;
        for octet in content {
            if number > u32::MAX >> 7 {
                return None;
            }
            number = number << 7 | u32::from(octet & 0x7F);
            if octet & 0x80 == 0 {
                if name.is_empty() {
                    let first = (number / 40).min(2);
                    name.extend([first, number - first * 40]);
                } else {
                    name.push(number);
                }
                number = 0;
            }
        }
        let is_whole = content.last().is_some_and(|last| last & 0x80 == 0);
        is_whole.then_some(name)
    }
}
