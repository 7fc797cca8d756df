//! `encspec bench`: creates bench files from discovered devices, and restores a device after an interrupted run.

use super::port::PortArgs;
use super::{CommandError, CommandResult, Suites, print_message, show};
use clap::{Args, Subcommand};
use engine;
use live::discover::DiscoveredStation;
use live::journal::{self, Journal, JournalEntry};
use report::ExitStatus;
use results::bench_file::{BenchFile, DeviceClaim, LinkSpec, is_station_name};
use std::fmt::Write as _;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;
use suite::device::Origin;
use suite::model::Manual;

/// How long to wait for a device that another process uses.
const LOCK_WAIT: Duration = Duration::from_secs(60);
/// How long to wait for DCP answers.
const WAIT: Duration = Duration::from_secs(3);

/// Arguments of `encspec bench`.
#[derive(Debug, Args)]
pub(super) struct BenchArgs {
    #[command(subcommand)]
    what: BenchCommand,
}

#[derive(Debug, Subcommand)]
enum BenchCommand {
    /// Write a bench file for a device found on a segment
    Init(InitArgs),
    /// Restore name, address and parameters of a device from the journal of an interrupted run
    Restore(RestoreArgs),
}

#[derive(Debug, Args)]
struct RestoreArgs {
    /// Journal file [default: every open journal in ./encspec-journal]
    journal: Option<PathBuf>,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct InitArgs {
    #[command(flatten)]
    port: PortArgs,
    /// Station name or MAC address of the device, if several answer
    #[arg(long, value_name = "NAME|MAC")]
    station: Option<String>,
    /// File to write [default: standard output]; an existing file is not overwritten
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    suites: Suites,
}

pub(super) fn run(args: &BenchArgs) -> CommandResult {
    match &args.what {
        BenchCommand::Init(args) => init(args),
        BenchCommand::Restore(args) => restore(args),
    }
}

fn restore(args: &RestoreArgs) -> CommandResult {
    let read = |path: &PathBuf| journal::read(path).map_err(|error| CommandError::usage(error.to_string()));
    let journals = match &args.journal {
        Some(path) => vec![(path.clone(), read(path)?)],
        None => journal::unrestored(Path::new(journal::FOLDER)),
    };
    if journals.is_empty() {
        print_message(&format!("nothing to restore: no open journal in {}", journal::FOLDER));
    }
    let mut status = ExitStatus::Green;
    let mut journals = journals.into_iter();
    // One journal per call: opening the first link drops the privileges that the next one would need.
    if let Some((path, contents)) = journals.next() {
        if !contents.is_open() {
            show(&format!("{}: nothing to restore, the journal is closed\n", path.display()));
            return Ok(ExitStatus::Green);
        }
        let left = restore_device(&contents, &args.suites)?;
        if left.is_empty() {
            let closed = Journal::resume(&path).and_then(|mut journal| journal.add(&JournalEntry::Restored));
            closed.map_err(|error| CommandError::bench(format!("{} cannot be closed: {error}", path.display())))?;
            show(&format!("{}: restored the state found at {}\n", path.display(), contents.found.link));
        } else {
            show(&format!("{}: not restored: {}\n", path.display(), left.join(", ")));
            status = ExitStatus::Red;
        }
    }
    if journals.len() > 0 {
        show(&format!("{} more to restore: run `encspec bench restore` again\n", journals.len()));
        status = ExitStatus::Red;
    }
    Ok(status)
}

/// Finds the device of a journal by its MAC address or station address, and restores what the run changed. Returns what could not
/// be restored.
fn restore_device(contents: &journal::JournalContent, suites: &Suites) -> Result<Vec<String>, CommandError> {
    let journal::InitialDevice { link, bench, manual, variant, mac, station, .. } = &contents.found;
    let manuals = suites.load()?;
    let mut bench = match bench {
        Some(path) if path.exists() => super::live::LiveTarget::File(path.clone()).bench(&manuals)?,
        _ => {
            let known = link.split_once(':').and_then(|(kind, address)| LinkSpec::of(kind, address));
            let unknown = || CommandError::usage(format!("the journal has an unknown link: {link}"));
            let link = known.ok_or_else(unknown)?;
            BenchFile::bare(link, DeviceClaim { manual: manual.clone(), variant: variant.clone() })
        }
    };
    let unreadable = |_| CommandError::usage(format!("the journal has an invalid MAC address: {}", mac.escape_debug()));
    match station {
        Some(station) => bench.line.address = Some(*station),
        None => bench.mac = Some(mac.parse().map_err(unreadable)?),
    }
    let _lock = super::live::lock(&bench, LOCK_WAIT)?;
    bench.station_name = None;
    (bench.consent.set_name, bench.consent.set_ip, bench.consent.set_address) = (true, true, true);
    if bench.ip.is_none() && !contents.found.ip.is_unspecified() {
        bench.ip = Some(contents.found.ip);
    }
    let dut = super::live::open(bench, suites, false, None)?;
    let live = dut.live().ok_or_else(|| CommandError::bench("the device of the journal is not a live device"))?;
    if let Some(why) = live.passive() {
        return Err(CommandError::bench(format!("nothing was restored: {why}")));
    }
    let (was, is) = (&contents.found, live.found());
    if (was.vendor_id, was.device_id) != (is.vendor_id, is.device_id) {
        let device = station.map_or_else(|| mac.clone(), |station| format!("the slave at station {station}"));
        return Err(CommandError::bench(format!("{device} is not the device of the journal; nothing was restored")));
    }
    let changed = |word: &str| contents.changes.iter().any(|change| change.starts_with(word));
    let wrote_parameters = changed("parameters");
    let parameters = if wrote_parameters { contents.parameters.as_slice() } else { &[] };
    let retained = engine::ParameterBackup { parameters, wrote_parameters, saved: changed("nvm_write") };
    let left = engine::restore_device(&dut, was, &retained).map_err(|error| CommandError::bench(error.to_string()))?;
    // This restores also what was changed here to reach the device. The journal of the run stays open until everything is restored.
    live.note(&JournalEntry::Restored).map_err(CommandError::bench)?;
    Ok(left)
}

fn init(args: &InitArgs) -> CommandResult {
    if let Some(path) = args.output.as_deref().filter(|path| path.exists()) {
        return Err(CommandError::usage(format!(
            "{} already exists; choose another name or remove it",
            path.display()
        )));
    }
    let manuals = args.suites.load()?;
    let (survey, _) = args.port.survey(WAIT)?;
    survey.remarks.iter().for_each(|remark| print_message(remark));
    let found = choose_station(&survey.stations, args.station.as_deref())?;
    let claim = find_fitting_manual(found, &manuals);
    let text = text(&args.port.spec(), found, &claim);
    if claim.manual.is_none() {
        print_message("there is no suite for this device; the bench file needs a `description`");
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

/// Writes a new file. An existing file is not overwritten.
fn write(path: &Path, text: &str) -> Result<(), CommandError> {
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| CommandError::usage(format!("{} cannot be written: {error}", path.display())))
}

/// The station that `--station` names, or the only device.
fn choose_station<'f>(
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

/// The manual that fits a discovered device.
struct FittingManual<'m> {
    manual: Option<&'m Manual>,
    /// Vendor and device ID are those of the manual; otherwise only the vendor ID is.
    certain: bool,
}

fn find_fitting_manual<'m>(found: &DiscoveredStation, manuals: &'m [Manual]) -> FittingManual<'m> {
    let same = |manual: &&Manual| found.ids.is_some() && manual.device.ids() == found.ids;
    let similar = |manual: &&Manual| {
        let vendor = |ids: Option<(u16, u16)>| ids.map(|(vendor, _)| vendor);
        let of_vendor = found.ids.is_some() && vendor(manual.device.ids()) == vendor(found.ids);
        of_vendor && manual.device.bus.number_origin() == Origin::Invented
    };
    let named = |manual: &&Manual| {
        manual.device.profinet().is_some_and(|facts| facts.identity.station_type == found.station_type)
    };
    let certain = manuals.iter().filter(same).find(named).or_else(|| manuals.iter().find(same));
    let perhaps = || manuals.iter().filter(similar).find(named).or_else(|| manuals.iter().find(similar));
    FittingManual { certain: certain.is_some(), manual: certain.or_else(perhaps) }
}

