//! Finds the shortest script on which a device differs from the reference device, and writes it as a case.
//!
//! It applies delta debugging to the steps (ddmin: Zeller and Hildebrandt, 2002), then to the contents of each step. A case is returned
//! only after it was loaded, passed on the reference device and failed on the other one. This module must not know frames.

use super::action::ControllerAction;
use super::capture::not_drivable;
use super::checks::{self, DifferenceChecks};
use super::compare::{Difference, DifferenceKind, compare};
use super::conversation::Conversation;
use super::drive::{CannotDrive, ScriptBench};
use super::masks::Masks;
use super::minimal::{fewest, one_less, simplest};
use super::report::related;
use super::script::script;
use super::shaft_dependence::{ShaftDependence, UNKNOWN};
use super::unseen::stand_scripts;
use super::write_case::{CaseLine, WrittenCase};
use engine::DutSpec;
use results::verdict::Verdict;
use std::collections::{BTreeSet, HashMap};
use std::time::Duration;
use suite::model::Bug;

/// Upper limit of the differences that are tried for a case.
const MOST_TARGETS: usize = 6;
/// The shaft position in a case that depends on it, in hardware steps.
const SHAFT: u32 = 0x1_2345;
/// Upper limit of the requirements that a written case covers.
const MOST_COVERED: usize = 3;

/// The two devices of a shrinking.
pub struct ShrinkPair<'a> {
    /// The reference device without bugs.
    pub reference: &'a DutSpec,
    /// The device that differs.
    pub dut: &'a DutSpec,
    /// The bug of the device, if it is a model with one.
    pub bug: Option<&'a Bug>,
}

/// The result of shrinking.
#[derive(Clone, Debug)]
pub enum ShrinkResult {
    /// A case that passes on the reference device and fails on the other one.
    Confirmed {
        case: WrittenCase,
        /// The name in which they differ.
        name: String,
        /// Number of steps of the controller side of the capture.
        before: usize,
        /// Number of runs.
        runs: usize,
    },
    /// The devices do not differ on the controller side of the capture.
    Same {
        /// Number of its steps.
        steps: usize,
    },
    /// The devices differ, but no case shows it.
    NoCase {
        /// Their differences.
        differences: Vec<Difference>,
    },
}

/// Shrinks the controller side of a capture.
pub fn shrink(
    bench: &ScriptBench<'_>,
    pair: &ShrinkPair<'_>,
    conversation: &Conversation,
    masks: &Masks,
) -> Result<ShrinkResult, CannotDrive> {
    let whole = script(conversation);
    let mut masks = masks.clone();
    if pair.dut.live().is_some() && not_drivable(conversation).is_none() {
        let follows = ShaftDependence::of(bench, pair.reference, conversation, &whole)?;
        masks.names.extend(follows.names().map(|name| (name, UNKNOWN.to_owned())));
    }
    let masks = &masks;
    if not_drivable(conversation).is_some() {
        return Ok(ShrinkResult::Same { steps: whole.len() });
    }
    let mut work = Shrinker { bench, pair, masks, runs: 0, known: HashMap::new() };
    let Some(DifferingScript { steps: whole, reference, differences }) = work.differing(whole, conversation)? else {
        return Ok(ShrinkResult::Same { steps: script(conversation).len() });
    };
    // Recorded differences come first.
    let recorded: BTreeSet<String> = compare(conversation, &reference, masks).into_iter().map(|of| of.name).collect();
    let mut targets: Vec<&Difference> = Vec::new();
    let (known, new): (Vec<_>, Vec<_>) = differences.iter().partition(|of| recorded.contains(&of.name));
    for difference in known.into_iter().chain(new) {
        if !targets.iter().any(|of| (of.kind, &of.name) == (difference.kind, &difference.name)) {
            targets.push(difference);
        }
    }
    for target in targets.into_iter().take(MOST_TARGETS) {
        let target = (target.kind, target.name.clone());
        let small = work.smallest(whole.clone(), &target)?;
        if let Some(case) = work.case(&small, &target)? {
            let case = work.shorter(case)?;
            return Ok(ShrinkResult::Confirmed { case, name: target.1, before: whole.len(), runs: work.runs });
        }
    }
    Ok(ShrinkResult::NoCase { differences })
}

