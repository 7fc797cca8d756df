//! `also` of `device.yaml`: other suites whose topics a manual takes, what it gives them, and what it leaves out.
//!
//! A topic that is taken is read as it stands in its own folder, with these changes: what `give` names is given instead, and the cases
//! under `except` are left out. The requirements come with the topics; the bugs stay where they are listed.

use super::device_yaml::{also, contradicted, named};
use super::error::{Mistake, Mistakes, Read};
use super::keys::Keyed;
use super::topic_keys::{case, uses};
use super::yaml::{Node, NodeKind, mentions};
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};
use suite::model::{GenericSuite, LeftOutPart, Requirement, RequirementClass, SuiteVariant, Trial};
use suite::scan::each_step_of;

/// A suite that a manual uses too.
#[derive(Debug)]
pub(super) struct Also {
    /// Its folder.
    pub suite: String,
    /// Where it is named.
    pub at: Node,
    give: Vec<(String, Node)>,
    except: Vec<(Node, LeftOutPart)>,
    /// The places of its requirements among those of the manual.
    pub requirements: Range<usize>,
    /// What of `give` and `except` was met.
    met: Mutex<BTreeSet<String>>,
}

/// What stands under `also` in the text of a `device.yaml`.
pub(super) fn read(device: &Node, folder: &str, folders: &[String], mistakes: &Mistakes) -> Vec<Also> {
    let Some(node) = device.get("also") else { return Vec::new() };
    let mut list = Vec::new();
    for (suite, of) in mistakes.keep(named(node, "also")).unwrap_or_default() {
        if suite == folder || !folders.iter().any(|known| known == suite) {
            let known = folders.iter().map(String::as_str).filter(|known| *known != folder);
            mistakes.note(Mistake::unknown(node.key(suite).spot, "suite", suite, known));
            continue;
        }
        list.extend(mistakes.keep(one(node.key(suite), suite, of)));
    }
    list
}

fn one(at: &Node, suite: &str, node: &Node) -> Read<Also> {
    let keyed = Keyed::new(node, &also::KEYS)?;
    let give = keyed.get(&also::give).map_or(Ok(Vec::new()), |give| named(give, "give"))?;
    let give = give.into_iter().map(|(name, value)| (name.to_owned(), value.clone())).collect();
    let mut except = Vec::new();
    let mut left_out = |key: &Node, why: &Node, cites: Option<&Node>| -> Read<()> {
        let what = key.text("what is left out")?.to_owned();
        let filled = |node: &Node, what: &str| match node.text(what)? {
            text if text.trim().is_empty() => Err(node.wrong(format!("{what} is empty"))),
            text => Ok(text.to_owned()),
        };
        let cites = cites.map(|cites| filled(cites, "the clause")).transpose()?;
        except.push((key.clone(), LeftOutPart { what, why: filled(why, "the reason")?, cites }));
        Ok(())
    };
    for (key, why) in keyed.get(&also::except).map_or(Ok(&[][..]), |node| node.entries("except"))? {
        left_out(key, why, None)?;
    }
    for (key, node) in keyed.get(&also::contradicted).map_or(Ok(&[][..]), |node| node.entries("contradicted"))? {
        let keyed = Keyed::new(node, &contradicted::KEYS)?;
        left_out(key, keyed.must(&contradicted::why)?, Some(keyed.must(&contradicted::cites)?))?;
    }
    let (at, suite) = (at.clone(), suite.to_owned());
    Ok(Also { suite, at, give, except, requirements: 0..0, met: Mutex::default() })
}

impl Also {
    fn left_out(&self, what: &str) -> Option<&LeftOutPart> {
        let (_, found) = self.except.iter().find(|(_, of)| of.what == what)?;
        self.met().insert(what.to_owned());
        Some(found)
    }

