//! `encspec explore`: runs sequences that no case names on a device and on its reference device, and writes each difference as a case.

use super::live::{self, LiveTarget};
use super::reports::{ReportRequest, check_folders, open_all, parse_report_request, uses_standard_output, write_all};
use super::{CommandError, CommandResult, Suites, print_message, show};
use ::live::lock::Lock;
use clap::Args;
use engine::{DutSpec, RestoreOutcome, SequenceLimits, with_claimed_device};
use explore::SequenceStep;
use explore::bench::{CannotExplore, ExploreBench};
use explore::campaign::{Campaign, CampaignEvent, CampaignOptions, CampaignResult, Finding};
use explore::learn::LearnedReference;
use explore::live_campaign::{IgnoredDifference, learn_baseline};
use plain_text::count;
use report::ExitStatus;
use results::bench_file::LinkSpec;
use results::outcome::{CaseFailure, CaseKind, CaseResult, DeviceRun, Dut, FailureCause, RunResult};
use results::verdict::Verdict;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;
use suite::Location;
use suite::model::{Level, Manual};
use suite_yaml::Sources;

/// How many sequences are run where neither `--sequences` nor `--time` is given.
const USUAL: u64 = 1000;
/// How long to wait for a live device that another process uses.
const LOCK_WAIT: Duration = Duration::from_secs(10);
/// The most reasons on the terminal.
const MOST_REASONS: usize = 5;
/// The most names of a list on the terminal.
const MOST_LISTED: usize = 12;

const EXAMPLE: &str = "Example: encspec explore --dut model:MANUAL/VARIANT --bug NAME --sequences 50 --out found";

/// Arguments of `encspec explore`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub(super) struct ExploreArgs {
    /// Device under test: model:MANUAL/VARIANT, a reference device; app:COMMAND, a program that is the application of a device; or the
    /// bench file of a live device or of a program
    #[arg(long, value_name = "DUT")]
    dut: String,
    /// Manual and variant that a device or program claims to be, where --dut does not name them
    #[arg(long, value_name = "MANUAL/VARIANT")]
    device: Option<String>,
    /// Enable a bug of the reference device; may be repeated; `encspec bugs` lists them
    #[arg(long, value_name = "NAME")]
    bug: Vec<String>,
    /// Enable a variation that the manual permits, or with random:SEED a random combination of them; may be repeated
    #[arg(long, value_name = "NAME")]
    vary: Vec<String>,
    /// Seed of the sequences; the same seed and number of sequences give the same result
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Number of sequences [default: 1000, unless --time is given]
    #[arg(long, value_name = "N")]
    sequences: Option<u64>,
    /// Stop after this many seconds; how many sequences that is depends on this host
    #[arg(long, value_name = "SECONDS")]
    time: Option<u64>,
    /// Prefer sequences with these words, for instance preset or P65001; may be repeated
    #[arg(long, value_name = "WORD")]
    focus: Vec<String>,
    /// Folder with the seeds that reached something new; read at the begin, written at the end
    #[arg(long, value_name = "DIR")]
    corpus: Option<PathBuf>,
    /// Write the cases and their captures to this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How often the supply of a live device may be switched off; how often its memory may be written, its bench file says
    #[arg(long, value_name = "N", default_value_t = 10)]
    power_cycles: u32,
    /// Stop after this many different findings
    #[arg(long, value_name = "N", default_value_t = 20)]
    findings: usize,
    /// Write a report; FORMAT is console, html, json, junit, tap or text, FILE - is standard output; may be repeated
    #[arg(long, value_name = "FORMAT=FILE", value_parser = parse_report_request)]
    report: Vec<ReportRequest>,
    #[command(flatten)]
    suites: Suites,
}

