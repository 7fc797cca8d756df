//! `encspec bench soak`: keeps connections to many devices for a long time and shows how steady host, link and devices are.

use super::super::live::{LiveTarget, manual, read_gsdml};
use super::super::{CommandError, CommandResult, Suites, print_message, show};
use clap::{Args, ValueEnum};
use controllers::profinet_io::{DeviceAddress, LimitError};
use description::gsdml;
use link::{Histogram, LinkError, Wire, interrupt, privileges, realtime};
use live::discover::{DiscoveredStation, Survey, discover, own_mac};
use live::preflight;
use live::soak::{SoakDevice, SoakReport, SoakResult, soak};
use report::ExitStatus;
use results::bench_file::BenchFile;
use results::outcome::DescriptionKind;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// How long to wait for DCP answers.
const WAIT: Duration = Duration::from_secs(3);
/// The most devices of one run.
const MOST: u16 = 200;
/// Interval of the lines about the progress.
const REPORT_INTERVAL: Duration = Duration::from_secs(60);

/// Arguments of `encspec bench soak`.
#[derive(Debug, Args)]
pub(super) struct SoakArgs {
    /// Bench file of the device on PROFINET; it needs the consent `alone`, since the run loads the whole segment
    bench: PathBuf,
    /// Number of devices of this kind; with more than one their names are the station name with -1, -2 and so on, as `encspec serve
    /// --count` gives them
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST)))]
    count: u16,
    /// Bench file of another device on the same link, to compare with; may be repeated
    #[arg(long, value_name = "BENCH")]
    beside: Vec<PathBuf>,
    /// Seconds of cyclic exchange
    #[arg(long, value_name = "SECONDS", default_value_t = 60)]
    duration: u64,
    /// Cycle in milliseconds, a power of two
    #[arg(long, value_name = "MS", default_value_t = 1)]
    cycle: u16,
    /// Output format
    #[arg(long, value_enum, default_value = "text")]
    format: SoakFormat,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum SoakFormat {
    Text,
    Json,
}

pub(super) fn run(args: &SoakArgs) -> CommandResult {
    let bench = read(&args.bench, &args.suites)?;
    let others = args.beside.iter().map(|path| read(path, &args.suites)).collect::<Result<Vec<_>, _>>()?;
    if let Some(other) = others.iter().find(|other| other.link != bench.link) {
        return Err(CommandError::usage(format!(
            "all devices of a run are on one link; {} is on {}, not on {}",
            name(other),
            other.link,
            bench.link
        )));
    }
    if !bench.consent.alone {
        return Err(CommandError::usage(format!(
            "a run loads the whole segment: say `consent: {{ alone: true }}` in {} if no other machine depends on it",
            args.bench.display()
        )));
    }
    interrupt::watch();
    let scheduling = realtime::raise();
    scheduling.granted.iter().chain(&scheduling.refused).for_each(|note| print_message(note));
    let unusable = |error: LinkError| CommandError::bench(error.to_string());
    let port = preflight::open(&bench.link).map_err(|why| CommandError::bench(why.to_string()))?;
    privileges::drop().map_err(unusable)?;
    let own = own_mac(port.mac());
    let mut wire = Wire::new(port);
    let survey = discover(&mut wire, own, WAIT, &mut interrupt::requested).map_err(unusable)?;
    let mut devices = Vec::new();
    for number in 1..=args.count {
        let called = if args.count == 1 { name(&bench) } else { format!("{}-{number}", name(&bench)) };
        devices.push(device(&bench, &called, &survey, args)?);
    }
    for other in &others {
        devices.push(device(other, &name(other), &survey, args)?);
    }
    let mut reported = Duration::ZERO;
    let mut watch = |passed: Duration, standing: usize| {
        if passed >= reported + REPORT_INTERVAL {
            reported = passed;
            print_message(&format!("{} s: {standing} of {} connections stand", passed.as_secs(), devices.len()));
        }
        interrupt::requested()
    };
    let time = Duration::from_secs(args.duration);
    let report = soak(&mut wire, &devices, &survey.stations, time, &mut watch).map_err(unusable)?;
    let beside = usize::from(args.count);
    match args.format {
        SoakFormat::Text => show(&text(&report, args.cycle, &bench.link.to_string(), beside)),
        SoakFormat::Json => show(&format!("{:#}\n", as_json(&report, args.cycle))),
    }
    Ok(if report.lost().next().is_none() { ExitStatus::Green } else { ExitStatus::Red })
}

fn read(path: &Path, suites: &Suites) -> Result<BenchFile, CommandError> {
    LiveTarget::File(path.to_owned()).bench(&suites.load()?)
}

/// The station name of a bench.
fn name(bench: &BenchFile) -> String {
    bench.station_name.clone().unwrap_or_else(|| "encoder-under-test".to_owned())
}

