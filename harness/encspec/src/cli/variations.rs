//! `encspec variations`: lists the variations of the reference devices that their manuals permit.

use super::list::json;
use super::{CommandError, CommandResult, ListingArgs, ListingFormat, show};
use clap::Args;
use deviations::{DeviationKind, Subject};
use plain_text::count;
use report::ExitStatus;
use serde::Serialize;
use std::fmt::Write as _;

#[derive(Debug, Args)]
pub(super) struct VariationsArgs {
    #[command(flatten)]
    listing: ListingArgs,
    /// List only what `--vary NAME` of a run stands for: one variation, or those of `random:SEED`
    #[arg(long, value_name = "NAME")]
    vary: Option<String>,
}

pub(super) fn variations(args: &VariationsArgs) -> CommandResult {
    let VariationsArgs { listing: ListingArgs { which, format }, vary } = args;
    let manuals = which.suites.load_one(which.manual.as_deref())?;
    let known = manuals.iter().filter_map(|manual| deviations::subject(&manual.device.name).ok());
    let of = |subject| ManualVariations::of(subject, vary.as_deref());
    let listed: Vec<ManualVariations> = known.filter_map(of).collect();
    if let (Some(name), true) = (vary, listed.is_empty()) {
        return Err(CommandError::usage(format!("no variation is called {name}; without --vary all are listed")));
    }
    match format {
        ListingFormat::Json => show(&json(listed)),
        ListingFormat::Text => show(&listed.iter().map(ManualVariations::text).collect::<String>()),
    }
    Ok(ExitStatus::Green)
}

#[derive(Serialize)]
struct ManualVariations {
    id: &'static str,
    variations: Vec<Variation>,
}

#[derive(Serialize)]
struct Variation {
    name: &'static str,
    why: &'static str,
    clause: &'static str,
}

impl ManualVariations {
    /// The variations of a manual; if `vary` is given, those that it stands for, and `None` if it stands for none.
    fn of(subject: &Subject, vary: Option<&str>) -> Option<ManualVariations> {
        let of = |known: &deviations::Deviation| match known.kind {
            DeviationKind::Permitted { clause } => Some(Variation { name: known.name, why: known.sentence, clause }),
            DeviationKind::Bug => None,
        };
        let variations = match vary {
            Some(name) => subject.variations_of(name)?.into_iter().filter_map(of).collect(),
            None => subject.permitted().filter_map(of).collect(),
        };
        Some(ManualVariations { id: subject.manual.name, variations })
    }

    fn text(&self) -> String {
        let mut out = String::new();
        // Writing into a String cannot fail.
        let _ = writeln!(out, "{}: {}", self.id, count(self.variations.len(), "variation", "variations"));
        for Variation { name, why, clause } in &self.variations {
            let _ = writeln!(out, "  {name}\n    {why}\n    permitted: {clause}");
        }
        out
    }
}
