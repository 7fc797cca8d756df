//! `encspec bench`: bench files from what is found, and what a run has changed put back.

use super::port::PortArgs;
use super::{Ended, Stop, Suites, complain, show};
use clap::{Args, Subcommand};
use engine;
use live::discover::Found;
use live::journal::{self, Entry, Journal};
use report::ExitStatus;
use results::bench_file::{BenchFile, Claim, LinkSpec, is_station_name};
use std::fmt::Write as _;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;
use suite::device::Origin;
use suite::model::Manual;

/// How long another process may go on using the device.
const LOCK_WAIT: Duration = Duration::from_secs(60);
/// How long answers are awaited.
const WAIT: Duration = Duration::from_secs(3);

/// Arguments of `encspec bench`.
#[derive(Debug, Args)]
pub(super) struct BenchArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Write a bench file for a device that is found on a segment
    Init(InitArgs),
    /// Put back what a run that broke off has changed: name, address and parameters, from its journal
    Restore(RestoreArgs),
}

#[derive(Debug, Args)]
struct RestoreArgs {
    /// The journal; every one below encspec-journal that is still open by default
    journal: Option<PathBuf>,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct InitArgs {
    #[command(flatten)]
    port: PortArgs,
    /// The station name or the MAC address of the device, where there are several
    #[arg(long, value_name = "NAME|MAC")]
    station: Option<String>,
    /// The file to be written; without it the standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    suites: Suites,
}

pub(super) fn run(args: &BenchArgs) -> Ended {
    match &args.what {
        What::Init(args) => init(args),
        What::Restore(args) => restore(args),
    }
}

fn restore(args: &RestoreArgs) -> Ended {
    let read = |path: &PathBuf| journal::read(path).map_err(|error| Stop::usage(error.to_string()));
    let journals = match &args.journal {
        Some(path) => vec![(path.clone(), read(path)?)],
        None => journal::open_ones(Path::new(journal::FOLDER)),
    };
    if journals.is_empty() {
        complain(&format!("nothing is left to be put back: no journal below {} is open", journal::FOLDER));
    }
    let mut status = ExitStatus::Green;
    let mut journals = journals.into_iter();
    // One at a time: privileges are given up with the first link that is opened.
    if let Some((path, kept)) = journals.next() {
        if !kept.is_open() {
            show(&format!("{}: everything is as it was found\n", path.display()));
            return Ok(ExitStatus::Green);
        }
        let left = put_back(&kept, &args.suites)?;
        if left.is_empty() {
            let closed = Journal::resume(&path).and_then(|mut journal| journal.add(&Entry::Restored));
            closed.map_err(|error| Stop::bench(format!("{} cannot be closed: {error}", path.display())))?;
            show(&format!("{}: put back as it was found on {}\n", path.display(), kept.found.link));
        } else {
            show(&format!("{}: not put back: {}\n", path.display(), left.join(", ")));
            status = ExitStatus::Red;
        }
    }
    if journals.len() > 0 {
        show(&format!("{} more to be put back: call `encspec bench restore` again\n", journals.len()));
        status = ExitStatus::Red;
    }
    Ok(status)
}

/// Finds the device of a journal by its MAC address, whatever its name is now, or by its station address, and gives it back what was
/// changed.
fn put_back(kept: &journal::Kept, suites: &Suites) -> Result<Vec<String>, Stop> {
    let journal::Found { link, bench, manual, variant, mac, station, .. } = &kept.found;
    let manuals = suites.load()?;
    let mut bench = match bench {
        Some(path) if path.exists() => super::live::Asked::File(path.clone()).bench(&manuals)?,
        _ => {
            let known = link.split_once(':').and_then(|(kind, address)| LinkSpec::of(kind, address));
            let unknown = || Stop::usage(format!("the journal names no link that is known: {link}"));
            let link = known.ok_or_else(unknown)?;
            BenchFile::bare(link, Claim { manual: manual.clone(), variant: variant.clone() })
        }
    };
    let unreadable =
        |_| Stop::usage(format!("the journal names no MAC address that can be read: {}", mac.escape_debug()));
    match station {
        Some(station) => bench.line.address = Some(*station),
        None => bench.mac = Some(mac.parse().map_err(unreadable)?),
    }
    let _lock = super::live::lock(&bench, LOCK_WAIT)?;
    bench.station_name = None;
    (bench.consent.set_name, bench.consent.set_ip, bench.consent.set_address) = (true, true, true);
    if bench.ip.is_none() && !kept.found.ip.is_unspecified() {
        bench.ip = Some(kept.found.ip);
    }
    let dut = super::live::open(bench, suites, false, None)?;
    let live = dut.live().ok_or_else(|| Stop::bench("the journal is of no live device"))?;
    if let Some(why) = live.passive() {
        return Err(Stop::bench(format!("nothing is put back now: {why}")));
    }
    let (was, is) = (&kept.found, live.found());
    if (was.vendor_id, was.device_id) != (is.vendor_id, is.device_id) {
        let who = station.map_or_else(|| mac.clone(), |station| format!("the slave at station {station}"));
        return Err(Stop::bench(format!("{who} is another device than the one of the journal; nothing is put back")));
    }
    let changed = |word: &str| kept.changes.iter().any(|change| change.starts_with(word));
    let wrote_parameters = changed("parameters");
    let parameters = if wrote_parameters { kept.parameters.as_slice() } else { &[] };
    let kept = engine::Kept { parameters, wrote_parameters, saved: changed("nvm_write") };
    let left = engine::put_back(&dut, was, &kept).map_err(|error| Stop::bench(error.to_string()))?;
    // What was done here to reach the device is put back with the rest; the journal of the run stays open until all is.
    live.note(&Entry::Restored).map_err(Stop::bench)?;
    Ok(left)
}

fn init(args: &InitArgs) -> Ended {
    if let Some(path) = args.output.as_deref().filter(|path| path.exists()) {
        return Err(Stop::usage(format!("{} is there already; choose another name or take it away", path.display())));
    }
    let manuals = args.suites.load()?;
    let (survey, _) = args.port.survey(WAIT)?;
    survey.remarks.iter().for_each(|remark| complain(remark));
    let found = chosen(&survey.stations, args.station.as_deref())?;
    let claim = claim(found, &manuals);
    let text = text(&args.port.spec(), found, &claim);
    if claim.manual.is_none() {
        complain("there is no suite for this device; the file wants a description of it");
    }
    match &args.output {
        None => show(&text),
        Some(path) => {
            write(path, &text)?;
            complain(&format!("wrote {}; look at its comments, then: encspec run --dut {0}", path.display()));
        }
    }
    Ok(ExitStatus::Green)
}

/// A new file with this text; one that is there is never written over.
fn write(path: &Path, text: &str) -> Result<(), Stop> {
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| Stop::usage(format!("{} cannot be written: {error}", path.display())))
}

