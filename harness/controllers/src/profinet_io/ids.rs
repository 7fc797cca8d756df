//! UUIDs and numbers that look random and are the same in every run with the same seed.

use crate::random::SplitMix64;
use wire::profinet::rpc::Uuid;

/// A source of UUIDs and numbers.
#[derive(Clone, Debug)]
pub(super) struct Ids(SplitMix64);

impl Ids {
    pub(super) fn new(seed: u64) -> Ids {
        Ids(SplitMix64::new(seed))
    }

    /// A random UUID: version 4, the usual variant (RFC 9562, 5.4).
    pub(super) fn uuid(&mut self) -> Uuid {
        let mut octets = [0; 16];
        octets[..8].copy_from_slice(&self.0.bits().to_be_bytes());
        octets[8..].copy_from_slice(&self.0.bits().to_be_bytes());
        octets[6] = octets[6] & 0x0F | 0x40;
        octets[8] = octets[8] & 0x3F | 0x80;
        Uuid(octets)
    }

    /// A transaction number (xid).
    pub(super) fn xid(&mut self) -> u32 {
        self.0.bits() as u32
    }
}
