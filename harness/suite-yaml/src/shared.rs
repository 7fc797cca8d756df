//! What a manual makes of a common suite: what it gives, which cases and rules it takes, and what it says of each.

use super::base::mentions;
use super::device_yaml::named;
use super::entry::{CommonEntry, TopicEntry, entries};
use super::error::{Mistake, Read};
use super::frame::Column;
use super::keys::{Key, Keyed};
use super::step::LoadContext;
use super::taken;
use super::topic_keys::{case, common_suite, uses};
use super::yaml::Node;

/// A mapping of a file that uses a common suite, by the ids of cases and rules.
struct ById<'n> {
    node: Option<&'n Node>,
    entries: Vec<(&'n str, &'n Node)>,
}

impl<'n> ById<'n> {
    fn read(keyed: Keyed<'n>, key: &Key) -> Read<ById<'n>> {
        let node = keyed.get(key);
        let entries = node.map_or(Ok(Vec::new()), |node| named(node, key.name))?;
        Ok(ById { node, entries })
    }

    fn get(&self, id: &str) -> Option<&'n Node> {
        self.entries.iter().find(|(known, _)| *known == id).map(|(_, value)| *value)
    }

    /// The key of an id, to point at.
    fn key(&self, id: &str) -> Option<&'n Node> {
        self.node.filter(|_| self.get(id).is_some()).map(|node| node.key(id))
    }
}

/// The entries of a common suite that a manual uses, followed by its own, and what it gives.
pub(super) fn used<'n>(
    keyed: Keyed<'n>,
    ground: &LoadContext<'_>,
    common: &dyn Fn(&Node) -> Read<&'n Node>,
) -> Read<(Vec<TopicEntry<'n>>, Vec<Column>)> {
    let name = keyed.must(&uses::r#use)?;
    let common = Keyed::new(common(name)?, &common_suite::KEYS)?;
    let mut list = entries(common, ground)?;
    let own = entries(keyed, ground)?;
    if let Some(same) = own.iter().find(|own| list.iter().any(|entry| entry.id == own.id)) {
        let at = same.keyed.get(&case::id).unwrap_or(same.keyed.node);
        return Err(at
            .wrong(format!("`{}` is a case or rule of the common suite", same.id))
            .help("call the own one otherwise"));
    }
    let [covers, omit, rows, catches, variants] =
        [&uses::covers, &uses::omit, &uses::rows, &uses::catches, &uses::variants].map(|key| ById::read(keyed, key));
    let (covers, omit, rows, catches, variants) = (covers?, omit?, rows?, catches?, variants?);
    for said in [&covers, &omit, &rows, &catches, &variants] {
        for (id, node) in &said.entries {
            if !list.iter().any(|entry| entry.id == *id) {
                let known = list.iter().map(|entry| entry.id.as_str());
                let spot = said.key(id).unwrap_or(node).spot;
                return Err(Mistake::unknown(spot, "case of the common suite", id, known));
            }
        }
    }
    for said in [&covers, &rows, &catches, &variants] {
        if let Some((id, node)) = omit.entries.iter().find(|(id, _)| said.get(id).is_some()) {
            let what = if said.get(id).is_some() && covers.get(id).is_some() { "covered" } else { "spoken of" };
            return Err(node.wrong(format!("`{id}` is {what} and left out")));
        }
    }
    for (_, reason) in &omit.entries {
        reason.text("a reason")?;
    }
    for entry in &mut list {
        let id = entry.id.as_str();
        let at = covers.key(id).or_else(|| rows.key(id));
        if at.is_none() && omit.get(id).is_none() {
            return Err(name.wrong(format!("`{id}` is neither in `covers` nor in `omit`")));
        }
        table(entry, &rows)?;
        entry.shared = at.map(|at| CommonEntry {
            at,
            covers: covers.get(id).filter(|list| list.sequence().is_none_or(|items| !items.is_empty())),
            variants: variants.get(id),
            rows: rows.get(id),
            catches: catches.get(id),
        });
    }
    list.retain(|entry| entry.shared.is_some());
    let give = give(keyed, name, common, &list, ground)?;
    list.extend(own);
    Ok((list, give))
}

/// Whether the manual gives rows to a case that takes some, and only to those.
fn table(entry: &TopicEntry<'_>, rows: &ById<'_>) -> Read<()> {
    let with = entry.keyed.get(&case::with);
    let (Some(given), Some(at)) = (rows.get(&entry.id), rows.key(&entry.id)) else { return Ok(()) };
    let Some(with) = with else {
        return Err(at.wrong(format!("`{}` has no table", entry.id)));
    };
    if with.mapping().is_none() {
        return Ok(());
    }
    let columns = taken::columns(with)?;
    for row in given.items("rows")? {
        for (name, value) in named(row, "a row")? {
            if super::table::is_reserved(name) {
                continue;
            }
            let Some((_, declared)) = columns.iter().find(|(known, _)| *known == name) else {
                return Err(Mistake::unknown(
                    row.key(name).spot,
                    "column",
                    name,
                    columns.iter().map(|(name, _)| *name),
                ));
            };
            taken::fits(value, declared)?;
        }
        if let Some((missing, _)) = columns.iter().find(|(name, _)| row.get(name).is_none()) {
            return Err(row.wrong(format!("this row has no `{missing}`")));
        }
    }
    Ok(())
}

/// What the manual gives; it gives all that is taken by what it does not leave out, and nothing else.
fn give<'n>(
    keyed: Keyed<'n>,
    name: &Node,
    common: Keyed<'n>,
    kept: &[TopicEntry<'n>],
    ground: &LoadContext<'_>,
) -> Read<Vec<Column>> {
    let takes = common.get(&common_suite::takes).map_or(Ok(Vec::new()), |takes| named(takes, "takes"))?;
    let give = keyed.get(&uses::give).map_or(Ok(Vec::new()), |give| named(give, "give"))?;
    let is_used = |take: &str| kept.iter().any(|entry| mentions(entry.keyed.node, take));
    let mut columns = Vec::new();
    for (entry, value) in &give {
        let key = || keyed.get(&uses::give).map_or(value.spot, |give| give.key(entry).spot);
        let Some((_, take)) = takes.iter().find(|(known, _)| known == entry) else {
            return Err(Mistake::unknown(key(), "entry of give", entry, takes.iter().map(|(name, _)| *name)));
        };
        if !is_used(entry) {
            return Err(Mistake::new(key(), format!("`{entry}` is given and never used"))
                .help("everything that would use it is left out"));
        }
        taken::given(value, take, &ground.device.variants)?;
        columns.push(Column::new(entry, (*value).clone()));
    }
    let is_given = |take: &str| give.iter().any(|(name, _)| *name == take);
    match takes.iter().find(|(take, _)| !is_given(take) && is_used(take)) {
        Some((missing, _)) => Err(name.wrong(format!("the common suite has to be given `{missing}`"))),
        None => Ok(columns),
    }
}
