//! Computes the verdict of each requirement from the results of the cases.

use results::outcome::{CaseResult, Covered, RequirementResult};
use results::verdict::Verdict;
pub use results::verdict::worse;
use suite::model::{Level, Manual, RequirementClass, SuiteVariant};

/// The requirements that apply to a variant, in the order of the manual, with the worst verdict of their cases.
pub fn results(manual: &Manual, variant: &SuiteVariant, cases: &[CaseResult]) -> Vec<RequirementResult> {
    let number = manual.variants.iter().position(|known| known.name == variant.name).unwrap_or_default();
    let result = |(index, of): (usize, &suite::model::Requirement)| {
        let mut verdict = None;
        let mut names = Vec::new();
        let mut unjudged = Vec::new();
        for case in cases {
            for covered in case.covers.iter().filter(|covered| covered.requirement == index) {
                verdict = Some(verdict.map_or(covered.verdict, |verdict| worse(verdict, covered.verdict)));
                names.push(case.id.clone());
                if case.verdict == Verdict::Fail && covered.verdict == Verdict::NotRun {
                    unjudged.push(case.id.as_str());
                }
            }
        }
        let note = match (&of.class, verdict) {
            (_, Some(Verdict::NotRun)) if !unjudged.is_empty() => {
                Some(format!("not judged in a case that failed before: {}", unjudged.join(", ")))
            }
            (_, Some(_)) => None,
            (RequirementClass::Testable | RequirementClass::Contradictory(_), None) => {
                Some("no case covers it in this run".to_owned())
            }
            (RequirementClass::Implicit(why), None) => Some(format!("implicit: {why}")),
            (RequirementClass::Untestable(why), None) => Some(format!("untestable: {why}")),
            (RequirementClass::NoCheck(why), None) => Some(format!("no check yet: {why}")),
            (RequirementClass::OutOfScope(why), None) => Some(format!("out of scope: {why}")),
        };
        RequirementResult {
            id: of.id.clone(),
            chapter: manual.suite_of_requirement(index).map(|suite| suite.name.clone()).or_else(|| of.chapter()),
            cites: of.cites.clone(),
            statement: of.statement.clone(),
            level: of.level,
            verdict: verdict.unwrap_or(Verdict::NotRun),
            note,
            cases: names,
        }
    };
    let applies = |(_, of): &(usize, &suite::model::Requirement)| of.variants.contains(&number);
    manual.requirements.iter().enumerate().filter(applies).map(result).collect()
}

/// The level of a result: the highest level of the requirements that have its verdict, else of all that it covers. What a failed case
/// did not judge counts as well, so that it stays red at the gate of that level.
pub fn level(manual: &Manual, covers: &[Covered], verdict: Verdict) -> Level {
    let of = |covered: &Covered| manual.requirements[covered.requirement].level;
    let is_open = |covered: &&Covered| {
        covered.verdict == verdict || (verdict == Verdict::Fail && covered.verdict == Verdict::NotRun)
    };
    let failed = covers.iter().filter(is_open).map(of).min();
    failed.or_else(|| covers.iter().map(of).min()).unwrap_or(Level::Must)
}
