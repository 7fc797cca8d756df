//! The requirement that a device breaks fails, and little else: each has a check of its own, a bug fails few requirements beyond those
//! that it breaks, and the report begins with the right group of failures.
//!
//! `fixtures/attribution.txt` has what is still above the goals; its numbers may only shrink. The bugs of a day are about a hundred;
//! `ENCSPEC_SAMPLE=all cargo test -p encspec --test integration attribution::` runs them all and prints a new table where it fails.

use crate::built_in::manuals;
use crate::on_two_threads::every;
use encspec::attribution::bugs::{BugEffect, percentile};
use encspec::attribution::shared::SharedRequirements;
use encspec::attribution::{BEYOND_GOALS, SHARED_GOAL};
use encspec::suite::model::{Bug, Manual};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Mutex;
use testing::DailySample;

/// How many bugs run each day.
const BUGS_A_DAY: usize = 50;
/// Percentage of the reports whose first group has a requirement that the bug breaks: 90 is the goal.
const FIRST_GROUP_REACHED: usize = 90;
/// At most so many percent of a manual's bugs may fail more than the goal of the 90th percentile.
const ABOVE: usize = 10;

/// What is above the goals today.
struct KnownNumbers {
    /// For each manual: requirements without a check of their own, and what is judged as one with several levels.
    shared: BTreeMap<String, (usize, usize)>,
    /// For each manual and bug: requirements beyond `breaks`, and musts if it breaks none.
    bugs: BTreeMap<(String, String), (usize, usize)>,
}

impl KnownNumbers {
    fn read() -> KnownNumbers {
        let mut known = KnownNumbers { shared: BTreeMap::new(), bugs: BTreeMap::new() };
        for line in include_str!("../fixtures/attribution.txt").lines().filter(|line| !line.starts_with('#')) {
            let number = |text: &str| text.parse().unwrap_or_else(|_| panic!("no number: {line}"));
            match line.split(' ').collect::<Vec<_>>()[..] {
                ["shared", manual, shared, mixed] => {
                    known.shared.insert(manual.to_owned(), (number(shared), number(mixed)));
                }
                [manual, bug, beyond, musts] => {
                    known.bugs.insert((manual.to_owned(), bug.to_owned()), (number(beyond), number(musts)));
                }
                _ => panic!("an unknown line: {line}"),
            }
        }
        known
    }
}

#[test]
fn few_requirements_have_no_check_of_their_own() {
    let known = KnownNumbers::read();
    let mut worse = String::new();
    for manual in manuals() {
        let shared = SharedRequirements::of(manual);
        let goal = (manual.own_requirements() as f64 * SHARED_GOAL / 100.0) as usize;
        let (most, mixed) = known.shared.get(&manual.device.name).copied().unwrap_or_default();
        if shared.shared() > most.max(goal) || shared.mixed.len() > mixed {
            let _ = writeln!(worse, "shared {} {} {}", manual.device.name, shared.shared(), shared.mixed.len());
        }
    }
    assert!(worse.is_empty(), "`encspec attribution` lists them; more than in the table:\n{worse}");
}

#[test]
fn the_table_names_bugs_and_few_of_each_manual() {
    let known = KnownNumbers::read();
    let listed = |manual: &Manual, bug: &Bug| known.bugs.contains_key(&(manual.device.name.clone(), bug.name.clone()));
    let all: usize = manuals().iter().map(|manual| manual.bugs.iter().filter(|bug| listed(manual, bug)).count()).sum();
    assert_eq!(all, known.bugs.len(), "a bug of the table does not exist");
}

#[test]
fn a_bug_fails_little_else_and_the_report_begins_with_it() {
    let bugs: Vec<(&Manual, &Bug)> =
        manuals().iter().flat_map(|manual| manual.bugs.iter().map(move |bug| (manual, bug))).collect();
    let sample = DailySample::one_of(bugs.len().div_ceil(BUGS_A_DAY) as u64);
    let chosen: Vec<(&Manual, &Bug)> = sample.items(bugs);
    let effects = Mutex::new(Vec::new());
    every(&chosen, |(manual, bug)| {
        let effect = BugEffect::of(manual, bug, 1).expect("a model can be run");
        effects.lock().expect("no thread panicked").push((*manual, effect));
        None
    });
    let effects = effects.into_inner().expect("no thread panicked");
    let known = KnownNumbers::read();
    let mut worse: Vec<String> = Vec::new();
    for (manual, effect) in &effects {
        let key = (manual.device.name.clone(), effect.bug.name.clone());
        let (most, musts) = known.bugs.get(&key).copied().unwrap_or_default();
        let failed = if effect.breaks_no_must(manual) { effect.musts(manual).count() } else { 0 };
        let beyond = if effect.is_of_whole_telegram() { 0 } else { effect.beyond.len() };
        if beyond > most.max(BEYOND_GOALS.1) || failed > musts {
            worse.push(format!("{} {} {} {failed}", key.0, key.1, effect.beyond.len()));
        }
    }
    worse.sort();
    assert!(worse.is_empty(), "{sample}: more than in the table:\n{}", worse.join("\n"));

    let reports: Vec<bool> = effects
        .iter()
        .flat_map(|(_, effect)| effect.causes.iter().filter(|cause| cause.size.1 > 1).map(|cause| cause.is_first))
        .collect();
    let first = reports.iter().filter(|is_first| **is_first).count();
    assert!(
        first * 100 >= reports.len() * FIRST_GROUP_REACHED,
        "{sample}: in {first} of {} reports the first group has a requirement that the bug breaks",
        reports.len()
    );

    if sample.part().is_none() {
        for manual in manuals() {
            let of = effects.iter().filter(|(known, _)| known.device.name == manual.device.name);
            let single = of.filter(|(_, effect)| !effect.is_of_whole_telegram());
            let numbers: Vec<usize> = single.map(|(_, effect)| effect.beyond.len()).collect();
            let above = numbers.iter().filter(|number| **number > BEYOND_GOALS.1).count();
            println!(
                "{}: median {}, 90th percentile {}, {above} of {} above {} (goal: {ABOVE} %)",
                manual.device.name,
                percentile(&numbers, 50),
                percentile(&numbers, 90),
                numbers.len(),
                BEYOND_GOALS.1
            );
        }
    }
}
