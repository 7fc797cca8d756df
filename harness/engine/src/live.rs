//! What the engine needs of a device outside of this process: a segment for each trial, and what may be done to it.
//!
//! [`LiveDevice`] is implemented where the real wires are. This module must not know how a device is found or prepared, nor what
//! carries its frames.

use super::environment::TrialEnvironment;
use super::segment::Segment;
use results::bench_file::BenchFile;
use results::journal::{InitialDevice, InitialParameter, JournalEntry};
use results::outcome::DeviceFinding;
use std::fmt::Debug;
use std::sync::Arc;
use suite::model::{Manual, SuiteVariant, Trial};

/// Why a trial does not run on a bench.
pub enum TrialExclusion {
    /// A claim, an ability or a consent is missing.
    NotApplicable(String),
    /// The line or the stand failed.
    Inconclusive(String),
    /// The run has ended.
    NotRun(String),
}

/// The parameters, and whether a run may have changed them.
#[derive(Clone, Copy, Debug)]
pub struct ParameterBackup<'a> {
    /// The parameters before the run.
    pub parameters: &'a [InitialParameter],
    /// Whether trials wrote parameters.
    pub wrote_parameters: bool,
    /// Whether trials wrote the non-volatile memory.
    pub saved: bool,
}

/// A device outside of this process on a prepared bench; it is used by one trial at a time.
pub trait LiveDevice: Debug + Send + Sync {
    /// The suite of the device that it claims to be, with the data of its description.
    fn manual(&self) -> &Manual;

    fn bench(&self) -> &BenchFile;

    /// The identity that it reported when it was found.
    fn identity(&self) -> String;

    /// The addresses of the device and of the harness's stations.
    fn environment(&self) -> &TrialEnvironment;

    /// Its state before anything was changed.
    fn found(&self) -> &InitialDevice;

    /// The findings before the first trial.
    fn findings(&self) -> &[DeviceFinding];

    /// Remarks for the report.
    fn notes(&self) -> &[String];

    /// Why only reading cases may run; `None` if all may.
    fn passive(&self) -> Option<&str>;

    /// The wire without another station of the harness, for one trial; its clock starts at zero.
    fn segment(&self) -> Box<dyn Segment + '_>;

    /// Adds a line to the journal.
    fn note(&self, entry: &JournalEntry) -> Result<(), String>;

    /// Whether the given parameters may have been changed.
    fn parameter_backup<'k>(&self, parameters: &'k [InitialParameter]) -> ParameterBackup<'k>;

    /// Counts whether the device answered in a trial; one that repeatedly does not is no longer tested.
    fn count_answer(&self, answered: bool);

    /// A number that no call before had.
    fn next_call(&self) -> u64;

    /// Ends the tests, with the reason.
    fn end_tests(&self, why: &str);

    /// Whether something was changed that may have to be restored.
    fn has_changed(&self) -> bool;

    /// Checks whether a trial may run here, prepares the bench for it and notes in the journal what it will change.
    fn admit(&self, variant: &SuiteVariant, trial: &Trial) -> Result<(), TrialExclusion>;
}

/// A live device as a device under test; clones are the same device.
#[derive(Clone, Debug)]
pub struct SharedLiveDevice(pub Arc<dyn LiveDevice>);

impl PartialEq for SharedLiveDevice {
    fn eq(&self, other: &SharedLiveDevice) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for SharedLiveDevice {}
