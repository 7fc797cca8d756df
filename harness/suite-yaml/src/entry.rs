//! The entries of a topic file or a common suite: cases and rules as they are written, with what a manual says of each.

use super::device_yaml::{label, labels, plain};
use super::error::{Mistake, Mistakes, Read};
use super::keys::Keyed;
use super::names::Names;
use super::step::LoadContext;
use super::topic_keys::{case, rule, topic};
use super::yaml::Node;
use plain_text::nearest;

/// A case or a rule; what both have is read by the keys of a case.
pub(super) struct TopicEntry<'n> {
    pub id: String,
    pub why: String,
    pub keyed: Keyed<'n>,
    /// What the manual says of it, where it is one of a common suite.
    pub shared: Option<CommonEntry<'n>>,
    pub is_case: bool,
    /// Whether it has an unknown key, which may be a misspelt one that is missed.
    pub is_partial: bool,
}

impl TopicEntry<'_> {
    /// The variants that it is meant for; the manual may leave some out of a common case.
    pub(super) fn variants(&self, names: &Names<'_>) -> Read<Vec<usize>> {
        let mut own = variants(self.keyed.get(&case::variants), names)?;
        if let Some(said) = self.shared.as_ref().and_then(|shared| shared.variants) {
            let narrowed = variants(Some(said), names)?;
            own.retain(|variant| narrowed.contains(variant));
            if own.is_empty() {
                return Err(said.wrong("no variant is left"));
            }
        }
        Ok(own)
    }

    /// The same; where the list has a mistake, which is noted, those that are probably meant.
    pub(super) fn variants_or_likely(&self, names: &Names<'_>, mistakes: &Mistakes) -> Vec<usize> {
        match self.variants(names) {
            Ok(variants) => variants,
            Err(mistake) => {
                mistakes.note(mistake);
                let known = &names.device().variants;
                let written = self.keyed.get(&case::variants).and_then(Node::sequence).unwrap_or_default();
                let meant = written.iter().filter_map(|item| nearest(item.scalar()?, known.iter().map(String::as_str)));
                meant.filter_map(|name| known.iter().position(|of| *of == name)).collect()
            }
        }
    }
}

/// What a manual says of a case or rule of a common suite.
pub(super) struct CommonEntry<'n> {
    /// Where it says it.
    pub at: &'n Node,
    pub covers: Option<&'n Node>,
    pub variants: Option<&'n Node>,
    pub rows: Option<&'n Node>,
    pub catches: Option<&'n Node>,
}

/// The cases and rules of a topic file or a common suite; ids are unique.
pub(super) fn entries<'n>(keyed: Keyed<'n>, ground: &LoadContext<'_>) -> Read<Vec<TopicEntry<'n>>> {
    let mut list: Vec<TopicEntry<'n>> = Vec::new();
    for (key, is_case) in [(&topic::cases, true), (&topic::rules, false)] {
        let Some(node) = keyed.get(key) else { continue };
        let items = node.items(key.name)?;
        if items.is_empty() {
            return Err(node.wrong(format!("an empty list of {}", key.name)));
        }
        for item in items {
            let Some(entry) = ground.mistakes.keep(self::entry(item, is_case, ground)) else { continue };
            if list.iter().any(|known| known.id == entry.id) {
                ground
                    .mistakes
                    .note(item.get(case::id.name).unwrap_or(item).wrong(format!("duplicate id `{}`", entry.id)));
            }
            list.push(entry);
        }
    }
    Ok(list)
}

fn entry<'n>(node: &'n Node, is_case: bool, ground: &LoadContext<'_>) -> Read<TopicEntry<'n>> {
    let set = if is_case { &case::KEYS } else { &rule::KEYS };
    let (keyed, is_partial) = Keyed::noting(node, set, ground.mistakes)?;
    let id = keyed.must(&case::id)?;
    let text = plain(id, "an id")?;
    label(id, text)?;
    let why = keyed.must(&case::why)?.text(case::why.name)?.to_owned();
    Ok(TopicEntry { id: text.to_owned(), why, keyed, shared: None, is_case, is_partial })
}

/// The variants of a list, all without one.
pub(super) fn variants(node: Option<&Node>, names: &Names<'_>) -> Read<Vec<usize>> {
    let known = &names.device().variants;
    let Some(node) = node else { return Ok((0..known.len()).collect()) };
    let list = labels(node, "variants")?;
    let index = |(at, name): (usize, &String)| {
        let at = node.sequence().and_then(|items| items.get(at)).unwrap_or(node);
        let found = known.iter().position(|known| known == name);
        found.ok_or_else(|| Mistake::unknown(at.spot, "variant", name, known.iter().map(String::as_str)))
    };
    list.iter().enumerate().map(index).collect()
}