    fn met(&self) -> MutexGuard<'_, BTreeSet<String>> {
        self.met.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The topics that the manual takes, with what it gives them; `own` are the names of its own topics.
    pub(super) fn topics(&self, nodes: &[(String, Node)], own: &[&str], mistakes: &Mistakes) -> Vec<(String, Node)> {
        let mut taken = Vec::new();
        for (name, node) in nodes {
            if self.left_out(name).is_some() {
                continue;
            }
            if own.contains(&name.as_str()) {
                let mistake = self.at.wrong(format!("this manual and `{}` both have a topic `{name}`", self.suite));
                mistakes.note(mistake.help(format!("leave it out with the reason: `except: {{ {name}: ... }}`")));
                continue;
            }
            taken.push((name.clone(), self.changed(name, node)));
        }
        taken
    }

    /// A topic file with what this manual gives and without what it leaves out.
    fn changed(&self, topic: &str, node: &Node) -> Node {
        let is_out = |id: &str| self.left_out(&format!("{topic}/{id}")).is_some();
        let is_kept = |key: &Node| key.scalar().is_none_or(|id| !is_out(id));
        let mut gone: Vec<(Node, Node)> = Vec::new();
        let entries = node.mapping().unwrap_or_default().iter().map(|(key, value)| {
            let mut value = value.clone();
            match (key.scalar().unwrap_or_default(), &mut value.kind) {
                ("give", NodeKind::Mapping(given)) => {
                    given.iter_mut().for_each(|(name, value)| self.instead(name, value))
                }
                ("defaults", NodeKind::Mapping(defaults)) => {
                    let start = defaults.iter_mut().filter(|(key, _)| key.scalar() == Some("start"));
                    for (_, start) in start {
                        if let NodeKind::Mapping(start) = &mut start.kind {
                            start.iter_mut().for_each(|(name, value)| {
                                if name.scalar() == Some("module") {
                                    self.instead(name, value);
                                }
                            });
                        }
                    }
                }
                ("covers" | "rows" | "catches" | "variants", NodeKind::Mapping(by_id)) => {
                    gone.extend(
                        by_id.iter().filter(|(key, _)| !is_kept(key)).map(|(key, _)| (key.clone(), key.clone())),
                    );
                    by_id.retain(|(key, _)| is_kept(key));
                }
                ("cases" | "rules", NodeKind::Sequence(list)) => {
                    list.retain(|entry| entry.get(case::id.name).is_none_or(is_kept));
                }
                _ => {}
            }
            (key.clone(), value)
        });
        let mut entries: Vec<(Node, Node)> = entries.collect();
        let is_empty = |value: &Node| value.sequence().is_some_and(<[Node]>::is_empty);
        entries.retain(|(key, value)| {
            !(["cases", "rules"].contains(&key.scalar().unwrap_or_default()) && is_empty(value))
        });
        let mut known = BTreeSet::new();
        gone.retain(|(key, _)| known.insert(key.scalar().unwrap_or_default().to_owned()));
        let omit = entries.iter_mut().find(|(key, _)| key.scalar() == Some(uses::omit.name));
        match omit.map(|(_, omit)| &mut omit.kind) {
            Some(NodeKind::Mapping(omit)) => omit.extend(gone),
            _ if gone.is_empty() => {}
            _ => {
                let kind = NodeKind::Scalar { text: uses::omit.name.to_owned(), quoted: false };
                entries.push((Node { kind, ..node.clone() }, Node { kind: NodeKind::Mapping(gone), ..node.clone() }));
            }
        }
        Node { kind: NodeKind::Mapping(entries), ..node.clone() }
    }

    fn instead(&self, name: &Node, value: &mut Node) {
        let Some(name) = name.scalar() else { return };
        if let Some((_, given)) = self.give.iter().find(|(known, _)| known == name) {
            self.met().insert(format!("give {name}"));
            *value = given.clone();
        }
    }

    /// Drops the rows that are left out.
    pub(super) fn drop_rows(&self, trials: &mut Vec<Trial>) {
        trials.retain(|trial| self.left_out(&trial.id).is_none());
    }

