//! Conditions, rules and observations as compiled from YAML. The crate `judge` evaluates them.
//!

use super::request::Code;
use super::{Deadline, HoldTime};
use crate::device::NameId;
use crate::location::Location;
use expression::{BytePattern, ExpectedValue, Program, Value};
use serde::{Deserialize, Serialize};

/// The expected value of a name.
#[derive(Debug, Deserialize, Serialize)]
pub enum Matcher {
    /// Equal to a computed value, with a tolerance where one is given.
    Equal(ExpectedValue),
    /// A word of the name's table.
    Word(String),
    /// A set of words: any order, exact number of entries.
    Set(Vec<String>),
    /// Bytes; `..` matches any byte and `*` any number of bytes.
    Bytes(BytePattern),
    /// A web page that contains all of these texts, ignoring case.
    Contains(Vec<String>),
    /// A web page that contains none of these texts, ignoring case.
    Lacks(Vec<String>),
    /// Any known value.
    Any,
    /// One of these.
    In(Vec<Matcher>),
    /// A range, both ends inclusive; one end may be open.
    Range { from: Option<Program>, to: Option<Program> },
    /// Any other value.
    Not(Box<Matcher>),
    /// A negative response with one of these codes; empty: any code.
    Refused(Vec<Code>),
    /// A positive response.
    Accepted,
}

/// A condition; it is true if all parts are true.
#[derive(Debug, Deserialize, Serialize)]
pub struct Condition {
    /// The parts, in the order written.
    pub parts: Vec<ConditionPart>,
}

/// One part of a condition.
#[derive(Debug, Deserialize, Serialize)]
pub struct ConditionPart {
    /// As written.
    pub text: String,
    pub test: PartTest,
}

/// The test of a part of a condition.
#[derive(Debug, Deserialize, Serialize)]
pub enum PartTest {
    /// An expression that is a condition.
    Expression(Program),
    /// A name and its expected value.
    Name(NameId, Matcher),
}

/// A rule of a file: judged on every connection of every trial, live run and capture.
#[derive(Debug, Deserialize, Serialize)]
pub struct SuiteRule {
    /// `<suite>/<id>`; the test name is `<manual>/<suite>/<id>`.
    pub id: String,
    pub why: String,
    /// Indices of the requirements.
    pub covers: Vec<usize>,
    /// Names of the bugs that it catches.
    pub catches: Vec<String>,
    /// The body of the rule.
    pub body: RuleBody,
    /// The modules (indices into `device.modules`) that have all signals of the rule.
    pub modules: Vec<usize>,
    pub at: Location,
}

/// The body of a rule.
#[derive(Debug, Deserialize, Serialize)]
#[allow(clippy::large_enum_variant, reason = "there are few of them, and they live as long as the suite")]
pub enum RuleBody {
    /// The condition is true at every sample at which it is known.
    Always(Condition),
    /// Each time the premise is true, `then` follows.
    When {
        /// The premise, evaluated at every frame and event.
        premise: Program,
        /// The condition that follows.
        then: Condition,
        /// Deadline after the premise.
        within: Deadline,
        /// How long the condition then has to stay true.
        hold: HoldTime,
    },
}

impl RuleBody {
    /// Visits the names whose values the rule depends on.
    pub fn each_name(&self, visit: &mut dyn FnMut(NameId)) {
        match self {
            RuleBody::Always(condition) => condition.each_name(visit),
            RuleBody::When { premise, then, hold, .. } => {
                premise.names().for_each(&mut *visit);
                then.each_name(visit);
                if let HoldTime::Until(end) = hold {
                    end.each_name(visit);
                }
            }
        }
    }
}

/// An observation over a block of steps.
#[derive(Debug, Deserialize, Serialize)]
pub enum BlockObservation {
    /// A rule without id.
    Rule {
        /// As written.
        text: String,
        at: Location,
        /// The body of the rule.
        body: RuleBody,
    },
    /// The number of frames or events at which a condition is true.
    Count {
        /// As written.
        text: String,
        at: Location,
        condition: Program,
        /// The expected number.
        is: Matcher,
    },
    /// The sequence of values of names; repetitions count once.
    Sequence {
        /// As written.
        text: String,
        at: Location,
        names: Vec<Program>,
        /// The expected values.
        is: Vec<SequenceEntry>,
    },
}

/// One entry of a sequence.
#[derive(Debug, Deserialize, Serialize)]
pub enum SequenceEntry {
    /// The values of all names.
    Values(Vec<Value>),
    /// One of several subsequences.
    Either(Vec<Vec<Vec<Value>>>),
}

impl Condition {
    /// Visits the programs of the condition in evaluation order.
    pub fn each_program<'a>(&'a self, visit: &mut dyn FnMut(&'a Program)) {
        for part in &self.parts {
            match &part.test {
                PartTest::Expression(program) => visit(program),
                PartTest::Name(_, matcher) => matcher.each_program(visit),
            }
        }
    }

    /// Visits the names whose values the condition depends on.
    pub fn each_name(&self, visit: &mut dyn FnMut(NameId)) {
        for part in &self.parts {
            if let PartTest::Name(name, _) = part.test {
                visit(name);
            }
        }
        self.each_program(&mut |program| program.names().for_each(&mut *visit));
    }
}

impl Matcher {
    fn each_program<'a>(&'a self, visit: &mut dyn FnMut(&'a Program)) {
        match self {
            Matcher::Equal(target) => visit(target.center()),
            Matcher::In(list) => list.iter().for_each(|matcher| matcher.each_program(visit)),
            Matcher::Range { from, to } => from.iter().chain(to).for_each(visit),
            Matcher::Not(matcher) => matcher.each_program(visit),
            Matcher::Word(_)
            | Matcher::Set(_)
            | Matcher::Bytes(_)
            | Matcher::Contains(_)
            | Matcher::Lacks(_)
            | Matcher::Any
            | Matcher::Refused(_)
            | Matcher::Accepted => {}
        }
    }
}