/// The only device, or the one that is meant.
fn chosen<'f>(stations: &'f [Found], meant: Option<&str>) -> Result<&'f Found, Stop> {
    let is_meant = |found: &&Found| match meant {
        Some(word) => {
            found.name == word.as_bytes() || found.mac.to_string() == word.to_ascii_lowercase().replace('-', ":")
        }
        None => found.roles.contains(&"device") || found.roles.is_empty(),
    };
    let list = || stations.iter().map(|found| format!("{} {}", found.mac, found.shown_name())).collect::<Vec<_>>();
    let mut meant_ones = stations.iter().filter(is_meant);
    match (meant_ones.next(), meant_ones.next(), meant) {
        (Some(found), None, _) => Ok(found),
        (Some(_), Some(_), _) => {
            Err(Stop::usage(format!("several stations can be meant; say which with --station: {}", list().join(", "))))
        }
        (None, _, Some(word)) if !stations.is_empty() => {
            Err(Stop::usage(format!("no station is called {}; there are {}", word.escape_default(), list().join(", "))))
        }
        (None, ..) => Err(Stop::bench("no device answered; is it switched on and connected here?")),
    }
}

/// What a device may claim to be.
struct Claimed<'m> {
    manual: Option<&'m Manual>,
    /// Its numbers are those of the manual, not only its vendor.
    certain: bool,
}

fn claim<'m>(found: &Found, manuals: &'m [Manual]) -> Claimed<'m> {
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
    Claimed { certain: certain.is_some(), manual: certain.or_else(perhaps) }
}

/// The text of the bench file.
fn text(link: &LinkSpec, found: &Found, claim: &Claimed<'_>) -> String {
    let mut out = String::new();
    let name = if found.name.is_empty() { "no name yet".to_owned() } else { found.shown_name() };
    let numbers = found.ids.map_or_else(
        || "no numbers".to_owned(),
        |(vendor, device)| format!("vendor 0x{vendor:04X}, device 0x{device:04X}"),
    );
    // Writing into a String cannot fail.
    let _ = writeln!(
        out,
        "# A bench file of encspec. Found: {} ({name}), {numbers}, type `{}`.",
        found.mac, found.station_type
    );
    match claim.manual.map(|manual| &manual.device) {
        Some(device) => {
            if !claim.certain {
                let _ = writeln!(
                    out,
                    "# Vendor and kind fit this manual, which prints no device number: is it the right one?"
                );
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
                "# There is no suite for it. Without one it needs a description in the words of device.yaml."
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
            let _ = writeln!(out, "# It has no proper name; a run gives it this one only with the consent `set_name`.");
            let _ = writeln!(out, "# station_name: encoder-1");
        }
    }
    let _ = writeln!(out, "mac: {}", found.mac);
    if let Some(ip) = found.ip {
        let _ = writeln!(out, "ip: {}\nmask: {}", ip.address, ip.mask);
    } else {
        let _ =
            writeln!(out, "# It has no address; a run gives it this one until it is switched off.\nip: 192.168.0.10");
    }
    out.push_str(REST);
    out
}

/// What only somebody who knows the bench can say.
const REST: &str = "
# What the vendor says of it, and what is known not to work.
# gsdml: GSDML-....xml
# ledger: known-failures.yaml

# Web pages of which the manual prints neither place nor looks; `{}` for one that is as device.yaml says.
# pages:
#   information: {}

# LLDP stops at a switch; its cases run only where our cable ends at the device.
# direct_cable: true

# What holds it. Without this, cases that turn the shaft, cut the power or look at LEDs are not applicable.
# stand:
#   hooks: { power: 'relay 1 {value}' }
#   ask: [turn]
#   shaft: [hand]

# What may be done to it that lasts. Without this nothing is, and the cases that need it are not applicable.
# consent:
#   set_name: true
#   set_ip: true
#   factory_reset: true
#   nvm_write: 50
#   position_reference: true
#   firmware: true
#   alone: true
";

#[cfg(test)]
mod tests;
