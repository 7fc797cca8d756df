//! What the engine asks of a device outside of this process: a segment for each trial, and what may be done to it.
//!
//! [`LiveDevice`] is implemented where the real wires are. This module must not know how a device is found or prepared, nor what
//! carries its frames.

use super::place::Place;
use super::segment::Segment;
use results::bench_file::BenchFile;
use results::journal::{Entry, Found, Parameter};
use results::outcome::Finding;
use std::fmt::Debug;
use std::sync::Arc;
use suite::model::{Manual, Trial, Variant};

/// Why a trial does not run on a bench.
pub enum Excluded {
    /// A claim, an ability or a consent is missing.
    NotApplicable(String),
    /// The line or the stand broke.
    Inconclusive(String),
    /// The run is over.
    NotRun(String),
}

/// What a run may have changed of the parameters.
#[derive(Clone, Copy, Debug)]
pub struct Kept<'a> {
    /// The parameters as they were found.
    pub parameters: &'a [Parameter],
    /// Whether trials wrote parameters.
    pub wrote_parameters: bool,
    /// Whether trials wrote the memory.
    pub saved: bool,
}

/// A device outside of this process on a bench that was prepared; one trial at a time has it.
pub trait LiveDevice: Debug + Send + Sync {
    /// The suite of what it claims to be, with what its description says.
    fn manual(&self) -> &Manual;

    /// The bench.
    fn bench(&self) -> &BenchFile;

    /// What it said it is when it was found.
    fn identity(&self) -> String;

    /// Where it is found.
    fn place(&self) -> &Place;

    /// How it was found, before anything was changed.
    fn found(&self) -> &Found;

    /// What was found out about it before the first trial.
    fn findings(&self) -> &[Finding];

    /// Remarks for the report.
    fn notes(&self) -> &[String];

    /// Why only what reads may run, where that is so.
    fn passive(&self) -> Option<&str>;

    /// The wire with no other station of ours on it, for one trial; its clock shows zero.
    fn segment(&self) -> Box<dyn Segment + '_>;

    /// Adds a line to the journal.
    fn note(&self, entry: &Entry) -> Result<(), String>;

    /// What may have been changed of the parameters, which were found as these.
    fn kept<'k>(&self, parameters: &'k [Parameter]) -> Kept<'k>;

    /// Counts whether the device answered in a trial; one that does not over and over is not asked any more.
    fn counts(&self, answered: bool);

    /// A number that no call before had.
    fn next_call(&self) -> u64;

    /// Nothing more can be tested, and why.
    fn lose(&self, why: &str);

    /// Whether something was changed that may have to be put back.
    fn has_changed(&self) -> bool;

    /// Whether a trial may run here; makes the bench ready for it and writes down what it will change.
    fn admit(&self, variant: &Variant, trial: &Trial) -> Result<(), Excluded>;
}

/// A live device as a device under test; copies are the same device.
#[derive(Clone, Debug)]
pub struct SharedLiveDevice(pub Arc<dyn LiveDevice>);

impl PartialEq for SharedLiveDevice {
    fn eq(&self, other: &SharedLiveDevice) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for SharedLiveDevice {}
