//! Fragmentation and reassembly of large bodies.

use super::{Fack, Flags1, PacketType, RpcHeader, RpcPdu, Uuid};
use alloc::collections::BTreeMap;
use alloc::vec::Vec;

/// Splits `body` into PDUs with at most `most` bytes each (multiples of 8 except the last, C706, 12.5.2.14).
///
/// A body that fits into one PDU is sent with the flags of `header` unchanged. Otherwise this sets the fragment flags, requests no
/// fack for the last fragment because the response acknowledges the whole body, counts fragments from 0, and increments the
/// serial number from that of `header`. `most` less than 8 counts as 8.
pub fn fragments(header: &RpcHeader, body: &[u8], most: usize) -> Vec<Vec<u8>> {
    let most = most.min(usize::from(u16::MAX));
    if body.len() <= most {
        return alloc::vec![RpcPdu::new(*header, body).to_vec()];
    }
    let size = (most / 8 * 8).max(8);
    let last = body.len().div_ceil(size) - 1;
    let plain = header.flags1.without(Flags1::LAST_FRAGMENT) | Flags1::FRAGMENT;
    body.chunks(size)
        .enumerate()
        .map(|(number, piece)| {
            let flags1 = if number == last { plain | Flags1::LAST_FRAGMENT | Flags1::NO_FACK } else { plain };
            let serial = header.serial.wrapping_add(number as u16);
            RpcPdu::new(RpcHeader { flags1, serial, fragment: number as u16, ..*header }, piece).to_vec()
        })
        .collect()
}

/// The result of passing a PDU to a [`Reassembler`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Assembled {
    /// The body is complete.
    Whole(Vec<u8>),
    /// Fragments are missing; `given_up` is the oldest other body if it was dropped for this one.
    Waiting {
        /// The dropped body.
        given_up: Option<Incomplete>,
    },
    /// The fragment was received before, with the same bytes.
    Repeated,
    /// The fragment contradicts an earlier one: other bytes with the same number, or a second last fragment. The earlier one is
    /// kept.
    Contradicts,
    /// The body is larger than allowed, or the fragment is empty; the body is dropped.
    Refused,
}

/// A body with missing fragments.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Incomplete {
    /// The activity of the call.
    pub activity: Uuid,
    /// The sequence number of the call within the activity.
    pub sequence: u32,
    /// Request or response.
    pub packet_type: PacketType,
    /// The number of bytes received.
    pub octets: usize,
    /// The missing fragment numbers below the highest received.
    pub gaps: Vec<u16>,
    /// Whether the last fragment has been received.
    pub has_last: bool,
}

/// Reassembles fragments in any order, for a bounded number of calls at the same time.
#[derive(Clone, Debug)]
pub struct Reassembler {
    calls: Vec<FragmentedCall>,
    most_calls: usize,
    most_octets: usize,
}

#[derive(Clone, Debug)]
struct FragmentedCall {
    key: (Uuid, u32, PacketType),
    pieces: BTreeMap<u16, Vec<u8>>,
    last: Option<u16>,
}

impl Reassembler {
    /// A reassembler for at most `most_calls` incomplete bodies of at most `most_octets` bytes each; drops the oldest when full.
    pub fn new(most_calls: usize, most_octets: usize) -> Reassembler {
        Reassembler { calls: Vec::new(), most_calls: most_calls.max(1), most_octets }
    }

    /// Takes one PDU; a PDU that is not a fragment is complete at once.
    pub fn take(&mut self, pdu: &RpcPdu) -> Assembled {
        if !pdu.header.flags1.has(Flags1::FRAGMENT) {
            return Assembled::Whole(pdu.body.to_vec());
        }
        let (at, given_up) = self.call(&pdu.header);
        match self.calls[at].add(pdu, self.most_octets) {
            FragmentResult::Complete => {
                Assembled::Whole(self.calls.remove(at).pieces.into_values().flatten().collect())
            }
            FragmentResult::More => Assembled::Waiting { given_up },
            FragmentResult::Repeated => Assembled::Repeated,
            FragmentResult::Contradicts => Assembled::Contradicts,
            FragmentResult::Refused => {
                self.calls.remove(at);
                Assembled::Refused
            }
        }
    }

    fn call(&mut self, header: &RpcHeader) -> (usize, Option<Incomplete>) {
        let key = key(header);
        if let Some(at) = self.calls.iter().position(|call| call.key == key) {
            return (at, None);
        }
        let given_up = (self.calls.len() >= self.most_calls).then(|| self.calls.remove(0).incomplete());
        self.calls.push(FragmentedCall { key, pieces: BTreeMap::new(), last: None });
        (self.calls.len() - 1, given_up)
    }

    /// All bodies with missing fragments, oldest first.
    pub fn incomplete(&self) -> impl Iterator<Item = Incomplete> {
        self.calls.iter().map(FragmentedCall::incomplete)
    }

