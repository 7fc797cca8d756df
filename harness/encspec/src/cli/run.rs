//! `encspec run`: runs cases and rules, writes reports, and decides the exit status.

use super::dut::{Devices, devices};
use super::encoder::GsdmlEncoder;
use super::filter::{FilterArgs, LAST_RUN, last_run};
use super::hash::{sha256_of_file, sha256_of_suite};
use super::reports::{
    ReportRequest, check_folders, colours, open_all, parse_report_request, uses_standard_output, write_all,
};
use super::{CommandError, CommandResult, Suites, show};
use clap::{ArgAction, Args, ColorChoice, ValueEnum};
use deviations::{Subject, persona_bugs};
use engine::{self, DutSpec, FailFast, RunOptions, TrialPart};
use indicatif::{ProgressBar, ProgressStyle};
use live::lock::Lock;
use plain_text::nearest;
use report::{self, ResultColour};
use results::ledger::{self, Date, Ledger};
use results::outcome::{CaseResult, DeviceRun, MinimumPass, RunResult};
use results::time_stamp;
use std::fs;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};
use suite::model::Manual;

/// The default folder for captures of cases that are not green. It is created with the first capture.
pub(super) const EVIDENCE: &str = "encspec-evidence";

/// Arguments of `encspec run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    #[command(flatten)]
    filter: FilterArgs,
    /// Device under test [default: every reference device]; may be repeated. One of: model:MANUAL[/VARIANT], a reference device;
    /// FILE.yaml, the bench file of a live device; nic:INTERFACE, socket:ADDRESS or serial:TTY, a live device without a bench file;
    /// app:COMMAND, a program that is the application of a device and has no network (docs/application-protocol.md);
    /// null:KIND, a device that must fail (absent, silent, reflector, babbler, wrong-identity, dies-after-N, or a hostile one, whose
    /// names `null:?` lists)
    #[arg(long, value_name = "DUT")]
    dut: Vec<String>,
    /// Manual and variant that the device under test claims to be, where --dut does not name them
    #[arg(long, value_name = "MANUAL[/VARIANT]")]
    device: Option<String>,
    /// With --device none: the GSDML that describes a reference device in place of its manual
    #[arg(long, value_name = "FILE")]
    gsdml: Option<PathBuf>,
    /// Enable a bug of the reference device; may be repeated; `encspec bugs` lists them
    #[arg(long, value_name = "NAME")]
    bug: Vec<String>,
    /// Enable a variation that the manual permits, or with random:SEED a random combination of them; may be repeated;
    /// `encspec variations` lists them
    #[arg(long, value_name = "NAME")]
    vary: Vec<String>,
    /// Act like the IO controller of this persona; `encspec personas` lists them. The cases stay the same: cycle and watchdog of a
    /// case override the persona's, and a case that cannot be judged at the persona's cycle is not applicable
    #[arg(long, value_name = "NAME")]
    persona: Option<String>,
    /// Lowest requirement level whose failures make the run red
    #[arg(long, value_enum, default_value_t)]
    gate: FailureGate,
    /// Least number of results of each device that have to pass, or a percentage of all its results: 40 or 80%
    #[arg(long, value_name = "N|P%")]
    min_pass: Option<MinimumPass>,
    /// Results that make the run red although they do not by themselves
    #[arg(long, value_enum)]
    fail_on: Option<FailOn>,
    /// Write a report; FORMAT is console, github, html, json, junit, markdown, pdf, tap or text, FILE - is standard output;
    /// may be repeated. `github` alone writes annotations for GitHub Actions, and its summary of the step
    #[arg(long, value_name = "FORMAT=FILE", value_parser = parse_report_request)]
    report: Vec<ReportRequest>,
    /// Ledger of known failures
    #[arg(long, value_name = "FILE")]
    ledger: Option<PathBuf>,
    /// Write a capture of each case that is not green to this folder
    #[arg(long, value_name = "DIR", default_value = EVIDENCE)]
    evidence: Option<PathBuf>,
    /// Write no captures
    #[arg(long, conflicts_with = "evidence")]
    no_evidence: bool,
    /// Write a capture of every case to this folder
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
    /// Number of cases that run at the same time [default: number of processors]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
    /// Run only part N of M of the cases, to split a run between several benches
    #[arg(long, value_name = "N/M")]
    part: Option<TrialPart>,
    /// End the run at the first red result that the ledger does not excuse; what was not run is `not-run`
    #[arg(long)]
    fail_fast: bool,
    /// Run a case that did not pass again, so many times at most; one that passes then is flaky, which is red
    #[arg(long, value_name = "N", default_value_t = 0)]
    retries: u32,
    /// Let the run be green although cases passed only when they were repeated
    #[arg(long, requires = "retries")]
    accept_flaky: bool,
    /// Also run cases that wait for minutes on a live device
    #[arg(long)]
    long: bool,
    /// How often a live trial is repeated that has no verdict only because this host or the line was late
    #[arg(long, value_name = "N", default_value_t = engine::STALL_REPEATS)]
    stall_repeats: u32,
    /// Seconds to wait for a live device that another process is testing
    #[arg(long, value_name = "SECONDS", default_value_t = 60)]
    lock_wait: u64,
    /// Who runs it, for the report
    #[arg(long, value_name = "NAME")]
    operator: Option<String>,
    /// List every case
    #[arg(short, long, visible_alias = "all", action = ArgAction::SetTrue)]
    verbose: bool,
    /// Print only what is red, and the last line
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,
    /// Whether to use colours; auto: on a terminal, unless NO_COLOR is set
    #[arg(long, value_enum, value_name = "WHEN", default_value_t = ColorChoice::Auto)]
    color: ColorChoice,
    #[command(flatten)]
    suites: Suites,
}

