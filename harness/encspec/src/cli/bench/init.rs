//! `encspec bench init`: finds a device, reads which variant of which manual it is, and writes its bench file.

use super::super::port::{DiscoverySegment, LineArgs, SegmentArgs};
use super::super::slaves::{self, FoundSlave};
use super::super::vendor_file::DescriptionFile;
use super::super::{CommandError, CommandResult, Suites, live, print_message, show};
use super::{LOCK_WAIT, mapping, text};
use ::live::discover::DiscoveredStation;
use ::live::preflight::PreflightPurpose;
use clap::Args;
use description::variant::{VariantReading, candidates, profibus_readings, profinet_readings};
use link::Port;
use report::ExitStatus;
use results::bench_file::{BenchFile, DeviceClaim, LinkSpec};
use results::outcome::DescriptionKind;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::time::Duration;
use suite::device::Origin;
use suite::model::Manual;

/// How long to wait for DCP answers.
const WAIT: Duration = Duration::from_secs(3);
/// The address of a device that has none, until power-off.
pub(super) const ADDRESS: Ipv4Addr = Ipv4Addr::new(192, 168, 0, 10);

/// Arguments of `encspec bench init`.
#[derive(Debug, Args)]
pub(super) struct InitArgs {
    #[command(flatten)]
    segment: SegmentArgs,
    #[command(flatten)]
    line: LineArgs,
    /// Station name or MAC address of the device, on PROFIBUS its station address, if several answer
    #[arg(long, value_name = "NAME|MAC|ADDRESS")]
    station: Option<String>,
    /// Manual of the device, if its identity does not tell
    #[arg(long, value_name = "MANUAL")]
    device: Option<String>,
    /// The vendor's GSDML of the device
    #[arg(long, value_name = "FILE", conflicts_with = "serial")]
    gsdml: Option<PathBuf>,
    /// The vendor's GSD of the device
    #[arg(long, value_name = "FILE", requires = "serial")]
    gsd: Option<PathBuf>,
    /// Only list the stations and read nothing of the device: its variant may stay open
    #[arg(long)]
    no_read: bool,
    /// File to write [default: standard output]; an existing file is not overwritten
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    suites: Suites,
}

/// A device that was found, on either bus.
pub(super) enum FoundDevice {
    Station(DiscoveredStation),
    Slave(FoundSlave),
}

impl FoundDevice {
    /// Whether its identity is that of the manual, printed or invented for the reference device.
    fn is_of(&self, manual: &Manual) -> bool {
        match self {
            FoundDevice::Station(found) => found.ids.is_some() && manual.device.ids() == found.ids,
            FoundDevice::Slave(slave) => manual.device.ident() == Some(slave.ident),
        }
    }
}

/// What is known of the manual and the variant of a device.
#[derive(Default)]
pub(super) struct KnownDevice<'m> {
    pub manual: Option<&'m Manual>,
    /// Whether its identity is that of the manual; otherwise only its vendor is.
    pub is_certain: bool,
    /// The variants that it can be, as indices.
    pub left: Vec<usize>,
    /// What shows its variant.
    pub readings: Vec<VariantReading>,
    /// Why nothing was read.
    pub unread: Option<String>,
}

