//! The right side of a check: values, tolerances, `any`, `in`, ranges, `not`, refusals.

use super::device_yaml::plain;
use super::dialect::{self, Service};
use super::error::{Mistake, Read, every};
use super::frame::{StepScope, in_expression};
use super::keys::Keyed;
use super::names::Verbs;
use super::yaml::Node;
use expression::{Allow, ExpectedValue, Type, Value};
use suite::device::NameKind;
use suite::model::{Code, Condition, ConditionPart, Matcher, PartTest};

key_set! {
    pub(crate) matcher "a matcher" {
        r#in may Any, "One of these values.";
        from may Any, "The lowest right value.";
        to may Any, "The highest right value.";
        not may Any, "Any other value than this.";
        refused may Any, "The request is refused with this code or one of these; `any` for any code.";
    }
}

impl StepScope<'_, '_> {
    /// What a value of the type `ty` is compared with; `service` is what a refusal would come from, if one can.
    pub(super) fn matcher(&self, node: &Node, ty: &Type, service: Option<Service>) -> Read<Matcher> {
        if let Some(items) = node.sequence() {
            let Type::Set(_) = ty else {
                return Err(node.wrong(format!("{ty} is no list")).help("for one of several write `{ in: [...] }`"));
            };
            let words =
                items.iter().map(|item| self.literal(item, ty).and_then(|_| Ok(plain(item, "a word")?.to_owned())));
            return words.collect::<Read<_>>().map(Matcher::Set);
        }
        let Some(entries) = node.mapping() else {
            return self.single(node, ty);
        };
        let keyed = Keyed::new(node, &matcher::KEYS)?;
        let [from, to] = [keyed.get(&matcher::from), keyed.get(&matcher::to)];
        let ends = usize::from(from.is_some()) + usize::from(to.is_some());
        if entries.len() != ends.max(1) {
            return Err(node.wrong("a matcher is one of `in`, `from` and `to`, `not`, `refused`"));
        }
        if ends > 0 {
            let bound = |end: Option<&Node>| end.map(|node| self.value(node, ty)).transpose();
            if matches!(ty, Type::Word(_) | Type::Text | Type::Bytes | Type::Address | Type::Bit) {
                return Err(node.wrong(format!("{ty} has no order")));
            }
            return Ok(Matcher::Range { from: bound(from)?, to: bound(to)? });
        }
        if let Some(list) = keyed.get(&matcher::r#in) {
            let items = list.items("in")?;
            if items.is_empty() {
                return Err(list.wrong("an empty list is nothing to choose from"));
            }
            return every(items.iter().map(|item| self.single(item, ty))).map(Matcher::In);
        }
        if let Some(not) = keyed.get(&matcher::not) {
            return Ok(Matcher::Not(Box::new(self.single(not, ty)?)));
        }
        match (keyed.get(&matcher::refused), service) {
            (Some(refused), Some(service)) => Ok(Matcher::Refused(self.refused(refused, service)?)),
            _ => Err(node.wrong("only an answer can be refused")),
        }
    }

    fn single(&self, node: &Node, ty: &Type) -> Read<Matcher> {
        if node.plain() == Some("any") {
            return Ok(Matcher::Any);
        }
        if let Some(text) = node.expression() {
            self.names.mark_words_in(text);
            let target = ExpectedValue::compile(text, ty, self, Allow::TRACE)
                .map_err(|error| in_expression(node, text, error))?;
            return match target.center().constant() {
                Some(Value::Pattern(pattern)) => Ok(Matcher::Bytes((**pattern).clone())),
                _ => Ok(Matcher::Equal(target)),
            };
        }
        match self.literal(node, ty)? {
            Value::Pattern(pattern) => Ok(Matcher::Bytes((*pattern).clone())),
            // Names of bytes appear in the failure of a check.
            Value::Bytes(_) => match expression::pattern(node.text("octets")?) {
                Ok(pattern) if pattern.is_named() => Ok(Matcher::Bytes(pattern)),
                _ => fixed(self.literal(node, ty)?, ty, node),
            },
            value => fixed(value, ty, node),
        }
    }

    /// The codes of a refusal; empty for any.
    pub(super) fn refused(&self, node: &Node, service: Service) -> Read<Vec<Code>> {
        if let Some(items) = node.sequence() {
            if items.is_empty() {
                return Err(node.wrong("an empty list of codes").help("write `any`"));
            }
            return items.iter().map(|item| code(item, service, self)).collect();
        }
        if node.plain() == Some("any") { Ok(Vec::new()) } else { Ok(vec![code(node, service, self)?]) }
    }

