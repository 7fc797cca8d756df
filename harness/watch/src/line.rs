//! Findings and events of the watch as lines: JSON for programs, one sentence for people.

use crate::counts::severity;
use plain_text::printable;
use replay::utc;
use replay::{ConnectionReport, LiveFinding};
use serde::Serialize;
use station::Time;

/// A line of the log of findings. Its JSON form is a contract: keys may be added, none is renamed or removed.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum WatchLine {
    /// Something is wrong.
    Finding(Box<FindingLine>),
    /// The watch began.
    Started {
        wall_clock: String,
        source: String,
        version: &'static str,
        warnings: Vec<String>,
        time_stamps: &'static str,
    },
    /// Frames were lost before they could be judged or kept; whatever happened in them is not known.
    Lost { wall_clock: String, blame: &'static str, by: &'static str, frames: u64 },
    /// An incident was saved.
    Incident { wall_clock: String, file: String, from: String, until: String, frames: u64, is_complete: bool },
    /// The source ended or came back, a file cannot be written, and the like.
    Note { wall_clock: String, text: String },
    /// The watch ended.
    Ended { wall_clock: String, frames: u64, findings: u64 },
}

/// A finding in the log.
#[derive(Clone, Debug, Serialize)]
pub struct FindingLine {
    /// When its frame was received, in UTC.
    pub wall_clock: String,
    /// Seconds since the first frame of the watch.
    pub time: f64,
    pub severity: &'static str,
    pub text: String,
    /// The capture that is saved of it; it is complete 10 s after the finding.
    pub incident: Option<String>,
    pub connection: Option<ConnectionReport>,
    /// The finding with the keys that it has in the report of a capture; its frame counts from the begin of the watch.
    pub finding: replay::CaptureFinding,
}

impl WatchLine {
    /// The line of a finding; `first` is the time of the first frame of the watch.
    pub fn finding(found: &LiveFinding, first: Time, incident: Option<String>) -> WatchLine {
        WatchLine::Finding(Box::new(FindingLine {
            wall_clock: utc(found.time),
            time: found.time.since(first).as_secs_f64(),
            severity: severity(found.finding.severity),
            text: printable(&found.finding.text).to_string(),
            incident,
            connection: found.connection.clone(),
            finding: found.finding.clone(),
        }))
    }
}

/// The line as JSON, with its line feed.
pub fn json_line(line: &WatchLine) -> String {
    let mut text = serde_json::to_string(line).unwrap_or_default();
    text.push('\n');
    text
}

/// The line as a sentence for people, without line feed.
pub fn text_line(line: &WatchLine) -> String {
    match line {
        WatchLine::Finding(line) => format!(
            "{} {} {} (blame: {}): {}",
            line.wall_clock,
            line.severity,
            line.finding.id,
            line.finding.blame.word(),
            line.text
        ),
        WatchLine::Started { wall_clock, source, .. } => format!("{wall_clock} watching {source}"),
        WatchLine::Lost { wall_clock, by, frames, .. } => {
            format!("{wall_clock} {frames} frames were lost by the {by}: what happened in them is not known")
        }
        WatchLine::Incident { wall_clock, file, frames, is_complete, .. } => {
            let cut = if *is_complete { "" } else { "; the ring did not hold all of it" };
            format!("{wall_clock} saved {file}: {frames} frames{cut}")
        }
        WatchLine::Note { wall_clock, text } => format!("{wall_clock} {text}"),
        WatchLine::Ended { wall_clock, frames, findings } => {
            format!("{wall_clock} ended after {frames} frames with {findings} findings")
        }
    }
}
