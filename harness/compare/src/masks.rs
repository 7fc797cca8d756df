//! The masks of a comparison as data: names that differ on each device and are not compared, and tolerances.
//!
//! Each manual may have a file `masks.yaml`; the command line can name another one. This module must not know what is compared.

use station::Time;
use std::collections::BTreeMap;
use std::time::Duration;
use suite_yaml::MaskList;

/// By how many cycles a value may be earlier or later if nothing else is given.
const TOLERANCE: u64 = 5;

/// The names that are not compared, and the tolerances.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Masks {
    /// Names that are not compared, including their parts, each with the reason.
    pub names: BTreeMap<String, String>,
    /// By how many cycles a value may be earlier or later.
    pub cycles: u64,
    /// By how many steps a measured number may differ.
    pub noise: u32,
    /// Names that are updated only periodically, each with its period.
    pub periods: BTreeMap<String, Duration>,
    /// When the shaft turned, by the time of the capture: a position may differ by one step there.
    pub turned: Vec<(Time, Time)>,
    /// The number of positions after which the position value wraps, if known.
    pub circle: Option<i128>,
}

impl Default for Masks {
    fn default() -> Masks {
        Masks {
            names: BTreeMap::new(),
            cycles: TOLERANCE,
            noise: 0,
            periods: BTreeMap::new(),
            turned: Vec::new(),
            circle: None,
        }
    }
}

impl From<MaskList> for Masks {
    fn from(list: MaskList) -> Masks {
        Masks {
            names: list.names.into_iter().collect(),
            cycles: list.tolerance.unwrap_or(TOLERANCE),
            noise: list.noise.unwrap_or_default(),
            periods: list.periods.into_iter().collect(),
            turned: Vec::new(),
            circle: None,
        }
    }
}

impl Masks {
    /// Whether a name is not compared: it is masked, or part of a masked name.
    pub fn hides(&self, name: &str) -> bool {
        let is_part = |mask: &String| {
            name.strip_prefix(mask.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        self.names.keys().any(is_part)
    }

    /// By how many steps a measured number may differ at an instant of the capture, or a little before or after.
    pub fn noise(&self, at: Time, tolerance: Duration) -> i128 {
        i128::from(self.noise.max(u32::from(self.turns(at, tolerance))))
    }

    /// Whether the shaft turned at an instant of the capture, or a little before or after.
    pub fn turns(&self, at: Time, tolerance: Duration) -> bool {
        self.turned.iter().any(|(from, to)| *from <= at + tolerance && at <= *to + tolerance)
    }

    /// By how much a name may be earlier or later because it is updated only periodically; this matters only while the shaft turns.
    pub fn period(&self, name: &str) -> Duration {
        self.periods.get(name).filter(|_| !self.turned.is_empty()).copied().unwrap_or_default()
    }

    /// By how much a value may be earlier or later.
    pub fn tolerance(&self, cycle: Duration) -> Duration {
        cycle * u32::try_from(self.cycles).unwrap_or(u32::MAX)
    }
}
