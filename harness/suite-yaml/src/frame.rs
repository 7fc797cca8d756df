//! The names that one trial adds to those of the device: columns, what a procedure or a common suite is given, saved
//! values, roles; and the replacing of `=name`.

use super::error::{Mistake, Read};
use super::names::{Name, Names, Verbs};
use super::yaml::{Node, NodeKind};
use expression::{Allow, DurationLiteral, NameScope, Program, ResolvedName, Type, Value};
use std::cell::{Cell, RefCell};
use suite::device::NameKind;
use suite::model::{Deadline, OurLimit, TimeSpan};

/// A name and the node that stands for it: a column, an entry of `give`.
#[derive(Clone, Debug)]
pub(super) struct Column {
    pub name: String,
    pub value: Node,
    pub used: Cell<bool>,
}

impl Column {
    pub(super) fn new(name: &str, value: Node) -> Column {
        Column { name: name.to_owned(), value, used: Cell::new(false) }
    }
}

/// What a trial has done so far, as far as names depend on it.
#[derive(Debug, Default)]
pub(super) struct Progress {
    /// Saved values with their types, in the order of their numbers.
    pub saved: RefCell<Vec<(String, Type)>>,
    /// The module in use.
    pub module: Cell<Option<usize>>,
}

/// The names at one place of a trial.
#[derive(Clone, Copy)]
pub(super) struct StepScope<'f, 'm> {
    pub names: &'f Names<'m>,
    pub columns: &'f [Column],
    pub progress: &'f Progress,
    /// A rule holds for every module that has its signals, so none is in use.
    pub any_module: bool,
}

/// Replaces `=name` wherever it stands alone, as a value or as a key.
pub(super) fn replaced(node: &Node, columns: &[Column]) -> Read<Node> {
    if columns.is_empty() {
        return Ok(node.clone());
    }
    let column = |node: &Node| {
        let name = node.expression()?.trim();
        columns.iter().find(|column| column.name == name).inspect(|column| column.used.set(true))
    };
    let kind = match &node.kind {
        NodeKind::Scalar { .. } => return Ok(column(node).map_or_else(|| node.clone(), |column| column.value.clone())),
        NodeKind::Sequence(items) => {
            NodeKind::Sequence(items.iter().map(|item| replaced(item, columns)).collect::<Read<_>>()?)
        }
        NodeKind::Mapping(entries) => {
            let mut list: Vec<(Node, Node)> = Vec::with_capacity(entries.len());
            for (key, value) in entries {
                let key = match column(key) {
                    Some(column) => column.value.clone(),
                    None => key.clone(),
                };
                let Some(name) = key.scalar() else { return Err(key.wrong("only a single word can be a key")) };
                if list.iter().any(|(known, _)| known.scalar() == Some(name)) {
                    return Err(key.wrong(format!("duplicate key `{name}`")));
                }
                list.push((key, replaced(value, columns)?));
            }
            NodeKind::Mapping(list)
        }
    };
    Ok(Node { spot: node.spot, kind })
}

impl<'f, 'm> StepScope<'f, 'm> {
    /// The same place with other columns, as in a procedure.
    pub(super) fn with(self, columns: &'f [Column]) -> StepScope<'f, 'm> {
        StepScope { columns, ..self }
    }

