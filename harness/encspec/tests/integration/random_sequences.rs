//! No rule breaks in random sequences of steps on conforming devices with random permitted variations; with bugs that rules catch, rules
//! do break in them.

use crate::built_in::{self, manual, manuals};
use crate::on_two_threads::every;
use crate::variations::combination;
use encspec::engine::{RunOptions, TrialOutcome, run_trial};
use encspec::suite::model::{Manual, SuiteVariant, Trial};
use encspec::suite_yaml::load;
use explore::SequenceSource;
use explore::topic::{TOPIC, case_id, topic};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Mutex;
use testing::DailySample;

/// Random sequences for each reference device, with the seeds from 0.
const SEQUENCES: u64 = 1000;
/// One of so many is run each day.
const PARTS: u64 = 20;
/// Sequences in which a bug of [`FOUND`] has to be found.
const SEQUENCES_OF_A_BUG: u64 = 40;

/// Rules that still break in some sequences of conforming devices; the list may only shrink.
const STILL_BROKEN: [(&str, &[&str]); 0] = [];

/// Rules that no sequence decides, each with the reason.
const NEVER_DECIDED: [(&str, &str, &str); 0] = [];

/// Bugs that a rule finds in the first sequences.
const FOUND: [(&str, &[&str]); 4] = [
    ("lika-xac77-profinet", &["park-never-ends", "preset-never-acknowledged", "sign-of-life-through-zero"]),
    ("kuebler-sendix58xx-profinet", &["parking-ignored", "preset-acknowledge-stays", "acknowledge-answer-stays"]),
    ("sick-afx60-profinet", &["xist2-always-shows-position", "error-clears-itself"]),
    ("sick-a3m60-profibus", &["time-stamp-by-two"]),
];

/// A manual with the cases of random sequences.
struct Sequences {
    manual: Manual,
    source: SequenceSource,
}

impl Sequences {
    fn new(of: &Manual, seeds: &[u64]) -> Sequences {
        let source = SequenceSource::new(of);
        let drawn: Vec<_> = seeds.iter().map(|seed| (*seed, source.sequence(*seed))).collect();
        let name = &of.device.name;
        let sources = suites::sources().with(&format!("{name}/{TOPIC}.yaml"), topic(of, &drawn));
        let mut loaded = load(&sources, Some(name)).unwrap_or_else(|errors| panic!("{errors}"));
        Sequences { manual: loaded.remove(0), source }
    }

    /// Runs the sequence of a seed on the device with these deviations.
    fn run(&self, variant: &SuiteVariant, seed: u64, deviations: &[&str]) -> TrialOutcome {
        let dut = built_in::model(&self.manual, variant, deviations);
        let outcome = run_trial(&self.manual, variant, &dut, trial(variant, seed), &RunOptions::default());
        outcome.expect("a model can be run")
    }

    /// The broken rules, each with what broke it, and how to repeat it.
    fn report(&self, variant: &SuiteVariant, seed: u64, deviations: &[&str], outcome: &TrialOutcome) -> Option<String> {
        let manual = &self.manual.device.name;
        let known = STILL_BROKEN.iter().find(|(of, _)| of == manual).map_or(&[][..], |(_, rules)| *rules);
        let mut broken = String::new();
        for (rule, result) in variant.rules.iter().zip(&outcome.rules) {
            let Some((_, failure)) = result.broken.as_ref().filter(|_| !known.contains(&rule.id.as_str())) else {
                continue;
            };
            let _ = writeln!(broken, "{manual}/{} seed {seed}: the rule {} is broken", variant.name, rule.id);
            let _ = writeln!(broken, "  {} ({})", failure.what, rule.why);
            for part in failure.parts.iter().filter(|part| !part.held) {
                let _ = writeln!(broken, "  {}: expected {}, observed {}", part.text, part.expected, part.observed);
            }
            failure.trace.iter().for_each(|line| {
                let _ = writeln!(broken, "  {line}");
            });
        }
        if broken.is_empty() {
            return None;
        }
        let _ = writeln!(broken, "with the variations {}", deviations.join(", "));
        Some(broken + &topic(&self.manual, &[(seed, self.source.sequence(seed))]))
    }
}

fn trial(variant: &SuiteVariant, seed: u64) -> &Trial {
    let id = format!("{TOPIC}/{}", case_id(seed));
    variant.trials.iter().find(|trial| trial.id == id).expect("the sequence was loaded")
}

#[test]
fn no_rule_breaks_in_random_sequences() {
    let sample = DailySample::one_of(PARTS);
    let seeds = sample.items(0..SEQUENCES);
    // How many sequences decided each rule of each variant.
    let decided: Mutex<BTreeMap<(String, String), usize>> = Mutex::default();
    let mut broken = Vec::new();
    for of in manuals() {
        let sequences = Sequences::new(of, &seeds);
        let variants = sequences.manual.variants.iter();
        let jobs: Vec<_> = variants.flat_map(|variant| seeds.iter().map(move |seed| (variant, *seed))).collect();
        broken.extend(every(&jobs, |(variant, seed)| {
            let deviations = combination(of, *seed);
            let outcome = sequences.run(variant, *seed, &deviations);
            let device = format!("{}/{}", of.device.name, variant.name);
            let mut decided = decided.lock().expect("no thread panicked");
            for (rule, result) in variant.rules.iter().zip(&outcome.rules) {
                let count = decided.entry((device.clone(), rule.id.clone())).or_default();
                *count += usize::from(result.decided.premises > 0);
            }
            drop(decided);
            sequences.report(variant, *seed, &deviations, &outcome)
        }));
    }
    let mut never = String::new();
    for ((device, rule), count) in decided.into_inner().expect("no thread panicked") {
        println!("{count:5} {device} {rule}");
        let excused = NEVER_DECIDED.iter().any(|(of, id, _)| device.starts_with(of) && *id == rule);
        if count == 0 && !excused {
            let _ = writeln!(never, "{device} {rule}");
        }
    }
    assert!(broken.is_empty(), "{sample}: rules break on conforming devices:\n{}", broken.concat());
    // A part of the sequences need not reach everything.
    assert!(sample.part().is_some() || never.is_empty(), "no sequence decides these rules:\n{never}");
}

#[test]
fn rules_find_bugs_in_random_sequences() {
    let seeds: Vec<u64> = (0..SEQUENCES_OF_A_BUG).collect();
    let of_manual = |(name, bugs): &(&str, &[&str])| {
        let sequences = Sequences::new(manual(name), &seeds);
        let missed = every(bugs, |bug| (!finds(&sequences, &seeds, bug)).then(|| format!("{name} --bug {bug}\n")));
        missed.concat()
    };
    let missed: String = FOUND.iter().map(of_manual).collect();
    assert!(missed.is_empty(), "no rule that catches these bugs breaks in {SEQUENCES_OF_A_BUG} sequences:\n{missed}");
}

/// Whether a rule that catches the bug breaks in one of the sequences.
fn finds(sequences: &Sequences, seeds: &[u64], bug: &str) -> bool {
    sequences.manual.variants.iter().any(|variant| {
        seeds.iter().any(|seed| {
            let outcome = sequences.run(variant, *seed, &[bug]);
            let rules = variant.rules.iter().zip(&outcome.rules);
            rules
                .into_iter()
                .any(|(rule, result)| rule.catches.iter().any(|name| name == bug) && result.broken.is_some())
        })
    })
}
