//! The report for the console: a paragraph for each connection, then what happened, then what is wrong.

use super::report::{CaptureReport, ConnectionReport, ReplayReport, Severity, StreamReport};
use crate::report::count;
use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

/// Writes the report; texts of stations are escaped already.
pub fn text(report: &ReplayReport) -> String {
    let mut out = String::new();
    for (place, capture) in report.captures.iter().enumerate() {
        if place > 0 {
            out.push('\n');
        }
        // Writing into a String cannot fail.
        let _ = one(&mut out, capture);
    }
    out
}

fn one(out: &mut String, capture: &CaptureReport) -> fmt::Result {
    let connections = count(capture.ars.len(), "connection", "connections");
    writeln!(
        out,
        "{}: {}, {connections}",
        capture.file.escape_debug(),
        count(capture.frames as usize, "frame", "frames")
    )?;
    for damage in &capture.damage {
        writeln!(out, "  damaged at octet {}: {}", damage.at, damage.what)?;
    }
    let mut refused: BTreeMap<(String, String), Vec<u64>> = BTreeMap::new();
    for (place, ar) in capture.ars.iter().enumerate() {
        if ar.stage == "refused" {
            let frame = ar.connect_frame.unwrap_or_default();
            refused.entry((controller(ar), device(ar))).or_default().push(frame);
        } else {
            connection(out, place + 1, ar)?;
        }
    }
    for ((controller, device), frames) in refused {
        let (first, last) = (frames.first().copied().unwrap_or_default(), frames.last().copied().unwrap_or_default());
        writeln!(out, "\n  refused {}: {controller} -> {device}", count(frames.len(), "time", "times"))?;
        writeln!(out, "    connect: first in frame {first}, last in frame {last}")?;
    }
    if !capture.events.is_empty() {
        writeln!(out, "\n  events (frame, seconds)")?;
    }
    for event in &capture.events {
        writeln!(out, "  {:>7} {:>14.6}  {:<18} {}", event.frame, event.time, event.kind.word(), event.text)?;
    }
    if capture.rules.is_empty() {
        writeln!(out, "\n  no rule was judged: no suite knows a device of this capture by its connection")?;
    } else {
        writeln!(out, "\n  rules")?;
    }
    for rule in &capture.rules {
        write!(out, "  {:<13} {} ({} decided, {} not)", rule.verdict, rule.id, rule.premises, rule.undecided)?;
        match &rule.reason {
            Some(reason) => writeln!(out, ": {reason}")?,
            None => writeln!(out)?,
        }
    }
    if !capture.findings.is_empty() {
        writeln!(out, "\n  findings")?;
    }
    for finding in &capture.findings {
        let severity = match finding.severity {
            Severity::Error => "error",
            Severity::Info => "info",
        };
        writeln!(out, "  {severity:<5} {} in frame {}: {}", finding.id, finding.frame, finding.text)?;
    }
    Ok(())
}

fn connection(out: &mut String, number: usize, ar: &ConnectionReport) -> fmt::Result {
    writeln!(out, "\n  connection {number} ({}, {}): {} -> {}", ar.role, ar.stage, controller(ar), device(ar))?;
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
    let frames = if frames.is_empty() { "made before the capture began".to_owned() } else { frames.join(", ") };
    writeln!(out, "    frames: {frames}")?;
    writeln!(out, "    in: {}; out: {}", stream(&ar.rt_in), stream(&ar.rt_out))
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
        (None, None) => "nobody".to_owned(),
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