pub(super) fn explore(args: &ExploreArgs) -> CommandResult {
    let manuals = args.suites.load()?;
    let deviations = [args.bug.as_slice(), &args.vary].concat();
    let devices = super::dut::devices(std::slice::from_ref(&args.dut), args.device.as_deref(), &deviations, &manuals)
        .map_err(CommandError::usage)?;
    check_folders(&args.report)?;
    if let Some(folder) = &args.out {
        fs::create_dir_all(folder)
            .map_err(|error| CommandError::usage(format!("{} cannot be created: {error}", folder.display())))?;
    }
    let device = match (devices.live.as_slice(), devices.here.as_slice()) {
        ([target], _) => outside(target, &manuals, args)?,
        (_, [spec]) => ExploredDevice {
            spec: spec.clone(),
            sources: args.suites.sources()?,
            reference: KnownReference::Compared,
            _lock: None,
        },
        (_, all) => {
            let name = args.dut.trim_start_matches("model:");
            return Err(match all.first() {
                Some(first) => CommandError::usage(format!(
                    "`{name}` has several variants; name one, for instance `model:{name}/{}`",
                    first.variant
                )),
                None => {
                    CommandError::usage(format!("`{}` is no reference device; write model:MANUAL/VARIANT", args.dut))
                }
            });
        }
    };
    let spec = &device.spec;
    let manual = match spec.live() {
        Some(live) => live.manual(),
        None => {
            let manual = manuals.iter().find(|of| of.device.name == spec.manual);
            let manual = manual.ok_or_else(|| CommandError::usage(format!("there is no suite for {}", spec.manual)))?;
            check_deviations(spec, manual)?;
            manual
        }
    };
    link::interrupt::watch();
    let files = open_all(&args.report)?;
    let (explored, restored) = match spec.live().filter(|live| !live.is_virtual()) {
        Some(live) => {
            let limits =
                SequenceLimits { power_cycles: args.power_cycles, memory_writes: live.bench().consent.nvm_write };
            let variant = manual.variants.iter().find(|variant| variant.name == spec.variant);
            let variant = variant
                .ok_or_else(|| CommandError::usage(format!("{} has no variant {}", spec.manual, spec.variant)))?;
            with_claimed_device(manual, variant, spec, limits, || sequences(args, &device, manual))
                .map_err(CommandError::bench)?
        }
        None => (sequences(args, &device, manual), RestoreOutcome::default()),
    };
    restored.left.iter().chain(&restored.remarks).for_each(|text| print_message(text));
    let explored = explored?;
    let result = &explored.result;
    keep_seeds(args.corpus.as_deref(), result)?;
    let run = run_result(spec, explored.cases);
    write_all(&args.report, files, &run, &manuals)?;
    if !uses_standard_output(&args.report) {
        show(&text(args, &device, manual, result, &explored.ignored));
    }
    let is_done = result.is_complete() && result.says_something() && restored.left.is_empty();
    Ok(if is_done && result.findings.is_empty() { ExitStatus::Green } else { ExitStatus::Red })
}

/// What the sequences showed.
struct ExploredSequences {
    result: CampaignResult,
    cases: Vec<CaseResult>,
    /// What a live device does differently before any sequence.
    ignored: Vec<IgnoredDifference>,
}

/// Runs the sequences; writes each finding at once.
fn sequences(args: &ExploreArgs, device: &ExploredDevice, manual: &Manual) -> Result<ExploredSequences, CommandError> {
    let spec = &device.spec;
    let is_live = spec.live().is_some_and(|live| !live.is_virtual());
    let mut bench = ExploreBench::new(&device.sources, manual, &spec.variant).map_err(stop)?;
    bench = bench.until(link::interrupt::requested);
    let is_compared = device.reference == KnownReference::Compared;
    let mut reference = is_compared.then(|| LearnedReference::new(spec)).transpose().map_err(stop)?;
    let mut ignored = Vec::new();
    if is_live {
        bench = bench.live();
        if let Some(reference) = &mut reference {
            ignored = learn_baseline(&mut bench, spec, reference).map_err(stop)?;
        }
    }
    let options = CampaignOptions {
        seed: args.seed,
        sequences: args.sequences.or(args.time.is_none().then_some(USUAL)),
        time: args.time.map(Duration::from_secs),
        focus: args.focus.clone(),
        kept: kept_seeds(args.corpus.as_deref())?,
        most_findings: args.findings,
    };
    let mut written = Ok(());
    let mut events = |event: CampaignEvent<'_>| {
        let done = match event {
            CampaignEvent::Confirmed { number, name, steps } => {
                let text =
                    format!("# {name} differs; these steps are not shortened yet.\n{}", bench.topic(&[steps.to_vec()]));
                write_finding(args, number, &text)
            }
            CampaignEvent::Found { number, finding } => {
                write_finding(args, number, &finding_file(args, &bench, spec, finding))
            }
        };
        if written.is_ok() {
            written = done;
        }
    };
    let result = Campaign::new(&bench, spec, reference, &options).run(&mut events).map_err(stop)?;
    written?;
    if let Some(error) = result.invalid.first() {
        return Err(CommandError::usage(format!(
            "{}; the first:\n{error}",
            count(result.invalid.len(), "sequence does not load", "sequences do not load")
        )));
    }
    let mut cases = Vec::new();
    for (index, finding) in result.findings.iter().enumerate() {
        cases.push(case_result(args, &bench, spec, finding, index + 1)?);
    }
    Ok(ExploredSequences { result, cases, ignored })
}

