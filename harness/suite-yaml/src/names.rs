//! The name table: what each name of a suite is, which type it has, and with which verbs it is used.
//!
//! Names are made on first use and stored per variant; what was never looked up is unused.

mod build;
mod known;
mod of_bus;

use super::device_yaml::Described;
use super::error::{Mistake, Mistakes, Read};
use super::yaml::Node;
use expression::{Allow, NameId, NameScope, Number, Program, ResolvedName, Type, Value, WordTable};
use rustc_hash::{FxHashMap, FxHashSet};
use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::sync::Arc;
use suite::device::{AnswerPart, DeviceDescription, NameKind};
use suite::model::{SuiteRule, SuiteVariant, Trial};
use suite::words::WordList;

/// How the times of ours begin.
const OURS: &str = "timing.";

/// The verbs that a name has, as bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Verbs(u8);

impl Verbs {
    pub(super) const NONE: Verbs = Verbs(0);
    pub(super) const SET: Verbs = Verbs(1);
    pub(super) const EXPECT: Verbs = Verbs(2);
    pub(super) const READ: Verbs = Verbs(4);
    pub(super) const WRITE: Verbs = Verbs(8);

    const fn and(self, other: Verbs) -> Verbs {
        Verbs(self.0 | other.0)
    }

    fn has(self, verb: Verbs) -> bool {
        self.0 & verb.0 != 0
    }

    fn words(self) -> Vec<&'static str> {
        let all =
            [(Verbs::SET, "`set`"), (Verbs::EXPECT, "`expect`"), (Verbs::READ, "`read`"), (Verbs::WRITE, "`write`")];
        all.into_iter().filter(|(verb, _)| self.has(*verb)).map(|(_, word)| word).collect()
    }
}

/// A name as steps and conditions see it.
#[derive(Clone, Debug)]
pub(super) struct Name {
    pub id: NameId,
    pub kind: NameKind,
    pub ty: Type,
    pub verbs: Verbs,
}

/// What was declared and used, over all variants and files of a manual.
#[derive(Debug, Default)]
pub(super) struct Used {
    known: RefCell<FxHashSet<String>>,
    /// Where a key is put together; nearly always it is known already.
    key: RefCell<String>,
}

impl Used {
    pub(super) fn mark(&self, kind: &str, name: &str) {
        self.mark_parts(kind, &[name]);
    }

    /// Marks a name that is put together of parts.
    fn mark_parts(&self, kind: &str, name: &[&str]) {
        let mut key = self.key.borrow_mut();
        key.clear();
        [kind, " `"].iter().chain(name).chain(&["`"]).for_each(|part| key.push_str(part));
        let mut known = self.known.borrow_mut();
        if !known.contains(key.as_str()) {
            known.insert(key.clone());
        }
    }

    pub(super) fn has(&self, declared: &str) -> bool {
        self.known.borrow().contains(declared)
    }
}

/// Something with the times of ours taken `patience` times.
pub(super) struct Patient<T> {
    pub value: T,
    /// The times of ours in it.
    pub names: Vec<String>,
}

/// The names of one variant.
pub(super) struct Names<'m> {
    pub described: &'m Described,
    /// Index of the variant.
    pub variant: usize,
    used: &'m Used,
    made: RefCell<Vec<(NameKind, String, Type)>>,
    paths: RefCell<FxHashMap<String, Name>>,
    saved: RefCell<FxHashMap<(usize, String), NameId>>,
    circles: RefCell<Vec<Option<Program>>>,
    derived: RefCell<Vec<(String, Program)>>,
    /// The LEDs that were looked up since [`take_leds`](Self::take_leds).
    leds: RefCell<BTreeSet<usize>>,
    /// The times of ours that were looked up since [`with_ours`](Self::with_ours) began.
    ours: RefCell<BTreeSet<String>>,
    /// The factor that times of ours are taken with.
    factor: Cell<u32>,
}

