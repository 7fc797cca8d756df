//! Evaluates compiled expressions over the values of one observation. Evaluation cannot fail; unknown operands give unknown
//! results.

use super::{History, HistoryCell, HistorySlot};
use crate::arithmetic::{ArithmeticFunction, binary_value, function_value};
use crate::ast::Binary;
use crate::compare::{OrderOperator, equal, order};
use crate::{NameId, NameValues, Number, Value};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A compiled, type-checked expression.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) enum Expr {
    Const(Value),
    Name(NameId),
    /// Index of a [`HistorySlot`].
    History(usize),
    Not(Box<Expr>),
    And(Box<[Expr]>),
    Or(Box<[Expr]>),
    Equal(Box<Equality>),
    Order(Box<Ordered>),
    In(Box<Among>),
    Binary(Binary, Box<[Expr; 2]>),
    Call(ArithmeticFunction, Box<[Expr]>),
    /// Condition, then, else.
    If(Box<[Expr; 3]>),
}

/// `left == right +/- tolerance`, or `!=`.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Equality {
    pub(super) left: Expr,
    pub(super) right: Expr,
    pub(super) tolerance: Option<Tolerance>,
    pub(super) noisy: bool,
    pub(super) negated: bool,
}

/// `left < right`, `<=`, `>` or `>=`.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Ordered {
    pub(super) sign: OrderOperator,
    pub(super) left: Expr,
    pub(super) right: Expr,
    pub(super) noisy: bool,
}

/// `value in [list]`.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Among {
    pub(super) value: Expr,
    pub(super) list: Box<[Expr]>,
    pub(super) noisy: bool,
}

/// The tolerance after `+/-`.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct Tolerance {
    pub(super) amount: Expr,
    pub(super) percent: bool,
}

/// One observation and the memory of earlier ones.
#[derive(Clone, Copy)]
pub(super) struct Evaluator<'a> {
    pub(super) env: &'a dyn NameValues,
    pub(super) cells: &'a [HistoryCell],
    pub(super) slots: &'a [HistorySlot],
}

