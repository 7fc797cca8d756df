//! Where the shaft stood, which no capture shows: it is put where the place in the first telegram is the recorded one.
//!
//! The place in a telegram depends on scaling, preset and direction, so nothing is computed from a manual: the stand moves the
//! shaft, and what the telegram shows then says how far it has still to go. This room must not know devices.

use super::ask::Ask;
use super::drive::{Bench, CannotDrive};
use super::heard::{Conversation, Track};
use engine::DutSpec;

/// How often the shaft is moved until it is given up.
const TRIES: usize = 5;
/// The raw place from which the search begins.
const BEGIN: i128 = 0x2_0000;

/// What was found about the shaft.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shaft {
    /// The name of the place by which it was found, and the raw place of the shaft; none where it is unknown.
    pub put: Option<(String, i128)>,
    /// The same as a sentence.
    pub text: String,
}

/// The first place that a telegram shows, by name.
fn place(heard: &Conversation) -> Option<(&String, i128)> {
    let first = |track: &Track| track.changes.iter().find_map(|change| change.value.as_ref()?.number);
    let places = heard.tracks.iter().filter(|(_, track)| track.is_place);
    let mut places: Vec<(&String, i128)> = places.filter_map(|(name, track)| Some((name, first(track)?))).collect();
    // A place that is only shown on request is 0 as long as nobody asks.
    places.sort_by_key(|(_, place)| *place == 0);
    places.into_iter().next()
}

/// Finds where the shaft has to stand at the begin of `script` so that a model shows the place that was recorded; `speed` is
/// how it turns from the begin on.
pub fn shaft(
    bench: &Bench<'_>,
    model: &DutSpec,
    recorded: &Conversation,
    script: &[Ask],
    speed: Option<&Ask>,
) -> Result<Shaft, CannotDrive> {
    let unknown = |why: &str| Shaft { put: None, text: format!("unknown: {why}") };
    let Some((name, wanted)) = place(recorded) else {
        return Ok(unknown("no telegram of the capture shows a place"));
    };
    // Up to the first place nothing but the start-up is needed.
    let connect = script.iter().position(|ask| matches!(ask, Ask::Connect(_))).unwrap_or_default();
    let begin: Vec<Ask> = script.iter().take(connect + 1).cloned().collect();
    let shows = |counts: i128| -> Result<Option<i128>, CannotDrive> {
        let mut script = vec![put(counts)];
        script.extend(speed.cloned());
        script.extend(begin.iter().cloned());
        let heard = bench.drive(&script, model)?;
        Ok(heard
            .tracks
            .get(name)
            .and_then(|track| track.changes.iter().find_map(|change| change.value.as_ref()?.number)))
    };
    let mut counts = BEGIN;
    let mut before: Option<(i128, i128)> = None;
    for _ in 0..TRIES {
        let Some(seen) = shows(counts)? else { return Ok(unknown("the model shows no place after this start-up")) };
        if seen == wanted {
            let text = format!("put where {name} is {wanted} at first, as recorded");
            return Ok(Shaft { put: Some((name.clone(), counts)), text });
        }
        let left = wanted - seen;
        // Hardware steps for each step of the telegram, as the last move has shown.
        let step = match before {
            Some((at, place)) if place != seen => (left * (counts - at)).checked_div(seen - place),
            _ => Some(left),
        };
        before = Some((counts, seen));
        counts += step.filter(|step| *step != 0).unwrap_or(left);
        if counts < 0 {
            counts = BEGIN + counts.rem_euclid(BEGIN);
        }
    }
    Ok(unknown(&format!("no place of the shaft was found at which {name} is {wanted}")))
}

/// What puts the shaft at a raw place.
pub fn put(counts: i128) -> Ask {
    Ask::Set(vec![("shaft.counts".to_owned(), counts.to_string())])
}
