//! `encspec bugs`: lists the bugs of the reference devices and the requirements that they break.

use super::coverage::{columns, share};
use super::list::{ListedCase, everything, json};
use super::{BugsArgs, CommandError, CommandResult, ListingFormat, show};
use plain_text::count;
use report::ExitStatus;
use serde::Serialize;
use std::fmt::Write as _;
use suite::model::{Bug, Manual};

pub(super) fn bugs(args: &BugsArgs) -> CommandResult {
    let manuals = args.suites.load_one(args.manual.as_deref())?;
    let listed: Vec<ManualBugs<'_>> =
        manuals.iter().map(|manual| ManualBugs::of(manual, args.filter.as_deref())).collect();
    if let Some(filter) = &args.filter
        && listed.iter().all(|of| of.bugs.is_empty())
    {
        return Err(CommandError::usage(format!(
            "no bug name contains `{filter}`, and no bug breaks a requirement `{filter}`"
        )));
    }
    match args.format {
        ListingFormat::Json => show(&json(listed)),
        ListingFormat::Text => show(&listed.iter().map(|of| of.text(args.filter.is_some())).collect::<String>()),
    }
    Ok(ExitStatus::Green)
}

/// The bugs of one manual. The counts are those of the whole manual, independent of the filter.
#[derive(Debug, Serialize)]
struct ManualBugs<'a> {
    id: &'a str,
    /// Number of requirements of the manual.
    requirements: usize,
    /// Number of requirements that at least one bug breaks.
    broken: usize,
    /// Ids of the requirements that no bug breaks.
    unbroken: Vec<String>,
    bugs: Vec<ListedBug<'a>>,
}

#[derive(Debug, Serialize)]
struct ListedBug<'a> {
    name: &'a str,
    why: &'a str,
    breaks: Vec<BrokenRequirement<'a>>,
    /// Ids of the cases and rules that list the bug under `catches`.
    caught_by: Vec<String>,
}

#[derive(Debug, Serialize)]
struct BrokenRequirement<'a> {
    id: &'a str,
    clause: &'a str,
    statement: &'a str,
}

impl<'a> ManualBugs<'a> {
    fn of(manual: &'a Manual, filter: Option<&str>) -> ManualBugs<'a> {
        let cases = everything(manual);
        let is_broken = |index: &usize| manual.bugs.iter().any(|bug| bug.breaks.contains(index));
        let unbroken: Vec<String> = (0..manual.requirements.len())
            .filter(|index| !is_broken(index))
            .filter_map(|index| manual.requirements.get(index))
            .map(|of| of.id.clone())
            .collect();
        let bugs = manual.bugs.iter().map(|bug| ListedBug::of(manual, bug, &cases));
        ManualBugs {
            id: &manual.device.name,
            requirements: manual.requirements.len(),
            broken: manual.requirements.len() - unbroken.len(),
            unbroken,
            bugs: bugs.filter(|bug| filter.is_none_or(|filter| bug.is_meant(filter))).collect(),
        }
    }

    fn text(&self, filtered: bool) -> String {
        let ManualBugs { id, requirements, broken, unbroken, bugs } = self;
        let mut out = String::new();
        if filtered && bugs.is_empty() {
            return out;
        }
        // Writing into a String cannot fail.
        let _ = writeln!(
            out,
            "{id}: {}; {broken} of {requirements} requirements ({}) are broken by at least one bug",
            count(bugs.len(), "bug", "bugs"),
            share(*broken, *requirements)
        );
        for bug in bugs {
            bug.text(&mut out, filtered);
        }
        if !filtered && !unbroken.is_empty() {
            let _ = writeln!(out, "  not broken by any bug:");
            columns(&mut out, unbroken);
        }
        out
    }
}

impl<'a> ListedBug<'a> {
    fn of(manual: &'a Manual, bug: &'a Bug, cases: &[ListedCase]) -> ListedBug<'a> {
        let broken = bug.breaks.iter().filter_map(|&index| manual.requirements.get(index));
        let catching = cases.iter().filter(|case| case.catches.contains(&bug.name));
        ListedBug {
            name: &bug.name,
            why: &bug.why,
            breaks: broken
                .map(|of| BrokenRequirement { id: &of.id, clause: &of.cites, statement: &of.statement })
                .collect(),
            caught_by: catching.map(|case| case.id.clone()).collect(),
        }
    }

    /// Whether the filter is a part of the bug's name, or the id of a requirement that it breaks.
    fn is_meant(&self, filter: &str) -> bool {
        self.name.contains(filter) || self.breaks.iter().any(|of| of.id.eq_ignore_ascii_case(filter))
    }

    fn text(&self, out: &mut String, in_full: bool) {
        let _ = writeln!(out, "  {}", self.name);
        if !self.why.is_empty() {
            let _ = writeln!(out, "    {}", self.why);
        }
        if in_full {
            for of in &self.breaks {
                let _ = writeln!(out, "    breaks {}, {}\n           {}", of.id, of.clause, of.statement);
            }
        } else {
            let ids: Vec<&str> = self.breaks.iter().map(|of| of.id).collect();
            let _ = writeln!(out, "    breaks {}", ids.join(", "));
        }
        for case in &self.caught_by {
            let _ = writeln!(out, "    caught by {case}");
        }
    }
}
