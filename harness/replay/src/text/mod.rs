//! The report for the console: the summary, the findings, the connections, the rules, and the events.

mod finding;
mod options;
mod summary;

pub use options::TextOptions;

use super::finding::CaptureFinding;
use super::report::{CaptureReport, ConnectionReport, ReplayReport, StreamReport};
use options::time_of_day;
use plain_text::count;
use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

/// Upper limit of the senders without a Connect that are named.
const MOST_SENDERS: usize = 4;

/// Writes the report without colours and with times in UTC; texts of stations are escaped already.
pub fn text(report: &ReplayReport) -> String {
    text_with(report, &TextOptions::default())
}

/// Writes the report; texts of stations are escaped already.
pub fn text_with(report: &ReplayReport, options: &TextOptions) -> String {
    let mut out = String::new();
    for (index, capture) in report.captures.iter().enumerate() {
        if index > 0 {
            out.push('\n');
        }
        // Writing into a String cannot fail.
        let _ = one(&mut out, capture, options);
        if let Some(against) = &capture.against {
            let _ = write!(out, "{against}");
        }
    }
    out
}

fn one(out: &mut String, capture: &CaptureReport, options: &TextOptions) -> fmt::Result {
    summary::write_summary(out, capture, options)?;
    for finding in sorted(capture) {
        out.push('\n');
        finding::write_finding(out, finding, options)?;
    }
    if !capture.ars.is_empty() {
        out.push('\n');
    }
    connections(out, capture, options)?;
    rules(out, capture)?;
    if !capture.events.is_empty() {
        writeln!(out, "\n  events (frame, seconds, time in UTC)")?;
    }
    for event in &capture.events {
        let wall_clock = event.wall_clock.as_deref().map_or_else(String::new, |time| format!(" {}", time_of_day(time)));
        let kind = event.kind.word();
        writeln!(out, "  {:>7} {:>14.6}{wall_clock}  {kind:<18} {}", event.frame, event.time, event.text)?;
    }
    if !capture.damage.is_empty() {
        writeln!(out, "\n  damage of the file")?;
    }
    for damage in &capture.damage {
        writeln!(out, "  damaged at byte {}: {}", damage.at, damage.what)?;
        writeln!(out, "    {}", damage.meaning)?;
    }
    Ok(())
}

/// The findings, the most severe first.
fn sorted(capture: &CaptureReport) -> Vec<&CaptureFinding> {
    let mut sorted: Vec<&CaptureFinding> = capture.findings.iter().collect();
    sorted.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    sorted
}

/// What of the cyclic frames was not judged, a sentence for each reason.
pub(crate) fn not_judged(capture: &CaptureReport) -> Vec<String> {
    let line = |judged: &str, what: &str| {
        let of: Vec<u64> = capture.judged.iter().filter(|of| of.judged == judged).map(|of| of.frames).collect();
        let frames = count(of.iter().sum::<u64>() as usize, "frame", "frames");
        (!of.is_empty()).then(|| format!("{}, {frames}: {what}", count(of.len(), "stream", "streams")))
    };
    let lines = [
        line("status", "no layout, contents not judged; the Connect is not in the capture"),
        line("nothing", "no layout and no place of the status, nothing judged"),
    ];
    let named = capture.judged.iter().filter_map(|of| Some(format!("{} ({})", of.source, of.sender.as_ref()?)));
    let mut named: Vec<String> = named.collect();
    named.dedup();
    let mut lines: Vec<String> = lines.into_iter().flatten().collect();
    if !named.is_empty() {
        let more = named.len().saturating_sub(MOST_SENDERS);
        named.truncate(MOST_SENDERS);
        let more = if more > 0 { format!("; and {more} more") } else { String::new() };
        if let Some(last) = lines.last_mut() {
            *last += &format!("; senders: {}{more}", named.join("; "));
        }
    }
    lines
}

/// A line for each connection; refused ones of the same pair are combined.
fn connections(out: &mut String, capture: &CaptureReport, options: &TextOptions) -> fmt::Result {
    let mut refused: BTreeMap<(String, String), Vec<u64>> = BTreeMap::new();
    for (index, ar) in capture.ars.iter().enumerate().filter(|(_, ar)| options.filter.shows_connection(ar)) {
        if ar.stage == "refused" {
            let frame = ar.connect_frame.unwrap_or_default();
            refused.entry((controller(ar), device(ar))).or_default().push(frame);
        } else {
            connection(out, index + 1, ar)?;
        }
    }
    for ((controller, device), frames) in refused {
        let (first, last) = (frames.first().copied().unwrap_or_default(), frames.last().copied().unwrap_or_default());
        let times = count(frames.len(), "time", "times");
        let span = if first == last { format!("frame {first}") } else { format!("frames {first} to {last}") };
        writeln!(out, "  refused {times}: {controller} -> {device}; {span}")?;
    }
    Ok(())
}

