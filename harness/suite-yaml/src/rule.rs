//! Rules: those of a file and those that are observed over a block.

use super::error::{Mistake, Read, both, every};
use super::frame::StepScope;
use super::keys::Keyed;
use super::step::StepContext;
use super::topic_keys::{observed, rule};
use super::yaml::Node;
use expression::{NameId, Program, Type, Value};
use suite::device::NameKind;
use suite::model::{BlockObservation, Condition, HoldTime, RuleBody, SequenceEntry};

/// A body and the names in it.
pub(super) struct Body {
    pub body: RuleBody,
    pub names: Vec<NameId>,
}

impl StepContext<'_, '_> {
    /// `always`, or `when` and `then`.
    pub(super) fn body(&self, keyed: Keyed<'_>) -> Read<Body> {
        if let Some(always) = keyed.get(&rule::always) {
            let condition = self.frame.checks(always)?;
            return Ok(Body { names: names_of(&condition), body: RuleBody::Always(condition) });
        }
        let when = keyed.must(&rule::when)?;
        let premise = match self.frame.condition(when) {
            Ok(premise) => premise,
            Err(wrong) => {
                let then = keyed.must(&rule::then).and_then(|then| self.frame.checks(then)).err();
                let within = keyed.must(&rule::within).and_then(|within| self.frame.deadline(within)).err();
                return Err(within.into_iter().chain(then).fold(wrong, Mistake::and));
            }
        };
        if let Some(value) = premise.constant() {
            return Err(when.wrong(format!("the premise is always {}", value.truth().unwrap_or(false))));
        }
        let within = self.frame.deadline(keyed.must(&rule::within)?);
        let then = self.frame.checks(keyed.must(&rule::then)?);
        let ((within, then), hold) = both(both(within, then), self.hold(keyed, &rule::r#for, &rule::until))?;
        let mut names: Vec<NameId> = premise.names().collect();
        names.extend(names_of(&then));
        if let HoldTime::Until(until) = &hold {
            names.extend(names_of(until));
        }
        Ok(Body { names, body: RuleBody::When { premise, then, within, hold } })
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
        every(items.iter().map(|item| self.observation(item)))
    }

    fn observation(&self, node: &Node) -> Read<BlockObservation> {
        let keyed = Keyed::new(node, &observed::KEYS)?;
        let (text, at) = (node.to_string(), self.ground.location(node));
        if let Some(count) = keyed.get(&observed::count) {
            let condition = self.frame.condition(count)?;
            let is = self.frame.matcher(keyed.must(&observed::is)?, &Type::whole(32, false), None)?;
            return Ok(BlockObservation::Count { text, at, condition, is });
        }
        if let Some(sequence) = keyed.get(&observed::sequence) {
            return self.sequence(sequence, keyed.must(&observed::is)?, text, at);
        }
        Ok(BlockObservation::Rule { text, at, body: self.body(keyed)?.body })
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

fn constant(frame: &StepScope<'_, '_>, node: &Node, ty: &Type) -> Read<Value> {
    match node.expression() {
        None => frame.literal(node, ty),
        Some(_) => {
            let program = frame.value(node, ty)?;
            program.constant().cloned().ok_or_else(|| node.wrong("the values of a sequence are known beforehand"))
        }
    }
}

/// The names in a condition.
pub(super) fn names_of(condition: &Condition) -> Vec<NameId> {
    let mut names = Vec::new();
    condition.each_name(&mut |name| names.push(name));
    names
}
