//! What a trial leaves behind: a capture with its frames and the step beside the first frame of each.

use super::options::RunOptions;
use judge::observe::link_type;
use results::outcome::CaseResult;
use results::verdict::{Colour, Verdict};
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::Path;
use suite::model::{Manual, Variant};
use virtual_wire::capture::LinkType;
use virtual_wire::{PcapngWriter, Trace};

/// Writes the capture of a trial where it is asked for: of every trial, or of those that failed.
pub fn keep(
    mut case: CaseResult,
    manual: &Manual,
    variant: &Variant,
    trace: &Trace,
    options: &RunOptions,
) -> CaseResult {
    let link = link_type(manual.device.bus.kind());
    let red = case.verdict.colour() == Colour::Red && case.verdict != Verdict::NotRun;
    let wanted = [(&options.record, true), (&options.evidence, red)];
    for folder in wanted.into_iter().filter(|(_, wanted)| *wanted).filter_map(|(folder, _)| folder.as_ref()) {
        let path = folder.join(file_name(&case.id, &variant.name));
        match write(&path, trace, &case.id, link) {
            Ok(()) => case.evidence = Some(path.display().to_string()),
            Err(error) => case.notes.push(format!("the capture {} could not be written: {error}", path.display())),
        }
    }
    case
}

/// The name of a trial on a variant as the name of a file.
fn file_name(id: &str, variant: &str) -> String {
    let plain = |letter: char| if letter.is_ascii_alphanumeric() || "-._[]".contains(letter) { letter } else { '_' };
    let (manual, trial) = id.split_once('/').unwrap_or(("", id));
    format!("{manual}/{variant}/{trial}.pcapng").chars().map(plain).collect()
}

fn write(path: &Path, trace: &Trace, name: &str, link: LinkType) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut writer = PcapngWriter::new(BufWriter::new(File::create(path)?), "encspec")?;
    let interface = writer.interface(name, link)?;
    for frame in trace.iter() {
        writer.packet(interface, frame.time, frame.octets, frame.comment)?;
    }
    writer.finish()?;
    Ok(())
}
