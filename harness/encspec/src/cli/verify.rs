//! `encspec verify`: checks the evidence of a report by its hashes.

use super::hash::sha256_of_file;
use super::{CommandError, CommandResult, show};
use clap::Args;
use plain_text::{count, printable};
use report::ExitStatus;
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

const EXAMPLE: &str = "\
Example:
  encspec run --dut bench.yaml --report html=report.html
  encspec verify report.html

Exit status: 0 every file is there and unchanged, 1 one is missing or changed, 2 the file is no report.";

/// Where the HTML report has its list of files.
const BEGIN: &str = "<script type=\"application/json\" id=\"evidence\">";

/// Arguments of `encspec verify`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub(super) struct VerifyArgs {
    /// HTML or JSON report of `encspec run`
    report: PathBuf,
}

/// A file of the evidence, and its hash when the report was written.
struct EvidenceFile {
    file: String,
    sha256: Option<String>,
}

pub(super) fn verify(args: &VerifyArgs) -> CommandResult {
    let path = &args.report;
    let failed = |why: &str| CommandError::usage(format!("{}: {why}", path.display()));
    let text = fs::read(path).map_err(|error| failed(&error.to_string()))?;
    if text.starts_with(b"%PDF") {
        return Err(failed(
            "a PDF has no list of files that can be read; verify the HTML or JSON report of the same run",
        ));
    }
    let text = String::from_utf8(text).map_err(|_| failed("it is no report of `encspec run`"))?;
    let files = listed(&text).ok_or_else(|| failed("it is no HTML or JSON report of `encspec run`"))?;
    let mut out = String::new();
    let mut wrong = 0;
    for of in &files {
        let file = printable(&of.file);
        let said = match (&of.sha256, sha256_of_file(&place(path, &of.file))) {
            (_, Err(error)) => format!("missing   {file}: {error}"),
            (None, Ok(_)) => format!("no hash   {file}: the report has none"),
            (Some(known), Ok(hash)) if *known == hash => {
                let _ = writeln!(out, "unchanged {file}");
                continue;
            }
            (Some(known), Ok(hash)) => {
                format!("changed   {file}\n          SHA-256 {hash}\n          report  {}", printable(known))
            }
        };
        wrong += 1;
        // Writing into a String cannot fail.
        let _ = writeln!(out, "{said}");
    }
    let all = count(files.len(), "file", "files");
    let _ = match wrong {
        0 => writeln!(out, "{all} of evidence, all unchanged."),
        wrong => writeln!(out, "{wrong} of {all} of evidence cannot be confirmed."),
    };
    show(&out);
    Ok(if wrong == 0 { ExitStatus::Green } else { ExitStatus::Red })
}

/// The file as the report names it, or beside the report if it is not there.
fn place(report: &Path, file: &str) -> PathBuf {
    let named = PathBuf::from(file);
    let beside = report.parent().map(|folder| folder.join(file));
    match beside {
        Some(beside) if !named.is_file() && beside.is_file() => beside,
        _ => named,
    }
}

/// The files in a report; `None` if it is none.
fn listed(text: &str) -> Option<Vec<EvidenceFile>> {
    if let Some((_, after)) = text.split_once(BEGIN) {
        let data: Value = serde_json::from_str(after.split("</script>").next()?).ok()?;
        return data.as_array()?.iter().map(|of| file(of, "file", "sha256")).collect();
    }
    let report: Value = serde_json::from_str(text).ok()?;
    let runs = report["runs"].as_array().filter(|_| report["tool"]["name"] == "encspec")?;
    let cases = runs.iter().flat_map(|run| run["cases"].as_array().into_iter().flatten());
    cases.filter(|case| case["evidence"].is_string()).map(|case| file(case, "evidence", "evidence_sha256")).collect()
}

fn file(of: &Value, file: &str, hash: &str) -> Option<EvidenceFile> {
    Some(EvidenceFile { file: of[file].as_str()?.to_owned(), sha256: of[hash].as_str().map(str::to_owned) })
}
