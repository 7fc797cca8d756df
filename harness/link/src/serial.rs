//! A serial line, or a pseudoterminal in its place: bytes in and out, without translation.
//!
//! This module must not know where a frame ends.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rustix::termios::{ControlModes, OptionalActions, QueueSelector, Termios};

use crate::interfaces::escaped;
use crate::sys::{PollEvent, pause, wait};
use crate::{Clock, LinkError};
use station::{Duration, Parity, Time};

/// The size of the read buffer, in bytes.
const SCRATCH: usize = 4096;
/// How long a line may accept no data before it counts as gone.
const PATIENCE: Duration = Duration::from_secs(3);
/// How often [`Serial::recover`] checks whether the line is back.
const LOOK_AGAIN: Duration = Duration::from_millis(20);

/// The settings of a serial line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialSettings {
    /// The rate in bit/s.
    pub baud: u32,
    pub parity: Parity,
    /// Whether sent bytes come back as an echo, as with adapters that do not switch their receiver off.
    pub echo: bool,
    /// Whether the UART switches the RS-485 driver by RTS; otherwise the adapter switches it.
    pub rs485: bool,
}

impl SerialSettings {
    /// A line at `baud` with even parity, whose adapter switches the RS-485 driver and has no echo.
    pub fn new(baud: u32) -> SerialSettings {
        SerialSettings { baud, parity: Parity::Even, echo: false, rs485: false }
    }
}

/// An open serial line.
pub struct Serial {
    path: PathBuf,
    settings: SerialSettings,
    line: File,
    /// The settings before this process opened the line, to restore them.
    before: Termios,
    /// Whether it is open for sending.
    sends: bool,
    is_pty: bool,
    scratch: Box<[u8]>,
    /// Sent bytes whose echo has not arrived yet.
    echo: Vec<u8>,
    garbled: u64,
    /// The other end, if this is the controlling end of a pseudoterminal.
    far_end: Option<FarEnd>,
}

/// The other end of a pseudoterminal, held open so that the line stays up while no other program has it open.
struct FarEnd {
    link: PathBuf,
    _open: Box<Serial>,
}

impl Drop for FarEnd {
    fn drop(&mut self) {
        // Another program may have removed the link already.
        let _ = std::fs::remove_file(&self.link);
    }
}

impl std::fmt::Debug for Serial {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Serial").field("path", &self.path).field("settings", &self.settings).finish_non_exhaustive()
    }
}

impl Serial {
    /// Opens the line at `path`, for this process alone, with eight bits.
    ///
    /// A pseudoterminal keeps neither baud rate nor parity; it is accepted all the same, and other programs may have it open too.
    /// Any other line must keep both, or this fails.
    pub fn open(path: &Path, settings: &SerialSettings) -> Result<Serial, LinkError> {
        Serial::opened(path, settings, true)
    }

    /// Opens the line at `path` as [`Serial::open`] does, but only to listen: nothing can be sent.
    ///
    /// Clears RTS, because it may switch the RS-485 driver on, which would occupy the bus.
    pub fn listen(path: &Path, settings: &SerialSettings) -> Result<Serial, LinkError> {
        let settings = SerialSettings { echo: false, rs485: false, ..settings.clone() };
        Serial::opened(path, &settings, false)
    }

    fn opened(path: &Path, settings: &SerialSettings, sends: bool) -> Result<Serial, LinkError> {
        let label = escaped(&path.display().to_string());
        let unusable = |error: io::Error| {
            let hint = match error.kind() {
                io::ErrorKind::PermissionDenied => {
                    "; the user needs access to it, for instance through the group dialout"
                }
                io::ErrorKind::NotFound => "; is the adapter plugged in?",
                _ => "",
            };
            LinkError::Unusable(format!("the serial line {label} cannot be opened: {error}{hint}"))
        };
        let flags = libc::O_NOCTTY | libc::O_NONBLOCK;
        let line = OpenOptions::new().read(true).write(sends).custom_flags(flags).open(path).map_err(unusable)?;
        if !rustix::termios::isatty(&line) {
            return Err(LinkError::Unusable(format!("{label} is not a serial line")));
        }
        let before = rustix::termios::tcgetattr(&line).map_err(|error| unusable(error.into()))?;
        let is_pty = prepare(&line, before.clone(), settings, &label)?;
        if !is_pty {
            rustix::termios::ioctl_tiocexcl(&line).map_err(|error| unusable(error.into()))?;
        }
        #[cfg(target_os = "linux")]
        if !sends {
            // A line without RTS returns an error, which does not matter here.
            let _ = crate::sys::serial::clear_rts(line.as_fd());
        }
        let scratch = vec![0; SCRATCH].into_boxed_slice();
        let (path, settings) = (path.to_owned(), settings.clone());
        let echo = Vec::new();
        Ok(Serial { path, settings, line, before, sends, is_pty, scratch, echo, garbled: 0, far_end: None })
    }

