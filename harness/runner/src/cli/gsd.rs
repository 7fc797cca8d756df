//! `encspec gsd`: what a GSD says, where it disagrees with a manual, and the GSD files of the reference devices.

use super::dut::claim;
use super::{Ended, Stop, Suites, show};
use crate::gsd::{self, Gsd};
use crate::report::{ExitStatus, finding};
use crate::result::Severity;
use crate::suite::model::Manual;
use clap::Args;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Arguments of `encspec gsd`.
#[derive(Debug, Args)]
pub(super) struct GsdArgs {
    /// A GSD file; without one the built-in ones of the reference devices are listed
    file: Option<PathBuf>,
    /// Compare it with this manual
    #[arg(long, value_name = "MANUAL[/VARIANT]")]
    device: Option<String>,
    /// Write the built-in GSD files into this folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["file", "device"])]
    save: Option<PathBuf>,
    #[command(flatten)]
    suites: Suites,
}

pub(super) fn gsd(args: &GsdArgs) -> Ended {
    match (&args.file, &args.save, &args.device) {
        (Some(file), _, device) => one(file, device.as_deref(), &args.suites),
        (None, Some(folder), _) => super::gsdml::save(folder, gsd::embedded()),
        (None, None, Some(_)) => Err(Stop::usage("`--device` needs a GSD file to compare with: name it")),
        (None, None, None) => {
            let names: String = gsd::embedded().iter().map(|(path, _)| format!("{path}\n")).collect();
            show(&(names + "`encspec gsd --save DIR` writes them into a folder.\n"));
            Ok(ExitStatus::Green)
        }
    }
}

/// The GSD in a file.
///
/// Fails with one sentence that names the file, and the line where it is broken.
pub(super) fn open(file: &Path) -> Result<Gsd, Stop> {
    let octets = fs::read(file).map_err(|error| Stop::usage(format!("{}: {error}", file.display())))?;
    gsd::read_octets(&octets).map_err(|error| {
        Stop::usage(format!("{}:{}: {}", file.display(), error.line, crate::report::printable(&error.message)))
    })
}

fn one(file: &Path, device: Option<&str>, suites: &Suites) -> Ended {
    let read = open(file)?;
    let mut out = gsd::show(&read);
    let mut status = ExitStatus::Green;
    if let Some(device) = device {
        let manuals = suites.load()?;
        for (manual, variant) in claim(device, &manuals).map_err(Stop::usage)? {
            if manual.device.slave.is_none() {
                let name = &manual.device.name;
                return Err(Stop::usage(format!("{name} is on PROFINET, whose descriptions are GSDML files")));
            }
            if against(&mut out, &read, manual, variant) {
                status = ExitStatus::Red;
            }
        }
    }
    show(&out);
    Ok(status)
}

/// Writes where manual and GSD disagree; returns whether something of it is an error.
fn against(out: &mut String, read: &Gsd, manual: &Manual, variant: &str) -> bool {
    let device = &manual.device;
    let index = device.variants.iter().position(|of| of == variant).unwrap_or_default();
    let findings = gsd::compare(device, index, read);
    let overlay = gsd::overlay(&mut (**device).clone(), Some(read));
    // Writing into a String cannot fail.
    let _ = writeln!(out, "\nagainst {}/{variant}", device.name);
    for taken in &overlay.taken {
        let _ = writeln!(out, "  taken over: {taken}");
    }
    for missing in &overlay.missing {
        let _ = writeln!(out, "  still unknown: {missing}");
    }
    if findings.is_empty() {
        out.push_str("  no disagreement\n");
    }
    findings.iter().for_each(|of| out.push_str(&finding(of)));
    findings.iter().any(|of| of.severity == Severity::Error)
}
