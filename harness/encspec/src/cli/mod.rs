//! The command line: what is typed, what is shown, how the process ends.
//!
//! Everything is written through `show`, which does not mind a reader that has gone, and every end goes through
//! [`ExitStatus`]. This room must not judge anything.

mod against;
mod bench;
mod bugs;
mod check;
mod control;
mod coverage;
mod discover;
pub mod dut;
mod errata;
mod explain;
pub mod filter;
mod gsd;
pub mod gsdml;
mod list;
pub mod live;
mod personas;
pub mod port;
mod progress;
mod record;
mod replay;
pub mod run;
mod serve;
mod variations;
mod vendor_file;

use clap::{Args, Parser, Subcommand, ValueEnum};
use report::ExitStatus;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use suite::model::Manual;
use suite::persona::Persona;
use suite_yaml::persona::{load_personas, named_persona};
use suite_yaml::{LoadErrors, Sources, load, load_some, schema};

/// Conformance and interoperability tests for absolute encoders.
///
/// Without a command everything is run: every suite against every reference device.
#[derive(Debug, Parser)]
#[command(name = "encspec", version, after_help = EXITS)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

const EXITS: &str = "Exit status: 0 all green, 1 something is not green, 2 a mistake on the command line or in a suite, \
                     3 the bench is unusable.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Run cases and rules against a device
    Run(run::RunArgs),
    /// List cases and rules
    List(Listing),
    /// Say how much of each manual is covered by cases and rules
    Coverage(CoverageArgs),
    /// List the bugs that the reference devices can be told to have, and how much of each manual they break
    Bugs(BugsArgs),
    /// List the variations that the manuals permit, with which no case may fail
    Variations(Listing),
    /// List the personas: in the manner of which controllers a device can be addressed
    Personas(personas::PersonasArgs),
    /// List where the manuals contradict themselves, and where they are silent
    Errata(Listing),
    /// Explain a requirement, a case, a rule, a bug or a check of the protocol
    Explain(ExplainArgs),
    /// Check suites and say what nothing uses
    Check(CheckArgs),
    /// Print the JSON schema of suite files and bench files, with a sentence for each word
    Schema,
    /// Judge captures by the rules, and say what happened in them
    Replay(ReplayArgs),
    /// Show a capture frame by frame
    Dissect(DissectArgs),
    /// Record what is heard at a serial line or an interface, or make a capture of a hex log
    Record(record::RecordArgs),
    /// Serve a reference device as a live device
    Serve(serve::ServeArgs),
    /// Send a command to the control channel of a served device: power, shaft, faults
    Control(control::ControlArgs),
    /// Show a vendor's GSDML, and compare it with a manual
    Gsdml(gsdml::GsdmlArgs),
    /// Show what a GSD (PROFIBUS) says, and where it disagrees with a manual
    Gsd(gsd::GsdArgs),
    /// Find the stations of a segment
    Discover(discover::DiscoverArgs),
    /// Write bench files, and put back what a run has changed
    Bench(bench::BenchArgs),
}

