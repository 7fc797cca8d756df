//! The bus parameters of a master: its address, and the times of the medium access at each baud rate.
//!
//! This module must not know the state of a master. Source: IEC 61158-4-3 (EN 50170-2), operating parameters and timers.

use core::time::Duration;
use wire::profibus::fdl::{BaudRate, BitTimes};

/// Default timeout for a DP-V1 answer; no standard sets it.
const ACYCLIC_TIMEOUT: Duration = Duration::from_secs(5);
/// Default timeout for the token; no standard sets it.
const TOKEN_TIMEOUT: Duration = Duration::from_secs(2);

/// Address and bus parameters of a master.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MasterSettings {
    /// Station address, 0 to 125.
    pub address: u8,
    /// Baud rate of the bus.
    pub baud: BaudRate,
    /// TSL: how long the master waits for the first character of an answer.
    pub slot_time: BitTimes,
    /// The shortest time that a slave of this bus takes to answer (min TSDR).
    pub min_tsdr: BitTimes,
    /// The longest time that a slave of this bus takes to answer (max TSDR). The bus stays idle for this time after a request
    /// without answer.
    pub max_tsdr: BitTimes,
    /// TQUI: how long a transmitter, such as a repeater, takes to release the bus.
    pub quiet: BitTimes,
    /// TSET: the time from an event to the reaction of a station.
    pub setup: BitTimes,
    /// How long a master that is alone keeps the token when it has nothing to send; below six slot times.
    pub token_pause: BitTimes,
    /// TTR: the target rotation time of the token. The master holds the token until this time after it received it before.
    pub rotation: BitTimes,
    /// How often an unanswered request is repeated.
    pub retries: u8,
    /// G: number of token rotations between two polls for new masters; 0: never.
    pub gap_factor: u8,
    /// HSA: the highest address that is polled.
    pub highest: u8,
    /// Timeout for a DP-V1 answer.
    pub acyclic: Duration,
    /// How long the master may wait for the token, or for time left with it, while it has something to send.
    pub patience: Duration,
}

/// The parameters that follow from the baud rate.
struct BusProfile {
    slot: u64,
    max_tsdr: u64,
    quiet: u64,
    setup: u64,
    retries: u8,
}

impl BusProfile {
    /// The defaults of GSD revision 3 for slot time and max TSDR, and of the DP profile of the standard for the others.
    const fn at(baud: BaudRate) -> BusProfile {
        let (slot, max_tsdr, quiet, setup, retries) = match baud.0 {
            45_450 => (640, 250, 0, 1, 1),
            ..=187_500 => (100, 60, 0, 1, 1),
            187_501..=500_000 => (200, 100, 0, 1, 1),
            500_001..=1_500_000 => (300, 150, 0, 1, 1),
            1_500_001..=3_000_000 => (400, 250, 3, 4, 2),
            3_000_001..=6_000_000 => (600, 450, 6, 8, 3),
            _ => (1_000, 800, 9, 16, 4),
        };
        BusProfile { slot, max_tsdr, quiet, setup, retries }
    }
}

impl MasterSettings {
    /// The usual parameters of a bus at `baud`.
    pub fn new(address: u8, baud: BaudRate) -> MasterSettings {
        let BusProfile { slot, max_tsdr, quiet, setup, retries } = BusProfile::at(baud);
        MasterSettings {
            address,
            baud,
            slot_time: BitTimes(slot),
            min_tsdr: BitTimes::DEFAULT_MIN_TSDR,
            max_tsdr: BitTimes(max_tsdr),
            quiet: BitTimes(quiet),
            setup: BitTimes(setup),
            token_pause: BitTimes(5 * slot),
            rotation: BitTimes(50_000),
            retries,
            gap_factor: 10,
            highest: 126,
            acyclic: ACYCLIC_TIMEOUT,
            patience: TOKEN_TIMEOUT,
        }
    }

    /// The safety margin (TSM): two bits, twice TSET, and TQUI.
    fn safety_margin(&self) -> BitTimes {
        BitTimes(self.setup.0.saturating_mul(2).saturating_add(2)) + self.quiet
    }

    /// The silence before a frame of the master that follows an answer, an acknowledgement or a token (TID1): the longest of
    /// TSYN + TSM and min TSDR. The delay of the master itself (TSDI) is not longer, since it sends as soon as it may.
    pub fn idle_after_answer(&self) -> BitTimes {
        (BitTimes::TSYN + self.safety_margin()).max(self.min_tsdr)
    }

    /// The silence after a request of the master that no station answers, SDN (TID2): the longer of TSYN + TSM and max TSDR.
    pub fn idle_after_unanswered(&self) -> BitTimes {
        (BitTimes::TSYN + self.safety_margin()).max(self.max_tsdr)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    // Slot time, max TSDR, TID1 and TID2 in bits, and the retry limit. TID1 by hand: 33 + 2 + 2 * TSET + TQUI.
    #[rstest]
    #[case(9_600, 100, 60, 37, 60, 1)]
    #[case(45_450, 640, 250, 37, 250, 1)]
    #[case(187_500, 100, 60, 37, 60, 1)]
    #[case(500_000, 200, 100, 37, 100, 1)]
    #[case(1_500_000, 300, 150, 37, 150, 1)]
    #[case(3_000_000, 400, 250, 46, 250, 2)]
    #[case(6_000_000, 600, 450, 57, 450, 3)]
    #[case(12_000_000, 1_000, 800, 76, 800, 4)]
    fn the_times_follow_from_the_baud_rate(
        #[case] baud: u32,
        #[case] slot: u64,
        #[case] max_tsdr: u64,
        #[case] idle_1: u64,
        #[case] idle_2: u64,
        #[case] retries: u8,
    ) {
        let of = MasterSettings::new(2, BaudRate(baud));
        assert_eq!((of.slot_time, of.max_tsdr), (BitTimes(slot), BitTimes(max_tsdr)));
        assert_eq!((of.idle_after_answer(), of.idle_after_unanswered()), (BitTimes(idle_1), BitTimes(idle_2)));
        assert_eq!(of.retries, retries);
    }

    #[test]
    fn a_long_min_tsdr_and_a_short_max_tsdr_change_the_idle_times() {
        let of = MasterSettings {
            min_tsdr: BitTimes(60),
            max_tsdr: BitTimes(20),
            ..MasterSettings::new(2, BaudRate(9_600))
        };
        assert_eq!((of.idle_after_answer(), of.idle_after_unanswered()), (BitTimes(60), BitTimes(37)));
    }
}
