//! `encspec gsdml`: what a GSDML says, where it disagrees with a manual, and the GSDML files of the reference devices.

use super::dut::claim;
use super::{Ended, Stop, Suites, show};
use crate::gsdml::{self, Gsdml};
use crate::report::{ExitStatus, finding};
use crate::result::Severity;
use crate::suite::model::Manual;
use clap::Args;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Arguments of `encspec gsdml`.
#[derive(Debug, Args)]
pub(super) struct GsdmlArgs {
    /// A GSDML file; without one the built-in ones of the reference devices are listed
    file: Option<PathBuf>,
    /// Compare it with this manual
    #[arg(long, value_name = "MANUAL[/VARIANT]")]
    device: Option<String>,
    /// Write the built-in GSDML files into this folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["file", "device"])]
    save: Option<PathBuf>,
    #[command(flatten)]
    suites: Suites,
}

pub(super) fn gsdml(args: &GsdmlArgs) -> Ended {
    match (&args.file, &args.save, &args.device) {
        (Some(file), _, device) => one(file, device.as_deref(), &args.suites),
        (None, Some(folder), _) => save(folder, gsdml::embedded()),
        (None, None, Some(_)) => Err(Stop::usage("`--device` needs a GSDML file to compare with: name it")),
        (None, None, None) => {
            let mut out = String::new();
            for (path, _) in gsdml::embedded() {
                // Writing into a String cannot fail.
                let _ = writeln!(out, "{path}");
            }
            out.push_str("`encspec gsdml --save DIR` writes them into a folder.\n");
            show(&out);
            Ok(ExitStatus::Green)
        }
    }
}

/// The GSDML in a file.
///
/// Fails with one sentence that names the file, and the place where it is broken.
pub fn open(file: &Path) -> Result<Gsdml, Stop> {
    let octets = fs::read(file).map_err(|error| Stop::usage(format!("{}: {error}", file.display())))?;
    gsdml::read_octets(&octets).map_err(|error| {
        let (line, column) = (error.line, error.column);
        Stop::usage(format!("{}:{line}:{column}: {}", file.display(), crate::report::printable(&error.message)))
    })
}

fn one(file: &Path, device: Option<&str>, suites: &Suites) -> Ended {
    let read = open(file)?;
    let Some(device) = device else {
        show(&gsdml::show(&read));
        return Ok(ExitStatus::Green);
    };
    let manuals = suites.load()?;
    let mut out = gsdml::show(&read);
    let mut status = ExitStatus::Green;
    for (manual, variant) in claim(device, &manuals).map_err(Stop::usage)? {
        if against(&mut out, &read, manual, variant) {
            status = ExitStatus::Red;
        }
    }
    show(&out);
    Ok(status)
}

/// Writes where manual and GSDML disagree; returns whether something of it is an error.
fn against(out: &mut String, read: &Gsdml, manual: &Manual, variant: &str) -> bool {
    let device = &manual.device;
    let index = device.variants.iter().position(|of| of == variant).unwrap_or_default();
    let findings = gsdml::compare(device, index, Some(read), None);
    let overlay = gsdml::overlay(&mut (**device).clone(), index, Some(read), None);
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

/// Writes built-in files into a folder.
pub(super) fn save(folder: &Path, files: &[(&str, &str)]) -> Ended {
    let failed = |path: &Path, error: &std::io::Error| Stop::usage(format!("{}: {error}", path.display()));
    fs::create_dir_all(folder).map_err(|error| failed(folder, &error))?;
    let mut out = String::new();
    for (path, text) in files {
        let name = path.rsplit('/').next().unwrap_or(path);
        let to = folder.join(name);
        fs::write(&to, text).map_err(|error| failed(&to, &error))?;
        // Writing into a String cannot fail.
        let _ = writeln!(out, "{}", to.display());
    }
    show(&out);
    Ok(ExitStatus::Green)
}