/// Writes the file of a finding; it is there when this returns, whatever happens to the process.
fn write_finding(args: &ExploreArgs, number: usize, text: &str) -> Result<(), CommandError> {
    let Some(folder) = &args.out else { return Ok(()) };
    let path = folder.join(format!("explored-{number}.yaml"));
    let part = folder.join(format!("explored-{number}.part"));
    let write = || -> std::io::Result<()> {
        let mut file = fs::File::create(&part)?;
        file.write_all(text.as_bytes())?;
        file.sync_data()?;
        fs::rename(&part, &path)
    };
    write().map_err(|error| CommandError::bench(format!("{} cannot be written: {error}", path.display())))
}

/// The case of a finding, or its steps, with the line that finds it again.
fn finding_file(args: &ExploreArgs, bench: &ExploreBench<'_>, spec: &DutSpec, finding: &Finding) -> String {
    let steps = std::slice::from_ref(&finding.steps);
    let covered = finding.rules.iter().flat_map(|rule| &rule.covers).next();
    let text = match (&finding.case, covered) {
        (Some(case), _) => case.yaml(),
        (None, Some(requirement)) => bench.topic_covering(requirement, steps),
        (None, None) => bench.topic(steps),
    };
    format!("# {}\n{text}", repeat(args, spec, finding))
}

/// Whether there is a reference device that does the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum KnownReference {
    /// There is, and the device is compared with it.
    Compared,
    /// There is, but what the device has stored before a sequence is not known.
    StateUnknown,
    None,
}

/// The device that is explored.
struct ExploredDevice {
    spec: DutSpec,
    /// The suite of the device.
    sources: Sources,
    reference: KnownReference,
    /// Held until the end.
    _lock: Option<Lock>,
}

/// Opens a live device, or starts a program that is the application of one.
fn outside(target: &LiveTarget, manuals: &[Manual], args: &ExploreArgs) -> Result<ExploredDevice, CommandError> {
    let bench = target.bench(manuals)?;
    let is_program = matches!(bench.link, LinkSpec::App(_));
    let lock = (!is_program).then(|| live::lock(&bench, LOCK_WAIT)).transpose()?;
    // Nothing but its description says what such a device does.
    let is_unknown = bench.claim.variant.is_empty();
    let spec = live::open(bench.clone(), &args.suites, false, None)?;
    let stand = spec.live().map(|live| &live.bench().stand);
    let is_renewed = stand.is_some_and(|of| {
        of.serves("renew") && of.position() == Some(0.0) && !of.ask.iter().any(|name| name == "renew")
    });
    let reference = match () {
        () if is_unknown || deviations::subject(&spec.manual).is_err() => KnownReference::None,
        () if is_program || is_renewed => KnownReference::Compared,
        () => KnownReference::StateUnknown,
    };
    Ok(ExploredDevice { sources: live::sources(&bench, &args.suites, &spec)?, reference, spec, _lock: lock })
}

fn stop(error: CannotExplore) -> CommandError {
    CommandError::bench(error.to_string())
}

fn check_deviations(spec: &DutSpec, manual: &Manual) -> Result<(), CommandError> {
    let subject = deviations::subject(&spec.manual).map_err(|error| CommandError::usage(error.to_string()))?;
    for name in spec.deviations() {
        let is_bug = manual.bugs.iter().any(|bug| bug.name == *name);
        if !is_bug && subject.variations_of(name).is_none() {
            let known = manual.bugs.iter().map(|bug| bug.name.as_str()).chain(subject.permitted().map(|of| of.name));
            return Err(CommandError::usage(super::dut::suggest("bug or variation", name, known)));
        }
    }
    Ok(())
}

