//! `encspec watch`: a permanent monitor and flight recorder.

mod outputs;
mod sources;

use super::dut::claimed_manuals;
use super::{CommandError, CommandResult, Suites, print_message};
use clap::Args;
use link::{interrupt, realtime};
use outputs::Outputs;
use report::ExitStatus;
use sources::Source;
use station::{Duration, Time};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::{Instant, SystemTime, UNIX_EPOCH};
use virtual_wire::capture::LinkType;
use watch::{DiskRing, LiveWatch, RingSettings, WatchLine};
use wire::profibus::fdl::BaudRate;

const EXAMPLE: &str = "\
Example, at a network tap, for weeks:
  encspec watch --nic eth1 --dir /var/lib/encspec --ring 4GB --syslog --metrics 127.0.0.1:9188

SIGHUP begins new files, SIGTERM and Ctrl-C end the watch without losing anything. docs/watch.md says which taps are safe.";

/// Arguments of `encspec watch`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub(super) struct WatchArgs {
    #[command(flatten)]
    from: WatchSource,
    /// Bit rate of the bus in bit/s; required with --serial
    #[arg(long, value_name = "RATE", value_parser = super::port::baud, conflicts_with = "nic")]
    baud: Option<BaudRate>,
    /// Folder of the ring, the incidents and the findings; it is created
    #[arg(long, value_name = "DIR", default_value = "encspec-watch")]
    dir: PathBuf,
    /// How much disk the last frames may take; 0 keeps no frames and saves no incidents
    #[arg(long, value_name = "SIZE", default_value = "1GB", value_parser = size)]
    ring: u64,
    /// How much disk the incidents may take; the oldest are deleted
    #[arg(long, value_name = "SIZE", default_value = "1GB", value_parser = size)]
    incidents: u64,
    /// File to which findings are appended as JSON lines; - is standard output [default: findings.jsonl in the folder]
    #[arg(long, value_name = "FILE")]
    findings: Option<PathBuf>,
    /// Also send findings to the system log
    #[arg(long, value_name = "SOCKET", num_args = 0..=1, default_missing_value = "/dev/log")]
    syslog: Option<PathBuf>,
    /// Shell command to run for each finding, with its JSON line on standard input; ended after 10 s
    #[arg(long, value_name = "COMMAND")]
    hook: Option<String>,
    /// Serve counts for Prometheus at this address, for instance 127.0.0.1:9188
    #[arg(long, value_name = "ADDRESS")]
    metrics: Option<SocketAddr>,
    /// Stop after this many seconds [default: stop on SIGTERM or Ctrl-C]
    #[arg(long, value_name = "SECONDS")]
    duration: Option<u64>,
    /// Read and judge before all ordinary programs, so that a busy host loses no frames; needs root or CAP_SYS_NICE
    #[arg(long)]
    realtime: bool,
    /// Use the rules of this manual only
    #[arg(long, value_name = "MANUAL[/VARIANT]")]
    device: Option<String>,
    #[command(flatten)]
    suites: Suites,
}

/// The source of the frames.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
struct WatchSource {
    /// Network interface, best at a tap or mirror port; nothing is sent at it
    #[arg(long, value_name = "IF")]
    nic: Option<String>,
    /// Serial line connected to a PROFIBUS; nothing is sent at it, neither token nor answer
    #[arg(long, value_name = "TTY", requires = "baud")]
    serial: Option<PathBuf>,
    /// A capture that is being written, from standard input: -
    #[arg(value_name = "-", value_parser = ["-"])]
    input: Option<String>,
}

