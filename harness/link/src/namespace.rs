//! A private network for a test: an own set of interfaces that no other process sees.

use std::process::Command;

use crate::Clock;
use crate::sys::pause;
use station::{Duration, Time};

/// How long two interfaces may need to see that they are connected.
const FIND_EACH_OTHER: Duration = Duration::from_secs(5);

/// Gives the calling thread, and the threads and processes that it starts from now on, a network of its own.
///
/// That needs root or `unshare -rn`; the error says so. The network ends with the last who is in it.
#[cfg(target_os = "linux")]
pub fn enter_private_network() -> Result<(), String> {
    crate::sys::process::private_network().map_err(|error| {
        format!("a network of its own needs root ({error}): run the tests as root or under `unshare -rn`")
    })?;
    // Interfaces that announce themselves would be counted as traffic of the test. An old kernel may lack the file.
    let _ = std::fs::write("/proc/sys/net/ipv6/conf/default/disable_ipv6", "1");
    run(&["link", "set", "lo", "up"])
}

/// Elsewhere than on Linux there are no private networks.
#[cfg(not(target_os = "linux"))]
pub fn enter_private_network() -> Result<(), String> {
    Err("a network of its own is to be had on Linux only".to_string())
}

/// Makes two interfaces `a` and `b` that are connected to each other, both up and with their carrier found.
pub fn veth(a: &str, b: &str) -> Result<(), String> {
    run(&["link", "add", a, "type", "veth", "peer", "name", b])?;
    run(&["link", "set", a, "up"])?;
    run(&["link", "set", b, "up"])?;
    let clock = Clock::start();
    while crate::interfaces().iter().filter(|known| (known.name == a || known.name == b) && known.running).count() < 2 {
        if clock.now() > Time::ZERO + FIND_EACH_OTHER {
            return Err(format!("{a} and {b} do not find each other"));
        }
        pause(&clock, clock.now() + Duration::from_millis(5));
    }
    Ok(())
}

/// Runs the program `ip` with `arguments`.
pub fn run(arguments: &[&str]) -> Result<(), String> {
    let said = |why: String| format!("`ip {}` did not work: {why}", arguments.join(" "));
    let output = Command::new("ip").args(arguments).output().map_err(|error| said(error.to_string()))?;
    if output.status.success() { Ok(()) } else { Err(said(String::from_utf8_lossy(&output.stderr).trim().to_string())) }
}
