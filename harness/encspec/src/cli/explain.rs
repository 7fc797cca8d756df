//! `encspec explain ID`: explains a requirement, case, rule, bug or protocol check.

use super::coverage::{class, covering};
use super::list::{ListedCase, everything};
use super::{CommandError, CommandResult, ExplainArgs, show};
use deviations::persona_bugs;
use plain_text::nearest;
use replay::{CHECKS, ProtocolCheck};
use report::{ExitStatus, level};
use std::fmt::Write as _;
use suite::model::{
    BlockObservation, Bug, Manual, Requirement, RequirementClass, RequirementSource, Trial, TrialStep, Verb,
};

pub(super) fn explain(args: &ExplainArgs) -> CommandResult {
    let manuals = args.suites.load()?;
    let mut out = String::new();
    for manual in &manuals {
        explain_in_manual(&mut out, manual, &args.id);
    }
    if let Some(of) = persona_bugs().find(|of| of.name == args.id) {
        // Writing into a String cannot fail.
        let _ = writeln!(out, "bug {}\n  {}\n", of.name, of.sentence);
        let _ = writeln!(out, "  a field bug: no manual lists it, and only the persona of another controller shows it");
        let _ = writeln!(
            out,
            "  try it     encspec run --bug {} --persona NAME; `encspec personas` lists the personas",
            of.name
        );
    }
    if let Some(check) = ProtocolCheck::by_id(&args.id) {
        let _ = writeln!(out, "check {}\n  {}\n", check.id, check.sentence);
        let _ = writeln!(out, "  cause      {}", check.cause);
        let _ = writeln!(out, "  next       {}", check.next);
        let _ = writeln!(out, "  try it     encspec replay CAPTURE (needs no manual)");
    }
    if out.is_empty() {
        let field_bugs = persona_bugs().map(|of| of.name.to_owned());
        let checks = CHECKS.iter().map(|check| check.id.to_owned());
        let known: Vec<String> = manuals.iter().flat_map(explainable_ids).chain(field_bugs).chain(checks).collect();
        let meant = nearest(&args.id, known.iter().map(String::as_str)).map_or_else(
            || "`encspec list` and `encspec bugs` list ids and names".to_owned(),
            |meant| format!("did you mean `{meant}`?"),
        );
        return Err(CommandError::usage(format!(
            "there is no requirement, case, rule, bug or check `{}`; {meant}",
            args.id
        )));
    }
    show(&out);
    Ok(ExitStatus::Green)
}

/// All ids and names in a manual that can be explained.
fn explainable_ids(manual: &Manual) -> Vec<String> {
    let requirements = manual.requirements.iter().map(|of| of.id.clone());
    let bugs = manual.bugs.iter().map(|of| of.name.clone());
    let cases = everything(manual).into_iter().flat_map(|case| names(&case.id));
    requirements.chain(bugs).chain(cases).collect()
}

/// The accepted forms of a case id: in full, without the manual, without the row, and the last part alone.
fn names(id: &str) -> Vec<String> {
    let short = id.split_once('/').map_or(id, |(_, short)| short);
    let without_row = |id: &str| id.split_once('[').map_or(id, |(case, _)| case).to_owned();
    let last = short.split_once('/').map_or(short, |(_, last)| last);
    vec![id.to_owned(), short.to_owned(), without_row(id), without_row(short), last.to_owned(), without_row(last)]
}

fn explain_in_manual(out: &mut String, manual: &Manual, id: &str) {
    if let Some((index, of)) = manual.requirements.iter().enumerate().find(|(_, of)| of.id.eq_ignore_ascii_case(id)) {
        requirement(out, manual, index, of);
    }
    if let Some(of) = manual.bugs.iter().find(|of| of.name == id) {
        bug(out, manual, of);
    }
    for case in everything(manual).iter().filter(|case| names(&case.id).iter().any(|name| name == id)) {
        explain_case(out, manual, case);
    }
}

// Writing into a String cannot fail, so the results of `write!` are ignored below.

