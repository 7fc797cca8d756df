//! The failure for the report: what was expected, what was observed, in which frame, and what to do next.

use super::step_error::BoxedStepError;
use super::{RunningTrial, TrialPhase};
use crate::world::{LostConnection, TrialWorld};
use judge::follow::Ending;
use judge::observe::{FrameDirection, Leaving};
use results::outcome::{CaseFailure, FailureCause, FailurePosition};
use results::verdict::Verdict;
use suite::model::{Manual, TrialStep};

/// Frames shown before and after the decisive one.
const AROUND: u64 = 4;

/// A failure of a step.
pub fn failure(
    run: &RunningTrial<'_>,
    step: Option<&TrialStep>,
    trouble: BoxedStepError,
    covers: &[usize],
) -> CaseFailure {
    let world = &run.world;
    let covers = if covers.is_empty() { &run.trial.covers } else { covers };
    let place = place(&trouble);
    let around = place.as_ref().map(|place| place.frame).or(trouble.frame);
    let (text, at) = match (&trouble.step, step) {
        (Some((text, at)), _) => (text.clone(), at.clone()),
        (None, Some(step)) => (step.text.clone(), step.at.clone()),
        (None, None) => ("start".to_owned(), run.trial.at.clone()),
    };
    let before_test = run.phase == TrialPhase::Before && trouble.verdict == Some(Verdict::Inconclusive);
    let of_device = before_test && trouble.blame == FailureCause::Device;
    let what = if of_device { before(&trouble, step) } else { trouble.what.clone() };
    let blame = match (trouble.blame, trouble.verdict) {
        (FailureCause::Device, Some(Verdict::Inconclusive)) => FailureCause::Undecided,
        (blame, _) => blame,
    };
    CaseFailure {
        blame,
        what,
        step: text,
        at,
        requirements: requirements(world.manual, covers),
        parts: trouble.parts.clone(),
        trace: around.map_or_else(Vec::new, |frame| trace(world, frame)),
        next: next(blame, place.as_ref()),
        place,
        before_test,
    }
}

/// What the device did before the test, in one sentence without a frame number, so that the same reason is the same text.
fn before(trouble: &BoxedStepError, step: Option<&TrialStep>) -> String {
    let wrong = trouble.parts.iter().filter(|part| !part.held);
    let wrong = wrong.map(|part| format!("{}: expected {}, observed {}", part.text, part.expected, part.observed));
    let wrong: Vec<String> = wrong.collect();
    let observed = if wrong.is_empty() { String::new() } else { format!(" {}.", wrong.join("; ")) };
    match step {
        Some(step) => format!("Before the test, in `given`, step `{}`: {}{observed}", step.text, trouble.what),
        None => format!("Before the test, at the start: {}{observed}", trouble.what),
    }
}

/// Id, clause and statement of each requirement.
pub fn requirements(manual: &Manual, covers: &[usize]) -> Vec<(String, String, String)> {
    covers
        .iter()
        .filter_map(|&index| manual.requirements.get(index))
        .map(|of| (of.id.clone(), of.cites.clone(), of.statement.clone()))
        .collect()
}

fn place(trouble: &BoxedStepError) -> Option<FailurePosition> {
    match (trouble.place, trouble.frame) {
        (Some((frame, octet, bit)), _) => {
            Some(FailurePosition { frame, octet: Some(octet), bit, filter: filter(frame) })
        }
        (None, Some(frame)) if frame > 0 => {
            Some(FailurePosition { frame, octet: None, bit: None, filter: filter(frame) })
        }
        (None, _) => None,
    }
}

fn filter(frame: u64) -> String {
    format!("frame.number == {frame}")
}

/// The frames around one, one line each, with the decisive one marked.
pub fn trace(world: &TrialWorld<'_>, frame: u64) -> Vec<String> {
    let first = usize::try_from(frame.saturating_sub(AROUND).max(1)).unwrap_or(usize::MAX);
    let last = usize::try_from(frame + AROUND).unwrap_or(usize::MAX).min(world.trace.len());
    let lines = world.describe(first..=last);
    (first..=last)
        .zip(lines)
        .filter_map(|(number, line)| {
            let shown = world.trace.get(number)?;
            let mark = if number as u64 == frame { '>' } else { ' ' };
            Some(format!("{mark}{number:>6} {}  {line}", shown.time))
        })
        .collect()
}

fn next(blame: FailureCause, place: Option<&FailurePosition>) -> String {
    match (blame, place) {
        (FailureCause::Device, Some(place)) => format!("Compare frame {} with the clause.", place.frame),
        (FailureCause::Device, None) => "Compare the answer with the clause.".into(),
        (FailureCause::Undecided, Some(place)) => format!(
            "The device was not judged. See frame {}, and begin with a failed case about this step.",
            place.frame
        ),
        (FailureCause::Undecided, None) => {
            "The device was not judged. Begin with a failed case about this step.".into()
        }
        (FailureCause::Environment, _) => {
            "Fix the bench and run the trial again; it says nothing about the device.".into()
        }
        (FailureCause::Harness, _) => "This is a bug in encspec: please report it with the capture.".into(),
        (FailureCause::Suite, _) => "This is an error in the suite: please report it.".into(),
    }
}

/// How a connection was lost, in a sentence.
pub fn lost(lost: &LostConnection) -> String {
    match lost.ending {
        Ending::Released => "The connection was released.".into(),
        Ending::Aborted(FrameDirection::ToController, code) => {
            format!("The device ended the connection: {}.", wire::profinet::status::PnioStatus::from(code))
        }
        Ending::Aborted(FrameDirection::ToDevice, code) => {
            format!(
                "The harness's controller had to end the connection: {}.",
                wire::profinet::status::PnioStatus::from(code)
            )
        }
        Ending::Starved(FrameDirection::ToController) => "The device stopped sending its cyclic frames.".into(),
        Ending::Starved(FrameDirection::ToDevice) => "The cyclic frames of the harness stopped.".into(),
        Ending::Left(Leaving::NoService) => "The device left the data exchange: it answers with `no service`.".into(),
        Ending::Left(Leaving::Diagnosis) => "The device left the data exchange: its diagnosis shows it.".into(),
    }
}
