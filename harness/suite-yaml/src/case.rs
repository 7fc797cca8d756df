//! Topic files: cases with their tables, rules, and the common suites that a manual uses.

use super::checks::{any_check_of_the_case, any_step, is_check, wants_life};
use super::device_yaml::{flag, plain};
use super::entry::{TopicEntry, entries, variants};
use super::error::{Read, every};
use super::frame::{Column, Progress, StepScope, is_none, replaced};
use super::keys::{Key, Keyed};
use super::names::Names;
use super::shared::used;
use super::start::merged;
use super::step::{LoadContext, StepContext};
use super::table::{Row, catches, rows};
use super::taken;
use super::topic_keys::{case, defaults, topic, uses};
use super::yaml::Node;
use rustc_hash::{FxHashMap, FxHashSet};
use suite::model::{Outline, SuiteRule, Trial, TrialSteps};

/// A topic file, with the common suite that it uses already joined.
pub(super) struct Topic<'n> {
    /// Name of the file.
    pub name: String,
    defaults: Option<Keyed<'n>>,
    entries: Vec<TopicEntry<'n>>,
    /// What a common suite was given.
    give: Vec<Column>,
}

/// The trials and rules of a topic for one variant.
#[derive(Default)]
pub(super) struct Compiled {
    pub trials: Vec<Trial>,
    pub rules: Vec<SuiteRule>,
}

impl<'n> Topic<'n> {
    /// Reads the frame of a topic file; `common` finds common suites by name.
    pub(super) fn read(
        node: &'n Node,
        file: &str,
        ground: &LoadContext<'_>,
        common: &dyn Fn(&Node) -> Read<&'n Node>,
    ) -> Read<Topic<'n>> {
        let uses = node.get(uses::r#use.name).is_some();
        let keyed = Keyed::new(node, if uses { &uses::KEYS } else { &topic::KEYS })?;
        let name = keyed.must(if uses { &uses::suite } else { &topic::suite })?;
        if plain(name, "suite")? != file {
            return Err(name.wrong(format!("this is the file `{file}`")).help(format!("write `suite: {file}`")));
        }
        let defaults = keyed
            .get(if uses { &uses::defaults } else { &topic::defaults })
            .map(|node| Keyed::new(node, &defaults::KEYS))
            .transpose()?;
        let (entries, give) = match uses {
            false => (entries(keyed, ground)?, Vec::new()),
            true => used(keyed, ground, common)?,
        };
        if entries.is_empty() && ground.mistakes.count() == 0 {
            return Err(node.wrong("an empty suite"));
        }
        Ok(Topic { name: file.to_owned(), defaults, entries, give })
    }

    /// Compiles everything for one variant.
    pub(super) fn compile(&self, ground: &LoadContext<'_>, names: &Names<'_>) -> Compiled {
        let mut compiled = Compiled::default();
        let mut seen: FxHashMap<String, String> = FxHashMap::default();
        let here = |column: &Column| {
            let value = taken::of_variant(&column.value, &names.device().variants, names.variant);
            Column::new(&column.name, value.clone())
        };
        let give: Vec<Column> = self.give.iter().map(here).collect();
        for entry in &self.entries {
            if ground.mistakes.enough() {
                break;
            }
            // What the common suite was given is no name of the manual's own cases.
            let give = if entry.shared.is_some() { give.as_slice() } else { &[] };
            if entry.is_case {
                if let Some(trials) = ground.mistakes.keep(self.case(entry, give, ground, names, &mut seen)) {
                    compiled.trials.extend(trials);
                }
            } else if let Some(rule) = ground.mistakes.keep(self.rule(entry, give, ground, names)) {
                compiled.rules.extend(rule);
            }
        }
        compiled
    }

