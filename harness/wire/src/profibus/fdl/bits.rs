//! Durations in bit times, and their conversion by the baud rate.
//!
//! Durations are added in bit times and converted once, to avoid accumulated rounding errors.

use core::ops::Add;

/// A duration in bit times, the unit of the bus parameters and of min TSDR (IEC 61158-4-3, bit time).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BitTimes(pub u64);

impl BitTimes {
    /// Bits on the wire for one byte (a UART character): start bit, 8 data bits, even parity bit, stop bit.
    pub const PER_OCTET: u64 = 11;
    /// The synchronisation time (TSYN): the minimum silence before a request, by which slaves detect the start of a frame.
    pub const TSYN: BitTimes = BitTimes(33);
    /// The default of min TSDR: the minimum time before a slave responds, unless Set_Prm sets another.
    pub const DEFAULT_MIN_TSDR: BitTimes = BitTimes(11);

    /// The transmission time of `count` bytes without gaps.
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

/// A baud rate in bit/s.
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

    /// Converts `bits` to nanoseconds, rounded up, because a frame ends with the end of its last bit. A rate of 0 counts as 1.
    #[inline]
    pub fn nanoseconds(self, bits: BitTimes) -> u64 {
        let rate = u64::from(self.0.max(1));
        // The product nearly always fits in 64 bits, and 128-bit division is slow.
        match bits.0.checked_mul(1_000_000_000) {
            Some(product) => product.div_ceil(rate),
            None => {
                let product = u128::from(bits.0) * 1_000_000_000;
                u64::try_from(product.div_ceil(u128::from(rate))).unwrap_or(u64::MAX)
            }
        }
    }

    /// Converts `nanoseconds` to whole bit times, rounded down; saturates at [`u64::MAX`].
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

    // At 1.5 Mbit/s a bit lasts 666.67 ns, at 12 Mbit/s 83.33 ns; both directions return integers.
    #[rstest]
    #[case(1_500_000, 3, 2_000)]
    #[case(1_500_000, 1, 667)]
    #[case(12_000_000, 33, 2_750)]
    #[case(9_600, 9_600, 1_000_000_000)]
    #[case(0, 5, 5_000_000_000)]
    fn bit_times_convert_to_nanoseconds_and_back(#[case] rate: u32, #[case] bits: u64, #[case] nanoseconds: u64) {
        assert_eq!(BaudRate(rate).nanoseconds(BitTimes(bits)), nanoseconds);
        if rate > 0 {
            assert_eq!(BaudRate(rate).bits(nanoseconds), BitTimes(bits));
            assert_eq!(BaudRate(rate).bits(nanoseconds - 1), BitTimes(bits - 1));
        }
    }

    #[test]
    fn long_durations_convert_without_overflow() {
        let (day, rate) = (86_400_000_000_000, BaudRate(12_000_000));
        assert_eq!(rate.bits(day), BitTimes(1_036_800_000_000));
        assert_eq!(rate.nanoseconds(BitTimes(1_036_800_000_000)), day);
        assert_eq!(BaudRate(1).nanoseconds(BitTimes(u64::MAX)), u64::MAX);
        assert_eq!(BaudRate(u32::MAX).bits(u64::MAX), BitTimes(u64::MAX));
    }
}
