//! From files to manuals: what is compiled in which order, and what is compared at the end.

use super::also::Also;
use super::base::{Base, common, common_suite};
use super::case::{Compiled, Topic};
use super::device_yaml::Described;
use super::error::{LoadError, LoadErrors, Mistake, Mistakes};
use super::lists::{self, AllBugs};
use super::masks::{self, MASKS, MaskList};
use super::names::{Names, Used};
use super::needed_version;
use super::outline::outlined;
use super::source::{BUGS, COMMON, Files, REQUIREMENTS, Sources, is_part};
use super::step::LoadContext;
use super::yaml::{self, Node};
use std::borrow::Cow;
use std::cmp::Reverse;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use suite::compiled;
use suite::model::{Bug, Manual, SuiteVariant, Trial};

/// The name of the file that describes a device.
const DEVICE: &str = "device";
/// The name of a file of procedures.
const PROCEDURES: &str = "procedures";

/// Whether a file of a manual's folder holds cases or rules, by its name.
fn is_topic(name: &str) -> bool {
    ![DEVICE, PROCEDURES, MASKS].contains(&name) && ![REQUIREMENTS, BUGS].iter().any(|list| is_part(name, list))
}

/// Loads the manuals of `sources`, or only the one of the name `only`.
///
/// Everything that is wrong in them comes back at once, in the order of files and lines.
pub fn load(sources: &Sources, only: Option<&str>) -> Result<Vec<Manual>, LoadErrors> {
    load_those(sources, |name| only.is_none_or(|only| only == name), only)
}

/// Loads the manuals of `sources` whose names are in `names`, as [`load`] does; a name that no manual has is passed over.
pub fn load_some(sources: &Sources, names: &[&str]) -> Result<Vec<Manual>, LoadErrors> {
    load_those(sources, |name| names.contains(&name), None)
}

fn load_those(
    sources: &Sources,
    is_wanted: impl Fn(&str) -> bool,
    only: Option<&str>,
) -> Result<Vec<Manual>, LoadErrors> {
    let known = sources.manuals();
    needed_version::check(sources, &is_wanted)?;
    let (mut manuals, mut errors) = (Vec::new(), Vec::new());
    let wanted = known.iter().filter(|folder| is_wanted(folder));
    for loaded in at_once(sources, &wanted.collect::<Vec<_>>()) {
        match loaded {
            Ok(manual) => manuals.push(manual),
            Err(LoadErrors(list)) => errors.extend(list),
        }
    }
    if manuals.is_empty() && errors.is_empty() {
        errors.push(sources.no_manual(only));
    }
    // A mistake in a common file comes once with each manual that uses it.
    let mut once: Vec<LoadError> = Vec::new();
    errors.into_iter().for_each(|error| {
        if !once.contains(&error) {
            once.push(error)
        }
    });
    if once.is_empty() { Ok(manuals) } else { Err(LoadErrors(once)) }
}

/// Each folder as a manual, in their order; those of several are read by as many threads as there are cores.
fn at_once(sources: &Sources, folders: &[&String]) -> Vec<Result<Manual, LoadErrors>> {
    let to_compile = folders.iter().filter(|folder| sources.octets(folder).is_none()).count();
    let threads = thread::available_parallelism().map_or(1, usize::from).min(to_compile);
    let elsewhere = AllBugs::default();
    if threads < 2 {
        return folders.iter().map(|folder| manual(sources, folder, &elsewhere)).collect();
    }
    // The folders with most to read come first, so that the last thread to end ends early.
    let mut order: Vec<usize> = (0..folders.len()).collect();
    order.sort_by_key(|&at| Reverse(sources.names_in(folders[at]).len()));
    let next = AtomicUsize::new(0);
    let work = || {
        let mut loaded = Vec::new();
        while let Some(&at) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            loaded.push((at, manual(sources, folders[at], &elsewhere)));
        }
        loaded
    };
    let mut loaded: Vec<(usize, Result<Manual, LoadErrors>)> = thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let mut loaded = work();
        for other in others {
            match other.join() {
                Ok(more) => loaded.extend(more),
                Err(panic) => resume_unwind(panic),
            }
        }
        loaded
    });
    loaded.sort_by_key(|(at, _)| *at);
    loaded.into_iter().map(|(_, manual)| manual).collect()
}

