//! The command line: arguments, output and exit status of each command.
//!
//! All output goes through `show`, which ignores a closed pipe, and every command ends with an [`ExitStatus`]. Verdicts are decided
//! elsewhere.

mod against;
mod attribution;
mod bench;
mod bugs;
mod check;
mod control;
mod coverage;
mod diff;
mod discover;
mod doctor;
pub mod dut;
pub mod encoder;
mod errata;
mod explain;
mod explore;
pub mod filter;
mod gsd;
pub mod gsdml;
mod hash;
mod list;
pub mod live;
mod merge;
mod package_files;
mod pdf;
mod personas;
pub mod port;
mod progress;
mod record;
mod replay;
mod reports;
pub mod run;
mod serve;
mod slaves;
mod suite;
mod suite_folders;
mod variations;
mod vendor_file;
mod verify;
mod watch;

use clap::{Args, ColorChoice, Parser, Subcommand, ValueEnum};
use report::ExitStatus;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::LazyLock;
pub use suite_folders::Suites;
use suite_yaml::LoadErrors;

/// Conformance and interoperability tests for absolute encoders on PROFINET and PROFIBUS DP.
///
/// Without a command, every suite runs against every reference device (`encspec run`).
#[derive(Debug, Parser)]
#[command(name = "encspec", version = VERSION.as_str(), after_help = EXITS)]
struct Cli {
    #[command(subcommand)]
    command: Option<CliCommand>,
}

/// The version, with commit and date if they are known.
static VERSION: LazyLock<String> = LazyLock::new(|| {
    let version = env!("CARGO_PKG_VERSION");
    match (commit(), env!("ENCSPEC_COMMIT_DATE")) {
        (None, _) => version.to_owned(),
        (Some(commit), "") => format!("{version} ({commit})"),
        (Some(commit), date) => format!("{version} ({commit} {date})"),
    }
});

/// The commit from which this program was built, if it is known.
fn commit() -> Option<&'static str> {
    Some(env!("ENCSPEC_COMMIT")).filter(|commit| !commit.is_empty())
}

const EXITS: &str = "\
Exit status: 0 all green, 1 at least one result is red, 2 an error on the command line or in a suite, 3 the bench cannot be used.";

