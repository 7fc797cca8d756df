//! The plain lists of a manual: its requirements and the bugs of its reference device, each in one file or several.

use super::error::{Mistake, Mistakes, Read, Spot};
use super::keys::{self, Keyed};
use super::source::{Files, Sources, is_list_of_bugs};
use super::yaml::{Node, parse};
use rustc_hash::{FxHashMap, FxHashSet};
use std::sync::{Arc, OnceLock};
use suite::model::{Bug, Level, Requirement, RequirementClass, RequirementSource};

/// Reads the requirements; those with a mistake are left out.
pub(super) fn requirements(
    parts: &[(u16, impl AsRef<str>)],
    variants: &[String],
    files: &Files,
    mistakes: &Mistakes,
) -> Vec<Requirement> {
    let mut known = FxHashSet::default();
    let mut list = Vec::new();
    for (file, text) in parts {
        let Some(node) = mistakes.keep(parse(*file, text.as_ref())) else { continue };
        let Some((defaults, entries)) = mistakes.keep(entries(&node)) else { continue };
        for entry in entries {
            let read = requirement(entry, defaults, variants, files);
            let Some(requirement) = mistakes.keep(read) else { continue };
            if known.insert(requirement.id.clone()) {
                list.push(requirement);
            } else {
                mistakes.note(entry.get("id").unwrap_or(entry).wrong(format!("duplicate id `{}`", requirement.id)));
            }
        }
    }
    list
}

/// The source and the channel of the requirements of a file that name none.
#[derive(Clone, Copy)]
struct RequirementDefaults {
    source: Option<&'static str>,
    channel: Option<&'static str>,
}

fn entries(node: &Node) -> Read<(RequirementDefaults, &[Node])> {
    let keyed = Keyed::new(node, &keys::REQUIREMENTS)?;
    let list = keyed.must("requirements")?;
    let defaults = RequirementDefaults {
        source: word(&keyed, "source", keys::SOURCES)?,
        channel: word(&keyed, "channel", keys::CHANNELS)?,
    };
    match list.items("requirements")? {
        [] => Err(list.wrong("there are no requirements")),
        entries => Ok((defaults, entries)),
    }
}

fn requirement(node: &Node, defaults: RequirementDefaults, variants: &[String], files: &Files) -> Read<Requirement> {
    let keyed = Keyed::new(node, &keys::REQUIREMENT)?;
    let text = |key: &str| -> Read<String> { Ok(keyed.must(key)?.text(key)?.to_owned()) };
    let optional = |key: &str| keyed.get(key).map(|node| node.text(key).map(str::to_owned)).transpose();
    let (id, cites, statement) = (text("id")?, text("cites")?, text("statement")?);
    let wrong = |message: &str| Err(keyed.must("id")?.wrong(format!("{id}: {message}")));
    let applies: Vec<usize> = match keyed.get("variants") {
        None => (0..variants.len()).collect(),
        Some(names) => {
            let index = |name: &Node| {
                let word = name.text("a variant")?;
                let found = variants.iter().position(|known| known == word);
                found.ok_or_else(|| Mistake::unknown(name.spot, "variant", word, variants.iter().map(String::as_str)))
            };
            names.items("variants")?.iter().map(index).collect::<Read<_>>()?
        }
    };
    if applies.is_empty() {
        return wrong("it applies to no variant");
    }
    let given = |key: &str, words: &'static [&'static str], default: Option<&'static str>| -> Read<&'static str> {
        let missing = || {
            let mistake = node.wrong(format!("a requirement needs the key `{key}`"));
            mistake
                .help(format!("write it here, or once for the whole file above `requirements`: `{key}: {}`", words[0]))
        };
        word(&keyed, key, words)?.or(default).ok_or_else(missing)
    };
    let level = given("level", keys::LEVELS, None)?;
    let source = given("source", keys::SOURCES, defaults.source)?;
    let channel = given("channel", keys::CHANNELS, defaults.channel)?;
    let ambiguity = optional("ambiguity")?;
    if level == "must" && (source != "manual" || ambiguity.is_some()) {
        return wrong("only what the manual says without ambiguity is `must`");
    }
    let class = word(&keyed, "class", keys::CLASSES)?;
    let class = match (class, optional("reason")?, optional("reading")?) {
        (None, None, None) => RequirementClass::Testable,
        (Some("implicit"), Some(reason), None) => RequirementClass::Implicit(reason),
        (Some("untestable"), Some(reason), None) => RequirementClass::Untestable(reason),
        (Some("out-of-scope"), Some(reason), None) => RequirementClass::OutOfScope(reason),
        (Some("contradictory"), None, Some(reading)) => RequirementClass::Contradictory(reading),
        (Some("contradictory"), ..) => return wrong("`contradictory` needs the `reading` that was chosen"),
        (Some(_), ..) => return wrong("its class needs a `reason`, and nothing else"),
        (None, ..) => return wrong("`reason` and `reading` go with a `class`"),
    };
    Ok(Requirement {
        level: match level {
            "must" => Level::Must,
            "should" => Level::Should,
            _ => Level::Info,
        },
        source: match source {
            "manual" => RequirementSource::Manual,
            "profile" => RequirementSource::Profile,
            _ => RequirementSource::Convention,
        },
        channel: channel.to_owned(),
        at: files.location(keyed.must("id")?.spot),
        id,
        cites,
        statement,
        variants: applies,
        ambiguity,
        class,
    })
}

