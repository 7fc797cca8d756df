//! Why a step did not go as it should, and who is to blame for it.

use expression::NameId;
use judge::place::Spot;
use results::outcome::{Blame, PartSeen};
use results::verdict::Verdict;
use std::ops::{Deref, DerefMut};
use suite::Location;

/// Why a step did not go as it should; boxed, since nearly every step goes well.
#[derive(Clone, Debug)]
pub struct Trouble(Box<Facts>);

impl Deref for Trouble {
    type Target = Facts;

    fn deref(&self) -> &Facts {
        &self.0
    }
}

impl DerefMut for Trouble {
    fn deref_mut(&mut self) -> &mut Facts {
        &mut self.0
    }
}

/// What is known about a step that did not go as it should.
#[derive(Clone, Debug)]
pub struct Facts {
    /// Who is to blame.
    pub blame: Blame,
    /// What broke, in one sentence.
    pub what: String,
    /// Wanted and seen.
    pub parts: Vec<PartSeen>,
    /// The frame in which it shows.
    pub frame: Option<u64>,
    /// Where each name stood.
    pub places: Vec<(NameId, Option<Spot>)>,
    /// The verdict where the device is not found wanting: the stand cannot do it, nothing can be said.
    pub verdict: Option<Verdict>,
    /// What was judged, where that is a rule inside the step.
    pub step: Option<(String, Location)>,
}

impl Trouble {
    /// The device did something else than was asked for.
    pub fn device(what: impl Into<String>, parts: Vec<PartSeen>) -> Trouble {
        let what = what.into();
        let facts =
            Facts { blame: Blame::Device, what, parts, frame: None, places: Vec::new(), verdict: None, step: None };
        Trouble(Box::new(facts))
    }

    /// Something else than the device broke, and `verdict` says how.
    pub fn other(blame: Blame, verdict: Verdict, what: impl Into<String>) -> Trouble {
        let mut trouble = Trouble::device(what, Vec::new());
        (trouble.blame, trouble.verdict) = (blame, Some(verdict));
        trouble
    }

    /// The same with the frame in which it shows.
    pub fn at(mut self, frame: u64) -> Trouble {
        self.frame = Some(frame);
        self
    }

    /// The same where the device only had to be brought to where the test begins: nothing can be said about it.
    pub fn before_the_test(mut self) -> Trouble {
        self.verdict = Some(self.verdict.unwrap_or(Verdict::Inconclusive));
        self
    }
}

/// How a step went.
pub type Done = Result<(), Trouble>;

/// The trouble with a step that the end of the run or of the line came upon.
pub fn halted(why: &str) -> Trouble {
    Trouble::other(Blame::Environment, Verdict::Inconclusive, format!("The trial could not go on: {why}."))
}

/// The trouble with a step that needs a connection where none stands.
pub fn no_connection() -> Trouble {
    Trouble::device("No connection stands, so nothing can be exchanged or asked for.", Vec::new())
}

/// A suite for one bus asks for something of the other; the loader does not let it through.
pub fn other_bus() -> Trouble {
    Trouble::other(Blame::Suite, Verdict::Error, "This is a service of the other bus.")
}
