//! The values that depend on the shaft: what a reference device answers differently if its shaft has another position or speed.
//!
//! If the shaft position is unknown, these values are not compared, and the report says so. This module must not know devices.

use super::action::ControllerAction;
use super::compare::{Difference, DifferenceKind, compare};
use super::conversation::Conversation;
use super::drive::{CannotDrive, ScriptBench};
use super::masks::Masks;
use super::shaft_motion::{ShaftState, shaft_state};
use super::shaft_position::set_shaft;
use engine::DutSpec;
use station::Duration;
use std::collections::BTreeSet;

/// Why values that depend on the shaft are not compared.
pub const UNKNOWN: &str = "it depends on the shaft position or on the start time of the device, which are unknown";
/// Two raw positions without a common digit.
const PLACES: [i128; 2] = [0x1_5A5A, 0xA5A5];
/// The speed of the second run, in revolutions per minute.
const SPEED: &str = "-7";
/// By how much the second run is later after the first connection.
const LATER: Duration = Duration::from_millis(17);

/// Inputs and parts of answers that depend on the shaft.
#[derive(Clone, Debug, Default)]
pub struct ShaftDependence {
    inputs: BTreeSet<String>,
    /// Request and part of its answer.
    answers: BTreeSet<(String, String)>,
}

impl ShaftDependence {
    /// Compares a reference device at rest with one at another position, a little later, and turning unless the shaft was at rest in
    /// the capture.
    pub fn of(
        bench: &ScriptBench<'_>,
        reference: &DutSpec,
        recorded: &Conversation,
        steps: &[ControllerAction],
    ) -> Result<ShaftDependence, CannotDrive> {
        let mut follows = ShaftDependence::default();
        let places = recorded.tracks.iter().filter(|(_, track)| track.is_place);
        follows.inputs.extend(places.map(|(name, _)| name.clone()));
        if follows.inputs.is_empty() {
            return Ok(follows);
        }
        let [stands, mut other] = PLACES.map(|place| {
            let mut script = vec![set_shaft(place)];
            script.extend(steps.iter().cloned());
            script
        });
        if let Some(connect) = other.iter().position(|ask| matches!(ask, ControllerAction::Connect(_))) {
            other.insert(connect + 1, ControllerAction::Wait(LATER));
        }
        if !matches!(shaft_state(bench, reference, recorded, steps)?, ShaftState::At(_)) {
            other.insert(1, ControllerAction::Set(vec![("shaft.speed".to_owned(), SPEED.to_owned())]));
        }
        let (one, other) = (bench.drive(&stands, reference)?, bench.drive(&other, reference)?);
        for difference in compare(&one, &other, &Masks::default()) {
            match (difference.kind, difference.step.and_then(|step| one.actions.get(step))) {
                (DifferenceKind::Input, _) => {
                    follows.inputs.insert(difference.name);
                }
                (DifferenceKind::Answer, Some(asked)) => {
                    follows.answers.insert((asked.ask.yaml(), difference.name));
                }
                _ => {}
            }
        }
        Ok(follows)
    }

    /// The names of all of them, except plain bytes.
    pub fn names(&self) -> impl Iterator<Item = String> + '_ {
        let answers = self.answers.iter().map(|(_, name)| name).filter(|name| *name != "bytes");
        self.inputs.iter().chain(answers).cloned()
    }

    /// Whether a difference may be caused by the shaft alone.
    pub fn explains(&self, difference: &Difference, recorded: &Conversation) -> bool {
        match (difference.kind, difference.step.and_then(|step| recorded.actions.get(step))) {
            (DifferenceKind::Input, _) => self.inputs.contains(&difference.name),
            (DifferenceKind::Answer, Some(asked)) => {
                let is_it = |(ask, name): &(String, String)| *name == difference.name && *ask == asked.ask.yaml();
                self.answers.iter().any(is_it)
            }
            _ => false,
        }
    }
}