fn manual(sources: &Sources, folder: &str, elsewhere: &AllBugs) -> Result<Manual, LoadErrors> {
    // Bytes that cannot be read are not of this build; the text says the same.
    if let Some(mut manual) = sources.octets(folder).and_then(|octets| compiled::read(octets).ok()) {
        manual.bugs.iter_mut().for_each(|bug| bug.why = sources.sentence(folder, &bug.name));
        return Ok(manual);
    }
    let (mut files, mistakes) = (Files::default(), Mistakes::default());
    let manual = read(sources, folder, None, elsewhere, &mut files, &mistakes);
    manual.ok_or_else(|| files.errors(&mistakes))
}

fn read(
    sources: &Sources,
    folder: &str,
    known: Option<&Base>,
    elsewhere: &AllBugs,
    files: &mut Files,
    mistakes: &Mistakes,
) -> Option<Manual> {
    let base = Base::read(sources, folder, known, elsewhere, files, mistakes)?;
    let nodes = parse(sources, folder, files, mistakes);
    if let Some((file, text)) = files.open(sources, folder, MASKS)
        && let Some(node) = mistakes.keep(yaml::parse(file, &text))
    {
        let used = Used::default();
        mistakes.keep(masks::read(&node, &Names::new(&base.described, 0, &used, mistakes)));
    }
    let used = Used::default();
    let own: Vec<&str> = nodes.iter().map(|(name, _)| name.as_str()).collect();
    let taken = base.also.iter().map(|also| Taken::read(also, sources, &own, files, mistakes)).collect::<Vec<_>>();
    let ground = base.ground(sources, files, mistakes);
    let variants = variants(&base, &base.common, &nodes.iter().collect::<Vec<_>>(), &taken, &ground, &used);
    for Taken { also, nodes, .. } in taken.iter().filter(|_| mistakes.count() == 0) {
        also.check_met(nodes, mistakes);
    }
    if mistakes.count() > 0 {
        return None;
    }
    let mut requirements = base.requirements.clone();
    for Taken { also, nodes, .. } in &taken {
        also.explain_uncovered(&mut requirements, &variants, nodes);
    }
    let topics: Vec<Vec<String>> = taken.into_iter().map(Taken::topics).collect();
    let Base { described: Described { device, .. }, bugs, declared, also, .. } = base;
    let also = also.into_iter().zip(topics).map(|(also, topics)| also.into_suite(topics)).collect();
    let unused = declared
        .into_iter()
        .filter(|(name, _)| !used.has(name))
        .map(|(name, spot)| (name, files.location(spot)))
        .collect();
    Some(outlined(Manual { device: Arc::new(device), requirements, bugs, variants, unused, also }))
}

/// The topics of a suite that a manual uses too.
struct Taken<'b> {
    also: &'b Also,
    /// The topic files as they stand in the folder of the suite.
    nodes: Vec<(String, Node)>,
    /// Those that are taken, as the manual has them.
    topics: Vec<(String, Node)>,
}

