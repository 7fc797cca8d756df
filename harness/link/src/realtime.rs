//! Being on time: scheduling before others, memory that stays in memory, timers without slack.

/// What the system granted of real-time scheduling, in words.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Punctuality {
    /// What was granted.
    pub granted: Vec<String>,
    /// What was refused, each with the reason and what to do.
    pub refused: Vec<String>,
}

impl Punctuality {
    fn add(&mut self, outcome: Result<String, String>) {
        match outcome {
            Ok(text) => self.granted.push(text),
            Err(text) => self.refused.push(text),
        }
    }
}

/// Makes the calling thread as punctual as the system permits.
///
/// It is called in the thread that drives the wire, before privileges are given up. Nothing of it is needed to work,
/// only to work at short cycles on a busy machine.
#[cfg(target_os = "linux")]
pub fn raise() -> Punctuality {
    use crate::privileges::may_lock_memory;
    use crate::sys::process::{lift_memory_limit, lock_memory, schedule_first, timer_slack};

    /// Before all ordinary threads, behind the kernel's own.
    const PRIORITY: i32 = 40;
    let advice = "give it with `setcap`, or run as root";
    let mut outcome = Punctuality::default();
    outcome.add(match schedule_first(PRIORITY) {
        Ok(()) => Ok(format!("scheduled before ordinary processes (SCHED_FIFO, priority {PRIORITY})")),
        Err(error) => Err(format!("scheduled like any other process, as CAP_SYS_NICE is missing ({error}): {advice}")),
    });
    // Below a limit, asking for memory would fail later, in the middle of a run.
    outcome.add(if lift_memory_limit().is_ok() || may_lock_memory() {
        match lock_memory() {
            Ok(()) => Ok("memory locked".to_string()),
            Err(error) => Err(format!("memory not locked ({error})")),
        }
    } else {
        Err(format!("memory not locked, as CAP_IPC_LOCK is missing: {advice}"))
    });
    if let Err(error) = timer_slack(1) {
        outcome.add(Err(format!("timers may run out up to 50 µs late ({error})")));
    }
    outcome
}

/// Elsewhere than on Linux nothing is changed.
#[cfg(not(target_os = "linux"))]
pub fn raise() -> Punctuality {
    let refused =
        vec!["scheduled like any other process: encspec knows real-time scheduling on Linux only".to_string()];
    Punctuality { refused, ..Punctuality::default() }
}
