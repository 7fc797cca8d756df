//! UUIDs and numbers that look random and are the same in every run with the same seed.

use wire::profinet::rpc::Uuid;

/// A source of UUIDs and numbers (SplitMix64).
#[derive(Clone, Debug)]
pub(super) struct Ids(u64);

impl Ids {
    pub(super) fn new(seed: u64) -> Ids {
        Ids(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// A random UUID: version 4, the usual variant (RFC 9562, 5.4).
    pub(super) fn uuid(&mut self) -> Uuid {
        let mut octets = [0; 16];
        octets[..8].copy_from_slice(&self.next().to_be_bytes());
        octets[8..].copy_from_slice(&self.next().to_be_bytes());
        octets[6] = octets[6] & 0x0F | 0x40;
        octets[8] = octets[8] & 0x3F | 0x80;
        Uuid(octets)
    }

    /// A transaction number (xid).
    pub(super) fn xid(&mut self) -> u32 {
        self.next() as u32
    }
}