/// The line that finds it again.
fn repeat(args: &ExploreArgs, spec: &DutSpec, finding: &Finding) -> String {
    let option =
        |name: &str, values: Vec<String>| values.iter().map(|value| format!(" --{name} {value}")).collect::<String>();
    format!(
        "encspec explore {}{}{}{} --seed {} --sequences {}",
        spec.option(),
        option("bug", spec.bugs()),
        option("vary", args.vary.clone()),
        option("focus", args.focus.clone()),
        args.seed,
        finding.sequence + 1
    )
}

/// The result of the written case on the device; without a case, one that says what differs.
fn case_result(
    args: &ExploreArgs,
    bench: &ExploreBench<'_>,
    spec: &DutSpec,
    finding: &Finding,
    number: usize,
) -> Result<CaseResult, CommandError> {
    let line = repeat(args, spec, finding);
    if let Some(case) = &finding.case {
        let outcome = bench.judge(case, spec, args.out.as_deref()).map_err(stop)?;
        let mut result = outcome.case;
        if let Some(failure) = result.failures.first_mut() {
            failure.next = format!("Find it again: {line}");
        }
        return Ok(result);
    }
    let what = if finding.kind.is_error() {
        finding.device.clone()
    } else {
        format!("{}: the reference device {}, this device {}.", finding.name, finding.reference, finding.device)
    };
    let at = Location { file: std::sync::Arc::new(PathBuf::new()), line: 1, column: 1 };
    let failure = CaseFailure {
        blame: FailureCause::Device,
        what: what.clone(),
        step: String::new(),
        at: at.clone(),
        requirements: Vec::new(),
        parts: Vec::new(),
        place: None,
        trace: finding.steps.iter().map(|step| step.action.yaml()).collect(),
        next: format!("Find it again: {line}"),
        before_test: false,
    };
    let id = format!("{}/explored-{number}", spec.manual);
    let why = format!("{} is as on the reference device.", finding.name);
    let verdict = if finding.is_stable { Verdict::Fail } else { Verdict::Inconclusive };
    let result = CaseResult::new(id, CaseKind::Trial, why, (verdict, Level::Must), at);
    Ok(CaseResult { reason: Some(what), failures: vec![failure], ..result })
}

fn run_result(spec: &DutSpec, cases: Vec<CaseResult>) -> RunResult {
    let run = DeviceRun {
        dut: Dut {
            kind: spec.kind_word().to_owned(),
            spec: spec.to_string(),
            device: spec.manual.clone(),
            variant: spec.variant.clone(),
            identity: "explored".to_owned(),
            firmware: None,
            details: Vec::new(),
        },
        cases,
        requirements: Vec::new(),
        filtered: true,
        persona: None,
        bugs: spec.bugs(),
        variations: spec.variations(),
        bug_notes: spec.bug_notes(),
        findings: Vec::new(),
        causes: Vec::new(),
        bus: None,
    };
    RunResult { runs: vec![run], ..RunResult::default() }
}

fn text(
    args: &ExploreArgs,
    explored: &ExploredDevice,
    manual: &Manual,
    result: &CampaignResult,
    ignored: &[IgnoredDifference],
) -> String {
    let (spec, has_reference) = (&explored.spec, explored.reference == KnownReference::Compared);
    let mut out = String::new();
    let _ = writeln!(
        out,
        "{spec}: {}, {} frames, seed {}",
        count(result.sequences as usize, "sequence", "sequences"),
        result.frames,
        args.seed
    );
    if result.interrupted {
        let _ = writeln!(out, "  interrupted; a difference that was still looked into is not listed");
    }
    if result.spoilt > 0 {
        let which = count(result.spoilt as usize, "sequence says", "sequences say");
        let _ = writeln!(out, "  {which} nothing: the bench does not permit it, or this host or the line was late");
        let mut reasons: Vec<&(String, u64)> = result.spoilt_by.values().collect();
        reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        for (why, count) in reasons.into_iter().take(MOST_REASONS) {
            let times = plain_text::count(*count as usize, "time", "times");
            let _ = writeln!(out, "    {times}: {why}");
        }
    }
    if let Some(why) = &result.ended {
        let _ = writeln!(out, "  ended: {why}");
    }
    if explored.reference == KnownReference::StateUnknown {
        let _ = writeln!(
            out,
            "  judged by rules only: for a comparison the stand has to serve `renew` and place the shaft exactly"
        );
    }
    for of in ignored {
        let _ = writeln!(
            out,
            "  not compared, since it differs before any sequence: {} (reference device {}, this device {})",
            of.name, of.reference, of.device
        );
    }
    for (name, count) in &result.unconfirmed {
        let times = plain_text::count(*count as usize, "time", "times");
        let _ = writeln!(out, "  {name} differed {times}, but did not do so again, or other times explain it");
    }
    for name in &result.learned {
        let _ = writeln!(out, "  the device has the permitted variation {name}");
    }
    let device = &manual.device;
    let (reached, values) = result.states.values(device);
    let whose = if has_reference { "reference " } else { "" };
    let _ = writeln!(
        out,
        "  reached {} states and {} pairs of transitions of the {whose}device, {reached} of {values} values of the inputs",
        result.states.states(),
        result.states.pairs()
    );
    let never = result.states.never(device);
    for of in never.iter().take(MOST_LISTED) {
        let _ = writeln!(out, "    never {}: {}", of.name, of.why);
    }
    if never.len() > MOST_LISTED {
        let _ = writeln!(out, "    and {} more", never.len() - MOST_LISTED);
    }
    if result.findings.is_empty() && result.says_something() {
        let same = "no difference from the reference device";
        let said = if has_reference { same } else { "no rule breaks, and there is no error of the protocol" };
        let _ = writeln!(out, "  {said}");
    }
    for (index, finding) in result.findings.iter().enumerate() {
        finding_text(&mut out, args, spec, finding, index + 1);
    }
    out
}

