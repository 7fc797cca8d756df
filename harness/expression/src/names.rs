//! What the expression language asks its surroundings: what a name is, and what its value is.

use super::{Type, Value};
use serde::{Deserialize, Serialize};
use station::Time;

/// A name that has a value at run time; the number is the caller's own and is handed back to its [`Env`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize)]
pub struct NameId(pub u32);

/// What a name turned out to be when an expression is compiled.
#[derive(Clone, Debug)]
pub enum Found {
    /// A value known at compile time (a constant, a column of a number or a text), folded into the program.
    Constant(Value, Type),
    /// A word without a table of its own, such as a column that holds `rpm`: read in the type of what it is compared with.
    Word(String),
    /// A name whose value comes from the [`Env`].
    Name(NameId, Type),
    /// A name that exists but cannot be used in this expression.
    Refused {
        /// What is wrong, in one sentence.
        message: String,
        /// What to write instead.
        help: Option<String>,
    },
}

/// The names that an expression may use.
pub trait Scope {
    /// What `path` (`G1_ZSW.parked`, `before`, `timing.save`) stands for, or `None` if there is no such name.
    fn lookup(&self, path: &str) -> Option<Found>;

    /// Calls `visit` with every name there is; asked only to suggest the nearest one to a misspelt name.
    fn known(&self, visit: &mut dyn FnMut(&str));
}

/// The values of names at one observation: one frame or one event of a trace.
pub trait Env {
    /// The value of `name`, or [`Value::Unknown`] while it has none (not seen yet, connection ended, bad status, gap).
    ///
    /// An output has the value last sent, an input the value last received.
    fn value(&self, name: NameId) -> Value;

    /// Whether `name` is true; `None` if it is unknown or no bit.
    fn truth(&self, name: NameId) -> Option<bool> {
        self.value(name).truth()
    }

    /// The whole number, or the place on a circle, that `name` is; `Some(None)` while it has no value, `None` where it is something
    /// else, or nobody has worked it out yet.
    ///
    /// It is the short way of comparisons without noise and tolerance, and never another answer than [`value`](Self::value).
    fn whole(&self, _name: NameId) -> Option<Option<i128>> {
        None
    }

    /// Whether this very observation carries `name`: an input in a received image, an output in a sent one.
    ///
    /// `prev` counts by this: between two images the value before the present one stays the same.
    fn fresh(&self, name: NameId) -> bool;

    /// The time of this observation; `since` is measured up to it.
    fn now(&self) -> Time;

    /// By how many steps two looks at a place at rest may differ; 0 except on a live bench.
    fn position_noise(&self) -> u32 {
        0
    }
}

/// What may stand in an expression besides names, numbers and comparisons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Allow {
    /// `if c then a else b`.
    pub choice: bool,
    /// `rises`, `falls`, `changes`, `prev`, `since`, which need a [`super::State`] that is advanced at each observation.
    pub history: bool,
}

impl Allow {
    /// Expressions of a `device.yaml`: a choice, but no history.
    pub const DEVICE: Allow = Allow { choice: true, history: false };
    /// Values of steps (`set`, `write`, `save`): neither.
    pub const VALUE: Allow = Allow { choice: false, history: false };
    /// Conditions and right sides that are looked at over a trace: history, but no choice.
    pub const TRACE: Allow = Allow { choice: false, history: true };
}
