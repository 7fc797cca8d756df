//! Actions of the stand as messages, and the words that LEDs show.

use crate::request::{ApplicationRequest, StandValue};
use station::{StandAction, Time};

/// The most different words that the LEDs of a run may show.
const MOST_WORDS: usize = 256;

/// The message for an action, with the names of `stand` in a bench file; `None` for what stack and stand do themselves.
pub(crate) fn act(now: Time, action: &StandAction<'_>) -> Option<ApplicationRequest> {
    use StandValue::{Flag, Number, Whole};
    let (mut unit, mut speed, mut by) = (None, None, None);
    let (name, value) = match *action {
        StandAction::ShaftSpeed(rpm) => ("shaft.speed".to_owned(), Number(rpm)),
        StandAction::ShaftRamp { rpm, acceleration } => {
            by = Some(acceleration);
            ("shaft.acceleration".to_owned(), Number(rpm))
        }
        StandAction::ShaftCounts(counts) => ("shaft.counts".to_owned(), Whole(counts)),
        StandAction::Turn { steps, rpm } => {
            (unit, speed) = (Some("counts".to_owned()), Some(rpm));
            ("turn".to_owned(), Number(steps))
        }
        StandAction::TurnRevolutions { revolutions, rpm } => {
            (unit, speed) = (Some("revolutions".to_owned()), Some(rpm));
            ("turn".to_owned(), Number(revolutions))
        }
        StandAction::Fault(name, present) => (format!("fault.{name}"), Flag(present)),
        StandAction::Button(name, pressed) => (format!("button.{name}"), Flag(pressed)),
        StandAction::Switch(name, position) => (format!("switch.{name}"), Whole(position.into())),
        StandAction::SupplyVoltage(volts) => ("supply.voltage".to_owned(), Number(volts)),
        StandAction::Temperature(degrees) => ("supply.temperature".to_owned(), Number(degrees)),
        StandAction::Power(_)
        | StandAction::Link(_)
        | StandAction::Skip(_)
        | StandAction::ReplaceDevice
        | StandAction::RestoreFactoryState => return None,
    };
    let now = now.as_nanos();
    Some(ApplicationRequest::Act { now, name, value, unit, rpm: speed, acceleration: by })
}

/// Words that live as long as the run.
#[derive(Debug, Default)]
pub(crate) struct LedWords(Vec<&'static str>);

impl LedWords {
    /// The word for the stand; `None` if the program shows too many different ones.
    pub(crate) fn word(&mut self, word: &str) -> Option<&'static str> {
        if let Some(known) = self.0.iter().find(|known| **known == word) {
            return Some(known);
        }
        if self.0.len() >= MOST_WORDS {
            return None;
        }
        let word: &'static str = Box::leak(word.to_owned().into_boxed_str());
        self.0.push(word);
        Some(word)
    }
}
