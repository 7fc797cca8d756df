//! Whether this host had enough processors for a device that runs on it, a program or a virtual machine beside the harness.

use station::{Duration, Time};

/// The share of a time, as one of so many parts, for which programs may wait for a processor without saying anything.
const UNREMARKABLE: u32 = 10;

/// How long programs of this host waited for a processor, as Linux counts it (`/proc/pressure/cpu`, `some`).
#[derive(Clone, Debug, Default)]
pub struct ProcessorShortage {
    /// What was counted at the begin; `None` if nothing is to be measured.
    begin: Option<Duration>,
}

impl ProcessorShortage {
    /// Begins to measure, if this thread has to share a processor with others: where it has real-time scheduling, so has its device.
    pub fn begin() -> ProcessorShortage {
        ProcessorShortage { begin: if crate::realtime::is_first() { None } else { waited() } }
    }

    /// How long programs waited in the time `passed` since the begin; `None` if it is at most a tenth of it, or not known.
    pub fn within(&self, passed: Time) -> Option<Duration> {
        let passed = passed.since(Time::ZERO);
        let shortage = waited()?.saturating_sub(self.begin?);
        (shortage * UNREMARKABLE > passed).then_some(shortage)
    }
}

/// What the kernel has counted since its start.
fn waited() -> Option<Duration> {
    counted(&std::fs::read_to_string("/proc/pressure/cpu").ok()?)
}

/// The microseconds of `total` in the line `some`.
fn counted(text: &str) -> Option<Duration> {
    let line = text.lines().find(|line| line.starts_with("some "))?;
    let total = line.split_ascii_whitespace().find_map(|word| word.strip_prefix("total="))?;
    Some(Duration::from_micros(total.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    /// Both lines are as `Documentation/accounting/psi.rst` of the kernel shows them.
    #[rstest]
    #[case(
        "some avg10=87.16 avg60=85.91 avg300=92.63 total=44248829675\nfull avg10=0.00 avg60=0.00 avg300=0.00 total=0\n",
        Some(44_248_829_675)
    )]
    #[case("full avg10=0.00 avg60=0.00 avg300=0.00 total=7\n", None)]
    #[case("some avg10=0.00 total=many\n", None)]
    #[case("", None)]
    fn the_counter_is_read(#[case] text: &str, #[case] expected: Option<u64>) {
        assert_eq!(counted(text), expected.map(Duration::from_micros));
    }

    #[test]
    fn nothing_measured_says_nothing() {
        assert_eq!(ProcessorShortage::default().within(Time::ZERO + Duration::from_secs(1)), None);
    }

    /// What was counted since the start of the host is more than a tenth of a nanosecond and less than a tenth of all time.
    #[test]
    fn a_tenth_is_unremarkable() {
        let since_start = ProcessorShortage { begin: waited().map(|_| Duration::ZERO) };
        let counted = waited();
        assert_eq!(since_start.within(Time::from_nanos(1)).is_some(), counted.is_some_and(|time| !time.is_zero()));
        assert_eq!(since_start.within(Time::from_nanos(u64::MAX)), None);
    }
}
