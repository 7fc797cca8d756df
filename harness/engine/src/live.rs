//! What the engine needs of a device outside of this process: a segment for each trial, and what may be done to it.
//!
//! [`LiveDevice`] is implemented where the real wires are. This module must not know how a device is found or prepared, nor what
//! carries its frames.

use super::environment::{DpLine, TrialEnvironment};
use super::segment::Segment;
use description::variant::VariantReading;
use results::bench_file::BenchFile;
use results::journal::{InitialDevice, InitialImRecord, InitialParameter, JournalEntry, change};
use results::outcome::DeviceFinding;
use std::fmt::Debug;
use std::sync::Arc;
use suite::model::{Manual, SuiteVariant, Trial};

/// Why a trial does not run on a bench.
pub enum TrialExclusion {
    /// A claim, an ability or a consent is missing.
    NotApplicable {
        why: String,
        /// The lines of the bench file that would change it.
        lines: Vec<String>,
    },
    /// The line or the stand failed.
    Inconclusive(String),
    /// The run has ended.
    NotRun(String),
}

/// What was read of a device before a run, and what the run may have changed.
#[derive(Clone, Copy, Debug)]
pub struct DeviceBackup<'a> {
    /// The parameters before the run.
    pub parameters: &'a [InitialParameter],
    /// I&M1 to I&M4 before the run.
    pub im_records: &'a [InitialImRecord],
    /// The changes, in the words of [`change`], each perhaps with more after it.
    pub changes: &'a [String],
}

impl DeviceBackup<'_> {
    /// Whether one of the changes begins with one of these words.
    fn has_any(&self, words: &[&str]) -> bool {
        self.changes.iter().any(|made| words.iter().any(|word| made.starts_with(word)))
    }

    /// Whether parameters may differ.
    pub fn wrote_parameters(&self) -> bool {
        self.has_any(&[change::PARAMETERS, change::FACTORY_RESET, change::NEW_DEVICE])
    }

    /// Whether the parameters in the non-volatile memory may differ.
    pub fn saved_parameters(&self) -> bool {
        self.has_any(&[change::MEMORY, change::FACTORY_RESET, change::NEW_DEVICE])
    }

    /// Whether I&M1 to I&M4 may differ.
    pub fn wrote_im_records(&self) -> bool {
        self.has_any(&[change::IM_RECORDS, change::FACTORY_RESET, change::NEW_DEVICE])
    }

    /// Whether the IP address may differ, or one that looks the same may no longer be stored.
    pub fn set_ip(&self) -> bool {
        self.has_any(&[change::IP, change::TEMPORARY_IP, change::FACTORY_RESET, change::NEW_DEVICE])
    }

    /// Whether the station name may differ, or one that looks the same may be stored now.
    pub fn set_name(&self) -> bool {
        self.has_any(&[change::NAME, change::FACTORY_RESET, change::NEW_DEVICE])
    }

    /// Whether nothing was done to name and address but a power cycle.
    pub fn only_cycled_power(&self) -> bool {
        self.has_any(&[change::POWER_CYCLE]) && !self.set_name() && !self.set_ip()
    }

    /// Whether an IP address may have been stored.
    pub fn stored_ip(&self) -> bool {
        self.has_any(&[change::IP])
    }

    /// What no service of the bus can put back, in words.
    pub fn lost(&self) -> Vec<String> {
        let lost = [
            (
                change::POSITION_REFERENCE,
                "the position reference, which a preset has moved: reference the machine again",
            ),
            (change::FACTORY_RESET, "what a factory reset erased besides name, address, I&M1 to I&M4 and parameters"),
            (
                change::FIRMWARE,
                "the web server of a device that waits for another firmware: switch its power off and on",
            ),
            (change::NEW_DEVICE, "the data of the device in place of which the stand put a new one"),
        ];
        lost.iter().filter(|(word, _)| self.has_any(&[word])).map(|(_, what)| (*what).to_owned()).collect()
    }
}

/// How far a device was put back.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RestoreOutcome {
    /// What could not be restored, each with the reason.
    pub left: Vec<String>,
    /// What was assumed, and what stays different until power-off.
    pub remarks: Vec<String>,
}

/// How much drawn sequences may change of a device in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SequenceLimits {
    /// How often its supply is switched off.
    pub power_cycles: u32,
    /// How often its non-volatile memory is written.
    pub memory_writes: u32,
}

/// How a trial begins on a virtual wire.
#[derive(Clone, Copy, Debug)]
pub struct VirtualStart {
    /// The position of the shaft in hardware steps from the physical zero.
    pub shaft: u64,
    /// The addresses and the baud rate on PROFIBUS.
    pub line: DpLine,
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

    /// What the device reported without a connection, and its description, about its variant.
    fn variant_readings(&self) -> &[VariantReading];

    /// Remarks for the report.
    fn notes(&self) -> &[String];

    /// Why only reading cases may run; `None` if all may.
    fn passive(&self) -> Option<&str>;

    /// The wire without another station of the harness, for one trial; its clock starts at zero. `start` says how the trial begins on
    /// a virtual wire.
    fn segment(&self, start: VirtualStart) -> Box<dyn Segment + '_>;

    /// Whether its wire is virtual, so that a trial needs no real time and the device begins each one in factory state.
    fn is_virtual(&self) -> bool {
        false
    }

    /// From now on trials are drawn sequences: each frame to the device is judged by what it changes, and these changes are counted.
    /// `None` ends that.
    fn limit_changes(&self, _: Option<SequenceLimits>) {}

    /// What is left of the limits, if there are any.
    fn limits_left(&self) -> Option<SequenceLimits> {
        None
    }

    /// Adds a line to the journal.
    fn note(&self, entry: &JournalEntry) -> Result<(), String>;

    /// The lasting changes that were made so far, in the words of [`change`].
    fn changes(&self) -> Vec<String>;

    /// Counts whether the device answered in a trial; one that repeatedly does not is no longer tested.
    fn count_answer(&self, answered: bool);

    /// A number that no call before had.
    fn next_call(&self) -> u64;

    /// Ends the tests, with the reason.
    fn end_tests(&self, why: &str);

    /// Why a trial would not run here; changes nothing.
    fn objection(&self, variant: &SuiteVariant, trial: &Trial) -> Option<String>;

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
