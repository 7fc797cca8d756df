//! Scheduling, memory, privileges and the network namespace of a process.

use std::io;

fn checked(result: libc::c_int) -> io::Result<()> {
    if result == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

/// Sets the calling thread to SCHED_FIFO with `priority` 1 to 99; threads and processes that it starts do not inherit it.
pub fn schedule_first(priority: i32) -> io::Result<()> {
    // The function of musl refuses every policy, so this is the system call, whose structure holds the priority alone.
    let parameters: libc::c_int = priority;
    let policy = libc::c_long::from(libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK);
    let this_thread: libc::c_long = 0;
    // SAFETY: `parameters` lives through the call.
    let result = unsafe { libc::syscall(libc::SYS_sched_setscheduler, this_thread, policy, &raw const parameters) };
    if result == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

/// Whether the calling thread has SCHED_FIFO.
pub fn is_scheduled_first() -> bool {
    let this_thread: libc::c_long = 0;
    // SAFETY: no memory is passed.
    let policy = unsafe { libc::syscall(libc::SYS_sched_getscheduler, this_thread) };
    policy & !libc::c_long::from(libc::SCHED_RESET_ON_FORK) == libc::c_long::from(libc::SCHED_FIFO)
}

/// Sets the timer slack of the calling thread: its timers expire at most `nanoseconds` late.
pub fn timer_slack(nanoseconds: libc::c_ulong) -> io::Result<()> {
    // SAFETY: no memory is passed.
    checked(unsafe { libc::prctl(libc::PR_SET_TIMERSLACK, nanoseconds) })
}

/// Removes the limit of locked memory, so that memory allocated later can be locked too.
pub fn lift_memory_limit() -> io::Result<()> {
    let all = libc::rlimit { rlim_cur: libc::RLIM_INFINITY, rlim_max: libc::RLIM_INFINITY };
    // SAFETY: `all` lives through the call.
    checked(unsafe { libc::setrlimit(libc::RLIMIT_MEMLOCK, &raw const all) })
}

/// Locks the present and future memory of the process against paging.
pub fn lock_memory() -> io::Result<()> {
    // SAFETY: no memory is passed.
    checked(unsafe { libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) })
}

/// Unlocks the memory of the process, unless the limit of locked memory is infinite.
///
/// With a limit, locked memory cannot grow beyond it: growth, for instance of a stack, would fail.
pub fn unlock_limited_memory() -> io::Result<()> {
    let mut limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: `limit` lives through the call.
    checked(unsafe { libc::getrlimit(libc::RLIMIT_MEMLOCK, &raw mut limit) })?;
    if limit.rlim_cur == libc::RLIM_INFINITY {
        return Ok(());
    }
    // SAFETY: no memory is passed.
    checked(unsafe { libc::munlockall() })
}

/// Moves the calling thread into a new network namespace, which has only a loopback interface that is down.
pub fn private_network() -> io::Result<()> {
    // SAFETY: no memory is passed; no other thread is concerned.
    checked(unsafe { libc::unshare(libc::CLONE_NEWNET) })
}

/// The effective user of the process.
pub fn effective_user() -> libc::uid_t {
    // SAFETY: always succeeds, no memory is passed.
    unsafe { libc::geteuid() }
}

/// Changes to the user `user` and the group `group`, in all threads and for good.
pub fn become_user(user: libc::uid_t, group: libc::gid_t) -> io::Result<()> {
    // SAFETY: `group` lives through the call and is one entry; the other calls pass no memory.
    unsafe {
        checked(libc::setgroups(1, &raw const group))?;
        checked(libc::setresgid(group, group, group))?;
        checked(libc::setresuid(user, user, user))
    }
}

/// _LINUX_CAPABILITY_VERSION_3: two 32-bit words for each set of capabilities.
const VERSION: u32 = 0x2008_0522;

#[repr(C)]
struct CapabilityHeader {
    version: u32,
    process: libc::c_int,
}

#[repr(C)]
#[derive(Clone, Copy, Default)]
struct CapabilitySets {
    effective: u32,
    permitted: u32,
    inheritable: u32,
}

/// Drops all capabilities of the calling thread that are not in the bit mask `keep`; adds none.
pub fn keep_capabilities(keep: u64) -> io::Result<()> {
    let mut head = CapabilityHeader { version: VERSION, process: 0 };
    let mut sets = [CapabilitySets::default(); 2];
    // SAFETY: `head` and `sets` are what version 3 of the call takes, and they live through it.
    if unsafe { libc::syscall(libc::SYS_capget, &raw mut head, sets.as_mut_ptr()) } != 0 {
        return Err(io::Error::last_os_error());
    }
    for (set, mask) in sets.iter_mut().zip([keep as u32, (keep >> 32) as u32]) {
        set.permitted &= mask;
        set.effective &= set.permitted;
        set.inheritable = 0;
    }
    // SAFETY: as above; the kernel only reads `sets`.
    if unsafe { libc::syscall(libc::SYS_capset, &raw mut head, sets.as_ptr()) } != 0 {
        return Err(io::Error::last_os_error());
    }
    Ok(())
}