/// The lowest requirement level whose failures make the run red.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum FailureGate {
    /// Only failures of `must` requirements
    Must,
    /// Failures of `must` and `should` requirements
    #[default]
    Should,
}

/// Results that make a run red only on request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FailOn {
    /// What the bench cannot test
    NotApplicable,
}

/// What to run, named as on the command line. The `cargo test` front end (`tests/conformance.rs`) uses it as well.
#[derive(Clone, Debug, Default)]
pub struct RunRequest {
    /// `--dut`.
    pub duts: Vec<String>,
    /// `--device`.
    pub device: Option<String>,
    /// `--bug`.
    pub bugs: Vec<String>,
    /// `--vary`.
    pub variations: Vec<String>,
    /// `--persona`.
    pub persona: Option<String>,
    /// `FILTER`, `--exact` and `--failed`.
    pub filter: FilterArgs,
    /// `--gate must`.
    pub gate_must: bool,
    /// `--ledger`.
    pub ledger: Option<PathBuf>,
    /// `--evidence`.
    pub evidence: Option<PathBuf>,
    /// `--record`.
    pub record: Option<PathBuf>,
    /// `--threads`; 0 for the number of processors.
    pub threads: usize,
    /// `--stall-repeats`.
    pub stall_repeats: u32,
    /// `--lock-wait`.
    pub lock_wait: Duration,
    /// `--part`.
    pub part: Option<TrialPart>,
    /// `--long`.
    pub long: bool,
    /// `--fail-fast`.
    pub fail_fast: bool,
    /// `--retries`.
    pub retries: u32,
    /// `--accept-flaky`.
    pub accept_flaky: bool,
    /// `--fail-on not-applicable`.
    pub fail_on_not_applicable: bool,
    /// `--suites`.
    pub suites: Suites,
    /// A reference device that is tested by its GSDML alone; it takes the place of the devices that the other options name.
    pub described: Option<DutSpec>,
}

