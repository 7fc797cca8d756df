//! Suggestions for misspelled words.

use alloc::{borrow::ToOwned, string::String};

/// Finds the candidate with the smallest Damerau-Levenshtein distance to `word`, or `None` if more than a third of the letters
/// differ.
///
/// Of equally near candidates the first wins: the result depends only on the order of the candidates.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let mut best = Nearest::new(word);
    candidates.into_iter().for_each(|candidate| best.offer(candidate));
    best.found()
}

/// The search of [`nearest`], for candidates that come one by one from a callback.
pub struct Nearest<'w> {
    word: &'w str,
    distance: usize,
    found: Option<String>,
}

impl<'w> Nearest<'w> {
    /// Starts a search for the candidate nearest to `word`.
    pub fn new(word: &'w str) -> Nearest<'w> {
        Nearest { word, distance: (word.chars().count() / 3).max(1) + 1, found: None }
    }

    /// Compares one more candidate.
    pub fn offer(&mut self, candidate: &str) {
        // Nothing but the word itself is nearer than one change, and a known word is never searched for.
        if self.distance <= 1 {
            return;
        }
        // The difference in length is a lower bound of the distance; it rules out most candidates.
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
