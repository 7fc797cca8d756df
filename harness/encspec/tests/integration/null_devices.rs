//! Null devices: whatever answers, or does not, a run is never green, lists every case and ends in time.

use encspec::cli::Suites;
use encspec::cli::filter::FilterArgs;
use encspec::cli::run::RunRequest;
use encspec::engine::dut::DEVICE;
use encspec::engine::{DutKind, DutSpec, NullPeer, RunOptions, run_trial};
use encspec::report::{self, ExitStatus};
use encspec::result::{CaseKind, RunResult};
use encspec::suite::device::Bus;
use encspec::suite::model::{Manual, SuiteVariant, Trial};
use encspec::verdict::Verdict;
use rstest::rstest;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{LazyLock, Mutex, OnceLock};
use std::thread;
use std::time::{Duration, Instant};
use testing::DailySample;
use wire::profibus::fdl::{FdlFrame, StationType};

static MANUALS: LazyLock<Vec<Manual>> = LazyLock::new(|| Suites::default().load().expect("the shipped suites"));

/// The longest that a run against a null device may take, in an unoptimised build on a loaded host.
const LONGEST_RUN: Duration = Duration::from_secs(120);

/// The results of running everything against a null device that claims to be each manual in turn. All tests share them.
fn run(null_device: &'static str) -> &'static [RunResult] {
    static RESULTS: Mutex<BTreeMap<&str, &OnceLock<Vec<RunResult>>>> = Mutex::new(BTreeMap::new());
    let mut results = RESULTS.lock().expect("no test panics here");
    let of_device = *results.entry(null_device).or_insert_with(|| Box::leak(Box::default()));
    drop(results);
    of_device.get_or_init(|| run_all(null_device))
}

fn run_all(null_device: &str) -> Vec<RunResult> {
    let run = |manual: &Manual| {
        let request = RunRequest {
            duts: vec![format!("null:{null_device}")],
            device: Some(manual.device.name.clone()),
            ..RunRequest::default()
        };
        let ready = request.ready(&MANUALS).map_err(|stop| stop.message).expect("a null device");
        ready.run(&MANUALS, &|_, _, _| {}).map_err(|stop| stop.message).expect("a virtual bench")
    };
    let begun = Instant::now();
    let results = MANUALS.iter().map(run).collect();
    assert!(begun.elapsed() < LONGEST_RUN, "{null_device}: the run took {:?}", begun.elapsed());
    results
}

/// Asserts that the report has every trial and rule, each with a reason unless it passed.
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
#[case::dies_before_the_first_frame("dies-after-0")]
#[case::dies_after_its_name("dies-after-1")]
#[case::dies_before_it_answers("dies-after-2")]
#[case::dies_after_discovery("dies-after-3")]
fn no_null_device_passes(#[case] null_device: &'static str) {
    for result in run(null_device) {
        is_complete(result);
        assert_eq!(report::status(result), ExitStatus::Red);
        let passes: Vec<&str> = result
            .runs
            .iter()
            .flat_map(|run| &run.cases)
            .filter(|case| case.verdict.colour() == encspec::verdict::Colour::Green)
            .map(|case| case.id.as_str())
            .filter(|id| !is_over_before_it_dies(id, null_device))
            .collect();
        assert_eq!(passes, [""; 0], "{null_device} passed");
    }
}

/// Whether a conforming device needs no more frames for the trial than the null device sends before it dies.
fn is_over_before_it_dies(id: &str, null_device: &str) -> bool {
    let frames = null_device.strip_prefix("dies-after-").and_then(|frames| frames.parse().ok());
    let trials = MANUALS.iter().flat_map(|manual| {
        let of = move |variant: &'static SuiteVariant| variant.trials.iter().map(move |trial| (manual, variant, trial));
        manual.variants.iter().flat_map(of)
    });
    let mut meant = trials.filter(|(.., trial)| trial.id == id);
    frames.is_some_and(|frames: usize| {
        meant.all(|(manual, variant, trial)| frames_of_a_conforming_device(manual, variant, trial) <= frames)
    })
}

/// A run against a device that dies is red and complete, whenever the device dies.
#[rstest]
#[case("dies-after-5")]
#[case("dies-after-40")]
#[case("dies-after-100")]
fn a_device_that_dies_is_never_green(#[case] null_device: &'static str) {
    for result in run(null_device) {
        is_complete(result);
        assert_eq!(report::status(result), ExitStatus::Red);
    }
}

/// A device that dies during a trial does not pass it: neither if only the last frame is missing nor if it dies earlier, at a point
/// that varies from trial to trial. A third of the trials runs each day.
#[test]
fn a_device_that_dies_in_a_trial_does_not_pass_it() {
    let trials: Vec<(&Manual, &SuiteVariant, &Trial)> = MANUALS
        .iter()
        .flat_map(|manual| manual.variants.iter().map(move |variant| (manual, variant)))
        .flat_map(|(manual, variant)| variant.trials.iter().map(move |trial| (manual, variant, trial)))
        .collect();
    let sample = DailySample::one_of(3);
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

/// The number of frames that a conforming device sends in a trial.
fn frames_of_a_conforming_device(manual: &Manual, variant: &SuiteVariant, trial: &Trial) -> usize {
    let known = deviations::subject(&manual.device.name).expect("a reference device for every suite");
    let mac = known.manual.mac(DEVICE.0.0);
    let kind = DutKind::Model { deviations: Vec::new() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a virtual bench");
    assert_eq!(outcome.case.verdict, Verdict::Pass, "{} on the reference device", trial.id);
    let from_device = |octets: &[u8]| match manual.device.bus.kind() {
        Bus::Profinet => octets.get(6..12) == Some(&mac),
        Bus::Profibus => is_answer(octets),
    };
    outcome.trace.iter().filter(|frame| from_device(frame.octets)).count()
}

/// Describes each death of the device that does not make the trial fail. `index` is the index of the trial.
fn survives(manual: &Manual, variant: &SuiteVariant, trial: &Trial, index: usize) -> Vec<String> {
    let one = |kind: DutKind| {
        let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
        run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a virtual bench")
    };
    let sent = frames_of_a_conforming_device(manual, variant, trial);
    let earlier = [sent - 2, sent * 3 / 4, sent / 2, sent / 4];
    let verdicts = [sent - 1, earlier[index % earlier.len()]]
        .map(|frames| (frames, one(DutKind::Null(NullPeer::DiesAfter(frames))).case.verdict));
    let survived = verdicts.iter().filter(|(_, of)| !matches!(of, Verdict::Fail | Verdict::Inconclusive));
    survived.map(|(frames, of)| format!("{}: {of} after {frames} of {sent} frames", trial.id)).collect()
}

/// Whether a PROFIBUS frame comes from a slave; the masters of the harness send requests and answer as masters.
fn is_answer(octets: &[u8]) -> bool {
    match FdlFrame::parse(octets) {
        Ok(FdlFrame::ShortAcknowledgement) => true,
        Ok(FdlFrame::Data(frame)) => frame.fc.station() == Some(StationType::SLAVE),
        Ok(FdlFrame::Token { .. }) | Err(_) => false,
    }
}

/// A run against a null device has no failures and no errors: everything is inconclusive.
#[rstest]
#[case("absent")]
#[case("silent")]
#[case("reflector")]
#[case("babbler")]
#[case("wrong-identity")]
fn a_null_device_is_not_blamed(#[case] null_device: &'static str) {
    for result in run(null_device) {
        let cases = result.runs.iter().flat_map(|run| &run.cases);
        let failed = cases.filter(|case| matches!(case.verdict, Verdict::Fail | Verdict::Error));
        assert_eq!(failed.map(|case| case.id.as_str()).collect::<Vec<_>>(), [""; 0]);
    }
}

/// A filter does not make a null device pass, even if it selects only rules.
#[rstest]
#[case("preset/absolute")]
#[case("protocol-connect/")]
#[case("rules/")]
fn a_filtered_run_does_not_pass_either(#[case] filter: &str) {
    let has_it = |manual: &&Manual| {
        let variants = || manual.variants.iter();
        let trials = variants().flat_map(|of| &of.trials).map(|of| &of.id);
        let rules = variants().flat_map(|of| &of.rules).map(|of| &of.id);
        trials.chain(rules).any(|id| id.contains(filter))
    };
    assert!(MANUALS.iter().any(|manual| has_it(&manual)), "no id contains {filter}");
    for null_device in ["absent", "reflector", "babbler"] {
        // Rules need every trial, which takes long with the babbler: one manual of each bus is enough.
        let takes_long = null_device == "babbler" && filter == "rules/";
        let size = |manual: &&Manual| manual.variants.iter().map(|variant| variant.trials.len()).sum::<usize>();
        let smallest = [Bus::Profinet, Bus::Profibus].map(|bus| {
            let of_bus = MANUALS.iter().filter(has_it).filter(|manual| manual.device.bus.kind() == bus);
            of_bus.min_by_key(size).map(|manual| &manual.device.name)
        });
        let is_tested = |manual: &&Manual| !takes_long || smallest.contains(&Some(&manual.device.name));
        for manual in MANUALS.iter().filter(has_it).filter(is_tested) {
            let request = RunRequest {
                duts: vec![format!("null:{null_device}")],
                device: Some(manual.device.name.clone()),
                filter: FilterArgs { filters: vec![filter.to_owned()], ..FilterArgs::default() },
                ..RunRequest::default()
            };
            let ready = request.ready(&MANUALS).map_err(|stop| stop.message).expect("a null device");
            let result = ready.run(&MANUALS, &|_, _, _| {}).map_err(|stop| stop.message).expect("a virtual bench");
            let kinds: Vec<CaseKind> = result.runs.iter().flat_map(|run| &run.cases).map(|case| case.kind).collect();
            assert!(!kinds.is_empty(), "nothing was selected");
            assert_eq!(report::status(&result), ExitStatus::Red, "null:{null_device} {filter}");
        }
    }
}