/// The kind and the name of a difference.
type ShrinkTarget = (DifferenceKind, String);

/// A script on which two devices differ.
struct DifferingScript {
    steps: Vec<ControllerAction>,
    /// What the reference device answers.
    reference: Conversation,
    differences: Vec<Difference>,
}

struct Shrinker<'a, 'm> {
    bench: &'a ScriptBench<'m>,
    pair: &'a ShrinkPair<'a>,
    masks: &'a Masks,
    runs: usize,
    /// Whether a script still differs in a target.
    known: HashMap<(ShrinkTarget, Vec<ControllerAction>), bool>,
}

impl Shrinker<'_, '_> {
    /// A script on which the devices differ, with what the reference device answers: that of the capture, or else the same with the shaft
    /// turned as recorded, or with what may have happened at the stand.
    fn differing(
        &mut self,
        whole: Vec<ControllerAction>,
        conversation: &Conversation,
    ) -> Result<Option<DifferingScript>, CannotDrive> {
        let (reference, other) = self.both(&whole)?;
        let found = compare(&reference, &other, self.masks);
        if !found.is_empty() {
            return Ok(Some(DifferingScript { steps: whole, reference, differences: found }));
        }
        if self.pair.dut.live().is_some() {
            return Ok(None);
        }
        for script in stand_scripts(self.bench, self.pair.reference, conversation, self.masks)? {
            let (reference, other) = match self.both(&script) {
                Err(CannotDrive::NotUnderstood(_) | CannotDrive::Nothing(_)) => continue,
                both => both?,
            };
            let found = compare(&reference, &other, self.masks);
            if !found.is_empty() {
                return Ok(Some(DifferingScript { steps: script, reference, differences: found }));
            }
        }
        Ok(None)
    }

    fn both(&mut self, script: &[ControllerAction]) -> Result<(Conversation, Conversation), CannotDrive> {
        self.runs += 2;
        Ok((self.bench.drive(script, self.pair.reference)?, self.bench.drive(script, self.pair.dut)?))
    }

    /// Whether the devices differ in `target` on a script; one that does not load does not differ.
    fn differs(&mut self, script: &[ControllerAction], target: &ShrinkTarget) -> Result<bool, CannotDrive> {
        let key = (target.clone(), script.to_vec());
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let differs = match self.both(script) {
            Ok((reference, other)) => {
                let found = compare(&reference, &other, self.masks);
                found.iter().any(|of| (of.kind, &of.name) == (target.0, &target.1))
            }
            Err(CannotDrive::NotUnderstood(_)) => false,
            Err(error) => return Err(error),
        };
        self.known.insert(key, differs);
        Ok(differs)
    }

    fn smallest(
        &mut self,
        script: Vec<ControllerAction>,
        target: &ShrinkTarget,
    ) -> Result<Vec<ControllerAction>, CannotDrive> {
        let mut still = |steps: &[ControllerAction]| self.differs(steps, target);
        let script = fewest(script, &mut still)?;
        let script = simplest(script, smaller, &mut still)?;
        fewest(script, &mut still)
    }

    /// The first form of the difference that passes on the reference device and fails on the other one.
    ///
    /// If it depends on the shaft position, the case sets the position first.
    fn case(&mut self, script: &[ControllerAction], target: &ShrinkTarget) -> Result<Option<WrittenCase>, CannotDrive> {
        if self.pair.dut.live().is_some() {
            return self.case_of(script, target);
        }
        let mut placed = vec![ControllerAction::Set(vec![("shaft.counts".to_owned(), SHAFT.to_string())])];
        placed.extend(script.iter().cloned());
        for script in [script, &placed] {
            if let Some(case) = self.case_of(script, target)? {
                return Ok(Some(case));
            }
        }
        Ok(None)
    }

