//! Topic files: cases with their tables, rules, and the common suites that a manual uses.

use super::checks::{any_check_of_the_case, any_step, is_check, wants_life};
use super::device_yaml::{named, plain};
use super::error::{Mistake, Read};
use super::frame::{Column, Frame, Progress, replaced};
use super::keys::{self, Keyed};
use super::model::{Rule, Trial};
use super::names::Names;
use super::start::{is_none, merged};
use super::step::{Ground, Place};
use super::table::{Row, catches, rows, variants};
use super::yaml::Node;
use rustc_hash::{FxHashMap, FxHashSet};

/// A topic file, with the common suite that it uses already joined.
pub(super) struct Topic<'n> {
    /// Name of the file.
    pub name: String,
    defaults: Option<Keyed<'n>>,
    entries: Vec<Entry<'n>>,
    /// What a common suite was given.
    give: Vec<Column>,
}

/// A case or a rule.
pub(super) struct Entry<'n> {
    pub id: String,
    why: String,
    pub keyed: Keyed<'n>,
    /// What the manual says of a case of a common suite.
    covers: Option<&'n Node>,
    is_case: bool,
}

/// The trials and rules of a topic for one variant.
#[derive(Default)]
pub(super) struct Compiled {
    pub trials: Vec<Trial>,
    pub rules: Vec<Rule>,
}

