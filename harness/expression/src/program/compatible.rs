//! Checks which types can be compared with each other and which value can be assigned to which name.

use super::check::TypedExpr;
use super::eval::Expr;
use crate::literal::outside;
use crate::{ExprError, NameId, NumberType, Type};

/// Checks that `left` can be compared with `right`, for order or for equality.
pub(super) fn comparable(left: &TypedExpr, right: &TypedExpr, ordered: bool) -> Result<(), ExprError> {
    let span = left.span.start..right.span.end.max(left.span.end);
    let wrong = |message: String, help: String| Err(ExprError::new(span.clone(), message).help(help));
    match (&left.ty, &right.ty) {
        (Type::Number(a), Type::Number(b)) => {
            for (one, whole, other, kind) in [(left, a, right, b), (right, b, left, a)] {
                if whole.whole && one.constant().is_none() && !kind.whole {
                    return Err(ExprError::new(
                        other.span.clone(),
                        "this value may have a fraction, and it is compared with a whole number",
                    )
                    .help("use `floor` or `round` on it"));
                }
                if let (false, Some(limits)) = (ordered, other.number().and_then(|value| outside(whole.limits, value)))
                {
                    return Err(
                        ExprError::new(other.span.clone(), limits).help("compare it with a value that it can have")
                    );
                }
            }
            Ok(())
        }
        (Type::Place(_), Type::Number(kind)) | (Type::Number(kind), Type::Place(_)) => {
            let number = left.number().or(right.number());
            if !kind.whole {
                return wrong(
                    "a position is a whole number, and this value may have a fraction".into(),
                    "use `floor` or `round` on it".into(),
                );
            }
            match number {
                Some(number) if number.is_negative() && !ordered => wrong(
                    format!("{number} is not a position"),
                    "a position is a whole number from 0 to the range minus 1".into(),
                ),
                _ => Ok(()),
            }
        }
        (Type::Place(a), Type::Place(b)) if a != b => wrong(
            "these positions lie on different circles".into(),
            "shift or multiply one of them first, so that it is a number".into(),
        ),
        (Type::Place(_), Type::Place(_)) | (Type::Time, Type::Time) | (Type::Cycles, Type::Cycles) => Ok(()),
        (Type::Time, Type::Cycles) | (Type::Cycles, Type::Time) => {
            wrong("a number of cycles is not a duration".into(), "multiply a number by the duration `cycle`".into())
        }
        (Type::Bit, Type::Number(_)) | (Type::Number(_), Type::Bit) if !ordered => Ok(()),
        (a, b) if a == b && !ordered => Ok(()),
        (a, b) if a == b => wrong(format!("{a} has no order"), "compare it with `==` or `!=`".into()),
        (Type::Word(table), Type::Number(_)) | (Type::Number(_), Type::Word(table)) => wrong(
            format!("a word of `{}` cannot be compared with a number", table.name),
            format!("write one of {}", table.listed()),
        ),
        (a, b) => wrong(format!("cannot compare {a} with {b}"), "compare values of the same type".into()),
    }
}

/// Checks that `value` can be assigned to a name of the type `expected`, or be its expected value.
pub(super) fn fits(expected: &Type, value: &TypedExpr) -> Result<(), ExprError> {
    // Stands for the name: a value that is not known at compile time.
    let name = TypedExpr { expr: Expr::Name(NameId(0)), ty: expected.clone(), span: value.span.clone() };
    if matches!((expected, &value.ty), (Type::Number(_), Type::Bit)) {
        return Err(ExprError::new(value.span.clone(), format!("expected {expected}, found {}", value.ty))
            .help("write the number"));
    }
    if let (Type::Number(of), Type::Number(NumberType { whole: true, .. })) = (expected, &value.ty)
        && !of.whole
        && value.constant().is_none()
    {
        // Each whole number is one that may have a fraction.
        return Ok(());
    }
    comparable(&name, value, false)
}
