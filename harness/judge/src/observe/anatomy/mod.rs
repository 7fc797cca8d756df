//! Splits a frame into named parts, for the view of a single packet.
//!
//! Every byte belongs to exactly one part; unreadable bytes are one part with the error. The data of a submodule are one part; the
//! caller splits it into signals.

mod profibus;
mod profinet;

use super::ObservedAr;
use std::ops::Range;
use virtual_wire::capture::LinkType;

/// A part of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FramePart {
    /// Byte range in the captured frame.
    pub octets: Range<usize>,
    pub name: String,
    /// The value as text; empty if the bytes are sufficient.
    pub value: String,
}

/// The parts of a frame in order; `ars` are the known connections.
pub fn anatomy(link: LinkType, octets: &[u8], ars: &[ObservedAr]) -> Vec<FramePart> {
    let mut parts = Parts { octets, at: 0, list: Vec::new() };
    match link {
        LinkType::ETHERNET => profinet::frame(&mut parts, ars),
        LinkType::PROFIBUS => profibus::frame(&mut parts),
        LinkType(_) => {}
    }
    parts.rest("bytes");
    parts.list
}

/// The parts so far, and the start of the next one.
struct Parts<'a> {
    octets: &'a [u8],
    at: usize,
    list: Vec<FramePart>,
}

impl<'a> Parts<'a> {
    /// Adds a part of the next `length` bytes, or of the remaining bytes.
    fn take(&mut self, length: usize, name: impl Into<String>, value: impl FnOnce(&[u8]) -> String) {
        let end = self.at.saturating_add(length).min(self.octets.len());
        let Some(octets) = self.octets.get(self.at..end).filter(|octets| !octets.is_empty()) else { return };
        let cut = if octets.len() < length { " (cut off)" } else { "" };
        let value = if cut.is_empty() { value(octets) } else { String::new() };
        self.list.push(FramePart { octets: self.at..end, name: format!("{}{cut}", name.into()), value });
        self.at = end;
    }

    /// Adds a part without a value.
    fn plain(&mut self, length: usize, name: impl Into<String>) {
        self.take(length, name, |_| String::new());
    }

    /// Adds a big-endian number.
    fn number(&mut self, length: usize, name: impl Into<String>, word: impl FnOnce(u64) -> Option<String>) {
        self.take(length, name, |octets| {
            let number = octets.iter().fold(0u64, |sum, octet| sum << 8 | u64::from(*octet));
            word(number).unwrap_or_else(|| format!("{number}"))
        });
    }

    /// Adds a part up to the offset `end` in the frame.
    fn until(&mut self, end: usize, name: impl Into<String>) {
        self.plain(end.saturating_sub(self.at), name);
    }

    /// Adds a part of all remaining bytes.
    fn rest(&mut self, name: impl Into<String>) {
        self.until(self.octets.len(), name);
    }

    /// The remaining bytes.
    fn left(&self) -> &'a [u8] {
        self.octets.get(self.at..).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests;
