//! What is known of changes that no case notices: the file `survivors.txt`.

use crate::Failure;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The classes, and what each means in the summary.
const CLASSES: [(&str, &str); 10] = [
    ("invalid", "not Rust"),
    ("equivalent", "equivalent"),
    ("permitted", "permitted"),
    ("no-requirement", "of no requirement"),
    ("generic", "for the generic suites"),
    ("silent", "never answer"),
    ("stops", "stand still"),
    ("hole", "known holes"),
    ("unread", "not classified yet"),
    ("unreached", "unreached"),
];

/// The changes that are classified.
pub struct Classes {
    /// By what is changed; the class.
    exact: BTreeMap<String, &'static str>,
    /// The beginnings of descriptions (written with a `*` at the end); the class.
    prefixes: Vec<(String, &'static str)>,
}

impl Classes {
    /// Reads the file: a line `CLASS: reason` begins a group, and the indented lines below it are the changes.
    pub fn read(path: &Path) -> Result<Classes, Failure> {
        let text = fs::read_to_string(path).unwrap_or_default();
        let mut classes = Classes { exact: BTreeMap::new(), prefixes: Vec::new() };
        let mut class = None;
        for (index, line) in text.lines().enumerate() {
            let wrong = |what: &str| format!("{}:{}: {what}", path.display(), index + 1);
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let Some(what) = line.strip_prefix("  ") else {
                let word = line.split_once(": ").ok_or_else(|| wrong("a class needs a reason"))?.0;
                let known = CLASSES.iter().find(|(name, _)| *name == word);
                class = Some(known.ok_or_else(|| wrong("no such class"))?.0);
                continue;
            };
            let class = class.ok_or_else(|| wrong("a change before any class"))?;
            match what.strip_suffix('*') {
                Some(prefix) => classes.prefixes.push((prefix.to_owned(), class)),
                None => {
                    if classes.exact.insert(what.to_owned(), class).is_some() {
                        return Err(wrong("the change is in the file twice").into());
                    }
                }
            }
        }
        Ok(classes)
    }

    /// The class of a change.
    pub fn of(&self, what: &str) -> Option<&'static str> {
        let by_prefix = || self.prefixes.iter().find(|(prefix, _)| what.starts_with(prefix)).map(|(_, class)| *class);
        self.exact.get(what).copied().or_else(by_prefix)
    }

    /// The changes that the file names and that are not among these.
    pub fn gone<'a>(&'a self, changes: &BTreeSet<&str>) -> impl Iterator<Item = &'a str> {
        let named = self.exact.iter().filter(|(_, class)| **class != "invalid").map(|(what, _)| what.as_str());
        let gone: Vec<&str> = named.filter(|what| !changes.contains(what)).collect();
        gone.into_iter()
    }

    /// Prints how many changes had which outcome, and lists what is new: changes that nothing noticed and the file does not name, and
    /// changes that the file names and a case notices. Returns whether at most one in a hundred of those that it does not name was not
    /// killed.
    pub fn summary(&self, sample: &[(&str, &str)]) -> bool {
        let mut new: BTreeMap<&str, usize> = BTreeMap::new();
        let mut by_class: BTreeMap<&str, usize> = BTreeMap::new();
        for (what, outcome) in sample {
            let (word, case) = outcome.split_once(' ').unwrap_or((outcome, ""));
            let is_killed = word == "killed";
            match self.of(what) {
                Some(class) if is_killed && self.exact.contains_key(*what) => {
                    println!("killed by {case}, but `{class}` in survivors.txt: {what}");
                }
                Some(class) if !is_killed => {
                    *by_class.entry(class).or_default() += 1;
                    continue;
                }
                None if word == "survived" => println!("survived: {what}"),
                None if !is_killed => println!("{word} at {case}: {what}"),
                _ => {}
            }
            *new.entry(word).or_default() += 1;
        }
        let killed = new.remove("killed").unwrap_or(0);
        let count = |class: &str| by_class.get(class).copied().unwrap_or(0);
        let list = |counts: Vec<String>| if counts.is_empty() { "none".to_owned() } else { counts.join(", ") };
        println!("{killed} killed");
        println!(
            "named in survivors.txt: {}",
            list(
                CLASSES
                    .iter()
                    .filter(|(name, _)| count(name) > 0)
                    .map(|(name, text)| format!("{} {text}", count(name)))
                    .collect()
            )
        );
        println!("new: {}", list(new.iter().map(|(word, count)| format!("{count} {word}")).collect()));
        let missed_new: usize = new.values().sum();
        let missed = count("hole") + count("unread") + missed_new;
        let covered = killed + missed;
        if let Some(tenths) = (killed * 1000).checked_div(covered) {
            println!("{}.{} % of the {covered} changes that a requirement covers are killed", tenths / 10, tenths % 10);
        }
        missed_new * 100 <= killed + missed_new
    }
}
