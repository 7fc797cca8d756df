//! How long frames last, in bits; what a bit lasts, the baud rate says.
//!
//! Durations are counted in bit times and converted once, so that no rounding adds up.

use core::ops::Add;

/// A duration in bits, as the parameters of the bus and `min TSDR` count it (IEC 61158-4-3, bit time).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BitTimes(pub u64);

impl BitTimes {
    /// Bits on the wire for one octet: start bit, 8 bits, even parity, stop bit.
    pub const PER_OCTET: u64 = 11;
    /// The least silence before a request, by which slaves find the beginning of a frame (TSYN).
    pub const SYNCHRONISATION: BitTimes = BitTimes(33);
    /// The least time that a slave waits before it answers, unless Set_Prm says otherwise (min TSDR).
    pub const LEAST_DELAY: BitTimes = BitTimes(11);

    /// How long `count` octets last when one follows on the other.
    pub const fn of_octets(count: usize) -> BitTimes {
        BitTimes(count as u64 * BitTimes::PER_OCTET)
    }
}

impl Add for BitTimes {
    type Output = BitTimes;

    fn add(self, more: BitTimes) -> BitTimes {
        BitTimes(self.0.saturating_add(more.0))
    }
}

/// Bits in a second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BaudRate(pub u32);

impl BaudRate {
    /// The rates that the standard allows on RS-485, ascending (IEC 61158-2, type 3).
    pub const STANDARD: &'static [BaudRate] = &[
        BaudRate(9_600),
        BaudRate(19_200),
        BaudRate(45_450),
        BaudRate(93_750),
        BaudRate(187_500),
        BaudRate(500_000),
        BaudRate(1_500_000),
        BaudRate(3_000_000),
        BaudRate(6_000_000),
        BaudRate(12_000_000),
    ];

    /// `bits` in nanoseconds, rounded up: a frame has ended when its last bit has. A rate of 0 counts as 1.
    pub fn nanoseconds(self, bits: BitTimes) -> u64 {
        let nanoseconds = (u128::from(bits.0) * 1_000_000_000).div_ceil(u128::from(self.0.max(1)));
        u64::try_from(nanoseconds).unwrap_or(u64::MAX)
    }
}
