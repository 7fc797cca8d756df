//! `FILTER`, `--exact` and `--failed`: which cases and rules a command line selects.

use super::CommandError;
use clap::Args;
use engine::{NotGreen, Selection};
use plain_text::nearest;
use results::outcome::RunResult;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use suite::model::{Manual, SuiteVariant};

/// The file in the folder of the captures that holds the verdicts of the last run.
pub const LAST_RUN: &str = "last-run.json";
/// The verdicts that `--failed` selects, as reports name them.
const NOT_GREEN: [&str; 4] = ["fail", "error", "inconclusive", "xpass"];

/// Which cases and rules are meant.
#[allow(rustdoc::broken_intra_doc_links, reason = "the comments are the help texts of the command line")]
#[derive(Clone, Debug, Default, Args)]
pub struct FilterArgs {
    /// Only cases and rules whose id contains this text (ids are MANUAL/SUITE/CASE[ROW] and MANUAL/SUITE/RULE), or that cover
    /// a requirement (`XAC77-PRK-004`, `XAC77-PRK`), a clause (`16.3`, `'p. 149'`) or a level (`must`, `should`, `info`). Of
    /// several any may match; the name of a manual narrows the others; `!FILTER` leaves out what FILTER selects
    #[arg(value_name = "FILTER")]
    pub filters: Vec<String>,
    /// Match each FILTER against the whole id
    #[arg(long, requires = "filters")]
    pub exact: bool,
    /// Only what was not green in the last run that wrote captures, or in this JSON report
    #[arg(long, value_name = "REPORT", num_args = 0..=1, require_equals = true)]
    pub failed: Option<Option<PathBuf>>,
}

impl FilterArgs {
    /// The arguments as they were written, for the report of a run.
    pub fn as_written(&self) -> Vec<String> {
        let exact = self.exact.then(|| "--exact".to_owned());
        let failed = self.failed.as_ref().map(|_| "--failed".to_owned());
        self.filters.iter().cloned().chain(exact).chain(failed).collect()
    }

    /// The selection of these arguments. `evidence` is the folder of the captures, which has the last run.
    pub fn selection(&self, manuals: &[Manual], evidence: &Path) -> Result<Selection, CommandError> {
        let selection = Selection::of(&self.filters, self.exact, manuals);
        let Some(failed) = &self.failed else { return Ok(selection) };
        let file = failed.clone().unwrap_or_else(|| evidence.join(LAST_RUN));
        let not_green = not_green(&file)?;
        match not_green.is_empty() {
            true => {
                Err(CommandError::usage(format!("everything was green in {}; run without --failed", file.display())))
            }
            false => Ok(selection.not_green(not_green)),
        }
    }

    /// Fails if a filter selects nothing of these manuals and variants, or all of them together nothing.
    pub fn check_matches(
        &self,
        selection: &Selection,
        selected: &[(&Manual, &SuiteVariant)],
    ) -> Result<(), CommandError> {
        if selection.is_all() || selected.is_empty() {
            return Ok(());
        }
        if let Some(filter) = selection.unmatched(selected).first() {
            let text = filter.strip_prefix('!').unwrap_or(filter);
            let manuals = selected.iter().map(|(manual, _)| manual.device.name.as_str());
            let meant = suggest_id(text, &known_words(selected))
                .or_else(|| nearest(text, manuals))
                .map_or_else(|| "`encspec list` lists all ids".to_owned(), |meant| format!("did you mean `{meant}`?"));
            let how = if self.exact { "is" } else { "contains" };
            return Err(CommandError::usage(format!("no case or rule id {how} `{text}`; {meant}")));
        }
        let is_any = selected.iter().any(|(manual, variant)| selection.selects_in(manual, variant));
        match (is_any, &self.failed) {
            (true, _) => Ok(()),
            (false, None) => Err(CommandError::usage("the filters leave no case and no rule")),
            (false, Some(_)) => {
                Err(CommandError::usage("nothing that --failed and the filters select belongs to these devices"))
            }
        }
    }
}