#[derive(Debug, Subcommand)]
enum CliCommand {
    /// Run cases and rules against a device
    #[command(after_help = "Example: encspec run --dut bench.yaml parking --report html=report.html")]
    Run(run::RunArgs),
    /// Compare two runs: what newly fails, newly passes, or has another reason
    Diff(diff::DiffArgs),
    /// Join the parts of a run, or runs of different devices, into one report
    Merge(merge::MergeArgs),
    /// Check the evidence of a report: whether each capture is there and unchanged
    Verify(verify::VerifyArgs),
    /// Find what no case names: draw sequences, compare the device with its reference device, and write each difference as a case
    Explore(explore::ExploreArgs),
    /// List cases and rules
    #[command(after_help = "Example: encspec list parking")]
    List(list::ListArgs),
    /// Show how much of each manual the cases and rules cover
    #[command(after_help = "Example: encspec coverage MANUAL")]
    Coverage(CoverageArgs),
    /// Measure whether a failure names the requirement that is broken
    #[command(after_help = "Example: encspec attribution MANUAL --bug speed-without-sign")]
    Attribution(AttributionArgs),
    /// List the bugs that the reference devices can have, and the requirements that each bug breaks
    #[command(after_help = "Example: encspec bugs MANUAL preset")]
    Bugs(BugsArgs),
    /// List the variations that the manuals permit; no case may fail because of one
    #[command(after_help = "Example: encspec variations MANUAL")]
    Variations(variations::VariationsArgs),
    /// List the personas: other IO controllers that encspec can act like
    #[command(after_help = "Example: encspec personas")]
    Personas(personas::PersonasArgs),
    /// List where the manuals contradict themselves and what they leave open
    #[command(after_help = "Example: encspec errata MANUAL")]
    Errata(ListingArgs),
    /// Explain a requirement, case, rule, bug or protocol check
    #[command(after_help = "Example: encspec explain parking/stays-parked")]
    Explain(ExplainArgs),
    /// Check suites for errors and list unused definitions
    #[command(after_help = "Example: encspec check suites/my-encoder")]
    Check(CheckArgs),
    /// Print the JSON schema of suite files and bench files, with a description of each key
    #[command(after_help = "Example: encspec schema > encspec.schema.json")]
    Schema,
    /// Check captures against the rules and the protocol, and report what went wrong
    #[command(after_help = "Example: encspec replay field.pcapng --severity warning --report html=field.html")]
    Replay(ReplayArgs),
    /// Watch a network or bus for weeks without sending a frame: findings, the frames around them, and counts
    Watch(watch::WatchArgs),
    /// Print a capture frame by frame
    #[command(after_help = "Example: encspec dissect field.pcapng")]
    Dissect(DissectArgs),
    /// Record a capture from a serial line or a network interface, or convert a hex log to one
    #[command(after_help = "Example: encspec record field.pcapng --serial /dev/ttyUSB0 --baud 1500000 --duration 60")]
    Record(record::RecordArgs),
    /// Serve a reference device on a network interface, a socket or a serial line
    #[command(after_help = "Example: encspec serve model:MANUAL/VARIANT --nic veth1 --control stand")]
    Serve(serve::ServeArgs),
    /// Send a command to the control channel of a served device: power, shaft, faults
    #[command(after_help = "Example: encspec control stand shaft speed 60")]
    Control(control::ControlArgs),
    /// Print the contents of a GSDML file (PROFINET), and compare it with a manual
    #[command(after_help = "Example: encspec gsdml GSDML-V2.43-Vendor-Encoder-20260101.xml --device MANUAL/VARIANT")]
    Gsdml(gsdml::GsdmlArgs),
    /// Print the contents of a GSD file (PROFIBUS), and compare it with a manual
    #[command(after_help = "Example: encspec gsd ENCODER.GSD --device MANUAL/VARIANT")]
    Gsd(gsd::GsdArgs),
    /// Check whether this host can test a live device, and name what fixes it
    Doctor(doctor::DoctorArgs),
    /// Discover the stations on a PROFINET segment or a PROFIBUS
    #[command(after_help = "Example: encspec discover --nic eth1")]
    Discover(discover::DiscoverArgs),
    /// Create bench files, and restore a device after an interrupted run
    Bench(bench::BenchArgs),
    /// Create a suite for a device that no built-in suite describes
    Suite(suite::SuiteArgs),
    /// Write the manual pages, for packages
    #[command(hide = true)]
    Man(package_files::ManArgs),
    /// Print the completions of a shell, for packages
    #[command(hide = true)]
    Completions(package_files::CompletionsArgs),
}

