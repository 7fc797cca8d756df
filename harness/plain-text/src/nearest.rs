//! The known word that was probably meant by an unknown one.

use alloc::{borrow::ToOwned, string::String};

/// Finds the candidate that `word` was probably meant to be, if one is near enough (a third of its letters differ).
///
/// Among equally near ones the first wins, so that a message does not depend on anything but the candidates' order.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let mut best = Nearest::new(word);
    candidates.into_iter().for_each(|candidate| best.offer(candidate));
    best.found()
}

/// The search behind [`nearest`], for candidates that come by callback.
pub struct Nearest<'w> {
    word: &'w str,
    distance: usize,
    found: Option<String>,
}

impl<'w> Nearest<'w> {
    /// Begins to look for what `word` was meant to be.
    pub fn new(word: &'w str) -> Nearest<'w> {
        Nearest { word, distance: (word.chars().count() / 3).max(1) + 1, found: None }
    }

    /// Takes one more candidate.
    pub fn offer(&mut self, candidate: &str) {
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

    /// The nearest candidate, if one was near enough.
    pub fn found(self) -> Option<String> {
        self.found
    }
}
