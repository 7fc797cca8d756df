//! From the tree to a program: names are looked up, types proved to fit, constants folded.

use super::Slot;
use super::eval::{Among, Equality, Expr, Ordered, Tolerance};
use super::explain::{Leaf, Note};
use super::fits::{comparable, fits};
use super::fold::{folded, joined};
use crate::arithmetic::binary_type;
use crate::ast::{Ast, Binary, Comparison, Deviation, Node};
use crate::compare::Order;
use crate::parse;
use crate::{Allow, ExprError, NameId, Number, NumberType, Program, Scope, Target, Type, Value};
use std::ops::Range;

/// An expression under construction.
pub(super) struct Checked<'s> {
    pub(super) scope: &'s dyn Scope,
    pub(super) allow: Allow,
    pub(super) slots: Vec<Slot>,
    pub(super) names: Vec<NameId>,
    pub(super) leaves: Vec<Leaf>,
}

/// A piece of an expression with its type.
pub(super) struct Typed {
    pub(super) expr: Expr,
    pub(super) ty: Type,
    pub(super) span: Range<usize>,
}

impl Typed {
    pub(super) fn constant(&self) -> Option<&Value> {
        match &self.expr {
            Expr::Const(value) => Some(value),
            _ => None,
        }
    }

    /// The number of a constant number or duration.
    pub(super) fn number(&self) -> Option<Number> {
        match self.constant() {
            Some(Value::Number(number) | Value::Time(number) | Value::Cycles(number)) => Some(*number),
            _ => None,
        }
    }
}

