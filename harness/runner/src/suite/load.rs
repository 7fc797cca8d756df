//! From files to manuals: what is compiled in which order, and what is compared at the end.

use super::base::{BUGS, Base, COMMON, REQUIREMENTS, common, common_suite, is_part};
use super::case::{Compiled, Topic};
use super::device_yaml::Described;
use super::error::{LoadError, LoadErrors, Mistake, Mistakes};
use super::lists;
use super::model::{Manual, Variant};
use super::names::{Names, Used};
use super::source::{Files, Sources};
use super::step::Ground;
use super::yaml::{self, Node};
use std::borrow::Cow;
use std::cmp::Reverse;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Whether a file of a manual's folder holds cases or rules, by its name.
fn is_topic(name: &str) -> bool {
    !["device", "procedures"].contains(&name) && ![REQUIREMENTS, BUGS].iter().any(|list| is_part(name, list))
}

/// Loads the manuals of `sources`, or only the one of the name `only`.
///
/// Everything that is wrong in them comes back at once, in the order of files and lines.
pub fn load(sources: &Sources, only: Option<&str>) -> Result<Vec<Manual>, LoadErrors> {
    let known = sources.manuals();
    let (mut manuals, mut errors) = (Vec::new(), Vec::new());
    let wanted = known.iter().filter(|folder| only.is_none_or(|only| only == folder.as_str()));
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
    let threads = thread::available_parallelism().map_or(1, usize::from).min(folders.len());
    if threads < 2 {
        return folders.iter().map(|folder| manual(sources, folder)).collect();
    }
    // The folders with most to read come first, so that the last thread to end ends early.
    let mut order: Vec<usize> = (0..folders.len()).collect();
    order.sort_by_key(|&at| Reverse(sources.names_in(folders[at]).len()));
    let next = AtomicUsize::new(0);
    let work = || {
        let mut loaded = Vec::new();
        while let Some(&at) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            loaded.push((at, manual(sources, folders[at])));
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

fn manual(sources: &Sources, folder: &str) -> Result<Manual, LoadErrors> {
    let (mut files, mistakes) = (Files::default(), Mistakes::default());
    let manual = read(sources, folder, None, &mut files, &mistakes);
    manual.ok_or_else(|| files.errors(&mistakes))
}

fn read(
    sources: &Sources,
    folder: &str,
    known: Option<&Base>,
    files: &mut Files,
    mistakes: &Mistakes,
) -> Option<Manual> {
    let base = Base::read(sources, folder, known, files, mistakes)?;
    let nodes = parse(sources, folder, files, mistakes);
    let used = Used::default();
    let ground = base.ground(sources, files, mistakes);
    let variants = topics(&base, &base.common, &nodes, &ground, &used);
    if mistakes.count() == 0 {
        for (bug, spot) in
            base.bugs.iter().zip(&base.bug_spots).filter(|(bug, _)| !used.has(&format!("bug `{}`", bug.name)))
        {
            mistakes.note(Mistake::new(*spot, format!("no case catches the bug `{}`", bug.name)));
        }
    }
    if mistakes.count() > 0 {
        return None;
    }
    let Base { described: Described { device, .. }, requirements, bugs, declared, .. } = base;
    let unused = declared
        .into_iter()
        .filter(|(name, _)| !used.has(name))
        .map(|(name, spot)| (name, files.location(spot)))
        .collect();
    Some(Manual { device: Arc::new(device), requirements, bugs, variants, unused })
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
    nodes: &[(String, Node)],
    ground: &Ground<'_>,
    used: &Used,
) -> Vec<Variant> {
    let common = |name: &Node| common(suites, name);
    let read = nodes.iter().filter_map(|(file, node)| ground.mistakes.keep(Topic::read(node, file, ground, &common)));
    let topics: Vec<Topic<'_>> = read.collect();
    let variants = (0..base.described.device.variants.len())
        .map(|variant| compile(&base.described, variant, &topics, ground, used));
    variants.collect()
}

fn compile(described: &Described, variant: usize, topics: &[Topic<'_>], ground: &Ground<'_>, used: &Used) -> Variant {
    let names = Names::new(described, variant, used, ground.mistakes);
    let (mut trials, mut rules) = (Vec::new(), Vec::new());
    for topic in topics {
        if ground.mistakes.enough() {
            break;
        }
        let Compiled { trials: more, rules: others } = topic.compile(ground, &names);
        trials.extend(more);
        rules.extend(others);
    }
    names.into_variant(trials, rules)
}

/// A manual that loads, against which the text of a single file can be checked quickly.
pub struct Checker {
    sources: Sources,
    folder: String,
    base: Base,
    files: Files,
    /// The parsed topic files.
    nodes: Vec<(String, Node)>,
}

impl Checker {
    /// Fails as [`load`] does if the manual `folder` has a mistake.
    pub fn new(sources: &Sources, folder: &str) -> Result<Checker, LoadErrors> {
        load(sources, Some(folder))?;
        let (mut files, mistakes) = (Files::default(), Mistakes::default());
        match Base::read(sources, folder, None, &mut files, &mistakes) {
            Some(base) => {
                let nodes = parse(sources, folder, &mut files, &mistakes);
                Ok(Checker { sources: sources.clone(), folder: folder.to_owned(), base, files, nodes })
            }
            None => Err(files.errors(&mistakes)),
        }
    }

    /// The first mistakes of the manual if the file `path` (below `suites`) had this text.
    ///
    /// A topic file, a file of requirements and one of bugs are looked at alone: with which others they collide, and which bugs the
    /// cases name, is not seen.
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
            lists::bugs(&[(opened.0, opened.1)], &self.base.index, &files, &mistakes);
        } else if folder == self.folder && is_topic(name) {
            if let Some(node) = mistakes.keep(yaml::parse(opened.0, &opened.1)) {
                self.compile(&self.base.common, &[(name.to_owned(), node)], &files, &mistakes);
            }
        } else if folder == COMMON && name != "procedures" {
            let node = mistakes.keep(yaml::parse(opened.0, &opened.1).and_then(|node| common_suite(node, name)));
            let using = |(_, node): &&(String, Node)| node.get("use").and_then(Node::scalar) == Some(name);
            let using: Vec<(String, Node)> = self.nodes.iter().filter(using).cloned().collect();
            if let Some(node) = node {
                self.compile(&[(name.to_owned(), node)], &using, &files, &mistakes);
            }
        } else {
            files = Files::default();
            read(&self.sources.clone().with(path, text), &self.folder, Some(&self.base), &mut files, &mistakes);
        }
        if mistakes.count() == 0 { Ok(()) } else { Err(files.errors(&mistakes)) }
    }

    fn compile(&self, suites: &[(String, Node)], nodes: &[(String, Node)], files: &Files, mistakes: &Mistakes) {
        topics(&self.base, suites, nodes, &self.base.ground(&self.sources, files, mistakes), &Used::default());
    }
}
