//! Which types can be compared with each other, and which value can go into which name.

use super::check::Typed;
use super::eval::Expr;
use crate::literal::outside;
use crate::{ExprError, NameId, Type};

/// Whether `left` can be compared with `right`, in order or only for equality.
pub(super) fn comparable(left: &Typed, right: &Typed, ordered: bool) -> Result<(), ExprError> {
    let span = left.span.start..right.span.end.max(left.span.end);
    let wrong = |message: String, help: String| Err(ExprError::new(span.clone(), message).help(help));
    match (&left.ty, &right.ty) {
        (Type::Number(a), Type::Number(b)) => {
            for (one, whole, other, kind) in [(left, a, right, b), (right, b, left, a)] {
                if whole.whole && one.constant().is_none() && !kind.whole {
                    return Err(ExprError::new(
                        other.span.clone(),
                        "this may have a fraction, and it meets a whole number",
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
                    "a place is a whole number, and this may have a fraction".into(),
                    "use `floor` or `round` on it".into(),
                );
            }
            match number {
                Some(number) if number.is_negative() && !ordered => wrong(
                    format!("{number} is no place"),
                    "a place is a whole number from 0 up to the range less 1".into(),
                ),
                _ => Ok(()),
            }
        }
        (Type::Place(a), Type::Place(b)) if a != b => wrong(
            "these are places on different circles".into(),
            "shift or multiply one of them first, so that it is a number".into(),
        ),
        (Type::Place(_), Type::Place(_)) | (Type::Time, Type::Time) | (Type::Cycles, Type::Cycles) => Ok(()),
        (Type::Time, Type::Cycles) | (Type::Cycles, Type::Time) => {
            wrong("cycles are counted, they are no time".into(), "multiply a number with the duration `cycle`".into())
        }
        (Type::Bit, Type::Number(_)) | (Type::Number(_), Type::Bit) if !ordered => Ok(()),
        (a, b) if a == b && !ordered => Ok(()),
        (a, b) if a == b => {
            wrong(format!("{a} comes neither before nor after another"), "compare it with `==` or `!=`".into())
        }
        (Type::Word(table), Type::Number(_)) | (Type::Number(_), Type::Word(table)) => wrong(
            format!("a word of `{}` is not compared with a number", table.name),
            format!("write one of {}", table.listed()),
        ),
        (a, b) => wrong(format!("this compares {a} with {b}"), "compare values of one type".into()),
    }
}

/// Whether `value` can go into a name of the type `wanted`, or be the right value of one.
pub(super) fn fits(wanted: &Type, value: &Typed) -> Result<(), ExprError> {
    // The name stands in as something that is not known before it is seen.
    let name = Typed { expr: Expr::Name(NameId(0)), ty: wanted.clone(), span: value.span.clone() };
    if matches!((wanted, &value.ty), (Type::Number(_), Type::Bit)) {
        return Err(ExprError::new(value.span.clone(), format!("this is {}, and {wanted} is wanted", value.ty))
            .help("write the number"));
    }
    comparable(&name, value, false)
}
