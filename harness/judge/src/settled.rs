//! What is worked out of parameters only, such as the size of a circle: once, and not at each frame.
//!
//! It knows which names no cyclic frame changes. It must not know what they are worked out for.

use expression::{Program, Value};
use std::cell::{Cell, RefCell};
use suite::device::{NameId, NameKind};
use suite::model::Variant;

/// What the values hold for: one of these numbers is another one as soon as a parameter may be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParameterVersion {
    /// The number of the start parameters.
    pub start: u64,
    /// The number of the notebook, which has those that were read or written.
    pub notebook: u64,
}

/// Values that hold until a parameter is another one; those of one variant.
#[derive(Clone, Debug, Default)]
pub struct Settled {
    of: Cell<ParameterVersion>,
    /// By the number of the name.
    values: RefCell<Vec<Settling>>,
}

#[derive(Clone, Debug, Default)]
enum Settling {
    /// Nobody has asked.
    #[default]
    Open,
    /// A frame may change it.
    Moves,
    At(Value),
}

impl Settled {
    /// What the program of a name comes to with the parameters `of`; `now` works it out.
    pub fn value(
        &self,
        name: NameId,
        program: &Program,
        variant: &Variant,
        of: ParameterVersion,
        now: impl FnOnce() -> Value,
    ) -> Value {
        self.forget_what_moved(of);
        let place = name.0 as usize;
        match self.values.borrow().get(place) {
            Some(Settling::At(value)) => return value.clone(),
            Some(Settling::Moves) => return now(),
            Some(Settling::Open) | None => {}
        }
        let value = now();
        let mut values = self.values.borrow_mut();
        if values.len() <= place {
            values.resize(place + 1, Settling::Open);
        }
        let settles = program.names().all(|name| is_settled(name, variant));
        values[place] = if settles { Settling::At(value.clone()) } else { Settling::Moves };
        value
    }

    /// The whole number that a name is, or that it has no value, if that was worked out before and holds.
    pub fn whole(&self, name: NameId, of: ParameterVersion) -> Option<Option<i128>> {
        self.forget_what_moved(of);
        match self.values.borrow().get(name.0 as usize)? {
            Settling::At(Value::Number(number)) => number.as_whole().map(Some),
            Settling::At(Value::Unknown) => Some(None),
            Settling::At(_) | Settling::Moves | Settling::Open => None,
        }
    }

    fn forget_what_moved(&self, of: ParameterVersion) {
        if self.of.replace(of) != of {
            self.values.borrow_mut().clear();
        }
    }
}

/// Whether neither a frame nor an event nor time changes the value of a name.
fn is_settled(name: NameId, variant: &Variant) -> bool {
    match variant.names.get(name.0 as usize) {
        Some(NameKind::Derived(index)) => {
            let program = variant.derived.get(*index).map(|(_, program)| program);
            program
                .is_some_and(|program| !program.has_history() && program.names().all(|name| is_settled(name, variant)))
        }
        kind => kind.is_some_and(|kind| kind.observability().is_settled),
    }
}