fn finding_text(out: &mut String, args: &ExploreArgs, spec: &DutSpec, finding: &Finding, number: usize) {
    let _ = writeln!(out, "\n{number}. {} ({})", finding.name, finding.kind.word());
    if !finding.kind.is_error() {
        let _ = writeln!(out, "   reference device: {}", finding.reference);
    }
    let _ = writeln!(out, "   this device:      {}", finding.device);
    if !finding.is_stable {
        let _ = writeln!(out, "   unstable: it did not show in each repetition");
    }
    for rule in &finding.rules {
        let _ = writeln!(out, "   the rule {} breaks ({})", rule.id, rule.covers.join(", "));
    }
    let lines: Vec<String> = match &finding.case {
        Some(case) => {
            let _ = writeln!(
                out,
                "   a case of {}, shortened from {} steps, fails on the device and passes on the reference device; it covers {}:",
                count(case.steps.len(), "step", "steps"),
                finding.before,
                case.covers.join(", ")
            );
            let line = |step: &compare::write_case::CaseLine| {
                std::iter::once(step.verb.clone())
                    .chain(step.modifiers.iter().map(|of| format!("  {of}")))
                    .collect::<Vec<_>>()
            };
            case.steps.iter().flat_map(line).collect()
        }
        None => {
            let what =
                if finding.rules.is_empty() { "no case shows it" } else { "in a case with them the rule breaks" };
            let _ = writeln!(out, "   {what}; the {} are:", count(finding.steps.len(), "step", "steps"));
            finding.steps.iter().map(|step: &SequenceStep| step.action.yaml()).collect()
        }
    };
    for line in lines {
        let _ = writeln!(out, "     {line}");
    }
    let _ = writeln!(out, "   find it again: {}", repeat(args, spec, finding));
}

/// The file of a corpus.
const SEEDS: &str = "seeds.txt";

fn kept_seeds(folder: Option<&Path>) -> Result<Vec<u64>, CommandError> {
    let Some(path) = folder.map(|folder| folder.join(SEEDS)).filter(|path| path.exists()) else {
        return Ok(Vec::new());
    };
    let text = fs::read_to_string(&path);
    let text = text.map_err(|error| CommandError::usage(format!("{} cannot be read: {error}", path.display())))?;
    let seed = |(number, line): (usize, &str)| {
        line.trim()
            .parse()
            .map_err(|_| CommandError::usage(format!("{}:{}: `{line}` is no seed", path.display(), number + 1)))
    };
    text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()).map(seed).collect()
}

fn keep_seeds(folder: Option<&Path>, result: &CampaignResult) -> Result<(), CommandError> {
    let Some(folder) = folder else { return Ok(()) };
    let lines: String = result.kept.iter().map(|seed| format!("{seed}\n")).collect();
    let written = fs::create_dir_all(folder).and_then(|()| fs::write(folder.join(SEEDS), lines));
    written.map_err(|error| CommandError::bench(format!("the corpus {} cannot be written: {error}", folder.display())))
}
