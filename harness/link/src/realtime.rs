//! Real-time settings of a thread: SCHED_FIFO, locked memory, timers without slack.

/// The real-time settings that the system granted and refused, as lines of text.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct RealtimeSettings {
    /// The granted settings.
    pub granted: Vec<String>,
    /// The refused settings, each with the reason and what to do.
    pub refused: Vec<String>,
}

impl RealtimeSettings {
    fn add(&mut self, outcome: Result<String, String>) {
        match outcome {
            Ok(text) => self.granted.push(text),
            Err(text) => self.refused.push(text),
        }
    }
}

/// Applies the real-time settings that the system permits to the calling thread.
///
/// Call it in the thread that drives the wire, before dropping privileges. It is optional: only short cycles on a busy host
/// need it.
#[cfg(target_os = "linux")]
pub fn raise() -> RealtimeSettings {
    use crate::privileges::may_lock_memory;
    use crate::sys::process::{lift_memory_limit, lock_memory, schedule_first, timer_slack};

    /// Above all ordinary threads, below the threads of the kernel.
    const PRIORITY: i32 = 40;
    let advice = "grant it with `setcap`, or run as root";
    let mut outcome = RealtimeSettings::default();
    outcome.add(match schedule_first(PRIORITY) {
        Ok(()) => Ok(format!("real-time scheduling (SCHED_FIFO, priority {PRIORITY})")),
        Err(error) => Err(format!("no real-time scheduling, CAP_SYS_NICE is missing ({error}): {advice}")),
    });
    // Under a memory limit, an allocation would fail later, in the middle of a run.
    outcome.add(if lift_memory_limit().is_ok() || may_lock_memory() {
        match lock_memory() {
            Ok(()) => Ok("memory locked".to_string()),
            Err(error) => Err(format!("memory not locked ({error})")),
        }
    } else {
        Err(format!("memory not locked, CAP_IPC_LOCK is missing: {advice}"))
    });
    if let Err(error) = timer_slack(1) {
        outcome.add(Err(format!("timers may expire up to 50 µs late ({error})")));
    }
    outcome
}

/// Whether the calling thread is scheduled before all ordinary ones.
#[cfg(target_os = "linux")]
pub fn is_first() -> bool {
    crate::sys::process::is_scheduled_first()
}

/// Returns false: only implemented on Linux.
#[cfg(not(target_os = "linux"))]
pub fn is_first() -> bool {
    false
}

/// Schedules the calling thread before all ordinary ones, but after those that drive a wire; the error says what is missing.
#[cfg(target_os = "linux")]
pub fn schedule_listener() -> Result<(), String> {
    /// Below the priority of [`raise`].
    const PRIORITY: i32 = 10;
    crate::sys::process::schedule_first(PRIORITY).map_err(|error| {
        format!("no real-time scheduling, CAP_SYS_NICE is missing ({error}): grant it with `setcap`, or run as root")
    })
}

/// Fails: only implemented on Linux.
#[cfg(not(target_os = "linux"))]
pub fn schedule_listener() -> Result<(), String> {
    Err("no real-time scheduling: only implemented on Linux".to_string())
}

/// Changes nothing: only implemented on Linux.
#[cfg(not(target_os = "linux"))]
pub fn raise() -> RealtimeSettings {
    let refused = vec!["no real-time scheduling: only implemented on Linux".to_string()];
    RealtimeSettings { refused, ..RealtimeSettings::default() }
}