    /// The path that `role.x` stands for in the module in use; other paths are themselves.
    fn role<'p>(&self, path: &'p str) -> Result<std::borrow::Cow<'p, str>, (String, Option<String>)> {
        let Some(role) = path.strip_prefix("role.") else { return Ok(path.into()) };
        let device = self.names.device();
        let Some((_, signals)) = device.roles.iter().find(|(name, _)| name == role) else {
            let help = plain_text::nearest(role, device.roles.iter().map(|(name, _)| name.as_str()));
            return Err((format!("unknown role `{role}`"), help.map(|meant| format!("did you mean `{meant}`?"))));
        };
        self.names.mark("role", role);
        let Some(module) = self.progress.module.get() else {
            return Err((format!("`{path}` needs a connection, and none was made"), None));
        };
        let index = |name: &String| device.signals.iter().position(|signal| signal.name == *name);
        let found = signals.iter().find(|name| index(name).is_some_and(|signal| self.names.has_signal(module, signal)));
        signals.iter().for_each(|name| self.names.mark("signal", name));
        match found {
            Some(name) => Ok(name.clone().into()),
            None => {
                Err((format!("no name of the role `{role}` is in the module `{}`", device.modules[module].name), None))
            }
        }
    }

    /// What is wrong with using a signal that the module in use does not have.
    fn absent(&self, path: &str, kind: &NameKind) -> Option<(String, Option<String>)> {
        let (NameKind::Signal { signal, .. }, Some(module), false) =
            (kind, self.progress.module.get(), self.any_module)
        else {
            return None;
        };
        if self.names.has_signal(module, *signal) {
            return None;
        }
        let device = self.names.device();
        let having = (0..device.modules.len()).filter(|module| self.names.has_signal(*module, *signal));
        let having: Vec<String> = having.map(|module| format!("`{}`", device.modules[module].name)).collect();
        let help = (!having.is_empty()).then(|| format!("it is in {}", having.join(", ")));
        Some((format!("`{path}` is not in the module `{}`, which is in use here", device.modules[module].name), help))
    }

    /// A name for a verb: the name and the path that a role stands for.
    pub(super) fn name(&self, at: &Node, verb: Verbs, word: &str) -> Read<Name> {
        let path = at.text("a name")?;
        let raise = |(message, help): (String, Option<String>)| {
            let mistake = at.wrong(message);
            match help {
                Some(help) => mistake.help(help),
                None => mistake,
            }
        };
        let path = self.role(path).map_err(raise)?;
        let name = self.names.for_verb(at, &path, verb, word)?;
        match self.absent(&path, &name.kind) {
            Some(wrong) => Err(raise(wrong)),
            None => Ok(name),
        }
    }

    /// A value for a name of the type `ty`: a literal, or `=` and an expression.
    pub(super) fn value(&self, node: &Node, ty: &Type) -> Read<Program> {
        if let Some(text) = node.expression() {
            self.names.mark_words_in(text);
            return Program::value(text, Some(ty), self, Allow::VALUE)
                .map_err(|error| in_expression(node, text, error));
        }
        constant(self.literal(node, ty)?, ty, node)
    }

    /// A literal of the type `ty`; its word is marked as used.
    pub(super) fn literal(&self, node: &Node, ty: &Type) -> Read<Value> {
        let value = literal(node, ty)?;
        if let (Type::Word(table) | Type::Set(table), Some(word)) = (ty, node.scalar()) {
            self.names.mark_word(&table.name, word);
        }
        Ok(value)
    }

    /// A condition.
    pub(super) fn condition(&self, node: &Node) -> Read<Program> {
        let text = node.text("a condition")?;
        if text.trim().is_empty() {
            return Err(node.wrong("an empty condition"));
        }
        self.names.mark_words_in(text);
        Program::condition(text, self, Allow::TRACE)
            .map_err(|error| Mistake::expression(node.spot, node.lead(), text, error))
    }

    /// A duration or a number of cycles.
    pub(super) fn span(&self, node: &Node) -> Read<TimeSpan> {
        let Some(text) = node.expression() else {
            let text = super::device_yaml::plain(node, "a duration")?;
            return Ok(
                match expression::duration(text).map_err(|error| Mistake::expression(node.spot, 0, text, error))? {
                    DurationLiteral::Time(time) => TimeSpan::Time(time),
                    DurationLiteral::Cycles(cycles) => TimeSpan::Cycles(cycles),
                },
            );
        };
        let program =
            Program::value(text, None, self, Allow::VALUE).map_err(|error| in_expression(node, text, error))?;
        match (program.ty(), program.constant()) {
            (Type::Time, Some(value)) => {
                time(value).map(TimeSpan::Time).ok_or_else(|| node.wrong("this is no duration from 0 on"))
            }
            (Type::Cycles, Some(Value::Cycles(cycles))) => cycles
                .as_whole()
                .and_then(|cycles| u64::try_from(cycles).ok())
                .map(TimeSpan::Cycles)
                .ok_or_else(|| node.wrong("this is no number of cycles")),
            (Type::Time, None) => Ok(TimeSpan::Computed(program)),
            (ty, _) => Err(node.wrong(format!("expected a duration, found {ty}"))),
        }
    }

    /// A deadline; where it rests on times of ours, also how much later is only noted.
    pub(super) fn deadline(&self, node: &Node) -> Read<Deadline> {
        let (limit, ours) = self.names.with_ours(|| self.span(node))?;
        let ours = ours.map(|ours| Box::new(OurLimit { patient: ours.value, names: ours.names }));
        Ok(Deadline { limit, ours })
    }

    /// The deadline of an expectation without one.
    pub(super) fn usual_deadline(&self) -> Deadline {
        let timing = &self.names.device().timing;
        let patient = TimeSpan::Time(timing.reaction().saturating_mul(timing.patience));
        let ours = OurLimit { patient, names: vec!["timing.reaction".to_owned()] };
        Deadline { limit: TimeSpan::Time(timing.reaction()), ours: Some(Box::new(ours)) }
    }

    /// A number that is known when the suite is loaded.
    pub(super) fn count(&self, node: &Node, what: &str) -> Read<i128> {
        let program = self.value(node, &Type::WHOLE)?;
        let value = program.constant().and_then(Value::as_whole);
        value.ok_or_else(|| node.wrong(format!("{what} is a whole number that is known beforehand")))
    }

    /// A number that is known beforehand and fits its field.
    pub(super) fn number<T: TryFrom<i128>>(&self, node: &Node, what: &str) -> Read<T> {
        if node.expression().is_none() {
            return super::device_yaml::whole(node, what);
        }
        let value = self.count(node, what)?;
        T::try_from(value).map_err(|_| node.wrong(format!("{value} is out of range for {what}")))
    }
}

