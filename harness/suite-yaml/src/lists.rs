//! The plain lists of a manual: its requirements and the bugs of its reference device, each in one file or several.

use super::error::{Mistake, Mistakes, Read, Spot, both, every};
use super::keys::{Key, Keyed, WordChoices};
use super::source::{Files, Sources};
use super::yaml::{Node, parse};
use rustc_hash::{FxHashMap, FxHashSet};
use std::sync::{Arc, OnceLock};
use suite::model::{Bug, Level, OtherReadings, Requirement, RequirementClass, RequirementSource};

/// How strict a requirement is.
static LEVELS: WordChoices<Level> =
    WordChoices(&[("must", Level::Must), ("should", Level::Should), ("info", Level::Info)]);
/// Where a requirement comes from.
static SOURCES: WordChoices<RequirementSource> = WordChoices(&[
    ("manual", RequirementSource::Manual),
    ("profile", RequirementSource::Profile),
    ("convention", RequirementSource::Convention),
]);
/// Where a requirement can be observed.
static CHANNELS: WordChoices<&str> = WordChoices(&[
    ("cyclic", "cyclic"),
    ("acyclic", "acyclic"),
    ("startup", "startup"),
    ("record", "record"),
    ("dcp", "dcp"),
    ("alarm", "alarm"),
    ("web", "web"),
    ("model", "model"),
    ("diagnosis", "diagnosis"),
]);

/// Why no case can cover a requirement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WhyUncovered {
    Implicit,
    Untestable,
    OutOfScope,
    NoCheck,
    Contradictory,
}

static CLASSES: WordChoices<WhyUncovered> = WordChoices(&[
    ("implicit", WhyUncovered::Implicit),
    ("untestable", WhyUncovered::Untestable),
    ("out-of-scope", WhyUncovered::OutOfScope),
    ("no-check", WhyUncovered::NoCheck),
    ("contradictory", WhyUncovered::Contradictory),
]);

key_set! {
    pub(crate) requirements "a file of requirements" {
        encspec may Pattern(&crate::needed_version::VERSIONS), "The versions of encspec that can read this file, for instance `>=0.2`.";
        source may Word(&SOURCES), "The source of each requirement of the file that names none itself.";
        channel may Word(&CHANNELS), "The channel of each requirement of the file that names none itself.";
        requirements must NonEmpty(&Keys(&requirement::KEYS)), "The requirements of one topic of the manual.";
    }
}

key_set! {
    pub(crate) requirement "a requirement" {
        id must Text, "Its id, unique in the manual; it stays when the requirement moves.";
        cites must Text, "The clause: section, table, page.";
        statement must Text, "What the clause says of the device, in one sentence of our own.";
        level must Word(&LEVELS), "How strict it is; `must` only where the manual, or a profile that it refers to, says it without ambiguity.";
        source may Word(&SOURCES), "Who says it: the manual, a profile that it refers to, or common practice; by default as the file says.";
        channel may Word(&CHANNELS), "Where it can be observed; by default as the file says.";
        variants may NonEmpty(&Text), "The variants that it applies to, all by default.";
        ambiguity may Text, "What the manual leaves open, and the reading that was chosen.";
        class may Word(&CLASSES), "Why no case can cover it; without a class it can be tested.";
        reason may Text, "The reason of its class.";
        reading may Text, "With `class: contradictory`: the reading that was chosen.";
        variations may NonEmpty(&Text), "With `ambiguity` or `contradictory`: the permitted variations of a device by another reading.";
        no_variation may Text, "Instead: why no device can show another reading.";
    }
}

key_set! {
    pub(crate) bugs "a list of bugs" {
        encspec may Pattern(&crate::needed_version::VERSIONS), "The versions of encspec that can read this file, for instance `>=0.2`.";
        bugs must Names(&NonEmpty(&Text)), "For each bug of the reference device the requirements that it breaks.";
    }
}

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
    source: Option<RequirementSource>,
    channel: Option<&'static str>,
}

fn entries(node: &Node) -> Read<(RequirementDefaults, &[Node])> {
    let keyed = Keyed::new(node, &requirements::KEYS)?;
    let list = keyed.must(&requirements::requirements)?;
    let defaults = RequirementDefaults {
        source: keyed.word(&requirements::source, &SOURCES)?,
        channel: keyed.word(&requirements::channel, &CHANNELS)?,
    };
    match list.items("requirements")? {
        [] => Err(list.wrong("there are no requirements")),
        entries => Ok((defaults, entries)),
    }
}

