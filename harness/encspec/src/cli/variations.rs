//! `encspec variations`: lists the variations of the reference devices that their manuals permit.

use super::list::json;
use super::{CommandResult, ListingArgs, ListingFormat, show};
use deviations::{DeviationKind, Subject};
use plain_text::count;
use report::ExitStatus;
use serde::Serialize;
use std::fmt::Write as _;

pub(super) fn variations(args: &ListingArgs) -> CommandResult {
    let manuals = args.which.suites.load_one(args.which.manual.as_deref())?;
    let known = manuals.iter().filter_map(|manual| deviations::subject(&manual.device.name).ok());
    let listed: Vec<ManualVariations> = known.map(ManualVariations::of).collect();
    match args.format {
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
    fn of(subject: &Subject) -> ManualVariations {
        let of = |known: &deviations::Deviation| match known.kind {
            DeviationKind::Permitted { clause } => Some(Variation { name: known.name, why: known.sentence, clause }),
            DeviationKind::Bug => None,
        };
        ManualVariations { id: subject.manual.name, variations: subject.permitted().filter_map(of).collect() }
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
