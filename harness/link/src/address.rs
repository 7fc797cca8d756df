//! Where a socket is that carries frames.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use thiserror::Error;

/// Where a socket is, and which side calls the other.
///
/// Written as `HOST:PORT`, `/path` or `unix:/path` to connect, and with `listen:` in front to wait for the peer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum SocketAddress {
    /// TCP: host and port to connect to.
    Tcp(String),
    /// A Unix socket to connect to.
    Unix(PathBuf),
    /// TCP: host and port to wait at; port 0 takes any free one.
    ListenTcp(String),
    /// A Unix socket to wait at.
    ListenUnix(PathBuf),
}

/// A text that is no address of a socket.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{}` is no address of a socket: write HOST:PORT or /path, with listen: in front to wait for the peer", .0.escape_debug())]
pub struct BadAddress(pub String);

impl SocketAddress {
    /// Whether this side waits for the other.
    pub fn listens(&self) -> bool {
        matches!(self, SocketAddress::ListenTcp(_) | SocketAddress::ListenUnix(_))
    }
}

impl FromStr for SocketAddress {
    type Err = BadAddress;

    fn from_str(text: &str) -> Result<SocketAddress, BadAddress> {
        let (listens, place) = match text.strip_prefix("listen:") {
            Some(place) => (true, place),
            None => (false, text),
        };
        let path = match place.strip_prefix("unix:") {
            Some(path) if !path.is_empty() => Some(path),
            Some(_) => return Err(BadAddress(text.to_string())),
            None if place.starts_with(['/', '.']) => Some(place),
            None => None,
        };
        if let Some(path) = path {
            let path = PathBuf::from(path);
            return Ok(if listens { SocketAddress::ListenUnix(path) } else { SocketAddress::Unix(path) });
        }
        let port = match place.rsplit_once(':') {
            Some((host, port)) if is_host(host) => port.parse::<u16>().ok().filter(|port| listens || *port != 0),
            _ => None,
        };
        match port {
            None => Err(BadAddress(text.to_string())),
            Some(_) if listens => Ok(SocketAddress::ListenTcp(place.to_string())),
            Some(_) => Ok(SocketAddress::Tcp(place.to_string())),
        }
    }
}

/// A name, an IPv4 address, or an IPv6 address in brackets.
fn is_host(host: &str) -> bool {
    let inner = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
    match inner {
        Some(inner) => inner.parse::<std::net::Ipv6Addr>().is_ok(),
        None => !host.is_empty() && host.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_')),
    }
}

/// As it is read.
impl fmt::Display for SocketAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SocketAddress::Tcp(place) => write!(f, "{place}"),
            SocketAddress::ListenTcp(place) => write!(f, "listen:{place}"),
            SocketAddress::Unix(path) => write!(f, "{}{}", prefix(path), path.display()),
            SocketAddress::ListenUnix(path) => write!(f, "listen:{}{}", prefix(path), path.display()),
        }
    }
}

/// A path that does not look like one says that it is one.
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
    fn addresses_are_read_and_shown_alike(#[case] text: &str, #[case] address: SocketAddress) {
        assert_eq!(text.parse(), Ok(address.clone()));
        assert_eq!(address.to_string(), text);
        assert_eq!(address.listens(), text.starts_with("listen:"));
    }

    #[rstest]
    fn what_is_no_address_is_refused(
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
        let error = text.parse::<SocketAddress>().expect_err("it is none");
        assert_eq!(error, BadAddress(text.to_string()));
        assert!(!error.to_string().contains('\u{1b}'), "nothing reaches the terminal as it is");
    }
}
