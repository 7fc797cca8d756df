//! Recordings of the reference devices, as captures in memory that a test can modify.

use encspec::engine::{DutKind, DutSpec, RunOptions, run_trial};
use encspec::observe::link_type;
use encspec::replay::{CaptureBlame, CaptureFinding, CaptureReport, FindingSeverity, capture};
use encspec::suite::model::{Manual, Trial};
use station::Time;
use virtual_wire::capture::LinkType;
use virtual_wire::{PcapngWriter, Trace};

/// The frames of a trial.
#[derive(Clone)]
pub struct TrialRecording {
    /// Manual, variant, trial and bugs, for messages.
    pub name: String,
    pub link: LinkType,
    pub frames: Vec<(Time, Vec<u8>)>,
}

/// Records a trial of the first variant of a manual on its reference device with these bugs.
pub fn record(manual: &Manual, trial: &Trial, bugs: &[&str]) -> TrialRecording {
    let variant = &manual.variants[0];
    let kind = DutKind::Model { deviations: bugs.iter().map(|bug| (*bug).to_owned()).collect() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run");
    let link = link_type(manual.device.bus.kind());
    let frames = outcome.trace.iter().map(|frame| (frame.time, frame.octets.to_vec())).collect();
    TrialRecording { name: format!("{}/{} {} {bugs:?}", manual.device.name, variant.name, trial.id), link, frames }
}

/// Records some trials of a manual, evenly spread, whose recordings are small and have cyclic data.
pub fn some(manual: &Manual, count: usize) -> Vec<TrialRecording> {
    let trials = &manual.variants[0].trials;
    let step = (trials.len() / (count * 4)).max(1);
    let recordings = trials.iter().step_by(step).map(|trial| record(manual, trial, &[]));
    recordings.filter(|recording| (60..700).contains(&recording.frames.len())).take(count).collect()
}

impl TrialRecording {
    pub fn file(&self) -> Vec<u8> {
        file(self.link, self.frames.iter())
    }

    pub fn replayed(&self, manuals: &[Manual]) -> CaptureReport {
        capture(&self.name, &self.file()[..], manuals).expect("a capture")
    }

    /// A copy with changed frames.
    pub fn changed(&self, change: impl FnOnce(&mut Vec<(Time, Vec<u8>)>)) -> TrialRecording {
        let mut changed = self.clone();
        change(&mut changed.frames);
        changed
    }
}

/// A trace of a device of this manual as a capture file, with its comments.
pub fn trace_file(manual: &Manual, trace: &Trace) -> Vec<u8> {
    let mut writer = PcapngWriter::new(Vec::new(), "made by a test").expect("a vector takes all");
    let interface = writer.interface("wire", link_type(manual.device.bus.kind())).expect("a vector takes all");
    for frame in trace.iter() {
        writer.packet(interface, frame.time, frame.octets, frame.comment).expect("a vector takes all");
    }
    writer.finish().expect("a vector takes all")
}

/// Frames as a capture file.
pub fn file<'f>(link: LinkType, frames: impl Iterator<Item = &'f (Time, Vec<u8>)>) -> Vec<u8> {
    let mut writer = PcapngWriter::new(Vec::new(), "made by a test").expect("a vector takes all");
    let interface = writer.interface("wire", link).expect("a vector takes all");
    for (time, octets) in frames {
        writer.packet(interface, *time, octets, None).expect("a vector takes all");
    }
    writer.finish().expect("a vector takes all")
}

/// The errors that blame a device. Findings that a device reports itself, such as a diagnosis, are not among them.
pub fn against_devices(report: &CaptureReport) -> Vec<&CaptureFinding> {
    report
        .findings
        .iter()
        .filter(|finding| (finding.blame, finding.severity) == (CaptureBlame::Device, FindingSeverity::Error))
        .collect()
}