    /// Creates a pseudoterminal and returns its controlling end; `link` becomes a symbolic link to the other end, which programs
    /// may open and close any number of times. The link is removed on drop.
    pub fn controlling(link: &Path, settings: &SerialSettings) -> Result<Serial, LinkError> {
        let label = escaped(&link.display().to_string());
        let (line, path) = pty::open()?;
        let far_end = Serial::open(&path, settings)?;
        let unusable = |error: io::Error| LinkError::Unusable(format!("cannot create a pseudoterminal: {error}"));
        rustix::io::ioctl_fionbio(&line, true).map_err(|error| unusable(error.into()))?;
        std::os::unix::fs::symlink(&path, link).map_err(|error| {
            LinkError::Unusable(format!(
                "cannot create the link {label}: {error}; remove the file or choose another name"
            ))
        })?;
        let far_end = FarEnd { link: link.to_owned(), _open: Box::new(far_end) };
        let before = rustix::termios::tcgetattr(&line).map_err(|error| unusable(error.into()))?;
        Ok(Serial {
            path: link.to_owned(),
            settings: settings.clone(),
            line,
            before,
            sends: true,
            is_pty: true,
            scratch: vec![0; SCRATCH].into_boxed_slice(),
            echo: Vec::new(),
            garbled: 0,
            far_end: Some(far_end),
        })
    }

    /// Whether it is a pseudoterminal, on which bytes take no time.
    pub fn is_pty(&self) -> bool {
        self.is_pty
    }

    /// The settings with which the line was opened.
    pub fn settings(&self) -> &SerialSettings {
        &self.settings
    }

    /// How often the echo differed from the sent bytes: another station was sending at the same time.
    pub fn echo_errors(&self) -> u64 {
        self.garbled
    }

    /// The kind and path of the line for messages: `the serial line /dev/ttyUSB0`.
    pub fn describe(&self) -> String {
        format!("the serial line {}", escaped(&self.path.display().to_string()))
    }

    /// Sends `octets`; returns when the kernel has accepted all of them.
    pub fn send(&mut self, octets: &[u8]) -> Result<(), LinkError> {
        let clock = Clock::start();
        let mut rest = octets;
        while !rest.is_empty() {
            match self.line.write(rest) {
                Ok(0) => return Err(self.gone("it accepts no more data")),
                Ok(count) => rest = &rest[count..],
                Err(error) if not_now(&error) && clock.now().since(Time::ZERO) < PATIENCE => {
                    let until = Time::ZERO + PATIENCE;
                    wait(self.line.as_fd(), PollEvent::Writing, &clock, until)
                        .map_err(|error| self.gone(&error.to_string()))?;
                }
                Err(error) if not_now(&error) => return Err(self.gone("it accepts no more data")),
                Err(error) => return Err(self.gone(&error.to_string())),
            }
        }
        if self.settings.echo {
            self.echo.extend_from_slice(octets);
        }
        Ok(())
    }

    /// Appends the bytes that have arrived to `into`, without waiting; returns false if there are none.
    pub fn receive(&mut self, into: &mut Vec<u8>) -> Result<bool, LinkError> {
        match self.line.read(&mut self.scratch) {
            // The line hung up, or the other end of the pseudoterminal was closed.
            Ok(0) => Err(self.gone("the other end was closed")),
            Ok(count) => {
                let before = into.len();
                into.extend_from_slice(&self.scratch[..count]);
                self.take_echo(into, before);
                Ok(into.len() > before)
            }
            Err(error) if not_now(&error) => Ok(false),
            Err(error) => Err(self.gone(&error.to_string())),
        }
    }

    /// Waits until bytes arrive or `clock` shows `until`.
    pub fn wait(&self, clock: &Clock, until: Time) -> Result<(), LinkError> {
        wait(self.line.as_fd(), PollEvent::Reading, clock, until).map_err(|error| self.gone(&error.to_string()))
    }

    /// Discards received bytes that were not read.
    pub fn discard_input(&mut self) {
        // If the line is gone, the next read fails again.
        let _ = rustix::termios::tcflush(&self.line, QueueSelector::IFlush);
        self.echo.clear();
    }

