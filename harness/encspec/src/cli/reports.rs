//! `--report FORMAT=FILE` of the commands that have a run: parsing, files and the pictures of HTML pages.

use super::dut::suggest;
use super::pdf;
use super::{CommandError, show};
use clap::ColorChoice;
use replay::PageCapture;
use report::page::{Mark, Timeline};
use report::{self, CaseEvidence, ReportFormat};
use results::outcome::{CaseResult, RunResult};
use std::ffi::OsStr;
use std::fs::{File, OpenOptions};
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use suite::model::Manual;

/// The environment variable of GitHub Actions with the file of the step's summary.
const STEP_SUMMARY: &str = "GITHUB_STEP_SUMMARY";

/// The format of a report: a text, or its page printed as PDF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RequestedFormat {
    Text(ReportFormat),
    Pdf,
}

/// A report that `--report` requests.
#[derive(Clone, Debug)]
pub(super) struct ReportRequest {
    pub format: RequestedFormat,
    pub file: PathBuf,
}

/// Splits `FORMAT=FILE` into format and file.
pub(super) fn format_and_file(text: &str) -> Result<(&str, PathBuf), String> {
    let (word, file) = text.split_once('=').ok_or("write FORMAT=FILE, for instance json=report.json")?;
    if file.is_empty() {
        Err(format!("the file name is missing after `{word}=`"))
    } else {
        Ok((word, PathBuf::from(file)))
    }
}

pub(super) fn parse_report_request(text: &str) -> Result<ReportRequest, String> {
    // Annotations are read from the output of the step.
    let (word, file) = if text == "github" { (text, PathBuf::from("-")) } else { format_and_file(text)? };
    if word == "pdf" {
        return match file == Path::new("-") {
            true => Err("a PDF is written to a file, for instance pdf=report.pdf".to_owned()),
            false => Ok(ReportRequest { format: RequestedFormat::Pdf, file }),
        };
    }
    let words = ReportFormat::ALL.iter().map(|(word, _)| *word).chain(["pdf"]);
    let known = ReportFormat::ALL.into_iter().find(|(known, _)| *known == word);
    let (_, format) = known.ok_or_else(|| suggest("format", word, words))?;
    Ok(ReportRequest { format: RequestedFormat::Text(format), file })
}

/// Fails if the folder of a report does not exist.
pub(super) fn check_folders(requests: &[ReportRequest]) -> Result<(), CommandError> {
    if requests.iter().any(|of| of.format == RequestedFormat::Pdf) {
        pdf::browser()?;
    }
    for requested in requests {
        let folder = requested.file.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            let (file, folder) = (requested.file.display(), folder.display());
            return Err(CommandError::usage(format!(
                "the report {file} cannot be written: folder {folder} does not exist"
            )));
        }
    }
    Ok(())
}

/// Opens the file of each report; `None` for standard output.
pub(super) fn open_all(requests: &[ReportRequest]) -> Result<Vec<Option<File>>, CommandError> {
    requests.iter().map(|requested| open(&requested.file)).collect()
}

/// Writes each report to its file.
pub(super) fn write_all(
    requests: &[ReportRequest],
    files: Vec<Option<File>>,
    result: &RunResult,
    manuals: &[Manual],
) -> Result<(), CommandError> {
    for (requested, file) in requests.iter().zip(files) {
        let page = || report::html(result, &|case| evidence_pictures(case, manuals));
        let text = match requested.format {
            RequestedFormat::Pdf => {
                pdf::write(&page(), &requested.file)?;
                continue;
            }
            RequestedFormat::Text(ReportFormat::Html) => page(),
            RequestedFormat::Text(format) => format.write(result),
        };
        write(&text, &requested.file, file)?;
        if requested.format == RequestedFormat::Text(ReportFormat::Github) {
            add_step_summary(result)?;
        }
    }
    Ok(())
}

/// Adds the Markdown report to the summary of the step, if GitHub Actions runs it.
fn add_step_summary(result: &RunResult) -> Result<(), CommandError> {
    let Some(path) = std::env::var_os(STEP_SUMMARY).filter(|path| !path.is_empty()) else { return Ok(()) };
    let path = Path::new(&path);
    let opened = OpenOptions::new().append(true).create(true).open(path);
    let written = opened.and_then(|mut file| file.write_all(report::markdown(result).as_bytes()));
    written.map_err(|error| {
        CommandError::bench(format!("the summary {} ({STEP_SUMMARY}) could not be written: {error}", path.display()))
    })
}

/// Whether one of the reports is written to standard output, instead of the text for people.
pub(super) fn uses_standard_output(requests: &[ReportRequest]) -> bool {
    // Annotations stand beside the text for people.
    requests.iter().any(|of| of.file == Path::new("-") && of.format != RequestedFormat::Text(ReportFormat::Github))
}

/// Timelines and the failing packet, from the capture of a case. Empty if there is no capture or it cannot be read.
fn evidence_pictures(case: &CaseResult, manuals: &[Manual]) -> CaseEvidence {
    let place = case.failures.first().and_then(|failure| failure.place.as_ref());
    let evidence = case.evidence.as_ref().and_then(|path| File::open(path).ok());
    let frame = place.iter().map(|place| place.frame);
    let Some(Ok(details)) = evidence.map(|evidence| PageCapture::at(evidence, frame, manuals)) else {
        return CaseEvidence::default();
    };
    let mark = place.and_then(|place| Some((place.octet?, place.bit)));
    let packet = place.and_then(|place| details.packet(place.frame, mark, manuals));
    let at = place.and_then(|place| details.seconds(place.frame));
    let mut timelines: Vec<Timeline> = details.timelines.into_iter().map(|(_, timeline)| timeline).collect();
    for (index, timeline) in timelines.iter_mut().enumerate() {
        timeline.heading = format!("Connection {}", index + 1);
        let at = at.filter(|at| (timeline.from..=timeline.to).contains(at));
        let text = case.reason.clone().unwrap_or_default();
        timeline.marks.extend(at.map(|at| Mark { at, is_finding: true, text, anchor: None }));
    }
    CaseEvidence { packet, timelines }
}

/// Opens the file of a report before anything runs, so that no result is lost to a wrong path. An existing file keeps its content
/// until the report is written.
pub(super) fn open(path: &Path) -> Result<Option<File>, CommandError> {
    if path == Path::new("-") {
        return Ok(None);
    }
    let opened = OpenOptions::new().write(true).create(true).truncate(false).open(path);
    opened
        .map(Some)
        .map_err(|error| CommandError::usage(format!("the report {} cannot be written: {error}", path.display())))
}

pub(super) fn write(text: &str, path: &Path, file: Option<File>) -> Result<(), CommandError> {
    let Some(mut file) = file else {
        show(text);
        return Ok(());
    };
    // Fails on pipes and character devices, which have no length.
    let _ = file.set_len(0);
    let written = file.write_all(text.as_bytes()).and_then(|()| file.flush());
    written.map_err(|error| CommandError::bench(format!("the report {} could not be written: {error}", path.display())))
}

/// Whether to colour standard output; automatically if it is a terminal, `NO_COLOR` is not set and `TERM` is not `dumb`.
pub(super) fn colours(choice: ColorChoice) -> bool {
    match choice {
        ColorChoice::Always => return true,
        ColorChoice::Never => return false,
        ColorChoice::Auto => {}
    }
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    io::stdout().is_terminal() && set("NO_COLOR").is_none() && set("TERM").is_none_or(|term| term != OsStr::new("dumb"))
}
