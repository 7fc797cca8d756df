//! Hostile devices: conforming ones whose frames are spoilt on their way, each in one way that a table names.
//!
//! A tester must take no harm from them: it ends, in bounded memory, with a verdict that is never green.

mod table;

pub use table::{HOSTILE_DEVICES, HostileDevice};

use crate::damage::Random;
use station::{Duration, Outbox, Station, Time};
use std::collections::VecDeque;

/// Which frames of a device are spoilt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SpoiltFrames {
    /// All of them.
    All,
    Dcp,
    /// Calls and answers in UDP.
    Rpc,
    Cyclic,
    Alarms,
    Arp,
    /// PROFIBUS telegrams with data.
    Telegrams,
    /// PROFIBUS answers from the service access point for diagnosis, 60.
    Diagnosis,
}

/// What happens to a frame. Places are counted from the payload of an Ethernet frame, or from the start of a telegram; negative ones
/// from the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FrameSpoiling {
    /// It is sent so many microseconds later.
    Late(u64),
    /// It is sent so many times more.
    Again(usize),
    /// It has so many bytes at most.
    Cut(usize),
    /// Bytes are replaced.
    Put(i32, &'static [u8]),
    /// Two bytes are replaced by a number that grows with each frame.
    Counted(i32),
    /// So many bytes are random.
    Random(i32, usize),
    /// All of it but the addresses has one value.
    Filled(u8),
    /// One random bit is inverted.
    Flipped,
    /// Each second frame is sent before the one in front of it.
    Swapped,
    /// Its sender's address grows with each frame.
    OtherSender,
    /// Its sender has the address of a group.
    GroupSender,
    /// The station name in an answer is this one.
    Named(&'static [u8]),
    /// So many frames follow that say the same to all stations.
    Flood(usize),
    /// Every frame but each n-th is lost.
    Lost(usize),
}

/// A device whose frames are spoilt.
#[derive(Debug)]
pub struct SpoiltDevice<S> {
    station: S,
    how: &'static HostileDevice,
    random: Random,
    /// How many frames were spoilt.
    spoilt: u64,
    sent: Outbox,
    late: VecDeque<(Time, Vec<u8>)>,
    held: Option<Vec<u8>>,
}

impl<S> SpoiltDevice<S> {
    /// `station`, whose frames are spoilt as `how` says. The same device does the same again.
    pub fn new(station: S, how: &'static HostileDevice) -> SpoiltDevice<S> {
        let random = Random::new(1);
        SpoiltDevice { station, how, random, spoilt: 0, sent: Outbox::new(), late: VecDeque::new(), held: None }
    }

    /// The inner station, for a stand.
    pub fn station_mut(&mut self) -> &mut S {
        &mut self.station
    }

    fn pass_on(&mut self, now: Time, out: &mut Outbox) {
        let sent = std::mem::take(&mut self.sent);
        for frame in sent.frames() {
            match kind(frame, self.how.is_of_profibus) {
                Some(of) if self.how.frames == SpoiltFrames::All || self.how.frames == of => {
                    self.spoil(now, frame, out);
                }
                _ => out.push(frame),
            }
        }
        self.sent = sent;
        self.sent.clear();
        while self.late.front().is_some_and(|(due, _)| *due <= now) {
            self.late.pop_front().iter().for_each(|(_, frame)| out.push(frame));
        }
    }

    fn spoil(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.spoilt += 1;
        let mut octets = frame.to_vec();
        let head = if self.how.is_of_profibus { 0 } else { payload(frame) };
        match self.how.does {
            FrameSpoiling::Late(micros) => {
                self.late.push_back((now + Duration::from_micros(micros), octets));
                return;
            }
            FrameSpoiling::Again(times) => (0..times).for_each(|_| out.push(frame)),
            FrameSpoiling::Cut(length) => octets.truncate(length),
            FrameSpoiling::Put(at, with) => put(&mut octets, head, at, with),
            FrameSpoiling::Counted(at) => put(&mut octets, head, at, &(self.spoilt as u16).to_be_bytes()),
            FrameSpoiling::Random(at, count) => {
                let with: Vec<u8> = (0..count).map(|_| self.random.octet()).collect();
                put(&mut octets, head, at, &with);
            }
            FrameSpoiling::Filled(with) => octets.iter_mut().skip(head).for_each(|octet| *octet = with),
            FrameSpoiling::Flipped => {
                let bit = self.random.below(octets.len().saturating_sub(head).max(1) as u64 * 8) as usize;
                if let Some(octet) = octets.get_mut(head + bit / 8) {
                    *octet ^= 1 << (bit % 8);
                }
            }
            FrameSpoiling::Swapped => match self.held.take() {
                Some(before) => {
                    out.push(frame);
                    octets = before;
                }
                None => {
                    self.held = Some(octets);
                    return;
                }
            },
            FrameSpoiling::OtherSender => {
                let counted = self.spoilt.to_be_bytes();
                octets.iter_mut().skip(9).zip(&counted[5..]).take(3).for_each(|(octet, with)| *octet ^= with);
            }
            FrameSpoiling::GroupSender => octets.iter_mut().skip(6).take(1).for_each(|octet| *octet |= 1),
            FrameSpoiling::Named(name) => octets = named(frame, head, name).unwrap_or(octets),
            FrameSpoiling::Flood(count) => {
                let mut flood = frame.to_vec();
                flood.iter_mut().take(6).for_each(|octet| *octet = 0xFF);
                (0..count).for_each(|_| out.push(&flood));
            }
            FrameSpoiling::Lost(each) if !self.spoilt.is_multiple_of(each as u64) => return,
            FrameSpoiling::Lost(_) => {}
        }
        if self.how.is_sealed {
            seal(&mut octets, head, self.how.is_of_profibus);
        }
        out.push(&octets);
    }
}

impl<S: Station> Station for SpoiltDevice<S> {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.station.receive(now, frame, &mut self.sent);
        self.pass_on(now, out);
    }

    fn carrier(&mut self, now: Time) {
        self.station.carrier(now);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.station.wake(now, &mut self.sent);
        self.pass_on(now, out);
    }

    fn deadline(&self) -> Option<Time> {
        let late = self.late.front().map(|(due, _)| *due);
        self.station.deadline().into_iter().chain(late).min()
    }
}