    /// After [`LinkError::Gone`]: tries to open the line again until `clock` shows `until`.
    pub fn recover(&mut self, clock: &Clock, until: Time) -> Result<(), LinkError> {
        loop {
            if self.far_end.is_some() {
                return Ok(());
            }
            // The old line is still open exclusively, also towards this process itself.
            let _ = rustix::termios::ioctl_tiocnxcl(&self.line);
            match Serial::opened(&self.path, &self.settings, self.sends) {
                Ok(line) => {
                    *self = line;
                    return Ok(());
                }
                Err(error) if clock.remaining(until).is_zero() => return Err(LinkError::Gone(error.to_string())),
                Err(_) => pause(clock, until.min(clock.now() + LOOK_AGAIN)),
            }
        }
    }

    fn gone(&self, why: &str) -> LinkError {
        LinkError::Gone(format!("{} is gone: {why}", self.describe()))
    }

    /// Removes the echo of sent bytes from the received bytes after `from`.
    fn take_echo(&mut self, into: &mut Vec<u8>, from: usize) {
        let received = into.get(from..).unwrap_or_default();
        let count = self.echo.len().min(received.len());
        if count == 0 {
            return;
        }
        if self.echo[..count] == received[..count] {
            self.echo.drain(..count);
            into.drain(from..from + count);
        } else {
            self.garbled += 1;
            self.echo.clear();
        }
    }
}

impl Drop for Serial {
    fn drop(&mut self) {
        let _ = rustix::termios::ioctl_tiocnxcl(&self.line);
        // A line that is gone has no settings to restore.
        let _ = rustix::termios::tcsetattr(&self.line, OptionalActions::Now, &self.before);
    }
}

/// Sets the line to raw mode with `settings`; returns whether it is a pseudoterminal.
fn prepare(line: &File, mut state: Termios, settings: &SerialSettings, label: &str) -> Result<bool, LinkError> {
    let refused = |what: &str, error: io::Error| {
        LinkError::Unusable(format!("the serial line {label} does not accept {what}: {error}; choose another adapter"))
    };
    state.make_raw();
    state.control_modes |= ControlModes::CS8 | ControlModes::PARENB | ControlModes::CREAD | ControlModes::CLOCAL;
    state.control_modes &= !(ControlModes::PARODD | ControlModes::CSTOPB | ControlModes::CRTSCTS);
    state.special_codes[rustix::termios::SpecialCodeIndex::VMIN] = 1;
    state.special_codes[rustix::termios::SpecialCodeIndex::VTIME] = 0;
    let rate = format!("{} bit/s", settings.baud);
    state.set_speed(settings.baud).map_err(|error| refused(&rate, error.into()))?;
    rustix::termios::tcsetattr(line, OptionalActions::Now, &state).map_err(|error| refused(&rate, error.into()))?;
    let effective = rustix::termios::tcgetattr(line).map_err(|error| refused("any settings", error.into()))?;
    // A pseudoterminal accepts all settings but clears the parity bit. So each line is first set to even parity.
    let is_pty = !effective.control_modes.contains(ControlModes::PARENB);
    if settings.parity != Parity::Even {
        state.control_modes.set(ControlModes::PARODD, settings.parity == Parity::Odd);
        state.control_modes.set(ControlModes::PARENB, settings.parity != Parity::None);
        let set = rustix::termios::tcsetattr(line, OptionalActions::Now, &state);
        set.map_err(|error| refused("this parity", error.into()))?;
    }
    if !is_pty && effective.output_speed().abs_diff(settings.baud) > settings.baud / 50 {
        return Err(LinkError::Unusable(format!(
            "the serial line {label} runs at {} bit/s instead of {rate}",
            effective.output_speed()
        )));
    }
    #[cfg(target_os = "linux")]
    {
        // A driver without low-latency mode delivers the bytes later, which is tolerable.
        let _ = crate::sys::serial::low_latency(line.as_fd());
        if settings.rs485 && !is_pty {
            crate::sys::serial::drive_rs485(line.as_fd())
                .map_err(|error| refused("switching the RS-485 driver", error))?;
        }
    }
    rustix::termios::tcflush(line, QueueSelector::IOFlush).map_err(|error| refused("any settings", error.into()))?;
    Ok(is_pty)
}

fn not_now(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

/// Pseudoterminals, for tests and for a device and a master on the same host.
pub mod pty {
    use super::{File, LinkError, PathBuf};
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

    /// Creates a pseudoterminal; returns its controlling end and the path of the other end.
    ///
    /// The pseudoterminal exists as long as the controlling end is open.
    pub fn open() -> Result<(File, PathBuf), LinkError> {
        let made = || -> rustix::io::Result<(File, PathBuf)> {
            let control = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
            grantpt(&control)?;
            unlockpt(&control)?;
            let name = ptsname(&control, Vec::new())?;
            Ok((File::from(control), PathBuf::from(String::from_utf8_lossy(name.to_bytes()).into_owned())))
        };
        made().map_err(|error| LinkError::Unusable(format!("cannot create a pseudoterminal: {error}")))
    }
}
