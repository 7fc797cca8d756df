//! `encspec check`: checks suites for errors and lists unused definitions.

use super::{CheckArgs, CommandError, CommandResult, show};
use plain_text::count;
use report::ExitStatus;
use std::fmt::Write as _;
use std::path::Path;
use suite::model::Manual;
use suite_yaml::persona::load_personas;
use suite_yaml::{Sources, load};

pub(super) fn check(args: &CheckArgs) -> CommandResult {
    let (sources, only) = match &args.path {
        None => (suites::sources(), None),
        Some(path) => suites_at(path)?,
    };
    let manuals = load(&sources, only.as_deref())?;
    let personas = if only.is_none() { load_personas(&sources)? } else { Vec::new() };
    let mut out = String::new();
    for manual in &manuals {
        // Writing into a String cannot fail.
        let _ = write_manual_summary(&mut out, manual);
    }
    if !personas.is_empty() {
        let _ = writeln!(out, "{}: no errors", count(personas.len(), "persona", "personas"));
    }
    show(&out);
    Ok(ExitStatus::Green)
}

/// The suites at a path, and the manual if the path names one: a folder of suites, the folder of a manual, or a file in it.
fn suites_at(path: &Path) -> Result<(Sources, Option<String>), CommandError> {
    let real = path.canonicalize().map_err(|error| CommandError::usage(format!("{}: {error}", path.display())))?;
    let folder = if real.is_dir() { real.as_path() } else { real.parent().unwrap_or(&real) };
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
    let is_manual = folder.join("device.yaml").is_file();
    let is_shared = matches!(name.as_deref(), Some("common" | "personas"));
    let above = folder.parent().unwrap_or(folder);
    if is_manual {
        Ok((Sources::folder(&folder_as_written(path, above))?, name))
    } else if is_shared {
        Ok((Sources::folder(&folder_as_written(path, above))?, None))
    } else if real.is_dir() {
        Ok((Sources::folder(path)?, None))
    } else {
        Err(CommandError::usage(format!(
            "{} belongs to no manual: there is no device.yaml in its folder",
            path.display()
        )))
    }
}

/// The folder as the user wrote it, if it is the same folder as `real`.
fn folder_as_written(written: &Path, real: &Path) -> std::path::PathBuf {
    let same = |above: &&Path| above.canonicalize().is_ok_and(|above| above == real);
    written.ancestors().filter(|above| !above.as_os_str().is_empty()).find(same).unwrap_or(real).to_owned()
}

fn write_manual_summary(out: &mut String, manual: &Manual) -> std::fmt::Result {
    let trials: usize = manual.variants.iter().map(|variant| variant.trials.len()).sum();
    let rules: usize = manual.variants.iter().map(|variant| variant.rules.len()).sum();
    writeln!(
        out,
        "{}: {}, {}, {} and {} on {}: no errors",
        manual.device.name,
        count(manual.requirements.len(), "requirement", "requirements"),
        count(manual.bugs.len(), "bug", "bugs"),
        count(trials, "trial", "trials"),
        count(rules, "rule", "rules"),
        count(manual.variants.len(), "variant", "variants")
    )?;
    for (what, at) in &manual.unused {
        writeln!(out, "  {}:{}: unused: {what}", at.file.display(), at.line)?;
    }
    Ok(())
}
