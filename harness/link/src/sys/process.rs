//! Scheduling, memory, privileges and the private network of a process.

use std::io;

fn checked(result: libc::c_int) -> io::Result<()> {
    if result == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

/// Schedules the calling thread before all ordinary ones, at `priority` from 1 to 99; what it starts is ordinary again.
pub fn schedule_first(priority: i32) -> io::Result<()> {
    let parameters = libc::sched_param { sched_priority: priority };
    // SAFETY: `parameters` lives through the call; 0 means the calling thread.
    checked(unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK, &raw const parameters) })
}

/// Lets the timers of the calling thread run out when they are due and not up to `nanoseconds` later.
pub fn timer_slack(nanoseconds: libc::c_ulong) -> io::Result<()> {
    // SAFETY: no memory is handed over.
    checked(unsafe { libc::prctl(libc::PR_SET_TIMERSLACK, nanoseconds) })
}

/// Lifts the limit of locked memory, so that memory which is asked for later can be locked too.
pub fn lift_memory_limit() -> io::Result<()> {
    let all = libc::rlimit { rlim_cur: libc::RLIM_INFINITY, rlim_max: libc::RLIM_INFINITY };
    // SAFETY: `all` lives through the call.
    checked(unsafe { libc::setrlimit(libc::RLIMIT_MEMLOCK, &raw const all) })
}

/// Keeps the memory of the process from being paged out, also what it asks for later.
pub fn lock_memory() -> io::Result<()> {
    // SAFETY: no memory is handed over.
    checked(unsafe { libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) })
}

/// Lets the memory of the process be paged out again, unless all of it may be locked without a privilege.
///
/// Beyond a limit, locked memory that grows, a stack for one, is an error.
pub fn unlock_limited_memory() -> io::Result<()> {
    let mut limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: `limit` lives through the call.
    checked(unsafe { libc::getrlimit(libc::RLIMIT_MEMLOCK, &raw mut limit) })?;
    if limit.rlim_cur == libc::RLIM_INFINITY {
        return Ok(());
    }
    // SAFETY: no memory is handed over.
    checked(unsafe { libc::munlockall() })
}

/// Gives the calling thread a network of its own, which has nothing but a loopback interface that is down.
pub fn private_network() -> io::Result<()> {
    // SAFETY: no memory is handed over; no other thread is concerned.
    checked(unsafe { libc::unshare(libc::CLONE_NEWNET) })
}

/// The user that the process acts as.
pub fn effective_user() -> libc::uid_t {
    // SAFETY: always succeeds, no memory is handed over.
    unsafe { libc::geteuid() }
}

/// Becomes the user `user` of the group `group`, in all threads and for good.
pub fn become_user(user: libc::uid_t, group: libc::gid_t) -> io::Result<()> {
    // SAFETY: `group` lives through the call and is one entry; the others hand no memory over.
    unsafe {
        checked(libc::setgroups(1, &raw const group))?;
        checked(libc::setresgid(group, group, group))?;
        checked(libc::setresuid(user, user, user))
    }
}

/// Version 3 of the structures below, of two words of 32 bits for each set.
const VERSION: u32 = 0x2008_0522;

#[repr(C)]
struct Head {
    version: u32,
    process: libc::c_int,
}

#[repr(C)]
#[derive(Clone, Copy, Default)]
struct Sets {
    effective: u32,
    permitted: u32,
    inheritable: u32,
}

/// Keeps of the capabilities of the calling thread those in `kept`, one bit for each; it has none that it had not.
pub fn keep_capabilities(kept: u64) -> io::Result<()> {
    let mut head = Head { version: VERSION, process: 0 };
    let mut sets = [Sets::default(); 2];
    // SAFETY: `head` and `sets` are what version 3 of the call takes, and they live through it.
    if unsafe { libc::syscall(libc::SYS_capget, &raw mut head, sets.as_mut_ptr()) } != 0 {
        return Err(io::Error::last_os_error());
    }
    for (set, mask) in sets.iter_mut().zip([kept as u32, (kept >> 32) as u32]) {
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
