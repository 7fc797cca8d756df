//! The names of cyclic data: the bits of a signal that belong to each, and how their values are written.

use crate::conversation::{FramePosition, SuiteValue};
use judge::image::ConnectionImage;
use judge::observe::FrameDirection;
use suite::device::{DeviceDescription, SignalForm, SignalSender, text_of};

/// A name of cyclic data.
#[derive(Clone, Debug)]
pub(super) struct CyclicName {
    /// The name in suites.
    pub path: String,
    signal: usize,
    low: u32,
    width: u32,
    signed: bool,
    form: SignalForm,
    words: Vec<(String, i128)>,
    /// The first and the last number, if it counts by itself.
    pub counts: Option<(i128, i128)>,
    /// Whether it is a measured number.
    pub measured: bool,
    /// Whether it is a position.
    pub is_place: bool,
}

impl CyclicName {
    /// Its present value, if it has one.
    pub fn present(&self, image: &ConnectionImage) -> Option<SuiteValue> {
        match self.form {
            SignalForm::Text => Some(SuiteValue::word(format!("\"{}\"", text_of(image.signal_octets(self.signal)?)))),
            SignalForm::Whole | SignalForm::Scaled { .. } | SignalForm::Float => {
                self.number(image).map(|number| self.value(number))
            }
        }
    }

    /// Its present number on the wire, if it has one.
    pub fn number(&self, image: &ConnectionImage) -> Option<i128> {
        let raw = image.signal(self.signal).filter(|_| self.form != SignalForm::Text)?;
        let bits = u128::from(raw) >> self.low & ((1_u128 << self.width) - 1);
        let number = i128::try_from(bits).ok()?;
        let negative = self.signed && number >> (self.width - 1) != 0;
        Some(if negative { number - (1_i128 << self.width) } else { number })
    }

    /// Its position in the frame that contains it.
    pub fn stands(&self, image: &ConnectionImage) -> Option<FramePosition> {
        let (_, octet) = image.place_of(self.signal)?;
        let (_, octets) = image.octets_of_signal(self.signal)?;
        let little_endian = image.is_little_endian(self.signal);
        Some(FramePosition { octet, octets: octets.len(), low: self.low, width: self.width, little_endian })
    }

    /// A number on the wire as a value.
    pub fn value(&self, number: i128) -> SuiteValue {
        if self.form != SignalForm::Whole {
            return SuiteValue::fraction(&self.form.value(number, self.width));
        }
        SuiteValue::of_table(number, self.width, self.signed, &self.words)
    }

    /// The number after this one, if it counts by itself.
    pub fn next(&self, number: i128) -> Option<i128> {
        let (first, last) = self.counts?;
        Some(if number >= last { first } else { number + 1 })
    }
}

/// The names of all signals that a side sends: the fields of a signal if it has some, else the signal as a whole.
///
/// Bits of a signal that belong to no field have no name and are ignored.
pub(super) fn parts(device: &DeviceDescription, variant: usize, from: SignalSender) -> Vec<CyclicName> {
    let mut parts = Vec::new();
    for (index, signal) in device.signals.iter().enumerate().filter(|(_, signal)| signal.from == from) {
        if signal.fields.is_empty() {
            let shift = signal.shift.get(variant).copied().unwrap_or_default();
            parts.push(CyclicName {
                path: signal.name.clone(),
                signal: index,
                low: shift,
                width: signal.width - shift,
                signed: signal.signed,
                form: signal.form,
                words: Vec::new(),
                counts: None,
                measured: signal.width >= 16,
                is_place: signal.position_in.is_some(),
            });
        }
        for field in &signal.fields {
            parts.push(CyclicName {
                path: format!("{}.{}", signal.name, field.name),
                signal: index,
                low: field.low,
                width: field.width,
                signed: field.signed,
                form: SignalForm::Whole,
                words: field.words.clone(),
                counts: field.counts.map(|(first, last)| (first.into(), last.into())),
                measured: field.words.is_empty() && field.width >= 8,
                is_place: false,
            });
        }
    }
    parts
}

/// The names that the present connection contains.
pub(super) fn carried<'p>(
    parts: &'p [CyclicName],
    image: &'p ConnectionImage,
    direction: FrameDirection,
) -> impl Iterator<Item = (usize, &'p CyclicName)> {
    parts.iter().enumerate().filter(move |(_, part)| image.direction(part.signal) == Some(direction))
}
