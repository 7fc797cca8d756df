//! Octets as they came, in pieces of any length, to frames and damage with the time of their first start bit.

use station::{Duration, Time};
use std::collections::VecDeque;
use wire::WireError;
use wire::profibus::fdl::{BaudRate, BitTimes, Piece, Splitter};

/// A shorter pause within a frame is one of the system that gathered the octets.
const SILENCE: Duration = Duration::from_millis(20);
/// Where the rate is not known: the slowest that there is.
const SLOWEST: BaudRate = BaudRate(9_600);

/// A frame, or octets that are none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Joined {
    /// When its first start bit was on the wire.
    pub begin: Time,
    /// The octets, from the first delimiter to the last.
    pub octets: Vec<u8>,
    /// Why they are no frame; none for a frame.
    pub damage: Option<WireError>,
}

/// Joins octets to frames.
#[derive(Debug)]
pub struct Joiner {
    split: Splitter,
    /// What was pushed and has not come out yet.
    waiting: VecDeque<Run>,
    baud: Option<BaudRate>,
    /// When the octets began that came last.
    last: Time,
    /// When the last octet was over, at the latest.
    end: Time,
}

/// Octets that came in one go.
#[derive(Clone, Copy, Debug)]
struct Run {
    begin: Time,
    count: usize,
    /// How many of them have come out.
    gone: usize,
}

impl Joiner {
    /// For a bus of the rate `baud`; without one all octets that came in one go have the time of their first.
    pub fn new(baud: Option<BaudRate>) -> Joiner {
        Joiner { split: Splitter::new(), waiting: VecDeque::new(), baud, last: Time::ZERO, end: Time::ZERO }
    }

    /// Takes octets, the first of which began at `begin`, and hands out what is complete.
    ///
    /// What waits for others is over when these come long after it, or before it: then somebody has set the clock.
    pub fn push(&mut self, begin: Time, octets: &[u8], out: &mut dyn FnMut(Joined)) {
        if begin.since(self.end) > SILENCE || self.last.since(begin) > SILENCE {
            self.silence(out);
        }
        self.split.push(octets);
        self.waiting.push_back(Run { begin, count: octets.len(), gone: 0 });
        let lasts = self.baud.unwrap_or(SLOWEST).nanoseconds(BitTimes::of_octets(octets.len()));
        self.last = begin;
        self.end = begin + Duration::from_nanos(lasts);
        while let Some(piece) = self.split.next_piece() {
            let joined = self.joined(piece);
            out(joined);
        }
    }

    /// When what waits for others is over unless they come; none if nothing waits.
    pub fn silent_at(&self) -> Option<Time> {
        self.split.is_waiting().then(|| self.end + SILENCE)
    }

    /// Says that the wire was silent: what waits is handed out as it is.
    pub fn silence(&mut self, out: &mut dyn FnMut(Joined)) {
        while let Some(piece) = self.split.silence() {
            let joined = self.joined(piece);
            out(joined);
        }
    }

    fn joined(&mut self, piece: Piece) -> Joined {
        let (octets, damage) = match piece {
            Piece::Frame(octets) => (octets, None),
            Piece::Damaged { octets, why } => (octets, Some(why)),
        };
        Joined { begin: self.take(octets.len()), octets, damage }
    }

