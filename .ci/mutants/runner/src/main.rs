//! Runs every suite against reference devices with one change each.
//!
//! `mutant-runner reach SUITES HIGHEST FILE` notes in a file which changes each trial reaches: a line for each trial, its microseconds
//! and the numbers; a `=` before one says that the change would make no difference there. `mutant-runner try SUITES FILE` reads numbers
//! of changes from standard input, and writes a line for each: number, outcome, and the case that noticed it.

use engine::{BenchError, DutKind, DutSpec, RunOptions, TrialOutcome, run_trial};
use mutant_switch::Reach;
use results::verdict::Verdict;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use suite::model::{Manual, SuiteVariant, Trial};
use suite_yaml::Sources;

/// A trial that takes longer does not end. The longest takes a tenth of a second.
const PATIENCE: Duration = Duration::from_secs(10);

struct Job<'a> {
    manual: &'a Manual,
    variant: &'a SuiteVariant,
    trial: &'a Trial,
}

/// What a trial says of a changed device.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    Survived,
    Inconclusive,
    Crashed,
    Killed,
}

impl Outcome {
    fn word(self) -> &'static str {
        match self {
            Outcome::Survived => "survived",
            Outcome::Inconclusive => "inconclusive",
            Outcome::Crashed => "crashed",
            Outcome::Killed => "killed",
        }
    }
}

impl Job<'_> {
    fn outcome(&self) -> Result<TrialOutcome, BenchError> {
        let dut = DutSpec {
            manual: self.manual.device.name.clone(),
            variant: self.variant.name.clone(),
            kind: DutKind::Model { deviations: Vec::new() },
        };
        run_trial(self.manual, self.variant, &dut, self.trial, &RunOptions::default())
    }

    fn run(&self) -> Outcome {
        match catch_unwind(AssertUnwindSafe(|| self.outcome())) {
            Err(_) => Outcome::Crashed,
            Ok(Err(_)) => Outcome::Inconclusive,
            Ok(Ok(outcome)) => match outcome.case.verdict {
                Verdict::Fail => Outcome::Killed,
                _ if outcome.rules.iter().any(|rule| rule.broken.is_some()) => Outcome::Killed,
                Verdict::Pass => Outcome::Survived,
                _ => Outcome::Inconclusive,
            },
        }
    }

    /// What is the same on all variants.
    fn case(&self) -> (&str, &str) {
        (&self.manual.device.name, &self.trial.id)
    }

    fn id(&self) -> String {
        format!("{}/{}", self.variant.name, self.trial.id)
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [mode, suites, rest @ ..] = arguments.as_slice() else { panic!("usage: mutant-runner reach|try SUITES ...") };
    let sources = Sources::folder(Path::new(suites)).unwrap_or_else(|errors| panic!("{errors}"));
    let manuals = suite_yaml::load(&sources, None).unwrap_or_else(|errors| panic!("{errors}"));
    let jobs: Vec<Job<'_>> = manuals
        .iter()
        .flat_map(|manual| manual.variants.iter().map(move |variant| (manual, variant)))
        .flat_map(|(manual, variant)| variant.trials.iter().map(move |trial| Job { manual, variant, trial }))
        .collect();
    match (mode.as_str(), rest) {
        ("reach", [highest, file]) => {
            let highest = highest.parse().expect("a number");
            std::fs::write(file, reach(&jobs, highest)).expect("a file that can be written");
        }
        ("try", [file, how @ ..]) => {
            let reach = std::fs::read_to_string(file).expect("the file that `reach` has made");
            try_each(&jobs, &reach, how == ["quick"]);
        }
        ("show", [number, filter]) => show(&jobs, number.parse().expect("a number"), filter),
        _ => {
            panic!("usage: mutant-runner reach SUITES HIGHEST FILE, try SUITES FILE [quick], show SUITES NUMBER FILTER")
        }
    }
}

