//! Steps: one verb with its modifiers, compiled for one trial.

use super::access::RequestSender;
use super::answer::RequestKind;
use super::device_yaml::{named, plain};
use super::error::{Mistake, Mistakes, Read, both, every};
use super::frame::{Column, StepScope, in_expression, is_none, octets, replaced};
use super::keys::{Key, Keyed};
use super::lists::AllBugs;
use super::names::Verbs;
use super::source::{Files, Sources};
use super::start::merged;
use super::topic_keys::{exchanged, turn};
use super::verbs::{
    VERBS, VerbWord, block_step, connect_step, either_step, expect_step, procedure_step, read_step, send_step, word_of,
    write_step,
};
use super::yaml::{Node, NodeKind};
use expression::{Allow, Program, Type};
use rustc_hash::FxHashMap;
use suite::Location;
use suite::device::{DeviceDescription, NameKind};
use suite::model::{
    AcyclicService, ExchangeEntry, FailureSubject, HoldTime, ManualReading, SetValue, Setting, TrialStep, Turn,
    TurnAngle, Verb,
};

/// The requirements of each name of a check that has its own, by the place of the name.
type CoversByName = Vec<(usize, Vec<usize>)>;

/// A procedure: names that are replaced, and steps.
#[derive(Debug)]
pub(super) struct Procedure {
    pub takes: Vec<String>,
    pub steps: Node,
    /// The requirements that a failure in it is about.
    pub about: Option<Node>,
}

/// What all steps of a manual have in common.
#[derive(Clone, Copy)]
pub(super) struct LoadContext<'g> {
    pub device: &'g DeviceDescription,
    /// All files, for what other manuals list.
    pub sources: &'g Sources,
    pub files: &'g Files,
    pub mistakes: &'g Mistakes,
    /// Number of each requirement by id, with the variants it applies to.
    pub requirements: &'g FxHashMap<String, (usize, Vec<usize>)>,
    pub procedures: &'g FxHashMap<String, Procedure>,
    /// The bugs, by name.
    pub bugs: &'g [suite::model::Bug],
    /// The bugs of all manuals.
    pub elsewhere: &'g AllBugs,
    /// Whether this is a suite that the manual uses too, whose bugs are listed in its own folder.
    pub is_generic: bool,
}

impl LoadContext<'_> {
    pub(super) fn location(&self, node: &Node) -> Location {
        self.files.location(node.spot)
    }

    /// Requirements of a list that apply to the variant; each must exist.
    fn covers_here(&self, node: &Node, frame: &StepScope<'_, '_>) -> Read<Vec<usize>> {
        let applies = |item: &&Node| {
            let known = item.plain().and_then(|id| self.requirements.get(id));
            known.is_none_or(|(_, variants)| variants.contains(&frame.names.variant))
        };
        let items: Vec<Node> = node.items("about")?.iter().filter(applies).cloned().collect();
        if items.is_empty() {
            return Ok(Vec::new());
        }
        self.covers(&Node { kind: NodeKind::Sequence(items), ..node.clone() }, frame)
    }

    /// Requirements of a list; each must exist and apply to the variant.
    pub(super) fn covers(&self, node: &Node, frame: &StepScope<'_, '_>) -> Read<Vec<usize>> {
        let mut list = Vec::new();
        let requirement = |item: &Node| {
            let id = plain(item, "a requirement")?;
            let Some((index, variants)) = self.requirements.get(id) else {
                return Err(Mistake::unknown(item.spot, "requirement", id, self.requirements_near(id)));
            };
            if !variants.contains(&frame.names.variant) {
                let variant = &frame.names.device().variants[frame.names.variant];
                return Err(item
                    .wrong(format!("{id} does not apply to the variant {variant}"))
                    .help("narrow `variants`"));
            }
            if list.contains(index) {
                return Err(item.wrong(format!("{id} stands twice")));
            }
            list.push(*index);
            Ok(())
        };
        every(node.items("covers")?.iter().map(requirement))?;
        if list.is_empty() { Err(node.wrong("an empty list of requirements")) } else { Ok(list) }
    }

    /// Requirements in a settled order, so that a suggestion is always the same.
    fn requirements_near(&self, id: &str) -> Vec<&str> {
        let mut near: Vec<(usize, &str)> =
            self.requirements.iter().map(|(known, (index, _))| (*index, known.as_str())).collect();
        near.retain(|(_, known)| known.len().abs_diff(id.len()) < 3);
        near.sort_unstable();
        near.into_iter().map(|(_, known)| known).collect()
    }
}

