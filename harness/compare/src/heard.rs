//! What was heard in a trace: what the controller asked one after the other, what the device answered, and how the names of
//! its inputs went in between.
//!
//! Plain data with the names of the manual, the same for a capture and for a run of ours, so that both can be compared. This
//! room must not know frames.

use super::ask::Ask;
use plain_text::hex;
use station::Time;
use std::collections::BTreeMap;
use std::fmt;

/// A value as a suite writes it, with its number where it has one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Value {
    /// The literal: `5`, `enabled`, `"80 00"`, `{ refused: read_only }`.
    pub text: String,
    /// The number that stands for it.
    pub number: Option<i128>,
}

impl Value {
    /// A value that is no number.
    pub fn word(text: impl Into<String>) -> Value {
        Value { text: text.into(), number: None }
    }

    /// A number, as hexadecimal where it is long and has no sign.
    pub fn number(number: i128, width: u32, signed: bool) -> Value {
        let text = match signed || number < 10 || width < 16 {
            true => number.to_string(),
            false => format!("0x{number:X}"),
        };
        Value { text, number: Some(number) }
    }

    /// A number that a table may have a word for.
    pub fn of_table(number: i128, width: u32, signed: bool, words: &[(String, i128)]) -> Value {
        match words.iter().find(|(_, known)| *known == number) {
            Some((word, _)) => Value { text: word.clone(), number: Some(number) },
            None => Value::number(number, width, signed),
        }
    }

    /// Octets.
    pub fn octets(octets: &[u8]) -> Value {
        Value::word(format!("\"{}\"", hex(octets)))
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// One thing that the controller did, and what came of it.
#[derive(Clone, Debug)]
pub struct Asked {
    /// What it did.
    pub ask: Ask,
    /// When it began.
    pub at: Time,
    /// When it was answered.
    pub done: Time,
    /// The frame of the answer, or of the outputs.
    pub frame: u64,
    /// The parts of the answer by name.
    pub answer: Vec<(String, Value)>,
}

/// From here on a name has another value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// When.
    pub at: Time,
    /// In which frame.
    pub frame: u64,
    /// The value; none where it is not known.
    pub value: Option<Value>,
}

/// How one name went.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// Its changes in the order of time.
    pub changes: Vec<Change>,
    /// Whether it is a measured number that may pass through every value between two.
    pub measured: bool,
    /// Whether it is a place of the shaft.
    pub is_place: bool,
    /// Where it stands in the frames that carry it.
    pub stands: Option<Stands>,
}

/// Where a name of cyclic data stands in a frame: a number, most significant octet first, and which of its bits are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stands {
    /// The first octet of the number, from 0 at the first one of the frame.
    pub octet: usize,
    /// How many octets the number has.
    pub octets: usize,
    /// The lowest bit that is meant, 0 is the least significant.
    pub low: u32,
    /// How many bits are meant.
    pub width: u32,
}

impl Stands {
    /// The octet and the bit of the highest bit in which two values differ; the bit only where a single one is meant.
    pub fn differs(&self, one: Option<i128>, other: Option<i128>) -> (usize, Option<u8>) {
        let mask = (1_i128 << self.width.min(64)) - 1;
        let different = one.zip(other).map_or(mask, |(one, other)| (one ^ other) & mask);
        let highest = self.low + (i128::BITS - 1).saturating_sub(different.leading_zeros());
        let behind = (highest / 8) as usize;
        let octet = self.octet + (self.octets.saturating_sub(1)).saturating_sub(behind);
        (octet, (self.width == 1).then_some((highest % 8) as u8))
    }
}

impl Track {
    /// Takes over a value; one that is the same as before changes nothing.
    pub fn take(&mut self, at: Time, frame: u64, value: Option<Value>) {
        if self.changes.last().map(|last| &last.value) != Some(&value) {
            self.changes.push(Change { at, frame, value });
        }
    }

    /// The change in force at an instant; none before the first.
    pub fn at(&self, time: Time) -> Option<&Change> {
        let behind = self.changes.partition_point(|change| change.at <= time);
        self.changes.get(behind.checked_sub(1)?)
    }
}

/// Something that the device did by itself at one instant: an alarm, an abort.
#[derive(Clone, Debug)]
pub struct Event {
    /// When.
    pub at: Time,
    /// In which frame.
    pub frame: u64,
    /// What it said, by the names of the language.
    pub said: Vec<(String, Value)>,
}

/// Something in a capture that cannot be done again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// The frame.
    pub frame: u64,
    /// What it was.
    pub what: String,
    /// From when on it may have changed what the device answers; none where it changes nothing.
    pub since: Option<Time>,
    /// Until when; none for the rest of the capture.
    pub until: Option<Time>,
}

impl LeftOut {
    /// Whether what the device answered at this time may come of it.
    pub fn covers(&self, time: Time) -> bool {
        self.since.is_some_and(|since| since <= time) && self.until.is_none_or(|until| time < until)
    }
}

/// What was said between a controller and a device.
#[derive(Clone, Debug, Default)]
pub struct Conversation {
    /// What the controller did.
    pub asked: Vec<Asked>,
    /// How the inputs went, by name.
    pub tracks: BTreeMap<String, Track>,
    /// What the device did by itself.
    pub events: Vec<Event>,
    /// What the controller did and cannot be done again.
    pub left_out: Vec<LeftOut>,
    /// The cycle of the last connection.
    pub cycle: Option<std::time::Duration>,
    /// When the last frame came.
    pub end: Time,
}

/// What was heard in a capture, and when its first frame came.
#[derive(Clone, Debug)]
pub struct Heard {
    /// What was said between the controller and the device.
    pub said: Conversation,
    /// The time of the first frame.
    pub begin: Time,
}