impl<'a> Evaluator<'a> {
    pub(super) fn value(&self, expr: &'a Expr) -> Cow<'a, Value> {
        Cow::Owned(match expr {
            Expr::Const(value) => return Cow::Borrowed(value),
            Expr::Name(name) => self.env.value(*name),
            Expr::History(index) => return self.history(*index),
            Expr::Binary(sign, sides) => {
                let [left, right] = sides.as_ref();
                binary_value(*sign, &self.value(left), &self.value(right))
            }
            Expr::Call(function, arguments) => {
                function_value(*function, &mut arguments.iter().map(|argument| self.value(argument).into_owned()))
            }
            Expr::If(parts) => {
                let [condition, then, other] = parts.as_ref();
                return match self.truth(condition) {
                    Some(true) => self.value(then),
                    Some(false) => self.value(other),
                    None => Cow::Owned(Value::Unknown),
                };
            }
            Expr::Not(_) | Expr::And(_) | Expr::Or(_) | Expr::Equal(_) | Expr::Order(_) | Expr::In(_) => {
                Value::from_truth(self.truth(expr))
            }
        })
    }

    pub(super) fn truth(&self, expr: &'a Expr) -> Option<bool> {
        match expr {
            Expr::Not(inner) => self.truth(inner).map(|truth| !truth),
            Expr::And(parts) => all(parts.iter().map(|part| self.truth(part))),
            Expr::Or(parts) => any(parts.iter().map(|part| self.truth(part))),
            Expr::Equal(compare) => {
                if let (None, Some(wholes)) =
                    (&compare.tolerance, self.wholes(&compare.left, &compare.right, compare.noisy))
                {
                    return wholes.map(|(left, right)| (left == right) != compare.negated);
                }
                let (left, right) = (self.value(&compare.left), self.value(&compare.right));
                let equal = self.equal(&left, &right, compare.tolerance.as_ref(), compare.noisy)?;
                Some(equal != compare.negated)
            }
            Expr::Order(compare) => {
                if let Some(wholes) = self.wholes(&compare.left, &compare.right, compare.noisy) {
                    return wholes.map(|(left, right)| compare.sign.holds(left.cmp(&right)));
                }
                let (left, right) = (self.value(&compare.left), self.value(&compare.right));
                order(compare.sign, &left, &right, self.noise(compare.noisy)).or_else(|| self.longer(compare))
            }
            Expr::In(among) => {
                let value = self.value(&among.value);
                any(among.list.iter().map(|entry| self.equal(&value, &self.value(entry), None, among.noisy)))
            }
            Expr::Name(name) => self.env.truth(*name),
            Expr::Const(_) | Expr::History(_) | Expr::Binary(..) | Expr::Call(..) | Expr::If(_) => {
                self.value(expr).truth()
            }
        }
    }

    pub(super) fn equal(
        &self,
        left: &Value,
        right: &Value,
        tolerance: Option<&'a Tolerance>,
        noisy: bool,
    ) -> Option<bool> {
        let width = match tolerance.map(|tolerance| self.tolerance(tolerance, right)) {
            None => None,
            Some(Value::Number(width) | Value::Time(width) | Value::Cycles(width)) if !width.is_negative() => {
                Some(width)
            }
            // With an unknown or negative tolerance the result is unknown.
            Some(_) => return None,
        };
        equal(left, right, width, self.noise(noisy))
    }

    /// The width of a tolerance around `center`, in the type of `center`.
    pub(super) fn tolerance(&self, tolerance: &'a Tolerance, center: &Value) -> Value {
        let amount = self.value(&tolerance.amount);
        if !tolerance.percent {
            return amount.into_owned();
        }
        let Value::Number(percent) = *amount else { return Value::Unknown };
        let part = |of: &Number| of.abs().times(percent)?.divided_by(Number::whole(100));
        match center {
            Value::Number(number) => part(number).map_or(Value::Unknown, Value::Number),
            Value::Time(nanos) => part(nanos).map_or(Value::Unknown, Value::Time),
            Value::Cycles(cycles) => part(cycles).map_or(Value::Unknown, Value::Cycles),
            _ => Value::Unknown,
        }
    }

    /// The whole numbers or positions on both sides; `Some(None)` if one is unknown, `None` if noise or an evaluation is needed.
    fn wholes(&self, left: &Expr, right: &Expr, noisy: bool) -> Option<Option<(i128, i128)>> {
        let whole = |expr: &Expr| match expr {
            Expr::Const(Value::Number(number)) => number.as_whole().map(Some),
            Expr::Name(name) => self.env.whole(*name),
            _ => None,
        };
        if self.noise(noisy) > 0 {
            return None;
        }
        let (left, right) = (whole(left)?, whole(right)?);
        Some(left.zip(right))
    }

    fn noise(&self, noisy: bool) -> u32 {
        if noisy { self.env.position_noise() } else { 0 }
    }

    fn history(&self, index: usize) -> Cow<'a, Value> {
        let unknown = Cow::Owned(Value::Unknown);
        let (Some(slot), Some(cell)) = (self.slots.get(index), self.cells.get(index)) else {
            // Without an earlier observation only `false` can be decided.
            return match self.slots.get(index) {
                Some(slot) => Cow::Owned(Value::from_truth(self.edge(slot, None))),
                None => unknown,
            };
        };
        match cell {
            HistoryCell::Truth(before) => Cow::Owned(Value::from_truth(self.edge(slot, *before))),
            HistoryCell::Image { present, before } => match slot.function {
                History::Changes => {
                    let now = self.value(&slot.argument);
                    let same = equal(&now, present, None, self.noise(slot.noisy));
                    Cow::Owned(Value::from_truth(same.map(|same| !same)))
                }
                _ if self.value(&slot.argument).is_unknown() => unknown,
                _ if self.is_fresh(slot) => Cow::Borrowed(present),
                _ => Cow::Borrowed(before),
            },
            HistoryCell::Last(Some(last)) => {
                Cow::Owned(Value::nanos(i128::from(crate::number::nanos(self.env.now().since(*last)))))
            }
            HistoryCell::Last(None) | HistoryCell::NotSince(_) => unknown,
        }
    }

