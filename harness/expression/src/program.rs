//! Compiled expressions and the history that some of them need.

mod check;
mod eval;
mod explain;
mod fits;
mod fold;
mod functions;
mod operand;

pub use explain::{Operand, Part};

use crate::{Allow, Env, ExprError, NameId, Scope, Shown, Type, Value};
use check::Checked;
use eval::{Expr, Machine, Tolerance};
use explain::Note;
use serde::{Deserialize, Serialize};
use station::Time;

/// An expression that was parsed, typed and folded.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Program {
    pub(super) text: Box<str>,
    root: Expr,
    pub(super) ty: Type,
    pub(super) slots: Box<[Slot]>,
    pub(super) names: Box<[NameId]>,
    notes: Box<[Note]>,
}

/// A use of a function that looks back, with its argument; an outer one stands before those inside it.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Slot {
    pub(super) function: History,
    argument: Expr,
    /// The names of the argument: `prev` moves on when one of them is fresh.
    pub(super) names: Box<[NameId]>,
    /// Whether the argument is a place, so that the bench's noise is no change.
    pub(super) noisy: bool,
}

/// The functions that look back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(super) enum History {
    Rises,
    Falls,
    Changes,
    Prev,
    Since,
}

impl Program {
    /// Compiles a condition, as `expect`, `always`, `when`, `then`, `until` and `count` have it.
    pub fn condition(text: &str, scope: &dyn Scope, allow: Allow) -> Result<Program, ExprError> {
        Checked::condition(text, scope, allow)
    }

    /// Compiles a value without a tolerance, as `set`, `write`, `save` and `device.yaml` have it.
    ///
    /// The text comes without the leading `=`. If the value goes into a name, `wanted` is the name's type: words and
    /// literals are read in it, and a value that does not fit is an error.
    pub fn value(text: &str, wanted: Option<&Type>, scope: &dyn Scope, allow: Allow) -> Result<Program, ExprError> {
        Checked::value(text, wanted, scope, allow)
    }

    /// The program that always has this value, which is already known to fit.
    pub fn of(value: Value, ty: Type) -> Program {
        Program {
            text: Shown(&value, &ty).to_string().into(),
            root: Expr::Const(value),
            ty,
            slots: Box::new([]),
            names: Box::new([]),
            notes: Box::new([]),
        }
    }

    /// Its value at the observation `env`, with `state` as the observations before have left it.
    ///
    /// Nothing is changed; after the last look at an observation the state is advanced over it.
    pub fn eval(&self, env: &dyn Env, state: &State) -> Value {
        self.machine(env, state).value(&self.root).into_owned()
    }

    /// Whether it is true at the observation `env`; `None` if unknown.
    pub fn truth(&self, env: &dyn Env, state: &State) -> Option<bool> {
        self.machine(env, state).truth(&self.root)
    }

    /// The type of its value; a condition is a [`Type::Bit`].
    pub fn ty(&self) -> &Type {
        &self.ty
    }

    /// The text that it was compiled from.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The names that its value depends on, each once, in ascending order.
    pub fn names(&self) -> impl Iterator<Item = NameId> + '_ {
        self.names.iter().copied()
    }

    /// Whether it looks back, so that its [`State`] must be advanced at every observation.
    pub fn has_history(&self) -> bool {
        !self.slots.is_empty()
    }

    /// Whether its value may change from one instant to the next although no name has another value.
    pub fn looks_at_the_clock(&self) -> bool {
        self.slots.iter().any(|slot| slot.function == History::Since)
    }

    /// Its value if that is the same at every observation.
    pub fn constant(&self) -> Option<&Value> {
        match &self.root {
            Expr::Const(value) => Some(value),
            _ => None,
        }
    }

    /// Whether its value is the same at every observation.
    pub fn is_constant(&self) -> bool {
        self.constant().is_some()
    }

    fn machine<'a>(&'a self, env: &'a dyn Env, state: &'a State) -> Machine<'a> {
        Machine { env, cells: &state.cells, slots: &self.slots }
    }
}

/// The right side of a check: a value, with or without a tolerance.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Target {
    pub(super) center: Program,
    pub(super) tolerance: Option<Tolerance>,
}

impl Target {
    /// Compiles `sum [ +/- sum [%] ]`, the text after `=`, for a name of the type `wanted`.
    pub fn compile(text: &str, wanted: &Type, scope: &dyn Scope, allow: Allow) -> Result<Target, ExprError> {
        Checked::target(text, wanted, scope, allow)
    }

    /// The target that is always exactly this value, for instance a literal.
    pub fn of(value: Value, ty: Type) -> Target {
        Target { center: Program::of(value, ty), tolerance: None }
    }

    /// The value in the middle of the tolerance; its state serves the tolerance as well.
    pub fn center(&self) -> &Program {
        &self.center
    }

    /// How far from the center a value may lie at the observation `env`: a number, steps, or a duration.
    ///
    /// `None` without a tolerance; a percentage is already worked out.
    pub fn tolerance(&self, env: &dyn Env, state: &State) -> Option<Value> {
        let machine = self.center.machine(env, state);
        let center = machine.value(&self.center.root);
        self.tolerance.as_ref().map(|tolerance| machine.tolerance(tolerance, &center))
    }

    /// Whether `seen` is the value wanted, by the rules of `==`; `None` if either is unknown.
    pub fn holds(&self, seen: &Value, env: &dyn Env, state: &State) -> Option<bool> {
        let machine = self.center.machine(env, state);
        let noisy = self.center.ty.is_noisy() || matches!(seen, Value::Place(_));
        machine.equal(seen, &machine.value(&self.center.root), self.tolerance.as_ref(), noisy)
    }
}

/// What a program remembers of the observations before; each rule instance owns one, and a new one remembers nothing.
///
/// At every observation: first evaluate, as often as needed, then advance once.
#[derive(Clone, Debug, Default)]
pub struct State {
    pub(super) cells: Vec<Cell>,
}

/// What one [`Slot`] remembers.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cell {
    /// `rises`, `falls`: whether it was true at the observation before.
    Truth(Option<bool>),
    /// `changes`, `prev`: the value in the present image and in the one before.
    Image { present: Value, before: Value },
    /// `since`: when it was last true, unless that is uncertain.
    Last(Option<Time>),
}

impl State {
    /// Moves on from the observation `env` to the next one, and says whether something else is remembered now.
    pub fn advance(&mut self, program: &Program, env: &dyn Env) -> bool {
        let mut changed = self.cells.len() != program.slots.len();
        if self.cells.len() != program.slots.len() {
            self.cells = program.slots.iter().map(|slot| slot.function.nothing_seen()).collect();
        }
        // An outer slot is advanced first: its argument still has to see what the inner ones remembered.
        for (index, slot) in program.slots.iter().enumerate() {
            let machine = Machine { env, cells: &self.cells, slots: &program.slots };
            let cell = machine.remember(index, slot);
            if let (Some(cell), Some(place)) = (cell, self.cells.get_mut(index)) {
                changed |= *place != cell;
                *place = cell;
            }
        }
        changed
    }

    /// Forgets everything, as at the begin of a connection or after a gap in the trace.
    pub fn forget(&mut self) {
        self.cells.clear();
    }
}

impl History {
    fn nothing_seen(self) -> Cell {
        match self {
            History::Rises | History::Falls => Cell::Truth(None),
            History::Changes | History::Prev => Cell::Image { present: Value::Unknown, before: Value::Unknown },
            History::Since => Cell::Last(None),
        }
    }
}
