//! Reports: each format turns a [`RunResult`] into text; none of them computes a verdict.
//!
//! Whether a result is green, neutral or red is decided once, in `status`, so that all formats and the exit status agree. This module must not know suites, engines, files or terminals; the caller supplies the packets and timelines of a page.

#![allow(missing_docs, reason = "an internal crate; names that say everything have no sentence")]

mod console;
pub mod diff;
mod github;
mod handover;
mod html;
mod json;
mod junit;
mod markdown;
pub mod page;
mod read;
mod sarif;
mod status;
mod tap;
mod text;
mod words;
mod xml;

pub use console::{ConsoleOptions, console, failed_case};
pub use github::github;
pub use html::{CaseEvidence, html};
pub use json::json;
pub use junit::junit;
pub use markdown::markdown;
pub use read::{ReadError, read};
pub use sarif::{RemarkLevel, SuiteRemark, sarif};
pub use status::{ExitStatus, ResultColour, reasons, result_colour, status};
pub use tap::tap;
pub use text::text;
pub use words::{finding, level, reproduce};

use results::outcome::RunResult;

/// The formats of `--report FORMAT=FILE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportFormat {
    /// The text for the terminal, without colours and with every case listed.
    Console,
    /// Workflow commands of GitHub Actions, which become annotations.
    Github,
    /// A page for a browser, in one file.
    Html,
    /// The contract with other tools.
    Json,
    /// JUnit XML for continuous integration.
    Junit,
    /// Markdown, for the summary of a CI job.
    Markdown,
    /// Test Anything Protocol, version 14.
    Tap,
    /// Requirement by requirement in the order of the manual, the same on every run.
    Text,
}

impl ReportFormat {
    /// Every format with its name on the command line.
    pub const ALL: [(&'static str, ReportFormat); 8] = [
        ("console", ReportFormat::Console),
        ("github", ReportFormat::Github),
        ("html", ReportFormat::Html),
        ("json", ReportFormat::Json),
        ("junit", ReportFormat::Junit),
        ("markdown", ReportFormat::Markdown),
        ("tap", ReportFormat::Tap),
        ("text", ReportFormat::Text),
    ];

    /// The report of `result` in this format, ending in a line feed.
    pub fn write(self, result: &RunResult) -> String {
        match self {
            ReportFormat::Console => console(result, ConsoleOptions { colour: false, verbose: true, quiet: false }),
            ReportFormat::Github => github(result),
            ReportFormat::Html => html(result, &|_| CaseEvidence::default()),
            ReportFormat::Json => json(result),
            ReportFormat::Junit => junit(result),
            ReportFormat::Markdown => markdown(result),
            ReportFormat::Tap => tap(result),
            ReportFormat::Text => text(result),
        }
    }
}