    /// Drops an incomplete body.
    pub fn forget(&mut self, header: &RpcHeader) {
        self.calls.retain(|call| call.key != key(header));
    }

    /// The fack for the fragment with `header` while its body is incomplete: the fragment number for the header of the fack (0xFFFF
    /// if fragment 0 is missing), and the body with serial number and selective acknowledgement.
    ///
    /// The caller fills in window and sizes, which are 0.
    pub fn fack(&self, header: &RpcHeader) -> Option<(u16, Fack)> {
        let call = self.calls.iter().find(|call| call.key == key(header))?;
        let in_order = call.in_order();
        let first = u32::from(in_order.wrapping_add(1));
        let mut selective: Vec<u32> = Vec::new();
        for number in call.pieces.keys().map(|number| u32::from(*number)).filter(|number| *number >= first) {
            let word = ((number - first) / 32) as usize;
            selective.resize(selective.len().max(word + 1), 0);
            selective[word] |= 1 << ((number - first) % 32);
        }
        Some((in_order, Fack { serial: header.serial, selective, ..Fack::default() }))
    }
}

enum FragmentResult {
    Complete,
    More,
    Repeated,
    Contradicts,
    Refused,
}

impl FragmentedCall {
    fn add(&mut self, pdu: &RpcPdu, most_octets: usize) -> FragmentResult {
        let number = pdu.header.fragment;
        if let Some(known) = self.pieces.get(&number) {
            return if known == pdu.body { FragmentResult::Repeated } else { FragmentResult::Contradicts };
        }
        if pdu.body.is_empty() || self.octets() + pdu.body.len() > most_octets {
            return FragmentResult::Refused;
        }
        let is_last = pdu.header.flags1.has(Flags1::LAST_FRAGMENT);
        let highest = self.pieces.keys().next_back().copied();
        let contradicts = match self.last {
            Some(last) => is_last || number > last,
            None => is_last && highest.is_some_and(|highest| number < highest),
        };
        if contradicts {
            return FragmentResult::Contradicts;
        }
        self.pieces.insert(number, pdu.body.to_vec());
        if is_last {
            self.last = Some(number);
        }
        match self.last {
            Some(last) if self.pieces.len() == usize::from(last) + 1 => FragmentResult::Complete,
            _ => FragmentResult::More,
        }
    }

    fn octets(&self) -> usize {
        self.pieces.values().map(Vec::len).sum()
    }

    fn in_order(&self) -> u16 {
        let run = (0..=u16::MAX).take_while(|number| self.pieces.contains_key(number)).count();
        (run as u16).wrapping_sub(1)
    }

    fn incomplete(&self) -> Incomplete {
        let highest = self.pieces.keys().next_back().copied().unwrap_or(0);
        let (activity, sequence, packet_type) = self.key;
        Incomplete {
            activity,
            sequence,
            packet_type,
            octets: self.octets(),
            gaps: (0..highest).filter(|number| !self.pieces.contains_key(number)).collect(),
            has_last: self.last.is_some(),
        }
    }
}

