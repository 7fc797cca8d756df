//! The network interfaces of the host.

/// A network interface and its state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InterfaceInfo {
    /// The name, for instance `eth0`.
    pub name: String,
    /// The MAC address; `None` if the interface has none.
    pub mac: Option<[u8; 6]>,
    /// Whether the interface is up (IFF_UP).
    pub up: bool,
    /// Whether a cable with a peer is plugged in (IFF_RUNNING).
    pub running: bool,
    /// Whether it is a loopback interface.
    pub loopback: bool,
}

/// Lists the network interfaces, in the order of their interface index.
pub fn interfaces() -> Vec<InterfaceInfo> {
    let mut found: Vec<_> = pnet_datalink::interfaces();
    found.sort_by_key(|interface| interface.index);
    let convert = |interface: pnet_datalink::NetworkInterface| InterfaceInfo {
        mac: interface.mac.map(|mac| mac.octets()),
        up: interface.is_up(),
        running: interface.is_running(),
        loopback: interface.is_loopback(),
        name: interface.name,
    };
    found.into_iter().map(convert).collect()
}

/// Lists the names of the Ethernet interfaces for an error message.
pub(crate) fn interface_names() -> String {
    let names: Vec<_> =
        interfaces().into_iter().filter(|known| !known.loopback).map(|known| escaped(&known.name)).collect();
    if names.is_empty() { "this host has none".to_string() } else { format!("the interfaces are {}", names.join(", ")) }
}

/// Escapes a name for output.
pub(crate) fn escaped(name: &str) -> String {
    name.escape_debug().to_string()
}
