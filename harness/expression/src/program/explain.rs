//! Explains the result of a condition part by part, for the report of a failure.

use super::eval::{Evaluator, Expr};
use crate::{FormattedValue, HistoryState, NameValues, Program, Type, Value};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A part of a condition; the condition is true if all parts are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExplainedPart {
    /// The source text.
    pub text: String,
    /// Whether it is true; `None` if unknown.
    pub truth: Option<bool>,
    /// The values that it was computed from, in the order written, each once.
    pub operands: Vec<Operand>,
}

/// A name, a call of a history function, or a side of a comparison.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Operand {
    /// The source text.
    pub text: String,
    /// The value as a suite writes it, whole numbers also in hexadecimal: `4660 (0x1234)`.
    pub value: String,
}

/// A part and its operands, stored for [`Program::explain`].
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Note {
    pub(super) part: Leaf,
    pub(super) operands: Box<[Leaf]>,
}

/// A piece of the source text with its expression.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Leaf {
    pub(super) span: Range<usize>,
    pub(super) expr: Expr,
    pub(super) ty: Type,
}

impl Program {
    /// The parts that `and` joins at the top level, each with its result at the observation `env`.
    ///
    /// A program that is not a condition is one part without a truth value.
    pub fn explain(&self, env: &dyn NameValues, state: &HistoryState) -> Vec<ExplainedPart> {
        let machine = self.machine(env, state);
        let mut parts = Vec::with_capacity(self.notes.len());
        for Note { part, operands } in &self.notes {
            let operand = |leaf| Operand { text: self.text_of(leaf), value: shown(leaf, machine) };
            let operands = operands.iter().map(operand).collect();
            parts.push(ExplainedPart { text: self.text_of(part), truth: machine.truth(&part.expr), operands });
        }
        parts
    }

    fn text_of(&self, leaf: &Leaf) -> String {
        self.text.get(leaf.span.clone()).unwrap_or_default().trim().to_owned()
    }
}

fn shown<'p>(leaf: &'p Leaf, machine: Evaluator<'p>) -> String {
    let value = machine.value(&leaf.expr);
    let decimal = FormattedValue(&value, &leaf.ty).to_string();
    match (&*value, value.as_whole()) {
        (Value::Number(_) | Value::Place(_), Some(whole)) if whole > 9 => format!("{decimal} (0x{whole:X})"),
        _ => decimal,
    }
}
