//! A serial line, or a pseudoterminal that stands for one: octets in and out, nothing translated.
//!
//! This room must not know where a frame ends.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rustix::termios::{ControlModes, OptionalActions, QueueSelector, Termios};

use crate::interfaces::escaped;
use crate::sys::{For, pause, wait};
use crate::{Clock, LinkError};
use station::{Duration, Parity, Time};

/// Octets that are read at once.
const SCRATCH: usize = 4096;
/// How long a line may take nothing before it is given up.
const PATIENCE: Duration = Duration::from_secs(3);
/// How often [`Serial::recover`] looks whether the line is back.
const LOOK_AGAIN: Duration = Duration::from_millis(20);

/// How a serial line is driven.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialSettings {
    /// Bits in a second.
    pub baud: u32,
    /// The parity bit.
    pub parity: Parity,
    /// Whether what is sent comes back, as adapters without a switch for it let it.
    pub echo: bool,
    /// Whether the hardware switches the driver of RS-485; else the adapter does it by itself.
    pub rs485: bool,
}

impl SerialSettings {
    /// A line at `baud` with even parity, whose adapter does everything by itself.
    pub fn new(baud: u32) -> SerialSettings {
        SerialSettings { baud, parity: Parity::Even, echo: false, rs485: false }
    }
}

/// An open serial line.
pub struct Serial {
    path: PathBuf,
    settings: SerialSettings,
    line: File,
    /// What the line was like before.
    before: Termios,
    /// Whether it is open for sending, too.
    sends: bool,
    is_pty: bool,
    scratch: Box<[u8]>,
    /// What was sent and has not come back yet, where it does.
    echo: Vec<u8>,
    garbled: u64,
    /// The other end, where this is the controlling one.
    far_end: Option<FarEnd>,
}

/// The other end of a pseudoterminal of ours, held open so that the line stays while nobody else has it open.
struct FarEnd {
    link: PathBuf,
    _open: Box<Serial>,
}

