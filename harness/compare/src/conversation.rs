//! The conversation in a trace: the actions of the controller in order, the answers of the device, and the values of its inputs over
//! time.
//!
//! It is plain data with the names of the manual, the same for a capture and for a run of encspec, so that both can be compared. This
//! module must not know frames.

use super::action::ControllerAction;
use expression::Value;
use plain_text::hex;
use station::Time;
use std::collections::BTreeMap;
use std::fmt;

/// A value in the form of the suite language, with its number if it has one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SuiteValue {
    /// The literal: `5`, `enabled`, `"80 00"`, `{ refused: read_only }`.
    pub text: String,
    /// The number of the value.
    pub number: Option<i128>,
}

impl SuiteValue {
    /// A value without a number.
    pub fn word(text: impl Into<String>) -> SuiteValue {
        SuiteValue { text: text.into(), number: None }
    }

    /// A number, in hexadecimal if it is long and unsigned.
    pub fn number(number: i128, width: u32, signed: bool) -> SuiteValue {
        let text = if signed || number < 10 || width < 16 { number.to_string() } else { format!("0x{number:X}") };
        SuiteValue { text, number: Some(number) }
    }

    /// A number for which a table may have a word.
    pub fn of_table(number: i128, width: u32, signed: bool, words: &[(String, i128)]) -> SuiteValue {
        match words.iter().find(|(_, known)| *known == number) {
            Some((word, _)) => SuiteValue { text: word.clone(), number: Some(number) },
            None => SuiteValue::number(number, width, signed),
        }
    }

    /// A number with a fraction; noise is counted in its whole part. What is no number is a word.
    pub fn fraction(value: &Value) -> SuiteValue {
        match value {
            Value::Number(number) => {
                let text = number.to_string();
                let text = if text.contains('/') { format!("\"= {text}\"") } else { text };
                SuiteValue { text, number: number.round().as_whole() }
            }
            _ => SuiteValue::word("no-number"),
        }
    }

    pub fn octets(octets: &[u8]) -> SuiteValue {
        SuiteValue::word(format!("\"{}\"", hex(octets)))
    }
}

impl fmt::Display for SuiteValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// An action of the controller and its answer.
#[derive(Clone, Debug)]
pub struct AnsweredAction {
    pub ask: ControllerAction,
    /// When it began.
    pub at: Time,
    /// When it was answered.
    pub done: Time,
    /// The frame of the answer, or of the outputs.
    pub frame: u64,
    /// The parts of the answer by name.
    pub answer: Vec<(String, SuiteValue)>,
    /// The frames of those parts that are in an earlier frame.
    pub part_frames: BTreeMap<String, u64>,
}

impl AnsweredAction {
    /// An action whose answer is not known so far.
    pub fn new(ask: ControllerAction, (at, done): (Time, Time), frame: u64) -> AnsweredAction {
        AnsweredAction { ask, at, done, frame, answer: Vec::new(), part_frames: BTreeMap::new() }
    }

    /// Adds a part of the answer that is in this frame; later parts may follow in others.
    pub fn part(&mut self, name: impl Into<String>, value: SuiteValue, frame: u64) {
        let name = name.into();
        self.part_frames.insert(name.clone(), frame);
        self.answer.push((name, value));
    }

    /// The frame of a part of the answer.
    pub fn frame_of(&self, name: &str) -> u64 {
        self.part_frames.get(name).copied().unwrap_or(self.frame)
    }
}

/// A change of the value of a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrackChange {
    pub at: Time,
    pub frame: u64,
    /// The new value; `None` if it is unknown.
    pub value: Option<SuiteValue>,
}

/// The values of one name over time.
#[derive(Clone, Debug, Default)]
pub struct ValueTrack {
    /// The changes in order of time.
    pub changes: Vec<TrackChange>,
    /// Whether it is a measured number, which may pass all values between two.
    pub measured: bool,
    /// Whether it is a position of the shaft.
    pub is_place: bool,
    /// Its position in the frames that contain it.
    pub stands: Option<FramePosition>,
}