impl<'b> Taken<'b> {
    fn read(also: &'b Also, sources: &Sources, own: &[&str], files: &mut Files, mistakes: &Mistakes) -> Taken<'b> {
        let nodes = parse(sources, &also.suite, files, mistakes);
        let topics = also.topics(&nodes, own, mistakes);
        Taken { also, nodes, topics }
    }

    fn topics(self) -> Vec<String> {
        self.topics.into_iter().map(|(name, _)| name).collect()
    }
}

/// Every variant of a manual, whose bugs are all caught.
fn variants(
    base: &Base,
    common: &[(String, Node)],
    nodes: &[&(String, Node)],
    taken: &[Taken<'_>],
    ground: &LoadContext<'_>,
    used: &Used,
) -> Vec<SuiteVariant> {
    let variants = topics(base, common, nodes, taken, ground, used);
    if ground.mistakes.count() == 0 {
        let is_caught = |bug: &Bug| used.has(&format!("bug `{}`", bug.name));
        for (bug, spot) in base.bugs.iter().zip(&base.bug_spots).filter(|(bug, _)| !is_caught(bug)) {
            ground.mistakes.note(Mistake::new(*spot, format!("no case catches the bug `{}`", bug.name)));
        }
    }
    variants
}

/// The topic files of a folder by name.
fn parse(sources: &Sources, folder: &str, files: &mut Files, mistakes: &Mistakes) -> Vec<(String, Node)> {
    let names = sources.names_in(folder).into_iter().filter(|name| is_topic(name));
    let node = |name: String| {
        let (file, text) = files.open(sources, folder, &name)?;
        Some((name, mistakes.keep(yaml::parse(file, &text))?))
    };
    names.filter_map(node).collect()
}

/// Compiles topic files for each variant.
fn topics(
    base: &Base,
    suites: &[(String, Node)],
    nodes: &[&(String, Node)],
    taken: &[Taken<'_>],
    ground: &LoadContext<'_>,
    used: &Used,
) -> Vec<SuiteVariant> {
    let common = |name: &Node| common(suites, name);
    let read = nodes.iter().filter_map(|(file, node)| ground.mistakes.keep(Topic::read(node, file, ground, &common)));
    let topics: Vec<Topic<'_>> = read.collect();
    let generic = LoadContext { is_generic: true, ..*ground };
    let mut generic_topics: Vec<(&Also, Vec<Topic<'_>>)> = Vec::new();
    for of in taken {
        let read = of.topics.iter().map(|(file, node)| Topic::read(node, file, &generic, &common));
        generic_topics.push((of.also, read.filter_map(|read| ground.mistakes.keep(read)).collect()));
    }
    let variant = |variant: usize| {
        let names = Names::new(&base.described, variant, used, ground.mistakes);
        let mut compiled = compile(&topics, ground, &names);
        for (also, topics) in &generic_topics {
            let Compiled { mut trials, rules } = compile(topics, &generic, &names);
            also.drop_rows(&mut trials);
            compiled.trials.extend(trials);
            compiled.rules.extend(rules);
        }
        names.into_variant(compiled.trials, compiled.rules)
    };
    (0..base.described.device.variants.len()).map(variant).collect()
}

fn compile(topics: &[Topic<'_>], ground: &LoadContext<'_>, names: &Names<'_>) -> Compiled {
    let mut compiled = Compiled::default();
    for topic in topics {
        if ground.mistakes.enough() {
            break;
        }
        let Compiled { mut trials, rules } = topic.compile(ground, names);
        if ground.sources.is_for_rules {
            trials.iter_mut().for_each(Trial::forget_steps);
        }
        compiled.trials.extend(trials);
        compiled.rules.extend(rules);
    }
    compiled
}

/// A manual that loads, against which the text of a single file can be checked quickly.
pub struct Checker {
    sources: Sources,
    folder: String,
    base: Base,
    files: Files,
    device: Node,
    /// The parsed files of procedures: the common one and that of the manual.
    procedures: [Option<Node>; 2],
    /// The parsed topic files.
    nodes: Vec<(String, Node)>,
}

/// A checker serves several threads.
const _: () = {
    const fn is_shared<T: Send + Sync>() {}
    is_shared::<Checker>();
};

impl Checker {
    /// Fails as [`load`] does if the manual `folder` has a mistake.
    pub fn new(sources: &Sources, folder: &str) -> Result<Checker, LoadErrors> {
        load(sources, Some(folder))?;
        Checker::unchecked(sources, folder)
    }

    /// The same for a manual that was loaded already, so that its topic files need not be checked again.
    ///
    /// Fails if what all of them stand on has a mistake.
    pub fn unchecked(sources: &Sources, folder: &str) -> Result<Checker, LoadErrors> {
        let (mut files, mistakes) = (Files::default(), Mistakes::default());
        let Some(base) = Base::read(sources, folder, None, &AllBugs::default(), &mut files, &mistakes) else {
            return Err(files.errors(&mistakes));
        };
        let nodes = parse(sources, folder, &mut files, &mistakes);
        let mut open = |folder: &str, name: &str| {
            let (file, text) = files.open(sources, folder, name)?;
            mistakes.keep(yaml::parse(file, &text))
        };
        let procedures = [open(COMMON, PROCEDURES), open(folder, PROCEDURES)];
        let device = open(folder, DEVICE);
        let Some(device) = device else { return Err(files.errors(&mistakes)) };
        Ok(Checker { sources: sources.clone(), folder: folder.to_owned(), base, files, device, procedures, nodes })
    }

    /// The first mistakes of the manual if the file `path` (below `suites`) had this text.
    ///
    /// A topic file, a file of requirements and one of bugs are checked alone: with which others they collide, and which bugs the
    /// cases name, is not checked.
    pub fn check(&self, path: &str, text: &str) -> Result<(), LoadErrors> {
        let (folder, name) = path.split_once('/').unwrap_or(("", path));
        let name = name.trim_end_matches(".yaml");
        let mistakes = Mistakes::only_first();
        let mut files = self.files.clone();
        let sources = Sources::none().with(path, text);
        let opened = files.open(&sources, folder, name).map_or((0, Cow::Borrowed("")), |opened| opened);
        if folder == self.folder && is_part(name, REQUIREMENTS) {
            let parts = [(opened.0, opened.1)];
            lists::requirements(&parts, &self.base.described.device.variants, &files, &mistakes);
        } else if folder == self.folder && is_part(name, BUGS) {
            lists::bugs(&[(opened.0, opened.1)], &self.base.index, &|_| String::new(), &files, &mistakes);
        } else if folder == self.folder && is_topic(name) {
            if let Some(node) = mistakes.keep(yaml::parse(opened.0, &opened.1)) {
                self.compile(&self.base.common, &[&(name.to_owned(), node)], &files, &mistakes);
            }
        } else if folder == COMMON && name != "procedures" {
            let node = mistakes.keep(yaml::parse(opened.0, &opened.1).and_then(|node| common_suite(node, name)));
            let using = |(_, node): &&(String, Node)| node.get("use").and_then(Node::scalar) == Some(name);
            let using: Vec<&(String, Node)> = self.nodes.iter().filter(using).collect();
            if let Some(node) = node {
                self.compile(&[(name.to_owned(), node)], &using, &files, &mistakes);
            }
        } else if folder == self.folder
            && let Some(base) = self.base_with(name, opened.0, &opened.1, &mistakes)
        {
            let (used, common) = (Used::default(), &self.base.common);
            let ground = base.ground(&self.sources, &files, &mistakes);
            variants(&base, common, &self.likely_first(path, text), &[], &ground, &used);
            let own: Vec<&str> = self.nodes.iter().map(|(name, _)| name.as_str()).collect();
            // The topics of other suites are read only where those of the manual show no mistake.
            for also in base.also.iter().filter(|_| mistakes.count() == 0) {
                let taken = Taken::read(also, &self.sources, &own, &mut files, &mistakes);
                let ground = base.ground(&self.sources, &files, &mistakes);
                topics(&base, common, &[], std::slice::from_ref(&taken), &ground, &used);
                also.check_met(&taken.nodes, &mistakes);
            }
        } else if mistakes.count() == 0 {
            files = Files::default();
            let sources = self.sources.clone().with(path, text);
            let elsewhere = self.base.elsewhere_with(path);
            read(&sources, &self.folder, Some(&self.base), &elsewhere, &mut files, &mistakes);
        }
        if mistakes.count() == 0 { Ok(()) } else { Err(files.errors(&mistakes)) }
    }

    /// What is not compared where a device is held against a capture: `text`, else the file `masks.yaml` of the manual.
    ///
    /// Fails with the mistakes of the text, which `path` names.
    pub fn masks(&self, named: Option<(&str, &str)>) -> Result<MaskList, LoadErrors> {
        let mistakes = Mistakes::default();
        let mut files = Files::default();
        let own = format!("{}/{MASKS}.yaml", self.folder);
        let sources = match named {
            Some((path, text)) => Sources::none().with(&own, text).called(&own, path),
            None => self.sources.clone(),
        };
        let Some((file, text)) = files.open(&sources, &self.folder, MASKS) else { return Ok(MaskList::default()) };
        let used = Used::default();
        let names = Names::new(&self.base.described, 0, &used, &mistakes);
        let list = yaml::parse(file, &text).and_then(|node| masks::read(&node, &names));
        mistakes.keep(list).ok_or_else(|| files.errors(&mistakes))
    }

    /// The manual with the cases of one topic file and no others, for a file that stands in no folder.
    ///
    /// `path` is below `suites`: the folder of this manual and the name of the file. Fails with the first mistakes of the text.
    pub fn alone(&self, path: &str, text: &str) -> Result<Manual, LoadErrors> {
        self.beside(&[], path, text)
    }

    /// The same with the rules of the manual, which are judged in each trial of the file.
    pub fn with_rules(&self, path: &str, text: &str) -> Result<Manual, LoadErrors> {
        let has_rules = |node: &Node| node.get("rules").is_some();
        let uses_rules =
            |node: &Node| node.get("use").is_some_and(|used| common(&self.base.common, used).is_ok_and(has_rules));
        let others: Vec<&(String, Node)> =
            self.nodes.iter().filter(|(_, node)| has_rules(node) || uses_rules(node)).collect();
        self.beside(&others, path, text)
    }

    /// The topic file `path` with this text, and the rules of `others`.
    fn beside(&self, others: &[&(String, Node)], path: &str, text: &str) -> Result<Manual, LoadErrors> {
        let name = path.rsplit('/').next().unwrap_or(path).trim_end_matches(".yaml");
        let mistakes = Mistakes::only_first();
        let mut files = self.files.clone();
        let sources = Sources::none().with(path, text);
        let opened = files.open(&sources, &self.folder, name).map_or((0, Cow::Borrowed("")), |opened| opened);
        let mut variants = Vec::new();
        if let Some(node) = mistakes.keep(yaml::parse(opened.0, &opened.1)) {
            let ground = self.base.ground(&self.sources, &files, &mistakes);
            let own = (name.to_owned(), node);
            let nodes = [&[&own], others].concat();
            variants = topics(&self.base, &self.base.common, &nodes, &[], &ground, &Used::default());
            let suite = own.1.get("suite").and_then(Node::scalar).unwrap_or(name);
            let is_own = |trial: &Trial| trial.id.split_once('/').is_some_and(|(topic, _)| topic == suite);
            variants.iter_mut().for_each(|variant| variant.trials.retain(is_own));
        }
        if mistakes.count() > 0 {
            return Err(files.errors(&mistakes));
        }
        let Base { described: Described { device, .. }, requirements, bugs, .. } = &self.base;
        let (device, requirements, bugs) = (Arc::new(device.clone()), requirements.clone(), bugs.clone());
        Ok(outlined(Manual { device, requirements, bugs, variants, unused: Vec::new(), also: Vec::new() }))
    }

    /// The topic files, first those that name what is no longer in the text of `path`: there a mistake is found soonest.
    fn likely_first(&self, path: &str, text: &str) -> Vec<&(String, Node)> {
        let file = |path: &str| self.sources.files().find(|(of, _)| *of == path).map_or("", |(_, text)| text);
        let gone = gone(file(path), text);
        let mut nodes: Vec<&(String, Node)> = self.nodes.iter().collect();
        nodes.sort_by_key(|(name, _)| !file(&format!("{}/{name}.yaml", self.folder)).contains(gone));
        nodes
    }

    /// What everything stands on with this text of the file `name`, the file number `file`; none where everything has to be read again.
    fn base_with(&self, name: &str, file: u16, text: &str, mistakes: &Mistakes) -> Option<Base> {
        let node = mistakes.keep(yaml::parse(file, text))?;
        let [common, own] = self.procedures.clone();
        let (device, own) = match name {
            DEVICE => (&node, own),
            PROCEDURES => (&self.device, Some(node.clone())),
            _ => return None,
        };
        let procedures: Vec<Node> = [common, own].into_iter().flatten().collect();
        self.base.with(&self.sources, device, &procedures, mistakes)
    }

    fn compile(&self, suites: &[(String, Node)], nodes: &[&(String, Node)], files: &Files, mistakes: &Mistakes) {
        topics(&self.base, suites, nodes, &[], &self.base.ground(&self.sources, files, mistakes), &Used::default());
    }
}

/// What stands in `before` where `after` has something else, out to the ends of its words.
fn gone<'a>(before: &'a str, after: &str) -> &'a str {
    let same = before.char_indices().zip(after.chars()).find(|((_, old), new)| old != new);
    let from = same.map_or(before.len(), |((at, _), _)| at);
    let tail = before.chars().rev().zip(after.chars().rev()).take_while(|(old, new)| old == new);
    let to = before.len() - tail.map(|(old, _)| old.len_utf8()).sum::<usize>();
    let is_edge = |letter: char| !letter.is_alphanumeric() && letter != '_';
    let edge = before[..from].char_indices().rev().find(|(_, letter)| is_edge(*letter));
    let begin = edge.map_or(0, |(at, letter)| at + letter.len_utf8());
    let to = to.max(from);
    let end = before[to..].find(is_edge).map_or(before.len(), |at| to + at);
    &before[begin..end]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_word_is_gone_as_a_whole() {
        assert_eq!(gone("a: home_position }", "a: home_pqsition }"), "home_position");
        assert_eq!(gone("a: b", "a: b"), "b");
        assert_eq!(gone("±word±", "±wqrd±"), "word");
        assert_eq!(gone("a: bc d", "a: c d"), "bc");
    }
}
