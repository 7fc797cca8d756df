//! `encspec suite init`: writes a suite for a device that no built-in suite describes, from the vendor's GSDML or GSD.

mod fields;
mod names;
mod profibus;
mod profinet;
mod profinet_text;
mod signals;
mod topics;

use super::vendor_file::DescriptionFile;
use super::{CommandError, CommandResult, print_message};
use clap::{Args, Subcommand};
use description::gsdml::{AccessPoint, Gsdml};
use report::ExitStatus;
use results::outcome::DescriptionKind;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use suite_yaml::{LoadErrors, load};

/// Arguments of `encspec suite`.
#[derive(Debug, Args)]
pub(super) struct SuiteArgs {
    #[command(subcommand)]
    command: SuiteCommand,
}

#[derive(Debug, Subcommand)]
enum SuiteCommand {
    /// Write a suite for a device from its GSDML or GSD; it loads and runs, and says what a person has to decide
    #[command(
        after_help = "Example: encspec suite init --gsdml GSDML-V2.43-Vendor-Encoder-20260101.xml --output my-encoder"
    )]
    Init(SuiteInitArgs),
}

/// Arguments of `encspec suite init`.
#[derive(Debug, Args)]
struct SuiteInitArgs {
    /// The vendor's GSDML of the device (PROFINET)
    #[arg(long, value_name = "FILE", required_unless_present = "gsd", conflicts_with = "gsd")]
    gsdml: Option<PathBuf>,
    /// The vendor's GSD of the device (PROFIBUS)
    #[arg(long, value_name = "FILE")]
    gsd: Option<PathBuf>,
    /// The access point of the GSDML, by its id, if there are several [default: the first]
    #[arg(long, value_name = "ID", conflicts_with = "gsd")]
    access_point: Option<String>,
    /// Folder to write, whose name becomes that of the manual [default: made of the name of the device]; it must not exist
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// A new suite.
struct Suite {
    /// Its files: name and text.
    files: Vec<(String, String)>,
    /// What a person has to decide and no file can say, as sentences.
    decisions: Vec<String>,
}

pub(super) fn suite(args: &SuiteArgs) -> CommandResult {
    match &args.command {
        SuiteCommand::Init(args) => init(args),
    }
}

fn init(args: &SuiteInitArgs) -> CommandResult {
    let (kind, path) = match (&args.gsdml, &args.gsd) {
        (Some(path), _) => (DescriptionKind::Gsdml, path),
        (None, Some(path)) => (DescriptionKind::Gsd, path),
        (None, None) => {
            return Err(CommandError::usage("name the GSDML or the GSD of the device: --gsdml FILE, --gsd FILE"));
        }
    };
    let file = DescriptionFile::open(kind, path)?;
    let failed = |why: String| CommandError::usage(format!("{}: {why}", path.display()));
    let point =
        file.gsdml().map(|gsdml| access_point(gsdml, args.access_point.as_deref())).transpose().map_err(failed)?;
    let usual = match (point, file.gsd()) {
        (Some(point), _) => names::folder_name(&point.info.name, "profinet"),
        (None, gsd) => names::folder_name(gsd.map_or("", |gsd| &gsd.model), "profibus"),
    };
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(usual));
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    if name.is_empty() || name == "common" || name == "personas" {
        return Err(CommandError::usage(format!(
            "`{}` cannot be the name of a manual; choose another folder",
            folder.display()
        )));
    }
    let suite = match (file.gsdml().zip(point), file.gsd()) {
        (Some((gsdml, point)), _) => profinet::suite(gsdml, point, &name),
        (None, Some(gsd)) => profibus::suite(gsd, &name),
        (None, None) => Err("it describes no device".to_owned()),
    };
    let suite = suite.map_err(failed)?;
    check(&suite, &name).map_err(|errors| {
        CommandError::usage(format!(
            "{}: the suite would have errors, and nothing was written:\n{errors}",
            path.display()
        ))
    })?;
    write(&folder, &suite)
        .map_err(|error| CommandError::usage(format!("{} cannot be written: {error}", folder.display())))?;
    suite.decisions.iter().for_each(|decision| print_message(decision));
    print_message(&format!(
        "wrote {0}; read its comments, then: encspec check {0}, and encspec run --suites {0} --device {name} --dut nic:IF, or \
         serial:TTY for PROFIBUS",
        folder.display()
    ));
    Ok(ExitStatus::Green)
}

/// The access point of this id, else the first.
fn access_point<'g>(gsdml: &'g Gsdml, id: Option<&str>) -> Result<&'g AccessPoint, String> {
    let points = &gsdml.access_points;
    match id {
        None => points.first().ok_or_else(|| "the GSDML has no access point".to_owned()),
        Some(id) => points.iter().find(|point| point.id == id).ok_or_else(|| {
            let known: Vec<&str> = points.iter().map(|point| point.id.as_str()).collect();
            super::dut::suggest("access point", id, known)
        }),
    }
}

/// Loads the suite beside the built-in ones, as it will be read from its folder.
fn check(suite: &Suite, name: &str) -> Result<(), LoadErrors> {
    let sources = suite
        .files
        .iter()
        .fold(suites::sources(), |sources, (file, text)| sources.with(&format!("{name}/{file}"), text.as_str()));
    load(&sources, Some(name)).map(|_| ())
}

/// Writes a new folder.
fn write(folder: &Path, suite: &Suite) -> io::Result<()> {
    if let Some(above) = folder.parent() {
        fs::create_dir_all(above)?;
    }
    fs::create_dir(folder)?;
    suite.files.iter().try_for_each(|(name, text)| fs::write(folder.join(name), text))
}
