//! Pages that people open in a browser: one self-contained file, nothing fetched, every text escaped.
//!
//! A page is data first: headings, facts, tables, timelines and entries that open on a click. The renderer knows what a page
//! looks like; it must not know captures, runs, files or verdicts. Without scripts everything can still be read; the script
//! of the page only zooms timelines and opens the entry that a link names.

mod html;
mod timeline;

pub use html::html;
pub use timeline::{Lane, Mark, Phase, Shape, Span, Timeline};

use judge::observe::Part;

/// How something is to be taken; each tone has a colour and a word of its own, so that no meaning hangs on colour alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// As it should be.
    Good,
    /// Wrong.
    Bad,
    /// Worth a look, or not to be decided.
    Open,
    /// Neither.
    #[default]
    Plain,
}

/// A page.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// What it is about.
    pub title: String,
    /// How it came out, in one sentence.
    pub verdict: (Tone, String),
    /// Its chapters.
    pub chapters: Vec<Chapter>,
}

/// A chapter of a page.
#[derive(Clone, Debug, Default)]
pub struct Chapter {
    /// What it is about.
    pub heading: String,
    /// What is known, as pairs of name and value.
    pub facts: Vec<(String, String)>,
    /// What went on over time.
    pub timelines: Vec<Timeline>,
    /// What a reader opens one by one.
    pub entries: Vec<Entry>,
    /// Lists of one line each.
    pub tables: Vec<Table>,
}

/// Something that a reader opens to see more.
#[derive(Clone, Debug, Default)]
pub struct Entry {
    /// The name by which links find it, unique on the page: letters, digits, `-`.
    pub anchor: String,
    /// How it is to be taken.
    pub tone: Tone,
    /// The word of the tone: `fail`, `error`, `inconclusive`.
    pub word: String,
    /// What it is, on one line.
    pub head: String,
    /// What else there is to say, as pairs of name and value; a value may have several lines.
    pub facts: Vec<(String, String)>,
    /// The packet that shows it.
    pub packet: Option<Packet>,
    /// What went on around it.
    pub timelines: Vec<Timeline>,
}

/// A packet, octet by octet.
#[derive(Clone, Debug, Default)]
pub struct Packet {
    /// What it is: its number and its time.
    pub head: String,
    /// Its octets.
    pub octets: Vec<u8>,
    /// What they are, in the order in which they stand.
    pub parts: Vec<Part>,
    /// The octet that matters, counted from 0, and the bit in it, 0 being the lowest.
    pub mark: Option<(usize, Option<u8>)>,
}

/// A list of one line each.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// What it lists.
    pub heading: String,
    /// What its columns hold.
    pub columns: Vec<String>,
    /// Its lines, each as long as `columns`.
    pub rows: Vec<(Tone, Vec<String>)>,
}

#[cfg(test)]
mod tests;