fn requirement(out: &mut String, manual: &Manual, index: usize, of: &Requirement) {
    let cases = covering(manual).get(index).cloned().unwrap_or_default();
    let source = match of.source {
        RequirementSource::Manual => "manual",
        RequirementSource::Profile => "profile",
        RequirementSource::Convention => "convention",
    };
    let _ = writeln!(out, "requirement {}\n  {}\n", of.id, of.statement);
    let _ = writeln!(out, "  manual     {} ({})", manual.device.title, manual.device.name);
    let _ = writeln!(out, "  clause     {}", of.cites);
    let _ = writeln!(out, "  level      {}", level(of.level));
    let _ = writeln!(out, "  source     {source}");
    let _ = writeln!(out, "  channel    {}", of.channel);
    let _ = write!(out, "  class      {}", class(&of.class, !cases.is_empty()));
    match &of.class {
        RequirementClass::Testable => out.push('\n'),
        RequirementClass::Implicit(why)
        | RequirementClass::Untestable(why)
        | RequirementClass::OutOfScope(why)
        | RequirementClass::NoCheck(why)
        | RequirementClass::Contradictory(why) => {
            let _ = writeln!(out, ": {why}");
        }
    }
    if of.variants.len() < manual.device.variants.len() {
        let variants: Vec<&str> =
            of.variants.iter().filter_map(|&index| manual.device.variants.get(index)).map(String::as_str).collect();
        let _ = writeln!(out, "  variants   {}", variants.join(", "));
    }
    if let Some(ambiguity) = &of.ambiguity {
        let _ = writeln!(out, "  ambiguity  {ambiguity}");
    }
    if let Some(suite) = manual.suite_of_requirement(index) {
        let _ = writeln!(out, "  suite      {}, which this manual uses too", suite.name);
    }
    for case in &cases {
        let _ = writeln!(out, "  covered by {}/{case}", manual.device.name);
    }
    for bug in manual.bugs.iter().filter(|bug| bug.breaks.contains(&index)) {
        let _ = writeln!(out, "  broken by  {}: {}", bug.name, bug.why);
    }
    let _ = writeln!(out, "  written    {}:{}\n", of.at.file.display(), of.at.line);
}

fn bug(out: &mut String, manual: &Manual, of: &Bug) {
    let _ = writeln!(out, "bug {}\n  {}\n", of.name, of.why);
    for broken in of.breaks.iter().filter_map(|&index| manual.requirements.get(index)) {
        let _ = writeln!(out, "  breaks     {}, {}\n             {}", broken.id, broken.cites, broken.statement);
    }
    for case in everything(manual).iter().filter(|case| case.catches.contains(&of.name)) {
        let _ = writeln!(out, "  caught by  {}", case.id);
    }
    let _ = writeln!(out, "  try it     encspec run --dut model:{} --bug {}", manual.device.name, of.name);
    let _ = writeln!(out, "  written    {}:{}\n", of.at.file.display(), of.at.line);
}

fn explain_case(out: &mut String, manual: &Manual, case: &ListedCase) {
    let _ = writeln!(out, "{} {}\n  {}\n", case.kind, case.id, case.why);
    let _ = writeln!(out, "  variants   {}", case.variants.join(", "));
    for id in &case.covers {
        if let Some(of) = manual.requirements.iter().find(|of| of.id == *id) {
            let _ = writeln!(
                out,
                "  covers     {} ({}), {}\n             {}",
                of.id,
                level(of.level),
                of.cites,
                of.statement
            );
        }
    }
    for name in &case.catches {
        let why = manual.bugs.iter().find(|bug| bug.name == *name).map_or("", |bug| &bug.why);
        let _ = writeln!(out, "  catches    {name}: {why}");
    }
    if let Some(suite) = &case.suite {
        let _ = writeln!(
            out,
            "  suite      {suite}, which this manual uses too; its own reference device proves that the case can fail"
        );
    }
    let _ = writeln!(out, "  written    {}", case.at);
    let id = case.id.split_once('/').map_or(case.id.as_str(), |(_, id)| id);
    let trial = manual.variants.iter().flat_map(|variant| &variant.trials).find(|trial| trial.id == id);
    if let (Some(trial), "case") = (trial, case.kind) {
        write_trial(out, manual, trial);
    }
    out.push('\n');
}

fn write_trial(out: &mut String, manual: &Manual, trial: &Trial) {
    let module = trial.start().map(|start| manual.device.modules.get(start.module).map_or("", |of| &of.name));
    let _ = writeln!(out, "  start      {}", module.unwrap_or("none"));
    for (title, steps) in
        [("given", &trial.how().given), ("steps", &trial.how().steps), ("finally", &trial.how().finally)]
    {
        if !steps.is_empty() {
            let _ = writeln!(out, "  {title}");
            write_steps(out, steps, 4);
        }
    }
}

fn write_steps(out: &mut String, steps: &[TrialStep], indent: usize) {
    for step in steps {
        let _ = writeln!(out, "{:indent$}- {}", "", step.text);
        match &step.verb {
            Verb::Block { steps, observe, .. } => {
                for rule in observe {
                    let (BlockObservation::Rule { text, .. }
                    | BlockObservation::Count { text, .. }
                    | BlockObservation::Sequence { text, .. }) = rule;
                    let _ = writeln!(out, "{:indent$}    observed: {text}", "");
                }
                write_steps(out, steps, indent + 4);
            }
            Verb::Either(readings) => {
                for reading in readings {
                    let _ = writeln!(out, "{:indent$}  {}:", "", reading.name);
                    write_steps(out, &reading.steps, indent + 4);
                }
            }
            _ => {}
        }
    }
}