impl<'s> Checked<'s> {
    fn new(scope: &'s dyn Scope, allow: Allow) -> Checked<'s> {
        Checked { scope, allow, slots: Vec::new(), names: Vec::new(), leaves: Vec::new() }
    }

    pub(super) fn condition(text: &str, scope: &'s dyn Scope, allow: Allow) -> Result<Program, ExprError> {
        let tree = parse::condition(text, allow)?;
        let mut this = Checked::new(scope, allow);
        let parts = match &tree.kind {
            Node::And(parts) => parts.as_slice(),
            _ => std::slice::from_ref(&tree),
        };
        let (mut exprs, mut notes) = (Vec::new(), Vec::new());
        for part in parts {
            let expr = this.truth(part)?;
            let part = Leaf { span: part.span.clone(), expr: expr.clone(), ty: Type::Bit };
            notes.push(this.note(part));
            exprs.push(expr);
        }
        Ok(this.program(text, joined(exprs, false), Type::Bit, notes))
    }

    pub(super) fn value(
        text: &str,
        wanted: Option<&Type>,
        scope: &'s dyn Scope,
        allow: Allow,
    ) -> Result<Program, ExprError> {
        let (tree, deviation) = parse::right_side(text, allow)?;
        if let Some(deviation) = deviation {
            return Err(ExprError::new(deviation.amount.span, "a tolerance has no meaning here")
                .help("give the value alone; tolerances belong into checks"));
        }
        let mut this = Checked::new(scope, allow);
        let typed = this.value_in(&tree, wanted)?;
        if let Some(wanted) = wanted {
            fits(wanted, &typed)?;
        }
        if let Some(Value::Pattern(_)) = typed.constant() {
            return Err(ExprError::new(typed.span, "`..` and `*` stand only in checks").help("write every octet"));
        }
        Ok(this.only_part(text, typed))
    }

    pub(super) fn target(text: &str, wanted: &Type, scope: &'s dyn Scope, allow: Allow) -> Result<Target, ExprError> {
        let (tree, deviation) = parse::right_side(text, allow)?;
        let mut this = Checked::new(scope, allow);
        let center = this.value_in(&tree, Some(wanted))?;
        fits(wanted, &center)?;
        let tolerance = deviation.map(|deviation| this.tolerance(&deviation, wanted, &center.ty)).transpose()?;
        Ok(Target { center: this.only_part(text, center), tolerance })
    }

    /// The part with what was collected for it, in the order written.
    fn note(&mut self, part: Leaf) -> Note {
        let mut operands = std::mem::take(&mut self.leaves);
        operands.sort_by_key(|leaf| (leaf.span.start, leaf.span.end));
        Note { part, operands: operands.into() }
    }

    fn only_part(mut self, text: &str, typed: Typed) -> Program {
        let part = Leaf { span: 0..text.len(), expr: typed.expr.clone(), ty: typed.ty.clone() };
        let note = self.note(part);
        self.program(text, typed.expr, typed.ty, vec![note])
    }

    fn program(mut self, text: &str, root: Expr, ty: Type, notes: Vec<Note>) -> Program {
        self.names.sort_unstable();
        self.names.dedup();
        Program { text: text.into(), root, ty, slots: self.slots.into(), names: self.names.into(), notes: notes.into() }
    }

    /// A condition: a bit or what gives one.
    pub(super) fn truth(&mut self, ast: &Ast<'_>) -> Result<Expr, ExprError> {
        let typed = self.value_in(ast, None)?;
        let help = match &typed.ty {
            Type::Bit => return Ok(typed.expr),
            Type::Number(_) | Type::Place(_) => "compare it, for instance with `!= 0`".to_owned(),
            Type::Word(table) => format!("compare it with `==` and one of {}", table.listed()),
            _ => "compare it with `==`".to_owned(),
        };
        Err(ExprError::new(typed.span, format!("a condition is wanted here, and this is {}", typed.ty)).help(help))
    }

    /// Any node; `wanted` reaches the branches of a choice.
    pub(super) fn node(&mut self, ast: &Ast<'_>, wanted: Option<&Type>) -> Result<Typed, ExprError> {
        let span = ast.span.clone();
        let constant = |value, ty| Ok(Typed { expr: Expr::Const(value), ty, span: span.clone() });
        let (expr, ty) = match &ast.kind {
            Node::Name(_) => return self.value_in(ast, wanted),
            Node::Number(number) => {
                let kind = NumberType { whole: number.is_whole(), ..NumberType::WHOLE };
                return constant(Value::Number(*number), Type::Number(kind));
            }
            Node::Time(nanos) => return constant(Value::Time(*nanos), Type::Time),
            Node::Cycles(cycles) => return constant(Value::Cycles(*cycles), Type::Cycles),
            Node::Text(text) => return constant(Value::text(*text), Type::Text),
            Node::Not(inner) => (Expr::Not(Box::new(self.truth(inner)?)), Type::Bit),
            Node::And(parts) => (joined(self.truths(parts)?, false), Type::Bit),
            Node::Or(parts) => (joined(self.truths(parts)?, true), Type::Bit),
            Node::Compare(sign, left, right, deviation) => {
                (self.compare(*sign, left, right, deviation.as_deref())?, Type::Bit)
            }
            Node::In(value, list) => (self.among(value, list)?, Type::Bit),
            Node::Binary(sign, left, right) => self.binary(*sign, left, right, &span)?,
            Node::Negate(inner) => self.negated(inner)?,
            Node::Call(name, at, arguments) => self.call(name, at, arguments, &span)?,
            Node::If(condition, then, other) => self.choice(condition, then, other, wanted)?,
        };
        folded(expr, ty, span)
    }

    fn truths(&mut self, parts: &[Ast<'_>]) -> Result<Vec<Expr>, ExprError> {
        parts.iter().map(|part| self.truth(part)).collect()
    }

    fn compare(
        &mut self,
        sign: Comparison,
        left: &Ast<'_>,
        right: &Ast<'_>,
        deviation: Option<&Deviation<'_>>,
    ) -> Result<Expr, ExprError> {
        let (left, right) = self.pair(left, right)?;
        let sign = match sign {
            Comparison::Equal => Err(false),
            Comparison::NotEqual => Err(true),
            Comparison::Less => Ok(Order::Less),
            Comparison::LessEqual => Ok(Order::LessEqual),
            Comparison::Greater => Ok(Order::Greater),
            Comparison::GreaterEqual => Ok(Order::GreaterEqual),
        };
        comparable(&left, &right, sign.is_ok())?;
        self.leaf(&left);
        self.leaf(&right);
        let noisy = left.ty.is_noisy() || right.ty.is_noisy();
        let negated = match sign {
            Ok(sign) => {
                return Ok(Expr::Order(Box::new(Ordered { sign, left: left.expr, right: right.expr, noisy })));
            }
            Err(negated) => negated,
        };
        let tolerance = deviation.map(|deviation| self.tolerance(deviation, &left.ty, &right.ty)).transpose()?;
        Ok(Expr::Equal(Box::new(Equality { left: left.expr, right: right.expr, tolerance, noisy, negated })))
    }

    fn among(&mut self, value: &Ast<'_>, list: &[Ast<'_>]) -> Result<Expr, ExprError> {
        let value = self.value_in(value, None)?;
        let mut noisy = value.ty.is_noisy();
        let mut entries = Vec::with_capacity(list.len());
        for entry in list {
            let entry = self.value_in(entry, Some(&value.ty))?;
            comparable(&value, &entry, false)?;
            noisy |= entry.ty.is_noisy();
            entries.push(entry.expr);
        }
        self.leaf(&value);
        Ok(Expr::In(Box::new(Among { value: value.expr, list: entries.into(), noisy })))
    }

    fn tolerance(&mut self, deviation: &Deviation<'_>, seen: &Type, center: &Type) -> Result<Tolerance, ExprError> {
        let wrong =
            |message: String, help: &str| Err(ExprError::new(deviation.amount.span.clone(), message).help(help));
        let wanted = match (seen, center) {
            (Type::Place(_), _) | (_, Type::Place(_)) => Type::WHOLE,
            (Type::Number(_), _) => Type::FRACTION,
            (Type::Time | Type::Cycles, _) => seen.clone(),
            _ => return wrong(format!("{seen} has no tolerance"), "compare it with `==` alone"),
        };
        if deviation.percent && wanted == Type::WHOLE {
            return wrong("a place on a circle has no percentage".to_owned(), "give the tolerance in steps");
        }
        let wanted = if deviation.percent { Type::FRACTION } else { wanted };
        let amount = self.value_in(&deviation.amount, Some(&wanted))?;
        if amount.number().is_some_and(Number::is_negative) {
            return wrong("a tolerance is never negative".to_owned(), "give how far the value may lie on either side");
        }
        match (&wanted, &amount.ty) {
            (Type::Number(wanted), Type::Number(kind)) if kind.whole || !wanted.whole => {}
            (wanted, ty) if wanted == ty => {}
            (wanted, ty) => {
                return wrong(
                    format!("the tolerance has to be {wanted}, and this is {ty}"),
                    "give it in the unit of the value",
                );
            }
        }
        self.leaf(&amount);
        Ok(Tolerance { amount: amount.expr, percent: deviation.percent })
    }

    fn binary(
        &mut self,
        sign: Binary,
        left: &Ast<'_>,
        right: &Ast<'_>,
        span: &Range<usize>,
    ) -> Result<(Expr, Type), ExprError> {
        let (left, right) = (self.value_in(left, None)?, self.value_in(right, None)?);
        let ty = binary_type(sign, &left.ty, &right.ty)
            .map_err(|(message, help)| ExprError::new(span.clone(), message).help(help))?;
        let wrong = |message: &str, help: &str| Err(ExprError::new(right.span.clone(), message).help(help));
        match (sign, right.number()) {
            (Binary::Div | Binary::Mod, Some(Number::ZERO)) => {
                return wrong("this divides by zero", "divide by another number");
            }
            (Binary::Shl | Binary::Shr, Some(by)) if by < Number::ZERO || by > Number::whole(127) => {
                return wrong("a number is shifted by 0 to 127 bits", "shift by fewer bits, or the other way");
            }
            _ => {}
        }
        Ok((Expr::Binary(sign, Box::new([left.expr, right.expr])), ty))
    }

    fn choice(
        &mut self,
        condition: &Ast<'_>,
        then: &Ast<'_>,
        other: &Ast<'_>,
        wanted: Option<&Type>,
    ) -> Result<(Expr, Type), ExprError> {
        let condition = self.truth(condition)?;
        let (then, other) = (self.value_in(then, wanted)?, self.value_in(other, wanted)?);
        let ty = match (&then.ty, &other.ty) {
            (Type::Number(a), Type::Number(b)) => {
                Type::Number(NumberType { whole: a.whole && b.whole, steps: a.steps || b.steps, limits: None })
            }
            (a, b) if a == b => a.clone(),
            (a, b) => {
                return Err(ExprError::new(other.span, format!("after `else` stands {b}, after `then` {a}"))
                    .help("give both the same type"));
            }
        };
        Ok((Expr::If(Box::new([condition, then.expr, other.expr])), ty))
    }
}
