//! The order of time: a frame is passed on once the next one shows whether its time stamp is plausible.
//!
//! Files of several interfaces are slightly out of order, clocks are set, and a damaged time stamp is wrong once. The times that
//! are passed on never step back, except where the clock was set. This module must not know what a frame means.

use station::{Duration, Time};
use virtual_wire::capture::{CapturedPacket, LinkType};

/// Steps back shorter than this come from several interfaces in one file and are ignored.
const JITTER: Duration = Duration::from_millis(1);

/// Holds back one frame.
#[derive(Debug, Default)]
pub struct FrameOrder {
    slots: [HeldFrame; 2],
    /// The slot that is held back.
    current: usize,
    is_holding: bool,
    /// The last time passed on.
    floor: Option<Time>,
    /// Whether the time of the frame before was implausible, or frames are missing before this one.
    interrupted: bool,
}

#[derive(Debug, Default)]
struct HeldFrame {
    number: u64,
    time: Time,
    link: LinkType,
    octets: Vec<u8>,
    original: u32,
    /// Whether frames may be missing before it.
    behind_damage: bool,
}

/// A frame that is passed on.
#[derive(Clone, Copy, Debug)]
pub struct OrderedFrame<'a> {
    /// Its number in the file, from 1.
    pub number: u64,
    /// Its time; if the time stamp is implausible, that of the frame before.
    pub time: Time,
    /// Its link type, which says what the first byte is.
    pub link: LinkType,
    /// The captured bytes.
    pub octets: &'a [u8],
    /// The number of captured and of all bytes, if not all were captured.
    pub cut: Option<(usize, u32)>,
    /// Whether the state so far does not simply continue: frames may be missing before it, or its time is in doubt.
    pub interrupted: bool,
}

impl FrameOrder {
    /// Takes in the next packet and passes on the one before.
    pub fn push(&mut self, packet: &CapturedPacket<'_>, behind_damage: bool) -> Option<OrderedFrame<'_>> {
        let other = 1 - self.current;
        let held = &mut self.slots[other];
        held.number = packet.number as u64;
        held.time = packet.time;
        held.link = packet.link_type;
        held.octets.clear();
        held.octets.extend_from_slice(packet.captured);
        held.original = packet.original_length;
        held.behind_damage = behind_damage;
        let next = packet.time;
        let before = std::mem::replace(&mut self.current, other);
        std::mem::replace(&mut self.is_holding, true).then(|| self.pass_on(before, Some(next)))
    }

    /// Passes on the last packet.
    pub fn end(&mut self) -> Option<OrderedFrame<'_>> {
        let last = self.current;
        std::mem::take(&mut self.is_holding).then(|| self.pass_on(last, None))
    }

    fn pass_on(&mut self, slot: usize, next: Option<Time>) -> OrderedFrame<'_> {
        let held = &self.slots[slot];
        let floor = self.floor.unwrap_or(Time::ZERO);
        let (time, in_doubt) = judge(floor, held.time, next);
        let was_set = time < floor;
        let interrupted = std::mem::replace(&mut self.interrupted, in_doubt) || in_doubt || was_set;
        self.floor = Some(time);
        let kept = held.octets.len();
        OrderedFrame {
            number: held.number,
            time,
            link: held.link,
            octets: &held.octets,
            cut: (kept < held.original as usize).then_some((kept, held.original)),
            interrupted: interrupted || held.behind_damage,
        }
    }
}

/// The time assumed for a frame, and whether it is in doubt.
fn judge(floor: Time, time: Time, next: Option<Time>) -> (Time, bool) {
    let next = next.unwrap_or(time);
    match (time < floor, next < time) {
        (false, false) => (time, false),
        // Its time is ahead of its neighbours, or the clock was set back after it.
        (false, true) if next >= floor => (floor, time.since(next) >= JITTER),
        (false, true) => (time, false),
        (true, _) if floor.since(time) < JITTER => (floor, false),
        // Only this frame is behind its neighbours.
        (true, _) if next >= floor => (floor, true),
        // The clock was set back.
        (true, _) => (time, false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    /// Time stamps of the file in milliseconds, the times passed on, and the interrupted frames.
    #[rstest]
    #[case::in_order(&[1, 2, 3], &[1, 2, 3], &[])]
    #[case::without_a_clock(&[0, 0, 0], &[0, 0, 0], &[])]
    #[case::one_far_ahead(&[1, 2, 900, 4, 5], &[1, 2, 2, 4, 5], &[3, 4])]
    #[case::one_far_behind(&[11, 12, 0, 14, 15], &[11, 12, 12, 14, 15], &[3, 4])]
    #[case::two_swapped(&[1, 2, 5, 3, 6], &[1, 2, 2, 3, 6], &[3, 4])]
    #[case::the_clock_was_set_back(&[101, 102, 1, 2, 3], &[101, 102, 1, 2, 3], &[3])]
    #[case::the_clock_was_set_forward(&[1, 2, 900, 901], &[1, 2, 900, 901], &[])]
    #[case::the_last_one_behind(&[11, 12, 1], &[11, 12, 1], &[3])]
    fn implausible_times_are_replaced(#[case] file: &[u64], #[case] taken: &[u64], #[case] interrupted: &[u64]) {
        let mut line = FrameOrder::default();
        let (mut times, mut cuts) = (Vec::new(), Vec::new());
        let mut note = |next: OrderedFrame<'_>| {
            times.push(next.time.as_nanos() / 1_000_000);
            cuts.extend(next.interrupted.then_some(next.number));
        };
        for (place, &millis) in file.iter().enumerate() {
            let packet = CapturedPacket {
                number: place + 1,
                time: Time::from_nanos(millis * 1_000_000),
                section: 1,
                interface: 0,
                link_type: LinkType::ETHERNET,
                captured: &[1],
                original_length: 1,
                comment: None,
            };
            if let Some(next) = line.push(&packet, false) {
                note(next);
            }
        }
        if let Some(next) = line.end() {
            note(next);
        }
        assert_eq!((&times[..], &cuts[..]), (taken, interrupted));
    }
}
