//! Which of the permitted variations of a reference device makes a trial fail: the reading of the manual that the suite does not know.

use super::dut::{DutKind, DutSpec};
use super::one_trial::run_described;
use super::options::RunOptions;
use super::outcome::TrialOutcome;
use deviations::{Deviation, DeviationKind};
use results::verdict::Verdict;
use suite::model::{Manual, SuiteVariant, Trial};

/// Returns a note that names the variations without which the trial would not have failed; `None` if it passed, if the device has no
/// variation, or if it fails without them too.
///
/// Of a combination the note names one variation that fails alone, or else a subset of which none can be left out.
pub(super) fn likely_reading(
    manual: &Manual,
    variant: &SuiteVariant,
    dut: &DutSpec,
    trial: &Trial,
    (outcome, options): (&TrialOutcome, &RunOptions),
) -> Option<String> {
    if !has_failed(outcome) || dut.variations().is_empty() {
        return None;
    }
    let subject = dut.model().ok()?;
    let names = dut.variations();
    let mut varied: Vec<&Deviation> = names.iter().filter_map(|name| subject.variations_of(name)).flatten().collect();
    let options = RunOptions { evidence: None, record: None, ..options.clone() };
    let fails = |varied: &[&Deviation]| {
        let deviations = dut.bugs().into_iter().chain(varied.iter().map(|known| known.name.to_owned())).collect();
        let kind = match &dut.kind {
            DutKind::External { model, variant, .. } => {
                DutKind::External { model, variant: variant.clone(), deviations }
            }
            DutKind::Model { .. } | DutKind::Null(_) | DutKind::Live(_) => DutKind::Model { deviations },
        };
        let dut = DutSpec { kind, ..dut.clone() };
        run_described(manual, variant, &dut, trial, &options).is_ok_and(|outcome| has_failed(&outcome))
    };
    if fails(&[]) {
        return None;
    }
    if let Some(alone) = varied.iter().find(|one| fails(&[one])).copied() {
        varied = vec![alone];
    }
    for at in (0..varied.len()).rev() {
        let mut fewer = varied.clone();
        fewer.remove(at);
        if !fewer.is_empty() && fails(&fewer) {
            varied = fewer;
        }
    }
    let described: Vec<String> = varied.iter().copied().map(describe).collect();
    Some(format!("likely reading: {}", described.join(" And: ")))
}

fn describe(of: &Deviation) -> String {
    let DeviationKind::Permitted { clause } = of.kind else { return of.sentence.to_owned() };
    format!("{} {} Permitted: {clause}.", of.name, of.sentence)
}

fn has_failed(outcome: &TrialOutcome) -> bool {
    outcome.case.verdict != Verdict::Pass || outcome.rules.iter().any(|rule| rule.broken.is_some())
}
