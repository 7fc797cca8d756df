//! The echo of ICMP (RFC 792; RFC 1122, 3.2.2.6).

use super::fragments::checksum;
use crate::error::Result;
use crate::octets::ByteReader;
use alloc::vec::Vec;

const REQUEST: u8 = 8;
const REPLY: u8 = 0;

/// An echo request or its reply.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IcmpEcho {
    /// Whether it is a reply.
    pub is_reply: bool,
    /// The identifier.
    pub identifier: u16,
    /// The sequence number.
    pub sequence: u16,
    /// The data, which the reply repeats.
    pub data: Vec<u8>,
}

impl IcmpEcho {
    /// Parses the payload of an IPv4 packet; fails if it is no echo or its checksum is wrong.
    pub fn parse(payload: &[u8]) -> Result<IcmpEcho> {
        let mut reader = ByteReader::new("ICMP", payload);
        let kind = reader.u8()?;
        if ![REQUEST, REPLY].contains(&kind) {
            return Err(reader.wrong("Type", 1, "0 or 8 (echo)", kind.into()));
        }
        let code = reader.u8()?;
        if code != 0 {
            return Err(reader.wrong("Code", 1, "0", code.into()));
        }
        let sum = reader.u16()?;
        if checksum(payload) != 0 {
            return Err(reader.wrong("Checksum", 2, "the checksum of the message", sum.into()));
        }
        let (identifier, sequence) = (reader.u16()?, reader.u16()?);
        Ok(IcmpEcho { is_reply: kind == REPLY, identifier, sequence, data: reader.rest().to_vec() })
    }

    /// The payload of an IPv4 packet.
    pub fn to_vec(&self) -> Vec<u8> {
        let mut octets = Vec::from([if self.is_reply { REPLY } else { REQUEST }, 0, 0, 0]);
        octets.extend(self.identifier.to_be_bytes());
        octets.extend(self.sequence.to_be_bytes());
        octets.extend(&self.data);
        let sum = checksum(&octets);
        octets[2..4].copy_from_slice(&sum.to_be_bytes());
        octets
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An echo request with eight bytes of data (RFC 792); its sum was computed apart from this code, after RFC 1071.
    const ECHO: [u8; 16] = [8, 0, 0xE6, 0xE4, 0x12, 0x34, 0, 1, 0, 1, 0, 2, 0, 3, 0xFE, 0xDF];

    #[test]
    fn an_echo_is_read_and_written() {
        let echo =
            IcmpEcho { is_reply: false, identifier: 0x1234, sequence: 1, data: [0, 1, 0, 2, 0, 3, 0xFE, 0xDF].into() };
        assert_eq!(echo.to_vec(), ECHO);
        assert_eq!(IcmpEcho::parse(&ECHO), Ok(echo));
    }

    #[test]
    fn damage_is_detected() {
        for at in 0..ECHO.len() {
            let mut damaged = ECHO;
            damaged[at] ^= 0x10;
            assert!(IcmpEcho::parse(&damaged).is_err(), "byte {at}");
        }
        (0..8).for_each(|length| assert!(IcmpEcho::parse(&ECHO[..length]).is_err()));
    }
}
