//! The expression language of the suites: compiles text to a typed and checked [`Program`] and evaluates it over observations.
//!
//! Conditions of rules and expectations, computed right sides (`= before + 1000 +/- 2`) and the derived values of a
//! `device.yaml` are compiled here, and so are the literals of every type. All checks run when a text is compiled.
//! Evaluation is three-valued, allocates nothing on numeric paths and cannot fail: a value that is missing or cannot be
//! computed is [`Value::Unknown`].
//!
//! These points go beyond "Expressions" of `docs/suite-language.md`:
//!
//! - **Positions.** `position << n`, `* n`, `/ n` and `mod n` use the number of steps of a position. `number - position` and
//!   the magnitude of a position have no meaning and are errors. Half a circle is a positive distance. A position outside its
//!   circle is compared as received, but nothing can be added to it and it has no distance to another position. `<` and `>`
//!   compare positions as numbers.
//! - **Noise** widens `==`, `in`, `<` and `>` of positions and of distances between positions, and the change that `changes`
//!   needs. `!=` is always the negation of `==`. A position outside its circle gets no noise, nor does a
//!   code that a device shows in place of a position.
//! - **History.** `prev(x)` is the value of `x` in the previous image that carries `x`; frames and events without `x` leave it
//!   unchanged. `changes(x)` is true only at the frame that carries the new value. Both are unknown after an image in which `x`
//!   is unknown. `rises(c)` is `c and not (c in the previous observation)`, three-valued. `since(c)` is unknown until `c` was
//!   true once, and again after an observation in which `c` is unknown; if `c` was false throughout, it is longer than that time.
//! - **Words** take precedence over names: compared with a name that has words, `position` is the word if the table has it.
//! - **Texts** in quotes have no escapes. Compared with bytes or an address they are parsed as bytes or an address.
//!
//! This crate does not depend on YAML, files, steps, frames or devices. A [`NameScope`] resolves names at compile time, an
//! [`NameValues`] returns their values at run time.

#![allow(missing_docs, reason = "internal crate: self-explanatory items need no comment")]

mod arithmetic;
mod ast;
mod circle;
mod compare;
mod error;
mod lexer;
mod literal;
mod names;
mod number;
mod parse;
mod pattern;
pub mod pool;
mod program;
mod types;
mod value;
mod word_table;

#[cfg(test)]
mod tests;

pub use circle::Circle;
pub use compare::{OrderOperator, equal, order};
pub use error::ExprError;
pub use literal::{DurationLiteral, address, bytes, duration, literal, number, pattern};
pub use names::{Allow, NameId, NameScope, NameValues, ResolvedName};
pub use number::Number;
pub use pattern::BytePattern;
pub use program::{ExpectedValue, ExplainedPart, HistoryState, Operand, Program};
pub use types::{NumberType, Type};
pub use value::{CircularPosition, FormattedValue, Value};
pub use word_table::WordTable;