impl NameScope for StepScope<'_, '_> {
    fn lookup(&self, path: &str) -> Option<ResolvedName> {
        if let Some(place) = self.columns.iter().position(|column| column.name == path)
            && let (before, [column, ..]) = self.columns.split_at(place)
        {
            column.used.set(true);
            // A column may be made of those before it, so never of itself: `give: { vendor: =vendor }` means the constant.
            return Some(column_value(column, &self.with(before)));
        }
        let saved = self.progress.saved.borrow();
        if let Some((number, (name, ty))) = saved.iter().enumerate().find(|(_, (name, _))| name == path) {
            return Some(ResolvedName::Name(self.names.saved(number, name, ty), ty.clone()));
        }
        let refused = |(message, help)| Some(ResolvedName::Refused { message, help });
        let path = match self.role(path) {
            Ok(path) => path,
            Err(wrong) => return refused(wrong),
        };
        match self.names.lookup(&path)? {
            ResolvedName::Name(id, ty) => match self.names.kind(id).and_then(|kind| self.absent(&path, &kind)) {
                Some(wrong) => refused(wrong),
                None => Some(ResolvedName::Name(id, ty)),
            },
            found => Some(found),
        }
    }

    fn known(&self, visit: &mut dyn FnMut(&str)) {
        self.columns.iter().for_each(|column| visit(&column.name));
        self.progress.saved.borrow().iter().for_each(|(name, _)| visit(name));
        self.names.known(visit);
    }
}