/// Where the payload of an Ethernet frame begins, behind its tag if it has one.
fn payload(frame: &[u8]) -> usize {
    if frame.get(12..14) == Some(&[0x81, 0x00]) { 18 } else { 14 }
}

/// What a frame is; none: something that no hostile device spoils alone.
fn kind(frame: &[u8], is_of_profibus: bool) -> Option<SpoiltFrames> {
    if is_of_profibus {
        return Some(match frame {
            [0x68, _, _, 0x68, _, _, _, _, 0x3C, ..] => SpoiltFrames::Diagnosis,
            [0x68, ..] => SpoiltFrames::Telegrams,
            _ => SpoiltFrames::All,
        });
    }
    let head = payload(frame);
    Some(match (frame.get(head - 2..head)?, frame.get(head..head + 2)) {
        (&[0x88, 0x92], Some(&[0xFE, 0xFC..=0xFF])) => SpoiltFrames::Dcp,
        (&[0x88, 0x92], Some(&[0xFC | 0xFE, 0x01])) => SpoiltFrames::Alarms,
        (&[0x88, 0x92], _) => SpoiltFrames::Cyclic,
        (&[0x08, 0x06], _) => SpoiltFrames::Arp,
        (&[0x08, 0x00], _) if frame.get(head + 9) == Some(&17) => SpoiltFrames::Rpc,
        _ => SpoiltFrames::All,
    })
}

fn put(octets: &mut [u8], head: usize, at: i32, with: &[u8]) {
    let from = if at < 0 {
        octets.len().checked_sub(at.unsigned_abs() as usize)
    } else {
        Some(head + at.unsigned_abs() as usize)
    };
    if let Some(from) = from {
        octets.iter_mut().skip(from).zip(with).for_each(|(octet, with)| *octet = *with);
    }
}

/// A DCP answer with another station name: the block of option 2, suboption 2, and the lengths around it.
fn named(frame: &[u8], head: usize, name: &[u8]) -> Option<Vec<u8>> {
    let mut at = head + 12;
    loop {
        let [option, suboption, high, low] = *frame.get(at..at + 4)?.first_chunk::<4>()?;
        let length = usize::from(u16::from_be_bytes([high, low]));
        let padded = length + length % 2;
        if (option, suboption) == (2, 2) {
            let mut octets = frame.get(..at)?.to_vec();
            // Two bytes of BlockInfo stand in front of the name.
            octets.extend([2, 2]);
            octets.extend((name.len() as u16 + 2).to_be_bytes());
            octets.extend([0, 0]);
            octets.extend(name);
            octets.extend(std::iter::repeat_n(0, name.len() % 2));
            octets.extend(frame.get(at + 4 + padded..)?);
            let data = (octets.len() - head - 12) as u16;
            octets.get_mut(head + 10..head + 12)?.copy_from_slice(&data.to_be_bytes());
            return Some(octets);
        }
        at += 4 + padded;
    }
}

/// Makes the checksum right again, so that only what was spoilt is wrong: none in UDP, that of the telegram on PROFIBUS.
fn seal(octets: &mut [u8], head: usize, is_of_profibus: bool) {
    if !is_of_profibus {
        if octets.get(head - 2..head) == Some(&[0x08, 0x00]) {
            put(octets, head, 26, &[0, 0]);
        }
        return;
    }
    let Some(end) = octets.len().checked_sub(2).filter(|end| *end > 4) else { return };
    octets[end] = octets[4..end].iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
}

#[cfg(test)]
mod tests;
