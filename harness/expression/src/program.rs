//! Compiled expressions and the state that history functions need.

mod check;
mod compatible;
mod eval;
mod explain;
mod fold;
mod functions;
mod operand;

pub use explain::{ExplainedPart, Operand};

use crate::{Allow, ExprError, FormattedValue, NameId, NameScope, NameValues, Type, Value};
use check::ExpressionCompiler;
use eval::{Evaluator, Expr, Tolerance};
use explain::Note;
use serde::{Deserialize, Serialize};
use station::Time;

/// An expression that was parsed, type-checked and constant-folded.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Program {
    pub(super) text: Box<str>,
    root: Expr,
    pub(super) ty: Type,
    pub(super) slots: Box<[HistorySlot]>,
    pub(super) names: Box<[NameId]>,
    notes: Box<[Note]>,
}

/// A call of a history function with its argument; an outer call comes before the calls inside it.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct HistorySlot {
    pub(super) function: History,
    argument: Expr,
    /// The names of the argument; `prev` moves on when one of them is fresh.
    pub(super) names: Box<[NameId]>,
    /// Whether the argument depends on a position, so that changes within the bench's noise do not count.
    pub(super) noisy: bool,
}

/// The history functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(super) enum History {
    Rises,
    Falls,
    Changes,
    Prev,
    Since,
}

impl Program {
    /// Compiles a condition of `expect`, `always`, `when`, `then`, `until` or `count`.
    pub fn condition(text: &str, scope: &dyn NameScope, allow: Allow) -> Result<Program, ExprError> {
        ExpressionCompiler::condition(text, scope, allow)
    }

    /// Compiles a value without a tolerance, as `set`, `write`, `save` and `device.yaml` use it.
    ///
    /// The text is passed without the leading `=`. If the value is assigned to a name, `expected` is the type of the name: words
    /// and literals are parsed in this type, and a value of another type is an error.
    pub fn value(
        text: &str,
        expected: Option<&Type>,
        scope: &dyn NameScope,
        allow: Allow,
    ) -> Result<Program, ExprError> {
        ExpressionCompiler::value(text, expected, scope, allow)
    }

    /// A program with a constant value; the caller has checked its type.
    pub fn of(value: Value, ty: Type) -> Program {
        Program {
            text: FormattedValue(&value, &ty).to_string().into(),
            root: Expr::Const(value),
            ty,
            slots: Box::new([]),
            names: Box::new([]),
            notes: Box::new([]),
        }
    }

    /// Evaluates the program at the observation `env`; `state` holds what earlier observations left.
    ///
    /// Does not change the state; the caller advances it after the last evaluation of an observation.
    pub fn eval(&self, env: &dyn NameValues, state: &HistoryState) -> Value {
        self.machine(env, state).value(&self.root).into_owned()
    }

    /// Whether the condition is true at the observation `env`; `None` if unknown.
    pub fn truth(&self, env: &dyn NameValues, state: &HistoryState) -> Option<bool> {
        self.machine(env, state).truth(&self.root)
    }

    /// The type of the result; a condition is a [`Type::Bit`].
    pub fn ty(&self) -> &Type {
        &self.ty
    }

    /// The source text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The names that the result depends on, each once, in ascending order.
    pub fn names(&self) -> impl Iterator<Item = NameId> + '_ {
        self.names.iter().copied()
    }

    /// Whether the program uses history functions, so that its [`HistoryState`] must be advanced at every observation.
    pub fn has_history(&self) -> bool {
        !self.slots.is_empty()
    }

    /// Whether the result depends on the time of the observation (`since`), even if no name changes its value.
    pub fn depends_on_time(&self) -> bool {
        self.slots.iter().any(|slot| slot.function == History::Since)
    }

    /// The result, if it is the same at every observation.
    pub fn constant(&self) -> Option<&Value> {
        match &self.root {
            Expr::Const(value) => Some(value),
            _ => None,
        }
    }

    /// Whether the result is the same at every observation.
    pub fn is_constant(&self) -> bool {
        self.constant().is_some()
    }

    fn machine<'a>(&'a self, env: &'a dyn NameValues, state: &'a HistoryState) -> Evaluator<'a> {
        Evaluator { env, cells: &state.cells, slots: &self.slots }
    }
}