impl<'n> Topic<'n> {
    /// Reads the frame of a topic file; `common` finds common suites by name.
    pub(super) fn read(
        node: &'n Node,
        file: &str,
        ground: &Ground<'_>,
        common: &dyn Fn(&Node) -> Read<&'n Node>,
    ) -> Read<Topic<'n>> {
        let uses = node.get("use").is_some();
        let keyed = Keyed::new(node, if uses { &keys::USE } else { &keys::TOPIC })?;
        let name = keyed.must("suite")?;
        if plain(name, "suite")? != file {
            return Err(name.wrong(format!("this is the file `{file}`")).help(format!("write `suite: {file}`")));
        }
        let defaults = keyed.get("defaults").map(|node| Keyed::new(node, &keys::DEFAULTS)).transpose()?;
        let (entries, give) = match uses {
            false => (entries(keyed, ground)?, Vec::new()),
            true => used(keyed, ground, common)?,
        };
        if entries.is_empty() {
            return Err(node.wrong("an empty suite"));
        }
        Ok(Topic { name: file.to_owned(), defaults, entries, give })
    }

    /// Compiles everything for one variant.
    pub(super) fn compile(&self, ground: &Ground<'_>, names: &Names<'_>) -> Compiled {
        let mut compiled = Compiled::default();
        let mut seen: FxHashMap<String, String> = FxHashMap::default();
        for entry in &self.entries {
            if ground.mistakes.enough() {
                break;
            }
            if entry.is_case {
                if let Some(trials) = ground.mistakes.keep(self.case(entry, ground, names, &mut seen)) {
                    compiled.trials.extend(trials);
                }
            } else if let Some(rule) = ground.mistakes.keep(self.rule(entry, ground, names)) {
                compiled.rules.extend(rule);
            }
        }
        compiled
    }

    /// What a common suite was given and no case used.
    pub(super) fn unused_give(&self, ground: &Ground<'_>) {
        for column in self.give.iter().filter(|column| !column.used.get()) {
            ground.mistakes.note(column.value.wrong(format!("`{}` is given and never used", column.name)));
        }
    }

    fn case(
        &self,
        entry: &Entry<'n>,
        ground: &Ground<'_>,
        names: &Names<'_>,
        seen: &mut FxHashMap<String, String>,
    ) -> Read<Vec<Trial>> {
        let own = variants(entry.keyed.get("variants"), names)?;
        let rows = rows(entry, names, &self.give)?;
        let mut trials = Vec::new();
        for row in &rows {
            let narrowed = variants(row.variants, names)?;
            if !own.iter().any(|variant| narrowed.contains(variant)) {
                return Err(row.variants.unwrap_or(entry.keyed.node).wrong("no variant is left"));
            }
            if !own.contains(&names.variant) || !narrowed.contains(&names.variant) {
                continue;
            }
            let label = row.label.as_deref().map_or(String::new(), |label| format!("[{label}]"));
            let before = ground.mistakes.count();
            let columns: Vec<Column> = self.give.iter().chain(&row.columns).cloned().collect();
            columns.iter().for_each(|column| column.used.set(false));
            let trial =
                self.trial(entry, row, &columns, format!("{}/{}{label}", self.name, entry.id), ground, names, seen);
            let trial = ground.mistakes.keep(trial);
            for (column, used) in self.give.iter().zip(&columns) {
                column.used.set(column.used.get() || used.used.get());
            }
            if ground.mistakes.count() > before {
                return Ok(trials);
            }
            if let Some(unused) = columns.iter().skip(self.give.len()).find(|column| !column.used.get()) {
                return Err(unused.value.wrong(format!("the column `{}` is never used", unused.name)));
            }
            trials.extend(trial);
        }
        Ok(trials)
    }

    #[allow(clippy::too_many_arguments, reason = "a trial is where everything meets")]
    fn trial(
        &self,
        entry: &Entry<'n>,
        row: &Row<'_>,
        columns: &[Column],
        id: String,
        ground: &Ground<'_>,
        names: &Names<'_>,
        seen: &mut FxHashMap<String, String>,
    ) -> Read<Trial> {
        let node = entry.keyed.node;
        let start = merged(self.defaults.and_then(|defaults| defaults.get("start")), entry.keyed.get("start"))?;
        let Some(start) = start else {
            return Err(node.wrong("a case needs a `start`").help("write `start: { module: ... }` or `start: none`"));
        };
        let start = replaced(&start, columns)?;
        let progress = Progress::default();
        let frame = Frame { names, columns, progress: &progress, any_module: false };
        let begin = if is_none(&start) { None } else { Some(frame.start(&start)?) };
        let within = self.defaults.and_then(|defaults| defaults.get("within"));
        let place = Place { ground, frame, within, start: Some(&start), in_procedure: false };

        let list = |keyed: Option<Keyed<'n>>, key: &str| -> Read<Vec<Node>> {
            let items = keyed.and_then(|keyed| keyed.get(key)).map_or(Ok(&[][..]), |node| node.items(key))?;
            items.iter().map(|item| replaced(item, columns)).collect()
        };
        let mut given = list(self.defaults, "given")?;
        given.extend(list(Some(entry.keyed), "given")?);
        let steps = list(Some(entry.keyed), "steps")?;
        let mut finally = list(Some(entry.keyed), "finally")?;
        finally.extend(list(self.defaults, "finally")?);
        if steps.is_empty() {
            return Err(node.wrong("a case without steps"));
        }
        let text = [&given, &steps, &finally]
            .map(|list| list.iter().map(Node::to_string).collect::<Vec<_>>().join("\n"))
            .join("\n--\n");
        if let Some(same) = seen.insert(format!("{start}\n{text}"), id.clone()) {
            return Err(row.at.unwrap_or(node).wrong(format!("this trial is the same as `{same}`")));
        }

        let mut covers: Vec<usize> = Vec::new();
        for list in [entry.keyed.get("covers"), entry.covers, row.covers].into_iter().flatten() {
            covers.extend(ground.covers(&replaced(list, columns)?, &frame)?);
        }
        let mut once = FxHashSet::default();
        covers.retain(|requirement| once.insert(*requirement));
        let (given, steps, finally) = (place.steps(&given), place.steps(&steps), place.steps(&finally));
        let any_apart = any_step(&steps, &|step| !step.covers.is_empty());
        if covers.is_empty() && !any_apart {
            return Err(node.wrong(format!("`{id}` covers nothing")).help("name the requirements: `covers: [...]`"));
        }
        if !any_step(&steps, &|step| is_check(step)) {
            return Err(node
                .wrong(format!("`{id}` checks nothing"))
                .help("a case needs an `expect`, a `read`, an `answer` or an `observe`"));
        }
        if !covers.is_empty() && any_apart && !any_check_of_the_case(&steps) {
            let ids = node.get("covers").or(entry.covers).or(row.covers).unwrap_or(node);
            return Err(ids
                .wrong(format!("nothing in `{id}` can fail what the case itself covers: every check has its own `covers`"))
                .help("name these requirements at the checks that show them, or take `covers` away from one of the checks"));
        }
        if !any_step(&steps, &wants_life) {
            return Err(node
                .wrong(format!("a dead device passes `{id}`"))
                .help("add a check that only a living device passes"));
        }
        Ok(Trial {
            id,
            why: entry.why.clone(),
            covers,
            catches: catches(entry.keyed, ground, names)?,
            start: begin,
            given,
            steps,
            finally,
            saved: progress.saved.take().into_iter().map(|(name, _)| name).collect(),
            at: ground.location(row.at.unwrap_or(node)),
        })
    }

    fn rule(&self, entry: &Entry<'n>, ground: &Ground<'_>, names: &Names<'_>) -> Read<Option<Rule>> {
        let node = entry.keyed.node;
        if !variants(entry.keyed.get("variants"), names)?.contains(&names.variant) {
            return Ok(None);
        }
        let progress = Progress::default();
        let frame = Frame { names, columns: &self.give, progress: &progress, any_module: true };
        let place = Place { ground, frame, within: None, start: None, in_procedure: false };
        let mut covers = Vec::new();
        for list in [entry.keyed.get("covers"), entry.covers].into_iter().flatten() {
            covers.extend(ground.covers(list, &frame)?);
        }
        if covers.is_empty() {
            return Err(node
                .wrong(format!("`{}` covers nothing", entry.id))
                .help("name the requirements: `covers: [...]`"));
        }
        let replaced = replaced(node, &self.give)?;
        let body = place.body(Keyed { node: &replaced })?;
        let modules = place.modules(&body.names);
        if modules.is_empty() {
            return Err(node.wrong("no module has all the signals of this rule"));
        }
        Ok(Some(Rule {
            id: format!("{}/{}", self.name, entry.id),
            why: entry.why.clone(),
            covers,
            catches: catches(entry.keyed, ground, names)?,
            body: body.body,
            modules,
            at: ground.location(node),
        }))
    }
}

