//! The ledger of known failures: which tests may fail on which device, with which signature, why, and until when.
//!
//! An entry excuses exactly the failure that it describes. The run fails if a test with an entry passes, fails with another
//! signature or after the entry expired, and if an entry matches no test. The caller passes the current day.

mod date;
mod entry;
pub mod keys;

pub use date::Date;
pub use entry::{Ledger, LedgerEntry, LedgerError};

use crate::outcome::{CaseFailure, CaseResult, DeviceRun, Dut, LedgerNote, RunResult};
use crate::verdict::{Verdict, worse};
use std::fmt::Write as _;

/// The signature of a failure: its step and the first part of the condition that failed.
///
/// It does not contain observed values, since these differ between runs on a live device. The signature of a failure without a
/// condition contains its sentence; an entry can have `*` for the variable parts.
pub fn signature(failure: &CaseFailure) -> String {
    let part = failure.parts.iter().find(|part| !part.held).map_or(&failure.what, |part| &part.text);
    format!("{} | {part}", failure.step)
}

/// A ledger entry for `failure` of `case` as YAML; reason, ticket and expiry are placeholders.
pub fn entry(run: &DeviceRun, case: &CaseResult, failure: &CaseFailure) -> String {
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

/// Applies the ledger to the results: known failures become `xfail`, unexpected passes `xpass`; adds notes about its entries.
pub fn apply(ledger: &Ledger, result: &mut RunResult, today: Date) {
    let mut matched = vec![false; ledger.entries.len()];
    let mut meant = vec![false; ledger.entries.len()];
    let is_plain_part = result.part.is_some() && result.filters.is_empty();
    for run in &mut result.runs {
        for (index, entry) in ledger.entries.iter().enumerate() {
            match applies(entry, &run.dut) {
                Some(applies) => meant[index] |= applies && (!run.filtered || is_plain_part),
                None => result.ledger_notes.push(LedgerNote {
                    text: format!(
                        "{} applies to certain firmware versions only, and {} did not report its firmware.",
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
            let entries: Vec<&LedgerEntry> = ledger
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
            update_requirements(run);
        }
    }
    for (entry, (matched, meant)) in ledger.entries.iter().zip(matched.into_iter().zip(meant)) {
        if meant && !matched && is_plain_part {
            result.unmatched_entries.push(entry.name());
        } else if meant && !matched {
            result.ledger_notes.push(note(unmatched(&entry.name())));
        } else if matched && today > entry.expires {
            result.ledger_notes.push(note(format!("{} expired on {}.", entry.name(), entry.expires)));
        }
    }
}

/// What is said of an entry that matches no test of a whole run.
pub(crate) fn unmatched(name: &str) -> String {
    format!("{name} matches no test: correct or remove it.")
}

fn note(text: String) -> LedgerNote {
    LedgerNote { text, red: true }
}

/// Whether the entry applies to this device; `None` if it requires a firmware and the device did not report its firmware.
fn applies(entry: &LedgerEntry, dut: &Dut) -> Option<bool> {
    if entry.device != dut.device || entry.variant.as_ref().is_some_and(|variant| *variant != dut.variant) {
        return Some(false);
    }
    match (&entry.firmware, &dut.firmware) {
        (None, _) => Some(true),
        (Some(range), Some(firmware)) => Some(range.contains(firmware)),
        (Some(_), None) => None,
    }
}

/// Applies the entries that name a case to its verdict; returns whether the verdict changed.
fn judge(case: &mut CaseResult, entries: &[&LedgerEntry], today: Date) -> bool {
    let (valid, expired): (Vec<&LedgerEntry>, Vec<&LedgerEntry>) =
        entries.iter().copied().partition(|entry| today <= entry.expires);
    let verdict = match case.verdict {
        Verdict::Pass => {
            let Some(entry) = valid.first() else { return false };
            case.reason = Some(format!("The test passes, but {} expects a failure: remove the entry.", entry.name()));
            Verdict::Xpass
        }
        Verdict::Fail => {
            let known = |failure: &CaseFailure| valid.iter().find(|entry| entry.describes(&signature(failure)));
            let all: Option<Vec<_>> = case.failures.iter().map(known).collect();
            match all.as_deref() {
                Some([entry, ..]) => {
                    case.reason = Some(format!("known failure {}: {}", entry.ticket, entry.reason));
                    Verdict::Xfail
                }
                _ => {
                    case.notes.extend(expired.iter().map(|entry| {
                        format!("{} excused this failure until {} and has expired.", entry.name(), entry.expires)
                    }));
                    let other = case.failures.iter().find(|failure| known(failure).is_none());
                    if let (Some(entry), Some(other)) = (valid.first(), other) {
                        let observed = signature(other);
                        case.notes.push(format!(
                            "This is not the failure that {} describes. Signature: {observed}",
                            entry.name()
                        ));
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

/// Computes the verdicts of the requirements again after verdicts of cases have changed.
pub(crate) fn update_requirements(run: &mut DeviceRun) {
    for of in &mut run.requirements {
        let said = run.cases.iter().flat_map(|case| &case.covers).filter(|covered| covered.id == of.id);
        if let Some(worst) = said.map(|covered| covered.verdict).reduce(worse) {
            of.verdict = worst;
        }
    }
}
