//! `encspec list`, `bugs` and `errata`: what there is in the suites.

use super::coverage::{covering, covers};
use super::{Ended, Format, Listing, Which, show};
use crate::report::{ExitStatus, level};
use crate::suite::model::{Class, Manual};
use serde::Serialize;
use std::fmt::Write as _;

/// A case (one row of it) or a rule, with the variants that have it.
#[derive(Debug, Serialize)]
pub(super) struct Listed {
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
    cases: Vec<Listed>,
}

pub(super) fn list(args: &Listing) -> Ended {
    let manuals = args.which.suites.load_one(args.which.manual.as_deref())?;
    let listed = manuals.iter().map(|manual| ListedManual {
        id: &manual.device.name,
        title: &manual.device.title,
        variants: &manual.device.variants,
        cases: everything(manual),
    });
    match args.format {
        Format::Json => {
            #[derive(Serialize)]
            struct Report<'a> {
                manuals: Vec<ListedManual<'a>>,
            }
            show(&pretty(&Report { manuals: listed.collect() }));
        }
        Format::Text => show(&listed.map(|manual| text(&manual)).collect::<String>()),
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
        "{}: {} cases and {} rules for the variants {}",
        manual.id,
        of_kind("case"),
        of_kind("rule"),
        manual.variants.join(", ")
    );
    out
}

/// Every case and rule of a manual in the order of the suites, whichever variant has it.
pub(super) fn everything(manual: &Manual) -> Vec<Listed> {
    let mut list: Vec<Listed> = Vec::new();
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
                    None => list.push(Listed {
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

pub(super) fn bugs(args: &Which) -> Ended {
    let mut out = String::new();
    for manual in args.suites.load_one(args.manual.as_deref())? {
        let cases = everything(&manual);
        // Writing into a String cannot fail.
        let _ = writeln!(out, "{}: {} bugs", manual.device.name, manual.bugs.len());
        for bug in &manual.bugs {
            let breaks: Vec<&str> = bug
                .breaks
                .iter()
                .filter_map(|&index| manual.requirements.get(index))
                .map(|of| of.id.as_str())
                .collect();
            let _ = writeln!(out, "  {}\n    {}\n    breaks {}", bug.name, bug.why, breaks.join(", "));
            for case in cases.iter().filter(|case| case.catches.contains(&bug.name)) {
                let _ = writeln!(out, "    caught by {}", case.id);
            }
        }
    }
    show(&out);
    Ok(ExitStatus::Green)
}

pub(super) fn errata(args: &Which) -> Ended {
    let mut out = String::new();
    for manual in args.suites.load_one(args.manual.as_deref())? {
        let covering = covering(&manual);
        let open: Vec<_> = manual
            .requirements
            .iter()
            .zip(&covering)
            .filter(|(of, _)| of.ambiguity.is_some() || matches!(of.class, Class::Contradictory(_)))
            .collect();
        // Writing into a String cannot fail.
        let _ = writeln!(out, "{}: {} of {} requirements", manual.device.name, open.len(), manual.requirements.len());
        let mut clause = "";
        for (of, cases) in open {
            if clause != of.cites {
                clause = &of.cites;
                let _ = writeln!(out, "\n{clause}");
            }
            let _ = writeln!(out, "  {} ({})\n    {}", of.id, level(of.level), of.statement);
            if let Some(ambiguity) = &of.ambiguity {
                let _ = writeln!(out, "    open: {ambiguity}");
            }
            if let Class::Contradictory(reading) = &of.class {
                let _ = writeln!(out, "    contradictory; read as: {reading}");
            }
            for case in cases {
                let _ = writeln!(out, "    tested by {}/{case}", manual.device.name);
            }
        }
        out.push('\n');
    }
    show(&out);
    Ok(ExitStatus::Green)
}

/// As JSON for people and programs.
pub(super) fn pretty(value: &impl Serialize) -> String {
    // The types that are shown have text keys and finite numbers only, so writing them cannot fail.
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}
