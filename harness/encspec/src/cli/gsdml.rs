//! `encspec gsdml`: prints a GSDML, compares it with a manual, and saves the GSDML files of the reference devices.

use super::{CommandError, CommandResult, Suites, vendor_file};
use clap::Args;
use description::gsdml::{self, Gsdml};
use std::fs;
use std::path::{Path, PathBuf};

/// Arguments of `encspec gsdml`.
#[derive(Debug, Args)]
pub(super) struct GsdmlArgs {
    /// GSDML file [default: list the built-in GSDML files]
    file: Option<PathBuf>,
    /// Compare the file with this manual
    #[arg(long, value_name = "MANUAL[/VARIANT]")]
    device: Option<String>,
    /// Write the built-in GSDML files, those of the reference devices, to this folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["file", "device"])]
    save: Option<PathBuf>,
    #[command(flatten)]
    suites: Suites,
}

pub(super) fn gsdml(args: &GsdmlArgs) -> CommandResult {
    match (&args.file, &args.save, &args.device) {
        (Some(file), _, device) => one(file, device.as_deref(), &args.suites),
        (None, Some(folder), _) => vendor_file::save(folder, suites::gsdml()),
        (None, None, Some(_)) => {
            Err(CommandError::usage("`--device` needs a GSDML file to compare with; name the file"))
        }
        (None, None, None) => vendor_file::list(suites::gsdml(), "encspec gsdml --save DIR"),
    }
}

/// Reads a GSDML file. The error names the file, line and column.
pub fn open(file: &Path) -> Result<Gsdml, CommandError> {
    let octets = fs::read(file).map_err(|error| CommandError::usage(format!("{}: {error}", file.display())))?;
    gsdml::read_octets(&octets).map_err(|error| {
        let (line, column) = (error.line, error.column);
        CommandError::usage(format!("{}:{line}:{column}: {}", file.display(), plain_text::printable(&error.message)))
    })
}

fn one(file: &Path, device: Option<&str>, suites: &Suites) -> CommandResult {
    let read = open(file)?;
    vendor_file::against(gsdml::show(&read), device, suites, |device, variant| {
        let overlay = gsdml::overlay(&mut device.clone(), variant, Some(&read), None, &[]);
        Ok((gsdml::compare(device, variant, Some(&read), None), overlay))
    })
}
