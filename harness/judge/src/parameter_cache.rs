//! Cache of values that depend on parameters only, such as the size of a circle, so they are not computed at each frame.

use expression::{Program, Value};
use std::cell::{Cell, RefCell};
use suite::device::{NameId, NameKind};
use suite::model::SuiteVariant;

/// The version of the parameters: one of these numbers changes when a parameter may have changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParameterVersion {
    /// The version of the start parameters.
    pub start: u64,
    /// The version of the notebook, which has parameters that were read or written.
    pub notebook: u64,
}

/// Cached values of one variant, valid until a parameter changes.
#[derive(Clone, Debug, Default)]
pub struct ParameterCache {
    of: Cell<ParameterVersion>,
    /// By number of the name.
    values: RefCell<Vec<CachedValue>>,
}

#[derive(Clone, Debug, Default)]
enum CachedValue {
    /// Not computed yet.
    #[default]
    Open,
    /// Not cacheable: a frame may change it.
    Moves,
    At(Value),
}

impl ParameterCache {
    /// The value of the program of a name with the parameters `of`; `now` computes it.
    pub fn value(
        &self,
        name: NameId,
        program: &Program,
        variant: &SuiteVariant,
        of: ParameterVersion,
        now: impl FnOnce() -> Value,
    ) -> Value {
        self.forget_what_moved(of);
        let place = name.0 as usize;
        match self.values.borrow().get(place) {
            Some(CachedValue::At(value)) => return value.clone(),
            Some(CachedValue::Moves) => return now(),
            Some(CachedValue::Open) | None => {}
        }
        let value = now();
        let mut values = self.values.borrow_mut();
        if values.len() <= place {
            values.resize(place + 1, CachedValue::Open);
        }
        let settles = program.names().all(|name| is_settled(name, variant));
        values[place] = if settles { CachedValue::At(value.clone()) } else { CachedValue::Moves };
        value
    }

    /// The cached whole number of a name; `Some(None)` if the value is unknown, `None` if it is not cached.
    pub fn whole(&self, name: NameId, of: ParameterVersion) -> Option<Option<i128>> {
        self.forget_what_moved(of);
        match self.values.borrow().get(name.0 as usize)? {
            CachedValue::At(Value::Number(number)) => number.as_whole().map(Some),
            CachedValue::At(Value::Unknown) => Some(None),
            CachedValue::At(_) | CachedValue::Moves | CachedValue::Open => None,
        }
    }

    fn forget_what_moved(&self, of: ParameterVersion) {
        if self.of.replace(of) != of {
            self.values.borrow_mut().clear();
        }
    }
}

/// Whether the value of a name is constant: neither frames nor events nor time change it.
fn is_settled(name: NameId, variant: &SuiteVariant) -> bool {
    match variant.names.get(name.0 as usize) {
        Some(NameKind::Derived(index)) => {
            let program = variant.derived.get(*index).map(|(_, program)| program);
            program
                .is_some_and(|program| !program.has_history() && program.names().all(|name| is_settled(name, variant)))
        }
        kind => kind.is_some_and(|kind| kind.observability().is_settled),
    }
}
