//! The interface to the names of the caller: [`NameScope`] at compile time, [`NameValues`] at run time.

use super::{Type, Value};
use serde::{Deserialize, Serialize};
use station::Time;

/// A name that has a value at run time; the number is chosen by the caller and passed to its [`NameValues`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize)]
pub struct NameId(pub u32);

/// What a name resolves to at compile time.
#[derive(Clone, Debug)]
pub enum ResolvedName {
    /// A value known at compile time (a constant, a column of a number or a text), folded into the program.
    Constant(Value, Type),
    /// A word without a table, such as a column that holds `rpm`; it is looked up in the table of the other operand.
    Word(String),
    /// A name whose value comes from the [`NameValues`].
    Name(NameId, Type),
    /// A name that exists but is not allowed in this expression.
    Refused {
        /// The error in one sentence.
        message: String,
        /// How to fix it.
        help: Option<String>,
    },
}

/// The names that an expression may use.
pub trait NameScope {
    /// Resolves `path` (`G1_ZSW.parked`, `before`, `timing.save`); `None` if there is no such name.
    fn lookup(&self, path: &str) -> Option<ResolvedName>;

    /// Calls `visit` with every existing name; used only to suggest a name for a misspelt one.
    fn known(&self, visit: &mut dyn FnMut(&str));
}

/// The values of names at one observation, which is one frame or one event of a trace.
pub trait NameValues {
    /// The value of `name`, or [`Value::Unknown`] while it has none (not received yet, connection ended, bad status, gap).
    ///
    /// For an output this is the value last sent, for an input the value last received.
    fn value(&self, name: NameId) -> Value;

    /// Whether `name` is true; `None` if it is unknown or not a bit.
    fn truth(&self, name: NameId) -> Option<bool> {
        self.value(name).truth()
    }

    /// The value of `name` as a whole number or position; `Some(None)` while it has no value, `None` if it is of another type or
    /// not computed yet.
    ///
    /// This is a fast path for comparisons without noise and tolerance; it always agrees with [`value`](Self::value).
    fn whole(&self, _name: NameId) -> Option<Option<i128>> {
        None
    }

    /// Whether this observation carries `name`: an input in a received image, an output in a sent image.
    ///
    /// `prev` moves on only at such observations.
    fn fresh(&self, name: NameId) -> bool;

    /// The time of this observation, up to which `since` measures.
    fn now(&self) -> Time;

    /// By how many steps two readings of a position at rest may differ; 0 except on a live bench.
    fn position_noise(&self) -> u32 {
        0
    }
}

/// Which parts of the language an expression may use in addition to names, numbers and comparisons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Allow {
    /// `if c then a else b`.
    pub choice: bool,
    /// `rises`, `falls`, `changes`, `prev`, `since`; they need a [`super::HistoryState`] that is advanced at each observation.
    pub history: bool,
}

impl Allow {
    /// Expressions of a `device.yaml`: a choice, but no history.
    pub const DEVICE: Allow = Allow { choice: true, history: false };
    /// Values of steps (`set`, `write`, `save`): neither.
    pub const VALUE: Allow = Allow { choice: false, history: false };
    /// Conditions and right sides that are evaluated over a trace: history, but no choice.
    pub const TRACE: Allow = Allow { choice: false, history: true };
}
