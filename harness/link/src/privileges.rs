//! Privileges of the process, and dropping them.

use crate::LinkError;

/// The number of CAP_NET_RAW, see `capabilities(7)`.
#[cfg(target_os = "linux")]
const RAW_SOCKETS: u32 = 13;
/// The number of CAP_DAC_OVERRIDE.
#[cfg(target_os = "linux")]
const WRITE_ALL_FILES: u32 = 1;
/// The number of CAP_IPC_LOCK.
#[cfg(target_os = "linux")]
const LOCK_MEMORY: u32 = 14;

/// The shell command that gives `program` the capabilities for a live bench.
pub fn how_to_grant(program: &str) -> String {
    format!("sudo setcap cap_net_raw,cap_sys_nice,cap_ipc_lock=ep {program}")
}

/// Whether this process may open raw sockets.
#[cfg(target_os = "linux")]
pub fn has_raw_sockets() -> bool {
    has(RAW_SOCKETS)
}

/// Whether this process may lock any amount of memory (CAP_IPC_LOCK).
#[cfg(target_os = "linux")]
pub(crate) fn may_lock_memory() -> bool {
    has(LOCK_MEMORY)
}

#[cfg(target_os = "linux")]
fn has(capability: u32) -> bool {
    effective("/proc/thread-self/status").is_some_and(|set| set >> capability & 1 == 1)
}

/// Returns true: on systems other than Linux only opening a raw socket shows whether it is allowed.
#[cfg(not(target_os = "linux"))]
pub fn has_raw_sockets() -> bool {
    true
}

/// Drops all privileges beyond those of the user for good; open sockets and files stay usable.
///
/// Under `sudo` all threads of the process change to the user who called `sudo`. Otherwise the calling thread, and those that it
/// starts later, drop their capabilities. It is an error if another thread still holds capabilities, so call this before
/// starting threads. Two capabilities stay: CAP_IPC_LOCK, because locked memory cannot grow without it, and, in a process
/// started by root, CAP_DAC_OVERRIDE, to write reports anywhere.
#[cfg(target_os = "linux")]
pub fn drop() -> Result<(), LinkError> {
    use crate::sys::process::{become_user, effective_user, keep_capabilities, unlock_limited_memory};

    let cannot = |error: std::io::Error| {
        LinkError::Unusable(format!("the privileges of this process cannot be dropped: {error}; run it without them"))
    };
    let root = effective_user() == 0;
    if root
        && let Some((user, group)) = caller()
        && become_user(user, group).is_ok()
    {
        unlock_limited_memory().map_err(cannot)?;
        return verify(0);
    }
    let keep = 1 << LOCK_MEMORY | if root { 1 << WRITE_ALL_FILES } else { 0 };
    keep_capabilities(keep).map_err(cannot)?;
    verify(keep)
}

/// Does nothing: systems other than Linux have no capabilities that could be dropped one by one.
#[cfg(not(target_os = "linux"))]
pub fn drop() -> Result<(), LinkError> {
    Ok(())
}

/// User and group of the caller of `sudo`, unless that is root.
#[cfg(target_os = "linux")]
fn caller() -> Option<(u32, u32)> {
    let number = |name| std::env::var(name).ok()?.parse().ok();
    let (user, group) = (number("SUDO_UID")?, number("SUDO_GID")?);
    (user != 0).then_some((user, group))
}

/// Fails if a thread of this process has capabilities beyond `keep`.
#[cfg(target_os = "linux")]
fn verify(keep: u64) -> Result<(), LinkError> {
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let mut in_force = threads.filter_map(|thread| effective(thread.path().join("status")));
    if in_force.any(|set| set & !keep != 0) {
        let why = "a thread of this process keeps its privileges: drop them before starting threads";
        return Err(LinkError::Unusable(why.to_string()));
    }
    Ok(())
}

/// The effective capabilities (CapEff) in the `/proc` file `status` of a thread.
#[cfg(target_os = "linux")]
fn effective(status: impl AsRef<std::path::Path>) -> Option<u64> {
    let text = std::fs::read_to_string(status).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("CapEff:"))?;
    u64::from_str_radix(line.trim(), 16).ok()
}
