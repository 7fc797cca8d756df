//! `encspec attribution`: measures whether a failure names the requirement that is broken.

use super::coverage::{columns, share};
use super::{AttributionArgs, CommandError, CommandResult, show};
use crate::attribution::bugs::{BugEffect, ForeignFailure, percentile};
use crate::attribution::shared::SharedRequirements;
use crate::attribution::{BEYOND_GOALS, SHARED_GOAL};
use plain_text::count;
use report::ExitStatus;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use suite::model::{Bug, Manual};

/// How many failing steps are listed for all bugs.
const STEPS: usize = 25;

pub(super) fn attribution(args: &AttributionArgs) -> CommandResult {
    let manuals = args.suites.load_one(args.manual.as_deref())?;
    let known = |name: &String| manuals.iter().any(|manual| manual.bugs.iter().any(|bug| bug.name == *name));
    if let Some(unknown) = args.bug.iter().find(|name| !known(name)) {
        return Err(CommandError::usage(format!("no manual has a bug `{unknown}`; `encspec bugs` lists them")));
    }
    for manual in &manuals {
        if args.bug.is_empty() {
            show(&shared_text(manual));
        }
        if args.bugs || !args.bug.is_empty() {
            let is_meant = |bug: &&Bug| args.bug.is_empty() || args.bug.contains(&bug.name);
            let effects = manual.bugs.iter().filter(is_meant).map(|bug| BugEffect::of(manual, bug, args.threads));
            let effects = effects.collect::<Result<Vec<_>, _>>();
            let effects = effects.map_err(|error| CommandError::bench(error.to_string()))?;
            show(&effects_text(manual, &effects, !args.bug.is_empty()));
        }
    }
    Ok(ExitStatus::Green)
}

fn id(manual: &Manual, requirement: usize) -> String {
    manual.requirements.get(requirement).map_or_else(String::new, |of| of.id.clone())
}

fn with_level(manual: &Manual, requirement: usize) -> String {
    let level = manual.requirements.get(requirement).map_or("", |of| report::level(of.level));
    format!("{} ({level})", id(manual, requirement))
}

fn shared_text(manual: &Manual) -> String {
    let shared = SharedRequirements::of(manual);
    let mut out = String::new();
    // Writing into a String cannot fail.
    let _ = writeln!(
        out,
        "{}: {} of {} requirements have no check of their own ({:.1} %, goal {SHARED_GOAL} %), in {}",
        manual.device.name,
        shared.shared(),
        manual.requirements.len(),
        shared.percent(manual),
        count(shared.groups.len(), "group", "groups")
    );
    for group in &shared.groups {
        let ids: Vec<String> = group.requirements.iter().map(|&of| with_level(manual, of)).collect();
        let _ = writeln!(out, "  {}", ids.join(", "));
        group.units.iter().for_each(|unit| {
            let _ = writeln!(out, "    {unit}");
        });
    }
    let _ = writeln!(out, "  judged as one, with several levels: {}", shared.mixed.len());
    for mixed in &shared.mixed {
        let ids: Vec<String> = mixed.requirements.iter().map(|&of| with_level(manual, of)).collect();
        let _ = writeln!(out, "    {}: {}", mixed.unit, ids.join(", "));
    }
    out
}

