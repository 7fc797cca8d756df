//! Times and tolerances: those that a manual prints, and those that are ours because it prints none.

use expression::Value;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// The times of ours that every manual has: name, value in milliseconds, and what it is for.
pub const STANDARD_TIMES: [(&str, u64, &str); 14] = [
    ("reaction", 100, "From an output or a request to what it changes; the deadline of an `expect` without `within`."),
    ("refresh", 100, "How old the inputs may be."),
    ("settle", 250, "Until a speed or another filtered value is shown."),
    ("alarm", 500, "From a fault, or its end, to the alarm."),
    ("diagnosis", 500, "From a fault, or its end, to the diagnosis, the error code or the status that shows it."),
    ("led", 1000, "Until an LED shows a new state, and how long it is then observed."),
    ("save", 5000, "Saving, restoring and resetting."),
    ("start", 10_000, "From Connect to the first good sample."),
    ("power_up", 10_000, "From power to an answer."),
    ("neighbours", 15_000, "From a start to the next LLDP frame."),
    (
        "hold",
        150,
        "How long something is observed that must not change; one and a half times `reaction` at least, since what is wrong may come as late.",
    ),
    ("long_hold", 500, "How long something is observed that would go wrong after a while."),
    ("pause", 200, "Between two actions."),
    ("long_pause", 2000, "For whatever the device does by itself after an action."),
];
/// The factor of the limits up to which something late is only noted.
pub const PATIENCE: u32 = 10;

/// Times and tolerances of a manual.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct DeviceTiming {
    /// The times of ours: first those of [`STANDARD_TIMES`] in that order.
    pub ours: Vec<OurSpan>,
    /// What comes later than a time of ours, but within so many times of it, is noted and does not fail.
    pub patience: u32,
    /// The tolerances of ours.
    pub tolerances: Vec<OurSpan>,
    /// What the manual prints.
    pub printed: Vec<PrintedSpan>,
    /// Default cycle of connections, set by the bench.
    pub cycle: Duration,
    /// Default watchdog of connections, set by the bench; `None`: ten cycles.
    pub watchdog: Option<Duration>,
}

/// A time or tolerance that no manual prints.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct OurSpan {
    pub name: String,
    /// A time, a number of cycles, or a number.
    pub value: Value,
    /// Why it is so, where `device.yaml` says it.
    pub why: Option<String>,
}

/// A time or tolerance that the manual prints.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct PrintedSpan {
    pub name: String,
    /// A time, a number of cycles, or a number, for each variant.
    pub values: Vec<Value>,
    /// The clause.
    pub cites: String,
}

impl DeviceTiming {
    /// The time of ours with this name; zero if there is none.
    fn time(&self, name: &str) -> Duration {
        let nanos = match self.ours.iter().find(|known| known.name == name).map(|known| &known.value) {
            Some(Value::Time(nanos)) => nanos.as_whole().and_then(|nanos| u64::try_from(nanos).ok()),
            _ => None,
        };
        nanos.map_or(Duration::ZERO, Duration::from_nanos)
    }

    /// The default deadline of expectations.
    pub fn reaction(&self) -> Duration {
        self.time("reaction")
    }

    /// Makes `hold` one and a half times as long as a reaction, at least: a wrong reaction may come as late as a right one, and what is
    /// observed for a shorter time would miss it.
    pub fn hold_beyond_reactions(&mut self) {
        let least = self.reaction() * 3 / 2;
        if self.time("hold") < least
            && let Some(hold) = self.ours.iter_mut().find(|known| known.name == "hold")
            && matches!(hold.value, Value::Time(_))
        {
            hold.value = Value::nanos(i128::try_from(least.as_nanos()).unwrap_or(i128::MAX));
        }
    }

    /// From Connect to the first good sample, at most.
    pub fn start(&self) -> Duration {
        self.time("start")
    }

    /// From power to the first answer, at most.
    pub fn power_up(&self) -> Duration {
        self.time("power_up")
    }
}
