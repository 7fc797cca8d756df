//! The change that is in force in this thread, and which changes the thread has reached.

use std::cell::{Cell, RefCell};

thread_local! {
    static ACTIVE: Cell<u32> = const { Cell::new(0) };
    static REACHED: RefCell<Vec<Reach>> = const { RefCell::new(Vec::new()) };
}

/// Whether a thread has been at the place of a change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reach {
    /// It has not.
    #[default]
    Not,
    /// It has, but the change would have made no difference there: for instance no two numbers that `<` and `<=` compare were equal.
    Same,
    /// It has, and the change would have made one.
    Differs,
}

/// Whether the change `number`, from 1, is in force. The changed code calls it at each place.
#[inline]
pub fn on(number: u32) -> bool {
    let active = ACTIVE.get();
    if active == u32::MAX {
        note(number, Reach::Differs);
    }
    active == number
}

/// The value `own` of the code, or `other` if the change `number` is in force.
#[inline]
pub fn either(number: u32, own: bool, other: bool) -> bool {
    let active = ACTIVE.get();
    if active == u32::MAX {
        note(number, if own == other { Reach::Same } else { Reach::Differs });
    }
    if active == number { other } else { own }
}

#[cold]
fn note(number: u32, reach: Reach) {
    REACHED.with_borrow_mut(|reached| {
        if let Some(known) = reached.get_mut(number as usize) {
            *known = reach.max(*known);
        }
    });
}

/// Puts a change in force in this thread; 0 for none.
pub fn set(number: u32) {
    ACTIVE.set(number);
}

/// Does `work` without a change; returns which of the changes up to `highest` it reached, by their number.
pub fn reached(highest: u32, work: impl FnOnce()) -> Vec<Reach> {
    REACHED.set(vec![Reach::Not; highest as usize + 1]);
    ACTIVE.set(u32::MAX);
    work();
    ACTIVE.set(0);
    REACHED.take()
}