fn effects_text(manual: &Manual, effects: &[BugEffect<'_>], in_full: bool) -> String {
    let mut out = String::new();
    let (whole, single): (Vec<&BugEffect<'_>>, Vec<&BugEffect<'_>>) =
        effects.iter().partition(|effect| effect.is_of_whole_telegram());
    let numbers: Vec<usize> = single.iter().map(|effect| effect.beyond.len()).collect();
    let mean = numbers.iter().sum::<usize>() as f64 / numbers.len().max(1) as f64;
    let (half, most) = BEYOND_GOALS;
    // Writing into a String cannot fail.
    let _ = writeln!(
        out,
        "{}: {} fail beyond `breaks` by the median {} requirements (goal {half}), at the 90th percentile {} (goal {most}), \
         mean {mean:.1}; {} of whole telegrams apart",
        manual.device.name,
        count(single.len(), "bug", "bugs"),
        percentile(&numbers, 50),
        percentile(&numbers, 90),
        whole.len()
    );
    let causes = || effects.iter().flat_map(|effect| &effect.causes).filter(|cause| cause.size.1 > 1);
    let first = causes().filter(|cause| cause.is_first).count();
    let begins = causes().filter(|cause| cause.begins).count();
    let _ = writeln!(
        out,
        "  of {} reports with several failures the first group has a broken requirement in {first} ({}), and begins with it in \
         {begins} ({})",
        causes().count(),
        share(first, causes().count()),
        share(begins, causes().count())
    );
    let mut sorted: Vec<&BugEffect<'_>> = effects.iter().collect();
    sorted.sort_by_key(|effect| std::cmp::Reverse(effect.beyond.len()));
    for effect in &sorted {
        let (failed, judged) = effect.trials;
        let apart = if effect.is_of_whole_telegram() { ", whole telegram" } else { "" };
        let bug = &effect.bug.name;
        let _ = writeln!(
            out,
            "  {bug}: {} beyond `breaks`; {failed} of {judged} judged trials fail{apart}",
            effect.beyond.len()
        );
        for cause in effect.causes.iter().filter(|cause| cause.size.1 > 1 && (in_full || !cause.begins)) {
            let (first, all) = cause.size;
            let what = if !cause.is_first {
                "FIRST GROUP IS ANOTHER"
            } else if !cause.begins {
                "begins with another"
            } else {
                "begins with it"
            };
            let _ = writeln!(out, "    {what}: {first} of {all} failures, {} groups: {}", cause.groups, cause.text);
        }
        if !effect.missed.is_empty() {
            let missed: Vec<String> = effect.missed.iter().map(|&of| id(manual, of)).collect();
            let _ = writeln!(out, "    DOES NOT FAIL: {}", missed.join(", "));
        }
        if effect.breaks_no_must(manual) && effect.musts(manual).next().is_some() {
            let musts: Vec<String> = effect.musts(manual).map(|of| id(manual, of)).collect();
            let _ = writeln!(out, "    BREAKS NO MUST, BUT THESE FAIL:");
            columns(&mut out, &musts);
        }
        if in_full {
            for (&of, failures) in &effect.beyond {
                let _ = writeln!(out, "    {}", with_level(manual, of));
                let mut listed: Vec<&ForeignFailure> = Vec::new();
                for failure in failures {
                    if !listed.iter().any(|known| known.step == failure.step) {
                        listed.push(failure);
                        let _ = writeln!(out, "      {}\n        {}", failure.case, failure.step);
                    }
                }
            }
        }
    }
    if !in_full {
        steps(&mut out, &single);
    }
    out
}

/// The steps that fail most requirements that their bug does not break.
fn steps(out: &mut String, effects: &[&BugEffect<'_>]) {
    let mut steps: BTreeMap<&str, (usize, &str)> = BTreeMap::new();
    for failures in effects.iter().flat_map(|effect| effect.beyond.values()) {
        let mut counted: Vec<&str> = Vec::new();
        for failure in failures {
            if !counted.contains(&failure.step.as_str()) {
                counted.push(&failure.step);
                steps.entry(&failure.step).or_insert((0, &failure.case)).0 += 1;
            }
        }
    }
    let mut steps: Vec<(&str, (usize, &str))> = steps.into_iter().collect();
    steps.sort_by_key(|(_, (number, _))| std::cmp::Reverse(*number));
    let _ = writeln!(out, "  steps that fail most requirements that their bug does not break:");
    for (step, (number, case)) in steps.into_iter().take(STEPS) {
        let _ = writeln!(out, "    {number:>5}  {step}\n           for instance in {case}");
    }
}
