//! Assembles bytes, received in chunks of any length, into frames and damage with the time of their first start bit.

use station::{Duration, Time};
use std::collections::VecDeque;
use wire::WireError;
use wire::profibus::fdl::{BaudRate, BitTimes, FdlPiece, Splitter};

/// A shorter gap inside a frame comes from the system that collected the bytes.
const SILENCE: Duration = Duration::from_millis(20);
/// The baud rate to assume if it is unknown: the slowest one.
const SLOWEST: BaudRate = BaudRate(9_600);

/// A frame, or bytes that are not a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Joined {
    /// Start time of the first start bit on the wire.
    pub begin: Time,
    /// The bytes, from the first delimiter to the last.
    pub octets: Vec<u8>,
    /// Why they are not a frame; `None` for a frame.
    pub damage: Option<WireError>,
}

/// Assembles bytes into frames.
#[derive(Debug)]
pub struct Joiner {
    split: Splitter,
    /// Chunks that were pushed and not completely returned yet.
    waiting: VecDeque<ByteRun>,
    baud: Option<BaudRate>,
    /// Start time of the last chunk.
    last: Time,
    /// The latest time at which the last byte ended.
    end: Time,
}

/// Contiguous bytes of one push.
#[derive(Clone, Copy, Debug)]
struct ByteRun {
    begin: Time,
    count: usize,
    /// How many of them were returned.
    gone: usize,
}

impl Joiner {
    /// For a bus at `baud`; without a rate all bytes of a chunk have the time of their first one.
    pub fn new(baud: Option<BaudRate>) -> Joiner {
        Joiner { split: Splitter::new(), waiting: VecDeque::new(), baud, last: Time::ZERO, end: Time::ZERO }
    }

    /// Processes bytes, the first of which began at `begin`, and returns what is complete. Incomplete bytes are ended if these
    /// bytes come long after them, or before them: then the clock was set back.
    pub fn push(&mut self, begin: Time, octets: &[u8], out: &mut dyn FnMut(Joined)) {
        if begin.since(self.end) > SILENCE || self.last.since(begin) > SILENCE {
            self.silence(out);
        }
        self.split.push(octets);
        self.waiting.push_back(ByteRun { begin, count: octets.len(), gone: 0 });
        let lasts = self.baud.unwrap_or(SLOWEST).nanoseconds(BitTimes::of_octets(octets.len()));
        self.last = begin;
        self.end = begin + Duration::from_nanos(lasts);
        while let Some(piece) = self.split.next_piece() {
            let joined = self.joined(piece);
            out(joined);
        }
    }

    /// When incomplete bytes end unless more arrive; `None` if there are none.
    pub fn silent_at(&self) -> Option<Time> {
        self.split.is_waiting().then(|| self.end + SILENCE)
    }

    /// Reports silence on the wire: incomplete bytes are returned as they are.
    pub fn silence(&mut self, out: &mut dyn FnMut(Joined)) {
        while let Some(piece) = self.split.silence() {
            let joined = self.joined(piece);
            out(joined);
        }
    }

    fn joined(&mut self, piece: FdlPiece) -> Joined {
        let (octets, damage) = match piece {
            FdlPiece::Frame(octets) => (octets, None),
            FdlPiece::Damaged { octets, why } => (octets, Some(why)),
        };
        Joined { begin: self.take(octets.len()), octets, damage }
    }

    /// The start time of the next byte; removes `count` bytes.
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
    /// Get_Cfg of station 8, as pyprofibus 1.13 sends it.
    const GET_CFG: [u8; 11] = [0x68, 0x05, 0x05, 0x68, 0x88, 0x82, 0x4D, 0x3B, 0x3E, 0xD0, 0x16];

    fn long_frame() -> Vec<u8> {
        let mut frame = vec![0x68, 103, 103, 0x68, 0x02, 0x08, 0x08];
        frame.resize(4 + 103, 0x55);
        let sum = frame[4..].iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
        frame.extend([sum, 0x16]);
        frame
    }

    /// The result of chunks, each with its start in microseconds: start in microseconds, bytes, whether they are damage.
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
    fn a_frame_in_two_pieces_has_the_time_of_its_first_byte(#[values(1, 4, 7, 10)] cut: usize) {
        let (first, second) = GET_CFG.split_at(cut);
        assert_eq!(joined(Some(19_200), &[(500, first), (9_000, second)]), [(500, GET_CFG.to_vec(), false)]);
    }

    #[test]
    fn frames_in_one_piece_are_placed_by_the_rate() {
        let both = [&TOKEN[..], &GET_CFG, &[0xE5]].concat();
        // 3 and 14 bytes of 11 bits at 1.1 Mbit/s.
        let expected = [(500, TOKEN.to_vec(), false), (530, GET_CFG.to_vec(), false), (640, vec![0xE5], false)];
        assert_eq!(joined(Some(1_100_000), &[(500, &both)]), expected);
        let at_once = expected.map(|(_, octets, damage)| (500, octets, damage));
        assert_eq!(joined(None, &[(500, &both)]), at_once);
    }

    #[test]
    fn noise_is_recorded_and_the_next_frame_is_found() {
        let pieces: [(u64, &[u8]); 3] = [(0, &[0x00, 0xFF]), (100, &GET_CFG), (5_000, &[0x16])];
        let expected = [(0, vec![0x00, 0xFF], true), (100, GET_CFG.to_vec(), false), (5_000, vec![0x16], true)];
        assert_eq!(joined(None, &pieces), expected);
    }

    #[test]
    fn a_pause_ends_an_incomplete_frame() {
        let half = &GET_CFG[..6];
        let expected = [(0, half.to_vec(), true), (60_000, TOKEN.to_vec(), false)];
        assert_eq!(joined(None, &[(0, half), (60_000, &TOKEN)]), expected);
    }

    #[test]
    fn a_clock_that_was_set_back_ends_an_incomplete_frame() {
        let half = &GET_CFG[..6];
        let expected = [(60_000, half.to_vec(), true), (0, TOKEN.to_vec(), false)];
        assert_eq!(joined(None, &[(60_000, half), (0, &TOKEN)]), expected);
    }

    /// At an unknown rate, bytes are not out of order just because a slower bus would have needed longer for them.
    #[test]
    fn a_fast_bus_is_not_mistaken_for_a_clock_that_was_set_back() {
        let frame = long_frame();
        let (first, second) = frame.split_at(90);
        assert_eq!(joined(None, &[(0, first), (80, second)]), [(0, frame.clone(), false)]);
    }

    /// Bytes in lines of 32, as in hex dumps, last long at a slow rate: that is not a pause.
    #[test]
    fn long_frames_in_lines_are_joined() {
        let frame = long_frame();
        let pieces: Vec<(u64, &[u8])> = (0..).step_by(36_667).zip(frame.chunks(32)).collect();
        assert_eq!(joined(None, &pieces), [(0, frame.clone(), false)]);
    }
}
