//! `encspec bench restore`: puts a device back as the journal of an interrupted run found it, or closes the journal on purpose.

use super::LOCK_WAIT;
use crate::cli::live::{LiveTarget, lock, open_for};
use crate::cli::{CommandError, CommandResult, Suites, print_message, show};
use clap::Args;
use engine::{DeviceBackup, RestoreOutcome};
use live::journal::{self, InitialDevice, Journal, JournalContent, JournalEntry};
use live::preflight::PreflightPurpose;
use live::stand::LiveStand;
use live::stand::set_back::actions;
use report::ExitStatus;
use results::bench_file::{BenchFile, DeviceClaim, LinkSpec};
use std::path::{Path, PathBuf};
use suite::model::Manual;

/// Arguments of `encspec bench restore`.
#[derive(Debug, Args)]
pub(super) struct RestoreArgs {
    /// Journal file [default: the newest open journal in ./encspec-journal]
    journal: Option<PathBuf>,
    /// Also let the stand set back what the interrupted case had set: power, cable, shaft, faults, switches; the device may start again
    #[arg(long)]
    stand: bool,
    /// Close the journal with this reason and restore nothing
    #[arg(long, value_name = "REASON", conflicts_with = "stand", value_parser = clap::builder::NonEmptyStringValueParser::new())]
    close: Option<String>,
    #[command(flatten)]
    suites: Suites,
}

pub(super) fn run(args: &RestoreArgs) -> CommandResult {
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
        status = match &args.close {
            Some(reason) => close(&path, &contents, reason)?,
            None => restore(&path, &contents, args)?,
        };
    }
    if journals.len() > 0 {
        show(&format!("{} more to restore: run `encspec bench restore` again\n", journals.len()));
        status = ExitStatus::Red;
    }
    Ok(status)
}

/// Closes a journal whose device is not restored.
fn close(path: &Path, contents: &JournalContent, reason: &str) -> CommandResult {
    let entry = JournalEntry::Closed { reason: reason.to_owned() };
    let closed = Journal::resume(path).and_then(|mut journal| journal.add(&entry));
    closed.map_err(|error| CommandError::bench(format!("{} cannot be closed: {error}", path.display())))?;
    let changes = contents.changes.join(", ");
    show(&format!("{}: closed, and nothing was restored of: {changes}\n", path.display()));
    Ok(ExitStatus::Green)
}

/// Restores the device of a journal, and says what was restored, what was assumed and what does not come back.
fn restore(path: &Path, contents: &JournalContent, args: &RestoreArgs) -> CommandResult {
    let mut text = format!("{}: ", path.display());
    let kept =
        DeviceBackup { parameters: &contents.parameters, im_records: &contents.im_records, changes: &contents.changes };
    let outcome = restore_device(path, contents, &kept, args)?;
    let status = if outcome.left.is_empty() {
        text.push_str(&format!("restored the state found at {}: {}\n", contents.found.link, found_text(contents)));
        ExitStatus::Green
    } else {
        text.push_str("not restored, and the journal stays open:\n");
        ExitStatus::Red
    };
    let line = |mark: &str, what: &str| format!("  {mark}{what}\n");
    text.extend(outcome.left.iter().map(|what| line("not restored: ", what)));
    text.extend(outcome.remarks.iter().map(|what| line("note: ", what)));
    text.extend(kept.lost().iter().map(|what| line("does not come back: ", what)));
    show(&text);
    Ok(status)
}

/// What was restored, in words.
fn found_text(contents: &JournalContent) -> String {
    let found = &contents.found;
    if let Some(station) = found.station {
        return format!("station address {station}");
    }
    let name = String::from_utf8_lossy(&found.name).escape_debug().to_string();
    let ip = match found.ip.is_unspecified() {
        true => "no IP address".to_owned(),
        false => {
            format!("IP address {}, mask {}, gateway {} ({})", found.ip, found.mask, found.gateway, found.ip_permanence)
        }
    };
    format!("name `{name}`, {ip}")
}

