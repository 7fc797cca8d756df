//! The suites for any device of a kind that a manual uses too.

use super::{Manual, Trial};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A suite for any device of a kind, whose topics a manual uses beside its own: `also` in its `device.yaml`.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct GenericSuite {
    /// Its name, which is that of its folder.
    pub name: String,
    /// The topics that the manual takes.
    pub topics: Vec<String>,
    /// The places of its requirements among those of the manual.
    pub requirements: Range<usize>,
    /// What the manual leaves out.
    pub except: Vec<LeftOutPart>,
}

/// A part of a suite that a manual leaves out.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct LeftOutPart {
    /// A topic, a case as `topic/case`, or a row as `topic/case[row]`.
    pub what: String,
    /// The reason.
    pub why: String,
    /// The clause of the manual that says otherwise, if one does.
    pub cites: Option<String>,
}

impl Manual {
    /// The suite that a requirement comes from, by its index, if it is none of the manual's own.
    pub fn suite_of_requirement(&self, requirement: usize) -> Option<&GenericSuite> {
        self.also.iter().find(|suite| suite.requirements.contains(&requirement))
    }

    /// The suite that a case or rule comes from, by its id, if it is none of the manual's own.
    ///
    /// That such a case can fail is proven with the reference device of its own suite; no bug of this manual is listed for it.
    pub fn suite_of(&self, id: &str) -> Option<&GenericSuite> {
        let topic = id.split_once('/').map_or(id, |(topic, _)| topic);
        self.also.iter().find(|suite| suite.topics.iter().any(|known| known == topic))
    }

    /// The number of the manual's own requirements, which come first.
    pub fn own_requirements(&self) -> usize {
        self.also.first().map_or(self.requirements.len(), |suite| suite.requirements.start)
    }

    /// Whether a trial is one of the manual's own.
    pub fn is_own(&self, trial: &Trial) -> bool {
        self.suite_of(&trial.id).is_none()
    }
}