/// The position of a name in a cyclic frame: a big-endian number, and which of its bits are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FramePosition {
    /// The first byte of the number, from 0 at the first byte of the frame.
    pub octet: usize,
    /// The number of bytes.
    pub octets: usize,
    /// The lowest bit used, 0 is the least significant.
    pub low: u32,
    /// The number of bits used.
    pub width: u32,
    /// Whether the least significant byte comes first.
    pub little_endian: bool,
}

impl FramePosition {
    /// The byte and the bit of the highest bit in which two values differ; the bit only if the name is a single bit.
    pub fn differs(&self, one: Option<i128>, other: Option<i128>) -> (usize, Option<u8>) {
        let mask = (1_i128 << self.width.min(64)) - 1;
        let different = one.zip(other).map_or(mask, |(one, other)| (one ^ other) & mask);
        let highest = self.low + (i128::BITS - 1).saturating_sub(different.leading_zeros());
        let after = (highest / 8) as usize;
        let before = if self.little_endian { after } else { self.octets.saturating_sub(1).saturating_sub(after) };
        let octet = self.octet + before;
        (octet, (self.width == 1).then_some((highest % 8) as u8))
    }
}

impl ValueTrack {
    /// Adds a value; an unchanged one adds nothing.
    pub fn take(&mut self, at: Time, frame: u64, value: Option<SuiteValue>) {
        if self.changes.last().map(|last| &last.value) != Some(&value) {
            self.changes.push(TrackChange { at, frame, value });
        }
    }

    /// The change in force at an instant; `None` before the first.
    pub fn at(&self, time: Time) -> Option<&TrackChange> {
        let after = self.changes.partition_point(|change| change.at <= time);
        self.changes.get(after.checked_sub(1)?)
    }
}

/// An alarm or abort of the device.
#[derive(Clone, Debug)]
pub struct DeviceEvent {
    pub at: Time,
    pub frame: u64,
    /// Its fields, by the names of the suite language.
    pub said: Vec<(String, SuiteValue)>,
}

/// An action in a capture that cannot be repeated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkippedAction {
    pub frame: u64,
    /// What the controller did.
    pub what: String,
    /// From when on it may have changed the answers of the device; `None` if it changes nothing.
    pub since: Option<Time>,
    /// Until when; `None` for the rest of the capture.
    pub until: Option<Time>,
}

impl SkippedAction {
    /// Whether an answer at this time may depend on it.
    pub fn covers(&self, time: Time) -> bool {
        self.since.is_some_and(|since| since <= time) && self.until.is_none_or(|until| time < until)
    }
}

/// The cycle time of a connection that does not show one.
const USUAL_CYCLE: std::time::Duration = std::time::Duration::from_millis(2);

/// The conversation of a controller and a device.
#[derive(Clone, Debug, Default)]
pub struct Conversation {
    /// The actions of the controller.
    pub actions: Vec<AnsweredAction>,
    /// The values of the inputs over time, by name.
    pub tracks: BTreeMap<String, ValueTrack>,
    /// Alarms and aborts of the device.
    pub events: Vec<DeviceEvent>,
    /// Actions of the controller that cannot be repeated.
    pub left_out: Vec<SkippedAction>,
    /// The cycle time of the last connection.
    pub cycle: Option<std::time::Duration>,
    /// The time of the last frame.
    pub end: Time,
}

impl Conversation {
    /// The cycle time of the last connection, or a usual one if it had no cyclic data.
    pub fn cycle_or_usual(&self) -> std::time::Duration {
        self.cycle.unwrap_or(USUAL_CYCLE)
    }
}

/// The conversation in a capture, with the time of the first frame.
#[derive(Clone, Debug)]
pub struct RecordedConversation {
    pub conversation: Conversation,
    pub begin: Time,
}