/// Finds the device of a journal by its MAC address, or on PROFIBUS by its ident number, and restores what the run changed.
fn restore_device(
    path: &Path,
    contents: &JournalContent,
    kept: &DeviceBackup<'_>,
    args: &RestoreArgs,
) -> Result<RestoreOutcome, CommandError> {
    let InitialDevice { mac, station, .. } = &contents.found;
    let manuals = args.suites.load()?;
    let mut bench = bench(&contents.found, &manuals)?;
    match station {
        Some(station) => bench.line.address = Some(*station),
        None => {
            let unreadable =
                |_| CommandError::usage(format!("the journal has an invalid MAC address: {}", mac.escape_debug()));
            bench.mac = Some(mac.parse().map_err(unreadable)?);
        }
    }
    let _lock = lock(&bench, LOCK_WAIT)?;
    // The device keeps the name that it has until its parameters are back; the fence lets only its own address pass.
    bench.station_name = None;
    bench.consent.set_address = true;
    set_stand_back(contents, &bench, &manuals, args)?;
    let purpose = PreflightPurpose::Restore { journal: path, found: &contents.found };
    let dut = open_for(purpose, None, bench, &args.suites, false, None)
        .map_err(|error| CommandError { message: error.message + stand_hint(contents, args), ..error })?;
    let live = dut.live().ok_or_else(|| CommandError::bench("the device of the journal is not a live device"))?;
    if let Some(why) = live.passive() {
        return Err(CommandError::bench(format!("nothing was restored: {why}")));
    }
    // An address that was given to reach the device is a change too.
    let mut changes = contents.changes.clone();
    changes.extend(live.changes().into_iter().filter(|change| !contents.changes.contains(change)));
    let kept = DeviceBackup { changes: &changes, ..*kept };
    let restored = engine::restore_device(&dut, &contents.found, &kept);
    let outcome = restored.map_err(|error| CommandError::bench(error.to_string()))?;
    if outcome.left.is_empty() {
        engine::note_restored(live, &outcome.remarks).map_err(CommandError::bench)?;
    }
    Ok(outcome)
}

/// The bench of the run, from its file, else what the journal says of it.
fn bench(found: &InitialDevice, manuals: &[Manual]) -> Result<BenchFile, CommandError> {
    let InitialDevice { link, bench, manual, variant, .. } = found;
    match bench {
        Some(path) if path.exists() => LiveTarget::File(path.clone()).bench(manuals),
        _ => {
            let known = link.split_once(':').and_then(|(kind, address)| LinkSpec::of(kind, address));
            let unknown = || CommandError::usage(format!("the journal has an unknown link: {link}"));
            let link = known.ok_or_else(unknown)?;
            Ok(BenchFile::bare(link, DeviceClaim { manual: manual.clone(), variant: variant.clone() }))
        }
    }
}

/// Sets the stand back, if `--stand` allows it; otherwise says what an interrupted case has left there.
fn set_stand_back(
    contents: &JournalContent,
    bench: &BenchFile,
    manuals: &[Manual],
    args: &RestoreArgs,
) -> Result<(), CommandError> {
    let Some((trial, set)) = contents.interrupted.as_ref().filter(|(_, set)| !set.is_empty()) else { return Ok(()) };
    if !args.stand {
        print_message(&format!(
            "the case {trial} was interrupted and may have left the stand as it set it ({}); with --stand it is set back",
            set.join(", ")
        ));
        return Ok(());
    }
    let declared = manuals.iter().find(|manual| manual.device.name == bench.claim.manual);
    let declared = declared.map(|manual| manual.device.stand.clone()).unwrap_or_default();
    let set_back = LiveStand::new(&bench.stand).act_in_turn(&actions(set, &declared));
    set_back.map_err(|why| CommandError::bench(format!("the stand cannot be set back: {why}")))
}

/// What to try if the device does not answer after a case that was interrupted.
fn stand_hint(contents: &JournalContent, args: &RestoreArgs) -> &'static str {
    let may_be_off = contents.stand().iter().any(|name| name == "power" || name == "link");
    if may_be_off && !args.stand {
        ". The interrupted case switches power or cable: switch them on, or add --stand"
    } else {
        ""
    }
}