/// The context of a step: what it may use and its defaults.
#[derive(Clone, Copy)]
pub(super) struct StepContext<'f, 'm> {
    pub ground: &'f LoadContext<'f>,
    pub frame: StepScope<'f, 'm>,
    /// The deadline of expectations that have none.
    pub within: Option<&'f Node>,
    /// The start of the case, for `connect`.
    pub start: Option<&'f Node>,
    /// Inside a procedure, which does no other.
    pub in_procedure: bool,
}

impl<'f, 'm> StepContext<'f, 'm> {
    /// A list of steps; mistakes are noted and reading goes on.
    pub(super) fn steps(&self, nodes: &[Node]) -> Vec<TrialStep> {
        nodes.iter().filter_map(|node| self.ground.mistakes.keep(self.step(node))).collect()
    }

    fn block(&self, node: &Node, what: &str) -> Read<Vec<TrialStep>> {
        let items = node.items(what)?;
        if items.is_empty() {
            return Err(node.wrong(format!("{what} is empty")));
        }
        Ok(self.steps(items))
    }

    fn step(&self, node: &Node) -> Read<TrialStep> {
        let entries = node.entries("a step")?;
        let verbs: Vec<_> = VERBS.iter().filter(|(_, set)| node.get(word_of(set)).is_some()).collect();
        let [(verb, set)] = verbs.as_slice() else {
            return Err(self.no_verb(node, entries, verbs.len()));
        };
        // What a procedure is not given may stand under a misspelt key.
        let keyed = match verb {
            VerbWord::Do => Keyed::new(node, set)?,
            _ => Keyed::noting(node, set, self.ground.mistakes)?.0,
        };
        // A manual may give `none` to a common suite: then the check counts for the case.
        let covers = keyed.get(&expect_step::covers).filter(|covers| !is_none(covers));
        let covers = covers.map_or(Ok((Vec::new(), Vec::new())), |covers| self.covers(covers, node));
        let judged = both(covers, self.about(keyed, *verb));
        let second = match keyed.get(&connect_step::r#as) {
            None => false,
            Some(by) if by.plain() == Some("second") => true,
            Some(by) => return Err(by.wrong("`as` is `second` or left out")),
        };
        let verb = self.to(keyed).and_then(|to| self.verb(*verb, keyed, RequestSender { second, to }));
        let otherwise = keyed.get(&expect_step::otherwise).map(|node| node.text("a reason").map(str::to_owned));
        let otherwise = otherwise.transpose();
        let (((covers, apart), about), verb) = both(judged, verb)?;
        Ok(TrialStep {
            at: self.ground.location(node),
            text: shown(node),
            covers,
            apart,
            about,
            otherwise: otherwise?,
            verb,
        })
    }

    /// The requirements of a check, in all and for each name that has its own: `covers` is a list, or a mapping of names of the check.
    fn covers(&self, covers: &Node, step: &Node) -> Read<(Vec<usize>, CoversByName)> {
        let Some(entries) = covers.mapping() else {
            return Ok((self.ground.covers(covers, &self.frame)?, Vec::new()));
        };
        let checked = step.get(word_of(&read_step::KEYS)).or(step.get(word_of(&expect_step::KEYS)));
        let Some(names) = checked.and_then(Node::mapping) else {
            return Err(covers.wrong("`covers` is a mapping only beside `read` and `expect` with names"));
        };
        let (mut all, mut apart): (Vec<usize>, CoversByName) = (Vec::new(), Vec::new());
        for (name, of) in entries.iter().filter(|(_, of)| !is_none(of)) {
            let word = plain(name, "a name")?;
            let Some(at) = names.iter().position(|(known, _)| known.scalar() == Some(word)) else {
                let known = names.iter().filter_map(|(known, _)| known.scalar());
                return Err(Mistake::unknown(name.spot, "name of this check", word, known));
            };
            let own = self.ground.covers(of, &self.frame)?;
            all.extend(own.iter().filter(|of| !all.contains(of)).copied().collect::<Vec<usize>>());
            apart.push((at, own));
        }
        apart.sort_by_key(|(at, _)| *at);
        Ok((all, apart))
    }

