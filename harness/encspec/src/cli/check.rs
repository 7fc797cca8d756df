//! `encspec check`: checks suites for errors and lists unused definitions.

use super::dut::has_model;
use super::{CheckArgs, CommandError, CommandResult, show};
use clap::ValueEnum;
use plain_text::count;
use report::{ExitStatus, RemarkLevel, SuiteRemark, sarif};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use suite::model::Manual;
use suite_yaml::persona::load_personas;
use suite_yaml::{AddedSuites, LoadErrors, load};

/// The unused definitions of a manual that the text lists: of a suite that `suite init` wrote there are hundreds.
const MOST_UNUSED: usize = 12;

/// The output format of `encspec check`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum CheckFormat {
    #[default]
    Text,
    /// SARIF 2.1.0, which code hosts and editors show beside the line
    Sarif,
}

pub(super) fn check(args: &CheckArgs) -> CommandResult {
    match checked(args) {
        Ok((manuals, _)) if args.format == CheckFormat::Sarif => {
            let unused = manuals.iter().flat_map(|manual| &manual.unused).map(|(what, at)| SuiteRemark {
                level: RemarkLevel::Note,
                text: format!("unused: {what}"),
                at: at.clone(),
                width: 1,
            });
            show(&sarif(&unused.collect::<Vec<_>>()));
            Ok(ExitStatus::Green)
        }
        Ok((manuals, personas)) => {
            show(&summary(&manuals, personas));
            Ok(ExitStatus::Green)
        }
        Err(CheckFailure::Suites(errors)) if args.format == CheckFormat::Sarif => {
            let remarks = errors.0.iter().map(|error| SuiteRemark {
                level: RemarkLevel::Error,
                text: error.help.iter().fold(error.message.clone(), |text, help| format!("{text}: {help}")),
                at: error.at.clone(),
                width: error.width,
            });
            show(&sarif(&remarks.collect::<Vec<_>>()));
            Ok(ExitStatus::Usage)
        }
        Err(CheckFailure::Suites(errors)) => Err(errors.into()),
        Err(CheckFailure::Command(error)) => Err(error),
    }
}

/// Why nothing was checked, or what is wrong.
enum CheckFailure {
    Suites(LoadErrors),
    Command(CommandError),
}

impl From<LoadErrors> for CheckFailure {
    fn from(errors: LoadErrors) -> CheckFailure {
        CheckFailure::Suites(errors)
    }
}

impl From<CommandError> for CheckFailure {
    fn from(error: CommandError) -> CheckFailure {
        CheckFailure::Command(error)
    }
}

/// The manuals that were asked for, and the number of personas.
fn checked(args: &CheckArgs) -> Result<(Vec<Manual>, usize), CheckFailure> {
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
    // A change of a common suite can be a mistake in any manual that uses it, so all are loaded; those at the path are listed.
    let listed = |manual: &&Manual| added.manuals.is_empty() || added.manuals.contains(&manual.device.name);
    let manuals = manuals.into_iter().filter(|manual| listed(&manual)).collect();
    Ok((manuals, personas.len()))
}

fn summary(manuals: &[Manual], personas: usize) -> String {
    let mut out = String::new();
    for manual in manuals {
        // Writing into a String cannot fail.
        let _ = write_manual_summary(&mut out, manual);
    }
    if personas > 0 {
        let _ = writeln!(out, "{}: no errors", count(personas, "persona", "personas"));
    }
    out
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
    for suite in &manual.also {
        let topics = suite.topics.len();
        writeln!(
            out,
            "  it uses {} too: {} with {}; {} left out",
            suite.name,
            count(topics, "topic", "topics"),
            count(suite.requirements.len(), "requirement", "requirements"),
            count(suite.except.len(), "part is", "parts are")
        )?;
    }
    if manual.bugs.is_empty() {
        writeln!(out, "  it lists no bugs: nothing proves that its cases can fail")?;
    } else if !has_model(manual) {
        writeln!(out, "  no reference device has its bugs: nothing proves that its cases can fail")?;
    }
    for (what, at) in manual.unused.iter().take(MOST_UNUSED) {
        writeln!(out, "  {}:{}: unused: {what}", at.file.display(), at.line)?;
    }
    let more = manual.unused.len().saturating_sub(MOST_UNUSED);
    if more > 0 {
        writeln!(out, "  and {more} more that are unused; --format sarif lists them all")?;
    }
    Ok(())
}
