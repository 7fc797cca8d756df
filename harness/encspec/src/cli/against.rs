//! `encspec replay --against` and `--shrink`: a capture held against a device, and the shortest case that shows what is wrong.

use super::{Stop, Suites, complain, dut, live, show, sources};
use clap::Args;
use compare::drive::{Bench, CannotDrive};
use compare::heard::Heard;
use compare::hold::{hear, hold, nothing_to_drive};
use compare::masks::Masks;
use compare::shrink::{Pair, Shrunk, shrink};
use compare::slice::slice;
use engine::{DutSpec, looked_after};
use plain_text::printable;
use replay::ReplayReport;
use std::fs::{self, File};
use std::path::PathBuf;
use suite::model::Manual;

/// What is asked of a capture besides its report.
#[derive(Debug, Args)]
pub(super) struct AgainstArgs {
    /// Drive this device as the controller of the capture did, and compare its answers with the recorded ones:
    /// model:MANUAL/VARIANT, or the bench file of a live device
    #[arg(long, value_name = "DUT")]
    against: Option<String>,
    /// Find the shortest case that fails on the device of `--dut` and passes on the healthy reference device
    #[arg(long)]
    shrink: bool,
    /// With `--shrink`: the device that differs, model:MANUAL/VARIANT with `--bug`, or a bench file; with `--against` in its place
    /// what the capture depends on is written as a case that nobody has confirmed
    #[arg(long, value_name = "DUT", requires = "shrink")]
    dut: Option<String>,
    /// Tell the reference device to have this bug; may be given several times
    #[arg(long, value_name = "NAME")]
    bug: Vec<String>,
    /// Names that are not compared, a file as `masks.yaml` of a manual is
    #[arg(long, value_name = "FILE")]
    masks: Option<PathBuf>,
    /// Write the case of `--shrink` to this file instead of standard output
    #[arg(long, value_name = "FILE", requires = "shrink")]
    case: Option<PathBuf>,
}

impl AgainstArgs {
    /// Whether a device is driven, for which the cases of the manuals are needed.
    pub fn drives(&self) -> bool {
        self.against.is_some() || self.shrink || self.dut.is_some()
    }

    /// Does what is asked; true where a device differs.
    pub fn hold(&self, suites: &Suites, manuals: &[Manual], report: &mut ReplayReport) -> Result<bool, Stop> {
        let Some(asked) = self.against.as_ref().or(self.dut.as_ref()) else {
            if self.shrink {
                return Err(Stop::usage(
                    "`--shrink` needs a device: `--dut model:MANUAL/VARIANT --bug NAME`, a bench file, or \
                     `--against model:MANUAL/VARIANT` for a case that nobody has confirmed",
                ));
            }
            return match self.bug.is_empty() && self.masks.is_none() {
                true => Ok(false),
                false => Err(Stop::usage("`--bug` and `--masks` go with `--against` or `--shrink`")),
            };
        };
        let (spec, _lock) = device(asked, &self.bug, suites, manuals)?;
        let own = spec.live().map(|live| live.manual());
        let manual = own.or_else(|| manuals.iter().find(|of| of.device.name == spec.manual));
        let manual = manual.ok_or_else(|| Stop::usage(format!("there is no suite for {}", spec.manual)))?;
        let bench = Bench::new(&sources(suites.folder.as_deref())?, manual, &spec.variant).map_err(stop)?;
        let text = self.masks.as_ref().map(|path| {
            let text = fs::read_to_string(path);
            text.map_err(|error| Stop::usage(format!("the masks {} cannot be read: {error}", path.display())))
        });
        let named = self.masks.as_ref().map(|path| path.display().to_string());
        let text = text.transpose()?;
        let masks = bench.masks(named.as_deref().zip(text.as_deref())).map_err(stop)?;
        let mut differs = false;
        for capture in &mut report.captures {
            if capture.file == "-" {
                return Err(Stop::usage(
                    "`--against` and `--shrink` read a capture once more, which standard input cannot",
                ));
            }
            let cannot = |why: &dyn std::fmt::Display| Stop::bench(format!("{}: {why}", printable(&capture.file)));
            let file = File::open(&capture.file).map_err(|error| cannot(&error))?;
            let heard = hear(file, bench.whom()).map_err(|error| cannot(&error))?;
            if self.against.is_some() {
                let held = around(&spec, manual, || hold(&bench, &spec, &heard, &masks))?.map_err(stop)?;
                differs |= !held.differences.is_empty() || held.inconclusive.is_some();
                capture.against = Some(held);
            }
            if self.shrink {
                differs |= self.shrunk(&bench, &spec, manual, &heard, &masks)?;
            }
        }
        Ok(differs)
    }

