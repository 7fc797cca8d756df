//! Non-volatile memory.

use core::time::Duration;
use station::Time;

/// One item of non-volatile memory: the stored value, and the value that is being written.
///
/// A write takes time. Until it is complete, the old value is valid: a power failure during a write keeps the old
/// value and never mixes both.
#[derive(Clone, Debug)]
pub struct NvmCell<T> {
    stored: T,
    writing: Option<(T, Time)>,
    writes: u64,
}

/// How a write ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteOutcome {
    /// The new value is stored.
    Written,
    /// The memory refused the new value; the old one is still valid.
    Failed,
}

impl<T> NvmCell<T> {
    /// A cell that holds `stored`.
    pub fn new(stored: T) -> NvmCell<T> {
        NvmCell { stored, writing: None, writes: 0 }
    }

    /// The stored value.
    pub fn stored(&self) -> &T {
        &self.stored
    }

    /// Starts to write `value`; the write takes `takes`. A running write is cancelled.
    pub fn write(&mut self, now: Time, value: T, takes: Duration) {
        self.writing = Some((value, now + takes));
    }

    /// Writes `value` at once.
    pub fn replace(&mut self, value: T) {
        self.writing = None;
        self.stored = value;
        self.writes += 1;
    }

    /// Completes the write that ends by `now`, if there is one. With a `faulty` memory it fails.
    pub fn settle(&mut self, now: Time, faulty: bool) -> Option<WriteOutcome> {
        let (value, _) = self.writing.take_if(|(_, done)| *done <= now)?;
        if faulty {
            return Some(WriteOutcome::Failed);
        }
        self.replace(value);
        Some(WriteOutcome::Written)
    }

    /// When the running write completes, if there is one.
    pub fn deadline(&self) -> Option<Time> {
        self.writing.as_ref().map(|(_, done)| *done)
    }

    /// The supply failed: a running write is lost.
    pub fn power_down(&mut self) {
        self.writing = None;
    }

    /// Number of completed writes.
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
    fn a_write_is_stored_when_it_is_complete() {
        let mut cell = NvmCell::new(1);
        cell.write(NOW, 2, TAKES);
        assert_eq!(cell.settle(Time::from_nanos(14), false), None);
        assert_eq!((*cell.stored(), cell.writes()), (1, 0));
        assert_eq!(cell.deadline(), Some(Time::from_nanos(15)));
        assert_eq!(cell.settle(Time::from_nanos(15), false), Some(WriteOutcome::Written));
        assert_eq!((*cell.stored(), cell.writes(), cell.deadline()), (2, 1, None));
        assert_eq!(cell.settle(Time::from_nanos(16), false), None);
    }

    #[test]
    fn a_power_failure_during_a_write_keeps_the_old_value() {
        let mut cell = NvmCell::new(1);
        cell.write(NOW, 2, TAKES);
        cell.power_down();
        assert_eq!(cell.settle(Time::MAX, false), None);
        assert_eq!(*cell.stored(), 1);
    }

    #[test]
    fn a_write_to_a_faulty_memory_fails_and_keeps_the_old_value() {
        let mut cell = NvmCell::new(1);
        cell.write(NOW, 2, TAKES);
        assert_eq!(cell.settle(Time::MAX, true), Some(WriteOutcome::Failed));
        assert_eq!((*cell.stored(), cell.writes()), (1, 0));
    }

    #[test]
    fn a_second_write_cancels_the_first_one() {
        let mut cell = NvmCell::new(1);
        cell.write(NOW, 2, TAKES);
        cell.write(NOW + TAKES / 2, 3, TAKES);
        assert_eq!(cell.settle(NOW + TAKES, false), None);
        assert_eq!(cell.settle(NOW + TAKES * 2, false), Some(WriteOutcome::Written));
        assert_eq!(*cell.stored(), 3);
    }
}
