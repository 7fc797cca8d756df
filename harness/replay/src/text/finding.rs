//! A finding in full: what, where, when, against which clause, expected and observed values, cause, next step, what follows from it,
//! and the frames around it.

use super::options::{TextOptions, time_of_day};
use crate::finding::{CaptureFinding, ContextFrame, FindingContext};
use plain_text::count;
use std::fmt::{self, Write as _};

/// A gap of more than this many frames in the context of a finding is marked with dots.
const FAR: u64 = 1_000;
/// Upper limit of the consequences that are written in full.
const MOST_CONSEQUENCES: usize = 12;

pub(super) fn write_finding(out: &mut String, finding: &CaptureFinding, options: &TextOptions) -> fmt::Result {
    let word = format!("{:<7}", finding.severity.word().to_uppercase());
    write!(out, "  {} {}", options.severity(finding.severity, &word), options.paint("1", &finding.id))?;
    // A finding without a frame is about the capture as a whole.
    if finding.frame > 0 {
        write!(out, " in frame {}", finding.frame)?;
    }
    match (finding.octet, finding.bit) {
        (Some(octet), Some(bit)) => write!(out, ", byte {octet} bit {bit}")?,
        (Some(octet), None) => write!(out, ", byte {octet}")?,
        (None, _) => {}
    }
    if let Some(ar) = finding.ar {
        write!(out, ", connection {}", ar + 1)?;
    }
    writeln!(out, " (blame: {})", finding.blame.word())?;
    writeln!(out, "    {}{}", finding.text, times(finding))?;
    for detail in &finding.details {
        writeln!(out, "      {detail}")?;
    }
    for (word, value) in [
        ("when", &when(finding, options)),
        ("clause", &finding.clause),
        ("expected", &finding.expected),
        ("observed", &finding.seen),
        ("cause", &finding.cause),
        ("next", &finding.next),
        ("filter", &finding.filter),
    ] {
        if let Some(value) = value.as_ref().filter(|value| !value.is_empty()) {
            writeln!(out, "    {word:<9} {value}")?;
        }
    }
    for of in finding.consequences.iter().take(MOST_CONSEQUENCES) {
        writeln!(out, "    followed by {} in frame {}{}: {}", of.id, of.frame, later(finding, of), of.text)?;
        for detail in &of.details {
            writeln!(out, "      {detail}")?;
        }
    }
    if let Some(more) = finding.consequences.len().checked_sub(MOST_CONSEQUENCES).filter(|more| *more > 0) {
        writeln!(out, "    and {}", count(more, "further consequence", "further consequences"))?;
    }
    context(out, finding)
}

/// ` (3 times, last in frame 7)`, or nothing for once.
pub(super) fn times(finding: &CaptureFinding) -> String {
    match finding.count {
        0 | 1 => String::new(),
        often => format!(" ({often} times, last in frame {})", finding.last_frame),
    }
}

/// When a finding was captured: seconds, UTC and local time.
fn when(finding: &CaptureFinding, options: &TextOptions) -> Option<String> {
    let seconds = format!("{:.6} s", finding.time.filter(|_| finding.frame > 0)?);
    Some(match &finding.wall_clock {
        Some(wall_clock) => format!("{seconds}, {}", options.date(wall_clock)),
        None => seconds,
    })
}

/// How much later a consequence was captured.
fn later(cause: &CaptureFinding, of: &CaptureFinding) -> String {
    match (cause.time, of.time) {
        (Some(cause), Some(of)) if of > cause => format!(", {:.6} s later", of - cause),
        _ => String::new(),
    }
}

fn context(out: &mut String, finding: &CaptureFinding) -> fmt::Result {
    let FindingContext { before, at, after } = &finding.context;
    let mut last = None;
    for frame in before.iter().chain(at).chain(after) {
        let mark = if frame.frame == finding.frame { '>' } else { ' ' };
        if last.is_some_and(|last| frame.frame > last + FAR) {
            writeln!(out, "       ..")?;
        }
        last = Some(frame.frame);
        writeln!(out, "    {mark}{}", line(frame))?;
    }
    Ok(())
}

/// A frame with number, seconds, time of day in UTC, and its contents.
fn line(frame: &ContextFrame) -> String {
    let wall_clock = frame.wall_clock.as_deref().map_or_else(String::new, |time| format!(" {}", time_of_day(time)));
    let text = frame.text.replace('\n', "\n                            ");
    format!("{:>7} {:>14.6}{wall_clock}  {text}", frame.frame, frame.time)
}