    fn shrunk(
        &self,
        bench: &Bench<'_>,
        spec: &DutSpec,
        manual: &Manual,
        heard: &Heard,
        masks: &Masks,
    ) -> Result<bool, Stop> {
        if let Some(why) = nothing_to_drive(&heard.said) {
            return Err(Stop::bench(format!("nothing can be shrunk: {why}")));
        }
        let healthy = spec.healthy();
        if self.dut.is_none() {
            let case = slice(bench, &healthy, heard, masks).map_err(stop)?;
            let Some(case) = case else {
                complain(
                    "no case was written: nothing differs from the healthy reference device but what depends on a shaft whose place is unknown or that turned",
                );
                return Ok(false);
            };
            self.write(&case.yaml())?;
            complain("the case is unconfirmed: no device was asked whether it fails on it");
            return Ok(true);
        }
        let bug = spec.bugs().into_iter().next();
        let bug = bug.and_then(|name| manual.bugs.iter().find(|bug| bug.name == name));
        let pair = Pair { healthy: &healthy, dut: spec, bug };
        match around(spec, manual, || shrink(bench, &pair, &heard.said, masks))?.map_err(stop)? {
            Shrunk::Confirmed { case, name, before, runs } => {
                complain(&format!(
                    "{before} steps of the capture became {} in {runs} runs; the device differs in {name}; the case fails on \
                     it and passes on the healthy reference device",
                    case.steps.len()
                ));
                self.write(&case.yaml())?;
                Ok(true)
            }
            Shrunk::Same { steps } => {
                complain(&format!(
                    "the device answers the {steps} steps of the capture as the healthy reference device does: what made the \
                     difference is not among what the controller did"
                ));
                Ok(false)
            }
            Shrunk::NoCase { differences } => {
                let names: Vec<&str> = differences.iter().take(5).map(|of| of.name.as_str()).collect();
                Err(Stop::bench(format!(
                    "the device differs in {}, and no case was found that says so; `--against` shows the differences",
                    names.join(", ")
                )))
            }
        }
    }

    fn write(&self, yaml: &str) -> Result<(), Stop> {
        match &self.case {
            None => show(yaml),
            Some(path) => fs::write(path, yaml)
                .map_err(|error| Stop::usage(format!("the case {} cannot be written: {error}", path.display())))?,
        }
        Ok(())
    }
}

/// Does `work` with a device; a live one is looked at before and put back after.
fn around<R>(spec: &DutSpec, manual: &Manual, work: impl FnOnce() -> R) -> Result<R, Stop> {
    let variant = manual.variants.iter().find(|variant| variant.name == spec.variant);
    let variant = variant.ok_or_else(|| Stop::usage(format!("there is no variant {}", spec.variant)))?;
    let (done, notes) = looked_after(manual, variant, spec, work).map_err(Stop::bench)?;
    notes.iter().for_each(|note| complain(note));
    Ok(done)
}

/// The one device that is named, a live one opened and locked.
fn device(
    asked: &str,
    bugs: &[String],
    suites: &Suites,
    manuals: &[Manual],
) -> Result<(DutSpec, Option<::live::lock::Lock>), Stop> {
    let devices = dut::devices(&[asked.to_owned()], None, bugs, manuals).map_err(Stop::usage)?;
    if let Some(known) =
        devices.here.first().and_then(|of| manuals.iter().find(|manual| manual.device.name == of.manual))
        && let Some(name) = bugs.iter().find(|name| known.bugs.iter().all(|bug| bug.name != **name))
    {
        let names = known.bugs.iter().map(|bug| bug.name.as_str());
        return Err(Stop::usage(dut::suggest("bug", name, names)));
    }
    match (devices.here.as_slice(), devices.live.as_slice()) {
        ([one], []) => Ok((one.clone(), None)),
        ([], [live]) => {
            let bench = live.bench(manuals)?;
            let lock = live::lock(&bench, std::time::Duration::from_secs(10))?;
            Ok((live::open(bench, suites, false, None)?, Some(lock)))
        }
        ([first, ..], _) => {
            let (manual, variant) = (&first.manual, &first.variant);
            Err(Stop::usage(format!("{asked} has several variants: say which one, `model:{manual}/{variant}`")))
        }
        _ => Err(Stop::usage(format!("{asked} is no device"))),
    }
}

fn stop(error: CannotDrive) -> Stop {
    Stop::bench(error.to_string())
}
