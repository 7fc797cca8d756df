//! Interfaces of a capture file and the resolution of their clocks.

use pcap_parser::{InterfaceDescriptionBlock, OptionCode};
use station::Time;

use super::LinkType;

/// Default resolution of a pcapng interface: microseconds (pcapng, option `if_tsresol`).
const MICROSECONDS: u8 = 6;
const SECOND: i128 = 1_000_000_000;

/// Byte order of a file or a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CaptureByteOrder {
    Little,
    Big,
}

impl CaptureByteOrder {
    /// The 32-bit number at `at`, or `None` beyond the end.
    pub fn word(self, octets: &[u8], at: usize) -> Option<u32> {
        let raw = octets.get(at..)?.first_chunk::<4>()?;
        Some(match self {
            CaptureByteOrder::Little => u32::from_le_bytes(*raw),
            CaptureByteOrder::Big => u32::from_be_bytes(*raw),
        })
    }

    /// `word` in this byte order.
    pub fn octets(self, word: u32) -> [u8; 4] {
        match self {
            CaptureByteOrder::Little => word.to_le_bytes(),
            CaptureByteOrder::Big => word.to_be_bytes(),
        }
    }
}

/// An interface of a pcapng section.
#[derive(Clone, Debug)]
pub(super) struct PcapngInterface {
    pub link_type: LinkType,
    /// Snap length in bytes; 0: no limit.
    pub longest_captured: u32,
    tick: InterfaceTick,
    /// Offset added to each time, in seconds.
    offset: i64,
}

/// The duration of a tick of an interface's clock.
#[derive(Clone, Copy, Debug)]
enum InterfaceTick {
    Nanoseconds(u64),
    PerNanosecond(u64),
    /// The binary logarithm of the ticks per second.
    BinaryFraction(u8),
}

impl PcapngInterface {
    pub fn read(block: &InterfaceDescriptionBlock<'_>, order: CaptureByteOrder) -> PcapngInterface {
        let mut resolution = MICROSECONDS;
        let mut offset = 0;
        // pcap-parser reads these two options itself, but supports no binary resolution and no big-endian offset.
        for option in block.options.iter().take_while(|option| option.code != OptionCode::EndOfOpt) {
            match (option.code, option.as_bytes()) {
                (OptionCode::IfTsresol, Ok([value])) => resolution = *value,
                (OptionCode::IfTsoffset, Ok(value)) => {
                    if let Some(value) = value.first_chunk::<8>() {
                        offset = match order {
                            CaptureByteOrder::Little => i64::from_le_bytes(*value),
                            CaptureByteOrder::Big => i64::from_be_bytes(*value),
                        };
                    }
                }
                _ => {}
            }
        }
        PcapngInterface {
            link_type: LinkType(block.linktype.0 as u16),
            longest_captured: block.snaplen,
            tick: InterfaceTick::new(resolution),
            offset,
        }
    }

    /// The time of `ticks` in nanoseconds since 1970, limited to the range of [`Time`].
    pub fn time(&self, ticks: u64) -> Time {
        if let (InterfaceTick::Nanoseconds(each), 0) = (self.tick, self.offset) {
            return Time::from_nanos(ticks.saturating_mul(each));
        }
        let nanos = match self.tick {
            InterfaceTick::Nanoseconds(each) => i128::from(ticks) * i128::from(each),
            InterfaceTick::PerNanosecond(many) => i128::from(ticks / many),
            InterfaceTick::BinaryFraction(exponent) => (i128::from(ticks) * SECOND) >> exponent,
        };
        let nanos = nanos + i128::from(self.offset) * SECOND;
        Time::from_nanos(u64::try_from(nanos.max(0)).unwrap_or(u64::MAX))
    }
}

impl InterfaceTick {
    /// Reads the byte of `if_tsresol`: bit 7 selects powers of 2 instead of 10, the rest is the negative exponent.
    fn new(resolution: u8) -> InterfaceTick {
        let exponent = resolution & 0x7F;
        if resolution & 0x80 != 0 {
            InterfaceTick::BinaryFraction(exponent)
        } else if exponent <= 9 {
            InterfaceTick::Nanoseconds(10u64.pow(u32::from(9 - exponent)))
        } else {
            // Finer than 10^-19 s no 64-bit time reaches a nanosecond.
            InterfaceTick::PerNanosecond(10u64.checked_pow(u32::from(exponent - 9)).unwrap_or(u64::MAX))
        }
    }
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::*;

    /// Ticks 0x1_0000_0007 as tshark 4.0.17 shows them.
    #[rstest]
    #[case::microseconds(0x06, 0, 4_294_967_303_000)]
    #[case::nanoseconds(0x09, 0, 4_294_967_303)]
    #[case::picoseconds(0x0C, 0, 4_294_967)]
    #[case::eighths_of_a_second(0x83, 0, 536_870_912_875_000_000)]
    #[case::binary_with_offset(0x94, 5, 4_101_000_006_675)]
    #[case::negative_offset(0x03, -3, 4_294_964_303_000_000)]
    #[case::before_1970(0x09, -5, 0)]
    #[case::finer_than_any_clock(0x7F, 0, 0)]
    #[case::beyond_the_range(0x00, i64::MAX, u64::MAX)]
    fn ticks_become_nanoseconds(#[case] resolution: u8, #[case] offset: i64, #[case] nanos: u64) {
        let interface = PcapngInterface {
            link_type: LinkType::ETHERNET,
            longest_captured: 0,
            tick: InterfaceTick::new(resolution),
            offset,
        };
        assert_eq!(interface.time(0x1_0000_0007), Time::from_nanos(nanos));
    }
}