    /// Notes what is given or left out in vain.
    pub(super) fn check_met(&self, nodes: &[(String, Node)], mistakes: &Mistakes) {
        let met = self.met();
        for (name, value) in self.give.iter().filter(|(name, _)| !met.contains(&format!("give {name}"))) {
            mistakes.note(value.wrong(format!("no topic that is taken of `{}` is given `{name}`", self.suite)));
        }
        for (key, of) in self.except.iter().filter(|(_, of)| !met.contains(&of.what)) {
            let topics = nodes.iter().map(|(name, _)| name.as_str());
            mistakes.note(match of.what.contains('/') {
                false => Mistake::unknown(key.spot, &format!("topic of `{}`", self.suite), &of.what, topics),
                true => key.wrong(format!("`{}` has no case or row `{}`", self.suite, of.what)),
            });
        }
    }

    /// Says of each requirement that only what is left out would cover why no case covers it.
    pub(super) fn explain_uncovered(
        &self,
        requirements: &mut [Requirement],
        variants: &[SuiteVariant],
        nodes: &[(String, Node)],
    ) {
        let trials = || variants.iter().flat_map(|variant| &variant.trials);
        let mut covered: BTreeSet<usize> = trials().flat_map(|trial| trial.covers.iter().copied()).collect();
        trials().for_each(|trial| each_step_of(trial, &mut |step| covered.extend(&step.covers)));
        covered.extend(variants.iter().flat_map(|variant| &variant.rules).flat_map(|rule| rule.covers.iter().copied()));
        for (index, requirement) in requirements.iter_mut().enumerate() {
            if !self.requirements.contains(&index)
                || covered.contains(&index)
                || requirement.class != RequirementClass::Testable
            {
                continue;
            }
            let found = self.except.iter().find(|(_, of)| {
                let (topic, case) =
                    of.what.split_once('/').map_or((of.what.as_str(), None), |(topic, case)| (topic, Some(case)));
                let node = nodes.iter().find(|(name, _)| name == topic).map(|(_, node)| node);
                node.is_some_and(|node| match case {
                    None => mentions(node, &requirement.id),
                    Some(case) => of_case(node, case, &requirement.id),
                })
            });
            if let Some((_, LeftOutPart { why, cites, .. })) = found {
                requirement.class = RequirementClass::OutOfScope(match cites {
                    Some(clause) => format!("the manual says otherwise, {clause}: {why}"),
                    None => why.clone(),
                });
            }
        }
    }

    /// What the manual says of it, for reports and listings.
    pub(super) fn into_suite(self, topics: Vec<String>) -> GenericSuite {
        let except = self.except.into_iter().map(|(_, of)| of).collect();
        GenericSuite { name: self.suite, topics, requirements: self.requirements, except }
    }
}

/// Whether a topic file names a requirement for a case, or for one of its rows: `case` or `case[row]`.
fn of_case(topic: &Node, case: &str, requirement: &str) -> bool {
    let (id, row) = case.split_once('[').map_or((case, None), |(id, row)| (id, Some(row.trim_end_matches(']'))));
    let by_id = ["covers", "rows"].iter().filter_map(|key| topic.get(key)?.get(id));
    let own = topic.get("cases").and_then(Node::sequence).unwrap_or_default();
    let own = own.iter().filter(|entry| entry.get(case::id.name).and_then(Node::scalar) == Some(id));
    by_id.chain(own).any(|node| match row {
        None => mentions(node, requirement),
        Some(row) => rows_named(node, row).iter().any(|node| mentions(node, requirement)),
    })
}

fn rows_named<'n>(node: &'n Node, row: &str) -> Vec<&'n Node> {
    let rows = node.sequence().or_else(|| node.get(case::with.name)?.sequence()).unwrap_or_default();
    rows.iter().filter(|entry| entry.get("row").and_then(Node::scalar) == Some(row)).collect()
}