pub(super) fn init(args: &InitArgs) -> CommandResult {
    if let Some(path) = args.output.as_deref().filter(|path| path.exists()) {
        return Err(CommandError::usage(format!(
            "{} already exists; choose another name or remove it",
            path.display()
        )));
    }
    let manuals = args.suites.load()?;
    let described = match (&args.gsdml, &args.gsd) {
        (Some(path), _) => Some(DescriptionFile::open(DescriptionKind::Gsdml, path)?),
        (None, Some(path)) => Some(DescriptionFile::open(DescriptionKind::Gsd, path)?),
        (None, None) => None,
    };
    let segment = args.segment.segment();
    let link = match &segment {
        DiscoverySegment::Line(path) => LinkSpec::Serial(path.clone()),
        DiscoverySegment::Port(port) => port.spec(),
    };
    let mut bench = BenchFile::bare(link, DeviceClaim { manual: String::new(), variant: String::new() });
    bench.line = args.line.spec();
    // A path in a bench file is relative to its folder.
    let is_beside = args.output.as_deref().and_then(Path::parent).is_none_or(|folder| folder.as_os_str().is_empty());
    let path = |file: &DescriptionFile| if is_beside { None } else { std::fs::canonicalize(&file.path).ok() };
    bench.descriptions =
        described.iter().map(|file| (file.kind, path(file).unwrap_or_else(|| file.path.clone()))).collect();
    let (found, port) = find(args, &segment)?;
    let mut known = fitting_manual(&found, &manuals, &args.suites.own()?, args.device.as_deref())?;
    match &found {
        FoundDevice::Station(station) => {
            bench.mac = Some(station.mac);
            bench.ip = Some(station.ip.map_or(ADDRESS, |ip| ip.address));
        }
        FoundDevice::Slave(slave) => {
            bench.line.address = Some(slave.address);
            bench.line.masters = slave.masters;
        }
    }
    identify(&mut known, &bench, described.as_ref(), port, args);
    let mapping = known.manual.zip(described.as_ref()).map(|(manual, file)| {
        let variant = known.left.first().copied().unwrap_or_default();
        mapping::of(&manual.device, variant, file)
    });
    let text = text::bench_file(&bench, &found, &known, mapping.as_ref());
    if known.manual.is_none() {
        print_message(match found {
            FoundDevice::Station(_) => {
                "there is no suite for this device; the bench file needs a `description`, or write one with `encspec suite init`"
            }
            FoundDevice::Slave(_) => {
                "there is no suite for this slave; write one from its GSD with `encspec suite init --gsd FILE`"
            }
        });
    }
    if let (Some(manual), [_, _, ..]) = (known.manual, &known.left[..]) {
        if let Some(why) = &known.unread {
            print_message(&format!("the variant was not read: {why}"));
        }
        print_message(&format!("the variant is open. {}", manual.device.variant_question(&known.left)));
    }
    if let Some(table) = mapping.as_ref().and_then(mapping::ParameterMapping::table) {
        table.lines().for_each(print_message);
    }
    match &args.output {
        None => show(&text),
        Some(path) => {
            write(path, &text)?;
            print_message(&format!("wrote {}; read its comments, then run: encspec run --dut {0}", path.display()));
        }
    }
    Ok(ExitStatus::Green)
}

/// Finds the device; on Ethernet the port stays open.
fn find(args: &InitArgs, segment: &DiscoverySegment) -> Result<(FoundDevice, Option<Box<dyn Port>>), CommandError> {
    let station = args.station.as_deref();
    match segment {
        DiscoverySegment::Line(path) => Ok((FoundDevice::Slave(slaves::find(path, &args.line, station)?), None)),
        DiscoverySegment::Port(port) => {
            let (survey, port) = port.survey(WAIT)?;
            survey.remarks.iter().for_each(|remark| print_message(remark));
            let found = choose_station(&survey.stations, station)?;
            Ok((FoundDevice::Station(found.clone()), Some(port)))
        }
    }
}

/// Reads which variant the device is; where nothing can be read, what the description says remains.
fn identify(
    known: &mut KnownDevice<'_>,
    bench: &BenchFile,
    described: Option<&DescriptionFile>,
    port: Option<Box<dyn Port>>,
    args: &InitArgs,
) {
    let Some(manual) = known.manual else { return };
    let device = &manual.device;
    known.left = (0..device.variants.len()).collect();
    if known.left.len() < 2 {
        return;
    }
    known.readings = match described {
        Some(file) if device.profibus().is_some() => profibus_readings(device, file.gsd()),
        Some(file) => profinet_readings(device, file.gsdml(), None),
        None => Vec::new(),
    };
    if args.no_read {
        known.unread = Some("--no-read".to_owned());
    } else {
        match read(manual, bench, port, &args.suites) {
            Ok((readings, notes)) => {
                known.readings = readings;
                notes.iter().for_each(|note| print_message(note));
            }
            Err(error) => known.unread = Some(error.message),
        }
    }
    known.left = candidates(device, &known.readings);
}

