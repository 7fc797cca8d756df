//! Runs every suite against reference devices with one change each. Reads the numbers of changes from standard input, and writes a
//! line for each: number, outcome, and the case that noticed it.

use engine::{DutKind, DutSpec, RunOptions, run_trial};
use results::verdict::Verdict;
use std::collections::BTreeMap;
use std::io::{BufRead, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use suite::model::{Manual, SuiteVariant, Trial};

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
    fn run(&self) -> Outcome {
        let dut = DutSpec {
            manual: self.manual.device.name.clone(),
            variant: self.variant.name.clone(),
            kind: DutKind::Model { deviations: Vec::new() },
        };
        let run = || run_trial(self.manual, self.variant, &dut, self.trial, &RunOptions::default());
        match catch_unwind(AssertUnwindSafe(run)) {
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

    fn id(&self) -> String {
        format!("{}/{}", self.variant.name, self.trial.id)
    }
}

fn main() {
    let manuals = suite_yaml::load(&suites::sources(), None).unwrap_or_else(|errors| panic!("{errors}"));
    let jobs: Vec<Job<'_>> = manuals
        .iter()
        .flat_map(|manual| manual.variants.iter().map(move |variant| (manual, variant)))
        .flat_map(|(manual, variant)| variant.trials.iter().map(move |trial| Job { manual, variant, trial }))
        .collect();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |text: &String| text.parse::<u32>().ok();
    let Some(highest) = arguments.first().and_then(number) else { panic!("usage: mutant-runner HIGHEST") };
    std::panic::set_hook(Box::new(|_| {}));
    let mut reaching: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (index, job) in jobs.iter().enumerate() {
        let reached = mutant_switch::reached(highest, || {
            job.run();
        });
        reached.into_iter().for_each(|number| reaching.entry(number).or_default().push(index));
    }
    let mut out = std::io::stdout().lock();
    let mut write = |line: String| {
        let written = writeln!(out, "{line}").and_then(|()| out.flush());
        written.is_ok()
    };
    write("ready".to_owned());
    for line in std::io::stdin().lock().lines() {
        let Some(number) = line.ok().as_ref().and_then(number) else { return };
        let line = match reaching.get(&number) {
            None => format!("{number} unreached"),
            Some(reaching) => {
                let (outcome, case) = worst(number, reaching.iter().filter_map(|index| jobs.get(*index)));
                format!("{number} {} {case}", outcome.word())
            }
        };
        if !write(line) {
            return;
        }
    }
}

/// The outcome that says most against the changed device, and the trial that had it.
fn worst<'j>(number: u32, jobs: impl Iterator<Item = &'j Job<'j>>) -> (Outcome, String) {
    let mut worst = (Outcome::Survived, String::new());
    for job in jobs {
        mutant_switch::set(number);
        let outcome = job.run();
        mutant_switch::set(0);
        if outcome > worst.0 {
            worst = (outcome, job.id());
        }
        if outcome == Outcome::Killed {
            break;
        }
    }
    worst
}
