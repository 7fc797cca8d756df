//! `encspec record`: records a serial line or a network interface, or converts a hex log to a capture.

use super::{CommandError, CommandResult, print_message, show};
use clap::Args;
use link::{Clock, LinkError, Nic, Port, Serial, SerialSettings, interrupt, privileges};
use plain_text::printable;
use report::ExitStatus;
use station::{Duration, Time};
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use virtual_wire::PcapngWriter;
use virtual_wire::capture::LinkType;
use virtual_wire::record::{CaptureRecorder, ImportError, RecordingCounts, import};
use wire::profibus::fdl::{BaudRate, BitTimes};

/// How often the recording checks for Ctrl-C and the end of `--duration`.
const POLL: Duration = Duration::from_millis(100);

/// Arguments of `encspec record`.
#[derive(Debug, Args)]
pub(super) struct RecordArgs {
    /// Capture to write, in pcapng format; an existing file is not overwritten
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    from: RecordSource,
    /// Bit rate of the bus in bit/s; required with --serial; with --from-hex it spaces the frames of one log line
    #[arg(long, value_name = "RATE", value_parser = super::port::baud, conflicts_with = "nic")]
    baud: Option<BaudRate>,
    /// Stop after this many seconds [default: stop on Ctrl-C]
    #[arg(long, value_name = "SECONDS", conflicts_with = "log")]
    duration: Option<u64>,
}

/// The source of the frames.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
struct RecordSource {
    /// Serial line connected to a PROFIBUS, for instance /dev/ttyUSB0; listens with 8 data bits and even parity, sends nothing
    #[arg(long, value_name = "TTY", requires = "baud")]
    serial: Option<PathBuf>,
    /// Network interface; records every received frame
    #[arg(long, value_name = "IF")]
    nic: Option<String>,
    /// PROFIBUS log with a timestamp and hexadecimal bytes on each line; - reads standard input
    #[arg(long = "from-hex", value_name = "LOG")]
    log: Option<PathBuf>,
}

pub(super) fn record(args: &RecordArgs) -> CommandResult {
    match (&args.from.serial, &args.from.nic, &args.from.log) {
        (Some(line), _, _) => serial(args, line),
        (_, Some(name), _) => nic(args, name),
        (_, _, log) => from_hex(args, log.as_deref().unwrap_or(Path::new("-"))),
    }
}

/// Creates the capture file, which must not exist yet.
fn create(file: &Path) -> Result<File, CommandError> {
    let hint = |error: &io::Error| match error.kind() {
        io::ErrorKind::AlreadyExists => "; remove it or choose another name",
        _ => "",
    };
    File::options()
        .write(true)
        .create_new(true)
        .open(file)
        .map_err(|error| CommandError::usage(format!("{} cannot be written: {error}{}", file.display(), hint(&error))))
}

fn unwritable(file: &Path, error: &io::Error) -> CommandError {
    CommandError::bench(format!("writing {} failed: {error}; it holds the frames recorded so far", file.display()))
}

fn unusable(error: &LinkError) -> CommandError {
    CommandError::bench(error.to_string())
}

/// A clock, and the Unix time of its zero. Later changes of the system time do not matter.
fn clock() -> (Clock, Duration) {
    (Clock::start(), SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default())
}

/// When to stop, on a clock that starts now.
fn end(args: &RecordArgs) -> Time {
    args.duration.map_or(Time::MAX, |seconds| Time::ZERO + Duration::from_secs(seconds))
}

fn serial(args: &RecordArgs, path: &Path) -> CommandResult {
    let rate = args.baud.unwrap_or(BaudRate(0));
    interrupt::watch();
    let mut line = Serial::listen(path, &SerialSettings::new(rate.0)).map_err(|error| unusable(&error))?;
    let place = line.describe();
    let file = create(&args.file)?;
    // A pseudoterminal has no bit times.
    let known = (!line.is_pty()).then_some(rate);
    let failed = |error: io::Error| unwritable(&args.file, &error);
    let mut recorder = CaptureRecorder::new(file, &path.display().to_string(), known).map_err(failed)?;
    show(&format!("listening at {place}\n"));
    let ((clock, start), end) = (clock(), end(args));
    let (mut octets, mut last, mut failure) = (Vec::new(), Time::ZERO, None);
    while failure.is_none() && !interrupt::requested() && clock.now() < end {
        octets.clear();
        let received = line.receive(&mut octets);
        let now = clock.now();
        match received {
            Ok(true) => {
                let lasts = known.map_or(0, |rate| rate.nanoseconds(BitTimes::of_octets(octets.len())));
                // The bytes were sent one after the other before they were received.
                let begin = (now - Duration::from_nanos(lasts)).max(last);
                recorder.record(begin + start, &octets).map_err(failed)?;
                last = now;
            }
            Ok(false) => {
                let silent_at = recorder.silent_at().map_or(Time::MAX, |at| at - start);
                if now >= silent_at {
                    recorder.silence().map_err(failed)?;
                    continue;
                }
                failure = line.wait(&clock, end.min(silent_at).min(now + POLL)).err();
            }
            Err(error) => failure = Some(error),
        }
    }
    let (_, counts) = recorder.finish().map_err(failed)?;
    show(&summary(&args.file, counts));
    if let Some(error) = failure {
        return Err(CommandError::bench(format!("{error}; {} holds the frames recorded so far", args.file.display())));
    }
    match (counts.frames, counts.damaged) {
        (0, 0) => {
            Err(CommandError::bench(format!("nothing received at {place}; is it connected, and is a master running?")))
        }
        (0, _) => Err(CommandError::bench(format!(
            "no valid frame received at {place}; is {} bit/s the rate of the bus, and are lines A and B not swapped?",
            rate.0
        ))),
        _ => Ok(ExitStatus::Green),
    }
}

