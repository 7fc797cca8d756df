//! The change that is in force in this thread, and which changes the thread has reached.

use std::cell::{Cell, RefCell};

thread_local! {
    static ACTIVE: Cell<u32> = const { Cell::new(0) };
    static REACHED: RefCell<Option<Vec<bool>>> = const { RefCell::new(None) };
}

/// Whether the change `number`, from 1, is in force. The changed code calls it at each place.
#[inline]
pub fn on(number: u32) -> bool {
    let active = ACTIVE.get();
    if active == u32::MAX {
        REACHED.with_borrow_mut(|reached| {
            if let Some(place) = reached.as_mut().and_then(|reached| reached.get_mut(number as usize)) {
                *place = true;
            }
        });
    }
    active == number
}

/// Puts a change in force in this thread; 0 for none.
pub fn set(number: u32) {
    ACTIVE.set(number);
}

/// Does `work` without a change; returns the changes up to `highest` whose places it reached.
pub fn reached(highest: u32, work: impl FnOnce()) -> Vec<u32> {
    REACHED.set(Some(vec![false; highest as usize + 1]));
    ACTIVE.set(u32::MAX);
    work();
    ACTIVE.set(0);
    let reached = REACHED.take().unwrap_or_default();
    (0..).zip(reached).filter(|(_, is_reached)| *is_reached).map(|(number, _)| number).collect()
}