/// What a column is inside an expression.
fn column_value(column: &Column, frame: &StepScope<'_, '_>) -> ResolvedName {
    let node = &column.value;
    let alone = |message: String| ResolvedName::Refused {
        message,
        help: Some(format!("`={}` standing alone may hold anything", column.name)),
    };
    let Some(text) = node.scalar() else {
        return alone(format!("`{}` is {}, no value", column.name, node.what()));
    };
    if let Some(text) = node.expression() {
        let program = Program::value(text, None, frame, Allow::VALUE);
        return match program.as_ref().map(|program| program.constant().map(|value| (value, program.ty()))) {
            Ok(Some((value, ty))) => ResolvedName::Constant(value.clone(), ty.clone()),
            Ok(None) => alone(format!("`{}` holds an expression", column.name)),
            Err(error) => ResolvedName::Refused { message: error.message.clone(), help: error.help.clone() },
        };
    }
    if node.plain().is_none() {
        return ResolvedName::Constant(Value::text(text), Type::Text);
    }
    if let Ok(number) = expression::number(text) {
        return ResolvedName::Constant(
            Value::Number(number),
            if number.is_whole() { Type::WHOLE } else { Type::FRACTION },
        );
    }
    match expression::duration(text) {
        Ok(DurationLiteral::Time(time)) => {
            ResolvedName::Constant(Value::nanos(i128::try_from(time.as_nanos()).unwrap_or(i128::MAX)), Type::Time)
        }
        Ok(DurationLiteral::Cycles(cycles)) => {
            ResolvedName::Constant(Value::Cycles(expression::Number::whole(cycles.into())), Type::Cycles)
        }
        Err(_) => ResolvedName::Word(text.to_owned()),
    }
}

/// A literal of the type `ty`: bytes and texts stand in quotes, all else does not.
pub(super) fn literal(node: &Node, ty: &Type) -> Read<Value> {
    let text = match ty {
        Type::Text | Type::Bytes => {
            let text = node.text(&ty.to_string())?;
            if node.plain().is_some() {
                return Err(node.wrong(format!("{ty} stands in quotes")).help(format!("write \"{text}\"")));
            }
            text
        }
        Type::Address => node.text(&ty.to_string())?,
        _ => super::device_yaml::plain(node, &ty.to_string())?,
    };
    expression::literal(text, ty).map_err(|error| Mistake::expression(node.spot, node.lead(), text, error))
}

/// Bytes without an open part.
pub(super) fn octets(node: &Node) -> Read<Vec<u8>> {
    match literal(node, &Type::Bytes)? {
        Value::Bytes(bytes) => Ok(bytes.to_vec()),
        _ => Err(node.wrong("`..` and `*` stand only in checks").help("write every byte")),
    }
}

/// The literal text of a node.
pub(super) fn text(node: &Node) -> Read<String> {
    match literal(node, &Type::Text)? {
        Value::Text(text) => Ok(text.to_string()),
        _ => Err(node.wrong("this is a text")),
    }
}

/// Whether a node is `none`.
pub(super) fn is_none(node: &Node) -> bool {
    node.plain() == Some("none")
}

/// A program that is this value.
pub(super) fn constant(value: Value, ty: &Type, node: &Node) -> Read<Program> {
    struct ConstantScope<'v>(&'v Value, &'v Type);
    impl NameScope for ConstantScope<'_> {
        fn lookup(&self, _: &str) -> Option<ResolvedName> {
            Some(ResolvedName::Constant(self.0.clone(), self.1.clone()))
        }
        fn known(&self, _: &mut dyn FnMut(&str)) {}
    }
    let ty = match (ty, &value) {
        (Type::Place(_), Value::Number(_)) => &Type::WHOLE,
        _ => ty,
    };
    Program::value("literal", Some(ty), &ConstantScope(&value, ty), Allow::VALUE)
        .map_err(|error| node.wrong(error.message))
}

/// A duration as time.
pub(super) fn time(value: &Value) -> Option<std::time::Duration> {
    match value {
        Value::Time(nanos) => {
            nanos.as_whole().and_then(|nanos| u64::try_from(nanos).ok()).map(std::time::Duration::from_nanos)
        }
        _ => None,
    }
}

/// A mistake in the expression after `=` of a node.
pub(super) fn in_expression(node: &Node, text: &str, error: expression::ExprError) -> Box<Mistake> {
    Mistake::expression(node.spot, node.lead() + 1, text, error)
}