fn nic(args: &RecordArgs, name: &str) -> CommandResult {
    interrupt::watch();
    let mut port = Nic::open(name).map_err(|error| unusable(&error))?;
    // Drop privileges first, so that the file belongs to the user.
    privileges::drop().map_err(|error| unusable(&error))?;
    let place = port.describe();
    let file = create(&args.file)?;
    let failed = |error: io::Error| unwritable(&args.file, &error);
    let mut writer = PcapngWriter::new(file, concat!("encspec ", env!("CARGO_PKG_VERSION"))).map_err(failed)?;
    let interface = writer.interface(name, LinkType::ETHERNET).map_err(failed)?;
    show(&format!("listening at {place}\n"));
    let ((clock, start), end) = (clock(), end(args));
    let (mut frame, mut counts, mut failure) = (Vec::new(), RecordingCounts::default(), None);
    while failure.is_none() && !interrupt::requested() && clock.now() < end {
        match port.receive(&clock, end.min(clock.now() + POLL), &mut frame) {
            Ok(Some(time)) => {
                writer.packet(interface, time + start, &frame, None).map_err(failed)?;
                counts.frames += 1;
                counts.span = Some((counts.span.map_or(time, |(first, _)| first), time));
            }
            Ok(None) => {}
            Err(error) => failure = Some(error),
        }
    }
    writer.finish().map_err(failed)?;
    show(&summary(&args.file, counts));
    let lost = port.lost();
    if lost > 0 {
        print_message(&format!("{lost} frames arrived too fast and are missing in {}", args.file.display()));
    }
    match failure {
        Some(error) => {
            Err(CommandError::bench(format!("{error}; {} holds the frames recorded so far", args.file.display())))
        }
        None if counts.frames == 0 => Err(CommandError::bench(format!("nothing received at {place}"))),
        None => Ok(ExitStatus::Green),
    }
}

fn from_hex(args: &RecordArgs, log: &Path) -> CommandResult {
    let source = if log == Path::new("-") { "standard input".to_owned() } else { log.display().to_string() };
    let input: Box<dyn Read> = match log.to_str() {
        Some("-") => Box::new(io::stdin().lock()),
        _ => Box::new(
            File::open(log).map_err(|error| CommandError::usage(format!("{source}: cannot be read: {error}")))?,
        ),
    };
    let output = BufWriter::new(create(&args.file)?);
    let imported = import(BufReader::new(input), output, &format!("hex log {source}"), args.baud);
    let stop = match imported {
        Ok((_, counts)) if counts.frames > 0 => {
            show(&summary(&args.file, counts));
            return Ok(ExitStatus::Green);
        }
        Ok((_, RecordingCounts { damaged: 0, .. })) => CommandError::usage(format!("{source}: no line has any bytes")),
        Ok(_) => CommandError::usage(format!("{source}: no valid PROFIBUS frame; is it the log of another bus?")),
        Err(ImportError::Wrong(errors, more)) => {
            let mut lines: Vec<String> =
                errors.iter().map(|(line, what)| format!("{source}:{line}: {}", printable(what))).collect();
            if more > 0 {
                lines.push(format!("{more} more errors in {source}"));
            }
            CommandError::usage(lines.join("\n"))
        }
        Err(ImportError::Unwritable(error)) => {
            CommandError::bench(format!("{} cannot be written: {error}", args.file.display()))
        }
        Err(ImportError::Unreadable(error)) => CommandError::usage(format!("{source}: cannot be read: {error}")),
    };
    // Do not leave an incomplete capture behind. It stays if it cannot be removed.
    let _ = fs::remove_file(&args.file);
    Err(stop)
}

/// A line about what was recorded.
fn summary(file: &Path, counts: RecordingCounts) -> String {
    let seconds = counts.span.map_or(0.0, |(first, last)| last.since(first).as_secs_f64());
    let damaged = match counts.damaged {
        0 => String::new(),
        1 => ", 1 damaged fragment".to_owned(),
        n => format!(", {n} damaged fragments"),
    };
    format!("{}: {} frames{damaged} in {seconds:.3} s\n", file.display(), counts.frames)
}