/// The cases and rules of a topic file or a common suite; ids are unique.
fn entries<'n>(keyed: Keyed<'n>, ground: &Ground<'_>) -> Read<Vec<Entry<'n>>> {
    let mut list: Vec<Entry<'n>> = Vec::new();
    for (key, is_case) in [("cases", true), ("rules", false)] {
        let Some(node) = keyed.get(key) else { continue };
        let items = node.items(key)?;
        if items.is_empty() {
            return Err(node.wrong(format!("an empty list of {key}")));
        }
        for item in items {
            let Some(entry) = ground.mistakes.keep(self::entry(item, is_case)) else { continue };
            if list.iter().any(|known| known.id == entry.id) {
                ground.mistakes.note(item.get("id").unwrap_or(item).wrong(format!("duplicate id `{}`", entry.id)));
            }
            list.push(entry);
        }
    }
    Ok(list)
}

fn entry(node: &Node, is_case: bool) -> Read<Entry<'_>> {
    let keyed = Keyed::new(node, if is_case { &keys::CASE } else { &keys::RULE })?;
    let id = keyed.must("id")?;
    let text = plain(id, "an id")?;
    super::device_yaml::label(id, text)?;
    let why = keyed.must("why")?.text("why")?.to_owned();
    Ok(Entry { id: text.to_owned(), why, keyed, covers: None, is_case })
}

/// The entries of a common suite that a manual uses, and what it gives.
fn used<'n>(
    keyed: Keyed<'n>,
    ground: &Ground<'_>,
    common: &dyn Fn(&Node) -> Read<&'n Node>,
) -> Read<(Vec<Entry<'n>>, Vec<Column>)> {
    let name = keyed.must("use")?;
    let common = Keyed::new(common(name)?, &keys::COMMON)?;
    let takes = common.get("takes").map_or(Ok(Vec::new()), |takes| named(takes, "takes"))?;
    let give = keyed.get("give").map_or(Ok(Vec::new()), |give| named(give, "give"))?;
    let mut columns = Vec::new();
    for (entry, value) in &give {
        let Some((_, take)) = takes.iter().find(|(known, _)| known == entry) else {
            let key = keyed.get("give").map_or(value.spot, |give| give.key(entry).spot);
            return Err(Mistake::unknown(key, "entry of give", entry, takes.iter().map(|(name, _)| *name)));
        };
        given(value, take)?;
        columns.push(Column::new(entry, (*value).clone()));
    }
    if let Some((missing, _)) = takes.iter().find(|(take, _)| !give.iter().any(|(name, _)| name == take)) {
        return Err(name.wrong(format!("the common suite has to be given `{missing}`")));
    }
    let mut list = entries(common, ground)?;
    let covers = keyed.get("covers").map_or(Ok(Vec::new()), |covers| named(covers, "covers"))?;
    let omit = keyed.get("omit").map_or(Ok(Vec::new()), |omit| named(omit, "omit"))?;
    for (id, node) in covers.iter().chain(&omit) {
        if !list.iter().any(|entry| entry.id == *id) {
            let lists = [keyed.get("covers"), keyed.get("omit")].into_iter().flatten();
            let key = lists.map(|list| list.key(id)).find(|key| key.scalar() == Some(id)).unwrap_or(node);
            return Err(Mistake::unknown(
                key.spot,
                "case of the common suite",
                id,
                list.iter().map(|entry| entry.id.as_str()),
            ));
        }
    }
    if let Some((id, node)) = omit.iter().find(|(id, _)| covers.iter().any(|(known, _)| known == id)) {
        return Err(node.wrong(format!("`{id}` is covered and left out")));
    }
    for (_, reason) in &omit {
        reason.text("a reason")?;
    }
    for entry in &mut list {
        entry.covers = covers.iter().find(|(id, _)| *id == entry.id).map(|(_, node)| *node);
        if entry.covers.is_none() && !omit.iter().any(|(id, _)| *id == entry.id) {
            return Err(name.wrong(format!("`{}` is neither in `covers` nor in `omit`", entry.id)));
        }
    }
    list.retain(|entry| entry.covers.is_some());
    Ok((list, columns))
}

/// Whether a manual gives what a common suite takes.
fn given(value: &Node, take: &Node) -> Read<()> {
    let take = Keyed::new(take, &keys::TAKES)?;
    take.must("why")?.text("why")?;
    let text = value.text("what is given")?;
    let good = match super::device_yaml::word(take.must("is")?, "is", keys::TAKEN)? {
        "parameter" => super::device_yaml::parameter_number(text.split('.').next().unwrap_or(text)).is_some(),
        "number" => value.expression().is_some() || super::expr::number(text).is_ok(),
        "role" => text.starts_with("role."),
        _ => true,
    };
    if good { Ok(()) } else { Err(value.wrong(format!("`{text}` is not what the common suite takes here"))) }
}
