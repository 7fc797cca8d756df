//! What may send frames at an interface that is only listened at: its addresses and routes, and how many frames it has transmitted.

use crate::interfaces::escaped;
use std::fs;
use std::net::IpAddr;

/// How many frames the interface has transmitted since it exists, whoever sent them; `None` if the system does not say.
pub fn transmitted_frames(interface: &str) -> Option<u64> {
    // Name, then eight columns about receiving; then bytes and packets transmitted.
    const PACKETS: usize = 9;
    let table = fs::read_to_string("/proc/thread-self/net/dev").ok()?;
    let row = table.lines().find_map(|line| line.trim().strip_prefix(interface)?.strip_prefix(':'))?;
    row.split_whitespace().nth(PACKETS)?.parse().ok()
}

/// Why the host may send frames of its own at the interface, one sentence each; empty if nothing is known that could.
pub fn why_it_may_transmit(interface: &str) -> Vec<String> {
    let label = escaped(interface);
    let addresses: Vec<IpAddr> = addresses(interface);
    let mut why = Vec::new();
    let list = |is_wanted: fn(&IpAddr) -> bool| {
        addresses.iter().filter(|of| is_wanted(of)).map(IpAddr::to_string).collect::<Vec<_>>().join(", ")
    };
    let fourth = list(IpAddr::is_ipv4);
    if !fourth.is_empty() {
        why.push(format!(
            "{label} has the address {fourth}: the host answers ARP and may send; remove it with `ip address flush dev {label}`"
        ));
    }
    let sixth = list(IpAddr::is_ipv6);
    let is_disabled = fs::read_to_string(format!("/proc/sys/net/ipv6/conf/{interface}/disable_ipv6"));
    if !sixth.is_empty() || is_disabled.is_ok_and(|text| text.trim() == "0") {
        why.push(format!(
            "IPv6 is enabled at {label}: the host sends router solicitations and group reports; switch it off with \
             `sysctl net.ipv6.conf.{label}.disable_ipv6=1`"
        ));
    }
    let routes = fs::read_to_string("/proc/thread-self/net/route").unwrap_or_default();
    if routes.lines().any(|line| line.split_whitespace().next() == Some(interface)) {
        why.push(format!(
            "a route leads through {label}: the system log, hooks and collected metrics may use it; see `ip route show dev {label}`"
        ));
    }
    why
}

/// The IP addresses of the interface.
pub fn addresses(interface: &str) -> Vec<IpAddr> {
    let known = pnet_datalink::interfaces();
    let found = known.into_iter().find(|known| known.name == interface);
    found.map(|found| found.ips.iter().map(|of| of.ip()).collect()).unwrap_or_default()
}
