//! What all topic files of a manual stand on: the device, the requirements, the bugs, the procedures, the common suites.

use super::also::{self, Also};
use super::device_yaml::{self, Described};
use super::error::{Mistake, Mistakes, Read, Spot};
use super::keys::Keyed;
use super::lists::{self, AllBugs};
use super::source::{
    ANY_DEVICE, ANY_ENCODER, ANY_SLAVE, BUGS, COMMON, Files, REQUIREMENTS, Sources, is_list_of_bugs, is_part,
};
use super::step::{LoadContext, Procedure};
use super::taken;
use super::topic_keys::{common_suite, procedure, procedures};
use super::yaml::{self, Node, mentions};
use rustc_hash::FxHashMap;
use std::borrow::Cow;
use suite::model::{Bug, Requirement};

/// Everything of a manual but its topic files.
pub(super) struct Base {
    pub described: Described,
    pub requirements: Vec<Requirement>,
    /// Number of each requirement by id, with the variants it applies to.
    pub index: FxHashMap<String, (usize, Vec<usize>)>,
    pub bugs: Vec<Bug>,
    /// The bugs of all manuals.
    elsewhere: AllBugs,
    /// Where each bug stands, in the order of `bugs`.
    pub bug_spots: Vec<Spot>,
    procedures: FxHashMap<String, Procedure>,
    /// The common suites by name.
    pub common: Vec<(String, Node)>,
    /// Everything that was declared and can go unused.
    pub declared: Vec<(String, Spot)>,
    /// The suites that the manual uses too.
    pub also: Vec<Also>,
}

impl Base {
    /// Reads everything in the folder `folder` but its topic files; none if there is a mistake.
    ///
    /// `known` are the requirements if they were read before for the same variants; `elsewhere` is shared by all manuals of
    /// `sources`.
    pub(super) fn read(
        sources: &Sources,
        folder: &str,
        known: Option<&Base>,
        elsewhere: &AllBugs,
        files: &mut Files,
        mistakes: &Mistakes,
    ) -> Option<Base> {
        let mut open = |folder: &str, name: &str| {
            let (file, text) = files.open(sources, folder, name)?;
            mistakes.keep(yaml::parse(file, &text))
        };
        let device = open(folder, "device")?;
        let procedures: Vec<Node> =
            [open(COMMON, "procedures"), open(folder, "procedures")].into_iter().flatten().collect();
        let mut common = Vec::new();
        for name in sources.names_in(COMMON).into_iter().filter(|name| name != "procedures") {
            let suite = open(COMMON, &name).and_then(|node| mistakes.keep(common_suite(node, &name)));
            common.extend(suite.map(|node| (name, node)));
        }
        let is_described = sources.is_described && [ANY_DEVICE, ANY_SLAVE, ANY_ENCODER].contains(&folder);
        if is_described && folder == ANY_DEVICE && device.get("bus").and_then(Node::scalar) == Some("profibus") {
            let mistake = device.key("bus").wrong("without a manual only devices on PROFINET are tested");
            mistakes.note(mistake.help("write a suite for the slave from its GSD: `encspec suite init --gsd FILE`"));
            return None;
        }
        let mut described = device_yaml::read(&device, folder, is_described, mistakes)?;
        sources.times.apply(&mut described.device.timing);
        let variants = &described.device.variants;
        let is_known = known.is_some();
        let mut requirements = match known.filter(|known| known.described.device.variants == *variants) {
            Some(known) => known.requirements.clone(),
            None => {
                let parts = parts(sources, folder, REQUIREMENTS, files);
                if parts.is_empty() {
                    mistakes.note(device.wrong(format!("there is no file {folder}/requirements.yaml")));
                    return None;
                }
                lists::requirements(&parts, variants, files, mistakes)
            }
        };
        let mut also = if is_known { Vec::new() } else { also::read(&device, folder, &sources.manuals(), mistakes) };
        for of in &mut also {
            let parts = parts(sources, &of.suite, REQUIREMENTS, files);
            let first = requirements.len();
            requirements.extend(lists::requirements(&parts, variants, files, mistakes));
            of.requirements = first..requirements.len();
            let (own, taken) = requirements.split_at(first);
            if let Some(both) = taken.iter().find(|of| own.iter().any(|own| own.id == of.id)) {
                mistakes.note(of.at.wrong(format!("both have a requirement `{}`", both.id)));
            }
        }
        let place = |(index, requirement): (usize, &Requirement)| {
            (requirement.id.clone(), (index, requirement.variants.clone()))
        };
        let index: FxHashMap<String, (usize, Vec<usize>)> = requirements.iter().enumerate().map(place).collect();
        let mut bugs = Vec::new();
        if mistakes.count() == 0 {
            let parts = parts(sources, folder, BUGS, files);
            bugs = lists::bugs(&parts, &index, &|bug| sources.sentence(folder, bug), files, mistakes);
        }
        let (bugs, bug_spots) = bugs.into_iter().unzip();
        let mut of_procedures = Vec::new();
        let procedures = self::procedures(&procedures, mistakes, &mut of_procedures);
        let declared = described.declared.iter().cloned().chain(of_procedures).collect();
        let elsewhere = elsewhere.clone();
        let base =
            Base { described, requirements, index, bugs, elsewhere, bug_spots, procedures, common, declared, also };
        (mistakes.count() == 0).then_some(base)
    }