/// A checked request whose live devices are locked and open.
#[derive(Debug)]
pub struct PreparedRun {
    options: RunOptions,
    ledger: Ledger,
    /// What decides whether a result is red; it has no runs.
    settings: RunResult,
    /// Held until the run ends.
    _locks: Vec<Lock>,
}

impl RunRequest {
    /// Checks the request, then locks and opens the live devices. No case has run when this fails.
    pub fn ready(&self, manuals: &[Manual]) -> Result<PreparedRun, CommandError> {
        for bug in self.bugs.iter().filter(|_| self.described.is_none()) {
            let listed = || manuals.iter().flat_map(|manual| &manual.bugs).map(|bug| bug.name.as_str());
            check_known_name("bug", bug, "bugs", listed().chain(persona_bugs().map(|bug| bug.name)))?;
        }
        for variation in &self.variations {
            if !deviations::subjects().iter().any(|subject| subject.variations_of(variation).is_some()) {
                let known = deviations::subjects().iter().flat_map(Subject::permitted).map(|known| known.name);
                check_known_name("variation", variation, "variations", known)?;
            }
        }
        let persona = self.persona.as_deref().map(|name| self.suites.persona(name)).transpose()?;
        let deviations = [self.bugs.as_slice(), &self.variations].concat();
        let mut devices = match &self.described {
            Some(spec) => Devices { here: vec![spec.clone()], ..Devices::default() },
            None => devices(&self.duts, self.device.as_deref(), &deviations, manuals).map_err(CommandError::usage)?,
        };
        for name in &devices.without_model {
            super::print_message(&format!(
                "{name} is not run: it has no reference device; name a live device with --dut"
            ));
        }
        if self.described.is_none() {
            self.retain_devices_with_deviations(&mut devices.here, manuals)?;
        }
        if persona.is_some() && self.duts.is_empty() && self.device.is_none() {
            // A persona is a PROFINET controller. A slave named with `--dut` stays; each of its cases is then not applicable.
            let is_slave = |manual: &Manual| manual.device.profibus().is_some();
            let slaves: Vec<&str> =
                manuals.iter().filter(|of| is_slave(of)).map(|of| of.device.name.as_str()).collect();
            devices.here.retain(|spec| !slaves.contains(&spec.manual.as_str()));
        }
        let options = RunOptions {
            duts: devices.here.clone(),
            selection: self.filter.selection(manuals, self.evidence.as_deref().unwrap_or(Path::new(EVIDENCE)))?,
            evidence: self.evidence.clone(),
            record: self.record.clone(),
            threads: self.threads,
            gate_must: self.gate_must,
            part: self.part,
            persona: persona.clone(),
            stall_repeats: self.stall_repeats,
            retries: self.retries,
            fail_fast: None,
            unjudged: false,
        };
        let selected = |spec: &DutSpec| {
            let manual = manuals.iter().find(|manual| manual.device.name == spec.manual)?;
            Some((manual, manual.variants.iter().find(|variant| variant.name == spec.variant)?))
        };
        self.filter.check_matches(&options.selection, &options.duts.iter().filter_map(selected).collect::<Vec<_>>())?;
        let mut options = options;
        if self.duts.is_empty() && self.device.is_none() {
            // Where no device is named, those without anything to run are none of the run.
            let selection = options.selection.clone();
            options
                .duts
                .retain(|spec| selected(spec).is_none_or(|(manual, variant)| selection.selects_in(manual, variant)));
        }
        let benches =
            devices.live.iter().map(|target| target.bench(manuals)).collect::<Result<Vec<_>, CommandError>>()?;
        let ledger_of_bench = benches.iter().find_map(|bench| bench.ledger.clone());
        let has_null_device = devices.here.iter().any(|device| device.kind_word() == "null");
        let ledger = match self.ledger.clone().or(ledger_of_bench) {
            Some(_) if has_null_device => {
                return Err(CommandError::usage(
                    "a ledger of known failures cannot be used with null devices, which must fail",
                ));
            }
            Some(path) => Ledger::read(&path, manuals).map_err(|error| CommandError::usage(error.to_string()))?,
            None => Ledger::default(),
        };
        let mut locks = Vec::new();
        for bench in benches {
            locks.push(super::live::lock(&bench, self.lock_wait)?);
            let of_bench = || bench.persona.as_deref().map(|name| self.suites.persona(name)).transpose();
            let persona = persona.clone().map_or_else(of_bench, |persona| Ok(Some(persona)))?;
            options.duts.push(super::live::open(bench, &self.suites, self.long, persona)?);
        }
        let settings = RunResult {
            gate_must: self.gate_must,
            accept_flaky: self.accept_flaky,
            fail_on_not_applicable: self.fail_on_not_applicable,
            filters: self.filter.as_written(),
            ..RunResult::default()
        };
        options.fail_fast = self.fail_fast.then(|| fail_fast(ledger.clone(), settings.clone()));
        Ok(PreparedRun { options, ledger, settings, _locks: locks })
    }

