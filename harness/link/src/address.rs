//! The address of a socket that carries Ethernet frames.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use thiserror::Error;

/// The address of a socket, and whether this side connects or listens.
///
/// Written as `HOST:PORT`, `/path` or `unix:/path` to connect, and with the prefix `listen:` to wait for the peer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum SocketAddress {
    /// TCP: host and port to connect to.
    Tcp(String),
    /// A Unix socket to connect to.
    Unix(PathBuf),
    /// TCP: host and port to listen on; port 0 selects any free port.
    ListenTcp(String),
    /// A Unix socket to listen on.
    ListenUnix(PathBuf),
}

/// The text is not a socket address.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{}` is not a socket address: write HOST:PORT or /path, with the prefix listen: to wait for the peer", .0.escape_debug())]
pub struct BadAddress(pub String);

impl SocketAddress {
    /// Whether this side listens for the peer.
    pub fn listens(&self) -> bool {
        matches!(self, SocketAddress::ListenTcp(_) | SocketAddress::ListenUnix(_))
    }
}

impl FromStr for SocketAddress {
    type Err = BadAddress;

    fn from_str(text: &str) -> Result<SocketAddress, BadAddress> {
        let (listens, target) = match text.strip_prefix("listen:") {
            Some(target) => (true, target),
            None => (false, text),
        };
        let path = match target.strip_prefix("unix:") {
            Some(path) if !path.is_empty() => Some(path),
            Some(_) => return Err(BadAddress(text.to_string())),
            None if target.starts_with(['/', '.']) => Some(target),
            None => None,
        };
        if let Some(path) = path {
            let path = PathBuf::from(path);
            return Ok(if listens { SocketAddress::ListenUnix(path) } else { SocketAddress::Unix(path) });
        }
        let port = match target.rsplit_once(':') {
            Some((host, port)) if is_host(host) => port.parse::<u16>().ok().filter(|port| listens || *port != 0),
            _ => None,
        };
        match port {
            None => Err(BadAddress(text.to_string())),
            Some(_) if listens => Ok(SocketAddress::ListenTcp(target.to_string())),
            Some(_) => Ok(SocketAddress::Tcp(target.to_string())),
        }
    }
}

/// Whether `host` is a name, an IPv4 address, or an IPv6 address in brackets.
fn is_host(host: &str) -> bool {
    let inner = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
    match inner {
        Some(inner) => inner.parse::<std::net::Ipv6Addr>().is_ok(),
        None => !host.is_empty() && host.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_')),
    }
}

/// Writes the form that [`FromStr`] reads.
impl fmt::Display for SocketAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SocketAddress::Tcp(target) => write!(f, "{target}"),
            SocketAddress::ListenTcp(target) => write!(f, "listen:{target}"),
            SocketAddress::Unix(path) => write!(f, "{}{}", prefix(path), path.display()),
            SocketAddress::ListenUnix(path) => write!(f, "listen:{}{}", prefix(path), path.display()),
        }
    }
}

/// The prefix `unix:` for a path that does not start with `/` or `.`.
fn prefix(path: &std::path::Path) -> &'static str {
    if path.to_string_lossy().starts_with(['/', '.']) { "" } else { "unix:" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    #[rstest]
    #[case("localhost:1234", SocketAddress::Tcp("localhost:1234".into()))]
    #[case("192.168.0.1:65535", SocketAddress::Tcp("192.168.0.1:65535".into()))]
    #[case("[::1]:1", SocketAddress::Tcp("[::1]:1".into()))]
    #[case("/run/qemu.sock", SocketAddress::Unix("/run/qemu.sock".into()))]
    #[case("./a b:1", SocketAddress::Unix("./a b:1".into()))]
    #[case("unix:wire", SocketAddress::Unix("wire".into()))]
    #[case("listen:0.0.0.0:0", SocketAddress::ListenTcp("0.0.0.0:0".into()))]
    #[case("listen:/run/x", SocketAddress::ListenUnix("/run/x".into()))]
    #[case("listen:unix:wire", SocketAddress::ListenUnix("wire".into()))]
    fn addresses_are_displayed_as_they_are_parsed(#[case] text: &str, #[case] address: SocketAddress) {
        assert_eq!(text.parse(), Ok(address.clone()));
        assert_eq!(address.to_string(), text);
        assert_eq!(address.listens(), text.starts_with("listen:"));
    }

    #[rstest]
    fn invalid_addresses_are_rejected(
        #[values(
            "",
            ":",
            ":1",
            "host",
            "host:",
            "host:0",
            "host:65536",
            "host:-1",
            "host:1:2",
            "a b:1",
            "unix:",
            "listen:",
            "listen:unix:",
            "listen:host",
            "listen:listen:h:1",
            "::1:80",
            "[::1",
            "[x]:1",
            "h\u{1b}[2J:1"
        )]
        text: &str,
    ) {
        let error = text.parse::<SocketAddress>().expect_err("not an address");
        assert_eq!(error, BadAddress(text.to_string()));
        assert!(!error.to_string().contains('\u{1b}'), "control characters are escaped");
    }
}
