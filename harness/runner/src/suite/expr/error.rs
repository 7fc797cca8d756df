//! What is wrong with an expression, where, and what to write instead.

use std::fmt;
use std::ops::Range;

/// A fault in the text of an expression or a literal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExprError {
    /// The octets of the text that are at fault; inside the text and on character borders, possibly empty.
    pub span: Range<usize>,
    /// What is wrong, in one sentence without a full stop.
    pub message: String,
    /// What to write instead.
    pub help: Option<String>,
}

impl ExprError {
    pub(super) fn new(span: Range<usize>, message: impl Into<String>) -> ExprError {
        ExprError { span, message: message.into(), help: None }
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> ExprError {
        self.help = Some(help.into());
        self
    }

    pub(super) fn did_you_mean(self, nearest: Option<String>) -> ExprError {
        match nearest {
            Some(word) => self.help(format!("did you mean `{word}`?")),
            None => self,
        }
    }
}

impl fmt::Display for ExprError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.help {
            Some(help) => write!(f, "{}: {help}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for ExprError {}

/// Finds the candidate that `word` was probably meant to be, if one is near enough (a third of its letters differ).
///
/// Among equally near ones the first wins, so that a message does not depend on anything but the candidates' order.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let mut best = Nearest::new(word);
    candidates.into_iter().for_each(|candidate| best.offer(candidate));
    best.found()
}

/// The search behind [`nearest`], for candidates that come by callback.
pub(super) struct Nearest<'w> {
    word: &'w str,
    distance: usize,
    found: Option<String>,
}

impl<'w> Nearest<'w> {
    pub(super) fn new(word: &'w str) -> Nearest<'w> {
        Nearest { word, distance: (word.chars().count() / 3).max(1) + 1, found: None }
    }

    pub(super) fn offer(&mut self, candidate: &str) {
        // A word with one change cannot be nearer but by being the same, and nobody looks for what is known.
        if self.distance <= 1 {
            return;
        }
        // Each letter more or less is a change, and most candidates are told apart by that.
        if self.word.len().abs_diff(candidate.len()) >= self.distance && self.word.is_ascii() && candidate.is_ascii() {
            return;
        }
        let distance = strsim::damerau_levenshtein(self.word, candidate);
        if distance < self.distance && distance < candidate.chars().count() {
            self.distance = distance;
            self.found = Some(candidate.to_owned());
        }
    }

    pub(super) fn found(self) -> Option<String> {
        self.found
    }
}