    /// Drops devices that cannot have the bugs and variations. It is an error if such a device was named.
    fn retain_devices_with_deviations(
        &self,
        devices: &mut Vec<DutSpec>,
        manuals: &[Manual],
    ) -> Result<(), CommandError> {
        let lists = |folder: &str, name: &String| {
            let manual = manuals.iter().find(|manual| manual.device.name == folder);
            manual.is_some_and(|manual| manual.bugs.iter().any(|bug| bug.name == *name))
        };
        let has =
            |spec: &DutSpec, name: &String| lists(&spec.manual, name) || persona_bugs().any(|bug| bug.name == name);
        // A suite that the manual uses too may list it; then it has to be asked for by the name of the device.
        let can_have = |spec: &DutSpec, name: &String| {
            let manual = manuals.iter().find(|manual| manual.device.name == spec.manual);
            manual.is_some_and(|manual| manual.also.iter().any(|suite| lists(&suite.name, name)))
                && deviations::subject(&spec.manual).is_ok_and(|of| of.bugs().any(|bug| bug.name == name))
        };
        let varies = |spec: &DutSpec, name: &String| {
            deviations::subject(&spec.manual).is_ok_and(|of| of.variations_of(name).is_some())
        };
        if self.duts.is_empty() && self.device.is_none() {
            devices.retain(|spec| self.bugs.iter().all(|bug| has(spec, bug)));
            devices.retain(|spec| self.variations.iter().all(|variation| varies(spec, variation)));
            if devices.is_empty() {
                return Err(CommandError::usage("no reference device has all of these bugs and variations"));
            }
        }
        for spec in devices.iter() {
            if let Some(bug) = self.bugs.iter().find(|bug| !has(spec, bug) && !can_have(spec, bug)) {
                return Err(CommandError::usage(format!("{} has no bug `{bug}`", spec.manual)));
            }
            if let Some(variation) = self.variations.iter().find(|variation| !varies(spec, variation)) {
                return Err(CommandError::usage(format!("{} has no variation `{variation}`", spec.manual)));
            }
        }
        Ok(())
    }
}

/// Ends a run at a result that is red by these settings and this ledger. An entry for some firmware versions does not apply, since the
/// firmware is not known before the end.
fn fail_fast(ledger: Ledger, settings: RunResult) -> FailFast {
    let today = Date::of(SystemTime::now());
    FailFast(Arc::new(move |device: &DutSpec, case: &CaseResult| {
        let run = DeviceRun::of_one(&device.to_string(), (device.kind_word(), &device.manual, &device.variant), case);
        let mut result = RunResult { runs: vec![run], ..settings.clone() };
        ledger::apply(&ledger, &mut result, today);
        let run = &result.runs[0];
        run.cases.iter().any(|case| report::result_colour(&result, run, case) == ResultColour::Red)
    }))
}

