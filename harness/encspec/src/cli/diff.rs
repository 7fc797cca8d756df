//! `encspec diff`: compares two runs by their JSON reports.

use super::dut::suggest;
use super::reports::{format_and_file, open, write};
use super::{CommandError, CommandResult, show};
use clap::Args;
use report::ExitStatus;
use report::diff::RunDiff;
use results::outcome::RunResult;
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

const EXAMPLE: &str = "\
Example:
  encspec run --dut bench.yaml --report json=new.json
  encspec diff released.json new.json --report markdown=changes.md

Exit status: 0 nothing is worse, 1 something newly fails or is no longer tested, 2 the reports cannot be compared.";

/// Arguments of `encspec diff`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub(super) struct DiffArgs {
    /// JSON report of the older run (`encspec run --report json=FILE`); - reads standard input
    before: PathBuf,
    /// JSON report of the newer run
    after: PathBuf,
    /// Write the comparison; FORMAT is console, html, json or markdown, FILE - is standard output; may be repeated
    #[arg(long, value_name = "FORMAT=FILE", value_parser = diff_report)]
    report: Vec<DiffReport>,
}

/// A report that `--report` of `encspec diff` requests.
#[derive(Clone, Debug)]
struct DiffReport {
    format: DiffFormat,
    file: PathBuf,
}

/// The format of a comparison.
#[derive(Clone, Copy, Debug)]
enum DiffFormat {
    Console,
    Html,
    Json,
    Markdown,
}

fn diff_report(text: &str) -> Result<DiffReport, String> {
    let (word, file) = format_and_file(text)?;
    let known = [
        ("console", DiffFormat::Console),
        ("html", DiffFormat::Html),
        ("json", DiffFormat::Json),
        ("markdown", DiffFormat::Markdown),
    ];
    match known.into_iter().find(|(known, _)| *known == word) {
        Some((_, format)) => Ok(DiffReport { format, file }),
        None => Err(suggest("format", word, known.map(|(word, _)| word))),
    }
}

/// Reads a JSON report: the version of encspec that wrote it, and the run.
pub(super) fn read_report(path: &Path) -> Result<(String, RunResult), CommandError> {
    let failed = |why: &dyn std::fmt::Display| CommandError::usage(format!("{}: {why}", path.display()));
    let mut text = String::new();
    if path == Path::new("-") {
        io::stdin().lock().read_to_string(&mut text).map_err(|error| failed(&error))?;
    } else {
        text = fs::read_to_string(path).map_err(|error| failed(&error))?;
    }
    report::read(&text).map_err(|error| failed(&error))
}

pub(super) fn diff(args: &DiffArgs) -> CommandResult {
    let (old_version, before) = read_report(&args.before)?;
    let (new_version, after) = read_report(&args.after)?;
    let diff = RunDiff::of(&before, &after, [&old_version, &new_version]).ok_or_else(|| {
        let names = |of: &RunResult| {
            let names = of.runs.iter().map(|run| format!("{}/{}", run.dut.device, run.dut.variant));
            names.collect::<Vec<_>>().join(", ")
        };
        let (old, new) = (names(&before), names(&after));
        CommandError::usage(format!("the runs have no device in common: {old} in the one, {new} in the other"))
    })?;
    for requested in &args.report {
        let text = match requested.format {
            DiffFormat::Console => diff.console(),
            DiffFormat::Html => diff.html(),
            DiffFormat::Json => diff.json(),
            DiffFormat::Markdown => diff.markdown(),
        };
        write(&text, &requested.file, open(&requested.file)?)?;
    }
    if !args.report.iter().any(|requested| requested.file == Path::new("-")) {
        show(&diff.console());
    }
    Ok(if diff.is_regression() { ExitStatus::Red } else { ExitStatus::Green })
}