    /// When the next octet began; takes `count` of them away.
    fn take(&mut self, mut count: usize) -> Time {
        let begin = self.waiting.front().map_or(self.end, |run| {
            let before = self.baud.map_or(0, |baud| baud.nanoseconds(BitTimes::of_octets(run.gone)));
            run.begin + Duration::from_nanos(before)
        });
        while let Some(run) = self.waiting.front_mut() {
            let here = count.min(run.count - run.gone);
            run.gone += here;
            count -= here;
            if run.gone < run.count {
                break;
            }
            self.waiting.pop_front();
        }
        begin
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    const TOKEN: [u8; 3] = [0xDC, 0x02, 0x02];
    /// Get_Cfg of station 8, as pyprofibus 1.13 makes it.
    const GET_CFG: [u8; 11] = [0x68, 0x05, 0x05, 0x68, 0x88, 0x82, 0x4D, 0x3B, 0x3E, 0xD0, 0x16];

    fn long_frame() -> Vec<u8> {
        let mut frame = vec![0x68, 103, 103, 0x68, 0x02, 0x08, 0x08];
        frame.resize(4 + 103, 0x55);
        let sum = frame[4..].iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
        frame.extend([sum, 0x16]);
        frame
    }

    /// What comes of pieces, each with the microsecond at which it began: the microsecond of each, its octets, whether it is damage.
    fn joined(baud: Option<u32>, pieces: &[(u64, &[u8])]) -> Vec<(u64, Vec<u8>, bool)> {
        let mut joiner = Joiner::new(baud.map(BaudRate));
        let mut all = Vec::new();
        let mut out = |found: Joined| {
            all.push((found.begin.as_nanos() / 1_000, found.octets, found.damage.is_some()));
        };
        for (begin, octets) in pieces {
            joiner.push(Time::from_nanos(begin * 1_000), octets, &mut out);
        }
        joiner.silence(&mut out);
        assert_eq!(joiner.silent_at(), None);
        all
    }

    #[rstest]
    fn a_frame_in_two_pieces_has_the_time_of_its_first_octet(#[values(1, 4, 7, 10)] cut: usize) {
        let (first, second) = GET_CFG.split_at(cut);
        assert_eq!(joined(Some(19_200), &[(500, first), (9_000, second)]), [(500, GET_CFG.to_vec(), false)]);
    }

    #[test]
    fn frames_in_one_piece_are_placed_by_the_rate() {
        let both = [&TOKEN[..], &GET_CFG, &[0xE5]].concat();
        // 3 and 14 octets of 11 bits at 1.1 Mbit/s.
        let expected = [(500, TOKEN.to_vec(), false), (530, GET_CFG.to_vec(), false), (640, vec![0xE5], false)];
        assert_eq!(joined(Some(1_100_000), &[(500, &both)]), expected);
        let at_once = expected.map(|(_, octets, damage)| (500, octets, damage));
        assert_eq!(joined(None, &[(500, &both)]), at_once);
    }

    #[test]
    fn noise_is_kept_and_the_frame_behind_it_found() {
        let pieces: [(u64, &[u8]); 3] = [(0, &[0x00, 0xFF]), (100, &GET_CFG), (5_000, &[0x16])];
        let expected = [(0, vec![0x00, 0xFF], true), (100, GET_CFG.to_vec(), false), (5_000, vec![0x16], true)];
        assert_eq!(joined(None, &pieces), expected);
    }

    #[test]
    fn a_pause_ends_what_waits() {
        let half = &GET_CFG[..6];
        let expected = [(0, half.to_vec(), true), (60_000, TOKEN.to_vec(), false)];
        assert_eq!(joined(None, &[(0, half), (60_000, &TOKEN)]), expected);
    }

    #[test]
    fn a_clock_that_was_set_back_ends_what_waits() {
        let half = &GET_CFG[..6];
        let expected = [(60_000, half.to_vec(), true), (0, TOKEN.to_vec(), false)];
        assert_eq!(joined(None, &[(60_000, half), (0, &TOKEN)]), expected);
    }

    /// At a rate that is not known, octets are not taken to be in disorder because a slower bus would have needed longer for them.
    #[test]
    fn a_fast_bus_is_not_taken_for_a_clock_that_was_set_back() {
        let frame = long_frame();
        let (first, second) = frame.split_at(90);
        assert_eq!(joined(None, &[(0, first), (80, second)]), [(0, frame.clone(), false)]);
    }

    /// Octets in lines of 32, as hex dumps have them, last long at a slow rate: that is no pause.
    #[test]
    fn long_frames_in_lines_are_joined() {
        let frame = long_frame();
        let pieces: Vec<(u64, &[u8])> = (0..).step_by(36_667).zip(frame.chunks(32)).collect();
        assert_eq!(joined(None, &pieces), [(0, frame.clone(), false)]);
    }
}
