//! `encspec replay` and `encspec dissect`: reports about captures, and captures frame by frame.

use super::dut::claimed_manuals;
use super::progress::CaptureReadProgress;
use super::reports::{colours, open, write};
use super::{
    CommandError, CommandResult, DissectArgs, ReplayArgs, ReplayFormat, SeverityChoice, ShownFindings, list,
    print_message, show,
};
use clap::ColorChoice;
use jiff::Timestamp;
use jiff::tz::TimeZone;
use judge::observe::{DpFieldValue, ProfibusFields, ProfibusWords, Tracker, describe, dissector};
use plain_text::printable;
use replay::{
    self, CaptureReport, FindingSeverity, IpReassembler, Reassembled, ReplayReport, ReportFilter, TextOptions,
    text_with,
};
use report::ExitStatus;
use report::page::html;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;
use suite::model::Manual;
use virtual_wire::CaptureReader;
use virtual_wire::capture::{CaptureItem, LinkType};

pub(super) fn replay(args: &ReplayArgs) -> CommandResult {
    let sources = args.suites.sources()?;
    // Judging a capture needs the rules but no cases.
    let sources = if args.against.drives() { sources } else { sources.for_rules() };
    let manuals = claimed_manuals(&sources, args.device.as_deref())?;
    let files = args.report.iter().map(|requested| open(&requested.file)).collect::<Result<Vec<_>, CommandError>>()?;
    let has_page = args.report.iter().any(|requested| requested.format == ReplayFormat::Html);
    if has_page && args.files.iter().any(|name| name == "-") {
        return Err(CommandError::usage("an HTML report reads the capture twice; save standard input to a file first"));
    }
    if args.annotate.is_some() && (args.files.len() != 1 || args.files[0] == "-") {
        return Err(CommandError::usage("--annotate takes one capture, and reads it twice; name one file"));
    }
    let mut report = ReplayReport { captures: Vec::new() };
    let mut bad = false;
    let reading = CaptureReadProgress::of(&args.files);
    let each = replay::each(&args.files, &manuals, &|progress| reading.step(progress));
    drop(reading);
    for read in each {
        match read {
            Ok(capture) => report.captures.push(capture),
            Err(error) => {
                print_message(&error.to_string());
                bad = true;
            }
        }
    }
    let filter = args.filter.filter();
    if !filter.is_empty() {
        report.captures.iter_mut().for_each(|capture| filter.apply(capture));
    }
    let on_terminal = TextOptions { colour: colours(args.color), local: Some(local_offset), filter: filter.clone() };
    let in_file = TextOptions { colour: args.color == ColorChoice::Always, ..on_terminal.clone() };
    let differs = args.against.hold(&args.suites, &manuals, &mut report)?;
    if !report.captures.is_empty() {
        for (requested, file) in args.report.iter().zip(files) {
            let text = match requested.format {
                ReplayFormat::Html => page(&report, &manuals)?,
                ReplayFormat::Json => list::pretty(&report),
                ReplayFormat::Text if requested.file == Path::new("-") => text_with(&report, &on_terminal),
                ReplayFormat::Text => text_with(&report, &in_file),
            };
            write(&text, &requested.file, file)?;
        }
        if !args.report.iter().any(|requested| requested.file == Path::new("-")) {
            show(&text_with(&report, &on_terminal));
        }
    }
    for capture in &report.captures {
        if let Some(damage) = capture.damage.first() {
            print_message(&format!(
                "{} is damaged at byte {}: {}; the report covers the {} readable frames",
                printable(&capture.file),
                damage.at,
                printable(&damage.what),
                capture.frames
            ));
            bad = true;
        }
    }
    if let Some(file) = args.annotate.as_ref().filter(|_| !report.captures.is_empty()) {
        annotate(&report, file, args.user_link_type)?;
    }
    if bad {
        return Ok(ExitStatus::Usage);
    }
    let mut findings = report.captures.iter().flat_map(|capture| &capture.findings);
    let has_errors = findings.any(|finding| finding.severity == FindingSeverity::Error);
    Ok(if has_errors || differs { ExitStatus::Red } else { ExitStatus::Green })
}

impl ShownFindings {
    fn filter(&self) -> ReportFilter {
        let ShownFindings { severity, station, from, to } = self.clone();
        let severity = severity.map(|of| match of {
            SeverityChoice::Error => FindingSeverity::Error,
            SeverityChoice::Warning => FindingSeverity::Warning,
            SeverityChoice::Info => FindingSeverity::Info,
        });
        ReportFilter { severity, station, from, to }
    }
}

/// The seconds by which local time is ahead of UTC, at a time in seconds since 1970.
fn local_offset(seconds: u64) -> i64 {
    let time = i64::try_from(seconds).ok().and_then(|seconds| Timestamp::from_second(seconds).ok());
    time.map_or(0, |time| TimeZone::system().to_offset(time).seconds().into())
}

