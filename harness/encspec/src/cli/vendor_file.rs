//! Shared by `encspec gsd` and `encspec gsdml`: compares a device description with a manual, and saves the built-in descriptions.

use super::dut::claim;
use super::{CommandError, CommandResult, Suites, show};
use description::gsd::Gsd;
use description::gsdml::{Gsdml, Overlay};
use report::{ExitStatus, finding};
use results::outcome::{DescriptionKind, DeviceFinding, FindingSeverity};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use suite::device::DeviceDescription;

/// A vendor's description that was read.
pub(super) struct DescriptionFile {
    pub kind: DescriptionKind,
    pub path: PathBuf,
    contents: DescriptionContents,
}

enum DescriptionContents {
    Gsdml(Gsdml),
    Gsd(Gsd),
}

impl DescriptionFile {
    /// Reads a file. The error names it and the line.
    pub fn open(kind: DescriptionKind, path: &Path) -> Result<DescriptionFile, CommandError> {
        let contents = match kind {
            DescriptionKind::Gsdml => DescriptionContents::Gsdml(super::gsdml::open(path)?),
            DescriptionKind::Gsd => DescriptionContents::Gsd(super::gsd::open(path)?),
        };
        Ok(DescriptionFile { kind, path: path.to_owned(), contents })
    }

    pub fn gsdml(&self) -> Option<&Gsdml> {
        match &self.contents {
            DescriptionContents::Gsdml(gsdml) => Some(gsdml),
            DescriptionContents::Gsd(_) => None,
        }
    }

    pub fn gsd(&self) -> Option<&Gsd> {
        match &self.contents {
            DescriptionContents::Gsd(gsd) => Some(gsd),
            DescriptionContents::Gsdml(_) => None,
        }
    }

    /// What the description adds to the device of a manual.
    pub fn overlay(&self, device: &mut DeviceDescription, variant: usize) -> Overlay {
        match &self.contents {
            DescriptionContents::Gsdml(gsdml) => description::gsdml::overlay(device, variant, Some(gsdml), None, &[]),
            DescriptionContents::Gsd(gsd) => description::gsd::overlay(device, Some(gsd), &[]),
        }
    }
}

/// Prints `text`, the contents of a description, and its disagreements with each variant that `claimed` names.
///
/// `compare` compares the description with a device and the index of one of its variants.
pub(super) fn against(
    mut text: String,
    claimed: Option<&str>,
    suites: &Suites,
    compare: impl Fn(&DeviceDescription, usize) -> Result<(Vec<DeviceFinding>, Overlay), CommandError>,
) -> CommandResult {
    let mut status = ExitStatus::Green;
    if let Some(claimed) = claimed {
        let manuals = suites.load()?;
        for (manual, variant) in claim(claimed, &manuals).map_err(CommandError::usage)? {
            let device = &manual.device;
            let index = device.variants.iter().position(|of| of == variant).unwrap_or_default();
            let (findings, overlay) = compare(device, index)?;
            write(&mut text, &format!("{}/{variant}", device.name), &findings, &overlay);
            if findings.iter().any(|of| of.severity == FindingSeverity::Error) {
                status = ExitStatus::Red;
            }
        }
    }
    show(&text);
    Ok(status)
}

fn write(text: &mut String, variant: &str, findings: &[DeviceFinding], overlay: &Overlay) {
    // Writing into a String cannot fail.
    let _ = writeln!(text, "\ncompared with {variant}");
    for taken in &overlay.taken {
        let _ = writeln!(text, "  used: {taken}");
    }
    for missing in &overlay.missing {
        let _ = writeln!(text, "  unknown: {missing}");
    }
    if findings.is_empty() {
        text.push_str("  no disagreements\n");
    }
    findings.iter().for_each(|of| text.push_str(&finding(of)));
}

/// Lists built-in files. `save` is the command that saves them.
pub(super) fn list(files: &[(&str, &str)], save: &str) -> CommandResult {
    let names: String = files.iter().map(|(path, _)| format!("{path}\n")).collect();
    show(&format!("{names}`{save}` saves them to a folder.\n"));
    Ok(ExitStatus::Green)
}

/// Saves built-in files to a folder.
pub(super) fn save(folder: &Path, files: &[(&str, &str)]) -> CommandResult {
    let failed = |path: &Path, error: &std::io::Error| CommandError::usage(format!("{}: {error}", path.display()));
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