    /// A condition of an expectation: an expression, or names and what they have to be.
    pub(super) fn checks(&self, node: &Node) -> Read<Condition> {
        if node.mapping().is_none() {
            let program = self.condition(node)?;
            if let Some(value) = program.constant() {
                return Err(node.wrong(format!("this condition is always {}", value.truth().unwrap_or(false))));
            }
            return Ok(Condition {
                parts: vec![ConditionPart { text: program.text().to_owned(), test: PartTest::Expression(program) }],
            });
        }
        let entries = node.entries("a condition")?;
        if entries.is_empty() {
            return Err(node.wrong("an empty condition"));
        }
        let part = |(key, value): &(Node, Node)| {
            let name = self.name(key, Verbs::EXPECT, "expect")?;
            let text = format!("{key}: {value}");
            self.signals_of_octets(value, &name.kind)?;
            let matcher = match &name.kind {
                NameKind::Answer(part) => self.answer_part(value, part)?,
                _ => self.matcher(&*self.bits_as_number(value, key, &name)?, &name.ty, None)?,
            };
            Ok(ConditionPart { text, test: PartTest::Name(name.id, matcher) })
        };
        Ok(Condition { parts: every(entries.iter().map(part))? })
    }
}

/// The code that a word of a suite stands for.
fn code(node: &Node, service: Service, frame: &StepScope<'_, '_>) -> Read<Code> {
    let word = plain(node, "a code")?;
    if word.starts_with(|c: char| c.is_ascii_digit() || c == '-') {
        return Err(node
            .wrong("a code is a word, not a number")
            .help("give the number a word under `codes` of device.yaml"));
    }
    let own = frame.names.device().codes.iter().find(|(table, _)| table == "parameter_error");
    if let (Some((_, words)), Service::Parameters | Service::Last) = (own, service)
        && let Some((word, number)) = words.iter().find(|(known, _)| known == word)
    {
        frame.names.mark("code", &format!("parameter_error.{word}"));
        return Ok(Code::Parameter(u16::try_from(*number).unwrap_or(u16::MAX), word.clone()));
    }
    let tables = (dialect::of(frame.names.device().bus.kind()).codes)(service);
    let mut all = tables.iter().flat_map(|(_, words)| words);
    match all.find(|(known, _)| *known == word) {
        Some((_, code)) => Ok(code.clone()),
        None => {
            let known: Vec<&str> = tables.iter().flat_map(|(_, words)| words).map(|(word, _)| *word).collect();
            Err(Mistake::unknown(node.spot, "code", word, known))
        }
    }
}

/// A matcher for exactly this value.
pub(super) fn fixed(value: Value, ty: &Type, node: &Node) -> Read<Matcher> {
    struct LiteralScope<'v>(&'v Value, &'v Type);
    impl expression::NameScope for LiteralScope<'_> {
        fn lookup(&self, _: &str) -> Option<expression::ResolvedName> {
            Some(expression::ResolvedName::Constant(self.0.clone(), self.1.clone()))
        }
        fn known(&self, _: &mut dyn FnMut(&str)) {}
    }
    let of = match (ty, &value) {
        (Type::Place(_), Value::Number(_)) => Type::WHOLE,
        _ => ty.clone(),
    };
    let target = ExpectedValue::compile("literal", ty, &LiteralScope(&value, &of), Allow::VALUE);
    target.map(Matcher::Equal).map_err(|error| node.wrong(error.message))
}

/// What is written: a value, as a matcher that only it satisfies.
pub(super) fn written(frame: &StepScope<'_, '_>, node: &Node, ty: &Type) -> Read<Matcher> {
    match node.expression() {
        Some(text) => {
            // A tolerance has no meaning here: compiled as a value first, so that one is refused.
            frame.value(node, ty)?;
            ExpectedValue::compile(text, ty, frame, Allow::VALUE)
                .map(Matcher::Equal)
                .map_err(|error| in_expression(node, text, error))
        }
        None => match frame.literal(node, ty)? {
            Value::Pattern(_) => Err(node.wrong("`..` and `*` stand only in checks").help("write every byte")),
            value => fixed(value, ty, node),
        },
    }
}
