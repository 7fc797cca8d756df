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

    #[inline]
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
    #[inline]
    pub fn nanoseconds(self, bits: BitTimes) -> u64 {
        let rate = u64::from(self.0.max(1));
        // Nearly always the product is short, and dividing long numbers is slow.
        match bits.0.checked_mul(1_000_000_000) {
            Some(product) => product.div_ceil(rate),
            None => {
                let product = u128::from(bits.0) * 1_000_000_000;
                u64::try_from(product.div_ceil(u128::from(rate))).unwrap_or(u64::MAX)
            }
        }
    }

    /// The whole bits that `nanoseconds` have room for; those that do not fit in a `u64` count as [`u64::MAX`].
    #[inline]
    pub fn bits(self, nanoseconds: u64) -> BitTimes {
        BitTimes(match nanoseconds.checked_mul(self.0.into()) {
            Some(product) => product / 1_000_000_000,
            None => u64::try_from(u128::from(nanoseconds) * u128::from(self.0) / 1_000_000_000).unwrap_or(u64::MAX),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    // At 1.5 Mbit/s a bit lasts 666.67 ns, at 12 Mbit/s 83.33 ns; both directions keep to whole numbers of their own side.
    #[rstest]
    #[case(1_500_000, 3, 2_000)]
    #[case(1_500_000, 1, 667)]
    #[case(12_000_000, 33, 2_750)]
    #[case(9_600, 9_600, 1_000_000_000)]
    #[case(0, 5, 5_000_000_000)]
    fn bits_last_so_many_nanoseconds(#[case] rate: u32, #[case] bits: u64, #[case] nanoseconds: u64) {
        assert_eq!(BaudRate(rate).nanoseconds(BitTimes(bits)), nanoseconds);
        if rate > 0 {
            assert_eq!(BaudRate(rate).bits(nanoseconds), BitTimes(bits));
            assert_eq!(BaudRate(rate).bits(nanoseconds - 1), BitTimes(bits - 1));
        }
    }

    #[test]
    fn what_is_too_long_for_short_numbers_is_right_too() {
        let (day, rate) = (86_400_000_000_000, BaudRate(12_000_000));
        assert_eq!(rate.bits(day), BitTimes(1_036_800_000_000));
        assert_eq!(rate.nanoseconds(BitTimes(1_036_800_000_000)), day);
        assert_eq!(BaudRate(1).nanoseconds(BitTimes(u64::MAX)), u64::MAX);
        assert_eq!(BaudRate(u32::MAX).bits(u64::MAX), BitTimes(u64::MAX));
    }
}
