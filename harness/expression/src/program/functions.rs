//! Compiles function calls: functions of one observation and history functions.

use super::check::{ExpressionCompiler, TypedExpr};
use super::eval::Expr;
use super::{History, HistorySlot};
use crate::arithmetic::{ArithmeticFunction, function_type};
use crate::ast::Ast;
use crate::types::NumberType;
use crate::{ExprError, Type, Value};
use plain_text::nearest;
use std::ops::Range;

/// The function that a name before a parenthesis calls.
#[derive(Clone, Copy)]
enum FunctionCallee {
    Plain(ArithmeticFunction),
    Back(History),
}

const FUNCTIONS: [(&str, FunctionCallee); 11] = [
    ("abs", FunctionCallee::Plain(ArithmeticFunction::Abs)),
    ("min", FunctionCallee::Plain(ArithmeticFunction::Min)),
    ("max", FunctionCallee::Plain(ArithmeticFunction::Max)),
    ("floor", FunctionCallee::Plain(ArithmeticFunction::Floor)),
    ("round", FunctionCallee::Plain(ArithmeticFunction::Round)),
    ("number", FunctionCallee::Plain(ArithmeticFunction::Number)),
    ("rises", FunctionCallee::Back(History::Rises)),
    ("falls", FunctionCallee::Back(History::Falls)),
    ("changes", FunctionCallee::Back(History::Changes)),
    ("prev", FunctionCallee::Back(History::Prev)),
    ("since", FunctionCallee::Back(History::Since)),
];

impl ExpressionCompiler<'_> {
    /// Compiles `name(arguments)`; `at` is the span of the name, `span` that of the call.
    pub(super) fn call(
        &mut self,
        name: &str,
        at: &Range<usize>,
        arguments: &[Ast<'_>],
        span: &Range<usize>,
    ) -> Result<(Expr, Type), ExprError> {
        let Some((_, callee)) = FUNCTIONS.iter().find(|(known, _)| *known == name) else {
            let error = ExprError::new(at.clone(), format!("unknown function `{name}`"));
            let names = FUNCTIONS.map(|(name, _)| name);
            return Err(match nearest(name, names) {
                Some(nearest) => error.did_you_mean(Some(nearest)),
                None => error.help(format!("the functions are {}", names.join(", "))),
            });
        };
        match (callee, arguments) {
            (FunctionCallee::Plain(function @ (ArithmeticFunction::Min | ArithmeticFunction::Max)), [_, _, ..]) => {
                self.extreme(*function, arguments, span)
            }
            (FunctionCallee::Plain(ArithmeticFunction::Min | ArithmeticFunction::Max), _) => {
                Err(ExprError::new(span.clone(), format!("`{name}` needs two or more values"))
                    .help("give at least two"))
            }
            (FunctionCallee::Plain(function), [argument]) => self.plain(*function, argument),
            (FunctionCallee::Back(function), [argument]) => self.back(*function, name, argument, span),
            _ => Err(ExprError::new(span.clone(), format!("`{name}` takes one value"))
                .help("give one value in the parentheses")),
        }
    }

    /// Compiles `-value`.
    pub(super) fn negated(&mut self, inner: &Ast<'_>) -> Result<(Expr, Type), ExprError> {
        self.plain(ArithmeticFunction::Negate, inner)
    }

    fn plain(&mut self, function: ArithmeticFunction, argument: &Ast<'_>) -> Result<(Expr, Type), ExprError> {
        let argument = self.value_in(argument, None)?;
        let ty = typed(function, &argument)?;
        Ok((Expr::Call(function, [argument.expr].into()), ty))
    }

    fn extreme(
        &mut self,
        function: ArithmeticFunction,
        arguments: &[Ast<'_>],
        span: &Range<usize>,
    ) -> Result<(Expr, Type), ExprError> {
        let mut common: Option<Type> = None;
        let mut exprs = Vec::with_capacity(arguments.len());
        for argument in arguments {
            let argument = self.value_in(argument, common.as_ref())?;
            let ty = typed(function, &argument)?;
            common = Some(match (common, ty) {
                (None, ty) => ty,
                (Some(Type::Number(a)), Type::Number(b)) => {
                    Type::Number(NumberType { whole: a.whole && b.whole, steps: a.steps || b.steps, limits: None })
                }
                (Some(a), b) if a == b => a,
                (Some(a), b) => {
                    return Err(ExprError::new(span.clone(), format!("cannot compare {a} with {b}"))
                        .help("give values of the same type"));
                }
            });
            exprs.push(argument.expr);
        }
        Ok((Expr::Call(function, exprs.into()), common.unwrap_or(Type::WHOLE)))
    }

    fn back(
        &mut self,
        function: History,
        name: &str,
        argument: &Ast<'_>,
        span: &Range<usize>,
    ) -> Result<(Expr, Type), ExprError> {
        if !self.allow.history {
            return Err(ExprError::new(
                span.clone(),
                format!("`{name}` needs earlier values, which do not exist here"),
            )
            .help("use it in `expect`, `observe` or a rule"));
        }
        // The slot is reserved before the argument is compiled, so outer slots come before inner ones.
        let index = self.slots.len();
        let empty = Expr::Const(Value::Unknown);
        self.slots.push(HistorySlot { function, argument: empty, names: Box::new([]), noisy: false });
        let names = self.names.len();
        let inner = match function {
            History::Rises | History::Falls | History::Since => {
                TypedExpr { expr: self.truth(argument)?, ty: Type::Bit, span: argument.span.clone() }
            }
            History::Changes | History::Prev => self.value_in(argument, None)?,
        };
        if matches!(inner.expr, Expr::Const(_)) {
            return Err(
                ExprError::new(inner.span, "this value is constant").help(format!("give `{name}` a name that changes"))
            );
        }
        let noisy = inner.ty.is_noisy();
        let ty = match function {
            History::Rises | History::Falls | History::Changes => Type::Bit,
            History::Prev => inner.ty,
            History::Since => Type::Time,
        };
        let names = self.names.get(names..).unwrap_or_default().into();
        if let Some(slot) = self.slots.get_mut(index) {
            *slot = HistorySlot { function, argument: inner.expr, names, noisy };
        }
        let call = TypedExpr { expr: Expr::History(index), ty: ty.clone(), span: span.clone() };
        self.leaf(&call);
        Ok((call.expr, ty))
    }
}

fn typed(function: ArithmeticFunction, argument: &TypedExpr) -> Result<Type, ExprError> {
    function_type(function, &argument.ty)
        .map_err(|(message, help)| ExprError::new(argument.span.clone(), message).help(help))
}
