//! Being on time: scheduling before others, memory that stays in memory, timers without slack.

/// Makes the calling thread as punctual as the system permits and says in words what was granted and what was not.
///
/// It is called in the thread that drives the wire, before privileges are given up. Nothing of it is needed to work,
/// only to work at short cycles on a busy machine.
#[cfg(target_os = "linux")]
pub fn raise() -> Vec<String> {
    use crate::privileges::may_lock_memory;
    use crate::sys::process::{lift_memory_limit, lock_memory, schedule_first, timer_slack};

    /// Before all ordinary threads, behind the kernel's own.
    const PRIORITY: i32 = 40;
    let advice = "give it with `setcap`, or run as root";
    let mut told = Vec::new();
    told.push(match schedule_first(PRIORITY) {
        Ok(()) => format!("scheduled before ordinary processes (SCHED_FIFO, priority {PRIORITY})"),
        Err(error) => format!("scheduled like any other process, as CAP_SYS_NICE is missing ({error}): {advice}"),
    });
    // Below a limit, asking for memory would fail later, in the middle of a run.
    told.push(if lift_memory_limit().is_ok() || may_lock_memory() {
        match lock_memory() {
            Ok(()) => "memory locked".to_string(),
            Err(error) => format!("memory not locked ({error})"),
        }
    } else {
        format!("memory not locked, as CAP_IPC_LOCK is missing: {advice}")
    });
    if let Err(error) = timer_slack(1) {
        told.push(format!("timers may run out up to 50 µs late ({error})"));
    }
    told
}

/// Elsewhere than on Linux nothing is changed.
#[cfg(not(target_os = "linux"))]
pub fn raise() -> Vec<String> {
    vec!["scheduled like any other process: on this system nothing else is known".to_string()]
}