/// The text of the bench file.
fn text(link: &LinkSpec, found: &DiscoveredStation, claim: &FittingManual<'_>) -> String {
    let mut out = String::new();
    let name = if found.name.is_empty() { "no name".to_owned() } else { found.printable_name() };
    let numbers = found.ids.map_or_else(
        || "no vendor and device ID".to_owned(),
        |(vendor, device)| format!("vendor 0x{vendor:04X}, device 0x{device:04X}"),
    );
    // Writing into a String cannot fail.
    let _ = writeln!(
        out,
        "# Bench file of encspec. Found: {} ({name}), {numbers}, type `{}`.",
        found.mac, found.station_type
    );
    match claim.manual.map(|manual| &manual.device) {
        Some(device) => {
            if !claim.certain {
                let _ = writeln!(out, "# The vendor fits this manual, which prints no device ID: is it the right one?");
            }
            let (first, others) = device.variants.split_first().map_or(("", &[][..]), |(first, rest)| (first, rest));
            let _ = writeln!(out, "device: {}/{first}", device.name);
            for other in others {
                let _ = writeln!(out, "#       {}/{other}", device.name);
            }
        }
        None => {
            let _ = writeln!(
                out,
                "# There is no suite for this device. Describe it in a file with the keys of device.yaml."
            );
            let _ = writeln!(out, "device: none\ndescription: my-device.yaml");
        }
    }
    let _ = writeln!(out, "link: {link}");
    match std::str::from_utf8(&found.name).ok().filter(|name| is_station_name(name)) {
        Some(name) => {
            let _ = writeln!(out, "station_name: {name}");
        }
        None => {
            let _ =
                writeln!(out, "# The device has no valid name; a run sets this one only with the consent `set_name`.");
            let _ = writeln!(out, "# station_name: encoder-1");
        }
    }
    let _ = writeln!(out, "mac: {}", found.mac);
    if let Some(ip) = found.ip {
        let _ = writeln!(out, "ip: {}\nmask: {}", ip.address, ip.mask);
    } else {
        let _ = writeln!(out, "# The device has no IP address; a run sets this one until power-off.\nip: 192.168.0.10");
    }
    out.push_str(REST);
    out
}

/// The keys that discovery cannot know, commented out.
const REST: &str = "
# The vendor's description of the device, and the ledger of known failures.
# gsdml: GSDML-....xml
# ledger: known-failures.yaml

# Web pages whose path and contents the manual does not print; `{}` for a page that is as in device.yaml.
# pages:
#   information: {}

# LLDP stops at a switch. Its cases run only if the cable ends at the device.
# direct_cable: true

# What controls power, shaft and faults. Without it, cases that turn the shaft, switch the power or read LEDs are not applicable.
# stand:
#   hooks: { power: 'relay 1 {value}' }
#   ask: [turn]
#   shaft: [hand]

# Lasting changes that are allowed. Without a consent, the cases that need it are not applicable.
# consent:
#   set_name: true
#   set_ip: true
#   factory_reset: true
#   nvm_write: 50
#   position_reference: true
#   firmware: true
#   overstress: true
#   alone: true
";

#[cfg(test)]
mod tests;