/// The ids of the cases and rules, and of the requirements with the manual in front.
fn known_words(selected: &[(&Manual, &SuiteVariant)]) -> Vec<String> {
    let mut known: Vec<String> = Vec::new();
    for (manual, variant) in selected {
        let ids = variant.trials.iter().map(|of| &of.id).chain(variant.rules.iter().map(|of| &of.id));
        let ids = ids.chain(manual.requirements.iter().map(|of| &of.id));
        known.extend(ids.map(|id| format!("{}/{id}", manual.device.name)));
    }
    known
}

/// What was not green by a JSON report.
fn not_green(file: &Path) -> Result<BTreeSet<NotGreen>, CommandError> {
    let failed = |why: String| CommandError::usage(format!("--failed: {}: {why}", file.display()));
    let text = fs::read_to_string(file).map_err(|error| failed(error.to_string()))?;
    let report: Value = serde_json::from_str(&text).map_err(|error| failed(error.to_string()))?;
    let runs =
        report["runs"].as_array().ok_or_else(|| failed("it is not a JSON report of `encspec run`".to_owned()))?;
    let mut list = BTreeSet::new();
    for run in runs {
        for case in run["cases"].as_array().into_iter().flatten() {
            if let (Some(variant), Some(id), Some(verdict)) =
                (run["dut"]["variant"].as_str(), case["id"].as_str(), case["verdict"].as_str())
                && NOT_GREEN.contains(&verdict)
            {
                list.insert(NotGreen { id: id.to_owned(), variant: variant.to_owned() });
            }
        }
    }
    Ok(list)
}

/// What `--failed` reads of a run: its cases and rules that are not green, in the form of the JSON report.
pub fn last_run(result: &RunResult) -> String {
    let runs = result.runs.iter().map(|run| {
        let cases = run.cases.iter().filter(|case| NOT_GREEN.contains(&case.verdict.to_string().as_str()));
        let cases = cases.map(|case| json!({ "id": case.id, "verdict": case.verdict.to_string() }));
        json!({ "dut": { "device": run.dut.device, "variant": run.dut.variant }, "cases": cases.collect::<Vec<_>>() })
    });
    format!("{:#}\n", json!({ "runs": runs.collect::<Vec<_>>() }))
}

/// The nearest id, or part of an id between slashes, to a filter that matches none of `ids`.
pub fn suggest_id(filter: &str, ids: &[String]) -> Option<String> {
    let whole = ids.iter().map(String::as_str);
    let without_manual = || whole.clone().filter_map(|id| id.split_once('/').map(|(_, rest)| rest));
    let without_row = || without_manual().filter_map(|id| id.split_once('[').map(|(rest, _)| rest));
    let parts = || without_manual().flat_map(|id| id.split('/'));
    let cases = || parts().filter_map(|part| part.split_once('[').map(|(case, _)| case));
    let words = if filter.contains('/') {
        whole.clone().chain(without_manual()).chain(without_row()).collect::<Vec<_>>()
    } else {
        parts().chain(cases()).collect()
    };
    // With --exact the last part of an id is not enough.
    let ended = whole.clone().find(|id| id.strip_suffix(filter).is_some_and(|before| before.ends_with('/')));
    let near = ended.map(str::to_owned).or_else(|| nearest(filter, words.iter().copied()));
    near.or_else(|| filter.rsplit_once('/').and_then(|(_, last)| nearest(last, parts().chain(cases()))))
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    const IDS: [&str; 4] =
        ["enc/preset/absolute", "enc/preset/shifted[mode 1]", "enc/rules/one-position", "enc/park/park"];

    #[rstest]
    #[case("presett", Some("preset"))]
    #[case("shiftet", Some("shifted"))]
    #[case("enc/preset/absolut", Some("enc/preset/absolute"))]
    #[case("preset/absolut", Some("preset/absolute"))]
    #[case("one-positoin", Some("one-position"))]
    #[case("absolute", Some("enc/preset/absolute"))]
    #[case("preset/shifted[mode 1]", Some("enc/preset/shifted[mode 1]"))]
    #[case("xyzzy", None)]
    fn the_nearest_id_is_suggested(#[case] filter: &str, #[case] meant: Option<&str>) {
        let ids: Vec<String> = IDS.iter().map(|id| (*id).to_owned()).collect();
        assert_eq!(super::suggest_id(filter, &ids).as_deref(), meant);
    }
}
