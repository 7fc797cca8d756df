//! A rule has the same result on the virtual wire and on a capture of it: every trial is written as pcapng, read back and judged again.

use crate::built_in::manuals;
use crate::recordings::trace_file;
use encspec::engine::{DutKind, DutSpec, RunOptions, TrialOutcome, run_trial};
use encspec::observe::Address;
use encspec::replay::judge_rules;
use encspec::suite::device::Bus;
use encspec::suite::model::{Manual, SuiteVariant, Trial};
use station::Time;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use virtual_wire::capture::CaptureItem;
use virtual_wire::{CaptureReader, Trace};
use wire::ethernet::Mac;

const CONTROLLER: Mac = Mac([2, 0, 0, 0, 0, 1]);
const MASTER: u8 = 1;

fn virtually(manual: &Manual, variant: &SuiteVariant, trial: &Trial, bugs: &[String]) -> TrialOutcome {
    let kind = DutKind::Model { deviations: bugs.to_vec() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run")
}

/// The frames after writing them to a file and reading it back.
fn through_a_file(manual: &Manual, trace: &Trace) -> Vec<(u64, Time, Vec<u8>)> {
    let file = trace_file(manual, trace);
    let mut reader = CaptureReader::new(file.as_slice()).expect("a readable capture");
    let mut frames = Vec::new();
    while let Some(item) = reader.next() {
        match item {
            CaptureItem::Packet(packet) => frames.push((packet.number as u64, packet.time, packet.captured.to_vec())),
            CaptureItem::Damage(damage) => panic!("the capture is damaged: {damage:?}"),
        }
    }
    frames
}

fn compare(manual: &Manual, index: usize, trial: &Trial, bugs: &[String]) -> usize {
    let variant = &manual.variants[index];
    let outcome = virtually(manual, variant, trial, bugs);
    let controller = match manual.device.bus.kind() {
        Bus::Profinet => Address::Mac(CONTROLLER),
        Bus::Profibus => Address::Fdl(MASTER),
    };
    let frames = through_a_file(manual, &outcome.trace);
    assert_eq!(frames.len(), outcome.trace.len());
    let frames = frames.iter().map(|(number, time, octets)| (*number, *time, octets.as_slice()));
    let replayed = judge_rules(frames, manual, index, |ar| ar.controller.address == controller);
    let mut decided = 0;
    for (rule, (virtually, replayed)) in variant.rules.iter().zip(outcome.rules.iter().zip(&replayed)) {
        let what = format!("{} in {} of {} with {bugs:?}", rule.id, trial.id, variant.name);
        assert_eq!(virtually.decided.premises, replayed.decided.premises, "decided premises of {what}");
        let (one, other) = (virtually.broken.as_ref().map(|(violation, _)| violation), replayed.violation.as_ref());
        assert_eq!(one.map(|of| of.tick), other.map(|of| of.tick), "violation of {what}");
        decided += usize::from(replayed.decided.premises > 0);
    }
    decided
}

/// Calls `work` for every item on one thread for each processor. Returns the sum of the results.
fn sum<T: Sync>(items: &[T], work: impl Fn(&T) -> usize + Sync) -> usize {
    let (next, sum) = (AtomicUsize::new(0), AtomicUsize::new(0));
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
                    sum.fetch_add(work(item), Ordering::Relaxed);
                }
            });
        }
    });
    sum.into_inner()
}

#[test]
fn rules_have_the_same_result_in_the_capture() {
    let manuals = manuals();
    let variants = manuals.iter().flat_map(|manual| (0..manual.variants.len()).map(move |index| (manual, index)));
    let trials: Vec<(&Manual, usize, &Trial)> = variants
        .flat_map(|(manual, index)| manual.variants[index].trials.iter().map(move |trial| (manual, index, trial)))
        .collect();
    let decided = sum(&trials, |(manual, index, trial)| compare(manual, *index, trial, &[]));
    assert!(decided > 1000, "only {decided} rules were decided");
}

#[test]
fn broken_rules_are_broken_in_the_capture_too() {
    let manuals = manuals();
    let mut rules: Vec<(&Manual, usize, usize)> = Vec::new();
    for manual in manuals {
        for (index, variant) in manual.variants.iter().enumerate() {
            let with_a_bug = (0..variant.rules.len()).filter(|&rule| !variant.rules[rule].catches.is_empty());
            rules.extend(with_a_bug.map(|rule| (manual, index, rule)));
        }
    }
    let broken = sum(&rules, |&(manual, index, rule)| {
        let variant = &manual.variants[index];
        let bug = &variant.rules[rule].catches[..1];
        // A trial that catches the bug usually breaks the rule.
        let (mut trials, others): (Vec<&Trial>, Vec<&Trial>) =
            variant.trials.iter().partition(|trial| trial.catches.contains(&bug[0]));
        trials.extend(others);
        let shows = |trial: &&Trial| virtually(manual, variant, trial, bug).rules[rule].broken.is_some();
        trials.into_iter().find(shows).map_or(0, |trial| {
            compare(manual, index, trial, bug);
            1
        })
    });
    assert!(broken * 2 > rules.len(), "only {broken} of {} rules were broken", rules.len());
}
