//! Devices that are none: whatever answers, or does not, a run against it is never green, lists everything and ends.

use encspec::cli::Suites;
use encspec::cli::run::Request;
use encspec::engine::dut::DEVICE;
use encspec::engine::{DutKind, DutSpec, Nobody, RunOptions, run_trial};
use encspec::report::{self, ExitStatus};
use encspec::result::{CaseKind, RunResult};
use encspec::suite::device::Bus;
use encspec::suite::model::{Manual, Trial, Variant};
use encspec::verdict::Verdict;
use rstest::rstest;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{LazyLock, Mutex, OnceLock};
use std::thread;
use std::time::{Duration, Instant};
use testing::Sample;
use wire::profibus::fdl::{Frame, StationType};

static MANUALS: LazyLock<Vec<Manual>> = LazyLock::new(|| Suites::default().load().expect("the shipped suites"));

/// The longest that a run against nobody may take, in a build without optimisation on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// What running everything against `nobody`, which claims to be each manual in turn, came to; it is run once for all tests.
fn run(nobody: &'static str) -> &'static [RunResult] {
    static KNOWN: Mutex<BTreeMap<&str, &OnceLock<Vec<RunResult>>>> = Mutex::new(BTreeMap::new());
    let place = *KNOWN.lock().expect("no test panics here").entry(nobody).or_insert_with(|| Box::leak(Box::default()));
    place.get_or_init(|| run_anew(nobody))
}

fn run_anew(nobody: &str) -> Vec<RunResult> {
    let run = |manual: &Manual| {
        let request = Request {
            duts: vec![format!("null:{nobody}")],
            device: Some(manual.device.name.clone()),
            ..Request::default()
        };
        let ready = request.ready(&MANUALS).map_err(|stop| stop.message).expect("a null device");
        ready.run(&MANUALS, &|_, _, _| {}).map_err(|stop| stop.message).expect("a virtual bench")
    };
    let begun = Instant::now();
    let results = MANUALS.iter().map(run).collect();
    assert!(begun.elapsed() < PATIENCE, "{nobody}: the run took {:?}", begun.elapsed());
    results
}

/// The ids of every trial and rule, and those of the report, are the same.
fn is_complete(result: &RunResult) {
    for run in &result.runs {
        let manual = MANUALS.iter().find(|manual| manual.device.name == run.dut.device).expect("a manual");
        let variant = manual.variants.iter().find(|variant| variant.name == run.dut.variant).expect("a variant");
        let trials = variant.trials.iter().map(|of| &of.id).chain(variant.rules.iter().map(|of| &of.id));
        let expected: Vec<String> = trials.map(|id| format!("{}/{id}", run.dut.device)).collect();
        let found: Vec<&String> = run.cases.iter().map(|case| &case.id).collect();
        assert_eq!(found, expected.iter().collect::<Vec<_>>());
        for case in run.cases.iter().filter(|case| case.verdict != Verdict::Pass) {
            assert!(case.reason.as_ref().is_some_and(|reason| !reason.is_empty()), "{} gives no reason", case.id);
        }
    }
}

#[rstest]
#[case::no_device("absent")]
#[case::silent("silent")]
#[case::reflector("reflector")]
#[case::random_octets("babbler")]
#[case::another_identity("wrong-identity")]
#[case::dead_from_the_start("dies-after-0")]
#[case::dead_after_its_name("dies-after-1")]
#[case::dead_before_it_can_be_asked("dies-after-2")]
#[case::dead_when_it_was_found("dies-after-3")]
fn nobody_passes(#[case] nobody: &'static str) {
    for result in run(nobody) {
        is_complete(result);
        assert_eq!(report::status(result), ExitStatus::Red);
        let passes: Vec<&str> = result
            .runs
            .iter()
            .flat_map(|run| &run.cases)
            .filter(|case| case.verdict.colour() == encspec::verdict::Colour::Green)
            .map(|case| case.id.as_str())
            .filter(|id| !is_over_before_it_dies(id, nobody))
            .collect();
        assert_eq!(passes, [""; 0], "{nobody} passed");
    }
}

/// Whether the device sends no more frames in the whole of a trial than it has when it dies: it lives through it.
fn is_over_before_it_dies(id: &str, nobody: &str) -> bool {
    let frames = nobody.strip_prefix("dies-after-").and_then(|frames| frames.parse().ok());
    let trials = MANUALS.iter().flat_map(|manual| {
        let of = move |variant: &'static Variant| variant.trials.iter().map(move |trial| (manual, variant, trial));
        manual.variants.iter().flat_map(of)
    });
    let mut meant = trials.filter(|(.., trial)| trial.id == id);
    frames.is_some_and(|frames: usize| {
        meant.all(|(manual, variant, trial)| sent_in_health(manual, variant, trial) <= frames)
    })
}

/// A run against a device that dies is red and complete, whenever it dies.
#[rstest]
#[case("dies-after-5")]
#[case("dies-after-40")]
#[case("dies-after-100")]
fn who_dies_is_never_green(#[case] nobody: &'static str) {
    for result in run(nobody) {
        is_complete(result);
        assert_eq!(report::status(result), ExitStatus::Red);
    }
}

/// A device that dies in the course of a trial does not pass it: not when its very last frame is missing, and not when it dies
/// earlier, which is somewhere else from one trial to the next. A third of the trials is looked at each day.
#[test]
fn who_dies_in_a_trial_does_not_pass_it() {
    let trials: Vec<(&Manual, &Variant, &Trial)> = MANUALS
        .iter()
        .flat_map(|manual| manual.variants.iter().map(move |variant| (manual, variant)))
        .flat_map(|(manual, variant)| variant.trials.iter().map(move |trial| (manual, variant, trial)))
        .collect();
    let sample = Sample::one_of(3);
    let (next, survivors) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some((manual, variant, trial)) = trials.get(at) else { return };
            if !sample.has(at) {
                continue;
            }
            let found = survives(manual, variant, trial, at);
            survivors.lock().expect("no thread panicked").extend(found);
        }
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(work);
        }
    });
    let survivors = survivors.into_inner().expect("no thread panicked");
    assert!(survivors.is_empty(), "{sample}: {}:\n{}", survivors.len(), survivors.join("\n"));
}

