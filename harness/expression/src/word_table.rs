//! Tables of words and their numbers.

use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Words and the numbers that represent them on the wire.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct WordTable {
    /// The name of the table in messages.
    pub name: String,
    /// Word and number in the order of declaration; a table without numbers counts its words from 0.
    pub words: Vec<(String, i64)>,
}

impl WordTable {
    /// A table of words with explicit numbers.
    pub fn new<W: Into<String>>(name: impl Into<String>, words: impl IntoIterator<Item = (W, i64)>) -> Arc<WordTable> {
        let words = words.into_iter().map(|(word, number)| (word.into(), number)).collect();
        Arc::new(WordTable { name: name.into(), words })
    }

    /// A table of words that are numbered from 0.
    pub fn plain<W: Into<String>>(name: impl Into<String>, words: impl IntoIterator<Item = W>) -> Arc<WordTable> {
        WordTable::new(name, words.into_iter().zip(0..))
    }

    /// The number of `word`.
    pub fn number(&self, word: &str) -> Option<i64> {
        self.words.iter().find(|(known, _)| known == word).map(|&(_, number)| number)
    }

    /// The first word with this number; a number received from the wire may have none.
    pub fn word(&self, number: i64) -> Option<&str> {
        self.words.iter().find(|&&(_, known)| known == number).map(|(word, _)| word.as_str())
    }

    /// The words in the order of declaration.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        self.words.iter().map(|(word, _)| word.as_str())
    }

    /// The words for a help text, at most eight of them.
    pub(super) fn listed(&self) -> String {
        let mut shown: Vec<String> = self.iter().take(8).map(|word| format!("`{word}`")).collect();
        match self.words.len() {
            0 => return "nothing".to_owned(),
            1..=8 => {}
            _ => shown.push("...".to_owned()),
        }
        shown.join(", ")
    }
}