/// The name of this host, if it has one.
fn host() -> Option<String> {
    let name = fs::read_to_string("/proc/sys/kernel/hostname").ok()?;
    Some(name.trim().to_owned()).filter(|name| !name.is_empty())
}

/// Fails if `name` is unknown. The error suggests the nearest name, or the command that lists all names.
fn check_known_name<'a>(
    what: &str,
    name: &str,
    command: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> Result<(), CommandError> {
    if known.clone().any(|known| known == name) {
        return Ok(());
    }
    let meant = nearest(name, known)
        .map_or_else(|| format!("`encspec {command}` lists them"), |meant| format!("did you mean `{meant}`?"));
    Err(CommandError::usage(format!("unknown {what} `{name}`; {meant}")))
}

impl PreparedRun {
    /// The devices under test.
    pub fn devices(&self) -> &[DutSpec] {
        &self.options.duts
    }

    /// Runs the request and applies the ledger.
    pub fn run(&self, manuals: &[Manual], progress: engine::RunProgress<'_>) -> Result<RunResult, CommandError> {
        let is_live = |device: &DutSpec| device.live().is_some_and(|live| !live.is_virtual());
        let started = self.options.duts.iter().any(is_live).then(|| time_stamp(SystemTime::now()));
        let run = engine::run(manuals, &self.options, progress);
        let mut result = run.map_err(|error| CommandError::bench(error.to_string()))?;
        let RunResult { accept_flaky, fail_on_not_applicable, filters, .. } = self.settings.clone();
        result = RunResult { accept_flaky, fail_on_not_applicable, filters, ..result };
        result.origin.commit = super::commit().map(str::to_owned);
        result.origin.host = started.is_some().then(host).flatten();
        result.origin.started = started;
        ledger::apply(&self.ledger, &mut result, Date::of(SystemTime::now()));
        Ok(result)
    }
}

pub(super) fn run(args: &RunArgs) -> CommandResult {
    // `--bug` and `--ledger` may name any manual.
    let names_all = !args.bug.is_empty() || args.device.is_some() || args.ledger.is_some();
    let (manuals, described) = match described(args)? {
        Some((manual, dut)) => (vec![manual], Some(dut)),
        None if names_all => (args.suites.load()?, None),
        None => (args.suites.load_for(&args.dut)?, None),
    };
    let request = RunRequest {
        duts: args.dut.clone(),
        device: args.device.clone(),
        bugs: args.bug.clone(),
        variations: args.vary.clone(),
        persona: args.persona.clone(),
        filter: args.filter.clone(),
        gate_must: args.gate == FailureGate::Must,
        ledger: args.ledger.clone(),
        evidence: args.evidence.clone().filter(|_| !args.no_evidence),
        record: args.record.clone(),
        threads: args.threads,
        lock_wait: Duration::from_secs(args.lock_wait),
        stall_repeats: args.stall_repeats,
        part: args.part,
        long: args.long,
        fail_fast: args.fail_fast,
        retries: args.retries,
        accept_flaky: args.accept_flaky,
        fail_on_not_applicable: args.fail_on == Some(FailOn::NotApplicable),
        suites: args.suites.clone(),
        described,
    };
    // A misspelt folder is an error before a live device is touched.
    check_folders(&args.report)?;
    let ready = request.ready(&manuals)?;
    let files = open_all(&args.report)?;
    let bar = if args.quiet { ProgressBar::hidden() } else { progress_bar() };
    let result = ready.run(&manuals, &|device, done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
        bar.set_message(device.to_owned());
    });
    bar.finish_and_clear();
    let mut result = result?;
    result.repeat = options_to_repeat(&args.suites);
    result.min_pass = args.min_pass;
    result.origin.operator = args.operator.clone();
    complete(&mut result, ready.devices(), &args.suites)?;
    write_all(&args.report, files, &result, &manuals)?;
    if let Some(folder) = args.evidence.as_deref().filter(|_| !args.no_evidence) {
        keep_last_run(folder, &result);
    }
    if !uses_standard_output(&args.report) {
        show(&report::console(
            &result,
            report::ConsoleOptions { colour: colours(args.color), verbose: args.verbose, quiet: args.quiet },
        ));
    }
    Ok(report::status(&result))
}

