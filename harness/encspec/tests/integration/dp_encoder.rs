//! The suite for any DP encoder on encoders of which it knows only the GSD.

use crate::built_in::manual;
use crate::on_two_threads::every;
use encspec::engine::{DutKind, DutSpec, RunOptions, run_trial};
use encspec::gsd;
use encspec::suite::model::{Manual, SuiteVariant, Trial};
use encspec::suite::needs::{BenchNeed, ClaimedFeature, needs};
use encspec::suite_yaml::{ANY_DP_ENCODER, ANY_SLAVE, load};
use encspec::verdict::Verdict;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::LazyLock;
use testing::DailySample;

const AMT58: &str = "datalogic-amt58-profibus";
/// Random combinations of variations for each variant.
const COMBINATIONS: u64 = 3;
/// Percentage of the bugs of the manual's own suite that the GSD alone has to suffice for.
const CAUGHT: usize = 60;
/// A variation for an encoder whose GSD says so.
const OTHER_GSD: &str = "without-sync-and-freeze";

/// An encoder that is known by its GSD alone.
struct UnknownEncoder {
    variant: String,
    manual: Manual,
    /// The modules that the GSD describes.
    claimed: Vec<&'static str>,
}

impl UnknownEncoder {
    fn of(variant: &str, text: &str) -> UnknownEncoder {
        let read = gsd::read(text).expect("a shipped GSD is read");
        let slave = gsd::describe(&read, Some("Class 2")).expect("the module has data");
        assert!(slave.is_encoder, "{variant}");
        // The reference device is built by the name of its variant.
        let text = slave.text.replace("variants: [plain]", &format!("variants: [{variant}]"));
        let sources = suites::sources().described(ANY_SLAVE, Path::new("encoder.gsd"), text);
        let manuals = load(&sources.joined(ANY_SLAVE, ANY_DP_ENCODER), Some(ANY_SLAVE));
        let manual = manuals.unwrap_or_else(|errors| panic!("{variant}:\n{errors}")).remove(0);
        UnknownEncoder { variant: variant.to_owned(), manual, claimed: slave.claimed }
    }

    fn amt58() -> Vec<UnknownEncoder> {
        let variants = manual(AMT58).variants.iter().map(|variant| {
            let path = format!("{AMT58}/encspec-amt58-{}.gsd", variant.name);
            let text = suites::gsd().iter().find(|(known, _)| *known == path).expect("each variant has a GSD").1;
            UnknownEncoder::of(&variant.name, text)
        });
        variants.collect()
    }

    fn variant(&self) -> &SuiteVariant {
        &self.manual.variants[0]
    }

    /// The trials about encoders for which the GSD has the modules.
    fn trials(&self) -> impl Iterator<Item = &Trial> {
        self.variant().trials.iter().filter(|trial| trial.id.contains("encoder-") && self.has_what_it_needs(trial))
    }

    fn has_what_it_needs(&self, trial: &Trial) -> bool {
        needs(&self.manual, self.variant(), trial).iter().all(|need| match need {
            BenchNeed::Claim(ClaimedFeature::Module(name)) => self.claimed.contains(&name.as_str()),
            _ => true,
        })
    }

    fn device(&self, deviations: &[&str]) -> DutSpec {
        let model = deviations::subject(AMT58).expect("a reference device");
        let deviations = deviations.iter().map(|name| (*name).to_owned()).collect();
        DutSpec {
            manual: ANY_SLAVE.to_owned(),
            variant: self.variant.clone(),
            kind: DutKind::External { model, variant: None, deviations },
        }
    }

    /// The trials and rules that are not green with these deviations.
    fn failed(&self, deviations: &[&str], is_enough: bool) -> Vec<String> {
        let device = self.device(deviations);
        let mut failed = Vec::new();
        for trial in self.trials() {
            let outcome = run_trial(&self.manual, self.variant(), &device, trial, &RunOptions::default());
            let outcome = outcome.expect("a model can be run");
            let rules = self.variant().rules.iter().zip(&outcome.rules).filter(|(_, rule)| rule.broken.is_some());
            failed.extend(rules.map(|(rule, _)| format!("rule {} in {}", rule.id, trial.id)));
            if outcome.case.verdict != Verdict::Pass {
                let reason = outcome.case.reason.unwrap_or_default();
                failed.push(format!("{} {} {reason}", outcome.case.verdict, outcome.case.id));
            }
            if is_enough && failed.iter().any(|line| line.starts_with("fail") || line.starts_with("rule")) {
                return failed;
            }
        }
        failed
    }
}

static ENCODERS: LazyLock<Vec<UnknownEncoder>> = LazyLock::new(UnknownEncoder::amt58);

#[test]
fn an_encoder_known_by_its_gsd_alone_passes() {
    for encoder in ENCODERS.iter() {
        let failed = encoder.failed(&[], false);
        assert!(failed.is_empty(), "{}:\n{}", encoder.variant, failed.join("\n"));
        let covered: BTreeSet<usize> = encoder.trials().flat_map(|trial| trial.covers.iter().copied()).collect();
        println!("{}: {} trials, {} requirements", encoder.variant, encoder.trials().count(), covered.len());
        assert!(encoder.trials().count() >= 80, "{}", encoder.trials().count());
    }
}

#[test]
fn no_permitted_variation_fails() {
    let subject = deviations::subject(AMT58).expect("a reference device");
    let each = || subject.permitted().map(|known| known.name).filter(|name| *name != OTHER_GSD);
    let pairs = ENCODERS.iter().flat_map(|encoder| each().map(move |name| (encoder, vec![name])));
    let sample = DailySample::one_of(12);
    let mut jobs = sample.items(pairs);
    for (index, encoder) in ENCODERS.iter().enumerate() {
        for seed in 0..COMBINATIONS {
            let drawn = subject.random_variations(seed + COMBINATIONS * index as u64);
            let names = drawn.into_iter().map(|known| known.name).filter(|name| *name != OTHER_GSD);
            jobs.push((encoder, names.collect()));
        }
    }
    let failed = every(&jobs, |(encoder, names)| {
        let failed = encoder.failed(names, false);
        (!failed.is_empty())
            .then(|| format!("{} --vary {}\n{}\n", encoder.variant, names.join(" --vary "), failed.join("\n")))
    });
    assert!(failed.is_empty(), "{sample}:\n{}", failed.concat());
}

/// Bugs in signals, presets, scaling, velocity and parameters, which the manual's own suite catches.
#[test]
fn most_bugs_that_the_manual_finds_are_found_without_it() {
    let topics = ["DXC", "PRE", "SCL", "SPD", "PRM", "NVM"];
    let own = manual(AMT58);
    let bugs: Vec<&str> = own
        .bugs
        .iter()
        .filter(|bug| {
            bug.breaks.iter().any(|index| topics.iter().any(|topic| own.requirements[*index].id.contains(topic)))
        })
        .map(|bug| bug.name.as_str())
        .collect();
    let sample = DailySample::one_of(6);
    let jobs = sample.items(bugs);
    let missed = every(&jobs, |name| {
        let is_caught = ENCODERS.iter().any(|encoder| {
            encoder.failed(&[name], true).iter().any(|line| line.starts_with("fail") || line.starts_with("rule"))
        });
        (!is_caught).then(|| (*name).to_owned())
    });
    let caught = jobs.len() - missed.len();
    println!("{caught} of {}; missed: {missed:?}", jobs.len());
    assert!(caught * 100 >= jobs.len() * CAUGHT, "{sample}: {caught} of {}; missed: {missed:?}", jobs.len());
}
