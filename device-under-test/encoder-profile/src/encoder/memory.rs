//! Memory that keeps its contents without power.

use core::time::Duration;
use station::Time;

/// One item of the non-volatile memory: what it holds, and what is being written to it.
///
/// A write takes time. Until it is done the old contents stand, so that a power failure in between leaves the old
/// contents and never a mixture.
#[derive(Clone, Debug)]
pub struct Cell<T> {
    stored: T,
    writing: Option<(T, Time)>,
    writes: u64,
}

/// How a write ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The new contents are safe.
    Written,
    /// The memory did not take them; the old contents stand.
    Failed,
}

impl<T> Cell<T> {
    /// A cell that holds `stored`.
    pub fn new(stored: T) -> Cell<T> {
        Cell { stored, writing: None, writes: 0 }
    }

    /// What is safe in memory.
    pub fn stored(&self) -> &T {
        &self.stored
    }

    /// Begins to write `value`, which takes `takes`; a write that was not yet done is given up.
    pub fn write(&mut self, now: Time, value: T, takes: Duration) {
        self.writing = Some((value, now + takes));
    }

    /// Writes `value` at once.
    pub fn replace(&mut self, value: T) {
        self.writing = None;
        self.stored = value;
        self.writes += 1;
    }

    /// Ends the write that is done by `now`, if there is one; a faulty memory takes nothing.
    pub fn settle(&mut self, now: Time, faulty: bool) -> Option<Outcome> {
        let (value, _) = self.writing.take_if(|(_, done)| *done <= now)?;
        if faulty {
            return Some(Outcome::Failed);
        }
        self.replace(value);
        Some(Outcome::Written)
    }

    /// When the write will be done, if there is one.
    pub fn deadline(&self) -> Option<Time> {
        self.writing.as_ref().map(|(_, done)| *done)
    }

    /// The supply has gone: what was being written is lost.
    pub fn power_down(&mut self) {
        self.writing = None;
    }

    /// How often contents were written.
    pub fn writes(&self) -> u64 {
        self.writes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Time = Time::from_nanos(5);
    const TAKES: Duration = Duration::from_nanos(10);

    #[test]
    fn a_write_is_safe_when_it_is_done_and_not_before() {
        let mut cell = Cell::new(1);
        cell.write(NOW, 2, TAKES);
        assert_eq!(cell.settle(Time::from_nanos(14), false), None);
        assert_eq!((*cell.stored(), cell.writes()), (1, 0));
        assert_eq!(cell.deadline(), Some(Time::from_nanos(15)));
        assert_eq!(cell.settle(Time::from_nanos(15), false), Some(Outcome::Written));
        assert_eq!((*cell.stored(), cell.writes(), cell.deadline()), (2, 1, None));
        assert_eq!(cell.settle(Time::from_nanos(16), false), None);
    }

    #[test]
    fn power_off_in_between_leaves_the_old_contents() {
        let mut cell = Cell::new(1);
        cell.write(NOW, 2, TAKES);
        cell.power_down();
        assert_eq!(cell.settle(Time::MAX, false), None);
        assert_eq!(*cell.stored(), 1);
    }

    #[test]
    fn a_faulty_memory_says_so_and_keeps_what_it_has() {
        let mut cell = Cell::new(1);
        cell.write(NOW, 2, TAKES);
        assert_eq!(cell.settle(Time::MAX, true), Some(Outcome::Failed));
        assert_eq!((*cell.stored(), cell.writes()), (1, 0));
    }

    #[test]
    fn the_last_of_two_writes_counts() {
        let mut cell = Cell::new(1);
        cell.write(NOW, 2, TAKES);
        cell.write(NOW + TAKES / 2, 3, TAKES);
        assert_eq!(cell.settle(NOW + TAKES, false), None);
        assert_eq!(cell.settle(NOW + TAKES * 2, false), Some(Outcome::Written));
        assert_eq!(*cell.stored(), 3);
    }
}