    fn case_of(
        &mut self,
        script: &[ControllerAction],
        target: &ShrinkTarget,
    ) -> Result<Option<WrittenCase>, CannotDrive> {
        let (reference, other) = self.both(script)?;
        let found = compare(&reference, &other, self.masks);
        let of_target = found.iter().filter(|of| (of.kind, &of.name) == (target.0, &target.1));
        for difference in of_target.take(2) {
            let DifferenceChecks { ways } = checks::forms(script, &reference, &other, difference);
            for steps in ways {
                let case = self.written(steps, difference);
                if self.is_confirmed(&case)? {
                    return Ok(Some(case));
                }
            }
        }
        Ok(None)
    }

    fn is_confirmed(&mut self, case: &WrittenCase) -> Result<bool, CannotDrive> {
        let yaml = case.yaml();
        self.runs += 1;
        let reference = match self.bench.run_undisturbed(&yaml, self.pair.reference) {
            Ok(outcome) => outcome.case.verdict,
            Err(CannotDrive::NotUnderstood(_)) => return Ok(false),
            Err(error) => return Err(error),
        };
        if reference != Verdict::Pass {
            return Ok(false);
        }
        self.runs += 1;
        Ok(self.bench.run_undisturbed(&yaml, self.pair.dut)?.case.verdict == Verdict::Fail)
    }

    /// Removes lines that a case does not need.
    fn shorter(&mut self, case: WrittenCase) -> Result<WrittenCase, CannotDrive> {
        let steps = fewest(case.steps.clone(), &mut |steps: &[CaseLine]| {
            self.is_confirmed(&WrittenCase { steps: steps.to_vec(), ..case.clone() })
        })?;
        Ok(WrittenCase { steps, ..case })
    }

    fn written(&self, steps: Vec<CaseLine>, difference: &Difference) -> WrittenCase {
        let manual = self.bench.manual();
        let (covers, source) = self.covers(&difference.name);
        let text = |value: &Option<super::conversation::SuiteValue>| {
            value.as_ref().map_or("nothing".to_owned(), ToString::to_string)
        };
        let name = &difference.name;
        WrittenCase {
            comment: vec![
                format!("Made by `encspec replay --shrink` for {}/{}.", manual.device.name, self.bench.variant()),
                format!(
                    "{name}: reference device {}, this device {}.",
                    text(&difference.first),
                    text(&difference.second)
                ),
                source.to_owned(),
            ],
            id: "shrunk".to_owned(),
            why: match self.pair.bug {
                Some(bug) => bug.why.clone(),
                None => format!("{} has the value of the reference device.", name.replace(['{', '}'], "")),
            },
            covers,
            catches: self.pair.bug.iter().map(|bug| bug.name.clone()).collect(),
            variant: self.bench.variant().to_owned(),
            steps,
        }
    }

    /// The requirements of a case: those that the bug breaks, else those that cases with the same name cover most often.
    fn covers(&self, name: &str) -> (Vec<String>, &'static str) {
        let manual = self.bench.manual();
        let place = manual.device.variants.iter().position(|of| of == self.bench.variant()).unwrap_or_default();
        let applies = |index: &usize| {
            manual.requirements.get(*index).filter(|of| of.variants.contains(&place)).map(|of| of.id.clone())
        };
        if let Some(bug) = self.pair.bug {
            let covers: Vec<String> = bug.breaks.iter().filter_map(applies).take(MOST_COVERED).collect();
            if !covers.is_empty() {
                return (covers, "It covers the requirements that the bug breaks.");
            }
        }
        let best = related(manual, place, name);
        let any = || manual.requirements.iter().position(|of| of.variants.contains(&place));
        let covers = best.or_else(any).as_ref().and_then(applies);
        (covers.into_iter().collect(), "The requirement was guessed from the name: check it.")
    }
}

/// The same step with one thing removed, or a shorter wait.
fn smaller(step: &ControllerAction) -> Vec<ControllerAction> {
    match step {
        ControllerAction::Wait(long) if *long > Duration::from_millis(20) => {
            vec![
                ControllerAction::Wait(Duration::from_millis(10)),
                ControllerAction::Wait(Duration::from_millis((long.as_millis() / 2) as u64)),
            ]
        }
        other => one_less(other),
    }
}
