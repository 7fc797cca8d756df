//! The parts of a frame octet by octet, for people who look at one packet.
//!
//! Every octet belongs to exactly one part; what cannot be read is one part that says so. Like the rest of [`observe`](super)
//! this room must not know devices: the data of a submodule are one part, and who knows its signals cuts it further.

mod profibus;
mod profinet;

use super::Ar;
use std::ops::Range;
use virtual_wire::capture::LinkType;

/// A part of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its octets, counted from the start of the frame as captured.
    pub octets: Range<usize>,
    /// What it is.
    pub name: String,
    /// What it says, in words or numbers; empty where its octets say all there is.
    pub value: String,
}

/// The parts of a frame of this link, in the order in which they stand in it; `ars` are the connections that were seen.
pub fn anatomy(link: LinkType, octets: &[u8], ars: &[Ar]) -> Vec<Part> {
    let mut parts = Parts { octets, at: 0, list: Vec::new() };
    match link {
        LinkType::ETHERNET => profinet::frame(&mut parts, ars),
        LinkType::PROFIBUS => profibus::frame(&mut parts),
        LinkType(_) => {}
    }
    parts.rest("octets");
    parts.list
}

/// The parts so far, and where the next one begins.
struct Parts<'a> {
    octets: &'a [u8],
    at: usize,
    list: Vec<Part>,
}

impl<'a> Parts<'a> {
    /// The next `length` octets, or what is left of them.
    fn take(&mut self, length: usize, name: impl Into<String>, value: impl FnOnce(&[u8]) -> String) {
        let end = self.at.saturating_add(length).min(self.octets.len());
        let Some(octets) = self.octets.get(self.at..end).filter(|octets| !octets.is_empty()) else { return };
        let cut = if octets.len() < length { " (cut off)" } else { "" };
        let value = if cut.is_empty() { value(octets) } else { String::new() };
        self.list.push(Part { octets: self.at..end, name: format!("{}{cut}", name.into()), value });
        self.at = end;
    }

    /// Octets that say all there is by themselves.
    fn plain(&mut self, length: usize, name: impl Into<String>) {
        self.take(length, name, |_| String::new());
    }

    /// A number, the highest octet first.
    fn number(&mut self, length: usize, name: impl Into<String>, word: impl FnOnce(u64) -> Option<String>) {
        self.take(length, name, |octets| {
            let number = octets.iter().fold(0u64, |sum, octet| sum << 8 | u64::from(*octet));
            word(number).unwrap_or_else(|| format!("{number}"))
        });
    }

    /// Everything up to `end`, counted from the start of the frame.
    fn until(&mut self, end: usize, name: impl Into<String>) {
        self.plain(end.saturating_sub(self.at), name);
    }

    /// Everything that is left.
    fn rest(&mut self, name: impl Into<String>) {
        self.until(self.octets.len(), name);
    }

    /// The octets that no part has yet.
    fn left(&self) -> &'a [u8] {
        self.octets.get(self.at..).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests;