#[derive(Debug, Args)]
struct ManualSelection {
    /// Name of the manual [default: all manuals]
    manual: Option<String>,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct ListingArgs {
    #[command(flatten)]
    which: ManualSelection,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: ListingFormat,
}

#[derive(Debug, Args)]
struct BugsArgs {
    /// Name of the manual [default: all manuals]
    manual: Option<String>,
    /// List only bugs whose name contains this text, or that break the requirement with this id
    filter: Option<String>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: ListingFormat,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct AttributionArgs {
    /// Name of the manual [default: all manuals]
    manual: Option<String>,
    /// Also run everything with each bug, which takes minutes, and list what fails beyond the requirements that it breaks
    #[arg(long)]
    bugs: bool,
    /// Run everything with this bug only, and list each failure; may be repeated
    #[arg(long, value_name = "NAME")]
    bug: Vec<String>,
    /// Number of cases that run at the same time [default: number of processors]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct CoverageArgs {
    /// Name of the manual [default: all manuals]
    manual: Option<String>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: ListingFormat,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct ExplainArgs {
    /// Id of a requirement, case or rule (`parking/stays-parked` is enough), or name of a bug or protocol check
    id: String,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct CheckArgs {
    /// Folder of suites, folder of one manual, or a file in it [default: the built-in suites]
    path: Option<PathBuf>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: check::CheckFormat,
    #[command(flatten)]
    suites: Suites,
}

#[derive(Debug, Args)]
struct ReplayArgs {
    /// Captures in pcap or pcapng format, optionally compressed with gzip or zstd; - reads standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<String>,
    /// Write a report; FORMAT is html, json or text, FILE - is standard output; may be repeated
    #[arg(long, value_name = "FORMAT=FILE", value_parser = replay_report)]
    report: Vec<ReplayReportRequest>,
    /// Write the capture again as pcapng, with each finding as a comment of its packet and the names of the stations, for Wireshark
    #[arg(long, value_name = "FILE")]
    annotate: Option<PathBuf>,
    /// With --annotate: write PROFIBUS frames with the user link type NUMBER, 0 to 15, since Wireshark refuses that of PROFIBUS; its
    /// dissector is printed by `encspec dissect --lua`
    #[arg(long, value_name = "NUMBER", requires = "annotate", value_parser = clap::value_parser!(u8).range(0..16))]
    user_link_type: Option<u8>,
    /// Use the rules of this manual only, also for connections whose Connect is not in the capture
    #[arg(long, value_name = "MANUAL[/VARIANT]")]
    device: Option<String>,
    #[command(flatten)]
    filter: ShownFindings,
    /// Colours on the terminal: auto leaves them out where the output is no terminal, or NO_COLOR is set
    #[arg(long, value_name = "WHEN", value_enum, default_value_t = ColorChoice::Auto)]
    color: ColorChoice,
    #[command(flatten)]
    against: against::AgainstArgs,
    #[command(flatten)]
    suites: Suites,
}

/// What of the report is shown; the exit status counts what is shown.
#[derive(Clone, Debug, Args)]
struct ShownFindings {
    /// Show findings of this severity and above
    #[arg(long, value_name = "SEVERITY", value_enum)]
    severity: Option<SeverityChoice>,
    /// Show the findings, events and connections of one station: its MAC address, station name, IP address or PROFIBUS address
    #[arg(long, value_name = "STATION")]
    station: Option<String>,
    /// Show findings and events from this time on: seconds since the first frame, or a time in UTC (2026-03-01T14:00:00)
    #[arg(long, value_name = "TIME")]
    from: Option<::replay::CaptureTime>,
    /// Show findings and events up to this time
    #[arg(long, value_name = "TIME")]
    to: Option<::replay::CaptureTime>,
}

/// The severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SeverityChoice {
    Error,
    Warning,
    Info,
}

#[derive(Debug, Args)]
struct DissectArgs {
    /// Capture in pcap or pcapng format, optionally compressed with gzip or zstd; - reads standard input
    #[arg(required_unless_present = "lua")]
    file: Option<PathBuf>,
    /// Print the fields of each PROFIBUS frame as a line of JSON, by the names that the dissector for Wireshark uses
    #[arg(long)]
    fields: bool,
    /// Print a dissector for Wireshark, in Lua: PROFIBUS frames of the user link type NUMBER, 0 to 15 (0 unless named)
    #[arg(long, value_name = "NUMBER", num_args = 0..=1, default_missing_value = "0", conflicts_with_all = ["file", "fields"],
        value_parser = clap::value_parser!(u8).range(0..16))]
    lua: Option<u8>,
}

/// A report that `--report` of `encspec replay` requests.
#[derive(Clone, Debug)]
struct ReplayReportRequest {
    format: ReplayFormat,
    file: PathBuf,
}

fn replay_report(text: &str) -> Result<ReplayReportRequest, String> {
    let (word, file) = reports::format_and_file(text)?;
    match word {
        "html" => Ok(ReplayReportRequest { format: ReplayFormat::Html, file }),
        "json" => Ok(ReplayReportRequest { format: ReplayFormat::Json, file }),
        "text" => Ok(ReplayReportRequest { format: ReplayFormat::Text, file }),
        word => Err(dut::suggest("format", word, ["html", "json", "text"])),
    }
}

/// The format of a replay report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ReplayFormat {
    Html,
    Json,
    Text,
}