/// The value of a key that is one of some words, none without the key.
fn word(keyed: &Keyed<'_>, key: &str, words: &'static [&'static str]) -> Read<Option<&'static str>> {
    let Some(node) = keyed.get(key) else { return Ok(None) };
    let text = node.text(key)?;
    let found = words.iter().find(|known| **known == text);
    found.map(|word| Some(*word)).ok_or_else(|| Mistake::unknown(node.spot, key, text, words.iter().copied()))
}

/// The names in a list of bugs, or none if it cannot be read.
fn bug_names(text: &str) -> Option<Vec<String>> {
    let node = parse(0, text).ok()?;
    let bugs = Keyed::new(&node, &keys::BUGS).ok()?.must("bugs").ok()?;
    bugs.entries("bugs").ok()?.iter().map(|(name, _)| name.scalar().map(str::to_owned)).collect()
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
        let Some(node) = mistakes.keep(parse(*file, text.as_ref())) else { continue };
        let entries = || Keyed::new(&node, &keys::BUGS)?.must("bugs")?.entries("bugs");
        for (name, ids) in mistakes.keep(entries()).unwrap_or_default() {
            let Some(bug) = mistakes.keep(bug(name, ids, requirements, sentence, files)) else { continue };
            match list.iter().any(|(known, _)| known.name == bug.name) {
                true => mistakes.note(name.wrong(format!("duplicate bug `{}`", bug.name))),
                false => list.push((bug, name.spot)),
            }
        }
    }
    list.sort_by_key(|(_, spot)| *spot);
    list
}

fn bug(
    name: &Node,
    ids: &Node,
    requirements: &FxHashMap<String, (usize, Vec<usize>)>,
    sentence: &dyn Fn(&str) -> String,
    files: &Files,
) -> Read<Bug> {
    let text = name.text("the name of a bug")?;
    let index = |id: &Node| {
        let word = id.text("a requirement")?;
        let unknown = || {
            let mut known: Vec<&str> = requirements.keys().map(String::as_str).collect();
            known.sort_unstable();
            Mistake::unknown(id.spot, "requirement", word, known)
        };
        requirements.get(word).map(|(index, _)| *index).ok_or_else(unknown)
    };
    let breaks = ids.items("the requirements that it breaks")?.iter().map(index).collect::<Read<Vec<usize>>>()?;
    match breaks.is_empty() {
        true => Err(name.wrong(format!("`{text}` breaks nothing"))),
        false => Ok(Bug { name: text.to_owned(), why: sentence(text), breaks, at: files.location(name.spot) }),
    }
}
