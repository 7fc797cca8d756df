//! What is wrong with a suite: where, what, the line itself, and what was probably meant.
//!
//! Mistakes are collected, so that one pass over a file reports all of them. This module knows text and positions, no YAML and
//! no suite language.

use expression::ExprError;
use plain_text::nearest;
use std::cell::{Cell, RefCell};
use std::fmt;
use suite::Location;

/// One thing that is wrong in a suite file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadError {
    /// Where it is.
    pub at: Location,
    /// How many characters of the line are at fault, at least 1.
    pub width: usize,
    /// The line itself.
    pub line: String,
    /// What is wrong, in one sentence without a full stop.
    pub message: String,
    /// What to write instead.
    pub help: Option<String>,
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.at.file.display())?;
        if self.at.line > 0 {
            write!(f, ":{}:{}", self.at.line, self.at.column)?;
        }
        write!(f, ": {}", self.message)?;
        if !self.line.trim().is_empty() {
            let before = (self.at.column as usize).saturating_sub(1);
            let left = self.line.chars().take_while(|c| c.is_whitespace()).count().min(before);
            let shown: String = self.line.chars().skip(left).collect();
            let width = self.width.clamp(1, shown.chars().count().saturating_sub(before - left).max(1));
            write!(f, "\n   | {}\n   | {}{}", shown.trim_end(), " ".repeat(before - left), "^".repeat(width))?;
        }
        if let Some(help) = &self.help {
            write!(f, "\n   = {help}")?;
        }
        Ok(())
    }
}

impl std::error::Error for LoadError {}

/// Everything that is wrong in the suites that were loaded; never empty, in the order of files and lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadErrors(pub Vec<LoadError>);

impl fmt::Display for LoadErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.0.iter().enumerate() {
            write!(f, "{}{error}", if index == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

impl std::error::Error for LoadErrors {}

/// A stretch of one line of a file: what an error points at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Spot {
    /// Number of the file in the files that were opened.
    pub file: u16,
    /// From 1.
    pub line: u32,
    /// From 1, in characters.
    pub column: u32,
    /// In characters.
    pub width: u32,
}

/// A mistake before its location is looked up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// The line and column.
    pub spot: Spot,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
    /// What else is wrong, found beside it.
    pub others: Vec<Mistake>,
}

/// The result of reading a part of a suite; the mistake is boxed because it is rare.
pub type Read<T> = std::result::Result<T, Box<Mistake>>;

impl Mistake {
    /// What is wrong at `spot`.
    pub fn new(spot: Spot, message: impl Into<String>) -> Box<Mistake> {
        Box::new(Mistake { spot, message: message.into(), help: None, others: Vec::new() })
    }

    /// The same with what to do.
    pub fn help(mut self: Box<Self>, help: impl Into<String>) -> Box<Mistake> {
        self.help = Some(help.into());
        self
    }

    /// The same with what else is wrong.
    #[must_use]
    #[allow(clippy::boxed_local, reason = "a mistake is boxed wherever it is passed on")]
    pub fn and(mut self: Box<Self>, other: Box<Mistake>) -> Box<Mistake> {
        self.others.push(*other);
        self
    }

    /// All of these as one, none without any.
    pub fn all(mistakes: impl IntoIterator<Item = Box<Mistake>>) -> Option<Box<Mistake>> {
        mistakes.into_iter().reduce(Mistake::and)
    }

    /// A word that is none of `known`: the nearest one is suggested, else the first ones are listed.
    pub fn unknown<'a>(
        spot: Spot,
        what: &str,
        word: &str,
        known: impl IntoIterator<Item = &'a str> + Clone,
    ) -> Box<Mistake> {
        let mistake = Mistake::new(spot, format!("unknown {what} `{word}`"));
        match nearest(word, known.clone()) {
            Some(meant) => mistake.help(format!("did you mean `{meant}`?")),
            None => match listed(known) {
                Some(list) => mistake.help(format!("there are {list}")),
                None => mistake,
            },
        }
    }

    /// A mistake in an expression that stands `ahead` characters after the begin of `spot`, in `text`.
    pub fn expression(spot: Spot, ahead: usize, text: &str, error: ExprError) -> Box<Mistake> {
        let before = text.get(..error.span.start).map_or(0, |part| part.chars().count());
        let width = text.get(error.span.clone()).map_or(1, |part| part.chars().count()).max(1);
        let column = spot.column + (ahead + before) as u32;
        let spot = if spot.width == 0 { spot } else { Spot { column, width: width as u32, ..spot } };
        Box::new(Mistake { spot, message: error.message, help: error.help, others: Vec::new() })
    }
}

/// The list on which mistakes are put while reading goes on.
#[derive(Debug, Default)]
pub struct Mistakes {
    list: RefCell<Vec<Mistake>>,
    noted: Cell<usize>,
    /// One mistake is as good as many: reading may end with the first.
    one_is_enough: bool,
}

impl Mistakes {
    /// A list for a caller that only needs to know whether there is a mistake.
    pub fn only_first() -> Mistakes {
        Mistakes { one_is_enough: true, ..Mistakes::default() }
    }

    /// Whether reading may end.
    pub fn enough(&self) -> bool {
        self.one_is_enough && self.count() > 0
    }

    /// Puts a mistake on the list, once.
    pub fn note(&self, mut mistake: Box<Mistake>) {
        self.noted.set(self.noted.get() + 1);
        let others = std::mem::take(&mut mistake.others);
        let mut list = self.list.borrow_mut();
        if !list.contains(&mistake) {
            list.push(*mistake);
        }
        drop(list);
        others.into_iter().for_each(|other| self.note(Box::new(other)));
    }

    /// The value, or none with the mistake put on the list.
    pub fn keep<T>(&self, read: Read<T>) -> Option<T> {
        read.map_err(|mistake| self.note(mistake)).ok()
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.list.borrow().len()
    }

    /// How many were noted so far, the same one again counted again: more than before means that something was not read.
    pub fn noted(&self) -> usize {
        self.noted.get()
    }

    /// Takes all of them, in the order of files and lines.
    pub fn take(&self) -> Vec<Mistake> {
        let mut list = self.list.take();
        list.sort_by_key(|mistake| mistake.spot);
        list
    }
}

/// All of these, or everything that is wrong with them.
pub fn every<T>(reads: impl IntoIterator<Item = Read<T>>) -> Read<Vec<T>> {
    let (mut list, mut wrong) = (Vec::new(), Vec::new());
    for read in reads {
        match read {
            Ok(item) => list.push(item),
            Err(mistake) => wrong.push(mistake),
        }
    }
    Mistake::all(wrong).map_or(Ok(list), Err)
}

/// Both of these, or everything that is wrong with them.
pub fn both<A, B>(one: Read<A>, other: Read<B>) -> Read<(A, B)> {
    match (one, other) {
        (Ok(one), Ok(other)) => Ok((one, other)),
        (Err(one), Err(other)) => Err(one.and(other)),
        (Err(wrong), _) | (_, Err(wrong)) => Err(wrong),
    }
}

fn listed<'a>(words: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let mut words: Vec<String> = words.into_iter().take(9).map(|word| format!("`{word}`")).collect();
    if words.is_empty() {
        return None;
    }
    if words.len() == 9 {
        words[8] = "...".to_owned();
    }
    Some(words.join(", "))
}
