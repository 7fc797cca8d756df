//! Constant folding: constant subexpressions are computed at compile time, so errors in them are found there.

use super::check::TypedExpr;
use super::eval::{Evaluator, Expr};
use crate::types::NumberType;
use crate::{ExprError, NameId, NameValues, Type, Value};
use std::ops::Range;

/// Joins conditions with `and` or `or`. Constants without effect are left out; a constant that decides replaces the whole.
pub(super) fn joined(parts: Vec<Expr>, or: bool) -> Expr {
    if parts.iter().any(|part| matches!(part, Expr::Const(Value::Bit(bit)) if *bit == or)) {
        return Expr::Const(Value::Bit(or));
    }
    let mut parts: Vec<Expr> = parts.into_iter().filter(|part| !matches!(part, Expr::Const(Value::Bit(_)))).collect();
    match (parts.pop(), parts.is_empty()) {
        (None, _) => Expr::Const(Value::Bit(!or)),
        (Some(only), true) => only,
        (Some(last), false) => {
            parts.push(last);
            if or { Expr::Or(parts.into()) } else { Expr::And(parts.into()) }
        }
    }
}

/// Replaces an expression whose operands are all constant by its value.
pub(super) fn folded(expr: Expr, ty: Type, span: Range<usize>) -> Result<TypedExpr, ExprError> {
    let constant = |expr: &Expr| matches!(expr, Expr::Const(value) if !value.is_unknown());
    let foldable = match &expr {
        Expr::Not(inner) => constant(inner),
        Expr::Equal(compare) => {
            let tolerance = compare.tolerance.as_ref().is_none_or(|tolerance| constant(&tolerance.amount));
            constant(&compare.left) && constant(&compare.right) && tolerance
        }
        Expr::Order(compare) => constant(&compare.left) && constant(&compare.right),
        Expr::In(among) => constant(&among.value) && among.list.iter().all(constant),
        Expr::Binary(_, sides) => sides.iter().all(constant),
        Expr::Call(_, arguments) => arguments.iter().all(constant),
        Expr::If(parts) => parts.iter().all(constant),
        Expr::Const(_) | Expr::Name(_) | Expr::History(_) | Expr::And(_) | Expr::Or(_) => false,
    };
    if !foldable {
        return Ok(TypedExpr { expr, ty, span });
    }
    let value = Evaluator { env: &ConstantEnv, cells: &[], slots: &[] }.value(&expr).into_owned();
    let ty = match (&value, ty) {
        (Value::Unknown, _) => {
            return Err(ExprError::new(span, "this cannot be computed")
                .help("a number has at most 38 digits, a text 65536 bytes"));
        }
        (Value::Number(number), Type::Number(kind)) => Type::Number(NumberType { whole: number.is_whole(), ..kind }),
        (_, ty) => ty,
    };
    Ok(TypedExpr { expr: Expr::Const(value), ty, span })
}

/// The environment for constants: no name has a value.
struct ConstantEnv;

impl NameValues for ConstantEnv {
    fn value(&self, _: NameId) -> Value {
        Value::Unknown
    }
    fn fresh(&self, _: NameId) -> bool {
        false
    }
    fn now(&self) -> station::Time {
        station::Time::ZERO
    }
}
