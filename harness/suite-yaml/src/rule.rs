//! Rules: those of a file and those that are observed over a block.

use super::error::{Mistake, Read};
use super::frame::Frame;
use super::keys::{self, Keyed};
use super::step::Place;
use super::yaml::Node;
use expression::{NameId, Program, Type, Value};
use suite::device::NameKind;
use suite::model::{BlockObservation, Condition, HoldTime, RuleBody, SequenceEntry};

/// A body and the names that it looks at.
pub(super) struct Body {
    pub body: RuleBody,
    pub names: Vec<NameId>,
}

impl Place<'_, '_> {
    /// `always`, or `when` and `then`.
    pub(super) fn body(&self, keyed: Keyed<'_>) -> Read<Body> {
        let node = keyed.node;
        match (keyed.get("always"), keyed.get("when"), keyed.get("then")) {
            (Some(always), None, None) => {
                for key in ["within", "for", "until"] {
                    if let Some(key) = keyed.key(key) {
                        return Err(key.wrong("`always` has no deadline and no hold"));
                    }
                }
                let condition = self.frame.checks(always)?;
                Ok(Body { names: names_of(&condition), body: RuleBody::Always(condition) })
            }
            (None, Some(when), Some(then)) => {
                let premise = self.frame.condition(when)?;
                if let Some(value) = premise.constant() {
                    return Err(when.wrong(format!("the premise is always {}", value.truth().unwrap_or(false))));
                }
                let Some(within) = keyed.get("within") else {
                    return Err(node.wrong("a rule has to say `within`").help("`within: 0` means at once"));
                };
                let within = self.frame.span(within)?;
                let then = self.frame.checks(then)?;
                let hold = self.hold(node)?;
                let mut names: Vec<NameId> = premise.names().collect();
                names.extend(names_of(&then));
                if let HoldTime::Until(until) = &hold {
                    names.extend(names_of(until));
                }
                Ok(Body { names, body: RuleBody::When { premise, then, within, hold } })
            }
            _ => Err(node.wrong("a rule has either `always`, or `when` and `then`")),
        }
    }

    /// The modules that have all the signals of these names.
    pub(super) fn modules(&self, names: &[NameId]) -> Vec<usize> {
        let frame = &self.frame;
        let signal = |id: &NameId| match frame.names.kind(*id) {
            Some(NameKind::Signal { signal, .. }) => Some(signal),
            _ => None,
        };
        let signals: Vec<usize> = names.iter().filter_map(signal).collect();
        let modules = 0..frame.names.device().modules.len();
        modules.filter(|module| signals.iter().all(|signal| frame.names.has_signal(*module, *signal))).collect()
    }

    pub(super) fn observations(&self, node: &Node) -> Read<Vec<BlockObservation>> {
        let items = node.items("observe")?;
        if items.is_empty() {
            return Err(node.wrong("an empty `observe`"));
        }
        items.iter().map(|item| self.observation(item)).collect()
    }

    fn observation(&self, node: &Node) -> Read<BlockObservation> {
        let keyed = Keyed::new(node, &keys::OBSERVED)?;
        let (text, at) = (node.to_string(), self.ground.location(node));
        let only = |keys: &[&str]| match node
            .entries("a rule")?
            .iter()
            .find(|(key, _)| !keys.iter().any(|known| key.scalar() == Some(known)))
        {
            Some((key, _)) => Err(key.wrong(format!("`{key}` does not go with `{}`", keys[0]))),
            None => Ok(()),
        };
        if let Some(count) = keyed.get("count") {
            only(&["count", "is"])?;
            let condition = self.frame.condition(count)?;
            let is = self.frame.matcher(self.is(keyed)?, &Type::whole(32, false), None)?;
            return Ok(BlockObservation::Count { text, at, condition, is });
        }
        if let Some(sequence) = keyed.get("sequence") {
            only(&["sequence", "is"])?;
            return self.sequence(sequence, self.is(keyed)?, text, at);
        }
        if let Some(is) = keyed.key("is") {
            return Err(is.wrong("`is` goes with `count` and `sequence`"));
        }
        Ok(BlockObservation::Rule { text, at, body: self.body(keyed)?.body })
    }

    fn is<'n>(&self, keyed: Keyed<'n>) -> Read<&'n Node> {
        keyed.get("is").ok_or_else(|| keyed.node.wrong("here `is` is missing"))
    }

    fn sequence(&self, names: &Node, is: &Node, text: String, at: suite::Location) -> Read<BlockObservation> {
        let mut programs = Vec::new();
        for node in names.items("sequence")? {
            let text = node.text("a name")?;
            let program = Program::value(text, None, &self.frame, expression::Allow::TRACE)
                .map_err(|error| Mistake::expression(node.spot, node.lead(), text, error))?;
            programs.push(program);
        }
        if programs.is_empty() {
            return Err(names.wrong("an empty `sequence`"));
        }
        let types: Vec<Type> = programs.iter().map(|program| program.ty().clone()).collect();
        let mut entries = Vec::new();
        for entry in is.items("is")? {
            entries.push(match entry.get("either") {
                Some(either) => {
                    if entry.mapping().is_some_and(|entries| entries.len() > 1) {
                        return Err(entry.wrong("`either` stands alone"));
                    }
                    let runs = either.items("either")?.iter().map(|run| {
                        run.items("a run of values")?
                            .iter()
                            .map(|values| self.values(values, &types))
                            .collect::<Read<Vec<_>>>()
                    });
                    SequenceEntry::Either(runs.collect::<Read<_>>()?)
                }
                None => SequenceEntry::Values(self.values(entry, &types)?),
            });
        }
        if entries.len() < 2 {
            return Err(is.wrong("a sequence has two or more entries"));
        }
        Ok(BlockObservation::Sequence { text, at, names: programs, is: entries })
    }

    fn values(&self, node: &Node, types: &[Type]) -> Read<Vec<Value>> {
        let items = node.items("an entry of a sequence")?;
        if items.len() != types.len() {
            return Err(node.wrong(format!("there are {} names, and here {} values", types.len(), items.len())));
        }
        items.iter().zip(types).map(|(item, ty)| constant(&self.frame, item, ty)).collect()
    }
}

fn constant(frame: &Frame<'_, '_>, node: &Node, ty: &Type) -> Read<Value> {
    match node.expression() {
        None => frame.literal(node, ty),
        Some(_) => {
            let program = frame.value(node, ty)?;
            program.constant().cloned().ok_or_else(|| node.wrong("the values of a sequence are known beforehand"))
        }
    }
}

/// The names that a condition looks at.
pub(super) fn names_of(condition: &Condition) -> Vec<NameId> {
    let mut names = Vec::new();
    condition.each_name(&mut |name| names.push(name));
    names
}
