//! The ledger of known failures: which tests may fail, on which device, why, until when, and how.
//!
//! An entry excuses exactly the failure that it describes. A test that passes, fails in another way, or outlives its entry is
//! not green, and neither is an entry that matches nothing. This room must not know engines and reports; the day is given.

mod date;
mod entry;

pub use date::Date;
pub use entry::{Entry, Ledger, LedgerError};

use crate::outcome::{CaseResult, DeviceRun, Dut, Failure, LedgerNote, RunResult};
use crate::verdict::{Verdict, worse};
use std::fmt::Write as _;

/// What a failure is recognised by: its step, and the first part of the condition that did not hold.
///
/// It says nothing of the values that were seen, which differ from run to run on a live device. A failure without a condition
/// is recognised by its sentence; an entry may have `*` for what changes in it.
pub fn signature(failure: &Failure) -> String {
    let part = failure.parts.iter().find(|part| !part.held).map_or(&failure.what, |part| &part.text);
    format!("{} | {part}", failure.step)
}

/// The entry that would make `failure` of `case` a known one, as YAML; three values are left to the author.
pub fn entry(run: &DeviceRun, case: &CaseResult, failure: &Failure) -> String {
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let test = case.id.strip_prefix(&format!("{}/", run.dut.device)).unwrap_or(&case.id);
    let mut out = String::new();
    // Writing into a String cannot fail.
    let _ = write!(
        out,
        "- test: {}\n  device: {}\n  variant: {}\n  reason: ...\n  ticket: ...\n  expires: YYYY-MM-DD\n  signature: {}\n",
        quoted(test),
        run.dut.device,
        run.dut.variant,
        quoted(&signature(failure)),
    );
    out
}

/// Applies the ledger to what was found: failures become `xfail`, passes `xpass`, and notes say what is wrong with it.
pub fn apply(ledger: &Ledger, result: &mut RunResult, today: Date) {
    let mut matched = vec![false; ledger.entries.len()];
    let mut meant = vec![false; ledger.entries.len()];
    for run in &mut result.runs {
        for (index, entry) in ledger.entries.iter().enumerate() {
            match applies(entry, &run.dut) {
                Some(applies) => meant[index] |= applies && !run.filtered,
                None => result.ledger_notes.push(LedgerNote {
                    text: format!(
                        "{} is for some firmware only, and {} did not say its own.",
                        entry.name(),
                        run.dut.spec
                    ),
                    red: false,
                }),
            }
        }
        let device = run.dut.device.clone();
        let mut changed = false;
        for case in &mut run.cases {
            let entries: Vec<&Entry> = ledger
                .entries
                .iter()
                .enumerate()
                .filter(|(_, entry)| applies(entry, &run.dut) == Some(true) && entry.names(&device, &case.id))
                .map(|(index, entry)| {
                    matched[index] = true;
                    entry
                })
                .collect();
            if !entries.is_empty() {
                changed |= judge(case, &entries, today);
            }
        }
        if changed {
            settle(run);
        }
    }
    for (entry, (matched, meant)) in ledger.entries.iter().zip(matched.into_iter().zip(meant)) {
        if meant && !matched {
            result.ledger_notes.push(note(format!("{} matches no test: take it out or correct it.", entry.name())));
        } else if matched && today > entry.expires {
            result.ledger_notes.push(note(format!("{} expired on {}.", entry.name(), entry.expires)));
        }
    }
}

fn note(text: String) -> LedgerNote {
    LedgerNote { text, red: true }
}

/// Whether the entry is for this device; unknown where it asks for a firmware that the device did not name.
fn applies(entry: &Entry, dut: &Dut) -> Option<bool> {
    if entry.device != dut.device || entry.variant.as_ref().is_some_and(|variant| *variant != dut.variant) {
        return Some(false);
    }
    match (&entry.firmware, &dut.firmware) {
        (None, _) => Some(true),
        (Some(range), Some(firmware)) => Some(range.contains(firmware)),
        (Some(_), None) => None,
    }
}

/// Judges a case that entries name; says whether its verdict is another one now.
fn judge(case: &mut CaseResult, entries: &[&Entry], today: Date) -> bool {
    let (valid, expired): (Vec<&Entry>, Vec<&Entry>) =
        entries.iter().copied().partition(|entry| today <= entry.expires);
    let verdict = match case.verdict {
        Verdict::Pass => {
            let Some(entry) = valid.first() else { return false };
            case.reason = Some(format!("It passes, though {} expects a failure: take the entry out.", entry.name()));
            Verdict::Xpass
        }
        Verdict::Fail => {
            let known = |failure: &Failure| valid.iter().find(|entry| entry.describes(&signature(failure)));
            let all: Option<Vec<_>> = case.failures.iter().map(known).collect();
            match all.as_deref() {
                Some([entry, ..]) => {
                    case.reason = Some(format!("known failure {}: {}", entry.ticket, entry.reason));
                    Verdict::Xfail
                }
                _ => {
                    case.notes.extend(expired.iter().map(|entry| {
                        format!("{} excused this until {} and does so no longer.", entry.name(), entry.expires)
                    }));
                    let other = case.failures.iter().find(|failure| known(failure).is_none());
                    if let (Some(entry), Some(other)) = (valid.first(), other) {
                        let seen = signature(other);
                        case.notes.push(format!("It fails in another way than {} says: {seen}", entry.name()));
                    }
                    return false;
                }
            }
        }
        _ => return false,
    };
    for covered in case.covers.iter_mut().filter(|covered| covered.verdict == case.verdict) {
        covered.verdict = verdict;
    }
    case.verdict = verdict;
    true
}

/// Judges the requirements again after verdicts of cases have changed.
fn settle(run: &mut DeviceRun) {
    for of in &mut run.requirements {
        let said = run.cases.iter().flat_map(|case| &case.covers).filter(|covered| covered.id == of.id);
        if let Some(worst) = said.map(|covered| covered.verdict).reduce(worse) {
            of.verdict = worst;
        }
    }
}
