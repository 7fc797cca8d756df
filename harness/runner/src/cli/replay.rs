//! `encspec replay` and `encspec dissect`: captures as reports, and frame by frame.

use super::run::{open, write};
use super::{DissectArgs, Ended, Format, ReplayArgs, Stop, complain, list, show};
use crate::observe::{ProfibusWords, Tracker, describe};
use crate::replay::{self, ReplayReport, Severity};
use crate::report::{ExitStatus, printable};
use crate::suite::model::Manual;
use bench::CaptureReader;
use bench::capture::{Item, LinkType};
use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

pub(super) fn replay(args: &ReplayArgs) -> Ended {
    let manuals: Vec<Manual> = args.suites.load_one(args.device.as_deref())?;
    let file = args.report.as_ref().map(|wanted| open(&wanted.file)).transpose()?;
    let mut report = ReplayReport { captures: Vec::new() };
    let mut bad = false;
    for name in &args.files {
        match replay::files(std::slice::from_ref(name), &manuals) {
            Ok(read) => report.captures.extend(read.captures),
            Err(error) => {
                complain(&error.to_string());
                bad = true;
            }
        }
    }
    if !report.captures.is_empty() {
        match (&args.report, file) {
            (Some(wanted), Some(file)) => {
                let text = match wanted.format {
                    Format::Json => list::pretty(&report),
                    Format::Text => replay::text(&report),
                };
                let is_shown = wanted.file == Path::new("-");
                write(&text, &wanted.file, file)?;
                if !is_shown {
                    show(&replay::text(&report));
                }
            }
            _ => show(&replay::text(&report)),
        }
    }
    for capture in &report.captures {
        if let Some(damage) = capture.damage.first() {
            complain(&format!(
                "{} is damaged at octet {}: {}; the {} frames that could be read are in the report",
                printable(&capture.file),
                damage.at,
                printable(&damage.what),
                capture.frames
            ));
            bad = true;
        }
    }
    let mut findings = report.captures.iter().flat_map(|capture| &capture.findings);
    Ok(match (bad, findings.any(|finding| finding.severity == Severity::Error)) {
        (true, _) => ExitStatus::Usage,
        (false, true) => ExitStatus::Red,
        (false, false) => ExitStatus::Green,
    })
}

pub(super) fn dissect(args: &DissectArgs) -> Ended {
    let cannot = |why: &dyn std::fmt::Display| Stop::usage(format!("{}: {why}", args.file.display()));
    let input: Box<dyn Read> = match args.file.to_str() {
        Some("-") => Box::new(io::stdin().lock()),
        _ => Box::new(File::open(&args.file).map_err(|error| cannot(&error))?),
    };
    let mut reader = CaptureReader::new(input).map_err(|error| cannot(&error))?;
    let mut out = BufWriter::new(io::stdout().lock());
    let mut tracker = Tracker::new();
    let mut profibus = ProfibusWords::default();
    let mut damaged = false;
    while let Some(item) = reader.next() {
        let line = match item {
            Item::Packet(packet) => {
                let number = packet.number as u64;
                let lines = match packet.link_type {
                    LinkType::ETHERNET => {
                        tracker.frame(number, packet.time, packet.captured, &mut |_, _| {});
                        vec![describe(packet.captured, tracker.ars())]
                    }
                    LinkType::PROFIBUS => {
                        let mut lines = profibus.lines(packet.captured);
                        if packet.is_sliced() {
                            let kept = packet.captured.len();
                            lines.push(format!("of {} octets {kept} were kept", packet.original_length));
                        }
                        lines
                    }
                    LinkType(other) => vec![format!("a frame of link type {other}")],
                };
                let lines: Vec<String> = lines.iter().map(|line| printable(line)).collect();
                format!("{number:>6} {} {}", packet.time, lines.join("\n           "))
            }
            Item::Damage(damage) => {
                damaged = true;
                format!("damaged at octet {}: {}", damage.at, printable(&damage.what))
            }
        };
        // A reader that has gone wants no more lines.
        if writeln!(out, "{line}").is_err() {
            return Ok(ExitStatus::Green);
        }
    }
    let _ = out.flush();
    if damaged {
        complain(&format!("{} is damaged; what could be read is shown", args.file.display()));
    }
    Ok(if damaged { ExitStatus::Usage } else { ExitStatus::Green })
}
