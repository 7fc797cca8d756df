//! Writes steps as a topic file of the suite language with one case, ready to be loaded.
//!
//! The strict loader reads the result before it is used. This module must not know devices.

use super::action::ControllerAction;
use std::fmt::Write as _;

/// The name of the topic file with the written cases.
pub const TOPIC: &str = "reproduced";

/// A step with its modifiers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaseLine {
    /// The verb with its argument.
    pub verb: String,
    /// Modifiers, each a key with its value.
    pub modifiers: Vec<String>,
}

impl CaseLine {
    /// A step without modifiers.
    pub fn new(verb: impl Into<String>) -> CaseLine {
        CaseLine { verb: verb.into(), modifiers: Vec::new() }
    }

    /// Adds a modifier.
    #[must_use]
    pub fn with(mut self, modifier: impl Into<String>) -> CaseLine {
        self.modifiers.push(modifier.into());
        self
    }
}

/// A case to be written.
#[derive(Clone, Debug, Default)]
pub struct WrittenCase {
    /// Lines of comment at the top.
    pub comment: Vec<String>,
    pub id: String,
    pub why: String,
    /// The requirements; empty if each check has its own.
    pub covers: Vec<String>,
    /// The bugs that make it fail.
    pub catches: Vec<String>,
    pub variant: String,
    pub steps: Vec<CaseLine>,
}

impl WrittenCase {
    /// The topic file.
    pub fn yaml(&self) -> String {
        let mut out = String::new();
        let list = |names: &[String]| names.join(", ");
        for line in &self.comment {
            let _ = writeln!(out, "# {}", line.replace(['\n', '\r'], " "));
        }
        let _ = writeln!(out, "suite: {TOPIC}\ncases:\n  - id: {}", self.id);
        let _ = writeln!(out, "    why: {}", quoted(&self.why));
        if !self.covers.is_empty() {
            let _ = writeln!(out, "    covers: [{}]", list(&self.covers));
        }
        let _ = writeln!(out, "    variants: [{}]", self.variant);
        if !self.catches.is_empty() {
            let _ = writeln!(out, "    catches: [{}]", list(&self.catches));
        }
        let _ = writeln!(out, "    start: none\n    steps:");
        for step in &self.steps {
            let _ = writeln!(out, "      - {}", step.verb);
            for modifier in &step.modifiers {
                let _ = writeln!(out, "        {modifier}");
            }
        }
        out
    }
}

/// A sentence in YAML quotes.
fn quoted(text: &str) -> String {
    let plain: String = text.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
    format!("\"{}\"", plain.replace('\\', "\\\\").replace('"', "\\\""))
}

/// The steps of a script without judging: whatever the device answers, the next step follows. `covers` is any requirement that applies,
/// since a check with its own requirements does not end a trial; the loader accepts a write to a read-only name only with an `answer`.
pub fn unjudged(script: &[ControllerAction], covers: &str, is_read_only: &dyn Fn(&str) -> bool) -> Vec<CaseLine> {
    let line = |ask: &ControllerAction| {
        let line = CaseLine::new(ask.yaml());
        match ask {
            ControllerAction::Write(entries) if entries.iter().any(|(name, _)| is_read_only(name)) => {
                line.with("answer: { refused: read_only }").with(format!("covers: [{covers}]"))
            }
            ControllerAction::Connect(_) => {
                line.with("answer: { connection: data }").with(format!("covers: [{covers}]"))
            }
            _ if ask.is_answered() => line.with(format!("covers: [{covers}]")),
            _ => line,
        }
    };
    script.iter().map(line).collect()
}