impl<'m> Names<'m> {
    /// The names of a variant; `derived` and the circles are compiled here.
    pub(super) fn new(described: &'m Described, variant: usize, used: &'m Used, mistakes: &Mistakes) -> Names<'m> {
        let names = Names {
            described,
            variant,
            used,
            made: RefCell::default(),
            paths: RefCell::default(),
            saved: RefCell::default(),
            circles: RefCell::default(),
            derived: RefCell::default(),
            leds: RefCell::default(),
            ours: RefCell::default(),
            factor: Cell::new(1),
        };
        for name in &described.mentioned {
            used.known.borrow_mut().insert(name.clone());
        }
        for (name, node) in &described.derived {
            let program = mistakes.keep(names.device_program(node));
            names.derived.borrow_mut().extend(program.map(|program| (name.clone(), program)));
        }
        if names.derived.borrow().len() < described.derived.len() {
            return names;
        }
        for node in &described.circles {
            let program = mistakes.keep(names.device_program(node));
            names.circles.borrow_mut().push(program);
        }
        names
    }

    fn device_program(&self, node: &Node) -> Read<Program> {
        let text = node.text("an expression")?;
        self.mark_words_in(text);
        let scope = DeviceScope(self);
        Program::value(text, None, &scope, Allow::DEVICE)
            .map_err(|error| Mistake::expression(node.spot, node.lead(), text, error))
    }

    pub(super) fn device(&self) -> &'m DeviceDescription {
        &self.described.device
    }

    /// Marks something of the device as used.
    pub(super) fn mark(&self, kind: &str, name: &str) {
        self.used.mark(kind, name);
    }

    /// Marks a word of a table as used.
    pub(super) fn mark_word(&self, table: &str, word: &str) {
        let coded = ["channel_error", "diagnosis_error"].contains(&table);
        self.used.mark_parts(if coded { "code" } else { "word" }, &[table, ".", word]);
    }

    /// Marks every word that an expression could mean.
    pub(super) fn mark_words_in(&self, text: &str) {
        for token in text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')) {
            for table in self.described.tables.iter().filter(|table| table.number(token).is_some()) {
                self.mark_word(&table.name, token);
            }
        }
    }

    /// Marks a submodule with what it needs, or a module with its submodules.
    pub(super) fn mark_module(&self, module: usize) {
        let device = self.device();
        let Some(module) = device.modules.get(module) else { return };
        self.mark("module", &module.name);
        let submodules = module.submodules.iter().filter_map(|index| device.submodules.get(*index));
        submodules.for_each(|submodule| self.mark("submodule", &submodule.name));
    }

    /// The name `path`; `None` if there is none, a mistake's text and help if there could be one.
    pub(super) fn find(&self, path: &str) -> Option<Result<Name, (String, Option<String>)>> {
        let known = self.paths.borrow().get(path).cloned();
        let found = match known {
            Some(name) => Ok(name),
            None => self.build(path)?.map(|(kind, ty, verbs)| {
                let name = Name { id: self.make(kind.clone(), path, ty.clone()), kind, ty, verbs };
                self.paths.borrow_mut().insert(path.to_owned(), name.clone());
                name
            }),
        };
        if let Ok(Name { kind: NameKind::Led(led), .. }) = &found {
            self.leds.borrow_mut().insert(*led);
        }
        Some(found)
    }

    /// The value of a constant; a time of ours is noted and taken with the factor of the moment.
    fn taken(&self, path: &str, value: Value) -> Value {
        if !path.starts_with(OURS) {
            return value;
        }
        self.ours.borrow_mut().insert(path.to_owned());
        let factor = Number::whole(self.factor.get().into());
        match value {
            Value::Time(time) => Value::Time(time.times(factor).unwrap_or(time)),
            Value::Cycles(cycles) => Value::Cycles(cycles.times(factor).unwrap_or(cycles)),
            value => value,
        }
    }

    /// What `make` gives, and if it uses times of ours, what it gives with `patience` times these, and their names.
    pub(super) fn with_ours<T>(&self, make: impl Fn() -> Read<T>) -> Read<(T, Option<Patient<T>>)> {
        self.ours.borrow_mut().clear();
        let usual = make()?;
        let names: Vec<String> = self.ours.take().into_iter().collect();
        if names.is_empty() {
            return Ok((usual, None));
        }
        self.factor.set(self.device().timing.patience);
        let patient = make();
        self.factor.set(1);
        Ok((usual, Some(Patient { value: patient?, names })))
    }

    /// The LEDs that were looked up since the last call.
    pub(super) fn take_leds(&self) -> Vec<usize> {
        self.leds.take().into_iter().collect()
    }

    /// The name of a saved value of a trial, by its number there.
    pub(super) fn saved(&self, number: usize, name: &str, ty: &Type) -> NameId {
        let key = (number, format!("{name} {ty:?}"));
        if let Some(id) = self.saved.borrow().get(&key) {
            return *id;
        }
        let id = self.make(NameKind::Saved(number), name, ty.clone());
        self.saved.borrow_mut().insert(key, id);
        id
    }

    fn make(&self, kind: NameKind, path: &str, ty: Type) -> NameId {
        let mut made = self.made.borrow_mut();
        made.push((kind, path.to_owned(), ty));
        NameId(made.len() as u32 - 1)
    }

    /// What a name is, by its number.
    pub(super) fn kind(&self, id: NameId) -> Option<NameKind> {
        self.made.borrow().get(id.0 as usize).map(|(kind, ..)| kind.clone())
    }

    /// The modules that have the signal.
    pub(super) fn has_signal(&self, module: usize, signal: usize) -> bool {
        let device = self.device();
        let submodules = device.modules.get(module).map_or(&[][..], |module| &module.submodules);
        submodules
            .iter()
            .filter_map(|index| device.submodules.get(*index))
            .any(|submodule| submodule.outputs.contains(&signal) || submodule.inputs.contains(&signal))
    }

    /// The variant with its names, for the engine.
    pub(super) fn into_variant(self, trials: Vec<Trial>, rules: Vec<SuiteRule>) -> SuiteVariant {
        let name = self.device().variants.get(self.variant).cloned().unwrap_or_default();
        let (mut names, mut paths, mut types) = (Vec::new(), Vec::new(), Vec::new());
        for (kind, path, ty) in self.made.into_inner() {
            names.push(kind);
            paths.push(path);
            types.push(ty);
        }
        SuiteVariant { name, names, paths, types, trials, rules, derived: self.derived.into_inner() }
    }

    /// The mistake that `path` is used with a verb that it does not have.
    pub(super) fn wrong_verb(at: &Node, path: &str, name: &Name, verb: &str) -> Box<Mistake> {
        let words = name.verbs.words();
        let mistake = at.wrong(format!("`{path}` has no `{verb}`"));
        match words.as_slice() {
            [] => mistake.help("it is a value, for expressions only"),
            words => mistake.help(format!("use {}", words.join(" or "))),
        }
    }

    /// The name `path` for a verb.
    pub(super) fn for_verb(&self, at: &Node, path: &str, verb: Verbs, word: &str) -> Read<Name> {
        match self.find(path) {
            None => {
                let mut known: Vec<String> = Vec::new();
                self.known(&mut |name| known.push(name.to_owned()));
                Err(Mistake::unknown(at.spot, "name", path, known.iter().map(String::as_str)))
            }
            Some(Err((message, help))) => {
                let mistake = at.wrong(message);
                Err(match help {
                    Some(help) => mistake.help(help),
                    None => mistake,
                })
            }
            Some(Ok(name)) if !name.verbs.has(verb) => Err(Names::wrong_verb(at, path, &name, word)),
            Some(Ok(name)) => Ok(name),
        }
    }

    /// A name in an expression.
    pub(super) fn lookup(&self, path: &str) -> Option<ResolvedName> {
        Some(match self.find(path)? {
            Err((message, help)) => ResolvedName::Refused { message, help },
            Ok(Name { kind: NameKind::Constant(value), ty, .. }) => ResolvedName::Constant(self.taken(path, value), ty),
            Ok(name) if name.verbs == Verbs::SET && !matches!(name.kind, NameKind::Signal { .. }) => {
                ResolvedName::Refused {
                    message: format!("`{path}` has no value that can be observed"),
                    help: Some("it can only be `set`".to_owned()),
                }
            }
            Ok(Name { kind: NameKind::Answer(part), .. })
                if !matches!(part, AnswerPart::Bytes | AnswerPart::Text | AnswerPart::Number) =>
            {
                ResolvedName::Refused {
                    message: format!("`{path}` is no value"),
                    help: Some(format!("write it as a key: `expect: {{ {path}: ... }}`")),
                }
            }
            Ok(name) => ResolvedName::Name(name.id, name.ty),
        })
    }
}

