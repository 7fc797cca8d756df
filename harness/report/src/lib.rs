//! Reports: each format turns a [`RunResult`] into text; none of them computes a verdict.
//!
//! Whether a result is green, neutral or red is decided once, in `status`, so that console, JSON, JUnit, TAP and the exit status
//! agree. This module must not know suites, engines, files or terminals; the caller supplies the packets and timelines of a page.

#![allow(missing_docs, reason = "an internal crate; names that say everything have no sentence")]

mod console;
mod html;
mod json;
mod junit;
pub mod page;
mod status;
mod tap;
mod text;
mod words;
mod xml;

pub use console::{Look, console, one};
pub use html::{Pictures, html};
pub use json::json;
pub use junit::junit;
pub use status::{ExitStatus, Light, light, reasons, status};
pub use tap::tap;
pub use text::text;
pub use words::{finding, level, reproduce};

use results::outcome::RunResult;

/// The formats of `--report FORMAT=FILE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// The text for the terminal, without colours and with every case listed.
    Console,
    /// A page for a browser, in one file.
    Html,
    /// The contract with other tools.
    Json,
    /// JUnit XML for continuous integration.
    Junit,
    /// Test Anything Protocol, version 14.
    Tap,
    /// Requirement by requirement in the order of the manual, the same on every run.
    Text,
}

impl Format {
    /// Every format with its name on the command line.
    pub const ALL: [(&'static str, Format); 6] = [
        ("console", Format::Console),
        ("html", Format::Html),
        ("json", Format::Json),
        ("junit", Format::Junit),
        ("tap", Format::Tap),
        ("text", Format::Text),
    ];

    /// The report of `result` in this format, ending in a line feed.
    pub fn write(self, result: &RunResult) -> String {
        match self {
            Format::Console => console(result, Look { colour: false, verbose: true }),
            Format::Html => html(result, &|_| Pictures::default()),
            Format::Json => json(result),
            Format::Junit => junit(result),
            Format::Tap => tap(result),
            Format::Text => text(result),
        }
    }
}
