//! Compiles the syntax tree to a program: resolves names, checks types, folds constants.

use super::HistorySlot;
use super::compatible::{comparable, fits};
use super::eval::{Among, Equality, Expr, Ordered, Tolerance};
use super::explain::{Leaf, Note};
use super::fold::{folded, joined};
use crate::arithmetic::binary_type;
use crate::ast::{Ast, AstNode, Binary, Comparison, ToleranceNode};
use crate::compare::OrderOperator;
use crate::parse;
use crate::{Allow, ExpectedValue, ExprError, NameId, NameScope, Number, NumberType, Program, Type, Value};
use std::ops::Range;

/// A program being compiled.
pub(super) struct ExpressionCompiler<'s> {
    pub(super) scope: &'s dyn NameScope,
    pub(super) allow: Allow,
    pub(super) slots: Vec<HistorySlot>,
    pub(super) names: Vec<NameId>,
    pub(super) leaves: Vec<Leaf>,
}

/// A compiled subexpression with its type.
pub(super) struct TypedExpr {
    pub(super) expr: Expr,
    pub(super) ty: Type,
    pub(super) span: Range<usize>,
}

impl TypedExpr {
    pub(super) fn constant(&self) -> Option<&Value> {
        match &self.expr {
            Expr::Const(value) => Some(value),
            _ => None,
        }
    }

    /// The value of a constant number or duration.
    pub(super) fn number(&self) -> Option<Number> {
        match self.constant() {
            Some(Value::Number(number) | Value::Time(number) | Value::Cycles(number)) => Some(*number),
            _ => None,
        }
    }
}

