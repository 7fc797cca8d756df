//! A reading that shows the variant of a device: a text or a number, and which variants it fits.

use results::outcome::DescriptionKind;
use suite::device::{DeviceDescription, VariantValue};

/// Who reports a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadingSource {
    /// The device.
    Device,
    /// A file that a person gave.
    Description(DescriptionKind),
}

/// Something that differs between the variants of a manual, as read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VariantReading {
    /// What was read, in words.
    pub what: String,
    /// The value as read, escaped.
    pub value: String,
    pub source: ReadingSource,
    /// What it is in each variant, in words.
    pub expected: Vec<String>,
    /// Which variants it fits.
    pub fits: Vec<bool>,
}

impl VariantReading {
    /// A text of a device or a description, by the words of each variant; `None` if it says nothing.
    pub(crate) fn of_text(
        device: &DeviceDescription,
        what: String,
        texts: &[&str],
        source: ReadingSource,
    ) -> Option<VariantReading> {
        let fits = called_in(device, texts);
        let value = texts.iter().filter(|text| !text.is_empty()).map(|text| quoted(text)).collect::<Vec<_>>();
        let expected = device.variant_identification.called.iter().map(|words| words.join(" or ")).collect();
        let reading = VariantReading { what, value: value.join(", "), source, expected, fits };
        reading.decides().then_some(reading)
    }

    /// A number that the device reported; `None` if it says nothing.
    pub fn of_number(value: &VariantValue, number: i128) -> Option<VariantReading> {
        let reading = VariantReading {
            what: value.name.clone(),
            value: number.to_string(),
            source: ReadingSource::Device,
            expected: value.expected.iter().map(ToString::to_string).collect(),
            fits: value.expected.iter().map(|of| of.allows(number)).collect(),
        };
        reading.decides().then_some(reading)
    }

    /// Whether it fits some variants and excludes others.
    pub(crate) fn decides(&self) -> bool {
        self.fits.contains(&true) && self.fits.contains(&false)
    }

    /// Whether the device itself reports it.
    pub fn speaks_of_device(&self) -> bool {
        self.source == ReadingSource::Device
    }

    /// Whether it fits a variant.
    pub(crate) fn fits(&self, variant: usize) -> bool {
        self.fits.get(variant).copied().unwrap_or(true)
    }
}

/// Whether these texts contain a word of each variant; punctuation, spaces and case do not count.
pub(crate) fn called_in(device: &DeviceDescription, texts: &[&str]) -> Vec<bool> {
    let plain = |text: &str| text.chars().filter(|of| of.is_alphanumeric()).collect::<String>().to_lowercase();
    let texts: Vec<String> = texts.iter().map(|text| plain(text)).collect();
    let is_in = |word: &String| texts.iter().any(|text| text.contains(&plain(word)));
    device.variant_identification.called.iter().map(|words| words.iter().any(is_in)).collect()
}

/// A text of a device or a file, cut and escaped.
fn quoted(text: &str) -> String {
    let short: String = text.trim_end().chars().take(60).collect();
    format!("`{}`", short.escape_debug())
}
