//! The dependency slice: the steps on which a difference can depend, if no device is available to try which it does depend on.
//!
//! It keeps the present connection and, of the steps before the difference, those that change something; reads and later steps are left
//! out. The case is not confirmed on a device that fails, and its comment says so.

use super::action::ControllerAction;
use super::checks;
use super::compare::{DifferenceKind, compare};
use super::conversation::RecordedConversation;
use super::drive::{CannotDrive, ScriptBench};
use super::masks::Masks;
use super::report::related;
use super::script::script;
use super::shaft_motion::{ShaftState, shaft_state};
use super::write_case::WrittenCase;
use engine::DutSpec;
use results::verdict::Verdict;

/// The steps on which the last step can depend: the last connection before it, and all changes since.
fn cut(steps: &[ControllerAction]) -> Vec<ControllerAction> {
    let connected = steps.iter().rposition(|ask| matches!(ask, ControllerAction::Connect(_))).unwrap_or_default();
    let lasting = |ask: &&ControllerAction| match ask {
        ControllerAction::Set(_) | ControllerAction::Write(_) | ControllerAction::Turn { .. } => true,
        ControllerAction::Send { service, .. } => !service.contains("read"),
        ControllerAction::Connect(_)
        | ControllerAction::Disconnect
        | ControllerAction::Read(_)
        | ControllerAction::Wait(_) => false,
    };
    let last = steps.len().saturating_sub(1);
    let mut kept: Vec<ControllerAction> =
        steps.iter().take(connected).filter(|ask| matches!(ask, ControllerAction::Set(_))).cloned().collect();
    let since = steps.iter().enumerate().skip(connected);
    kept.extend(
        since.filter(|(place, ask)| *place == connected || *place == last || lasting(ask)).map(|(_, ask)| ask.clone()),
    );
    kept
}

/// A case for the first difference between a capture and the reference device; `None` if there is no difference.
///
/// It passes on the reference device. That it fails on the recorded device is not confirmed.
pub fn slice(
    bench: &ScriptBench<'_>,
    reference: &DutSpec,
    conversation: &RecordedConversation,
    masks: &Masks,
) -> Result<Option<WrittenCase>, CannotDrive> {
    let mut whole = script(&conversation.conversation);
    let place = match shaft_state(bench, reference, &conversation.conversation, &whole)? {
        ShaftState::At(place) => Some(place),
        ShaftState::Turns | ShaftState::Unknown => None,
    };
    // The shaft position belongs to every case about a position.
    whole.splice(0..0, place.clone());
    let reference_run = bench.drive(&whole, reference)?;
    let found = compare(&reference_run, &conversation.conversation, masks);
    let known = reference_run.tracks.iter().filter(|(_, track)| track.is_place && place.is_none());
    let places: Vec<String> = known.map(|(name, _)| name.clone()).collect();
    let whom = bench.manual_variant();
    for difference in found.iter().filter(|of| of.kind != DifferenceKind::Step && !places.contains(&of.name)) {
        let Some(asked) = difference.step.and_then(|step| reference_run.actions.get(step)) else { continue };
        let Some(end) = whole.iter().rposition(|ask| *ask == asked.ask) else { continue };
        let steps = cut(whole.get(..=end).unwrap_or_default());
        let again = bench.drive(&steps, reference)?;
        let step = again.actions.iter().rposition(|of| of.ask == asked.ask);
        // The difference at its time after the slice.
        let since = difference.at.since(asked.done);
        let at = step.and_then(|step| again.actions.get(step)).map_or(difference.at, |of| of.done + since);
        let moved = super::compare::Difference { step, at, ..difference.clone() };
        for steps in checks::forms(&steps, &again, &conversation.conversation, &moved).ways {
            let requirement = related(whom.manual, whom.variant, &difference.name);
            let requirement = requirement.and_then(|index| whom.manual.requirements.get(index));
            let Some(requirement) = requirement else { continue };
            let recorded = difference.second.as_ref().map_or("nothing".to_owned(), ToString::to_string);
            let case = WrittenCase {
                comment: vec![
                    "UNCONFIRMED: these are the steps on which the difference can depend; no device was tried that fails here.".to_owned(),
                    format!("{}: recorded {recorded} in frame {}.", difference.name, difference.there.1),
                    "The requirement was guessed from the name: check it.".to_owned(),
                ],
                id: "unconfirmed".to_owned(),
                why: "The reference device answers differently from the recorded device.".to_owned(),
                covers: vec![requirement.id.clone()],
                variant: bench.variant().to_owned(),
                steps,
                ..WrittenCase::default()
            };
            match bench.run(&case.yaml(), reference) {
                Ok(outcome) if outcome.case.verdict == Verdict::Pass => return Ok(Some(case)),
                Ok(_) | Err(CannotDrive::NotUnderstood(_)) => {}
                Err(error) => return Err(error),
            }
        }
    }
    Ok(None)
}