    /// The same with other texts of `device.yaml` and of the files of procedures, without requirements and common suites, which
    /// nothing is compiled on.
    ///
    /// None if there is a mistake, or if it has other variants, on which everything else depends.
    pub(super) fn with(
        &self,
        sources: &Sources,
        device: &Node,
        procedures: &[Node],
        mistakes: &Mistakes,
    ) -> Option<Base> {
        let before = &self.described.device;
        let mut described = device_yaml::read(device, &before.name, sources.is_described, mistakes)?;
        sources.times.apply(&mut described.device.timing);
        if described.device.variants != before.variants || mistakes.count() > 0 {
            return None;
        }
        let procedures = self::procedures(procedures, mistakes, &mut Vec::new());
        let also = also::read(device, &before.name, &sources.manuals(), mistakes);
        let base = Base {
            described,
            requirements: Vec::new(),
            index: self.index.clone(),
            bugs: self.bugs.clone(),
            elsewhere: self.elsewhere.clone(),
            bug_spots: self.bug_spots.clone(),
            procedures,
            common: Vec::new(),
            declared: Vec::new(),
            also,
        };
        (mistakes.count() == 0).then_some(base)
    }

    /// The bugs of all manuals where the file `path` (below `suites`) has another text.
    pub(super) fn elsewhere_with(&self, path: &str) -> AllBugs {
        if is_list_of_bugs(path) { AllBugs::default() } else { self.elsewhere.clone() }
    }

    /// What steps are compiled on.
    pub(super) fn ground<'g>(
        &'g self,
        sources: &'g Sources,
        files: &'g Files,
        mistakes: &'g Mistakes,
    ) -> LoadContext<'g> {
        let Base { described, index, bugs, procedures, elsewhere, .. } = self;
        let device = &described.device;
        LoadContext {
            device,
            sources,
            files,
            mistakes,
            requirements: index,
            procedures,
            bugs,
            elsewhere,
            is_generic: false,
        }
    }
}

/// The files of a list with their numbers, in the order of their names.
fn parts(sources: &Sources, folder: &str, list: &str, files: &mut Files) -> Vec<(u16, Cow<'static, str>)> {
    let names = sources.names_in(folder).into_iter().filter(|name| is_part(name, list));
    names.filter_map(|name| files.open(sources, folder, &name)).collect()
}

/// A common suite by the node that names it.
pub(super) fn common<'n>(suites: &'n [(String, Node)], name: &Node) -> Read<&'n Node> {
    let text = device_yaml::plain(name, "a common suite")?;
    match suites.iter().find(|(known, _)| known == text) {
        Some((_, node)) => Ok(node),
        None => Err(Mistake::unknown(name.spot, "common suite", text, suites.iter().map(|(name, _)| name.as_str()))),
    }
}

/// A common suite by itself: its name, and that what it takes is used.
pub(super) fn common_suite(node: Node, file: &str) -> Read<Node> {
    let keyed = Keyed::new(&node, &common_suite::KEYS)?;
    let name = keyed.must(&common_suite::common)?;
    if device_yaml::plain(name, "common")? != file {
        return Err(name.wrong(format!("this is the file `{file}`")).help(format!("write `common: {file}`")));
    }
    keyed.must(&common_suite::why)?.text("why")?;
    for (take, at) in
        keyed.get(&common_suite::takes).map_or(Ok(Vec::new()), |takes| device_yaml::named(takes, "takes"))?
    {
        taken::kind(at)?;
        let said = [keyed.get(&common_suite::cases), keyed.get(&common_suite::rules)]
            .into_iter()
            .flatten()
            .any(|part| mentions(part, take));
        if !said {
            return Err(at.wrong(format!("`{take}` is taken and never used")));
        }
    }
    Ok(node)
}

fn procedures(files: &[Node], mistakes: &Mistakes, declared: &mut Vec<(String, Spot)>) -> FxHashMap<String, Procedure> {
    let mut procedures = FxHashMap::default();
    for file in files {
        let list = Keyed::new(file, &procedures::KEYS)
            .and_then(|keyed| device_yaml::named(keyed.must(&procedures::procedures)?, "procedures"));
        for (name, node) in mistakes.keep(list).unwrap_or_default() {
            let Some(procedure) = mistakes.keep(procedure(node)) else { continue };
            declared.push((format!("procedure `{name}`"), node.spot));
            if procedures.insert(name.to_owned(), procedure).is_some() {
                mistakes.note(node.wrong(format!("the procedure `{name}` exists already")));
            }
        }
    }
    procedures
}

fn procedure(node: &Node) -> Read<Procedure> {
    let keyed = Keyed::new(node, &procedure::KEYS)?;
    let (takes, steps) = (keyed.must(&procedure::takes)?, keyed.must(&procedure::steps)?);
    let takes = if takes.items("takes")?.is_empty() { Vec::new() } else { device_yaml::labels(takes, "takes")? };
    if steps.items("steps")?.is_empty() {
        return Err(steps.wrong("a procedure without steps"));
    }
    match takes.iter().find(|take| !mentions(steps, take)) {
        Some(take) => Err(node.wrong(format!("`{take}` is taken and never used"))),
        None => Ok(Procedure { takes, steps: steps.clone(), about: keyed.get(&procedure::about).cloned() }),
    }
}
