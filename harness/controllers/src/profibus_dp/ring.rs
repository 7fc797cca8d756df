//! The logical ring: which masters there are, and who is asked next whether it is one.
//!
//! This room must not know time. Source: IEC 61158-4-3, LAS and GAPL.

use alloc::vec::Vec;
use wire::profibus::fdl::{BROADCAST, StationType};

/// Rounds of the token after which a listener knows the ring.
const ROUNDS: u8 = 2;

/// The masters that a master knows, and its search for more.
#[derive(Clone, Debug)]
pub(super) struct Ring {
    own: u8,
    highest: u8,
    /// LAS, ascending, without ourselves.
    others: Vec<u8>,
    /// How often the token was heard to come round.
    rounds: u8,
    /// The address that is asked next.
    cursor: u8,
    /// After how many tokens.
    pause: u8,
    factor: u8,
}

impl Ring {
    pub fn new(own: u8, highest: u8, factor: u8) -> Ring {
        let mut ring = Ring { own, highest, others: Vec::new(), rounds: 0, cursor: own, pause: 0, factor };
        ring.cursor = ring.after(own);
        ring
    }

    /// Whether nobody else is in the ring.
    pub fn is_alone(&self) -> bool {
        self.others.is_empty()
    }

    /// Who gets the token from us.
    pub fn successor(&self) -> u8 {
        let next = self.others.iter().find(|other| **other > self.own).or(self.others.first());
        next.copied().unwrap_or(self.own)
    }

    /// A token was heard that goes from `sa` to `da`.
    pub fn heard(&mut self, sa: u8, da: u8) {
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

    /// Whether the ring is known, so that we may enter it.
    pub fn is_known(&self) -> bool {
        self.rounds >= ROUNDS
    }

    /// Nobody else is in the ring, and nothing is known of it.
    pub fn clear(&mut self) {
        self.others.clear();
        (self.rounds, self.cursor, self.pause) = (0, self.after(self.own), 0);
    }

    /// `master` does not take the token; the search begins anew, so that it is found once it is back.
    pub fn remove(&mut self, master: u8) {
        self.others.retain(|other| *other != master);
        (self.cursor, self.pause) = (self.after(self.own), 0);
    }

    /// We have the token once more; the address that is to be asked now, if one is.
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

    /// What became of asking `station`: its type if it answered.
    pub fn asked(&mut self, station: u8, answer: Option<StationType>) {
        self.pause = self.factor.saturating_sub(1);
        match answer {
            Some(StationType::MASTER_READY | StationType::MASTER_IN_RING) => {
                self.heard(self.own, station);
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
    fn alone_it_asks_every_address_but_its_own_in_turn() {
        let mut ring = Ring::new(2, 4, 1);
        let mut asked = Vec::new();
        for _ in 0..8 {
            let station = ring.token().expect("a factor of 1 asks at each token");
            asked.push(station);
            ring.asked(station, None);
        }
        assert_eq!(asked, [3, 4, 0, 1, 3, 4, 0, 1]);
    }

    #[test]
    fn it_asks_each_factor_th_round() {
        let mut ring = Ring::new(2, 126, 3);
        let asked: Vec<_> = (0..7)
            .map(|_| {
                let station = ring.token();
                station.inspect(|station| ring.asked(*station, Some(StationType::SLAVE)));
                station
            })
            .collect();
        assert_eq!(asked, [Some(3), None, None, Some(4), None, None, Some(5)]);
    }

    #[test]
    fn a_master_that_is_not_ready_is_asked_again_and_then_gets_the_token() {
        let mut ring = Ring::new(2, 126, 10);
        assert_eq!(ring.token(), Some(3));
        ring.asked(3, Some(StationType::MASTER_NOT_READY));
        assert_eq!((ring.token(), ring.successor()), (Some(3), 2));
        ring.asked(3, Some(StationType::MASTER_READY));
        assert_eq!(ring.successor(), 3);
        ring.remove(3);
        assert!(ring.is_alone());
    }

    #[test]
    fn with_a_factor_of_0_nobody_is_ever_asked() {
        let mut ring = Ring::new(2, 126, 0);
        assert_eq!([ring.token(), ring.token(), ring.token()], [None; 3]);
    }

    #[test]
    fn between_neighbours_nobody_is_asked() {
        let mut ring = Ring::new(2, 126, 1);
        ring.heard(3, 2);
        ring.asked(3, Some(StationType::MASTER_IN_RING));
        assert_eq!(ring.token(), None);
    }

    #[test]
    fn a_neighbour_that_went_away_is_asked_for_again() {
        let mut ring = Ring::new(2, 126, 10);
        ring.heard(3, 2);
        ring.asked(3, Some(StationType::MASTER_IN_RING));
        ring.remove(3);
        assert_eq!(ring.token(), Some(3));
    }

    #[test]
    fn a_listener_knows_the_ring_after_two_rounds() {
        let mut ring = Ring::new(5, 126, 10);
        ring.heard(2, 3);
        ring.heard(3, 2);
        assert!(!ring.is_known());
        ring.heard(2, 3);
        ring.heard(3, 2);
        assert!(ring.is_known());
        assert_eq!(ring.successor(), 2);
    }
}
