//! The values of the last cycles, for data that wait in a buffer.

use alloc::collections::VecDeque;

/// Values of the present cycle and of some before it.
pub(super) struct LastCycles<T> {
    /// By how many cycles the data are old.
    pub cycles: usize,
    values: VecDeque<T>,
}

impl<T> Default for LastCycles<T> {
    fn default() -> Self {
        LastCycles { cycles: 0, values: VecDeque::new() }
    }
}

impl<T> LastCycles<T> {
    /// For data that are old by this number of cycles.
    pub fn of(cycles: usize) -> LastCycles<T> {
        LastCycles { cycles, ..LastCycles::default() }
    }

    /// Takes in the value of a cycle; returns that of `cycles` before, or the oldest one there is.
    pub fn oldest_with(&mut self, value: T) -> Option<&T> {
        self.values.push_back(value);
        while self.values.len() > self.cycles + 1 {
            self.values.pop_front();
        }
        self.values.front()
    }

    /// Drops the values for which `keep` is false.
    pub fn retain(&mut self, keep: impl FnMut(&T) -> bool) {
        self.values.retain(keep);
    }

    /// Drops all values.
    pub fn clear(&mut self) {
        self.values.clear();
    }
}