/// Prepares the device as a run does, and reads what shows its variant.
fn read(
    manual: &Manual,
    bench: &BenchFile,
    port: Option<Box<dyn Port>>,
    suites: &Suites,
) -> Result<(Vec<VariantReading>, Vec<String>), CommandError> {
    let mut bench = bench.clone();
    let variant = manual.device.variants.first().cloned().unwrap_or_default();
    bench.claim = DeviceClaim { manual: manual.device.name.clone(), variant };
    let _lock = live::lock(&bench, LOCK_WAIT)?;
    let dut = live::open_for(PreflightPurpose::Run, port, bench, suites, false, None)?;
    engine::identify_live_variant(&dut).map_err(|error| CommandError::bench(error.to_string()))
}

/// Writes a new file. An existing file is not overwritten.
fn write(path: &Path, text: &str) -> Result<(), CommandError> {
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| CommandError::usage(format!("{} cannot be written: {error}", path.display())))
}

/// The station that `--station` names, or the only device.
pub(super) fn choose_station<'f>(
    stations: &'f [DiscoveredStation],
    station: Option<&str>,
) -> Result<&'f DiscoveredStation, CommandError> {
    let matches = |found: &&DiscoveredStation| match station {
        Some(word) => {
            found.name == word.as_bytes() || found.mac.to_string() == word.to_ascii_lowercase().replace('-', ":")
        }
        None => found.roles.contains(&"device") || found.roles.is_empty(),
    };
    let list = || stations.iter().map(|found| format!("{} {}", found.mac, found.printable_name())).collect::<Vec<_>>();
    let mut matching = stations.iter().filter(matches);
    match (matching.next(), matching.next(), station) {
        (Some(found), None, _) => Ok(found),
        (Some(_), Some(_), _) => Err(CommandError::usage(format!(
            "several stations match; choose one with --station: {}",
            list().join(", ")
        ))),
        (None, _, Some(word)) if !stations.is_empty() => Err(CommandError::usage(format!(
            "there is no station {}; found: {}",
            word.escape_default(),
            list().join(", ")
        ))),
        (None, ..) => Err(CommandError::bench("no device answered; is it powered and connected to this interface?")),
    }
}

/// The manual that fits a device, or the one that `named` says; one of `own`, the manuals of the user, before a built-in one.
pub(super) fn fitting_manual<'m>(
    found: &FoundDevice,
    manuals: &'m [Manual],
    own: &[String],
    named: Option<&str>,
) -> Result<KnownDevice<'m>, CommandError> {
    if let Some(named) = named {
        let claimed = super::super::dut::claim(named, manuals).map_err(CommandError::usage)?;
        let manual = claimed.first().map(|(manual, _)| *manual);
        return Ok(KnownDevice { manual, is_certain: true, ..KnownDevice::default() });
    }
    let mut certain: Vec<&Manual> = manuals.iter().filter(|manual| found.is_of(manual)).collect();
    if certain.iter().any(|manual| own.contains(&manual.device.name)) {
        certain.retain(|manual| own.contains(&manual.device.name));
    }
    let similar = |manual: &&Manual| {
        let FoundDevice::Station(found) = found else { return false };
        let vendor = |ids: Option<(u16, u16)>| ids.map(|(vendor, _)| vendor);
        let of_vendor = found.ids.is_some() && vendor(manual.device.ids()) == vendor(found.ids);
        of_vendor && manual.device.bus.number_origin() == Origin::Invented
    };
    let has_type = |manual: &&&Manual| {
        let FoundDevice::Station(found) = found else { return false };
        manual.device.profinet().is_some_and(|facts| facts.identity.station_type == found.station_type)
    };
    let perhaps: Vec<&Manual> = manuals.iter().filter(similar).collect();
    let best = |of: &[&'m Manual]| of.iter().find(has_type).or_else(|| of.first()).copied();
    let manual = best(&certain).or_else(|| best(&perhaps));
    Ok(KnownDevice { manual, is_certain: !certain.is_empty(), ..KnownDevice::default() })
}