/// The names of `derived` and `position_in`: start parameters and constants.
struct DeviceScope<'n, 'm>(&'n Names<'m>);

impl NameScope for DeviceScope<'_, '_> {
    fn lookup(&self, path: &str) -> Option<ResolvedName> {
        if path.starts_with(OURS) {
            return Some(ResolvedName::Refused {
                message: format!("`{path}` is a time of ours, which no derived value hides"),
                help: Some("use it where the time is needed: `within: =derived + timing.name`".to_owned()),
            });
        }
        match self.0.lookup(path)? {
            ResolvedName::Name(id, ty) => match self.0.kind(id) {
                Some(NameKind::StartParameter { .. } | NameKind::Derived(_)) => Some(ResolvedName::Name(id, ty)),
                _ => Some(ResolvedName::Refused {
                    message: format!("`{path}` is neither a start parameter nor a constant"),
                    help: None,
                }),
            },
            found => Some(found),
        }
    }

    fn known(&self, visit: &mut dyn FnMut(&str)) {
        self.0.values(visit);
    }
}

/// A table of built-in words as a type.
pub(super) fn built_in(name: &str, table: WordList) -> Type {
    Type::Word(WordTable::new(name, table.iter().map(|(word, number)| (*word, *number))))
}

/// A table of words without numbers as a type.
pub(super) fn plain_words(name: &str, words: impl IntoIterator<Item = impl Into<String>>) -> Type {
    Type::Word(WordTable::plain(name, words))
}

/// The type of a field with a table, or with so many bits.
pub(super) fn field_type(table: Option<&Arc<WordTable>>, width: u32, signed: bool) -> Type {
    match (table, width) {
        (Some(table), _) => Type::Word(Arc::clone(table)),
        (None, 1) => Type::Bit,
        (None, _) => Type::whole(width, signed),
    }
}
