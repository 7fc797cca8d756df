//! The deliberate bugs of the reference devices, by the seam at which they are switched on.
//!
//! A [`Bug`] is a name, a sentence and the knob that it turns; no code of a device ever asks for a bug. A model says which
//! of them it can be told to have. This room must not hold healthy behaviour: that stands at the seam which reads the knob.

use crate::behaviour::Behaviour;

/// Lines of `"name" "Sentence." => |b| what is turned;`.
macro_rules! bugs {
    ($($name:literal $sentence:literal => |$behaviour:ident| $turn:expr;)*) => {
        &[$($crate::bugs::Bug {
            name: $name,
            sentence: $sentence,
            apply: |$behaviour: &mut $crate::behaviour::Behaviour| { $turn; },
        }),*]
    };
}

pub(crate) mod diagnosis;
pub(crate) mod handshakes;
mod image;
pub(crate) mod measuring;
pub(crate) mod memory;
pub(crate) mod parameter_access;
pub(crate) mod parameters;
pub(crate) mod plain;
pub(crate) mod presets;
pub(crate) mod records;
pub(crate) mod reset;
pub(crate) mod signals;
pub(crate) mod stack;
pub(crate) mod start;
pub(crate) mod station;
pub(crate) mod velocity;
pub(crate) mod web;

/// A deliberate deviation of a reference device from its manual.
#[derive(Debug)]
pub struct Bug {
    /// Its name, as the suites name it under `catches`.
    pub name: &'static str,
    /// What the device does wrong, in one sentence.
    pub sentence: &'static str,
    /// What it changes in a behaviour.
    pub apply: fn(&mut Behaviour),
}

/// Bugs of one seam that a model can be told to have.
#[derive(Clone, Copy, Debug)]
pub enum Table {
    /// All of them.
    All(&'static [Bug]),
    /// Those of these names.
    Only(&'static [Bug], &'static [&'static str]),
}

impl Table {
    /// The bugs that it names, in the order of the seam.
    pub fn bugs(&self) -> impl Iterator<Item = &'static Bug> + Clone + use<> {
        let (all, only) = match *self {
            Table::All(all) => (all, None),
            Table::Only(all, only) => (all, Some(only)),
        };
        all.iter().filter(move |bug| only.is_none_or(|only| only.contains(&bug.name)))
    }
}