/// The output format of a listing.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum ListingFormat {
    #[default]
    Text,
    Json,
}

/// An error that ends a command: the message for standard error, and the exit status.
#[derive(Debug)]
pub struct CommandError {
    /// The message, without the program's name.
    pub message: String,
    /// The exit status of the process.
    pub status: ExitStatus,
}

impl CommandError {
    /// An error on the command line or in a file that it names.
    pub fn usage(message: impl Into<String>) -> CommandError {
        CommandError { message: message.into(), status: ExitStatus::Usage }
    }

    /// The bench cannot be used, or output cannot be written.
    pub fn bench(message: impl Into<String>) -> CommandError {
        CommandError { message: message.into(), status: ExitStatus::Bench }
    }
}

impl From<LoadErrors> for CommandError {
    fn from(errors: LoadErrors) -> CommandError {
        let count = match errors.0.len() {
            1 => String::new(),
            n => format!("\n{n} errors in the suites"),
        };
        CommandError::usage(format!("{errors}{count}"))
    }
}

/// Parses the command line and runs the command.
pub fn main() -> ExitCode {
    let command = Cli::parse().command.or_else(|| Cli::parse_from(["encspec", "run"]).command);
    let ended = command.map_or(Ok(ExitStatus::Usage), |command| match command {
        CliCommand::Run(args) => run::run(&args),
        CliCommand::Diff(args) => diff::diff(&args),
        CliCommand::Merge(args) => merge::run(&args),
        CliCommand::Verify(args) => verify::verify(&args),
        CliCommand::Explore(args) => explore::explore(&args),
        CliCommand::List(args) => list::list(&args),
        CliCommand::Coverage(args) => coverage::coverage(&args),
        CliCommand::Attribution(args) => attribution::attribution(&args),
        CliCommand::Bugs(args) => bugs::bugs(&args),
        CliCommand::Variations(args) => variations::variations(&args),
        CliCommand::Personas(args) => personas::personas(&args),
        CliCommand::Errata(args) => errata::errata(&args),
        CliCommand::Explain(args) => explain::explain(&args),
        CliCommand::Check(args) => check::check(&args),
        CliCommand::Schema => {
            show(&format!("{:#}\n", results::schema()));
            Ok(ExitStatus::Green)
        }
        CliCommand::Replay(args) => replay::replay(&args),
        CliCommand::Watch(args) => watch::watch(&args),
        CliCommand::Dissect(args) => replay::dissect(&args),
        CliCommand::Record(args) => record::record(&args),
        CliCommand::Gsd(args) => gsd::gsd(&args),
        CliCommand::Gsdml(args) => gsdml::gsdml(&args),
        CliCommand::Serve(args) => serve::run(&args),
        CliCommand::Control(args) => control::run(&args),
        CliCommand::Doctor(args) => doctor::doctor(&args),
        CliCommand::Man(args) => package_files::man(&args),
        CliCommand::Completions(args) => package_files::completions(&args),
        CliCommand::Discover(args) => discover::run(&args),
        CliCommand::Bench(args) => bench::run(&args),
        CliCommand::Suite(args) => suite::suite(&args),
    });
    let status = ended.unwrap_or_else(|stop| {
        print_message(&stop.message);
        stop.status
    });
    ExitCode::from(status.code())
}

/// The result of a command.
type CommandResult = Result<ExitStatus, CommandError>;

/// Writes `text` to standard output. A closed pipe is not an error.
fn show(text: &str) {
    let mut out = io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// Writes a message to standard error.
fn print_message(message: &str) {
    let _ = writeln!(io::stderr().lock(), "encspec: {}", message.trim_end());
}