/// The expected value of a check, with or without a tolerance.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct ExpectedValue {
    pub(super) center: Program,
    pub(super) tolerance: Option<Tolerance>,
}

impl ExpectedValue {
    /// Compiles `sum [ +/- sum [%] ]`, the text after `=`, for a name of type `expected`.
    pub fn compile(
        text: &str,
        expected: &Type,
        scope: &dyn NameScope,
        allow: Allow,
    ) -> Result<ExpectedValue, ExprError> {
        ExpressionCompiler::target(text, expected, scope, allow)
    }

    /// A constant target without tolerance, for instance a literal.
    pub fn of(value: Value, ty: Type) -> ExpectedValue {
        ExpectedValue { center: Program::of(value, ty), tolerance: None }
    }

    /// The value in the middle of the tolerance; both share one [`HistoryState`].
    pub fn center(&self) -> &Program {
        &self.center
    }

    /// How far a value may differ from the center at the observation `env`: a number, steps, or a duration.
    ///
    /// `None` without a tolerance; a percentage is converted to the unit of the center.
    pub fn tolerance(&self, env: &dyn NameValues, state: &HistoryState) -> Option<Value> {
        let machine = self.center.machine(env, state);
        let center = machine.value(&self.center.root);
        self.tolerance.as_ref().map(|tolerance| machine.tolerance(tolerance, &center))
    }

    /// Whether `observed` is the expected value, by the rules of `==`; `None` if either is unknown.
    pub fn holds(&self, observed: &Value, env: &dyn NameValues, state: &HistoryState) -> Option<bool> {
        let machine = self.center.machine(env, state);
        let noisy = self.center.ty.is_noisy() || matches!(observed, Value::Place(_));
        machine.equal(observed, &machine.value(&self.center.root), self.tolerance.as_ref(), noisy)
    }
}

/// What a program remembers of earlier observations. Each instance of a rule has its own; a new state is empty.
///
/// At every observation, first evaluate as often as needed, then advance once.
#[derive(Clone, Debug, Default)]
pub struct HistoryState {
    pub(super) cells: Vec<HistoryCell>,
}

/// The memory of one [`HistorySlot`].
#[derive(Clone, Debug, PartialEq)]
pub(super) enum HistoryCell {
    /// `rises`, `falls`: the truth at the previous observation.
    Truth(Option<bool>),
    /// `changes`, `prev`: the value in the current and in the previous image.
    Image { present: Value, before: Value },
    /// `since`: when the argument was last true; `None` if uncertain.
    Last(Option<Time>),
    /// `since`: the argument was false at each observation from here on.
    NotSince(Time),
}

impl HistoryState {
    /// Moves on from the observation `env` to the next one; returns whether the memory has changed.
    pub fn advance(&mut self, program: &Program, env: &dyn NameValues) -> bool {
        let mut changed = self.cells.len() != program.slots.len();
        if self.cells.len() != program.slots.len() {
            self.cells = program.slots.iter().map(|slot| slot.function.initial_cell()).collect();
        }
        // Outer slots are advanced first: their arguments still need the previous memory of the inner slots.
        for (index, slot) in program.slots.iter().enumerate() {
            let machine = Evaluator { env, cells: &self.cells, slots: &program.slots };
            let cell = machine.remember(index, slot);
            if let (Some(cell), Some(place)) = (cell, self.cells.get_mut(index)) {
                changed |= *place != cell;
                *place = cell;
            }
        }
        changed
    }

    /// Clears the memory, at the start of a connection or after a gap in the trace.
    pub fn forget(&mut self) {
        self.cells.clear();
    }
}

impl History {
    fn initial_cell(self) -> HistoryCell {
        match self {
            History::Rises | History::Falls => HistoryCell::Truth(None),
            History::Changes | History::Prev => HistoryCell::Image { present: Value::Unknown, before: Value::Unknown },
            History::Since => HistoryCell::Last(None),
        }
    }
}
