//! `encspec personas`: lists the IO controllers that encspec can act like.

use super::list::json;
use super::{CommandResult, ListingFormat, Suites, show};
use clap::Args;
use report::ExitStatus;
use serde::Serialize;
use std::fmt::Write as _;
use suite::persona::Persona;

/// Arguments of `encspec personas`.
#[derive(Debug, Args)]
pub struct PersonasArgs {
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: ListingFormat,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Serialize)]
struct ListedPersona<'a> {
    name: &'a str,
    why: &'a str,
    source: &'a str,
}

pub(super) fn personas(args: &PersonasArgs) -> CommandResult {
    let personas = args.suites.personas()?;
    match args.format {
        ListingFormat::Json => {
            let listed = personas.iter().map(|of| ListedPersona { name: &of.name, why: &of.why, source: &of.source });
            show(&json(listed.collect::<Vec<_>>()));
        }
        ListingFormat::Text => show(&text(&personas)),
    }
    Ok(ExitStatus::Green)
}

fn text(personas: &[Persona]) -> String {
    let mut out = String::new();
    let width = personas.iter().map(|of| of.name.len()).max().unwrap_or_default();
    for of in personas {
        // Writing into a String cannot fail.
        let _ = writeln!(out, "{:width$}  {}\n{:width$}  from {}", of.name, of.why, "", of.source);
    }
    out
}
