//! The network interfaces of the machine.

/// A network interface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Interface {
    /// Its name, for instance `eth0`.
    pub name: String,
    /// Its MAC address, if it has one.
    pub mac: Option<[u8; 6]>,
    /// Whether it is switched on.
    pub up: bool,
    /// Whether something is plugged in.
    pub running: bool,
    /// Whether it leads back to this machine.
    pub loopback: bool,
}

/// The network interfaces that there are, in the order in which the machine numbers them.
pub fn interfaces() -> Vec<Interface> {
    let mut found: Vec<_> = pnet_datalink::interfaces();
    found.sort_by_key(|interface| interface.index);
    let to_ours = |interface: pnet_datalink::NetworkInterface| Interface {
        mac: interface.mac.map(|mac| mac.octets()),
        up: interface.is_up(),
        running: interface.is_running(),
        loopback: interface.is_loopback(),
        name: interface.name,
    };
    found.into_iter().map(to_ours).collect()
}

/// The names of the Ethernet interfaces, for a message that says which ones there are.
pub(crate) fn known_names() -> String {
    let names: Vec<_> =
        interfaces().into_iter().filter(|known| !known.loopback).map(|known| escaped(&known.name)).collect();
    if names.is_empty() { "this machine has none".to_string() } else { format!("there are {}", names.join(", ")) }
}

/// A name that is not ours, fit to be shown.
pub(crate) fn escaped(name: &str) -> String {
    name.escape_debug().to_string()
}
