//! The finding of a broken rule: its requirements and clauses, byte and bit, likely causes, and the next step.

use super::{CaptureFinding, FindingSeverity};
use judge::violation::RuleViolation;
use results::outcome::JudgedPart;
use suite::model::{Level, Manual, RuleBody, SuiteRule};

/// Upper limit of the known bugs that are named as likely causes.
const MOST_CAUSES: usize = 3;

/// The finding of a broken rule.
pub(crate) fn rule_finding(manual: &Manual, rule: &SuiteRule, violation: &RuleViolation) -> CaptureFinding {
    let covered: Vec<_> = rule.covers.iter().filter_map(|&index| manual.requirements.get(index)).collect();
    let requirements: Vec<_> = covered.iter().map(|of| (of.id.as_str(), of.cites.as_str())).collect();
    let severity = match covered.iter().map(|requirement| requirement.level).min() {
        Some(Level::Info) => FindingSeverity::Info,
        Some(Level::Must | Level::Should) | None => FindingSeverity::Error,
    };
    let missed = || violation.parts.iter().filter(|part| !part.held);
    let parts: Vec<String> =
        missed().map(|part| format!("{}: expected {}, observed {}", part.text, part.expected, part.observed)).collect();
    let since = violation.trigger.map_or(String::new(), |trigger| format!(" (after frame {})", trigger.frame));
    let text = format!("{} {}{since} [{}]; {}", rule.why.trim_end(), violation.how, rule.id, parts.join("; "));
    let list = |say: &dyn Fn(&JudgedPart) -> String| missed().map(say).collect::<Vec<_>>().join("; ");
    let id = format!("{}/{}", manual.device.name, rule.id);
    let finding = CaptureFinding::rule(id, &requirements, severity, violation.frame(), text.trim_end_matches("; "))
        .on(manual.device.bus.kind())
        .expected(list(&|part| match part.expected.as_str() {
            "true" => part.text.clone(),
            wanted => format!("{}: {wanted}", part.text),
        }))
        .observed(list(&|part| match part.expected.as_str() {
            "true" => values_of_false(&part.observed).to_owned(),
            _ => format!("{}: {}", part.text, part.observed),
        }))
        .cause(cause(manual, rule))
        .next(next(manual, rule, violation));
    match violation.place {
        Some((_, octet, bit)) => finding.at(octet, bit),
        None => finding,
    }
}

/// The values in `false (...)`.
fn values_of_false(observed: &str) -> &str {
    observed.strip_prefix("false (").and_then(|values| values.strip_suffix(')')).unwrap_or(observed)
}

/// Why a rule of this kind is broken, followed by the known bugs of the suites that break it.
fn cause(manual: &Manual, rule: &SuiteRule) -> String {
    let known: Vec<&str> = rule
        .catches
        .iter()
        .filter_map(|name| manual.bugs.iter().find(|bug| bug.name == *name))
        .map(|bug| bug.why.trim_end().trim_end_matches('.'))
        .take(MOST_CAUSES)
        .collect();
    let kind = match &rule.body {
        RuleBody::Always(_) => "The device sends values that its manual forbids",
        RuleBody::When { .. } => "The device reacts too late, not at all or not long enough",
    };
    if known.is_empty() {
        format!("{kind}.")
    } else {
        format!("{kind}. Known bugs with this symptom: {}.", known.join("; "))
    }
}

/// Where to look, and how to reproduce it.
fn next(manual: &Manual, rule: &SuiteRule, violation: &RuleViolation) -> String {
    let frame = violation.frame();
    let place = match violation.place {
        Some((_, octet, Some(bit))) => format!("byte {octet} bit {bit} of packet {frame}"),
        Some((_, octet, None)) => format!("packet {frame} from byte {octet}"),
        None => format!("packet {frame}"),
    };
    let since = violation.trigger.map_or(String::new(), |trigger| format!(" and packet {}", trigger.frame));
    let first = rule.covers.first().and_then(|&index| manual.requirements.get(index));
    let what = first.map_or_else(|| "the rule".to_owned(), |of| format!("{} (encspec explain {})", of.cites, of.id));
    let again = reproducer(manual, rule).map_or(String::new(), |case| {
        format!(" To reproduce it on a bench: encspec run {}/{case}.", manual.device.name)
    });
    format!("Compare {place}{since} with {what}. Report the deviation to the maker of the device.{again}")
}

/// A case that covers the same requirements, preferably one that also catches the same bugs.
fn reproducer<'m>(manual: &'m Manual, rule: &SuiteRule) -> Option<&'m str> {
    let trials = || manual.variants.iter().flat_map(|variant| &variant.trials);
    let covers = |of: &&suite::model::Trial| of.covers.iter().any(|covered| rule.covers.contains(covered));
    let catches = |of: &&suite::model::Trial| of.catches.iter().any(|bug| rule.catches.contains(bug));
    let trial = trials()
        .find(|trial| covers(trial) && catches(trial))
        .or_else(|| trials().find(covers))
        .or_else(|| trials().find(catches))?;
    Some(trial.case())
}
