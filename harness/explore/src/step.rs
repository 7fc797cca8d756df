//! A step of a sequence: an action of the controller or of the stand, with what is changed in it on purpose.

use compare::action::ControllerAction;
use compare::write_case::CaseLine;

/// A step of a sequence.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SequenceStep {
    pub action: ControllerAction,
    /// Modifiers of the suite language: `instead`, `as`, `repeats`, each with its value.
    pub modifiers: Vec<(String, String)>,
}

impl From<ControllerAction> for SequenceStep {
    fn from(action: ControllerAction) -> SequenceStep {
        SequenceStep { action, modifiers: Vec::new() }
    }
}

impl SequenceStep {
    /// A service of `send`.
    pub fn send(service: &str, fields: impl Into<String>) -> SequenceStep {
        let answered = !["global_control", "broken", "abort", "lldp"].contains(&service);
        ControllerAction::Send { service: service.to_owned(), fields: fields.into(), answered }.into()
    }

    /// The same step with one more modifier.
    #[must_use]
    pub fn with(mut self, modifier: &str, value: impl Into<String>) -> SequenceStep {
        self.modifiers.push((modifier.to_owned(), value.into()));
        self
    }

    /// Whether the device may refuse it because something in it is wrong on purpose.
    pub fn is_broken(&self) -> bool {
        let is_damaged = matches!(&self.action, ControllerAction::Send { service, .. } if service == "broken");
        let instead = matches!(&self.action, ControllerAction::Connect(of) if !of.instead.is_empty());
        is_damaged || instead || self.modifiers.iter().any(|(name, _)| name == "instead")
    }

    /// The step without judging. `is_read_only` says which names can only be read: the loader takes a write to one with its refusal.
    pub fn line(&self, is_read_only: &dyn Fn(&str) -> bool) -> CaseLine {
        let mut line = CaseLine::new(self.action.yaml());
        if let ControllerAction::Write(entries) = &self.action
            && entries.iter().any(|(name, _)| is_read_only(name))
        {
            line = line.with("answer: { refused: read_only }");
        }
        for (name, value) in &self.modifiers {
            line = line.with(format!("{name}: {value}"));
        }
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_wrong_on_purpose_is_said() {
        let read = SequenceStep::from(ControllerAction::Read(vec!["P922".to_owned()]));
        assert!(!read.is_broken());
        assert!(read.clone().with("instead", "{ do_id: 7 }").is_broken());
        assert!(SequenceStep::send("broken", "{ frame: alarm_endpoint }").is_broken());
        let line = read.with("instead", "{ do_id: 7 }").line(&|_| false);
        assert_eq!(
            (line.verb.as_str(), line.modifiers),
            ("read: { P922: any }", vec!["instead: { do_id: 7 }".to_owned()])
        );
    }
}