impl<'s> ExpressionCompiler<'s> {
    fn new(scope: &'s dyn NameScope, allow: Allow) -> ExpressionCompiler<'s> {
        ExpressionCompiler { scope, allow, slots: Vec::new(), names: Vec::new(), leaves: Vec::new() }
    }

    pub(super) fn condition(text: &str, scope: &'s dyn NameScope, allow: Allow) -> Result<Program, ExprError> {
        let tree = parse::condition(text, allow)?;
        let mut this = ExpressionCompiler::new(scope, allow);
        let parts = match &tree.kind {
            AstNode::And(parts) => parts.as_slice(),
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
        expected: Option<&Type>,
        scope: &'s dyn NameScope,
        allow: Allow,
    ) -> Result<Program, ExprError> {
        let (tree, deviation) = parse::right_side(text, allow)?;
        if let Some(deviation) = deviation {
            return Err(ExprError::new(deviation.amount.span, "a tolerance has no meaning here")
                .help("give the value alone; tolerances are allowed in checks only"));
        }
        let mut this = ExpressionCompiler::new(scope, allow);
        let typed = this.value_in(&tree, expected)?;
        if let Some(expected) = expected {
            fits(expected, &typed)?;
        }
        if let Some(Value::Pattern(_)) = typed.constant() {
            return Err(ExprError::new(typed.span, "`..` and `*` are allowed in checks only").help("write every byte"));
        }
        Ok(this.only_part(text, typed))
    }

    pub(super) fn target(
        text: &str,
        expected: &Type,
        scope: &'s dyn NameScope,
        allow: Allow,
    ) -> Result<ExpectedValue, ExprError> {
        let (tree, deviation) = parse::right_side(text, allow)?;
        let mut this = ExpressionCompiler::new(scope, allow);
        let center = this.value_in(&tree, Some(expected))?;
        fits(expected, &center)?;
        let tolerance = deviation.map(|deviation| this.tolerance(&deviation, expected, &center.ty)).transpose()?;
        Ok(ExpectedValue { center: this.only_part(text, center), tolerance })
    }

    /// Combines a part with the operands collected for it, in the order written.
    fn note(&mut self, part: Leaf) -> Note {
        let mut operands = std::mem::take(&mut self.leaves);
        operands.sort_by_key(|leaf| (leaf.span.start, leaf.span.end));
        Note { part, operands: operands.into() }
    }

    fn only_part(mut self, text: &str, typed: TypedExpr) -> Program {
        let part = Leaf { span: 0..text.len(), expr: typed.expr.clone(), ty: typed.ty.clone() };
        let note = self.note(part);
        self.program(text, typed.expr, typed.ty, vec![note])
    }

    fn program(mut self, text: &str, root: Expr, ty: Type, notes: Vec<Note>) -> Program {
        self.names.sort_unstable();
        self.names.dedup();
        Program { text: text.into(), root, ty, slots: self.slots.into(), names: self.names.into(), notes: notes.into() }
    }

    /// Compiles a condition; its type must be a bit.
    pub(super) fn truth(&mut self, ast: &Ast<'_>) -> Result<Expr, ExprError> {
        let typed = self.value_in(ast, None)?;
        let help = match &typed.ty {
            Type::Bit => return Ok(typed.expr),
            Type::Number(_) | Type::Place(_) => "compare it, for instance with `!= 0`".to_owned(),
            Type::Word(table) => format!("compare it with `==` and one of {}", table.listed()),
            _ => "compare it with `==`".to_owned(),
        };
        Err(ExprError::new(typed.span, format!("expected a condition, found {}", typed.ty)).help(help))
    }

    /// Compiles a node; `expected` applies to the branches of a choice.
    pub(super) fn node(&mut self, ast: &Ast<'_>, expected: Option<&Type>) -> Result<TypedExpr, ExprError> {
        let span = ast.span.clone();
        let constant = |value, ty| Ok(TypedExpr { expr: Expr::Const(value), ty, span: span.clone() });
        let (expr, ty) = match &ast.kind {
            AstNode::Name(_) => return self.value_in(ast, expected),
            AstNode::Number(number) => {
                let kind = NumberType { whole: number.is_whole(), ..NumberType::WHOLE };
                return constant(Value::Number(*number), Type::Number(kind));
            }
            AstNode::Time(nanos) => return constant(Value::Time(*nanos), Type::Time),
            AstNode::Cycles(cycles) => return constant(Value::Cycles(*cycles), Type::Cycles),
            AstNode::Text(text) => return constant(Value::text(*text), Type::Text),
            AstNode::Not(inner) => (Expr::Not(Box::new(self.truth(inner)?)), Type::Bit),
            AstNode::And(parts) => (joined(self.truths(parts)?, false), Type::Bit),
            AstNode::Or(parts) => (joined(self.truths(parts)?, true), Type::Bit),
            AstNode::Compare(sign, left, right, deviation) => {
                (self.compare(*sign, left, right, deviation.as_deref())?, Type::Bit)
            }
            AstNode::In(value, list) => (self.among(value, list)?, Type::Bit),
            AstNode::Binary(sign, left, right) => self.binary(*sign, left, right, &span)?,
            AstNode::Negate(inner) => self.negated(inner)?,
            AstNode::Call(name, at, arguments) => self.call(name, at, arguments, &span)?,
            AstNode::If(condition, then, other) => self.choice(condition, then, other, expected)?,
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
        deviation: Option<&ToleranceNode<'_>>,
    ) -> Result<Expr, ExprError> {
        let (left, right) = self.pair(left, right)?;
        let sign = match sign {
            Comparison::Equal => Err(false),
            Comparison::NotEqual => Err(true),
            Comparison::Less => Ok(OrderOperator::Less),
            Comparison::LessEqual => Ok(OrderOperator::LessEqual),
            Comparison::Greater => Ok(OrderOperator::Greater),
            Comparison::GreaterEqual => Ok(OrderOperator::GreaterEqual),
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

    fn tolerance(
        &mut self,
        deviation: &ToleranceNode<'_>,
        observed: &Type,
        center: &Type,
    ) -> Result<Tolerance, ExprError> {
        let wrong =
            |message: String, help: &str| Err(ExprError::new(deviation.amount.span.clone(), message).help(help));
        let expected = match (observed, center) {
            (Type::Place(_), _) | (_, Type::Place(_)) => Type::WHOLE,
            (Type::Number(_), _) => Type::FRACTION,
            (Type::Time | Type::Cycles, _) => observed.clone(),
            _ => return wrong(format!("{observed} has no tolerance"), "compare it with `==` alone"),
        };
        if deviation.percent && expected == Type::WHOLE {
            return wrong("a position has no percentage".to_owned(), "give the tolerance in steps");
        }
        let expected = if deviation.percent { Type::FRACTION } else { expected };
        let amount = self.value_in(&deviation.amount, Some(&expected))?;
        if amount.number().is_some_and(Number::is_negative) {
            return wrong(
                "a tolerance cannot be negative".to_owned(),
                "give the allowed difference in either direction",
            );
        }
        match (&expected, &amount.ty) {
            (Type::Number(expected), Type::Number(kind)) if kind.whole || !expected.whole => {}
            (expected, ty) if expected == ty => {}
            (expected, ty) => {
                return wrong(
                    format!("the tolerance must be {expected}, found {ty}"),
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
                return wrong("division by zero", "divide by another number");
            }
            (Binary::Shl | Binary::Shr, Some(by)) if by < Number::ZERO || by > Number::whole(127) => {
                return wrong("a number is shifted by 0 to 127 bits", "shift by fewer bits, or in the other direction");
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
        expected: Option<&Type>,
    ) -> Result<(Expr, Type), ExprError> {
        let condition = self.truth(condition)?;
        let (then, other) = (self.value_in(then, expected)?, self.value_in(other, expected)?);
        let ty = match (&then.ty, &other.ty) {
            (Type::Number(a), Type::Number(b)) => {
                Type::Number(NumberType { whole: a.whole && b.whole, steps: a.steps || b.steps, limits: None })
            }
            (a, b) if a == b => a.clone(),
            (a, b) => {
                return Err(ExprError::new(other.span, format!("`then` gives {a}, but `else` gives {b}"))
                    .help("give both the same type"));
            }
        };
        Ok((Expr::If(Box::new([condition, then.expr, other.expr])), ty))
    }
}
