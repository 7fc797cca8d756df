//! Private networks for tests: a network namespace with its own interfaces.

use std::process::Command;

use crate::Clock;
use crate::sys::pause;
use station::{Duration, Time};

/// How long two interfaces may take to detect that they are connected.
const FIND_EACH_OTHER: Duration = Duration::from_secs(5);
/// How often [`veth`] checks whether they have.
const CHECK_AGAIN: Duration = Duration::from_millis(5);

/// Moves the calling thread, and the threads and processes that it starts from now on, into a new network namespace.
///
/// This needs root or `unshare -rn`; the error says so. The namespace ends with its last process.
#[cfg(target_os = "linux")]
pub fn enter_private_network() -> Result<(), String> {
    crate::sys::process::private_network().map_err(|error| {
        format!("a network namespace needs root ({error}): run the tests as root or under `unshare -rn`")
    })?;
    // IPv6 announcements of the interfaces would be counted as traffic of the test. Old kernels may lack the file.
    let _ = std::fs::write("/proc/sys/net/ipv6/conf/default/disable_ipv6", "1");
    run(&["link", "set", "lo", "up"])
}

/// Fails: network namespaces exist only on Linux.
#[cfg(not(target_os = "linux"))]
pub fn enter_private_network() -> Result<(), String> {
    Err("network namespaces exist only on Linux".to_string())
}

/// Creates two interfaces `a` and `b` that are connected to each other, both up and with carrier.
pub fn veth(a: &str, b: &str) -> Result<(), String> {
    run(&["link", "add", a, "type", "veth", "peer", "name", b])?;
    run(&["link", "set", a, "up"])?;
    run(&["link", "set", b, "up"])?;
    let clock = Clock::start();
    while crate::interfaces().iter().filter(|known| (known.name == a || known.name == b) && known.running).count() < 2 {
        if clock.now() > Time::ZERO + FIND_EACH_OTHER {
            return Err(format!("{a} and {b} have no carrier after {} s", FIND_EACH_OTHER.as_secs()));
        }
        pause(&clock, clock.now() + CHECK_AGAIN);
    }
    Ok(())
}

/// Runs the program `ip` with `arguments`.
pub fn run(arguments: &[&str]) -> Result<(), String> {
    let failed = |why: String| format!("`ip {}` failed: {why}", arguments.join(" "));
    let output = Command::new("ip").args(arguments).output().map_err(|error| failed(error.to_string()))?;
    if output.status.success() {
        Ok(())
    } else {
        Err(failed(String::from_utf8_lossy(&output.stderr).trim().to_string()))
    }
}
