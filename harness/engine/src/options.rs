//! What a run is asked for: which devices, which of their trials, and what is kept of them.

use super::dut::DutSpec;
use std::path::PathBuf;
use std::sync::Arc;
use suite::model::Manual;
use suite::persona::Persona;

/// What a run is asked for.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// The devices under test.
    pub duts: Vec<DutSpec>,
    /// Only trials and rules whose full name contains this.
    pub filter: Option<String>,
    /// The filter is the whole name.
    pub exact: bool,
    /// Where captures of failed trials go.
    pub evidence: Option<PathBuf>,
    /// Where captures of all trials go.
    pub record: Option<PathBuf>,
    /// How many trials run at once; 0: as many as there are cores.
    pub threads: usize,
    /// Whether only `must` counts.
    pub gate_must: bool,
    /// In the manner of which controller every device is addressed; none: as its bench says, else in our own.
    pub persona: Option<Arc<Persona>>,
    /// Only every so-manieth trial, so that several benches share the work.
    pub part: Option<Part>,
}

/// A part of the trials: one of so many, dealt out like cards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Which one, from 1.
    pub number: usize,
    /// Of how many.
    pub of: usize,
}

impl Part {
    pub(super) fn has(self, at: usize) -> bool {
        at % self.of.max(1) + 1 == self.number
    }
}

/// As `--part` has it: `2/8`.
impl std::str::FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Part, String> {
        let wrong = || format!("`{text}` is no part; write 2/8 for the second of eight");
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        let (number, of) = (number.parse().map_err(|_| wrong())?, of.parse().map_err(|_| wrong())?);
        if (1..=of).contains(&number) { Ok(Part { number, of }) } else { Err(wrong()) }
    }
}

/// Hears how far a run has come: the device under test of the last trial, trials done, trials in all.
pub type Progress<'a> = &'a (dyn Fn(&str, usize, usize) + Sync);

/// Whether a filter leaves a trial or a rule in.
pub fn selects(options: &RunOptions, manual: &Manual, id: &str) -> bool {
    let full = format!("{}/{id}", manual.device.name);
    match &options.filter {
        None => true,
        Some(filter) if options.exact => full == *filter || id == filter,
        Some(filter) => full.contains(filter.as_str()),
    }
}
