//! What a manual makes of a common suite: what it gives, which cases and rules it takes, and what it says of each.

use super::device_yaml::named;
use super::entry::{CommonEntry, TopicEntry, entries};
use super::error::{Mistake, Read};
use super::frame::Column;
use super::keys::{Key, Keyed};
use super::step::LoadContext;
use super::taken;
use super::topic_keys::{case, common_suite, takes, uses};
use super::yaml::{Node, mentions};
use plain_text::nearest;

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
    let mut wrong: Vec<Box<Mistake>> = Vec::new();
    let mut meant: Vec<String> = Vec::new();
    for said in [&covers, &omit, &rows, &catches, &variants] {
        for (id, node) in &said.entries {
            if !list.iter().any(|entry| entry.id == *id) {
                let known = list.iter().map(|entry| entry.id.as_str());
                let spot = said.key(id).unwrap_or(node).spot;
                meant.extend(nearest(id, known.clone()));
                wrong.push(Mistake::unknown(spot, "case of the common suite", id, known));
            }
        }
    }
    for said in [&covers, &rows, &catches, &variants] {
        for (id, node) in omit.entries.iter().filter(|(id, _)| said.get(id).is_some()) {
            let what = if covers.get(id).is_some() { "covered" } else { "spoken of" };
            wrong.push(node.wrong(format!("`{id}` is {what} and left out")));
        }
    }
    wrong.extend(omit.entries.iter().filter_map(|(_, reason)| reason.text("a reason").err()));
    let is_open = |id: &str| covers.key(id).is_none() && rows.key(id).is_none() && omit.get(id).is_none();
    let open =
        list.iter().map(|entry| entry.id.as_str()).filter(|id| is_open(id) && meant.iter().all(|name| name != id));
    let open: Vec<String> = open.map(|id| format!("`{id}`")).collect();
    if let Some(first) = open.first() {
        let help = "name the requirements of each under `covers`, or say under `omit` why the manual leaves it out";
        let wrong_one = match open.len() {
            1 => name.wrong(format!("{first} is neither in `covers` nor in `omit`")),
            _ => name.wrong(format!("{} are neither in `covers` nor in `omit`", open.join(", "))),
        };
        wrong.push(wrong_one.help(help));
    }
    wrong.extend(list.iter().filter_map(|entry| table(entry, &rows).err()));
    for entry in &mut list {
        let id = entry.id.as_str();
        let at = covers.key(id).or_else(|| rows.key(id));
        entry.shared = at.map(|at| CommonEntry {
            at,
            covers: covers.get(id).filter(|list| list.sequence().is_none_or(|items| !items.is_empty())),
            variants: variants.get(id),
            rows: rows.get(id),
            catches: catches.get(id),
        });
    }
    list.retain(|entry| entry.shared.is_some());
    let is_kept_known = wrong.is_empty() && !ground.is_generic;
    let given = give(keyed, name, common, &list, ground, is_kept_known);
    let given = given.map_err(|mistake| wrong.push(mistake)).unwrap_or_default();
    if let Some(wrong) = Mistake::all(wrong) {
        // The cases of the common suite would only say so again; those of the manual itself are read.
        ground.mistakes.note(wrong);
        list.clear();
    }
    list.extend(own);
    Ok((list, given))
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

/// What the manual gives; it gives all that is taken by what it does not leave out, and nothing else. Whether something is given and not
/// used is known only if it is known what is kept.
fn give<'n>(
    keyed: Keyed<'n>,
    name: &Node,
    common: Keyed<'n>,
    kept: &[TopicEntry<'n>],
    ground: &LoadContext<'_>,
    is_kept_known: bool,
) -> Read<Vec<Column>> {
    let takes = common.get(&common_suite::takes).map_or(Ok(Vec::new()), |takes| named(takes, "takes"))?;
    let give = keyed.get(&uses::give).map_or(Ok(Vec::new()), |give| named(give, "give"))?;
    let is_used = |take: &str| kept.iter().any(|entry| mentions(entry.keyed.node, take));
    let mut columns = Vec::new();
    let mut wrong: Vec<Box<Mistake>> = Vec::new();
    let mut one = |entry: &'n str, value: &'n Node| -> Read<()> {
        let key = || keyed.get(&uses::give).map_or(value.spot, |give| give.key(entry).spot);
        let Some((_, take)) = takes.iter().find(|(known, _)| *known == entry) else {
            return Err(Mistake::unknown(key(), "entry of give", entry, takes.iter().map(|(name, _)| *name)));
        };
        if is_kept_known && !is_used(entry) {
            return Err(Mistake::new(key(), format!("`{entry}` is given and never used"))
                .help("everything that would use it is left out"));
        }
        taken::given(value, take, &ground.device.variants)?;
        columns.push(Column::new(entry, value.clone()));
        Ok(())
    };
    wrong.extend(give.iter().filter_map(|(entry, value)| one(entry, value).err()));
    // An entry that is misspelt is not missing too.
    let misspelt = give.iter().filter(|(name, _)| takes.iter().all(|(take, _)| take != name));
    let meant: Vec<String> =
        misspelt.filter_map(|(name, _)| nearest(name, takes.iter().map(|(take, _)| *take))).collect();
    let is_given = |take: &str| meant.iter().any(|name| name == take) || give.iter().any(|(name, _)| *name == take);
    let missing = takes.iter().filter(|(take, _)| !is_given(take) && is_used(take));
    wrong.extend(missing.map(|(missing, take)| {
        let why = take.get(takes::why.name).and_then(Node::scalar).unwrap_or_default();
        let mistake = name.wrong(format!("the common suite has to be given `{missing}`"));
        mistake.help(format!("write `give: {{ {missing}: ... }}`: {why}"))
    }));
    Mistake::all(wrong).map_or(Ok(columns), Err)
}
