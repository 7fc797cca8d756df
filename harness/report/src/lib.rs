//! Reports: each reads a [`RunResult`] and gives text; none of them computes a verdict of its own.
//!
//! What a result weighs (green, neutral, red) is decided once, in `status`, so that console, JSON, JUnit, TAP and the exit
//! status agree. This room must not know suites, engines, files or terminals; a page gets its pictures from who calls.

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

/// The formats that `--report FORMAT=FILE` knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// What the terminal shows, without colours and with every case listed.
    Console,
    /// A page for a browser, in one file.
    Html,
    /// The contract for other tools.
    Json,
    /// For continuous integration.
    Junit,
    /// Test Anything Protocol, version 14.
    Tap,
    /// Requirement by requirement in the order of the manual, the same on every run.
    Text,
}

impl Format {
    /// Every format with its word on the command line.
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