    /// What a failure of the step is about: its own `about`, else that of the procedure which it runs. Requirements of a procedure that do
    /// not apply to the variant are left out.
    fn about(&self, keyed: Keyed<'_>, verb: VerbWord) -> Read<FailureSubject> {
        let of_procedure = |about: &Node| {
            let list = self.ground.covers_here(about, &self.frame)?;
            Ok(if list.is_empty() { FailureSubject::Unsaid } else { FailureSubject::OfProcedure(list) })
        };
        if let Some(own) = keyed.get(&expect_step::about) {
            return match (own.plain(), self.in_procedure) {
                (Some("none"), _) => Ok(FailureSubject::Unsaid),
                (Some("case"), false) if verb == VerbWord::Do => Ok(FailureSubject::Case),
                (_, true) => of_procedure(own),
                (_, false) => self.ground.covers(own, &self.frame).map(FailureSubject::OfCase),
            };
        }
        let procedure = keyed.node.get(procedure_step::r#do.name).filter(|_| verb == VerbWord::Do);
        let procedure = procedure.and_then(|name| self.ground.procedures.get(name.plain()?));
        procedure.and_then(|procedure| procedure.about.as_ref()).map_or(Ok(FailureSubject::Unsaid), of_procedure)
    }

    /// The station address after `to`.
    fn to(&self, keyed: Keyed<'_>) -> Read<Option<Program>> {
        let Some(to) = keyed.get(&connect_step::to) else { return Ok(None) };
        if self.ground.device.profinet().is_some() {
            return Err(keyed.node.key(connect_step::to.name).wrong("`to` exists on PROFIBUS only"));
        }
        self.frame.value(to, &Type::whole(8, false)).map(Some)
    }

    fn no_verb(&self, node: &Node, entries: &[(Node, Node)], count: usize) -> Box<Mistake> {
        let words: Vec<&str> = VERBS.iter().map(|(_, set)| word_of(set)).collect();
        if count > 1 {
            return node.wrong("a step has exactly one verb").help("write two steps");
        }
        let is_known =
            |key: &Node| VERBS.iter().any(|(_, set)| key.scalar().is_some_and(|name| set.key(name).is_some()));
        let strange = entries.iter().map(|(key, _)| key).find(|key| !is_known(key));
        match strange.and_then(|key| key.scalar().map(|name| (key, name))) {
            Some((key, name)) => Mistake::unknown(key.spot, "verb", name, words),
            None => node.wrong("a step without a verb").help(format!("the verbs are {}", words.join(", "))),
        }
    }

    fn verb(&self, verb: VerbWord, keyed: Keyed<'_>, by: RequestSender) -> Read<Verb> {
        let (frame, node) = (&self.frame, keyed.node);
        let value = VERBS.iter().find(|(word, _)| *word == verb).and_then(|(_, set)| node.get(word_of(set)));
        let value = value.ok_or_else(|| node.wrong("a step without a verb"))?;
        let answer = keyed.get(&connect_step::answer);
        let second = by.second;
        Ok(match verb {
            VerbWord::Set => Verb::Set(self.settings(value)?),
            VerbWord::Turn => Verb::Turn(self.turn(value)?),
            VerbWord::Exchange => Verb::Exchange(self.exchange(value)?),
            VerbWord::Connect if is_none(value) => {
                if let Some(answer) = answer {
                    return Err(answer.wrong("ending a connection has no answer"));
                }
                Verb::Disconnect { second }
            }
            VerbWord::Connect => {
                value.entries("connect")?;
                let case = self.start.filter(|start| !is_none(start));
                let start = merged(case, Some(value))?.unwrap_or_else(|| value.clone());
                let before = frame.progress.module.get();
                let start = frame.start(&Node { spot: value.spot, ..start })?;
                if second {
                    frame.progress.module.set(before);
                }
                let answer = answer.map(|node| frame.answer(node, RequestKind::Connect)).transpose()?;
                Verb::Connect { start, answer, second, to: by.to }
            }
            VerbWord::Write => Verb::Write(frame.access(value, true, keyed.get(&write_step::instead), answer, by)?),
            VerbWord::Read => Verb::Read {
                access: frame.access(value, false, keyed.get(&read_step::instead), None, by)?,
                within: keyed.get(&read_step::within).map(|within| frame.deadline(within)).transpose()?,
            },
            VerbWord::Send => {
                let (service, asked) = frame.service(value)?;
                if let (Some(answer), AcyclicService::Broken(_)) = (answer, &service)
                    && frame.names.device().profibus().is_none()
                {
                    return Err(answer
                        .wrong("what comes after a damaged frame is not judged on PROFINET")
                        .help("leave `answer` out, and judge what the device does next"));
                }
                let answer = answer.map(|node| frame.answer(node, asked)).transpose()?;
                let repeats = keyed.get(&send_step::repeats);
                let repeats = repeats.map_or(Ok(0), |repeats| frame.repeats(repeats, &service))?;
                Verb::Send { service, answer, second, to: by.to, repeats }
            }
            VerbWord::Expect => {
                let condition = frame.checks(value);
                let within = match keyed.get(&expect_step::within).or(self.within) {
                    Some(within) => frame.deadline(within),
                    None => Ok(frame.usual_deadline()),
                };
                let hold = self.hold(keyed, &expect_step::r#for, &expect_step::until);
                let ((condition, within), hold) = both(both(condition, within), hold)?;
                Verb::Expect { condition, within, hold }
            }
            VerbWord::Wait => Verb::Wait(frame.span(value)?),
            VerbWord::Save => self.save(value)?,
            VerbWord::Steps => {
                let times = keyed
                    .get(&block_step::times)
                    .map_or(Ok(1), |times| frame.number::<u32>(times, "a number of times"))?;
                if let Some(node) = keyed.get(&block_step::times).filter(|_| times == 0) {
                    return Err(node.wrong("a block that is never done"));
                }
                let steps = self.block(value, "a block")?;
                let observe =
                    keyed.get(&block_step::observe).map_or(Ok(Vec::new()), |observe| self.observations(observe))?;
                Verb::Block { steps, times, observe }
            }
            VerbWord::Either => self.either(value, keyed.get(&either_step::finding))?,
            VerbWord::Do => self.procedure(value, keyed.get(&procedure_step::give))?,
        })
    }

    /// How long something stays true, by the keys `hold` and `until` of a step or a rule.
    pub(super) fn hold(&self, keyed: Keyed<'_>, hold: &Key, until: &Key) -> Read<HoldTime> {
        match (keyed.get(hold), keyed.get(until)) {
            (None, None) => Ok(HoldTime::None),
            (Some(hold), _) => Ok(HoldTime::For(self.frame.span(hold)?)),
            (None, Some(until)) => Ok(HoldTime::Until(self.frame.checks(until)?)),
        }
    }

    fn settings(&self, node: &Node) -> Read<Vec<Setting>> {
        let entries = node.entries("set")?;
        if entries.is_empty() {
            return Err(node.wrong("an empty `set`"));
        }
        every(entries.iter().map(|(key, value)| self.setting(key, value)))
    }

    fn setting(&self, key: &Node, value: &Node) -> Read<Setting> {
        let name = self.frame.name(key, Verbs::SET, "set")?;
        self.frame.signals_of_octets(value, &name.kind)?;
        let counts = match name.kind {
            NameKind::Signal { signal, field: Some(field), .. } => {
                let of = self.frame.names.device().signals.get(signal).and_then(|signal| signal.fields.get(field));
                of.is_some_and(|field| field.counts.is_some())
            }
            _ => false,
        };
        let set = match (&name.kind, &name.ty) {
            (NameKind::OutputOctets(_), _) => SetValue::Bytes(octets(value)?),
            (NameKind::Signal { .. }, _) => match value.plain() {
                Some(word @ ("held" | "counting")) if counts => SetValue::Word(word.to_owned()),
                Some(word) if counts && word.starts_with(|c: char| c.is_ascii_alphabetic()) => {
                    return Err(Mistake::unknown(value.spot, "way to count", word, ["held", "counting"]));
                }
                _ => SetValue::Value(self.frame.value(&*self.frame.bits_as_number(value, key, &name)?, &name.ty)?),
            },
            (_, Type::Word(table)) => {
                self.frame.literal(value, &name.ty)?;
                let word = plain(value, "a word")?;
                debug_assert!(table.number(word).is_some(), "the literal was read");
                SetValue::Word(word.to_owned())
            }
            _ => SetValue::Value(self.frame.value(value, &name.ty)?),
        };
        Ok(Setting { name: name.id, value: set })
    }

    fn turn(&self, node: &Node) -> Read<Turn> {
        let keyed = Keyed::new(node, &turn::KEYS)?;
        let number = |node: &Node, ty: &Type| self.frame.value(node, ty);
        let way = match (keyed.get(&turn::revolutions), keyed.get(&turn::counts)) {
            (Some(way), _) => TurnAngle::Revolutions(number(way, &Type::FRACTION)?),
            (None, Some(way)) => TurnAngle::Counts(number(way, &Type::WHOLE)?),
            (None, None) => TurnAngle::Degrees(number(keyed.must(&turn::degrees)?, &Type::FRACTION)?),
        };
        let rpm = match keyed.get(&turn::rpm) {
            Some(rpm) => number(rpm, &Type::FRACTION)?,
            None => Program::value("60", Some(&Type::FRACTION), &self.frame, Allow::VALUE)
                .map_err(|error| in_expression(node, "60", error))?,
        };
        Ok(Turn { way, rpm })
    }

    fn exchange(&self, node: &Node) -> Read<Vec<ExchangeEntry>> {
        let items = node.items("exchange")?;
        if items.is_empty() {
            return Err(node.wrong("an empty `exchange`"));
        }
        let entry = |node: &Node| {
            let keyed = Keyed::new(node, &exchanged::KEYS)?;
            if let Some(key) = keyed.key(&exchanged::expect).filter(|_| self.ground.device.profinet().is_some()) {
                return Err(key
                    .wrong("`expect` in `exchange` exists on PROFIBUS only")
                    .help("the two directions of PROFINET are not in step: expect in a step of its own"));
            }
            let times = match keyed.get(&exchanged::times) {
                Some(times) => {
                    self.frame.number::<u32>(times, "a number of cycles")?;
                    self.frame.value(times, &Type::WHOLE)?
                }
                None => Program::value("1", Some(&Type::WHOLE), &self.frame, Allow::VALUE)
                    .map_err(|error| in_expression(node, "1", error))?,
            };
            let set = keyed.get(&exchanged::set).map_or(Ok(Vec::new()), |set| self.settings(set))?;
            let expect = keyed.get(&exchanged::expect).map(|expect| self.frame.checks(expect)).transpose()?;
            Ok(ExchangeEntry { set, times, expect })
        };
        every(items.iter().map(entry))
    }

    fn save(&self, node: &Node) -> Read<Verb> {
        let mut list = Vec::new();
        let entries = named(node, "save")?;
        if entries.is_empty() {
            return Err(node.wrong("an empty `save`"));
        }
        for (name, value) in entries {
            if self.frame.columns.iter().any(|column| column.name == name) || self.frame.names.find(name).is_some() {
                return Err(node
                    .key(name)
                    .wrong(format!("`{name}` is a name already"))
                    .help("save it under another name"));
            }
            let text = value.text("an expression")?;
            let (text, ahead) = text.strip_prefix('=').map_or((text, 0), |text| (text, 1));
            let program = Program::value(text, None, &self.frame, Allow::VALUE)
                .map_err(|error| Mistake::expression(value.spot, value.lead() + ahead, text, error))?;
            let mut saved = self.frame.progress.saved.borrow_mut();
            let number = match saved.iter().position(|(known, ty)| known == name && ty == program.ty()) {
                Some(number) => number,
                None if saved.iter().any(|(known, _)| known == name) => {
                    return Err(node.key(name).wrong(format!("`{name}` was saved with another type before")));
                }
                None => {
                    saved.push((name.to_owned(), program.ty().clone()));
                    saved.len() - 1
                }
            };
            list.push((self.frame.names.saved(number, name, program.ty()), program));
        }
        Ok(Verb::Save(list))
    }

    fn either(&self, node: &Node, finding: Option<&Node>) -> Read<Verb> {
        let readings = named(node, "either")?;
        if readings.len() < 2 {
            return Err(node.wrong("`either` has two or more readings"));
        }
        let findings = finding.map_or(Ok(Vec::new()), |finding| named(finding, "finding"))?;
        for (name, said) in &findings {
            if !readings.iter().any(|(known, _)| known == name) {
                let key = finding.map_or(said.spot, |finding| finding.key(name).spot);
                return Err(Mistake::unknown(key, "reading", name, readings.iter().map(|(name, _)| *name)));
            }
        }
        if findings.len() == readings.len() {
            return Err(node.wrong("every reading is a fault").help("one of them is right: give it no `finding`"));
        }
        let mut list: Vec<ManualReading> = Vec::new();
        for (name, steps) in readings {
            let said = findings.iter().find(|(known, _)| *known == name).map(|(_, said)| said.text("a finding"));
            let said = said.transpose()?.map(str::to_owned);
            if said.is_none() && list.iter().any(|reading| reading.finding.is_some()) {
                return Err(node.key(name).wrong("a right reading stands before those that are faults"));
            }
            for step in steps.items("a reading")? {
                if step.get("expect").is_none() && step.get("read").is_none() {
                    return Err(step.wrong("a reading has only `expect` and `read`"));
                }
            }
            list.push(ManualReading { name: name.to_owned(), steps: self.block(steps, "a reading")?, finding: said });
        }
        Ok(Verb::Either(list))
    }

    fn procedure(&self, node: &Node, give: Option<&Node>) -> Read<Verb> {
        let name = plain(node, "a procedure")?;
        if self.in_procedure {
            return Err(node.wrong("a procedure does no other procedure"));
        }
        let Some(procedure) = self.ground.procedures.get(name) else {
            let mut known: Vec<&str> = self.ground.procedures.keys().map(String::as_str).collect();
            known.sort_unstable();
            return Err(Mistake::unknown(node.spot, "procedure", name, known));
        };
        self.frame.names.mark("procedure", name);
        let given = give.map_or(Ok(Vec::new()), |give| named(give, "give"))?;
        if let Some((strange, value)) = given.iter().find(|(name, _)| !procedure.takes.iter().any(|take| take == name))
        {
            let key = give.map_or(value.spot, |give| give.key(strange).spot);
            return Err(Mistake::unknown(key, "entry of give", strange, procedure.takes.iter().map(String::as_str)));
        }
        if let Some(missing) = procedure.takes.iter().find(|take| !given.iter().any(|(name, _)| name == take)) {
            return Err(node.wrong(format!("`{name}` has to be given `{missing}`")));
        }
        let columns: Vec<Column> = given.into_iter().map(|(name, value)| Column::new(name, value.clone())).collect();
        let steps = replaced(&procedure.steps, &columns)?;
        let place = StepContext {
            ground: self.ground,
            frame: self.frame.with(&columns),
            within: self.within,
            start: self.start,
            in_procedure: true,
        };
        Ok(Verb::Block { steps: place.block(&steps, "a procedure")?, times: 1, observe: Vec::new() })
    }
}

/// A step on one line; blocks and readings without what is in them.
fn shown(node: &Node) -> String {
    let part = |(key, value): &(Node, Node)| -> Option<String> {
        match (key.scalar()?, &value.kind) {
            ("steps" | "observe", NodeKind::Sequence(_)) => None,
            ("either", NodeKind::Mapping(readings)) => {
                let names: Vec<&str> = readings.iter().filter_map(|(name, _)| name.scalar()).collect();
                Some(format!("either: {}", names.join(" | ")))
            }
            _ => Some(format!("{key}: {value}")),
        }
    };
    let parts: Vec<String> = node.mapping().unwrap_or_default().iter().filter_map(part).collect();
    if parts.is_empty() { "steps".to_owned() } else { parts.join(", ") }
}
