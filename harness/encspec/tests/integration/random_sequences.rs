//! No rule breaks in random sequences of steps on conforming devices with random permitted variations.

use crate::built_in::{self, manuals};
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
const PARTS: u64 = 25;

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
        run_trial(&self.manual, variant, &dut, self.trial(variant, seed), &RunOptions::default())
            .expect("a model can be run")
    }

    fn trial<'a>(&self, variant: &'a SuiteVariant, seed: u64) -> &'a Trial {
        let id = format!("{TOPIC}/{}", case_id(seed));
        variant.trials.iter().find(|trial| trial.id == id).expect("the sequence was loaded")
    }

    /// The broken rules, each with what broke it, and how to repeat it.
    fn report(&self, variant: &SuiteVariant, seed: u64, deviations: &[&str], outcome: &TrialOutcome) -> Option<String> {
        let mut broken = String::new();
        for (rule, result) in variant.rules.iter().zip(&outcome.rules) {
            let Some((_, failure)) = &result.broken else { continue };
            let manual = &self.manual.device.name;
            let _ = writeln!(broken, "{manual}/{} seed {seed}: the rule {} is broken", variant.name, rule.id);
            let _ = writeln!(broken, "  {} ({})", failure.what, rule.why);
            for part in failure.parts.iter().filter(|part| !part.held) {
                let _ = writeln!(broken, "  {}: expected {}, observed {}", part.text, part.expected, part.observed);
            }
            failure.trace.iter().for_each(|line| broken.push_str(&format!("  {line}\n")));
        }
        if broken.is_empty() {
            return None;
        }
        let _ = writeln!(broken, "with the variations {}", deviations.join(", "));
        Some(broken + &topic(&self.manual, &[(seed, self.source.sequence(seed))]))
    }
}

#[test]
fn no_rule_breaks_in_random_sequences() {
    let sample = DailySample::one_of(PARTS);
    let seeds = sample.items(0..SEQUENCES);
    let decided: Mutex<BTreeMap<String, usize>> = Mutex::default();
    let mut broken = Vec::new();
    for of in manuals() {
        let sequences = Sequences::new(of, &seeds);
        let variants = sequences.manual.variants.iter();
        let jobs: Vec<_> = variants.flat_map(|variant| seeds.iter().map(move |seed| (variant, *seed))).collect();
        broken.extend(every(&jobs, |(variant, seed)| {
            let deviations = combination(of, *seed);
            let outcome = sequences.run(variant, *seed, &deviations);
            let mut decided = decided.lock().expect("no thread panicked");
            for (rule, result) in variant.rules.iter().zip(&outcome.rules) {
                let count = decided.entry(format!("{}/{} {}", of.device.name, variant.name, rule.id)).or_default();
                *count += usize::from(result.decided.premises > 0);
            }
            if let Some(reason) = &outcome.case.reason {
                *decided.entry(format!("{} end {:?} {}", of.device.name, outcome.case.verdict, reason.chars().take(110).collect::<String>())).or_default() += 1;
            }
            drop(decided);
            sequences.report(variant, *seed, &deviations, &outcome)
        }));
    }
    let decided = decided.into_inner().expect("no thread panicked");
    for (rule, count) in decided {
        println!("{count:5} {rule}");
    }
    assert!(broken.is_empty(), "{sample}: rules break on conforming devices:\n{}", broken.concat());
}

#[test]
#[ignore = "writes the sequences"]
fn write_topics() {
    let folder = std::env::var("TOPICS").unwrap();
    for of in manuals() {
        let source = SequenceSource::new(of);
        let drawn: Vec<_> = (0..SEQUENCES).map(|seed| (seed, source.sequence(seed))).collect();
        std::fs::write(format!("{folder}/{}.yaml", of.device.name), topic(of, &drawn)).unwrap();
        let all: String = (0..SEQUENCES).map(|seed| format!("{seed} {}\n", combination(of, seed).join(" "))).collect();
        std::fs::write(format!("{folder}/{}.vary", of.device.name), all).unwrap();
    }
}