/// Completes what a report says of the suites, the benches and the evidence.
fn complete(result: &mut RunResult, devices: &[DutSpec], suites: &Suites) -> Result<(), CommandError> {
    let sources = suites.sources()?;
    let mut names: Vec<&str> = vec!["common"];
    for run in &mut result.runs {
        let device = devices.iter().find(|device| device.to_string() == run.dut.spec);
        run.dut.details.extend(device.map(details).unwrap_or_default());
        for case in &mut run.cases {
            let evidence = case.evidence.as_ref().and_then(|file| sha256_of_file(Path::new(file)).ok());
            case.evidence_sha256 = evidence;
        }
    }
    for run in &result.runs {
        if !names.contains(&run.dut.device.as_str()) {
            names.push(&run.dut.device);
        }
    }
    result.origin.suites = names.into_iter().map(|name| (name.to_owned(), sha256_of_suite(&sources, name))).collect();
    Ok(())
}

/// What the bench says of a live device: addresses, the vendor's descriptions with their hashes, what the stand can do, consents.
fn details(device: &DutSpec) -> Vec<(String, String)> {
    let Some(live) = device.live() else { return Vec::new() };
    let (bench, found) = (live.bench(), live.found());
    let mut details: Vec<(&str, String)> = vec![("link", bench.link.to_string())];
    if !found.mac.is_empty() {
        details.push(("MAC address", found.mac.clone()));
    }
    details.extend(found.station.map(|station| ("station address", station.to_string())));
    for (kind, path) in &bench.descriptions {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let hash = sha256_of_file(path).unwrap_or_else(|error| error.to_string());
        details.push((kind.title(), format!("{name}, SHA-256 {hash}")));
    }
    details.push(("stand", bench.stand.abilities().join(", ")));
    details.push(("consents", bench.consent.words().join(", ")));
    let shown =
        |(name, value): (&str, String)| (name.to_owned(), if value.is_empty() { "none".to_owned() } else { value });
    details.into_iter().map(shown).collect()
}

/// The suite and the reference device of `--dut model:MANUAL/VARIANT --device none --gsdml FILE`.
fn described(args: &RunArgs) -> Result<Option<(Manual, DutSpec)>, CommandError> {
    let Some(path) = &args.gsdml else { return Ok(None) };
    let model = match args.dut.as_slice() {
        [only] if args.device.as_deref() == Some("none") => only.strip_prefix("model:"),
        _ => None,
    };
    let model = model.ok_or_else(|| {
        CommandError::usage("`--gsdml` goes with `--device none` and one `--dut model:MANUAL/VARIANT`")
    })?;
    let deviations = [args.bug.as_slice(), &args.vary].concat();
    GsdmlEncoder::open(path)?.of_model(args.suites.sources()?, model, deviations).map(Some)
}

/// Writes what was not green beside the captures, for `--failed`. The folder is not created for it.
fn keep_last_run(folder: &Path, result: &RunResult) {
    if folder.is_dir()
        && let Err(error) = fs::write(folder.join(LAST_RUN), last_run(result))
    {
        super::print_message(&format!("--failed will not know this run: {}: {error}", folder.join(LAST_RUN).display()));
    }
}

/// The options that the command line for reproducing a failure must repeat.
fn options_to_repeat(suites: &Suites) -> Vec<String> {
    suites.folders.iter().flat_map(|folder| ["--suites".to_owned(), folder.display().to_string()]).collect()
}

/// A progress bar on standard error, if that is a terminal.
fn progress_bar() -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style =
        ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(0).with_style(style)
}
