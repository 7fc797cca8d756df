//! The system log (`syslog(3)`), through its Unix datagram socket.

use std::io;
use std::os::unix::net::UnixDatagram;
use std::path::Path;

/// The facility `daemon` of RFC 5424, 6.2.1.
const DAEMON: u8 = 3;

/// How serious a message is (RFC 5424, 6.2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogSeverity {
    /// An error condition.
    Error = 3,
    /// A warning condition.
    Warning = 4,
    /// An informational message.
    Info = 6,
}

/// The system log of this host.
#[derive(Debug)]
pub struct SystemLog {
    socket: UnixDatagram,
    path: std::path::PathBuf,
}

impl SystemLog {
    /// Opens the socket of the system log, `/dev/log` on most systems.
    pub fn open(path: &Path) -> io::Result<SystemLog> {
        let socket = UnixDatagram::unbound()?;
        socket.connect(path)?;
        socket.set_nonblocking(true)?;
        Ok(SystemLog { socket, path: path.to_owned() })
    }

    /// Sends a message of one line. A log that was restarted is connected again; a full one fails.
    pub fn send(&self, severity: LogSeverity, program: &str, text: &str) -> io::Result<()> {
        let priority = DAEMON * 8 + severity as u8;
        let line = format!("<{priority}>{program}[{}]: {}", std::process::id(), text.replace('\n', " "));
        match self.socket.send(line.as_bytes()) {
            Err(error) if matches!(error.kind(), io::ErrorKind::ConnectionRefused | io::ErrorKind::NotConnected) => {
                self.socket.connect(&self.path)?;
                self.socket.send(line.as_bytes()).map(|_| ())
            }
            sent => sent.map(|_| ()),
        }
    }
}
