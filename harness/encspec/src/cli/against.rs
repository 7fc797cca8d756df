//! `encspec replay --against` and `--shrink`: compares a capture with a device, and finds the shortest case that shows a difference.

use super::{CommandError, Suites, live, print_message, show};
use clap::Args;
use compare::capture::{compare_capture, extract_capture, not_drivable};
use compare::conversation::RecordedConversation;
use compare::drive::{CannotDrive, ScriptBench};
use compare::masks::Masks;
use compare::shrink::{ShrinkPair, ShrinkResult, shrink};
use compare::slice::slice;
use engine::{DutSpec, with_restored_device};
use plain_text::printable;
use replay::ReplayReport;
use std::fs::{self, File};
use std::path::PathBuf;
use std::time::Duration;
use suite::model::Manual;

/// How long to wait for a live device that another process uses.
const LOCK_WAIT: Duration = Duration::from_secs(10);

/// Arguments of `encspec replay` that drive a device.
#[derive(Debug, Args)]
pub(super) struct AgainstArgs {
    /// Send the recorded requests to this device and compare its answers with the recorded ones: model:MANUAL/VARIANT, or the
    /// bench file of a live device
    #[arg(long, value_name = "DUT")]
    against: Option<String>,
    /// Find the shortest case that fails on the device of --dut and passes on the reference device
    #[arg(long)]
    shrink: bool,
    /// With --shrink: the device that differs, as model:MANUAL/VARIANT with --bug, or as a bench file. With --against instead of
    /// --dut the case is written unconfirmed, from the capture alone
    #[arg(long, value_name = "DUT", requires = "shrink")]
    dut: Option<String>,
    /// Enable a bug of the reference device; may be repeated; `encspec bugs` lists them
    #[arg(long, value_name = "NAME")]
    bug: Vec<String>,
    /// File of names that are not compared, in the format of a manual's masks.yaml
    #[arg(long, value_name = "FILE")]
    masks: Option<PathBuf>,
    /// Write the case of --shrink to this file instead of standard output
    #[arg(long, value_name = "FILE", requires = "shrink")]
    case: Option<PathBuf>,
}

impl AgainstArgs {
    /// Whether a device is driven. Then the cases of the manuals are needed, not only their rules.
    pub fn drives(&self) -> bool {
        self.against.is_some() || self.shrink || self.dut.is_some()
    }

    /// Compares, shrinks, or both. Returns whether a device differs.
    pub fn hold(&self, suites: &Suites, manuals: &[Manual], report: &mut ReplayReport) -> Result<bool, CommandError> {
        let Some(dut) = self.against.as_ref().or(self.dut.as_ref()) else {
            if self.shrink {
                return Err(CommandError::usage(
                    "`--shrink` needs a device: `--dut model:MANUAL/VARIANT --bug NAME`, `--dut BENCH.yaml`, or \
                     `--against model:MANUAL/VARIANT` for an unconfirmed case",
                ));
            }
            if !self.bug.is_empty() || self.masks.is_some() {
                return Err(CommandError::usage("`--bug` and `--masks` need `--against` or `--shrink`"));
            }
            return Ok(false);
        };
        let (spec, _lock) = device(dut, &self.bug, suites, manuals)?;
        let own = spec.live().map(|live| live.manual());
        let manual = own.or_else(|| manuals.iter().find(|of| of.device.name == spec.manual));
        let manual = manual.ok_or_else(|| CommandError::usage(format!("there is no suite for {}", spec.manual)))?;
        let bench = ScriptBench::new(&suites.sources()?, manual, &spec.variant).map_err(stop)?;
        let text = self.masks.as_ref().map(|path| {
            let text = fs::read_to_string(path);
            text.map_err(|error| {
                CommandError::usage(format!("the masks file {} cannot be read: {error}", path.display()))
            })
        });
        let named = self.masks.as_ref().map(|path| path.display().to_string());
        let text = text.transpose()?;
        let masks = bench.masks(named.as_deref().zip(text.as_deref())).map_err(stop)?;
        let mut differs = false;
        for capture in &mut report.captures {
            if capture.file == "-" {
                return Err(CommandError::usage(
                    "`--against` and `--shrink` read the capture twice; save standard input to a file first",
                ));
            }
            let cannot =
                |why: &dyn std::fmt::Display| CommandError::bench(format!("{}: {why}", printable(&capture.file)));
            let file = File::open(&capture.file).map_err(|error| cannot(&error))?;
            let heard = extract_capture(file, bench.manual_variant()).map_err(|error| cannot(&error))?;
            if self.against.is_some() {
                let held =
                    run_on_device(&spec, manual, || compare_capture(&bench, &spec, &heard, &masks))?.map_err(stop)?;
                differs |= !held.differences.is_empty() || held.inconclusive.is_some();
                capture.against = Some(held);
            }
            if self.shrink {
                differs |= self.shrink_capture(&bench, &spec, manual, &heard, &masks)?;
            }
        }
        Ok(differs)
    }