/// How many frames a healthy device sends in a trial.
fn sent_in_health(manual: &Manual, variant: &Variant, trial: &Trial) -> usize {
    let known = deviations::subject(&manual.device.name).expect("a reference device for every suite");
    let mac = known.manual.mac(DEVICE.0.0);
    let kind = DutKind::Model { deviations: Vec::new() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    let healthy = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a virtual bench");
    assert_eq!(healthy.case.verdict, Verdict::Pass, "{} in health", trial.id);
    let from_device = |octets: &[u8]| match manual.device.bus.kind() {
        Bus::Profinet => octets.get(6..12) == Some(&mac),
        Bus::Profibus => is_answer(octets),
    };
    healthy.trace.iter().filter(|frame| from_device(frame.octets)).count()
}

/// After how many frames a device may die in a trial, which is the one `at` this place, and yet not fail it.
fn survives(manual: &Manual, variant: &Variant, trial: &Trial, at: usize) -> Vec<String> {
    let one = |kind: DutKind| {
        let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
        run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a virtual bench")
    };
    let sent = sent_in_health(manual, variant, trial);
    let earlier = [sent - 2, sent * 3 / 4, sent / 2, sent / 4];
    let verdicts = [sent - 1, earlier[at % earlier.len()]]
        .map(|frames| (frames, one(DutKind::Nobody(Nobody::DiesAfter(frames))).case.verdict));
    let survived = verdicts.iter().filter(|(_, of)| !matches!(of, Verdict::Fail | Verdict::Inconclusive));
    survived.map(|(frames, of)| format!("{}: {of} after {frames} of {sent} frames", trial.id)).collect()
}

/// Whether a frame of PROFIBUS is one of a slave; our masters ask, and answer each other as masters.
fn is_answer(octets: &[u8]) -> bool {
    match Frame::parse(octets) {
        Ok(Frame::ShortAcknowledgement) => true,
        Ok(Frame::Data(frame)) => frame.fc.station() == Some(StationType::SLAVE),
        Ok(Frame::Token { .. }) | Err(_) => false,
    }
}

/// What nobody does is never a finding about a device, nor one about us.
#[rstest]
#[case("absent")]
#[case("silent")]
#[case("reflector")]
#[case("babbler")]
#[case("wrong-identity")]
fn nobody_is_not_blamed(#[case] nobody: &'static str) {
    for result in run(nobody) {
        let cases = result.runs.iter().flat_map(|run| &run.cases);
        let failed = cases.filter(|case| matches!(case.verdict, Verdict::Fail | Verdict::Error));
        assert_eq!(failed.map(|case| case.id.as_str()).collect::<Vec<_>>(), [""; 0]);
    }
}

/// A part of the suite is no way around it, rules alone included.
#[rstest]
#[case("preset/absolute")]
#[case("protocol-connect/")]
#[case("rules/")]
fn a_part_of_the_suite_does_not_pass_either(#[case] filter: &str) {
    let has_it = |manual: &&Manual| {
        let variants = || manual.variants.iter();
        let trials = variants().flat_map(|of| &of.trials).map(|of| &of.id);
        let rules = variants().flat_map(|of| &of.rules).map(|of| &of.id);
        trials.chain(rules).any(|id| id.contains(filter))
    };
    assert!(MANUALS.iter().any(|manual| has_it(&manual)), "no suite has anything like {filter}");
    for nobody in ["absent", "reflector", "babbler"] {
        // The rules alone need every trial, and to look at the babbler in all of them takes long: a manual for each bus will do.
        let takes_long = nobody == "babbler" && filter == "rules/";
        let size = |manual: &&Manual| manual.variants.iter().map(|variant| variant.trials.len()).sum::<usize>();
        let smallest = [Bus::Profinet, Bus::Profibus].map(|bus| {
            let of_bus = MANUALS.iter().filter(has_it).filter(|manual| manual.device.bus.kind() == bus);
            of_bus.min_by_key(size).map(|manual| &manual.device.name)
        });
        let is_asked = |manual: &&Manual| !takes_long || smallest.contains(&Some(&manual.device.name));
        for manual in MANUALS.iter().filter(has_it).filter(is_asked) {
            let request = Request {
                duts: vec![format!("null:{nobody}")],
                device: Some(manual.device.name.clone()),
                filter: Some(filter.to_owned()),
                ..Request::default()
            };
            let ready = request.ready(&MANUALS).map_err(|stop| stop.message).expect("a null device");
            let result = ready.run(&MANUALS, &|_, _, _| {}).map_err(|stop| stop.message).expect("a virtual bench");
            let kinds: Vec<CaseKind> = result.runs.iter().flat_map(|run| &run.cases).map(|case| case.kind).collect();
            assert!(!kinds.is_empty(), "something was selected");
            assert_eq!(report::status(&result), ExitStatus::Red, "null:{nobody} {filter}");
        }
    }
}