/// The rules, grouped by verdict and reason.
fn rules(out: &mut String, capture: &CaptureReport) -> fmt::Result {
    if capture.rules.is_empty() {
        return writeln!(out, "\n  no rule was judged: no suite matches a connection of this capture");
    }
    writeln!(out, "\n  rules")?;
    let mut alike: Vec<(&str, Option<&str>, Vec<String>)> = Vec::new();
    for rule in &capture.rules {
        let name = match rule.undecided {
            0 => format!("{} ({})", rule.id, rule.premises),
            undecided => format!("{} ({}, {undecided} undecided)", rule.id, rule.premises),
        };
        let reason = rule.reason.as_deref();
        match alike.iter_mut().find(|(verdict, why, _)| (*verdict, *why) == (rule.verdict, reason)) {
            Some((.., names)) => names.push(name),
            None => alike.push((rule.verdict, reason, vec![name])),
        }
    }
    // Open verdicts come before passed ones.
    alike.sort_by_key(|(verdict, ..)| {
        ["fail", "error", "inconclusive", "not-run"].iter().position(|of| of == verdict).unwrap_or(9)
    });
    for (verdict, reason, names) in alike {
        match reason {
            Some(reason) => writeln!(out, "  {verdict:<13} {reason}:")?,
            None => writeln!(out, "  {verdict}")?,
        }
        for name in names {
            writeln!(out, "    {name}")?;
        }
    }
    for rule in &capture.rules {
        if let Some(note) = &rule.note {
            writeln!(out, "  note          {note} ({})", rule.id)?;
        }
    }
    Ok(())
}

fn connection(out: &mut String, number: usize, ar: &ConnectionReport) -> fmt::Result {
    let mut frames = Vec::new();
    for (what, frame) in [
        ("connect", ar.connect_frame),
        ("end of parameters", ar.parameter_end_frame),
        ("ready", ar.application_ready_frame),
        ("release", ar.release_frame),
        ("abort", ar.abort.map(|abort| abort.frame)),
    ] {
        if let Some(frame) = frame {
            frames.push(format!("{what} {frame}"));
        }
    }
    if let Some(layout) = &ar.layout {
        frames.push(format!("layout {layout}"));
    }
    let mut frames =
        if frames.is_empty() { "established before the capture began".to_owned() } else { frames.join(", ") };
    if !ar.roles_known {
        frames += "; which side is the controller is not in the capture";
    }
    writeln!(
        out,
        "  connection {number} ({}, {}): {} -> {}; {frames}; in: {}; out: {}",
        ar.role,
        ar.stage,
        controller(ar),
        device(ar),
        stream(&ar.rt_in),
        stream(&ar.rt_out)
    )
}

fn controller(ar: &ConnectionReport) -> String {
    party(&ar.controller.station, ar.controller.mac.as_deref(), ar.controller.address)
}

fn device(ar: &ConnectionReport) -> String {
    let mut text = party(&ar.device.station, ar.device.mac.as_deref(), ar.device.address);
    if let Some(ident) = ar.device.ident {
        let _ = write!(text, " ident 0x{ident:04X}");
    }
    if let (Some(vendor), Some(device)) = (ar.device.vendor_id, ar.device.device_id) {
        let _ = write!(text, " vendor 0x{vendor:04X} device 0x{device:04X}");
    }
    text
}

fn party(station: &Option<String>, mac: Option<&str>, number: Option<u8>) -> String {
    let mac = match (mac, number) {
        (Some(mac), _) => mac.to_owned(),
        (None, Some(number)) => format!("station {number}"),
        (None, None) => "unknown station".to_owned(),
    };
    match station {
        Some(station) => format!("'{station}' {mac}"),
        None => mac,
    }
}

fn stream(stream: &StreamReport) -> String {
    if stream.frames == 0 {
        return "no frames".into();
    }
    let gap = stream.max_gap_ns as f64 / 1e6;
    format!("{}, {} lost, longest gap {gap:.3} ms", count(stream.frames as usize, "frame", "frames"), stream.lost)
}