    fn shrink_capture(
        &self,
        bench: &ScriptBench<'_>,
        spec: &DutSpec,
        manual: &Manual,
        heard: &RecordedConversation,
        masks: &Masks,
    ) -> Result<bool, CommandError> {
        if let Some(why) = not_drivable(&heard.conversation) {
            return Err(CommandError::bench(format!("nothing can be shrunk: {why}")));
        }
        let reference = spec.without_deviations();
        if self.dut.is_none() {
            let case = slice(bench, &reference, heard, masks).map_err(stop)?;
            let Some(case) = case else {
                print_message(
                    "no case was written: every difference from the reference device depends on a shaft whose position is unknown \
                     or that turned",
                );
                return Ok(false);
            };
            self.write(&case.yaml())?;
            print_message("the case is unconfirmed: it has not been run on the device that it should fail on");
            return Ok(true);
        }
        let bug = spec.bugs().into_iter().next();
        let bug = bug.and_then(|name| manual.bugs.iter().find(|bug| bug.name == name));
        let pair = ShrinkPair { reference: &reference, dut: spec, bug };
        match run_on_device(spec, manual, || shrink(bench, &pair, &heard.conversation, masks))?.map_err(stop)? {
            ShrinkResult::Confirmed { case, name, before, runs } => {
                print_message(&format!(
                    "reduced {before} steps of the capture to {} in {runs} runs; the device differs in {name}; the case fails on \
                     the device and passes on the reference device",
                    case.steps.len()
                ));
                self.write(&case.yaml())?;
                Ok(true)
            }
            ShrinkResult::Same { steps } => {
                print_message(&format!(
                    "no difference: the device answers the {steps} steps of the capture as the reference device does; what went \
                     wrong in the capture was not caused by the controller's requests"
                ));
                Ok(false)
            }
            ShrinkResult::NoCase { differences } => {
                let names: Vec<&str> = differences.iter().take(5).map(|of| of.name.as_str()).collect();
                Err(CommandError::bench(format!(
                    "the device differs in {}, but no case that shows it was found; `--against` lists the differences",
                    names.join(", ")
                )))
            }
        }
    }

    fn write(&self, yaml: &str) -> Result<(), CommandError> {
        match &self.case {
            None => show(yaml),
            Some(path) => fs::write(path, yaml).map_err(|error| {
                CommandError::usage(format!("the case {} cannot be written: {error}", path.display()))
            })?,
        }
        Ok(())
    }
}

/// Runs `work` with a device. A live device is checked before and restored afterwards.
fn run_on_device<R>(spec: &DutSpec, manual: &Manual, work: impl FnOnce() -> R) -> Result<R, CommandError> {
    let variant = manual.variants.iter().find(|variant| variant.name == spec.variant);
    let variant = variant.ok_or_else(|| CommandError::usage(format!("there is no variant `{}`", spec.variant)))?;
    let (done, notes) = with_restored_device(manual, variant, spec, work).map_err(CommandError::bench)?;
    notes.iter().for_each(|note| print_message(note));
    Ok(done)
}

/// The device that `dut` names. A live device is locked and opened.
fn device(
    dut: &str,
    bugs: &[String],
    suites: &Suites,
    manuals: &[Manual],
) -> Result<(DutSpec, Option<::live::lock::Lock>), CommandError> {
    let devices = super::dut::devices(&[dut.to_owned()], None, bugs, manuals).map_err(CommandError::usage)?;
    if let Some(known) =
        devices.here.first().and_then(|of| manuals.iter().find(|manual| manual.device.name == of.manual))
        && let Some(name) = bugs.iter().find(|name| known.bugs.iter().all(|bug| bug.name != **name))
    {
        let names = known.bugs.iter().map(|bug| bug.name.as_str());
        return Err(CommandError::usage(super::dut::suggest("bug", name, names)));
    }
    match (devices.here.as_slice(), devices.live.as_slice()) {
        ([one], []) => Ok((one.clone(), None)),
        ([], [live]) => {
            let bench = live.bench(manuals)?;
            let lock = live::lock(&bench, LOCK_WAIT)?;
            Ok((live::open(bench, suites, false, None)?, Some(lock)))
        }
        ([first, ..], _) => {
            let (manual, variant) = (&first.manual, &first.variant);
            Err(CommandError::usage(format!(
                "`{dut}` has several variants; name one, for instance `model:{manual}/{variant}`"
            )))
        }
        _ => Err(CommandError::usage(format!("`{dut}` is not a device"))),
    }
}

fn stop(error: CannotDrive) -> CommandError {
    CommandError::bench(error.to_string())
}
