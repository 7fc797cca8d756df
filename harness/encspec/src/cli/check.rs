//! `encspec check`: checks suites for errors and lists unused definitions.

use super::dut::has_model;
use super::{CheckArgs, CommandError, CommandResult, show};
use plain_text::count;
use report::ExitStatus;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use suite::model::Manual;
use suite_yaml::persona::load_personas;
use suite_yaml::{AddedSuites, load};

pub(super) fn check(args: &CheckArgs) -> CommandResult {
    let sources = args.suites.sources()?;
    let (sources, added, only) = match &args.path {
        None => (sources, AddedSuites::default(), None),
        Some(path) => {
            let (folder, only) = folder_of(path)?;
            let (sources, added) = sources.and_folder(&folder)?;
            (sources, added, only)
        }
    };
    let manuals = load(&sources, only.as_deref())?;
    let personas = if only.is_none() { load_personas(&sources)? } else { Vec::new() };
    let mut out = String::new();
    // A change of a common suite can be a mistake in any manual that uses it, so all are loaded; those at the path are listed.
    let listed = |manual: &&Manual| added.manuals.is_empty() || added.manuals.contains(&manual.device.name);
    for manual in manuals.iter().filter(listed) {
        // Writing into a String cannot fail.
        let _ = write_manual_summary(&mut out, manual);
    }
    if !personas.is_empty() {
        let _ = writeln!(out, "{}: no errors", count(personas.len(), "persona", "personas"));
    }
    show(&out);
    Ok(ExitStatus::Green)
}

/// The folder to read for a path, and the manual if the path names one: a folder of suites, the folder of a manual, or a file in it.
fn folder_of(path: &Path) -> Result<(PathBuf, Option<String>), CommandError> {
    let real = path.canonicalize().map_err(|error| CommandError::usage(format!("{}: {error}", path.display())))?;
    let folder = if real.is_dir() { real.as_path() } else { real.parent().unwrap_or(&real) };
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
    let is_shared = matches!(name.as_deref(), Some("common" | "personas"));
    if folder.join("device.yaml").is_file() {
        Ok((folder_as_written(path, folder), name))
    } else if is_shared {
        Ok((folder_as_written(path, folder.parent().unwrap_or(folder)), None))
    } else if real.is_dir() {
        Ok((path.to_owned(), None))
    } else {
        Err(CommandError::usage(format!(
            "{} belongs to no manual: there is no device.yaml in its folder",
            path.display()
        )))
    }
}

/// The folder as the user wrote it, if it is the same folder as `real`.
fn folder_as_written(written: &Path, real: &Path) -> PathBuf {
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
    if manual.bugs.is_empty() {
        writeln!(out, "  it lists no bugs: nothing proves that its cases can fail")?;
    } else if !has_model(manual) {
        writeln!(out, "  no reference device has its bugs: nothing proves that its cases can fail")?;
    }
    for (what, at) in &manual.unused {
        writeln!(out, "  {}:{}: unused: {what}", at.file.display(), at.line)?;
    }
    Ok(())
}