    fn case(
        &self,
        entry: &TopicEntry<'n>,
        give: &[Column],
        ground: &LoadContext<'_>,
        names: &Names<'_>,
        seen: &mut FxHashMap<String, String>,
    ) -> Read<Vec<Trial>> {
        let own = entry.variants_or_likely(names, ground.mistakes);
        if own.is_empty() {
            return Ok(Vec::new());
        }
        let rows = rows(entry, names, give)?;
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
            let before = ground.mistakes.noted();
            let columns: Vec<Column> = give.iter().chain(&row.columns).cloned().collect();
            columns.iter().for_each(|column| column.used.set(false));
            let trial = self.trial(
                entry,
                (row, &rows),
                &columns,
                format!("{}/{}{label}", self.name, entry.id),
                ground,
                names,
                seen,
            );
            let trial = ground.mistakes.keep(trial);
            if ground.mistakes.noted() > before {
                // Other rows may have other mistakes.
                continue;
            }
            if let Some(unused) = columns.iter().skip(give.len()).find(|column| !column.used.get()) {
                return Err(unused.value.wrong(format!("the column `{}` is never used", unused.name)));
            }
            trials.extend(trial.flatten());
        }
        Ok(trials)
    }

    #[allow(clippy::too_many_arguments, reason = "a trial is where everything meets")]
    fn trial(
        &self,
        entry: &TopicEntry<'n>,
        (row, rows): (&Row<'n>, &[Row<'n>]),
        columns: &[Column],
        id: String,
        ground: &LoadContext<'_>,
        names: &Names<'_>,
        seen: &mut FxHashMap<String, String>,
    ) -> Read<Option<Trial>> {
        let node = entry.keyed.node;
        let default = self.defaults.and_then(|defaults| defaults.get(&defaults::start));
        let [under, over] =
            [default, entry.keyed.get(&case::start)].map(|start| start.map(|start| replaced(start, columns)));
        let Some(start) = merged(under.transpose()?.as_ref(), over.transpose()?.as_ref())? else {
            return Err(node.wrong("a case needs a `start`").help("write `start: { module: ... }` or `start: none`"));
        };
        // What was named before belongs to something else.
        names.take_leds();
        let progress = Progress::default();
        let frame = StepScope { names, columns, progress: &progress, any_module: false };
        let begin = if is_none(&start) { Ok(None) } else { frame.start(&start).map(Some) };
        if progress.module.get().is_none() && begin.is_err() {
            // Without a module no step can be read.
            return begin.map(|_| None);
        }
        let within = self.defaults.and_then(|defaults| defaults.get(&defaults::within));
        let place = StepContext { ground, frame, within, start: Some(&start), in_procedure: false };

        let list = |keyed: Option<Keyed<'n>>, key: &Key| -> Read<Vec<Node>> {
            let items = keyed.and_then(|keyed| keyed.get(key)).map_or(Ok(&[][..]), |node| node.items(key.name))?;
            items.iter().map(|item| replaced(item, columns)).collect()
        };
        let mut given = list(self.defaults, &defaults::given)?;
        given.extend(list(Some(entry.keyed), &case::given)?);
        let steps = list(Some(entry.keyed), &case::steps)?;
        let mut finally = list(Some(entry.keyed), &case::finally)?;
        finally.extend(list(self.defaults, &defaults::finally)?);
        if steps.is_empty() {
            return Err(node.wrong("a case without steps"));
        }
        let text = [&given, &steps, &finally]
            .map(|list| list.iter().map(Node::to_string).collect::<Vec<_>>().join("\n"))
            .join("\n--\n");
        if let Some(same) = seen.insert(format!("{start}\n{text}"), id.clone()) {
            return Err(row.at.unwrap_or(node).wrong(format!("this trial is the same as `{same}`")));
        }

        let before = ground.mistakes.noted();
        let said = entry.shared.as_ref().and_then(|shared| shared.covers);
        let lists = [entry.keyed.get(&case::covers), said, row.covers].into_iter().flatten();
        let covers = every(lists.map(|list| ground.covers(&replaced(list, columns)?, &frame)));
        let mut covers: Vec<usize> = ground.mistakes.keep(covers).unwrap_or_default().concat();
        let mut once = FxHashSet::default();
        covers.retain(|requirement| once.insert(*requirement));
        let begin = ground.mistakes.keep(begin).flatten();
        let bit_timing = ground.mistakes.keep(flag(entry.keyed, &case::bit_timing)).unwrap_or_default();
        let caught = ground.mistakes.keep(catches(entry, Some((row, rows)), ground, names)).unwrap_or_default();
        let (given, steps, finally) = (place.steps(&given), place.steps(&steps), place.steps(&finally));
        if ground.mistakes.noted() > before || entry.is_partial {
            // A step that could not be read may be the one that is missed below.
            return Ok(None);
        }
        let any_apart = any_step(&steps, &|step| !step.covers.is_empty());
        if covers.is_empty() && !any_apart {
            let at = entry.shared.as_ref().map_or(node, |shared| shared.at);
            return Err(at.wrong(format!("`{id}` covers nothing")).help("name the requirements: `covers: [...]`"));
        }
        if !any_step(&steps, &|step| is_check(step)) {
            return Err(node
                .wrong(format!("`{id}` checks nothing"))
                .help("a case needs an `expect`, a `read`, an `answer` or an `observe`"));
        }
        if !covers.is_empty() && any_apart && !any_check_of_the_case(&steps) {
            let ids = entry.keyed.get(&case::covers).or(said).or(row.covers).unwrap_or(node);
            return Err(ids
                .wrong(format!("nothing in `{id}` can fail what the case itself covers: every check has its own `covers`"))
                .help("name these requirements at the checks that show them, or take `covers` away from one of the checks"));
        }
        if !any_step(&steps, &wants_life) {
            return Err(node
                .wrong(format!("a dead device passes `{id}`"))
                .help("add a check that only a living device passes"));
        }
        Ok(Some(Trial {
            id,
            why: entry.why.clone(),
            covers,
            catches: caught,
            at: ground.location(row.at.unwrap_or(node)),
            outline: Outline { leds: names.take_leds(), ..Outline::default() },
            how: TrialSteps {
                start: begin,
                given,
                steps,
                finally,
                bit_timing,
                saved: progress.saved.take().into_iter().map(|(name, _)| name).collect(),
            }
            .into(),
        }))
    }

    fn rule(
        &self,
        entry: &TopicEntry<'n>,
        give: &[Column],
        ground: &LoadContext<'_>,
        names: &Names<'_>,
    ) -> Read<Option<SuiteRule>> {
        let node = entry.keyed.node;
        if !entry.variants(names)?.contains(&names.variant) {
            return Ok(None);
        }
        let progress = Progress::default();
        let frame = StepScope { names, columns: give, progress: &progress, any_module: true };
        let place = StepContext { ground, frame, within: None, start: None, in_procedure: false };
        let before = ground.mistakes.noted();
        let said = entry.shared.as_ref().and_then(|shared| shared.covers);
        let lists = [entry.keyed.get(&case::covers), said].into_iter().flatten();
        let covers = every(lists.map(|list| ground.covers(list, &frame)));
        let covers = ground.mistakes.keep(covers).unwrap_or_default().concat();
        let caught = ground.mistakes.keep(catches(entry, None, ground, names)).unwrap_or_default();
        let is_partial = ground.mistakes.noted() > before;
        if covers.is_empty() && !is_partial && !entry.is_partial {
            return Err(node
                .wrong(format!("`{}` covers nothing", entry.id))
                .help("name the requirements: `covers: [...]`"));
        }
        if entry.is_partial {
            return Ok(None);
        }
        let replaced = replaced(node, give)?;
        let body = place.body(Keyed { node: &replaced })?;
        if is_partial {
            return Ok(None);
        }
        let modules = place.modules(&body.names);
        if modules.is_empty() {
            return Err(node.wrong("no module has all the signals of this rule"));
        }
        Ok(Some(SuiteRule {
            id: format!("{}/{}", self.name, entry.id),
            why: entry.why.clone(),
            covers,
            catches: caught,
            body: body.body,
            modules,
            at: ground.location(node),
        }))
    }
}
