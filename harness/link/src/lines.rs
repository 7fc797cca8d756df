//! Lines of text over a Unix socket: server and client.

use std::fs;
use std::io::{self, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::fs::{FileTypeExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

use crate::interfaces::escaped;
use crate::sys::{PollEvent, wait};
use crate::{Clock, LinkError};
use station::{Duration, Time};

/// The longest line, in bytes.
const LONGEST_LINE: usize = 64 * 1024;
/// How long a peer may take to accept a line before the connection counts as lost.
const PATIENCE: Duration = Duration::from_secs(1);

fn display_path(path: &Path) -> String {
    escaped(&path.to_string_lossy())
}

/// Listens at `path`, for this user only; replaces a stale socket file that no process listens on.
pub(crate) fn listen_at(path: &Path) -> Result<UnixListener, LinkError> {
    let unusable = |why: String| LinkError::Unusable(format!("cannot listen at {}: {why}", display_path(path)));
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(unusable(error.to_string())),
        Ok(found) if !found.file_type().is_socket() => {
            return Err(unusable("a file that is not a socket exists there; choose another name".to_string()));
        }
        Ok(_) if UnixStream::connect(path).is_ok() => {
            return Err(unusable("another process listens there; choose another name".to_string()));
        }
        Ok(_) => {}
    }
    // No process may connect before the permissions are set, so the socket is created under another name and then renamed.
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".{}", std::process::id()));
    let early = PathBuf::from(name);
    let made = || {
        let listener = UnixListener::bind(&early)?;
        listener.set_nonblocking(true)?;
        fs::set_permissions(&early, fs::Permissions::from_mode(0o600))?;
        fs::rename(&early, path)?;
        Ok(listener)
    };
    made().map_err(|error: io::Error| {
        let _ = fs::remove_file(&early);
        unusable(format!("{error}; choose a short path in a folder that you own"))
    })
}

/// A Unix socket at which clients connect to exchange lines.
#[derive(Debug)]
pub struct LineListener {
    listener: UnixListener,
    path: PathBuf,
}

impl LineListener {
    /// Listens at `path`, for this user only; the file is removed on drop.
    pub fn bind(path: &Path) -> Result<LineListener, LinkError> {
        Ok(LineListener { listener: listen_at(path)?, path: path.to_owned() })
    }

    /// Accepts a client if one is waiting; does not block.
    pub fn accept(&self) -> Result<Option<LineConnection>, LinkError> {
        match self.listener.accept() {
            Ok((stream, _)) => LineConnection::new(stream, &self.path).map(Some),
            Err(error) if not_now(&error) || error.kind() == io::ErrorKind::ConnectionAborted => Ok(None),
            Err(error) => Err(LinkError::Gone(format!(
                "cannot accept connections at {} any more: {error}",
                display_path(&self.path)
            ))),
        }
    }

    /// The path of the socket.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for LineListener {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// A connection that carries lines.
#[derive(Debug)]
pub struct LineConnection {
    stream: UnixStream,
    input: Vec<u8>,
    name: String,
}

impl LineConnection {
    fn new(stream: UnixStream, path: &Path) -> Result<LineConnection, LinkError> {
        let name = display_path(path);
        stream
            .set_nonblocking(true)
            .map_err(|error| LinkError::Gone(format!("the connection at {name} cannot be used: {error}")))?;
        Ok(LineConnection { stream, input: Vec::new(), name })
    }

    fn gone(&self, why: &str) -> LinkError {
        LinkError::Gone(format!("the connection at {} has ended: {why}", self.name))
    }

