//! `encspec list`: lists cases and rules.

use super::coverage::covers;
use super::filter::FilterArgs;
use super::{CommandResult, ListingFormat, Suites, show};
use clap::Args;
use engine::Selection;
use report::ExitStatus;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;
use suite::model::{Manual, SuiteVariant};

/// Arguments of `encspec list`.
#[derive(Debug, Args)]
pub(super) struct ListArgs {
    #[command(flatten)]
    filter: FilterArgs,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: ListingFormat,
    /// Folder of the captures, where --failed finds the last run
    #[arg(long, value_name = "DIR", default_value = super::run::EVIDENCE)]
    evidence: PathBuf,
    #[command(flatten)]
    suites: Suites,
}

/// A case (one row of it) or a rule, with the variants that it applies to.
#[derive(Debug, Serialize)]
pub(super) struct ListedCase {
    pub id: String,
    pub kind: &'static str,
    pub why: String,
    pub covers: Vec<String>,
    pub catches: Vec<String>,
    pub variants: Vec<String>,
    /// The suite that it comes from, if it is none of the manual's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub suite: Option<String>,
    pub at: String,
}

#[derive(Serialize)]
struct ListedManual<'a> {
    id: &'a str,
    title: &'a str,
    variants: &'a [String],
    cases: Vec<ListedCase>,
}

pub(super) fn list(args: &ListArgs) -> CommandResult {
    let manuals = args.suites.load()?;
    let selection = args.filter.selection(&manuals, &args.evidence)?;
    let all = manuals.iter().flat_map(|manual| manual.variants.iter().map(move |variant| (manual, variant)));
    args.filter.check_matches(&selection, &all.collect::<Vec<(&Manual, &SuiteVariant)>>())?;
    let listed = manuals.iter().map(|manual| ListedManual {
        id: &manual.device.name,
        title: &manual.device.title,
        variants: &manual.device.variants,
        cases: selected(manual, &selection),
    });
    let listed = listed.filter(|manual| selection.is_all() || !manual.cases.is_empty());
    match args.format {
        ListingFormat::Json => show(&json(listed.collect())),
        ListingFormat::Text => show(&listed.map(|manual| text(&manual)).collect::<String>()),
    }
    Ok(ExitStatus::Green)
}

fn text(manual: &ListedManual<'_>) -> String {
    let mut out = String::new();
    for case in &manual.cases {
        // Writing into a String cannot fail.
        let _ = write!(out, "{}", case.id);
        if case.variants.len() < manual.variants.len() {
            let _ = write!(out, " ({} only)", case.variants.join(", "));
        }
        if let Some(suite) = &case.suite {
            let _ = write!(out, " (from {suite})");
        }
        let _ = writeln!(out, "\n    {}", case.why);
    }
    let of_kind = |kind| manual.cases.iter().filter(|case| case.kind == kind).count();
    let taken = manual.cases.iter().filter(|case| case.suite.is_some()).count();
    let taken = if taken == 0 { String::new() } else { format!(", {taken} of them from other suites") };
    let _ = writeln!(
        out,
        "{}: {} cases and {} rules{taken}; variants: {}",
        manual.id,
        of_kind("case"),
        of_kind("rule"),
        manual.variants.join(", ")
    );
    out
}

/// Every case and rule of a manual, of all variants, in suite order.
pub(super) fn everything(manual: &Manual) -> Vec<ListedCase> {
    selected(manual, &Selection::default())
}

/// The cases and rules of a manual that a selection has.
fn selected(manual: &Manual, selection: &Selection) -> Vec<ListedCase> {
    let mut list: Vec<ListedCase> = Vec::new();
    let names = |covers: &[usize]| -> Vec<String> {
        covers.iter().filter_map(|&index| manual.requirements.get(index)).map(|of| of.id.clone()).collect()
    };
    for kind in ["case", "rule"] {
        for variant in &manual.variants {
            let trials = variant.trials.iter().filter(|of| selection.trial(manual, variant, of));
            let rules = variant.rules.iter().filter(|of| selection.rule(manual, variant, of));
            let trials = trials.map(|of| (&of.id, &of.why, names(&covers(of)), &of.catches, &of.at));
            let rules = rules.map(|of| (&of.id, &of.why, names(&of.covers), &of.catches, &of.at));
            let of_kind: Vec<_> = if kind == "case" { trials.collect() } else { rules.collect() };
            for (id, why, covers, catches, at) in of_kind {
                let suite = manual.suite_of(id).map(|suite| suite.name.clone());
                let id = format!("{}/{id}", manual.device.name);
                match list.iter_mut().find(|known| known.id == id && known.kind == kind) {
                    Some(known) => known.variants.push(variant.name.clone()),
                    None => list.push(ListedCase {
                        id,
                        kind,
                        why: why.clone(),
                        covers,
                        catches: catches.clone(),
                        variants: vec![variant.name.clone()],
                        suite,
                        at: format!("{}:{}", at.file.display(), at.line),
                    }),
                }
            }
        }
    }
    list
}

/// The listings of all manuals as JSON.
pub(super) fn json(manuals: Vec<impl Serialize>) -> String {
    #[derive(Serialize)]
    struct ManualListing<T> {
        manuals: Vec<T>,
    }
    pretty(&ManualListing { manuals })
}

/// Indented JSON with a newline at the end.
pub(super) fn pretty(value: &impl Serialize) -> String {
    // Serialising cannot fail: all keys are strings and all numbers finite.
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}
