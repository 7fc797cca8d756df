//! Lines of text over a Unix socket: one that serves, one that asks.

use std::fs;
use std::io::{self, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::fs::{FileTypeExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

use crate::interfaces::escaped;
use crate::sys::{For, wait};
use crate::{Clock, LinkError};
use station::{Duration, Time};

/// The longest line, in octets.
const LONGEST_LINE: usize = 64 * 1024;
/// How long a peer may take to accept a line.
const PATIENCE: Duration = Duration::from_secs(1);

fn shown(path: &Path) -> String {
    escaped(&path.to_string_lossy())
}

/// Listens at `path`, for this user only; a name that a process has left behind is taken over.
pub(crate) fn take_place(path: &Path) -> Result<UnixListener, LinkError> {
    let unusable = |why: String| LinkError::Unusable(format!("nobody can connect at {}: {why}", shown(path)));
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(unusable(error.to_string())),
        Ok(found) if !found.file_type().is_socket() => {
            return Err(unusable("there is a file that is no socket; choose another name".to_string()));
        }
        Ok(_) if UnixStream::connect(path).is_ok() => {
            return Err(unusable("another process listens there; choose another name".to_string()));
        }
        Ok(_) => {}
    }
    // Nobody may connect before the rights are set, so it comes into being under another name.
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
        unusable(format!("{error}; choose a short path in a folder of your own"))
    })
}

/// Where others connect to speak line by line.
#[derive(Debug)]
pub struct Listener {
    listener: UnixListener,
    path: PathBuf,
}

impl Listener {
    /// Listens at `path`, for this user only; the name goes when this is dropped.
    pub fn bind(path: &Path) -> Result<Listener, LinkError> {
        Ok(Listener { listener: take_place(path)?, path: path.to_owned() })
    }

    /// Takes one who wants to connect, if there is one; nothing is waited for.
    pub fn accept(&self) -> Result<Option<Connection>, LinkError> {
        match self.listener.accept() {
            Ok((stream, _)) => Connection::new(stream, &self.path).map(Some),
            Err(error) if not_now(&error) || error.kind() == io::ErrorKind::ConnectionAborted => Ok(None),
            Err(error) => {
                Err(LinkError::Gone(format!("nobody can connect at {} any more: {error}", shown(&self.path))))
            }
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// One who speaks line by line.
#[derive(Debug)]
pub struct Connection {
    stream: UnixStream,
    input: Vec<u8>,
    name: String,
}

impl Connection {
    fn new(stream: UnixStream, path: &Path) -> Result<Connection, LinkError> {
        let name = shown(path);
        stream
            .set_nonblocking(true)
            .map_err(|error| LinkError::Gone(format!("the connection at {name} does not work: {error}")))?;
        Ok(Connection { stream, input: Vec::new(), name })
    }

    fn gone(&self, why: &str) -> LinkError {
        LinkError::Gone(format!("the connection at {} has ended: {why}", self.name))
    }

    /// The next line without its end, if one is there; nothing is waited for.
    ///
    /// What is not UTF-8 is shown as replacement characters. A line beyond 64 KiB ends the connection.
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
                return Err(self.gone("a line has no end"));
            }
            let mut piece = [0; 4096];
            match self.stream.read(&mut piece) {
                Ok(0) => return Err(self.gone("the peer has closed it")),
                Ok(count) => self.input.extend_from_slice(&piece[..count]),
                Err(error) if not_now(&error) => return Ok(None),
                Err(error) => return Err(self.gone(&error.to_string())),
            }
        }
    }

    /// Sends `line` with an end; ends of lines within it are sent as spaces. A peer that takes nothing for 1 s is gone.
    pub fn write_line(&mut self, line: &str) -> Result<(), LinkError> {
        let clock = Clock::start();
        let mut octets = line.replace(['\n', '\r'], " ").into_bytes();
        octets.push(b'\n');
        let mut rest = octets.as_slice();
        while !rest.is_empty() {
            match self.stream.write(rest) {
                Ok(0) => return Err(self.gone("the peer takes nothing any more")),
                Ok(count) => rest = &rest[count..],
                Err(error) if not_now(&error) && clock.now().since(Time::ZERO) < PATIENCE => {
                    wait(self.stream.as_fd(), For::Writing, &clock, Time::ZERO + PATIENCE)
                        .map_err(|error| self.gone(&error.to_string()))?;
                }
                Err(error) if not_now(&error) => return Err(self.gone("the peer takes nothing any more")),
                Err(error) => return Err(self.gone(&error.to_string())),
            }
        }
        Ok(())
    }

    /// Waits for a line up to `timeout`.
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
            wait(self.stream.as_fd(), For::Reading, &clock, until).map_err(|error| self.gone(&error.to_string()))?;
        }
    }
}

fn not_now(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

/// One who asks line by line, each answered by a line.
#[derive(Debug)]
pub struct Client {
    path: PathBuf,
    connection: Option<Connection>,
}

impl Client {
    /// Connects to who listens at `path`.
    pub fn connect(path: &Path) -> Result<Client, LinkError> {
        let connection = connect(path).map_err(LinkError::Unusable)?;
        Ok(Client { path: path.to_owned(), connection: Some(connection) })
    }

    /// Sends `line` and waits for the answer up to `timeout`.
    ///
    /// After an error the connection is made anew, so that a late answer is never taken for that to the next line.
    pub fn ask(&mut self, line: &str, timeout: Duration) -> Result<String, LinkError> {
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
                "{} has not answered `{}` within {} ms",
                shown(&self.path),
                escaped(line),
                timeout.as_millis()
            ))),
        }
    }
}

fn connect(path: &Path) -> Result<Connection, String> {
    let trouble = |why: String| format!("nobody answers at {}: {why}; start what listens there", shown(path));
    let stream = UnixStream::connect(path).map_err(|error| trouble(error.to_string()))?;
    Connection::new(stream, path).map_err(|error| trouble(error.to_string()))
}
