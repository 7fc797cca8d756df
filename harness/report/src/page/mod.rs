//! Pages for a browser: one self-contained file that fetches nothing, with every text escaped.
//!
//! A page is data first: headings, facts, tables, timelines and entries that open on a click. This module renders it and must not
//! know captures, runs, files or verdicts. Without scripts everything is readable, unless the page is so long that it is packed;
//! the script zooms timelines and opens the entry that a link names.

mod html;
mod timeline;

pub use html::html;
pub use timeline::{Lane, LanePhase, LaneShape, Mark, Timeline, ValueSpan};

use judge::observe::FramePart;

/// How good or bad something is; each tone has a colour and a word, so that no meaning depends on colour alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// Correct.
    Good,
    /// Wrong.
    Bad,
    /// To be checked, or undecided.
    Open,
    /// Neither.
    #[default]
    Plain,
}

/// A page.
#[derive(Clone, Debug, Default)]
pub struct HtmlPage {
    pub title: String,
    /// The result in one sentence.
    pub verdict: (Tone, String),
    pub chapters: Vec<Chapter>,
    /// Data for programs, each with its id.
    pub data: Vec<(&'static str, serde_json::Value)>,
}

/// A chapter of a page.
#[derive(Clone, Debug, Default)]
pub struct Chapter {
    pub heading: String,
    /// Pairs of name and value.
    pub facts: Vec<(String, String)>,
    pub timelines: Vec<Timeline>,
    /// Parts that the reader opens one by one.
    pub entries: Vec<PageEntry>,
    pub tables: Vec<PageTable>,
}

/// A part of a page that the reader opens.
#[derive(Clone, Debug, Default)]
pub struct PageEntry {
    /// The target of links, unique on the page: letters, digits, `-`.
    pub anchor: String,
    pub tone: Tone,
    /// The word of the tone: `fail`, `error`, `inconclusive`.
    pub word: String,
    /// The headline.
    pub head: String,
    /// Pairs of name and value; a value may have several lines.
    pub facts: Vec<(String, String)>,
    /// The packet that shows it.
    pub packet: Option<PagePacket>,
    pub timelines: Vec<Timeline>,
}

/// A packet, byte by byte.
#[derive(Clone, Debug, Default)]
pub struct PagePacket {
    /// The headline: packet number and time.
    pub head: String,
    pub octets: Vec<u8>,
    /// The fields, in the order of the bytes.
    pub parts: Vec<FramePart>,
    /// The byte to mark, counted from 0, and the bit in it, 0 being the lowest.
    pub mark: Option<(usize, Option<u8>)>,
}

/// A table of a page.
#[derive(Clone, Debug, Default)]
pub struct PageTable {
    pub heading: String,
    pub columns: Vec<String>,
    /// The rows, each as long as `columns`.
    pub rows: Vec<(Tone, Vec<String>)>,
}

#[cfg(test)]
mod tests;