impl Drop for FarEnd {
    fn drop(&mut self) {
        // Where somebody took it away there is nothing left to be done.
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
    /// A pseudoterminal keeps neither baud rate nor parity and is taken all the same, although others may have it open, too; any
    /// other line that does not keep them is refused.
    pub fn open(path: &Path, settings: &SerialSettings) -> Result<Serial, LinkError> {
        Serial::opened(path, settings, true)
    }

    /// Opens the line at `path` as [`Serial::open`] does, but only to listen: nothing can be sent.
    ///
    /// Where RTS is what switches the driver of RS-485 on, it is taken away, so that the bus stays free.
    pub fn listen(path: &Path, settings: &SerialSettings) -> Result<Serial, LinkError> {
        let settings = SerialSettings { echo: false, rs485: false, ..settings.clone() };
        Serial::opened(path, &settings, false)
    }

    fn opened(path: &Path, settings: &SerialSettings, sends: bool) -> Result<Serial, LinkError> {
        let shown = escaped(&path.display().to_string());
        let trouble = |error: io::Error| {
            let hint = match error.kind() {
                io::ErrorKind::PermissionDenied => {
                    "; the user needs the right to use it, for instance by the group dialout"
                }
                io::ErrorKind::NotFound => "; is the adapter plugged in?",
                _ => "",
            };
            LinkError::Unusable(format!("the serial line {shown} cannot be opened: {error}{hint}"))
        };
        let flags = libc::O_NOCTTY | libc::O_NONBLOCK;
        let line = OpenOptions::new().read(true).write(sends).custom_flags(flags).open(path).map_err(trouble)?;
        if !rustix::termios::isatty(&line) {
            return Err(LinkError::Unusable(format!("{shown} is no serial line")));
        }
        let before = rustix::termios::tcgetattr(&line).map_err(|error| trouble(error.into()))?;
        let is_pty = prepare(&line, before.clone(), settings, &shown)?;
        if !is_pty {
            rustix::termios::ioctl_tiocexcl(&line).map_err(|error| trouble(error.into()))?;
        }
        #[cfg(target_os = "linux")]
        if !sends {
            // A line without RTS has none to be taken away.
            let _ = crate::sys::serial::take_rts_away(line.as_fd());
        }
        let scratch = vec![0; SCRATCH].into_boxed_slice();
        let (path, settings) = (path.to_owned(), settings.clone());
        let echo = Vec::new();
        Ok(Serial { path, settings, line, before, sends, is_pty, scratch, echo, garbled: 0, far_end: None })
    }

    /// Makes a pseudoterminal and gives its controlling end; `link` becomes a symbolic link to the other end, which somebody can
    /// open and close as often as he likes. The link goes when this does.
    pub fn controlling(link: &Path, settings: &SerialSettings) -> Result<Serial, LinkError> {
        let shown = escaped(&link.display().to_string());
        let (line, path) = pty::open()?;
        let far_end = Serial::open(&path, settings)?;
        let trouble = |error: io::Error| LinkError::Unusable(format!("there is no pseudoterminal to be had: {error}"));
        rustix::io::ioctl_fionbio(&line, true).map_err(|error| trouble(error.into()))?;
        std::os::unix::fs::symlink(&path, link).map_err(|error| {
            LinkError::Unusable(format!(
                "the link {shown} cannot be made: {error}; choose another name or take it away"
            ))
        })?;
        let far_end = FarEnd { link: link.to_owned(), _open: Box::new(far_end) };
        let before = rustix::termios::tcgetattr(&line).map_err(|error| trouble(error.into()))?;
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

    /// Whether it is a pseudoterminal, which has no bit times.
    pub fn is_pty(&self) -> bool {
        self.is_pty
    }

    /// How it is driven.
    pub fn settings(&self) -> &SerialSettings {
        &self.settings
    }

    /// How often what came back was not what was sent: somebody else was sending too.
    pub fn garbled(&self) -> u64 {
        self.garbled
    }

    /// What it is, for messages.
    pub fn describe(&self) -> String {
        format!("the serial line {}", escaped(&self.path.display().to_string()))
    }

    /// Sends `octets`; it comes back once the kernel has them all.
    pub fn send(&mut self, octets: &[u8]) -> Result<(), LinkError> {
        let clock = Clock::start();
        let mut rest = octets;
        while !rest.is_empty() {
            match self.line.write(rest) {
                Ok(0) => return Err(self.gone("it takes nothing any more")),
                Ok(count) => rest = &rest[count..],
                Err(error) if not_now(&error) && clock.now().since(Time::ZERO) < PATIENCE => {
                    let until = Time::ZERO + PATIENCE;
                    wait(self.line.as_fd(), For::Writing, &clock, until)
                        .map_err(|error| self.gone(&error.to_string()))?;
                }
                Err(error) if not_now(&error) => return Err(self.gone("it takes nothing any more")),
                Err(error) => return Err(self.gone(&error.to_string())),
            }
        }
        if self.settings.echo {
            self.echo.extend_from_slice(octets);
        }
        Ok(())
    }

    /// Appends the octets that are here to `into`, without waiting; false if there are none.
    pub fn receive(&mut self, into: &mut Vec<u8>) -> Result<bool, LinkError> {
        match self.line.read(&mut self.scratch) {
            // A line that hung up, or a pseudoterminal whose other end was closed.
            Ok(0) => Err(self.gone("the other end has closed")),
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

    /// Waits until octets are here, or `clock` shows `until`.
    pub fn wait(&self, clock: &Clock, until: Time) -> Result<(), LinkError> {
        wait(self.line.as_fd(), For::Reading, clock, until).map_err(|error| self.gone(&error.to_string()))
    }

    /// Throws away what has come in and was not read.
    pub fn forget(&mut self) {
        // A line that is gone says so again when it is read.
        let _ = rustix::termios::tcflush(&self.line, QueueSelector::IFlush);
        self.echo.clear();
    }

    /// After [`LinkError::Gone`]: tries to open the line again until `clock` shows `until`.
    pub fn recover(&mut self, clock: &Clock, until: Time) -> Result<(), LinkError> {
        loop {
            if self.far_end.is_some() {
                return Ok(());
            }
            // The old one is still open for this process alone; who recovers is this process.
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

    /// Takes away what we have sent ourselves from the octets behind `from`.
    fn take_echo(&mut self, into: &mut Vec<u8>, from: usize) {
        let came = into.get(from..).unwrap_or_default();
        let count = self.echo.len().min(came.len());
        if count == 0 {
            return;
        }
        if self.echo[..count] == came[..count] {
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
        // A line that is gone needs no settings.
        let _ = rustix::termios::tcsetattr(&self.line, OptionalActions::Now, &self.before);
    }
}

/// Makes the line carry octets as they are; says whether it is a pseudoterminal.
fn prepare(line: &File, mut state: Termios, settings: &SerialSettings, shown: &str) -> Result<bool, LinkError> {
    let trouble = |what: &str, error: io::Error| {
        LinkError::Unusable(format!("the serial line {shown} does not take {what}: {error}; choose another adapter"))
    };
    state.make_raw();
    state.control_modes |= ControlModes::CS8 | ControlModes::PARENB | ControlModes::CREAD | ControlModes::CLOCAL;
    state.control_modes &= !(ControlModes::PARODD | ControlModes::CSTOPB | ControlModes::CRTSCTS);
    state.special_codes[rustix::termios::SpecialCodeIndex::VMIN] = 1;
    state.special_codes[rustix::termios::SpecialCodeIndex::VTIME] = 0;
    let rate = format!("{} bit/s", settings.baud);
    state.set_speed(settings.baud).map_err(|error| trouble(&rate, error.into()))?;
    rustix::termios::tcsetattr(line, OptionalActions::Now, &state).map_err(|error| trouble(&rate, error.into()))?;
    let kept = rustix::termios::tcgetattr(line).map_err(|error| trouble("any settings", error.into()))?;
    // A pseudoterminal takes everything and clears the parity, so that each line is asked for one at first.
    let is_pty = !kept.control_modes.contains(ControlModes::PARENB);
    if settings.parity != Parity::Even {
        state.control_modes.set(ControlModes::PARODD, settings.parity == Parity::Odd);
        state.control_modes.set(ControlModes::PARENB, settings.parity != Parity::None);
        let set = rustix::termios::tcsetattr(line, OptionalActions::Now, &state);
        set.map_err(|error| trouble("this parity", error.into()))?;
    }
    if !is_pty && kept.output_speed().abs_diff(settings.baud) > settings.baud / 50 {
        return Err(LinkError::Unusable(format!(
            "the serial line {shown} runs at {} bit/s and not at {rate}",
            kept.output_speed()
        )));
    }
    #[cfg(target_os = "linux")]
    {
        // What gathers octets for a while still delivers them.
        let _ = crate::sys::serial::low_latency(line.as_fd());
        if settings.rs485 && !is_pty {
            crate::sys::serial::drive_rs485(line.as_fd()).map_err(|error| trouble("the driver of RS-485", error))?;
        }
    }
    rustix::termios::tcflush(line, QueueSelector::IOFlush).map_err(|error| trouble("any settings", error.into()))?;
    Ok(is_pty)
}

fn not_now(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

/// Two ends of a line that is none, for tests and for a device and a master in one machine.
pub mod pty {
    use super::{File, LinkError, PathBuf};
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

    /// The controlling end of a new pseudoterminal, and the path of the other end.
    ///
    /// It lives as long as the controlling end is open.
    pub fn open() -> Result<(File, PathBuf), LinkError> {
        let made = || -> rustix::io::Result<(File, PathBuf)> {
            let control = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
            grantpt(&control)?;
            unlockpt(&control)?;
            let name = ptsname(&control, Vec::new())?;
            Ok((File::from(control), PathBuf::from(String::from_utf8_lossy(name.to_bytes()).into_owned())))
        };
        made().map_err(|error| LinkError::Unusable(format!("there is no pseudoterminal to be had: {error}")))
    }
}
