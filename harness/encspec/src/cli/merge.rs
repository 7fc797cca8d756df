//! `encspec merge`: joins the parts of a run, and runs of different devices, into one report.

use super::diff::read_report;
use super::reports::{
    ReportRequest, check_folders, colours, open_all, parse_report_request, uses_standard_output, write_all,
};
use super::{CommandError, CommandResult, Suites, show};
use clap::{ArgAction, Args, ColorChoice};
use engine::causes;
use results::merge::{MergedReport, merge};
use results::outcome::{CaseResult, DeviceRun};
use results::verdict::Verdict;
use std::path::PathBuf;
use suite::model::Manual;

const EXAMPLE: &str = "\
Example, with a part on each of two benches:
  encspec run --dut bench-1.yaml --part 1/2 --report json=part-1.json
  encspec run --dut bench-2.yaml --part 2/2 --report json=part-2.json
  encspec merge part-1.json part-2.json --report junit=junit.xml --report html=report.html

The exit status is that of the merged run; 2 if a part is missing or the parts do not belong together.";

/// Arguments of `encspec merge`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub(super) struct MergeArgs {
    /// JSON reports: all parts of a run (`encspec run --part 1/4 --report json=FILE`), or runs of different devices
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Write a report; FORMAT is console, github, html, json, junit, markdown, pdf, tap or text, FILE - is standard output; may be repeated
    #[arg(long, value_name = "FORMAT=FILE", value_parser = parse_report_request)]
    report: Vec<ReportRequest>,
    /// List every case
    #[arg(short, long, action = ArgAction::SetTrue)]
    verbose: bool,
    /// Whether to use colours; auto: on a terminal, unless NO_COLOR is set
    #[arg(long, value_enum, value_name = "WHEN", default_value_t = ColorChoice::Auto)]
    color: ColorChoice,
    #[command(flatten)]
    suites: Suites,
}

pub(super) fn run(args: &MergeArgs) -> CommandResult {
    check_folders(&args.report)?;
    let read = |file: &PathBuf| -> Result<MergedReport, CommandError> {
        let (version, result) = read_report(file)?;
        Ok(MergedReport { name: file.display().to_string(), version, result })
    };
    let reports = args.files.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let mut result = merge(reports).map_err(|error| CommandError::usage(error.to_string()))?;
    let manuals = args.suites.load()?;
    result.runs.iter_mut().for_each(|run| group_failures(run, &manuals));
    let files = open_all(&args.report)?;
    write_all(&args.report, files, &result, &manuals)?;
    if !uses_standard_output(&args.report) {
        show(&report::console(
            &result,
            report::ConsoleOptions { colour: colours(args.color), verbose: args.verbose, quiet: false },
        ));
    }
    Ok(report::status(&result))
}

/// Groups the failures of all parts by probable cause, as a whole run does before the ledger is applied. A device that no suite
/// describes keeps the groups that it has.
fn group_failures(run: &mut DeviceRun, manuals: &[Manual]) {
    let Some(manual) = manuals.iter().find(|manual| manual.device.name == run.dut.device) else { return };
    let Some(variant) = manual.variants.iter().find(|variant| variant.name == run.dut.variant) else { return };
    let before_ledger = |verdict: Verdict| match verdict {
        Verdict::Xfail => Verdict::Fail,
        Verdict::Xpass => Verdict::Pass,
        other => other,
    };
    let mut cases: Vec<CaseResult> = run.cases.clone();
    for case in &mut cases {
        case.verdict = before_ledger(case.verdict);
        case.covers.iter_mut().for_each(|covered| covered.verdict = before_ledger(covered.verdict));
    }
    run.causes = causes(manual, variant, &cases);
}
