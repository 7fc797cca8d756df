//! The first lines of a report: the verdict, the times, what was not judged, and the findings in one line each.

use super::finding::times;
use super::options::TextOptions;
use super::{not_judged, sorted};
use crate::finding::FindingSeverity;
use crate::report::{CaptureReport, RecordingReport};
use plain_text::count;
use std::fmt::{self, Write as _};

/// Upper limit of the lines, the verdict included.
const MOST_LINES: usize = 12;
/// Upper limit of the characters of a finding in one line.
const MOST_CHARACTERS: usize = 120;
/// Upper limit of the recordings whose times are written.
const MOST_RECORDINGS: usize = 3;

pub(super) fn write_summary(out: &mut String, capture: &CaptureReport, options: &TextOptions) -> fmt::Result {
    let mut counts = vec![
        count(capture.frames as usize, "frame", "frames"),
        count(capture.ars.len(), "connection", "connections"),
        findings(capture, options),
    ];
    if !capture.damage.is_empty() {
        counts.push(count(capture.damage.len(), "damage", "damages"));
    }
    writeln!(out, "{}: {}", capture.file.escape_debug(), counts.join(", "))?;
    let mut lines: Vec<String> = not_judged(capture).into_iter().map(|line| format!("not judged: {line}")).collect();
    lines.extend(recordings(capture, options));
    if let Some(damage) = capture.damage.first() {
        lines.push(format!("damaged at byte {}: {}", damage.at, damage.what));
    }
    if capture.hidden_findings > 0 {
        let hidden = count(capture.hidden_findings as usize, "finding is", "findings are");
        lines.push(format!("{hidden} not shown: another severity, station or time"));
    }
    let found = if capture.findings.len() > 1 { one_line_each(capture, options) } else { Vec::new() };
    let room = (MOST_LINES - 1).saturating_sub(lines.len());
    let fits = if found.len() > room { room.saturating_sub(1) } else { found.len() };
    let left_out = found.len() - fits;
    lines.extend(found.into_iter().take(fits));
    if left_out > 0 {
        lines.push(format!("and {} below", count(left_out, "more finding", "more findings")));
    }
    lines.iter().take(MOST_LINES - 1).try_for_each(|line| writeln!(out, "  {line}"))
}

/// The number of findings, in all and by severity.
fn findings(capture: &CaptureReport, options: &TextOptions) -> String {
    let of = |severity: FindingSeverity| capture.findings.iter().filter(|finding| finding.severity == severity).count();
    let each: Vec<String> = [FindingSeverity::Error, FindingSeverity::Warning, FindingSeverity::Info]
        .into_iter()
        .filter(|severity| of(*severity) > 0)
        .map(|severity| options.severity(severity, &format!("{} {}", of(severity), severity.word())))
        .collect();
    match capture.findings.len() {
        0 if capture.hidden_findings > 0 => "no findings shown".to_owned(),
        0 if !capture.judged.is_empty() => "no findings in what was judged".to_owned(),
        0 => "no findings".to_owned(),
        all => format!("{} ({})", count(all, "finding", "findings"), each.join(", ")),
    }
}

/// When the recordings were made. Where there are several, their distance means nothing.
fn recordings(capture: &CaptureReport, options: &TextOptions) -> Vec<String> {
    let several = capture.recordings.len();
    let one = |of: &RecordingReport| {
        let from = options.date(of.from.as_ref()?);
        let to = of.to.as_deref().map_or("", super::options::time_of_day);
        Some(format!("recorded from {from} to {to} UTC, {:.6} s", of.seconds))
    };
    let mut lines: Vec<String> = capture.recordings.iter().filter_map(one).take(MOST_RECORDINGS).collect();
    if several > 1 {
        if several > MOST_RECORDINGS {
            lines.truncate(MOST_RECORDINGS - 1);
        }
        lines.push(format!(
            "{several} recordings of different times: seconds count from the first frame of each, and nothing is measured between them"
        ));
    }
    lines
}

fn one_line_each(capture: &CaptureReport, options: &TextOptions) -> Vec<String> {
    let each = sorted(capture).into_iter().map(|finding| {
        let word = format!("{:<7}", finding.severity.word().to_uppercase());
        let time = finding.time.map_or_else(String::new, |time| format!(", {time:.6} s"));
        let mut text = format!("{} frame {}{time}: {}{}", finding.id, finding.frame, finding.text, times(finding));
        if text.chars().count() > MOST_CHARACTERS {
            text = text.chars().take(MOST_CHARACTERS - 3).collect::<String>() + "...";
        }
        let mut line = options.severity(finding.severity, &word);
        // Writing into a String cannot fail.
        let _ = write!(line, " {text}");
        line
    });
    each.collect()
}
