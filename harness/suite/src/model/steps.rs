//! The steps of a trial, decoded on first use.

use super::{ConnectionStart, TrialStep};
use crate::encoding::{EncodingContext, put_steps, reading, shared};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser};
use std::fmt;
use std::sync::{Arc, OnceLock};

/// The steps of a trial, decoded.
#[derive(Debug, Default, Deserialize, Serialize)]
pub struct TrialSteps {
    /// The connection that the trial begins with; `None` for `start: none`.
    pub start: Option<ConnectionStart>,
    /// Steps that bring the device into the state for the test.
    pub given: Vec<TrialStep>,
    /// Steps of the test.
    pub steps: Vec<TrialStep>,
    /// Steps that always run at the end.
    pub finally: Vec<TrialStep>,
    /// Whether it is about bit times, which no serial line keeps.
    pub bit_timing: bool,
    /// The names of `save`, by their number in [`NameKind::Saved`](crate::device::NameKind::Saved).
    pub saved: Vec<String>,
}

/// The steps of a trial, encoded or decoded.
pub struct Steps {
    read: OnceLock<Box<TrialSteps>>,
    /// The encoded steps: start and end in the steps of the manual; `None` if they were never encoded.
    octets: Option<(Arc<EncodingContext>, usize, usize)>,
}

impl Steps {
    /// The steps; decodes them on the first call.
    pub fn get(&self) -> &TrialSteps {
        self.read.get_or_init(|| {
            let Some((shared, from, to)) = &self.octets else { return Box::default() };
            let octets = shared.steps.get(*from..*to).unwrap_or_default();
            // These bytes are part of the program, so an error is a bug. An empty trial would pass.
            Box::new(reading(shared, || postcard::from_bytes(octets)).expect("steps as this build wrote them"))
        })
    }
}

impl From<TrialSteps> for Steps {
    fn from(steps: TrialSteps) -> Steps {
        Steps { read: OnceLock::from(Box::new(steps)), octets: None }
    }
}

impl fmt::Debug for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.get().fmt(f)
    }
}

impl Serialize for Steps {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let octets = postcard::to_stdvec(self.get()).map_err(ser::Error::custom)?;
        put_steps(&octets).ok_or_else(|| ser::Error::custom("steps outside of a manual"))?.serialize(to)
    }
}

impl<'de> Deserialize<'de> for Steps {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Steps, D::Error> {
        let (start, end) = Deserialize::deserialize(from)?;
        let shared = shared().ok_or_else(|| de::Error::custom("steps outside of a manual"))?;
        Ok(Steps { read: OnceLock::new(), octets: Some((shared, start, end)) })
    }
}