#[derive(Debug, Args)]
struct Which {
    /// The manual; all by default
    manual: Option<String>,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct Listing {
    #[command(flatten)]
    which: Which,
    /// How it is shown
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Debug, Args)]
struct BugsArgs {
    /// The manual; all by default
    manual: Option<String>,
    /// Only bugs with this in their name, or that break the requirement of this id
    filter: Option<String>,
    /// How it is shown
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct CoverageArgs {
    /// How it is shown
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct ExplainArgs {
    /// The id of a requirement, a case or a rule (`parking/stays-parked` will do), or the name of a bug or check
    id: String,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct CheckArgs {
    /// A folder of suites, the folder of one manual, or a file in it; the built-in suites by default
    path: Option<PathBuf>,
}

#[derive(Debug, Args)]
struct ReplayArgs {
    /// Captures, pcap or pcapng, packed by gzip or zstd or not; - is the standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<String>,
    /// Write a report: html, json or text; the file - is the standard output
    #[arg(long, value_name = "FORMAT=FILE", value_parser = replay_report)]
    report: Vec<ReplayWanted>,
    /// Judge by the rules of this manual only; it is also taken for connections whose Connect is not in the capture
    #[arg(long, value_name = "MANUAL[/VARIANT]")]
    device: Option<String>,
    #[command(flatten)]
    against: against::AgainstArgs,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct DissectArgs {
    /// A capture, pcap or pcapng, packed by gzip or zstd or not; - is the standard input
    file: PathBuf,
}

/// A report of a replay that is asked for.
#[derive(Clone, Debug)]
struct ReplayWanted {
    format: ReplayFormat,
    file: PathBuf,
}

fn replay_report(text: &str) -> Result<ReplayWanted, String> {
    let (word, file) = run::format_and_file(text)?;
    match word {
        "html" => Ok(ReplayWanted { format: ReplayFormat::Html, file }),
        "json" => Ok(ReplayWanted { format: ReplayFormat::Json, file }),
        "text" => Ok(ReplayWanted { format: ReplayFormat::Text, file }),
        word => Err(dut::suggest("format", word, ["html", "json", "text"])),
    }
}

/// How the report of a replay is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ReplayFormat {
    /// For a browser.
    Html,
    /// For programs.
    Json,
    /// For people.
    Text,
}

/// How a listing is shown.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Format {
    /// For people.
    #[default]
    Text,
    /// For programs.
    Json,
}

/// Where the suites come from.
#[derive(Clone, Debug, Default, Args)]
pub struct Suites {
    /// Read the suites from this folder instead of the built-in ones
    #[arg(long = "suites", value_name = "DIR")]
    pub folder: Option<PathBuf>,
}

impl Suites {
    /// Loads every manual.
    pub fn load(&self) -> Result<Vec<Manual>, LoadErrors> {
        load(&sources(self.folder.as_deref())?, None)
    }

    /// Loads the manuals that `duts` name; every manual unless all of these are built-in suites of reference devices.
    fn load_for(&self, duts: &[String]) -> Result<Vec<Manual>, LoadErrors> {
        let sources = sources(self.folder.as_deref())?;
        let known = sources.manuals();
        let named = |dut: &String| {
            let name = dut.strip_prefix("model:")?;
            let name = name.split_once('/').map_or(name, |(name, _)| name);
            known.iter().find(|known| *known == name).map(String::as_str)
        };
        match duts.iter().map(named).collect::<Option<Vec<&str>>>() {
            // What stands in a folder may be wrong, and whoever works there is told.
            Some(names) if !names.is_empty() && self.folder.is_none() => load_some(&sources, &names),
            _ => load(&sources, None),
        }
    }

    /// Loads every persona.
    pub fn personas(&self) -> Result<Vec<Persona>, LoadErrors> {
        load_personas(&sources(self.folder.as_deref())?)
    }

    /// The persona of a name; one that is not known is a mistake on the command line.
    pub fn persona(&self, name: &str) -> Result<Arc<Persona>, Stop> {
        Ok(Arc::new(named_persona(self.personas()?, name).map_err(Stop::usage)?))
    }

    fn load_one(&self, manual: Option<&str>) -> Result<Vec<Manual>, Stop> {
        Ok(load(&sources(self.folder.as_deref())?, manual)?)
    }
}

fn sources(folder: Option<&Path>) -> Result<Sources, LoadErrors> {
    let sources = folder.map_or_else(|| Ok(suites::sources()), Sources::folder)?;
    Ok(sources.with_sentences(deviations::sentence))
}

/// Why a command ends before its work is done: what is said, and how the process ends.
#[derive(Debug)]
pub struct Stop {
    /// What is said, one clear message.
    pub message: String,
    /// How the process ends.
    pub status: ExitStatus,
}

impl Stop {
    /// A mistake on the command line or in a file that it names.
    pub fn usage(message: impl Into<String>) -> Stop {
        Stop { message: message.into(), status: ExitStatus::Usage }
    }

    /// The bench cannot be used.
    pub fn bench(message: impl Into<String>) -> Stop {
        Stop { message: message.into(), status: ExitStatus::Bench }
    }
}

impl From<LoadErrors> for Stop {
    fn from(errors: LoadErrors) -> Stop {
        let mistakes = match errors.0.len() {
            1 => String::new(),
            n => format!("\n{n} mistakes in the suites"),
        };
        Stop::usage(format!("{errors}{mistakes}"))
    }
}

/// Does what the command line says; this is all that the binary does.
pub fn main() -> ExitCode {
    let command = Cli::parse().command.or_else(|| Cli::parse_from(["encspec", "run"]).command);
    let ended = command.map_or(Ok(ExitStatus::Usage), |command| match command {
        Command::Run(args) => run::run(&args),
        Command::List(args) => list::list(&args),
        Command::Coverage(args) => coverage::coverage(&args),
        Command::Bugs(args) => bugs::bugs(&args),
        Command::Variations(args) => variations::variations(&args),
        Command::Personas(args) => personas::personas(&args),
        Command::Errata(args) => errata::errata(&args),
        Command::Explain(args) => explain::explain(&args),
        Command::Check(args) => check::check(&args),
        Command::Schema => {
            show(&format!("{:#}\n", schema()));
            Ok(ExitStatus::Green)
        }
        Command::Replay(args) => replay::replay(&args),
        Command::Dissect(args) => replay::dissect(&args),
        Command::Record(args) => record::record(&args),
        Command::Gsd(args) => gsd::gsd(&args),
        Command::Gsdml(args) => gsdml::gsdml(&args),
        Command::Serve(args) => serve::run(&args),
        Command::Control(args) => control::run(&args),
        Command::Discover(args) => discover::run(&args),
        Command::Bench(args) => bench::run(&args),
    });
    let status = ended.unwrap_or_else(|stop| {
        complain(&stop.message);
        stop.status
    });
    ExitCode::from(status.code())
}

/// How a command ends.
type Ended = Result<ExitStatus, Stop>;

/// Writes `text` to standard output; a reader that has gone away is no failure.
fn show(text: &str) {
    let mut out = io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// Writes a message to standard error.
fn complain(message: &str) {
    let _ = writeln!(io::stderr().lock(), "encspec: {}", message.trim_end());
}
