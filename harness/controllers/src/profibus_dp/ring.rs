//! The logical ring: which masters are in it, and which address is polled next.
//!
//! This module must not know time. Source: IEC 61158-4-3, LAS and GAPL.

use alloc::vec::Vec;
use wire::profibus::fdl::{BROADCAST, StationType};

/// Number of token rotations after which a listener knows the ring.
const ROUNDS: u8 = 2;

/// The list of known masters, and the search for more.
#[derive(Clone, Debug)]
pub(super) struct LogicalRing {
    own: u8,
    highest: u8,
    /// LAS, ascending, without this master.
    others: Vec<u8>,
    /// The master that is not the predecessor and passed the token to this one last.
    unexpected: Option<u8>,
    /// Number of token rotations observed.
    rounds: u8,
    /// The address that is polled next.
    cursor: u8,
    /// Remaining tokens before the next poll.
    pause: u8,
    factor: u8,
}

impl LogicalRing {
    pub fn new(own: u8, highest: u8, factor: u8) -> LogicalRing {
        let mut ring = LogicalRing {
            own,
            highest,
            others: Vec::new(),
            unexpected: None,
            rounds: 0,
            cursor: own,
            pause: 0,
            factor,
        };
        ring.cursor = ring.after(own);
        ring
    }

    /// Whether no other master is in the ring.
    pub fn is_alone(&self) -> bool {
        self.others.is_empty()
    }

    /// The master to which this master passes the token.
    pub fn successor(&self) -> u8 {
        let next = self.others.iter().find(|other| **other > self.own).or(self.others.first());
        next.copied().unwrap_or(self.own)
    }

    /// The master from which this master gets the token (PS).
    fn predecessor(&self) -> Option<u8> {
        self.others.iter().rev().find(|other| **other < self.own).or(self.others.last()).copied()
    }

    /// Processes a token from `sa` to this master; returns whether it is accepted: from the predecessor at once, from any other
    /// master when it repeats it. That master is the predecessor from then on, and those between have left the ring.
    pub fn token_offered(&mut self, sa: u8) -> bool {
        if self.predecessor() != Some(sa) && self.unexpected != Some(sa) {
            self.unexpected = Some(sa);
            return false;
        }
        self.unexpected = None;
        let own = self.own;
        // The distance from the sender, upwards and around.
        let distance = |station: u8| station.wrapping_sub(sa);
        self.others.retain(|other| distance(*other) == 0 || distance(*other) > distance(own));
        self.token_observed(sa, own);
        true
    }

    /// Records that another frame than a repetition followed a token that was not accepted.
    pub fn token_in_use(&mut self) {
        self.unexpected = None;
    }

    /// Records an observed token from `sa` to `da`.
    pub fn token_observed(&mut self, sa: u8, da: u8) {
        for master in [sa, da] {
            if master != self.own && master < BROADCAST && !self.others.contains(&master) {
                self.others.push(master);
                self.others.sort_unstable();
            }
        }
        if da <= sa {
            self.rounds = self.rounds.saturating_add(1);
        }
    }

    /// Whether the ring is known, so that this master may enter it.
    pub fn is_complete(&self) -> bool {
        self.rounds >= ROUNDS
    }

    /// Forgets all other masters.
    pub fn clear(&mut self) {
        self.others.clear();
        self.unexpected = None;
        (self.rounds, self.cursor, self.pause) = (0, self.after(self.own), 0);
    }

    /// Removes `master`, which does not accept the token, and restarts the search so that it is found when it returns.
    pub fn remove(&mut self, master: u8) {
        self.others.retain(|other| *other != master);
        (self.cursor, self.pause) = (self.after(self.own), 0);
    }

    /// Counts a token received; returns the address to poll now, if there is one.
    pub fn token(&mut self) -> Option<u8> {
        if self.factor == 0 {
            return None;
        }
        if self.pause > 0 {
            self.pause -= 1;
            return None;
        }
        (self.cursor != self.own).then_some(self.cursor)
    }

    /// Processes the result of polling `station`: its type if it answered.
    pub fn polled(&mut self, station: u8, answer: Option<StationType>) {
        self.pause = self.factor.saturating_sub(1);
        match answer {
            Some(StationType::MASTER_READY | StationType::MASTER_IN_RING) => {
                self.token_observed(self.own, station);
                self.cursor = self.after(self.own);
            }
            Some(StationType::MASTER_NOT_READY) => self.pause = 0,
            _ => {
                let next = self.after(station);
                self.cursor = if next == self.successor() { self.after(self.own) } else { next };
            }
        }
        if self.cursor == self.successor() {
            self.cursor = self.own;
        }
    }

