//! The plain lists of a manual: its requirements and the bugs of its reference device, each in one file or several.

use super::error::{Mistake, Mistakes, Read, Spot};
use super::source::{Files, Sources, is_list_of_bugs};
use super::yaml::{Node, from_yaml};
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};
use suite::model::{Bug, Class, Level, Requirement, Source};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RequirementsFile {
    requirements: Vec<RequirementEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RequirementEntry {
    id: String,
    cites: String,
    statement: String,
    level: LevelWord,
    source: SourceWord,
    channel: Channel,
    variants: Option<Vec<String>>,
    ambiguity: Option<String>,
    class: Option<ClassWord>,
    reason: Option<String>,
    reading: Option<String>,
}

#[derive(Clone, Copy, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum LevelWord {
    Must,
    Should,
    Info,
}

#[derive(Clone, Copy, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum SourceWord {
    Manual,
    Profile,
    Convention,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Channel {
    Cyclic,
    Acyclic,
    Startup,
    Record,
    Dcp,
    Alarm,
    Web,
    Model,
    Diagnosis,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum ClassWord {
    Implicit,
    Untestable,
    OutOfScope,
    Contradictory,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BugsFile {
    /// The requirements that each breaks.
    bugs: BTreeMap<String, Vec<String>>,
}

/// Reads the requirements; those with a mistake are left out.
pub(super) fn requirements(
    parts: &[(u16, impl AsRef<str>)],
    variants: &[String],
    files: &Files,
    mistakes: &Mistakes,
) -> Vec<Requirement> {
    let mut known = FxHashMap::default();
    let mut list = Vec::new();
    for (file, text) in parts {
        let Some(read) = mistakes.keep(from_yaml::<RequirementsFile>(*file, text.as_ref())) else { continue };
        let mut spots = Spots::new(*file, text.as_ref());
        if read.requirements.is_empty() {
            mistakes.note(Mistake::new(spots.top(), "there are no requirements"));
        }
        for entry in read.requirements {
            let spot = spots.after("id:", &entry.id);
            if known.insert(entry.id.clone(), spot).is_some() {
                mistakes.note(Mistake::new(spot, format!("duplicate id `{}`", entry.id)));
                continue;
            }
            list.extend(mistakes.keep(requirement(entry, spot, variants, files)));
        }
    }
    list
}

fn requirement(entry: RequirementEntry, spot: Spot, variants: &[String], files: &Files) -> Read<Requirement> {
    let wrong = |message: &str| Err(Mistake::new(spot, format!("{}: {message}", entry.id)));
    let applies = match &entry.variants {
        None => (0..variants.len()).collect(),
        Some(names) => {
            let index = |name: &String| {
                let found = variants.iter().position(|known| known == name);
                found.ok_or_else(|| Mistake::unknown(spot, "variant", name, variants.iter().map(String::as_str)))
            };
            names.iter().map(index).collect::<Read<Vec<usize>>>()?
        }
    };
    if applies.is_empty() {
        return wrong("it applies to no variant");
    }
    if entry.level == LevelWord::Must && (entry.source != SourceWord::Manual || entry.ambiguity.is_some()) {
        return wrong("only what the manual says without ambiguity is `must`");
    }
    let class = match (entry.class, entry.reason, entry.reading) {
        (None, None, None) => Class::Testable,
        (Some(ClassWord::Implicit), Some(reason), None) => Class::Implicit(reason),
        (Some(ClassWord::Untestable), Some(reason), None) => Class::Untestable(reason),
        (Some(ClassWord::OutOfScope), Some(reason), None) => Class::OutOfScope(reason),
        (Some(ClassWord::Contradictory), None, Some(reading)) => Class::Contradictory(reading),
        (Some(ClassWord::Contradictory), ..) => return wrong("`contradictory` needs the `reading` that was chosen"),
        (Some(_), ..) => return wrong("its class needs a `reason`, and nothing else"),
        (None, ..) => return wrong("`reason` and `reading` go with a `class`"),
    };
    Ok(Requirement {
        level: match entry.level {
            LevelWord::Must => Level::Must,
            LevelWord::Should => Level::Should,
            LevelWord::Info => Level::Info,
        },
        source: match entry.source {
            SourceWord::Manual => Source::Manual,
            SourceWord::Profile => Source::Profile,
            SourceWord::Convention => Source::Convention,
        },
        channel: match entry.channel {
            Channel::Cyclic => "cyclic",
            Channel::Acyclic => "acyclic",
            Channel::Startup => "startup",
            Channel::Record => "record",
            Channel::Dcp => "dcp",
            Channel::Alarm => "alarm",
            Channel::Web => "web",
            Channel::Model => "model",
            Channel::Diagnosis => "diagnosis",
        }
        .to_owned(),
        id: entry.id,
        cites: entry.cites,
        statement: entry.statement,
        variants: applies,
        ambiguity: entry.ambiguity,
        class,
        at: files.location(spot),
    })
}

/// The names in a list of bugs, or none if it cannot be read.
fn bug_names(text: &str) -> Option<Vec<String>> {
    from_yaml::<BugsFile>(0, text).ok().map(|read| read.bugs.into_keys().collect())
}

/// The bugs of all manuals, which are read when a common suite names one that this manual does not have.
#[derive(Clone, Debug, Default)]
pub(super) struct Elsewhere(Arc<OnceLock<Option<FxHashSet<String>>>>);

impl Elsewhere {
    /// Fails if no manual lists the bug `name`, which stands at `at`.
    pub(super) fn lists(&self, sources: &Sources, name: &str, at: &Node) -> Read<()> {
        let read = || {
            let lists = sources.files().filter(|(path, _)| is_list_of_bugs(path));
            let lists = lists.map(|(_, text)| bug_names(text));
            // A list that cannot be read is told of by the manual that it belongs to.
            let names: Option<Vec<Vec<String>>> = lists.collect();
            names.map(|names| names.into_iter().flatten().collect())
        };
        match self.0.get_or_init(read) {
            Some(names) if !names.contains(name) => {
                let mut names: Vec<&str> = names.iter().map(String::as_str).collect();
                names.sort_unstable();
                Err(Mistake::unknown(at.spot, "bug", name, names))
            }
            _ => Ok(()),
        }
    }
}

/// Reads the bugs; each has a name of its own and breaks requirements that exist.
pub(super) fn bugs(
    parts: &[(u16, impl AsRef<str>)],
    requirements: &FxHashMap<String, (usize, Vec<usize>)>,
    sentence: &dyn Fn(&str) -> String,
    files: &Files,
    mistakes: &Mistakes,
) -> Vec<(Bug, Spot)> {
    let mut list: Vec<(Bug, Spot)> = Vec::new();
    for (file, text) in parts {
        let Some(read) = mistakes.keep(from_yaml::<BugsFile>(*file, text.as_ref())) else { continue };
        let heads = heads(*file, text.as_ref());
        for (name, ids) in read.bugs {
            let spots = || Spots::new(*file, text.as_ref());
            let spot = heads.get(name.as_str()).copied();
            let spot = spot.unwrap_or_else(|| spots().after("", &format!("{name}:")));
            if list.iter().any(|(bug, _)| bug.name == name) {
                mistakes.note(Mistake::new(spot, format!("duplicate bug `{name}`")));
                continue;
            }
            let breaks = ids.iter().map(|id| match requirements.get(id) {
                Some((index, _)) => Ok(*index),
                None => {
                    let mut known: Vec<&str> = requirements.keys().map(String::as_str).collect();
                    known.sort_unstable();
                    // Behind the name, or in a line that continues the list.
                    let (head, mut at) = (format!("{name}:"), spots());
                    let mut spot = at.after(&head, id);
                    if spot == at.top() {
                        at = spots();
                        at.after("", &head);
                        spot = at.after("", id);
                    }
                    Err(Mistake::unknown(spot, "requirement", id, known))
                }
            });
            let breaks = breaks.collect::<Read<Vec<usize>>>();
            let breaks = breaks.and_then(|breaks| {
                if breaks.is_empty() { Err(Mistake::new(spot, format!("`{name}` breaks nothing"))) } else { Ok(breaks) }
            });
            let Some(breaks) = mistakes.keep(breaks) else { continue };
            let why = sentence(&name);
            list.push((Bug { name, why, breaks, at: files.location(spot) }, spot));
        }
    }
    list.sort_by_key(|(_, spot)| *spot);
    list
}

/// Where each key that begins a line stands first.
fn heads(file: u16, text: &str) -> FxHashMap<&str, Spot> {
    let mut heads = FxHashMap::default();
    for (index, line) in text.lines().enumerate() {
        let key = line.trim_start();
        let indent = line.len() - key.len();
        if let Some((head, _)) = key.split_once(':') {
            let (line, column, width) = (index as u32 + 1, indent as u32 + 1, head.len() as u32 + 1);
            heads.entry(head).or_insert(Spot { file, line, column, width });
        }
    }
    heads
}

/// Where `word` begins in `line`; one letter after the other, since a search would cost more to begin than it saves.
fn find(line: &str, word: &str) -> Option<usize> {
    let Some(first) = word.chars().next() else { return Some(0) };
    line.match_indices(first).map(|(at, _)| at).find(|at| line[*at..].starts_with(word))
}

/// Finds words in the order of a file, for lists whose reader keeps no places.
struct Spots<'t> {
    file: u16,
    lines: std::iter::Enumerate<std::str::Lines<'t>>,
}

impl<'t> Spots<'t> {
    fn new(file: u16, text: &'t str) -> Spots<'t> {
        Spots { file, lines: text.lines().enumerate() }
    }

    /// The beginning of the file.
    fn top(&self) -> Spot {
        Spot { file: self.file, line: 1, column: 1, width: 0 }
    }

    /// The next line that has `key` and then `word`; the search goes on after it.
    fn after(&mut self, key: &str, word: &str) -> Spot {
        for (index, line) in self.lines.by_ref() {
            let place = find(line, key).and_then(|start| Some(start + find(line.get(start..)?, word)?));
            if let Some(place) = place {
                let column = line.get(..place).map_or(0, |before| before.chars().count()) as u32 + 1;
                return Spot { file: self.file, line: index as u32 + 1, column, width: word.chars().count() as u32 };
            }
        }
        self.top()
    }
}
