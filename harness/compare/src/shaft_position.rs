//! Infers the shaft position, which no capture contains, from the first recorded position value.
//!
//! The position value depends on scaling, preset and direction. Therefore it is not computed from a manual: the stand moves the shaft
//! of the model until its position value is the recorded one. This module must not know devices.

use super::action::ControllerAction;
use super::conversation::{Conversation, ValueTrack};
use super::drive::{CannotDrive, ScriptBench};
use engine::DutSpec;

/// How often the shaft is moved before the search is given up.
const TRIES: usize = 10;
/// The raw position at which the search begins.
const BEGIN: i128 = 0x2_0000;

/// The inferred shaft position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InferredShaft {
    /// The position name by which it was found, and the raw shaft position; `None` if it is unknown.
    pub put: Option<(String, i128)>,
    /// The result as a sentence.
    pub text: String,
    /// The name of the position, the recorded value and the nearest of the model, if the model has the recorded one nowhere.
    pub nowhere: Option<(String, i128, i128)>,
}

/// The first position value of a conversation, by name.
fn place(conversation: &Conversation) -> Option<(&String, i128)> {
    let first = |track: &ValueTrack| track.changes.iter().find_map(|change| change.value.as_ref()?.number);
    let places = conversation.tracks.iter().filter(|(_, track)| track.is_place);
    let mut places: Vec<(&String, i128)> = places.filter_map(|(name, track)| Some((name, first(track)?))).collect();
    // A position that is only sent on request is 0 until then.
    places.sort_by_key(|(_, place)| *place == 0);
    places.into_iter().next()
}

/// Finds the shaft position at the begin of `script` for which a model has the recorded position value; `speed` is the speed of the
/// shaft from the begin on.
pub fn shaft(
    bench: &ScriptBench<'_>,
    model: &DutSpec,
    recorded: &Conversation,
    script: &[ControllerAction],
    speed: Option<&ControllerAction>,
) -> Result<InferredShaft, CannotDrive> {
    let unknown = |why: &str| InferredShaft { put: None, text: format!("unknown: {why}"), nowhere: None };
    let Some((name, recorded_value)) = place(recorded) else {
        return Ok(unknown("the capture has no position value"));
    };
    // Up to the first position value only the start-up is needed.
    let connect = script.iter().position(|ask| matches!(ask, ControllerAction::Connect(_))).unwrap_or_default();
    let begin: Vec<ControllerAction> = script.iter().take(connect + 1).cloned().collect();
    let shows = |counts: i128| -> Result<Option<i128>, CannotDrive> {
        let mut script = vec![set_shaft(counts)];
        script.extend(speed.cloned());
        script.extend(begin.iter().cloned());
        let conversation = bench.drive(&script, model)?;
        Ok(conversation
            .tracks
            .get(name)
            .and_then(|track| track.changes.iter().find_map(|change| change.value.as_ref()?.number)))
    };
    let mut counts = BEGIN;
    let mut before: Option<(i128, i128)> = None;
    let mut nearest: Option<i128> = None;
    for _ in 0..TRIES {
        let Some(observed) = shows(counts)? else {
            return Ok(unknown("the model has no position value after this start-up"));
        };
        if observed == recorded_value {
            let text = format!("set so that {name} is {recorded_value} at first, as recorded");
            return Ok(InferredShaft { put: Some((name.clone(), counts)), text, nowhere: None });
        }
        let left = recorded_value - observed;
        if nearest.is_none_or(|nearest| left.abs() < (recorded_value - nearest).abs()) {
            nearest = Some(observed);
        }
        // Hardware steps for each step of the position value, from the last move.
        let step = match before {
            Some((at, place)) if place != observed => (left * (counts - at)).checked_div(observed - place),
            _ => Some(left),
        };
        before = Some((counts, observed));
        counts += step.filter(|step| *step != 0).unwrap_or(left);
        if counts < 0 {
            counts = BEGIN + counts.rem_euclid(BEGIN);
        }
    }
    let nearest = nearest.map(|nearest| (name.clone(), recorded_value, nearest));
    let text = format!("found no shaft position at which {name} is {recorded_value}");
    Ok(InferredShaft { nowhere: nearest, ..unknown(&text) })
}

/// Sets the shaft to a raw position.
pub fn set_shaft(counts: i128) -> ControllerAction {
    ControllerAction::Set(vec![("shaft.counts".to_owned(), counts.to_string())])
}