    fn after(&self, station: u8) -> u8 {
        if station >= self.highest { 0 } else { station + 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_master_alone_polls_every_address_but_its_own_in_turn() {
        let mut ring = LogicalRing::new(2, 4, 1);
        let mut polled = Vec::new();
        for _ in 0..8 {
            let station = ring.token().expect("a factor of 1 polls at each token");
            polled.push(station);
            ring.polled(station, None);
        }
        assert_eq!(polled, [3, 4, 0, 1, 3, 4, 0, 1]);
    }

    #[test]
    fn it_polls_every_factor_rotations() {
        let mut ring = LogicalRing::new(2, 126, 3);
        let polled: Vec<_> = (0..7)
            .map(|_| {
                let station = ring.token();
                station.inspect(|station| ring.polled(*station, Some(StationType::SLAVE)));
                station
            })
            .collect();
        assert_eq!(polled, [Some(3), None, None, Some(4), None, None, Some(5)]);
    }

    #[test]
    fn a_master_that_is_not_ready_is_polled_again_and_then_gets_the_token() {
        let mut ring = LogicalRing::new(2, 126, 10);
        assert_eq!(ring.token(), Some(3));
        ring.polled(3, Some(StationType::MASTER_NOT_READY));
        assert_eq!((ring.token(), ring.successor()), (Some(3), 2));
        ring.polled(3, Some(StationType::MASTER_READY));
        assert_eq!(ring.successor(), 3);
        ring.remove(3);
        assert!(ring.is_alone());
    }

    #[test]
    fn with_a_factor_of_0_no_address_is_polled() {
        let mut ring = LogicalRing::new(2, 126, 0);
        assert_eq!([ring.token(), ring.token(), ring.token()], [None; 3]);
    }

    #[test]
    fn between_neighbours_no_address_is_polled() {
        let mut ring = LogicalRing::new(2, 126, 1);
        ring.token_observed(3, 2);
        ring.polled(3, Some(StationType::MASTER_IN_RING));
        assert_eq!(ring.token(), None);
    }

    #[test]
    fn a_neighbour_that_left_is_polled_again() {
        let mut ring = LogicalRing::new(2, 126, 10);
        ring.token_observed(3, 2);
        ring.polled(3, Some(StationType::MASTER_IN_RING));
        ring.remove(3);
        assert_eq!(ring.token(), Some(3));
    }

    #[test]
    fn a_token_of_another_master_than_the_predecessor_is_accepted_when_it_is_repeated() {
        let mut ring = LogicalRing::new(5, 126, 10);
        for (sa, da) in [(2, 3), (3, 4), (4, 5), (5, 9), (9, 2)] {
            ring.token_observed(sa, da);
        }
        assert!(ring.token_offered(4), "its predecessor");
        assert_eq!([ring.token_offered(2), ring.token_offered(2)], [false, true]);
        // 3 and 4 lie between, so they have left the ring.
        assert_eq!(ring.others, [2, 9]);
        assert!(ring.token_offered(2), "now its predecessor");
    }

    #[test]
    fn a_repetition_counts_only_if_nothing_came_between() {
        let mut ring = LogicalRing::new(5, 126, 10);
        ring.token_observed(4, 2);
        assert!(!ring.token_offered(9));
        ring.token_in_use();
        assert!(!ring.token_offered(9));
        assert_eq!([ring.token_offered(2), ring.token_offered(9)], [false, false]);
        assert!(ring.token_offered(9));
    }

    #[test]
    fn the_predecessor_of_the_lowest_master_is_the_highest() {
        let mut ring = LogicalRing::new(1, 126, 10);
        ring.token_observed(2, 100);
        ring.token_observed(100, 110);
        assert!(ring.token_offered(110));
        assert_eq!([ring.token_offered(100), ring.token_offered(100)], [false, true]);
        assert_eq!(ring.others, [2, 100]);
    }

    #[test]
    fn a_listener_knows_the_ring_after_two_rotations() {
        let mut ring = LogicalRing::new(5, 126, 10);
        ring.token_observed(2, 3);
        ring.token_observed(3, 2);
        assert!(!ring.is_complete());
        ring.token_observed(2, 3);
        ring.token_observed(3, 2);
        assert!(ring.is_complete());
        assert_eq!(ring.successor(), 2);
    }
}
