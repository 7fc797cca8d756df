//! The expression language of the suites: text in, a typed and checked [`Program`] out, evaluated over what was seen.
//!
//! Conditions of rules and expectations, computed right sides (`= before + 1000 +/- 2`) and the derived values of a
//! `device.yaml` all go through here, and so do the literals of every type. All checking is done when a text is
//! compiled; evaluation is three-valued, allocates nothing on numeric paths and cannot fail: what cannot be known or
//! computed is [`Value::Unknown`].
//!
//! What the page of the language leaves open is decided here:
//!
//! - **Places.** `place << n`, `* n`, `/ n` and `mod n` take a place as its number of steps; `number - place` and the size
//!   of a place have no meaning and are errors. Half a circle is a positive way. A place beyond its circle is compared
//!   as it came, but moves nowhere and has no way to another one. Places are compared in order as numbers.
//! - **Noise** widens `==`, `in` and orders of places, ways between places, and what `changes` calls a change; `!=` is
//!   always the contrary of `==`. A place beyond its circle gets none.
//! - **History.** `prev(x)` is the value in the image before the present one that carries `x`, so it stays the same at
//!   frames and events that do not; `changes(x)` is true only at the frame that brings the change. Both are unknown
//!   across an image in which `x` is. `rises(c)` is `c and not c before`, three-valued. `since(c)` is unknown until `c`
//!   was true once, and again as soon as it cannot be known whether it was.
//! - **Words** go before names: beside a name with words, `position` is the word if the table has it.
//! - **Texts** in quotes have no escapes; beside octets or an address they are read as such.
//!
//! This room must not know YAML, files, steps, frames or devices. It asks a [`Scope`] what a name is when it compiles,
//! and an [`Env`] what the name's value is when it evaluates.

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
pub use compare::{Order, equal, order};
pub use error::ExprError;
pub use literal::{Span, address, bytes, duration, literal, number, pattern};
pub use names::{Allow, Env, Found, NameId, Scope};
pub use number::Number;
pub use pattern::BytePattern;
pub use program::{Operand, Part, Program, State, Target};
pub use types::{NumberType, Type};
pub use value::{Place, Shown, Value};
pub use word_table::WordTable;
