//! What follows from where a shaft is: what a healthy reference device answers otherwise where its shaft stands or turns otherwise.
//!
//! Where nobody knows the place of a shaft all of this is not compared, and the report says so. This room must not know devices.

use super::ask::Ask;
use super::compare::{Difference, Kind, compare};
use super::drive::{Bench, CannotDrive};
use super::heard::Conversation;
use super::infer::put;
use super::masks::Masks;
use super::turn::{Standing, standing};
use engine::DutSpec;
use station::Duration;
use std::collections::BTreeSet;

/// Why what follows from the shaft is not compared.
pub const UNKNOWN: &str = "it follows from where the shaft is or from when the device began, which is unknown";
/// Two raw places that have no digit in common, and a speed.
const PLACES: [i128; 2] = [0x1_5A5A, 0xA5A5];
const SPEED: &str = "-7";
/// How much later everything behind the first connection comes once.
const LATER: Duration = Duration::from_millis(17);

/// Inputs and parts of answers that follow from the shaft.
#[derive(Clone, Debug, Default)]
pub struct Follows {
    inputs: BTreeSet<String>,
    /// The request with the part of its answer.
    answers: BTreeSet<(String, String)>,
}

impl Follows {
    /// Asks a healthy reference device with its shaft at rest, and again with it elsewhere and a little later, turning unless it
    /// stood while it was captured.
    pub fn of(
        bench: &Bench<'_>,
        healthy: &DutSpec,
        recorded: &Conversation,
        steps: &[Ask],
    ) -> Result<Follows, CannotDrive> {
        let mut follows = Follows::default();
        let places = recorded.tracks.iter().filter(|(_, track)| track.is_place);
        follows.inputs.extend(places.map(|(name, _)| name.clone()));
        if follows.inputs.is_empty() {
            return Ok(follows);
        }
        let [stands, mut other] = PLACES.map(|place| {
            let mut script = vec![put(place)];
            script.extend(steps.iter().cloned());
            script
        });
        if let Some(connect) = other.iter().position(|ask| matches!(ask, Ask::Connect(_))) {
            other.insert(connect + 1, Ask::Wait(LATER));
        }
        if !matches!(standing(bench, healthy, recorded, steps)?, Standing::At(_)) {
            other.insert(1, Ask::Set(vec![("shaft.speed".to_owned(), SPEED.to_owned())]));
        }
        let (one, other) = (bench.drive(&stands, healthy)?, bench.drive(&other, healthy)?);
        for difference in compare(&one, &other, &Masks::default()) {
            match (difference.kind, difference.step.and_then(|step| one.asked.get(step))) {
                (Kind::Input, _) => {
                    follows.inputs.insert(difference.name);
                }
                (Kind::Answer, Some(asked)) => {
                    follows.answers.insert((asked.ask.yaml(), difference.name));
                }
                _ => {}
            }
        }
        Ok(follows)
    }

    /// The names of all of it but of mere octets.
    pub fn names(&self) -> impl Iterator<Item = String> + '_ {
        let answers = self.answers.iter().map(|(_, name)| name).filter(|name| *name != "bytes");
        self.inputs.iter().chain(answers).cloned()
    }

    /// Whether a difference may come from the shaft alone.
    pub fn explains(&self, difference: &Difference, recorded: &Conversation) -> bool {
        match (difference.kind, difference.step.and_then(|step| recorded.asked.get(step))) {
            (Kind::Input, _) => self.inputs.contains(&difference.name),
            (Kind::Answer, Some(asked)) => {
                let is_it = |(ask, name): &(String, String)| *name == difference.name && *ask == asked.ask.yaml();
                self.answers.iter().any(is_it)
            }
            _ => false,
        }
    }
}