/// A line for each trial: its microseconds, and the changes that it reaches, with a `=` those that would make no difference.
fn reach(jobs: &[Job<'_>], highest: u32) -> String {
    let mut lines = String::new();
    for job in jobs {
        let begin = Instant::now();
        let mut outcome = Outcome::Survived;
        let reached = mutant_switch::reached(highest, || outcome = job.run());
        assert!(outcome == Outcome::Survived, "{} does not pass without a change", job.id());
        lines += &begin.elapsed().as_micros().to_string();
        for (number, reach) in (0_u32..).zip(reached) {
            match reach {
                Reach::Not => {}
                Reach::Same => lines += &format!(" ={number}"),
                Reach::Differs => lines += &format!(" {number}"),
            }
        }
        lines.push('\n');
    }
    lines
}

/// Tries the changes that standard input names; when it is quick, each trial on one variant only.
fn try_each(jobs: &[Job<'_>], reach: &str, is_quick: bool) {
    std::panic::set_hook(Box::new(|_| {}));
    let mut reaching: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let mut breadth = Vec::new();
    for (index, line) in reach.lines().enumerate() {
        let numbers = line.split(' ').skip(1).filter_map(|number| number.parse().ok());
        breadth.push(numbers.map(|number| reaching.entry(number).or_default().push(index)).count());
    }
    for indices in reaching.values_mut() {
        // What reaches the least is most about a change. The same trial on another variant says little more, so it comes later.
        indices.sort_by_key(|index| breadth[*index]);
        let mut seen = BTreeSet::new();
        let (first, again): (Vec<usize>, Vec<usize>) =
            indices.iter().partition(|index| seen.insert(jobs[**index].case()));
        *indices = first;
        if !is_quick {
            indices.extend(again);
        }
    }
    let watch = Watch::start();
    for line in std::io::stdin().lock().lines() {
        let Some(number) = line.ok().and_then(|line| line.parse().ok()) else { return };
        let (outcome, case) = match reaching.get(&number) {
            // Where it is reached it makes no difference.
            None => ("survived", String::new()),
            Some(reaching) => {
                let (outcome, case) = worst(number, reaching.iter().filter_map(|index| jobs.get(*index)), &watch);
                (outcome.word(), case)
            }
        };
        if writeln!(std::io::stdout(), "{number} {outcome} {case}").is_err() {
            return;
        }
    }
}

/// Prints what the trials whose names have the text `filter` say of a change.
fn show(jobs: &[Job<'_>], number: u32, filter: &str) {
    for job in jobs.iter().filter(|job| job.id().contains(filter)) {
        mutant_switch::set(number);
        let outcome = job.outcome();
        mutant_switch::set(0);
        match outcome {
            Err(why) => println!("{}: {why}", job.id()),
            Ok(outcome) => {
                println!("{}: {}", job.id(), outcome.case.verdict);
                outcome.case.failures.iter().for_each(|failure| println!("    {}", failure.what));
                let broken = outcome.rules.iter().zip(&job.variant.rules).filter(|(result, _)| result.broken.is_some());
                broken.for_each(|(_, rule)| println!("    breaks the rule {}", rule.id));
            }
        }
    }
}

/// The outcome that says most against the changed device, and the trial that had it.
fn worst<'j>(number: u32, jobs: impl Iterator<Item = &'j Job<'j>>, watch: &Watch) -> (Outcome, String) {
    let mut worst = (Outcome::Survived, String::new());
    for job in jobs {
        watch.begin(number);
        mutant_switch::set(number);
        let outcome = job.run();
        mutant_switch::set(0);
        watch.end();
        if outcome > worst.0 {
            worst = (outcome, job.id());
        }
        if outcome == Outcome::Killed {
            break;
        }
    }
    worst
}

/// Ends the process when a trial does not end.
struct Watch {
    /// The number of the change, and the milliseconds at which the trial began, since the start and from 1; 0 between trials.
    state: &'static (Instant, AtomicU64, AtomicU64),
}

impl Watch {
    fn start() -> Watch {
        let state = Box::leak(Box::new((Instant::now(), AtomicU64::new(0), AtomicU64::new(0))));
        let state: &'static (Instant, AtomicU64, AtomicU64) = state;
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(Duration::from_millis(500));
                let begin = state.2.load(Ordering::Relaxed);
                if begin != 0 && now(&state.0) > begin + u64::try_from(PATIENCE.as_millis()).unwrap_or(u64::MAX) {
                    println!("{} hung", state.1.load(Ordering::Relaxed));
                    std::process::exit(1);
                }
            }
        });
        Watch { state }
    }

    fn begin(&self, number: u32) {
        self.state.1.store(number.into(), Ordering::Relaxed);
        self.state.2.store(now(&self.state.0), Ordering::Relaxed);
    }

    fn end(&self) {
        self.state.2.store(0, Ordering::Relaxed);
    }
}

/// Milliseconds since the start, from 1.
fn now(start: &Instant) -> u64 {
    u64::try_from(start.elapsed().as_millis()).unwrap_or(u64::MAX) + 1
}