/// Writes the capture again with its findings as comments.
fn annotate(report: &ReplayReport, file: &Path, user: Option<u8>) -> Result<(), CommandError> {
    let cannot = |why: &dyn std::fmt::Display| CommandError::usage(format!("--annotate {}: {why}", file.display()));
    let [capture] = report.captures.as_slice() else {
        return Err(cannot(&"it takes one capture; name one file"));
    };
    let input = Path::new(&capture.file);
    if let (Ok(one), Ok(other)) = (input.canonicalize(), file.canonicalize())
        && one == other
    {
        return Err(cannot(&"that is the capture itself, which is never changed; name another file"));
    }
    let input = File::open(input)
        .map_err(|error| cannot(&format!("{} cannot be read again: {error}", printable(&capture.file))))?;
    let output = File::create(file).map_err(|error| cannot(&error))?;
    replay::annotate(capture, input, BufWriter::new(output), user).map_err(|error| cannot(&error))
}

/// The HTML page of these captures, which are read again.
fn page(report: &ReplayReport, manuals: &[Manual]) -> Result<String, CommandError> {
    let chapter = |(number, capture): (usize, &CaptureReport)| {
        let cannot = |why: &dyn std::fmt::Display| {
            CommandError::bench(format!("{} cannot be read again for the HTML report: {why}", printable(&capture.file)))
        };
        let again = File::open(&capture.file).map_err(|error| cannot(&error))?;
        replay::chapter(number + 1, capture, again, manuals).map_err(|error| cannot(&error))
    };
    let chapters = report.captures.iter().enumerate().map(chapter).collect::<Result<_, CommandError>>()?;
    Ok(html(&replay::page("encspec replay", chapters)))
}

pub(super) fn dissect(args: &DissectArgs) -> CommandResult {
    if let Some(user) = args.lua {
        show(&dissector(user));
        return Ok(ExitStatus::Green);
    }
    let file = args.file.as_deref().ok_or_else(|| CommandError::usage("name a capture"))?;
    let cannot = |why: &dyn std::fmt::Display| CommandError::usage(format!("{}: {why}", file.display()));
    let input: Box<dyn Read> = match file.to_str() {
        Some("-") => Box::new(io::stdin().lock()),
        _ => Box::new(File::open(file).map_err(|error| cannot(&error))?),
    };
    let mut reader = CaptureReader::new(input).map_err(|error| cannot(&error))?;
    let mut out = BufWriter::new(io::stdout().lock());
    let mut tracker = Tracker::new();
    let mut profibus = ProfibusWords::default();
    let mut named = ProfibusFields::default();
    let mut datagrams = IpReassembler::default();
    let mut damaged = false;
    while let Some(item) = reader.next() {
        let line = match item {
            CaptureItem::Packet(packet) if args.fields => {
                if packet.link_type != LinkType::PROFIBUS {
                    continue;
                }
                fields_line(packet.number as u64, &named.frame(packet.captured))
            }
            CaptureItem::Packet(packet) => {
                let number = packet.number as u64;
                let lines = match packet.link_type {
                    LinkType::ETHERNET => {
                        let whole = match datagrams.take(number, packet.time, packet.captured) {
                            Reassembled::Whole => datagrams.whole(),
                            Reassembled::Part | Reassembled::Untouched => packet.captured,
                        };
                        tracker.frame(number, packet.time, whole, &mut |_, _| {});
                        vec![describe(whole, tracker.ars())]
                    }
                    LinkType::PROFIBUS => {
                        let mut lines = profibus.lines(packet.captured);
                        if packet.is_sliced() {
                            let captured = packet.captured.len();
                            lines.push(format!("captured {captured} of {} bytes", packet.original_length));
                        }
                        lines
                    }
                    LinkType(other) => vec![format!("a frame of link type {other}")],
                };
                let lines: Vec<String> = lines.iter().map(|line| printable(line)).collect();
                format!("{number:>6} {} {}", packet.time, lines.join("\n           "))
            }
            CaptureItem::Damage(damage) => {
                damaged = true;
                format!("damaged at byte {}: {}", damage.at, printable(&damage.what))
            }
        };
        // The pipe is closed.
        if writeln!(out, "{line}").is_err() {
            return Ok(ExitStatus::Green);
        }
    }
    let _ = out.flush();
    if damaged {
        print_message(&format!("{} is damaged; only the readable frames are shown", file.display()));
    }
    Ok(if damaged { ExitStatus::Usage } else { ExitStatus::Green })
}

/// The fields of a frame as a line of JSON: the number of the frame, and the values of each field in their order.
fn fields_line(number: u64, fields: &[(String, DpFieldValue)]) -> String {
    let mut values: BTreeMap<&str, Vec<serde_json::Value>> = BTreeMap::new();
    for (name, value) in fields {
        values.entry(name).or_default().push(match value {
            DpFieldValue::Number(number) => (*number).into(),
            DpFieldValue::Octets(octets) => {
                octets.iter().map(|octet| format!("{octet:02x}")).collect::<String>().into()
            }
            DpFieldValue::Text(text) => text.as_str().into(),
        });
    }
    serde_json::json!({ "frame": number, "fields": values }).to_string()
}
