//! `encspec gsd`: prints a GSD, compares it with a manual, and saves the GSD files of the reference devices.

use super::{CommandError, CommandResult, Suites, vendor_file};
use clap::Args;
use description::gsd::{self, Gsd};
use std::fs;
use std::path::{Path, PathBuf};

/// Arguments of `encspec gsd`.
#[derive(Debug, Args)]
pub(super) struct GsdArgs {
    /// GSD file [default: list the built-in GSD files]
    file: Option<PathBuf>,
    /// Compare the file with this manual
    #[arg(long, value_name = "MANUAL[/VARIANT]")]
    device: Option<String>,
    /// Write the built-in GSD files, those of the reference devices, to this folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["file", "device"])]
    save: Option<PathBuf>,
    #[command(flatten)]
    suites: Suites,
}

pub(super) fn gsd(args: &GsdArgs) -> CommandResult {
    match (&args.file, &args.save, &args.device) {
        (Some(file), _, device) => one(file, device.as_deref(), &args.suites),
        (None, Some(folder), _) => vendor_file::save(folder, suites::gsd()),
        (None, None, Some(_)) => Err(CommandError::usage("`--device` needs a GSD file to compare with; name the file")),
        (None, None, None) => vendor_file::list(suites::gsd(), "encspec gsd --save DIR"),
    }
}

/// Reads a GSD file. The error names the file and the line.
pub(super) fn open(file: &Path) -> Result<Gsd, CommandError> {
    let octets = fs::read(file).map_err(|error| CommandError::usage(format!("{}: {error}", file.display())))?;
    gsd::read_octets(&octets).map_err(|error| {
        CommandError::usage(format!("{}:{}: {}", file.display(), error.line, plain_text::printable(&error.message)))
    })
}

fn one(file: &Path, device: Option<&str>, suites: &Suites) -> CommandResult {
    let read = open(file)?;
    vendor_file::against(gsd::show(&read), device, suites, |device, variant| {
        if device.profibus().is_none() {
            let name = &device.name;
            return Err(CommandError::usage(format!(
                "{name} is a PROFINET device; use `encspec gsdml` with its GSDML file"
            )));
        }
        let overlay = gsd::overlay(&mut device.clone(), Some(&read), &[]);
        Ok((gsd::compare(device, variant, &read), overlay))
    })
}
