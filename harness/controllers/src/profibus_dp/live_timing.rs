//! Timeouts of a master on a live bus.

use super::MasterSettings;
use wire::profibus::fdl::{BaudRate, BitTimes};

/// The shortest slot time, in nanoseconds: no kernel reliably delivers an answer sooner, at any baud rate.
const SHORTEST_SLOT_NANOS: u64 = 20_000_000;

/// Timeouts on a live bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LiveBusTiming {
    /// Slot time (TSL): how long the master waits for an answer.
    pub slot_time: BitTimes,
    /// The longest time that a slave takes to answer (max TSDR).
    pub max_tsdr: BitTimes,
}

impl LiveBusTiming {
    /// The times of a bus at `baud`: the given ones, else those of the standard, with a slot time of at least 20 ms.
    pub fn new(baud: BaudRate, slot_time: Option<BitTimes>, max_tsdr: Option<BitTimes>) -> LiveBusTiming {
        let usual = MasterSettings::new(0, baud);
        let shortest = u64::from(baud.0).saturating_mul(SHORTEST_SLOT_NANOS).div_ceil(1_000_000_000);
        LiveBusTiming {
            slot_time: slot_time.unwrap_or(BitTimes(usual.slot_time.0.max(shortest))),
            max_tsdr: max_tsdr.unwrap_or(usual.max_tsdr),
        }
    }

    /// The settings of the master at `address`, where `highest` is the highest address of the harness's masters. A bus with any
    /// other master is refused, so no other masters are searched for.
    pub fn settings(self, address: u8, baud: BaudRate, highest: u8) -> MasterSettings {
        let usual = MasterSettings::new(address, baud);
        let slot = self.slot_time.0;
        MasterSettings {
            slot_time: self.slot_time,
            max_tsdr: self.max_tsdr,
            token_pause: BitTimes(5 * slot),
            rotation: BitTimes(usual.rotation.0.max(8 * slot)),
            gap_factor: if address < highest { usual.gap_factor } else { 0 },
            highest,
            ..usual
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slot_time_allows_for_the_latency_of_the_kernel() {
        // 20 ms at 187.5 kbit/s, and the value of the bench if it says one.
        assert_eq!(LiveBusTiming::new(BaudRate(187_500), None, None).slot_time, BitTimes(3_750));
        assert_eq!(LiveBusTiming::new(BaudRate(187_500), Some(BitTimes(100)), None).slot_time, BitTimes(100));
        assert_eq!(LiveBusTiming::new(BaudRate(1_500_000), None, None).slot_time, BitTimes(30_000));
    }

    #[test]
    fn only_the_second_master_of_the_harness_is_polled() {
        let pace = LiveBusTiming::new(BaudRate(187_500), None, None);
        let settings = |address, highest| pace.settings(address, BaudRate(187_500), highest);
        assert_eq!((settings(1, 1).gap_factor, settings(2, 2).gap_factor), (0, 0));
        assert_eq!((settings(1, 2).gap_factor, settings(1, 2).highest), (10, 2));
    }
}
