//! The capture of a trial: its frames, with the step as comment on the first frame of each step.

use super::options::RunOptions;
use judge::observe::link_type;
use results::outcome::CaseResult;
use results::verdict::{Colour, Verdict};
use station::Time;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::Path;
use suite::model::{Manual, SuiteVariant};
use virtual_wire::capture::LinkType;
use virtual_wire::{PcapngWriter, Trace};

/// Writes the capture of a trial if requested: of every trial, or of failed ones. The time at which a live trial began is added to
/// the times of its frames.
pub fn write_captures(
    mut case: CaseResult,
    manual: &Manual,
    variant: &SuiteVariant,
    (trace, began): (&Trace, Time),
    options: &RunOptions,
) -> CaseResult {
    let link = link_type(manual.device.bus.kind());
    let red = case.verdict.colour() == Colour::Red && case.verdict != Verdict::NotRun;
    let targets = [(&options.record, true), (&options.evidence, red)];
    for folder in targets.into_iter().filter(|(_, is_on)| *is_on).filter_map(|(folder, _)| folder.as_ref()) {
        let path = folder.join(file_name(&case.id, &variant.name));
        match write(&path, (trace, began), &case.id, link) {
            Ok(()) => case.evidence = Some(path.display().to_string()),
            Err(error) => case.notes.push(format!("cannot write the capture {}: {error}", path.display())),
        }
    }
    case
}

/// The file name for a trial on a variant.
fn file_name(id: &str, variant: &str) -> String {
    let plain = |letter: char| if letter.is_ascii_alphanumeric() || "-._[]".contains(letter) { letter } else { '_' };
    let (manual, trial) = id.split_once('/').unwrap_or(("", id));
    format!("{manual}/{variant}/{trial}.pcapng").chars().map(plain).collect()
}

fn write(path: &Path, (trace, began): (&Trace, Time), name: &str, link: LinkType) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut writer = PcapngWriter::new(BufWriter::new(File::create(path)?), "encspec")?;
    let interface = writer.interface(name, link)?;
    for frame in trace.iter() {
        writer.packet(interface, began + frame.time.since(Time::ZERO), frame.octets, frame.comment)?;
    }
    writer.finish()?;
    Ok(())
}
