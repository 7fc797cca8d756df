//! Conditions: what a value is compared with, what has to be true at once, and rules over what follows.
//!
//! It must not know steps; to judge it is the business of another room.

use super::request::Code;
use super::{Hold, Span};
use crate::device::NameId;
use crate::location::Location;
use expression::{BytePattern, Program, Target, Value};
use serde::{Deserialize, Serialize};

/// What a value is compared with.
#[derive(Debug, Deserialize, Serialize)]
pub enum Matcher {
    /// Equal to a computed value, with a tolerance where one is given.
    Equal(Target),
    /// A word of the name.
    Word(String),
    /// A set of words: order free, number of entries exact.
    Set(Vec<String>),
    /// Octets, with `..` for any octet and `*` for any rest.
    Bytes(BytePattern),
    /// A web page that has all of these texts, the case of letters apart.
    Contains(Vec<String>),
    /// A web page that has none of these texts.
    Lacks(Vec<String>),
    /// Anything that is there.
    Any,
    /// One of these.
    In(Vec<Matcher>),
    /// Both ends inclusive, one may be missing.
    Range {
        /// The lower end.
        from: Option<Program>,
        /// The upper end.
        to: Option<Program>,
    },
    /// Anything else than this.
    Not(Box<Matcher>),
    /// The answer refuses with one of these codes; empty: with any.
    Refused(Vec<Code>),
    /// The answer accepts.
    Accepted,
}

/// A condition: all parts have to be true.
#[derive(Debug, Deserialize, Serialize)]
pub struct Condition {
    /// The parts, in the order written.
    pub parts: Vec<Part>,
}

/// One part of a condition.
#[derive(Debug, Deserialize, Serialize)]
pub struct Part {
    /// As written.
    pub text: String,
    /// What is tested.
    pub test: Test,
}

/// What a part of a condition tests.
#[derive(Debug, Deserialize, Serialize)]
pub enum Test {
    /// An expression that is a condition.
    Expression(Program),
    /// A name against a matcher.
    Name(NameId, Matcher),
}

/// A rule of a file: judged on every connection of every trial, live run and capture.
#[derive(Debug, Deserialize, Serialize)]
pub struct Rule {
    /// `<suite>/<id>`; with the manual in front it is the name of the test.
    pub id: String,
    /// Its sentence.
    pub why: String,
    /// Indices of the requirements.
    pub covers: Vec<usize>,
    /// Bugs that it catches, by name.
    pub catches: Vec<String>,
    /// What it says.
    pub body: RuleBody,
    /// The modules (indices into `device.modules`) that have all of its signals.
    pub modules: Vec<usize>,
    /// Where it stands.
    pub at: Location,
}

/// What a rule says.
#[derive(Debug, Deserialize, Serialize)]
#[allow(clippy::large_enum_variant, reason = "there are few of them, and they live as long as the suite")]
pub enum RuleBody {
    /// True at every sample at which it is known.
    Always(Condition),
    /// Each time the premise is true, the consequence follows.
    When {
        /// The premise, looked at on every frame and event.
        premise: Program,
        /// What follows.
        then: Condition,
        /// Not later than this after the premise.
        within: Span,
        /// How long it then has to stay true.
        hold: Hold,
    },
}

/// A rule over a block.
#[derive(Debug, Deserialize, Serialize)]
pub enum Observation {
    /// A rule without id.
    Rule {
        /// As written.
        text: String,
        /// Where it stands.
        at: Location,
        /// What it says.
        body: RuleBody,
    },
    /// The number of frames or events at which a condition is true.
    Count {
        /// As written.
        text: String,
        /// Where it stands.
        at: Location,
        /// What is counted.
        condition: Program,
        /// The number that is right.
        is: Matcher,
    },
    /// The values that names take one after the other, equal neighbours taken as one.
    Sequence {
        /// As written.
        text: String,
        /// Where it stands.
        at: Location,
        /// The names.
        names: Vec<Program>,
        /// The values that are right, one entry after the other.
        is: Vec<SequenceEntry>,
    },
}

/// One entry of a sequence.
#[derive(Debug, Deserialize, Serialize)]
pub enum SequenceEntry {
    /// The values of all names.
    Values(Vec<Value>),
    /// One of several runs of values.
    Either(Vec<Vec<Vec<Value>>>),
}

impl Condition {
    /// Visits the programs of the condition in the order in which it is walked.
    pub fn each_program<'a>(&'a self, visit: &mut dyn FnMut(&'a Program)) {
        for part in &self.parts {
            match &part.test {
                Test::Expression(program) => visit(program),
                Test::Name(_, matcher) => matcher.each_program(visit),
            }
        }
    }

    /// Visits the names whose values the condition depends on.
    pub fn each_name(&self, visit: &mut dyn FnMut(NameId)) {
        for part in &self.parts {
            if let Test::Name(name, _) = part.test {
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