fn key(header: &RpcHeader) -> (Uuid, u32, PacketType) {
    (header.activity, header.sequence, header.packet_type)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::octets::ByteOrder;
    use alloc::vec;
    use rstest::rstest;

    fn header() -> RpcHeader {
        RpcHeader { serial: 0xFFFF, sequence: 3, ..RpcHeader::new(PacketType::REQUEST, ByteOrder::Big) }
    }

    fn take(reassembler: &mut Reassembler, octets: &[u8]) -> Assembled {
        reassembler.take(&RpcPdu::parse(octets).expect("a PDU"))
    }

    #[rstest]
    #[case::fits(16, 16, &[(0, 16, 0x00)])]
    #[case::one_too_many(17, 16, &[(0, 16, 0x04), (1, 1, 0x0E)])]
    #[case::multiples_of_eight(20, 12, &[(0, 8, 0x04), (1, 8, 0x04), (2, 4, 0x0E)])]
    #[case::at_least_eight(9, 3, &[(0, 8, 0x04), (1, 1, 0x0E)])]
    #[case::empty(0, 0, &[(0, 0, 0x00)])]
    fn a_body_is_split(#[case] length: u8, #[case] most: usize, #[case] expected: &[(u16, u16, u8)]) {
        let body: Vec<u8> = (0..length).collect();
        let pdus = fragments(&header(), &body, most);
        let parsed: Vec<_> = pdus.iter().map(|octets| RpcPdu::parse(octets).expect("a PDU")).collect();
        let observed: Vec<_> =
            parsed.iter().map(|pdu| (pdu.header.fragment, pdu.header.body_length, pdu.header.flags1.0)).collect();
        assert_eq!(observed, expected);
        assert_eq!(parsed.iter().flat_map(|pdu| pdu.body).copied().collect::<Vec<_>>(), body);
        let serials = parsed.iter().zip(0_u16..).all(|(pdu, n)| pdu.header.serial == 0xFFFF_u16.wrapping_add(n));
        assert!(serials, "serial numbers increase");
    }

    #[rstest]
    #[case::in_order([0, 1, 2])]
    #[case::backwards([2, 1, 0])]
    #[case::last_in_the_middle([0, 2, 1])]
    fn fragments_in_any_order_are_reassembled(#[case] order: [usize; 3]) {
        let body: Vec<u8> = (0..20).collect();
        let pdus = fragments(&header(), &body, 8);
        let mut reassembler = Reassembler::new(1, 20);
        for number in &order[..2] {
            assert_eq!(take(&mut reassembler, &pdus[*number]), Assembled::Waiting { given_up: None });
            assert_eq!(take(&mut reassembler, &pdus[*number]), Assembled::Repeated);
        }
        assert_eq!(take(&mut reassembler, &pdus[order[2]]), Assembled::Whole(body));
        assert_eq!(reassembler.incomplete().count(), 0);
    }

    #[test]
    fn gaps_are_reported_and_facked() {
        let body: Vec<u8> = (0..=255).cycle().take(8 * 40).collect();
        let pdus = fragments(&header(), &body, 8);
        let mut reassembler = Reassembler::new(1, 1000);
        for number in [0, 1, 3, 35, 36] {
            take(&mut reassembler, &pdus[number]);
        }
        let last = RpcPdu::parse(&pdus[36]).expect("a PDU").header;
        let (fragment, fack) = reassembler.fack(&last).expect("an incomplete body");
        // Bit 0 of word 0 is fragment 2, bit 0 of word 1 is fragment 34.
        assert_eq!((fragment, fack.serial, fack.selective), (1, 35, vec![0b10, 0b110]));
        let incomplete: Vec<_> = reassembler.incomplete().collect();
        assert_eq!(incomplete.len(), 1);
        assert_eq!((incomplete[0].octets, incomplete[0].has_last, incomplete[0].sequence), (40, false, 3));
        assert_eq!(incomplete[0].gaps, [2].into_iter().chain(4..35).collect::<Vec<u16>>());
        reassembler.forget(&last);
        assert_eq!(reassembler.fack(&last), None);
    }

    #[test]
    fn a_contradiction_is_reported_and_the_first_fragment_is_kept() {
        let pdus = fragments(&header(), &[1; 20], 8);
        let other = fragments(&header(), &[2; 12], 8);
        let mut reassembler = Reassembler::new(1, 100);
        take(&mut reassembler, &pdus[1]);
        assert_eq!(take(&mut reassembler, &other[1]), Assembled::Contradicts, "other bytes of the same number");
        take(&mut reassembler, &pdus[2]);
        let longer = fragments(&header(), &[1; 28], 8);
        assert_eq!(take(&mut reassembler, &longer[3]), Assembled::Contradicts, "a second last fragment");
        assert_eq!(take(&mut reassembler, &pdus[0]), Assembled::Whole(vec![1; 20]));
    }

    #[test]
    fn memory_is_bounded() {
        let pdus = fragments(&header(), &[1; 24], 8);
        let mut reassembler = Reassembler::new(1, 16);
        take(&mut reassembler, &pdus[0]);
        take(&mut reassembler, &pdus[1]);
        assert_eq!(take(&mut reassembler, &pdus[2]), Assembled::Refused, "more bytes than allowed");
        assert_eq!(reassembler.incomplete().count(), 0);

        take(&mut reassembler, &pdus[0]);
        let other = fragments(&RpcHeader { sequence: 4, ..header() }, &[1; 24], 8);
        let Assembled::Waiting { given_up: Some(oldest) } = take(&mut reassembler, &other[0]) else {
            panic!("the oldest body is dropped");
        };
        assert_eq!((oldest.sequence, oldest.octets), (3, 8));
        assert_eq!(reassembler.incomplete().map(|call| call.sequence).collect::<Vec<_>>(), [4]);

        let empty = RpcHeader { flags1: Flags1::FRAGMENT, fragment: 9, ..header() };
        assert_eq!(reassembler.take(&RpcPdu::new(empty, &[])), Assembled::Refused, "an empty fragment");
    }

    #[test]
    fn requests_and_responses_of_a_call_are_separate() {
        let request = fragments(&header(), &[1; 12], 8);
        let response = fragments(&RpcHeader { packet_type: PacketType::RESPONSE, ..header() }, &[2; 12], 8);
        let mut reassembler = Reassembler::new(2, 100);
        take(&mut reassembler, &request[0]);
        take(&mut reassembler, &response[1]);
        assert_eq!(take(&mut reassembler, &request[1]), Assembled::Whole(vec![1; 12]));
        assert_eq!(take(&mut reassembler, &response[0]), Assembled::Whole(vec![2; 12]));
    }
}
