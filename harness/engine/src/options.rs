//! The options of a run: the devices, the trials, and which captures are written.

use super::dut::DutSpec;
use super::selection::Selection;
use results::outcome::CaseResult;
use std::path::PathBuf;
use std::sync::Arc;
use suite::persona::Persona;

/// The options of a run.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// The devices under test.
    pub duts: Vec<DutSpec>,
    /// The trials and rules that are run.
    pub selection: Selection,
    /// The folder for captures of failed trials.
    pub evidence: Option<PathBuf>,
    /// The folder for captures of all trials.
    pub record: Option<PathBuf>,
    /// How many trials run at once; 0 means one for each core.
    pub threads: usize,
    /// Whether only requirements of level `must` count.
    pub gate_must: bool,
    /// The persona of the controller for every device; `None`: the one of its bench, else the defaults.
    pub persona: Option<Arc<Persona>>,
    /// Only every n-th trial, so that several benches share the work.
    pub part: Option<TrialPart>,
    /// How often a live trial is repeated while a stall is its only trouble; see [`STALL_REPEATS`].
    pub stall_repeats: u32,
    /// How often a trial that did not pass is run again; one that passes then is flaky.
    pub retries: u32,
    /// Which result ends the run; `None`: none does.
    pub fail_fast: Option<FailFast>,
    /// Whether trials are recorded step by step instead of judged; rules are judged all the same.
    pub unjudged: bool,
}

/// Says whether a result ends a run (`--fail-fast`).
#[derive(Clone)]
pub struct FailFast(pub Arc<EndsRun>);

/// Whether a result of a device ends a run.
pub type EndsRun = dyn Fn(&DutSpec, &CaseResult) -> bool + Send + Sync;

impl std::fmt::Debug for FailFast {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("FailFast")
    }
}

/// How often `encspec run` repeats a live trial that a stall of the host or the line left without a verdict.
pub const STALL_REPEATS: u32 = 3;

/// One of several parts of the trials, which are dealt out in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrialPart {
    /// The number of this part, from 1.
    pub number: usize,
    /// The number of parts.
    pub of: usize,
}

impl TrialPart {
    pub(super) fn has(self, at: usize) -> bool {
        at % self.of.max(1) + 1 == self.number
    }
}

/// The form of `--part`: `2/8`.
impl std::str::FromStr for TrialPart {
    type Err = String;

    fn from_str(text: &str) -> Result<TrialPart, String> {
        let wrong = || format!("`{text}` is not a part; write 2/8 for the second of eight parts");
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        let (number, of) = (number.parse().map_err(|_| wrong())?, of.parse().map_err(|_| wrong())?);
        if (1..=of).contains(&number) { Ok(TrialPart { number, of }) } else { Err(wrong()) }
    }
}

/// A callback for the progress of a run: the device under test of the last trial, trials done, trials in all.
pub type RunProgress<'a> = &'a (dyn Fn(&str, usize, usize) + Sync);