    /// Returns the next line without its line ending, if one has arrived; does not block.
    ///
    /// Bytes that are not UTF-8 become replacement characters. A line longer than 64 KiB ends the connection.
    pub fn poll_line(&mut self) -> Result<Option<String>, LinkError> {
        loop {
            if let Some(end) = self.input.iter().position(|octet| *octet == b'\n') {
                let mut line: Vec<u8> = self.input.drain(..=end).collect();
                line.pop();
                if line.last() == Some(&b'\r') {
                    line.pop();
                }
                return Ok(Some(String::from_utf8_lossy(&line).into_owned()));
            }
            if self.input.len() > LONGEST_LINE {
                return Err(self.gone("a line is longer than 64 KiB"));
            }
            let mut piece = [0; 4096];
            match self.stream.read(&mut piece) {
                Ok(0) => return Err(self.gone("the peer closed it")),
                Ok(count) => self.input.extend_from_slice(&piece[..count]),
                Err(error) if not_now(&error) => return Ok(None),
                Err(error) => return Err(self.gone(&error.to_string())),
            }
        }
    }

    /// Sends `line` with a line ending; line breaks in it are sent as spaces. A peer that accepts nothing for 1 s is gone.
    pub fn write_line(&mut self, line: &str) -> Result<(), LinkError> {
        let clock = Clock::start();
        let mut octets = line.replace(['\n', '\r'], " ").into_bytes();
        octets.push(b'\n');
        let mut rest = octets.as_slice();
        while !rest.is_empty() {
            match self.stream.write(rest) {
                Ok(0) => return Err(self.gone("the peer accepts no more data")),
                Ok(count) => rest = &rest[count..],
                Err(error) if not_now(&error) && clock.now().since(Time::ZERO) < PATIENCE => {
                    wait(self.stream.as_fd(), PollEvent::Writing, &clock, Time::ZERO + PATIENCE)
                        .map_err(|error| self.gone(&error.to_string()))?;
                }
                Err(error) if not_now(&error) => return Err(self.gone("the peer accepts no more data")),
                Err(error) => return Err(self.gone(&error.to_string())),
            }
        }
        Ok(())
    }

    /// Waits for a line, at most `timeout`.
    pub fn wait_line(&mut self, timeout: Duration) -> Result<Option<String>, LinkError> {
        let clock = Clock::start();
        let until = Time::ZERO + timeout;
        loop {
            if let Some(line) = self.poll_line()? {
                return Ok(Some(line));
            }
            if clock.remaining(until).is_zero() {
                return Ok(None);
            }
            wait(self.stream.as_fd(), PollEvent::Reading, &clock, until)
                .map_err(|error| self.gone(&error.to_string()))?;
        }
    }
}

fn not_now(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

/// A client that sends lines and receives one line as the answer to each.
#[derive(Debug)]
pub struct LineClient {
    path: PathBuf,
    connection: Option<LineConnection>,
}

impl LineClient {
    /// Connects to the server at `path`.
    pub fn connect(path: &Path) -> Result<LineClient, LinkError> {
        let connection = connect(path).map_err(LinkError::Unusable)?;
        Ok(LineClient { path: path.to_owned(), connection: Some(connection) })
    }

    /// Sends `line` and waits for the answer, at most `timeout`.
    ///
    /// After an error the next call opens a new connection, so a late answer is never taken for the answer to the next line.
    pub fn request(&mut self, line: &str, timeout: Duration) -> Result<String, LinkError> {
        let mut connection = match self.connection.take() {
            Some(connection) => connection,
            None => connect(&self.path).map_err(LinkError::Gone)?,
        };
        connection.write_line(line)?;
        match connection.wait_line(timeout)? {
            Some(answer) => {
                self.connection = Some(connection);
                Ok(answer)
            }
            None => Err(LinkError::Gone(format!(
                "{} did not answer `{}` within {} ms",
                display_path(&self.path),
                escaped(line),
                timeout.as_millis()
            ))),
        }
    }
}

fn connect(path: &Path) -> Result<LineConnection, String> {
    let trouble =
        |why: String| format!("cannot connect to {}: {why}; start the program that listens there", display_path(path));
    let stream = UnixStream::connect(path).map_err(|error| trouble(error.to_string()))?;
    LineConnection::new(stream, path).map_err(|error| trouble(error.to_string()))
}
