//! `encspec list`: lists cases and rules.

use super::coverage::covers;
use super::{CommandResult, ListingArgs, ListingFormat, show};
use report::ExitStatus;
use serde::Serialize;
use std::fmt::Write as _;
use suite::model::Manual;

/// A case (one row of it) or a rule, with the variants that it applies to.
#[derive(Debug, Serialize)]
pub(super) struct ListedCase {
    pub id: String,
    pub kind: &'static str,
    pub why: String,
    pub covers: Vec<String>,
    pub catches: Vec<String>,
    pub variants: Vec<String>,
    pub at: String,
}

#[derive(Serialize)]
struct ListedManual<'a> {
    id: &'a str,
    title: &'a str,
    variants: &'a [String],
    cases: Vec<ListedCase>,
}

pub(super) fn list(args: &ListingArgs) -> CommandResult {
    let manuals = args.which.suites.load_one(args.which.manual.as_deref())?;
    let listed = manuals.iter().map(|manual| ListedManual {
        id: &manual.device.name,
        title: &manual.device.title,
        variants: &manual.device.variants,
        cases: everything(manual),
    });
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
        let _ = writeln!(out, "\n    {}", case.why);
    }
    let of_kind = |kind| manual.cases.iter().filter(|case| case.kind == kind).count();
    let _ = writeln!(
        out,
        "{}: {} cases and {} rules; variants: {}",
        manual.id,
        of_kind("case"),
        of_kind("rule"),
        manual.variants.join(", ")
    );
    out
}

/// Every case and rule of a manual, of all variants, in suite order.
pub(super) fn everything(manual: &Manual) -> Vec<ListedCase> {
    let mut list: Vec<ListedCase> = Vec::new();
    let names = |covers: &[usize]| -> Vec<String> {
        covers.iter().filter_map(|&index| manual.requirements.get(index)).map(|of| of.id.clone()).collect()
    };
    for kind in ["case", "rule"] {
        for variant in &manual.variants {
            let trials = variant.trials.iter().map(|of| (&of.id, &of.why, names(&covers(of)), &of.catches, &of.at));
            let rules = variant.rules.iter().map(|of| (&of.id, &of.why, names(&of.covers), &of.catches, &of.at));
            let of_kind: Vec<_> = if kind == "case" { trials.collect() } else { rules.collect() };
            for (id, why, covers, catches, at) in of_kind {
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
