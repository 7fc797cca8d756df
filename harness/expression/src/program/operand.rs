//! Resolves names and words. Whether an identifier is a name or a word depends on the other operand.

use super::check::{ExpressionCompiler, TypedExpr};
use super::eval::Expr;
use super::explain::Leaf;
use crate::ast::{Ast, AstNode};
use crate::literal::bytes_or_pattern;
use crate::{ExprError, Number, ResolvedName, Type, Value, WordTable, address, pattern};
use plain_text::Nearest;
use plain_text::nearest;
use std::ops::Range;
use std::sync::Arc;

/// A side of a comparison before the other side is resolved.
pub(super) enum Candidate<'t> {
    /// A value; with its text if it is an identifier, which may be a word if the other side has words.
    Value(TypedExpr, Option<&'t str>),
    /// An identifier that is not a name and may be a word. `error` is reported if it is not a word; `None`: unknown name.
    Word { word: String, span: Range<usize>, error: Option<ExprError> },
}

impl Candidate<'_> {
    fn table(&self) -> Option<&Arc<WordTable>> {
        match self {
            Candidate::Value(TypedExpr { ty: Type::Word(table), .. }, _) => Some(table),
            Candidate::Value(..) | Candidate::Word { .. } => None,
        }
    }
}

impl<'t> ExpressionCompiler<'_> {
    /// Compiles the two sides of a comparison; each may resolve words by the type of the other.
    pub(super) fn pair(&mut self, left: &Ast<'t>, right: &Ast<'t>) -> Result<(TypedExpr, TypedExpr), ExprError> {
        let (left, right) = (self.candidate(left)?, self.candidate(right)?);
        if let (Candidate::Word { word, span, error }, Candidate::Word { .. }) = (&left, &right) {
            return Err(error.clone().unwrap_or_else(|| self.unknown(word, span)));
        }
        let table = left.table().cloned();
        let right = self.resolve(right, table.as_ref())?;
        let table = match &right.ty {
            Type::Word(table) => Some(table.clone()),
            _ => None,
        };
        let left = self.resolve(left, table.as_ref())?;
        let (left, right) = (coerced(left, &right.ty)?, right);
        let right = coerced(right, &left.ty)?;
        Ok((left, right))
    }

    /// Compiles a value; `expected` is the type of the name it is assigned to or compared with, if known.
    pub(super) fn value_in(&mut self, ast: &Ast<'t>, expected: Option<&Type>) -> Result<TypedExpr, ExprError> {
        let table = match expected {
            Some(Type::Word(table)) => Some(table),
            _ => None,
        };
        let typed = match ast.kind {
            AstNode::Name(_) => {
                let candidate = self.candidate(ast)?;
                self.resolve(candidate, table)?
            }
            _ => self.node(ast, expected)?,
        };
        match expected {
            Some(expected) => coerced(typed, expected),
            None => Ok(typed),
        }
    }