/// The device with this station name, and the connection to it.
fn device(bench: &BenchFile, called: &str, survey: &Survey, args: &SoakArgs) -> Result<SoakDevice, CommandError> {
    let found = survey.stations.iter().find(|station| station.name == called.as_bytes());
    let found: &DiscoveredStation = found.ok_or_else(|| {
        let names: Vec<String> = survey.stations.iter().map(DiscoveredStation::printable_name).collect();
        let names =
            if names.is_empty() { "nothing answered".to_owned() } else { format!("found: {}", names.join(", ")) };
        CommandError::bench(format!("there is no station {called}; {names}"))
    })?;
    let ip =
        found.ip.ok_or_else(|| CommandError::bench(format!("the station {called} has no IP address; give it one")))?;
    let mut manual = manual(bench, &args.suites)?;
    if manual.device.profibus().is_some() {
        return Err(CommandError::usage(format!("{} is not on PROFINET", manual.device.name)));
    }
    let variant = manual.device.variants.iter().position(|known| *known == bench.claim.variant).unwrap_or_default();
    let description = bench.description_of(DescriptionKind::Gsdml).map(read_gsdml).transpose()?;
    let known = Arc::get_mut(&mut manual.device).ok_or_else(|| CommandError::bench("the suite is in use elsewhere"))?;
    gsdml::overlay(known, variant, description.as_ref(), None, &bench.start_parameters);
    let address = DeviceAddress::Name(called.into());
    let mut connection = engine::usual_connection(&manual.device, variant, address, ip);
    let watchdog = bench.watchdog.unwrap_or(connection.data_hold_time());
    connection.reduction_ratio = args.cycle;
    let cycles = watchdog.as_nanos().div_ceil(connection.cycle().as_nanos().max(1));
    connection.watchdog_factor = u16::try_from(cycles).unwrap_or(u16::MAX).max(3);
    connection.data_hold_factor = connection.watchdog_factor;
    connection.check().map_err(|error: LimitError| CommandError::usage(error.to_string()))?;
    Ok(SoakDevice { station: found.clone(), connection })
}

fn text(report: &SoakReport, cycle: u16, link: &str, beside: usize) -> String {
    let mut out = String::new();
    let devices = &report.devices;
    let (own, others) = devices.split_at(beside.min(devices.len()));
    let sum = |count: fn(&SoakResult) -> u64| devices.iter().map(count).sum::<u64>();
    // Writing into a String cannot fail.
    let _ = writeln!(out, "{} devices at {cycle} ms for {:.0} s on {link}", devices.len(), report.lasted.as_secs_f64());
    let _ = writeln!(out, "  connected        after {:.1} s", report.start_up.as_secs_f64());
    let lost: Vec<&SoakResult> = report.lost().collect();
    let _ = writeln!(out, "  lost             {}", lost.len());
    for device in lost {
        let _ = writeln!(out, "    {} {}: {}", device.name, device.mac, device.lost.as_deref().unwrap_or_default());
    }
    let _ = writeln!(out, "  frames           {} sent, {} received", sum(|of| of.sent), sum(|of| of.received));
    let _ = writeln!(out, "  missing          {} by the cycle counters of the devices", sum(|of| of.missing));
    let _ = writeln!(out, "  {:16} {:>10} {:>10} {:>10} {:>10}", "", "median", "99 %", "99.99 %", "most");
    let _ = writeln!(out, "  {:16} {}", "we wake late", quantiles(&report.late));
    let _ = writeln!(out, "  {:16} {}", "we send each", quantiles(&report.gaps));
    let mut all = Histogram::default();
    own.iter().for_each(|device| all.add(&device.intervals));
    let _ = writeln!(out, "  {:16} {}", "they send each", quantiles(&all));
    if let Some(worst) = own.iter().max_by_key(|device| device.intervals.max()).filter(|_| own.len() > 1) {
        let _ = writeln!(out, "  {:16} {}  {}", "  the least even", quantiles(&worst.intervals), worst.name);
    }
    for device in others {
        let _ = writeln!(out, "  {:16} {}  {}", "  beside them", quantiles(&device.intervals), device.name);
    }
    if let Some((before, after)) = report.memory {
        let mega = |bytes: u64| bytes as f64 / 1e6;
        let _ =
            writeln!(out, "  memory           {:.1} MB at the start, {:.1} MB at the end", mega(before), mega(after));
    }
    out
}

/// Median, 99 %, 99.99 % and the most of a histogram, in milliseconds.
fn quantiles(of: &Histogram) -> String {
    let values = [of.p50(), of.p99(), of.quantile(0.9999), of.max()];
    values.map(|value| format!("{:>7.3} ms", value.as_secs_f64() * 1e3)).join(" ")
}

fn as_json(report: &SoakReport, cycle: u16) -> Value {
    let times = |of: &Histogram| {
        let nanos = |time: Duration| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        json!({
            "count": of.count(), "p50_ns": nanos(of.p50()), "p99_ns": nanos(of.p99()),
            "p9999_ns": nanos(of.quantile(0.9999)), "max_ns": nanos(of.max()),
        })
    };
    let devices = report.devices.iter().map(|of| {
        json!({
            "name": of.name, "mac": of.mac.to_string(), "lost": of.lost, "sent": of.sent, "received": of.received,
            "missing": of.missing, "intervals": times(&of.intervals),
        })
    });
    json!({
        "cycle_ms": cycle,
        "start_up_s": report.start_up.as_secs_f64(),
        "lasted_s": report.lasted.as_secs_f64(),
        "devices": devices.collect::<Vec<_>>(),
        "late": times(&report.late),
        "gaps": times(&report.gaps),
        "memory_bytes": report.memory.map(|(before, after)| [before, after]),
    })
}
