//! `encspec errata`: lists where a manual contradicts itself and what it leaves open.

use super::coverage::covering;
use super::list::json;
use super::{CommandResult, ListingArgs, ListingFormat, show};
use report::{ExitStatus, level};
use serde::Serialize;
use std::fmt::Write as _;
use suite::model::{Manual, OtherReadings, Requirement, RequirementClass};

pub(super) fn errata(args: &ListingArgs) -> CommandResult {
    let manuals = args.which.suites.load_one(args.which.manual.as_deref())?;
    let errata: Vec<Errata<'_>> = manuals.iter().map(Errata::of).collect();
    match args.format {
        ListingFormat::Json => show(&json(errata)),
        ListingFormat::Text => {
            let texts: Vec<String> = errata.iter().filter(|of| !of.is_empty()).map(Errata::text).collect();
            show(&texts.join("\n"));
        }
    }
    Ok(ExitStatus::Green)
}

/// The errata of one manual, in the order of its requirements.
#[derive(Debug, Serialize)]
struct Errata<'a> {
    id: &'a str,
    /// Number of requirements of the manual.
    requirements: usize,
    /// Requirements on which clauses of the manual contradict each other.
    contradictions: Vec<Erratum<'a>>,
    /// Requirements on which the manual leaves something open.
    silences: Vec<Erratum<'a>>,
}

#[derive(Debug, Serialize)]
struct Erratum<'a> {
    id: &'a str,
    level: &'static str,
    /// The cited clauses; for a contradiction those of both sides.
    clauses: Vec<&'a str>,
    statement: &'a str,
    /// The contradiction, or what the manual leaves open.
    ambiguity: Option<&'a str>,
    /// The chosen reading of a contradiction.
    #[serde(skip_serializing_if = "Option::is_none")]
    reading: Option<&'a str>,
    /// The permitted variations that behave as another reading has it.
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    variations: &'a [String],
    /// Why no device can show another reading.
    #[serde(skip_serializing_if = "Option::is_none")]
    no_variation: Option<&'a str>,
    /// The readings, by name, that cases accept.
    accepted: Vec<Accepted>,
    /// Ids of the cases and rules that cover the requirement.
    cases: Vec<String>,
}

/// The readings that one case accepts in any of its rows.
#[derive(Debug, Serialize)]
struct Accepted {
    case: String,
    readings: Vec<String>,
}

impl<'a> Errata<'a> {
    fn of(manual: &'a Manual) -> Errata<'a> {
        let mut errata = Errata {
            id: &manual.device.name,
            requirements: manual.requirements.len(),
            contradictions: Vec::new(),
            silences: Vec::new(),
        };
        for (index, (of, cases)) in manual.requirements.iter().zip(covering(manual)).enumerate() {
            let list = match (&of.class, &of.ambiguity) {
                (RequirementClass::Contradictory(_), _) => &mut errata.contradictions,
                (_, Some(_)) => &mut errata.silences,
                (_, None) => continue,
            };
            list.push(Erratum::of(manual, index, of, cases));
        }
        errata
    }

    fn is_empty(&self) -> bool {
        self.contradictions.is_empty() && self.silences.is_empty()
    }

    fn text(&self) -> String {
        let mut out = String::new();
        let parts = [("contradicts itself", &self.contradictions), ("leaves something open", &self.silences)];
        // Writing into a String cannot fail.
        let _ = writeln!(
            out,
            "{}: {} requirements; the manual contradicts itself on {} and leaves something open on {}",
            self.id,
            self.requirements,
            self.contradictions.len(),
            self.silences.len()
        );
        for (what, errata) in parts.into_iter().filter(|(_, errata)| !errata.is_empty()) {
            let _ = writeln!(out, "\nWhere {} {what}", self.id);
            errata.iter().for_each(|of| of.text(&mut out));
        }
        out
    }
}

impl<'a> Erratum<'a> {
    fn of(manual: &'a Manual, index: usize, of: &'a Requirement, cases: Vec<String>) -> Erratum<'a> {
        let full = |id: &str| format!("{}/{id}", manual.device.name);
        let mut accepted: Vec<Accepted> = Vec::new();
        for trial in manual.variants.iter().flat_map(|variant| &variant.trials) {
            for (_, reading) in trial.outline.readings.iter().filter(|(of, _)| *of == index) {
                let case = full(trial.case());
                match accepted.iter_mut().find(|known| known.case == case) {
                    Some(known) if known.readings.contains(reading) => {}
                    Some(known) => known.readings.push(reading.clone()),
                    None => accepted.push(Accepted { case, readings: vec![reading.clone()] }),
                }
            }
        }
        Erratum {
            id: &of.id,
            level: level(of.level),
            clauses: of.cites.split("; ").collect(),
            statement: &of.statement,
            ambiguity: of.ambiguity.as_deref(),
            reading: match &of.class {
                RequirementClass::Contradictory(reading) => Some(reading),
                _ => None,
            },
            variations: match &of.other_readings {
                OtherReadings::Varied(names) => names,
                OtherReadings::Invisible(_) | OtherReadings::Unknown => &[],
            },
            no_variation: match &of.other_readings {
                OtherReadings::Invisible(why) => Some(why),
                OtherReadings::Varied(_) | OtherReadings::Unknown => None,
            },
            accepted,
            cases: cases.iter().map(|id| full(id)).collect(),
        }
    }

    fn text(&self, out: &mut String) {
        let _ = writeln!(out, "\n{} ({})\n    {}", self.id, self.level, self.statement);
        for clause in &self.clauses {
            let _ = writeln!(out, "    clause: {clause}");
        }
        if let Some(ambiguity) = self.ambiguity {
            let _ = writeln!(out, "    open: {ambiguity}");
        }
        if let Some(reading) = self.reading {
            let _ = writeln!(out, "    read as: {reading}");
        }
        for variation in self.variations {
            let _ = writeln!(out, "    other reading: as with --vary {variation}");
        }
        if let Some(why) = self.no_variation {
            let _ = writeln!(out, "    other reading: not visible, {why}");
        }
        for Accepted { case, readings } in &self.accepted {
            let _ = writeln!(out, "    accepted: {} (in {case})", readings.join(" | "));
        }
        for case in &self.cases {
            let _ = writeln!(out, "    tested by {case}");
        }
    }
}