fn requirement(node: &Node, defaults: RequirementDefaults, variants: &[String], files: &Files) -> Read<Requirement> {
    let keyed = Keyed::new(node, &requirement::KEYS)?;
    let text = |key: &Key| -> Read<String> { Ok(keyed.must(key)?.text(key.name)?.to_owned()) };
    let optional = |key: &Key| keyed.get(key).map(|node| node.text(key.name).map(str::to_owned)).transpose();
    let (id, cites, statement) = (text(&requirement::id)?, text(&requirement::cites)?, text(&requirement::statement)?);
    let wrong = |message: &str| Err(keyed.must(&requirement::id)?.wrong(format!("{id}: {message}")));
    let applies: Vec<usize> = match keyed.get(&requirement::variants) {
        None => (0..variants.len()).collect(),
        Some(names) => {
            let index = |name: &Node| {
                let word = name.text("a variant")?;
                let found = variants.iter().position(|known| known == word);
                found.ok_or_else(|| Mistake::unknown(name.spot, "variant", word, variants.iter().map(String::as_str)))
            };
            every(names.items("variants")?.iter().map(index))?
        }
    };
    if applies.is_empty() {
        return wrong("it applies to no variant");
    }
    let missing = |key: &Key| {
        let mistake = node.wrong(format!("a requirement needs the key `{}`", key.name));
        mistake.help(format!("write it here, or once for the whole file above `requirements`: `{}: ...`", key.name))
    };
    let level = keyed.must(&requirement::level).and_then(|node| LEVELS.read(node, &requirement::level));
    let source = keyed.word(&requirement::source, &SOURCES);
    let source = source.and_then(|own| own.or(defaults.source).ok_or_else(|| missing(&requirement::source)));
    let channel = keyed.word(&requirement::channel, &CHANNELS);
    let channel = channel.and_then(|own| own.or(defaults.channel).ok_or_else(|| missing(&requirement::channel)));
    let ((level, source), channel) = both(both(level, source), channel)?;
    let ambiguity = optional(&requirement::ambiguity)?;
    if level == Level::Must && (source == RequirementSource::Convention || ambiguity.is_some()) {
        return wrong("only what the manual or its profile says without ambiguity is `must`");
    }
    let varied = match keyed.get(&requirement::variations) {
        None => Vec::new(),
        Some(names) => {
            let name = |name: &Node| name.text("a variation").map(str::to_owned);
            names.items("variations")?.iter().map(name).collect::<Read<_>>()?
        }
    };
    let varied = match (varied.is_empty(), optional(&requirement::no_variation)?) {
        (false, None) => OtherReadings::Varied(varied),
        (true, Some(why)) => OtherReadings::Invisible(why),
        (true, None) => OtherReadings::Unknown,
        (false, Some(_)) => return wrong("it has either `variations` or `no_variation`"),
    };
    let class = keyed.word(&requirement::class, &CLASSES)?;
    let class = match (class, optional(&requirement::reason)?, optional(&requirement::reading)?) {
        (None, None, None) => RequirementClass::Testable,
        (Some(WhyUncovered::Implicit), Some(reason), None) => RequirementClass::Implicit(reason),
        (Some(WhyUncovered::Untestable), Some(reason), None) => RequirementClass::Untestable(reason),
        (Some(WhyUncovered::OutOfScope), Some(reason), None) => RequirementClass::OutOfScope(reason),
        (Some(WhyUncovered::NoCheck), Some(reason), None) => RequirementClass::NoCheck(reason),
        (Some(WhyUncovered::Contradictory), None, Some(reading)) => RequirementClass::Contradictory(reading),
        (Some(WhyUncovered::Contradictory), ..) => return wrong("`contradictory` needs the `reading` that was chosen"),
        (Some(_), ..) => return wrong("its class needs a `reason`, and nothing else"),
        (None, ..) => return wrong("`reason` and `reading` go with a `class`"),
    };
    if varied != OtherReadings::Unknown && ambiguity.is_none() && !matches!(class, RequirementClass::Contradictory(_)) {
        return wrong("`variations` and `no_variation` go with an `ambiguity` or `class: contradictory`");
    }
    Ok(Requirement {
        level,
        source,
        channel: channel.to_owned(),
        at: files.location(keyed.must(&requirement::id)?.spot),
        id,
        cites,
        statement,
        variants: applies,
        ambiguity,
        other_readings: varied,
        class,
    })
}

/// The names in a list of bugs, or none if it cannot be read.
fn bug_names(text: &str) -> Option<Vec<String>> {
    let node = parse(0, text).ok()?;
    let bugs = Keyed::new(&node, &bugs::KEYS).ok()?.must(&bugs::bugs).ok()?;
    bugs.entries("bugs").ok()?.iter().map(|(name, _)| name.scalar().map(str::to_owned)).collect()
}

/// The bugs of all manuals, which are read when a common suite names one that this manual does not have.
#[derive(Clone, Debug, Default)]
pub(super) struct AllBugs(Arc<OnceLock<Option<FxHashSet<String>>>>);

impl AllBugs {
    /// Fails if no manual lists the bug `name`, which stands at `at`.
    pub(super) fn lists(&self, sources: &Sources, name: &str, at: &Node) -> Read<()> {
        let read = || {
            let lists = sources.lists_of_bugs().map(bug_names);
            // A list that cannot be read is reported by the manual that it belongs to.
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
        let entries = || Keyed::new(&node, &bugs::KEYS)?.must(&bugs::bugs)?.entries("bugs");
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
    let breaks = every(ids.items("the requirements that it breaks")?.iter().map(index))?;
    match breaks.is_empty() {
        true => Err(name.wrong(format!("`{text}` breaks nothing"))),
        false => Ok(Bug { name: text.to_owned(), why: sentence(text), breaks, at: files.location(name.spot) }),
    }
}