    fn candidate(&mut self, ast: &Ast<'t>) -> Result<Candidate<'t>, ExprError> {
        let AstNode::Name(path) = ast.kind else { return Ok(Candidate::Value(self.node(ast, None)?, None)) };
        let span = ast.span.clone();
        let value = |expr, ty| Ok(Candidate::Value(TypedExpr { expr, ty, span: span.clone() }, Some(path)));
        match self.scope.lookup(path) {
            Some(ResolvedName::Constant(constant, ty)) => value(Expr::Const(constant), ty),
            Some(ResolvedName::Name(name, ty)) => value(Expr::Name(name), ty),
            Some(ResolvedName::Word(word)) => {
                let error = ExprError::new(
                    span.clone(),
                    format!("`{path}` is the word `{word}`, which has no meaning on its own"),
                )
                .help("compare it with a name that has this word");
                Ok(Candidate::Word { word, span, error: Some(error) })
            }
            Some(ResolvedName::Refused { message, help }) => Err(ExprError { span, message, help }),
            None => Ok(Candidate::Word { word: path.to_owned(), error: None, span }),
        }
    }

    fn resolve(&mut self, candidate: Candidate<'t>, table: Option<&Arc<WordTable>>) -> Result<TypedExpr, ExprError> {
        let word = match &candidate {
            Candidate::Value(_, bare) => *bare,
            Candidate::Word { word, .. } => Some(word.as_str()),
        };
        let number = word.zip(table).and_then(|(word, table)| Some((table.number(word)?, table)));
        match (candidate, number) {
            (Candidate::Value(TypedExpr { span, .. }, _) | Candidate::Word { span, .. }, Some((number, table))) => {
                Ok(TypedExpr { expr: Expr::Const(Value::Word(number)), ty: Type::Word(table.clone()), span })
            }
            (Candidate::Value(typed, _), None) => {
                if let Expr::Name(name) = typed.expr {
                    self.names.push(name);
                    self.leaf(&typed);
                }
                Ok(typed)
            }
            (Candidate::Word { word, span, error }, None) => Err(match table {
                Some(table) => no_word(&word, span, table),
                None => error.unwrap_or_else(|| self.unknown(&word, &span)),
            }),
        }
    }

    /// Adds an operand whose value the report of a failure shows.
    pub(super) fn leaf(&mut self, typed: &TypedExpr) {
        if !matches!(typed.expr, Expr::Const(_)) && self.leaves.iter().all(|leaf| leaf.span != typed.span) {
            self.leaves.push(Leaf { span: typed.span.clone(), expr: typed.expr.clone(), ty: typed.ty.clone() });
        }
    }

    fn unknown(&self, path: &str, span: &Range<usize>) -> ExprError {
        let error = ExprError::new(span.clone(), format!("unknown name `{path}`"));
        match path {
            "true" | "on" | "yes" => return error.help("write 1 for a bit, or use the bit alone as a condition"),
            "false" | "off" | "no" => return error.help("write 0 for a bit, or negate a condition with `not`"),
            _ => {}
        }
        let mut best = Nearest::new(path);
        self.scope.known(&mut |name| best.offer(name));
        match best.found() {
            Some(name) => error.did_you_mean(Some(name)),
            None => error.help("declare it in `device.yaml`, `save` it first, or write a text in double quotes"),
        }
    }
}

fn no_word(word: &str, span: Range<usize>, table: &WordTable) -> ExprError {
    let error = ExprError::new(span, format!("`{word}` is not a word of `{}`", table.name));
    match nearest(word, table.iter()) {
        Some(nearest) => error.did_you_mean(Some(nearest)),
        None => error.help(format!("write one of {}", table.listed())),
    }
}

/// Converts a literal to the type of the other operand: a text to bytes or an address, 0 to a duration, 0 and 1 to a bit.
fn coerced(typed: TypedExpr, beside: &Type) -> Result<TypedExpr, ExprError> {
    let Expr::Const(value) = &typed.expr else { return Ok(typed) };
    let here = |error: ExprError| ExprError { span: typed.span.clone(), ..error };
    let value = match (value, beside) {
        (Value::Text(text), Type::Bytes) => bytes_or_pattern(pattern(text).map_err(here)?),
        (Value::Text(text), Type::Address) => Value::Address(address(text).map_err(here)?),
        (Value::Number(Number::ZERO), Type::Time) => Value::Time(Number::ZERO),
        (Value::Number(Number::ZERO), Type::Cycles) => Value::Cycles(Number::ZERO),
        (Value::Number(number), Type::Bit) => match number.as_whole() {
            Some(0) => Value::Bit(false),
            Some(1) => Value::Bit(true),
            _ => return Err(ExprError::new(typed.span, format!("{number} is not a bit")).help("write 0 or 1")),
        },
        _ => return Ok(typed),
    };
    Ok(TypedExpr { expr: Expr::Const(value), ty: beside.clone(), span: typed.span })
}
