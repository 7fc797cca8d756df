//! The syntax tree of an expression, before names are resolved and types are checked.

use super::Number;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A node of the tree with its span and depth.
#[derive(Debug)]
pub(super) struct Ast<'t> {
    pub(super) kind: AstNode<'t>,
    pub(super) span: Range<usize>,
    /// The number of nodes on the longest path down, including this one.
    pub(super) depth: u32,
}

/// The kind of a node.
#[derive(Debug)]
pub(super) enum AstNode<'t> {
    Number(Number),
    Time(Number),
    Cycles(Number),
    Text(&'t str),
    Name(&'t str),
    Negate(Box<Ast<'t>>),
    Not(Box<Ast<'t>>),
    And(Vec<Ast<'t>>),
    Or(Vec<Ast<'t>>),
    Binary(Binary, Box<Ast<'t>>, Box<Ast<'t>>),
    Compare(Comparison, Box<Ast<'t>>, Box<Ast<'t>>, Option<Box<ToleranceNode<'t>>>),
    In(Box<Ast<'t>>, Vec<Ast<'t>>),
    Call(&'t str, Range<usize>, Vec<Ast<'t>>),
    If(Box<Ast<'t>>, Box<Ast<'t>>, Box<Ast<'t>>),
}

/// The tolerance after `+/-`.
#[derive(Debug)]
pub(super) struct ToleranceNode<'t> {
    pub(super) amount: Ast<'t>,
    pub(super) percent: bool,
}

/// Binary operators that result in a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(super) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Mod,
    Shl,
    Shr,
}

/// Comparison operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Comparison {
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
}
