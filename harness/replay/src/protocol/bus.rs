//! The bus itself: lost tokens, masters that send at the same time, damaged frames, and captures of one side only.

use super::coverage::{CapturePosition, FindingList, SettledFrames};
use super::slaves::on_bus;
use super::table::{DP_DAMAGED, DP_ONE_SIDED, DP_TOKEN_LOST, DP_TOKEN_TWICE};
use crate::finding::{CaptureBlame, FindingSeverity};
use judge::observe::{DpCounts, Observation, PollPart, Traffic};
use std::collections::BTreeMap;

/// This many requests without any answer show that the answers are not recorded, or that no slave is connected.
const MANY: u64 = 50;
/// A master that has passed the token on this often belongs to a stable ring.
const STEADY: u64 = 3;
/// This many damaged frames are accepted, since a recording may begin in the middle of a frame.
const FEW: u64 = 2;

/// A master in the ring.
#[derive(Clone, Copy, Debug, Default)]
struct RingMaster {
    /// How often it passed the token on, and the frame in which it last did.
    passed: u64,
    last: u64,
    /// How many tokens other masters have passed on since.
    since: u64,
}

/// The token ring and the frame counts of the bus.
#[derive(Clone, Debug, Default)]
pub(super) struct TokenRing {
    /// The master that holds the token, where it is known.
    holder: Option<u8>,
    masters: BTreeMap<u8, RingMaster>,
    /// A master that sends requests without the token, the first frame, and how often. If the holder sends too, there are two tokens.
    intruder: Option<(u8, u64, u64)>,
    /// Requests of a master without the token while the holder sent too: master, holder, first frame, how often.
    twice: BTreeMap<(u8, u8), (u64, u64)>,
    /// Tokens passed on by a master that had not received it: first frame, how often, sender, expected holder.
    lost: Option<(u64, u64, u8, u8)>,
    asked: u64,
    answered: u64,
    first_asked: u64,
    damaged: (u64, u64),
    /// The frames before those whose damage is counted.
    frames_before: u64,
}

impl TokenRing {
    pub fn observe(&mut self, now: CapturePosition, observation: &Observation<'_>) {
        match observation {
            Observation::Traffic(Traffic::Token { from, to }) => {
                let intruder = self.intruder.take();
                if let Some((intruder, frame, count)) =
                    intruder.filter(|(of, ..)| of != from && self.holder == Some(*from))
                {
                    self.twice.entry((intruder, *from)).or_insert((frame, 0)).1 += count;
                }
                if let Some(holder) = self.holder.filter(|holder| holder != from) {
                    // A master that claims the token after a silence first passes it to itself.
                    let lost = self.lost.get_or_insert((now.frame, 0, *from, holder));
                    lost.1 += 1;
                }
                for (address, master) in &mut self.masters {
                    if address != from {
                        master.since += 1;
                    }
                }
                let master = self.masters.entry(*from).or_default();
                (master.passed, master.last, master.since) = (master.passed + 1, now.frame, 0);
                self.holder = Some(*to);
            }
            Observation::Traffic(Traffic::Poll { master, part, .. }) => match part {
                PollPart::Asked | PollPart::Again => {
                    self.asked += 1;
                    if self.first_asked == 0 {
                        self.first_asked = now.frame;
                    }
                    match (self.holder, self.intruder) {
                        (Some(holder), None) if holder != *master => self.intruder = Some((*master, now.frame, 1)),
                        (Some(holder), Some((intruder, frame, count))) if holder != *master && intruder == *master => {
                            self.intruder = Some((intruder, frame, count + 1));
                        }
                        (Some(holder), Some((intruder, frame, count))) if holder == *master => {
                            self.twice.entry((intruder, holder)).or_insert((frame, 0)).1 += count;
                            self.intruder = None;
                        }
                        _ => {}
                    }
                }
                PollPart::Answered => self.answered += 1,
                PollPart::Unanswered => {}
            },
            // A damaged frame may have been a token.
            Observation::Unreadable { .. } => {
                self.holder = None;
                if self.damaged.0 == 0 {
                    self.damaged.1 = now.frame;
                }
                self.damaged.0 += 1;
            }
            _ => {}
        }
    }

    pub fn end(self, counts: &DpCounts, findings: &mut FindingList) {
        if self.damaged.0 > FEW {
            let frames = counts.frames.saturating_sub(self.frames_before);
            let severity = if self.damaged.0 * 100 > frames { FindingSeverity::Warning } else { FindingSeverity::Info };
            let text = format!("{} of {frames} frames are damaged", self.damaged.0);
            findings.add(on_bus(DP_DAMAGED.finding(severity, CaptureBlame::Network, self.damaged.1, text), None));
        }
        if self.asked >= MANY && self.answered == 0 {
            let text = format!(
                "{} requests and no answer: the capture shows one side only, or no slave is connected",
                self.asked
            );
            findings.add(on_bus(
                DP_ONE_SIDED.finding(FindingSeverity::Info, CaptureBlame::Capture, self.first_asked, text),
                None,
            ));
        }
        for ((master, holder), (frame, count)) in &self.twice {
            let text = format!("master {master} sends {count} requests while master {holder} holds the token");
            findings.add(on_bus(
                DP_TOKEN_TWICE.finding(FindingSeverity::Error, CaptureBlame::Controller, *frame, text),
                None,
            ));
        }
        if let Some((frame, count, from, holder)) = self.lost.filter(|_| self.twice.is_empty()) {
            let text = format!(
                "master {from} passes on the token although master {holder} holds it ({count} times in the capture)"
            );
            findings
                .add(on_bus(DP_TOKEN_LOST.finding(FindingSeverity::Warning, CaptureBlame::Network, frame, text), None));
        }
        let rounds = self.masters.values().map(|master| master.passed).max().unwrap_or(0);
        for (address, master) in &self.masters {
            if master.passed >= STEADY && master.since > STEADY * self.masters.len() as u64 && master.passed < rounds {
                let text = format!("master {address} is not in the ring after this frame");
                findings.add(on_bus(
                    DP_TOKEN_LOST.finding(FindingSeverity::Warning, CaptureBlame::Network, master.last, text),
                    None,
                ));
            }
        }
    }
}

impl TokenRing {
    /// Forgets what a watch that never ends need not remember; `frames` is the number of frames so far.
    pub fn forget(&mut self, settled: SettledFrames<'_>, frames: u64) {
        self.twice.retain(|_, (first, _)| *first > settled.reported);
        self.lost = self.lost.filter(|(first, ..)| *first > settled.reported);
        self.masters.retain(|_, master| master.last > settled.old);
        if self.damaged.1 <= settled.reported {
            (self.damaged, self.frames_before) = ((0, 0), frames);
        }
    }
}