/// A number of bytes, for instance `1GB` or `500MB`.
fn size(text: &str) -> Result<u64, String> {
    let digits = text.len() - text.trim_start_matches(|of: char| of.is_ascii_digit()).len();
    let (number, unit) = text.split_at(digits);
    let factor = match unit.trim().to_ascii_uppercase().as_str() {
        "" | "B" => 1,
        "K" | "KB" => 1_000,
        "M" | "MB" => 1_000_000,
        "G" | "GB" => 1_000_000_000,
        "T" | "TB" => 1_000_000_000_000,
        _ => return Err(format!("`{unit}` is no unit; write for instance 500MB or 1GB")),
    };
    let number: u64 = number.parse().map_err(|_| "write for instance 500MB or 1GB".to_owned())?;
    number.checked_mul(factor).ok_or_else(|| "that is too much".to_owned())
}

pub(super) fn watch(args: &WatchArgs) -> CommandResult {
    let manuals = claimed_manuals(&args.suites.sources()?.for_rules(), args.device.as_deref())?;
    interrupt::watch();
    interrupt::watch_reload();
    if args.realtime {
        realtime::schedule_listener().map_err(CommandError::bench)?;
    }
    let (nic, serial) = (args.from.nic.as_deref(), args.from.serial.as_deref());
    let mut source = Source::open(nic, serial, args.baud)?;
    let interfaces = match &source {
        Source::Input(_) => vec![("-".to_owned(), LinkType::ETHERNET), ("-".to_owned(), LinkType::PROFIBUS)],
        other => vec![(other.name(), other.link())],
    };
    let settings = RingSettings { folder: args.dir.clone(), size: args.ring, incidents: args.incidents, interfaces };
    let unwritable =
        |error: std::io::Error| CommandError::bench(format!("{} cannot be written: {error}", args.dir.display()));
    let ring = if args.ring > 0 { Some(DiskRing::start(&settings).map_err(unwritable)?) } else { None };
    let mut outputs = Outputs::open(args, &source)?;
    let warnings = source.warnings(args.metrics.map(|address| address.ip()));
    for warning in &warnings {
        print_message(warning);
    }
    outputs.pass_on(&[WatchLine::Started {
        wall_clock: watch::utc(now()),
        source: source.describe(),
        version: env!("CARGO_PKG_VERSION"),
        warnings,
        time_stamps: source.time_stamps(),
    }]);
    let mut watch = LiveWatch::new(&manuals, ring);
    let ended = run(args, &mut source, &mut watch, &mut outputs);
    let (lines, counts) = watch.end();
    outputs.pass_on(&lines);
    outputs.end();
    ended?;
    let has_errors = counts.findings.iter().any(|((_, severity), count)| *severity == "error" && *count > 0);
    // Who ends a watch has no test to fail; a capture or a given time ends by itself.
    Ok(if has_errors && !interrupt::requested() { ExitStatus::Red } else { ExitStatus::Green })
}

/// Watches until the source or the time ends, or the user ends it.
fn run(
    args: &WatchArgs,
    source: &mut Source,
    watch: &mut LiveWatch<'_>,
    outputs: &mut Outputs,
) -> Result<(), CommandError> {
    let begun = Instant::now();
    let end = args.duration.map(std::time::Duration::from_secs);
    let mut is_open = true;
    while is_open && !interrupt::requested() && end.is_none_or(|end| begun.elapsed() < end) {
        if interrupt::take_reload() {
            watch.rotate();
            outputs.rotate()?;
        }
        let received = source.receive(watch)?;
        is_open = received.is_open;
        if let Some(note) = received.note {
            outputs.pass_on(&[WatchLine::Note { wall_clock: watch::utc(now()), text: note }]);
        }
        // While frames still wait, the time is that of the last one.
        let time = if received.is_drained { source.now(watch.last()) } else { watch.last() };
        if watch.is_due(time) {
            watch.counts_mut().transmitted = source.transmitted();
            let lines = watch.tick(time);
            outputs.pass_on(&lines);
            watch.counts_mut().not_passed_on = outputs.not_passed_on();
            outputs.update(watch);
        }
    }
    Ok(())
}

/// The time of this host since 1970.
fn now() -> Time {
    Time::ZERO + SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or(Duration::ZERO)
}