    /// Decides `since(c) <= time` where `c` was false at each observation so far: it lasts longer than these.
    fn longer(&self, compare: &'a Ordered) -> Option<bool> {
        let lasts = |side: &'a Expr| match side {
            Expr::History(index) => match self.cells.get(*index)? {
                HistoryCell::NotSince(begin) => Some(i128::from(crate::number::nanos(self.env.now().since(*begin)))),
                _ => None,
            },
            _ => None,
        };
        let at_least = |time: &'a Expr, seen: i128| match &*self.value(time) {
            Value::Time(time) => Some(*time <= Number::whole(seen)),
            _ => None,
        };
        let is_longer = |is_upper: bool, known: bool| known.then_some(!is_upper);
        let is_upper = matches!(compare.sign, OrderOperator::Less | OrderOperator::LessEqual);
        match (lasts(&compare.left), lasts(&compare.right)) {
            (Some(seen), None) => is_longer(is_upper, at_least(&compare.right, seen)?),
            (None, Some(seen)) => is_longer(!is_upper, at_least(&compare.left, seen)?),
            _ => None,
        }
    }

    fn edge(&self, slot: &'a HistorySlot, before: Option<bool>) -> Option<bool> {
        match slot.function {
            History::Rises => all([self.truth(&slot.argument), before.map(|before| !before)].into_iter()),
            History::Falls => all([self.truth(&slot.argument).map(|now| !now), before].into_iter()),
            History::Changes | History::Prev | History::Since => None,
        }
    }

    fn is_fresh(&self, slot: &HistorySlot) -> bool {
        slot.names.iter().any(|name| self.env.fresh(*name))
    }

    /// The memory of slot `index` after this observation; `None` if it does not change.
    pub(super) fn remember(&self, index: usize, slot: &'a HistorySlot) -> Option<HistoryCell> {
        match self.cells.get(index)? {
            HistoryCell::Truth(_) => Some(HistoryCell::Truth(self.truth(&slot.argument))),
            cell @ (HistoryCell::Last(_) | HistoryCell::NotSince(_)) => match self.truth(&slot.argument) {
                Some(true) => Some(HistoryCell::Last(Some(self.env.now()))),
                Some(false) if *cell == HistoryCell::Last(None) => Some(HistoryCell::NotSince(self.env.now())),
                Some(false) => None,
                // It may be true here, so the last time is uncertain.
                None => Some(HistoryCell::Last(None)),
            },
            HistoryCell::Image { present, .. } => {
                let now = self.value(&slot.argument);
                match (now.is_unknown(), present.is_unknown()) {
                    (true, _) => Some(HistoryCell::Image { present: Value::Unknown, before: Value::Unknown }),
                    (false, true) => Some(HistoryCell::Image { present: now.into_owned(), before: Value::Unknown }),
                    (false, false) if self.is_fresh(slot) => {
                        Some(HistoryCell::Image { present: now.into_owned(), before: present.clone() })
                    }
                    (false, false) => None,
                }
            }
        }
    }
}

/// Three-valued `and`: false if one is false, else unknown if one is unknown.
pub(super) fn all(truths: impl Iterator<Item = Option<bool>>) -> Option<bool> {
    let mut result = Some(true);
    for truth in truths {
        match truth {
            Some(false) => return truth,
            Some(true) => {}
            None => result = None,
        }
    }
    result
}

/// Three-valued `or`: true if one is true, else unknown if one is unknown.
pub(super) fn any(truths: impl Iterator<Item = Option<bool>>) -> Option<bool> {
    all(truths.map(|truth| truth.map(|truth| !truth))).map(|none| !none)
}
