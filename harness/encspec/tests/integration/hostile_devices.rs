//! Hostile devices: whatever they send, a trial ends in bounded time and memory, a run is never green, and what they send is shown
//! escaped.

use encspec::cli::Suites;
use encspec::cli::filter::FilterArgs;
use encspec::cli::run::RunRequest;
use encspec::report::{self, ConsoleOptions, ExitStatus};
use encspec::result::RunResult;
use encspec::suite::device::Bus;
use encspec::suite::model::Manual;
use encspec::verdict::Verdict;
use std::sync::LazyLock;
use std::time::{Duration, Instant};
use testing::DailySample;
use virtual_wire::hostile::{HOSTILE_DEVICES, HostileDevice, SpoiltFrames};

static MANUALS: LazyLock<Vec<Manual>> = LazyLock::new(|| Suites::default().load().expect("the shipped suites"));

/// The longest that a run of some cases may take, in an unoptimised build on a loaded host.
const LONGEST_RUN: Duration = Duration::from_secs(120);

/// Cases that touch every kind of frame, on either bus.
const FILTERS: [&str; 7] =
    ["identification/", "preset/", "alarms/", "diagnosis/", "start-up/", "protocol-cyclic/", "protocol-alarms/"];

/// Those of the filters that select something of a manual.
fn filters(manual: &Manual) -> Vec<String> {
    let has = |filter: &&str| {
        let mut trials = manual.variants.iter().flat_map(|variant| &variant.trials);
        trials.any(|trial| trial.id.contains(*filter))
    };
    FILTERS.into_iter().filter(has).map(str::to_owned).collect()
}

fn run(manual: &Manual, device: &HostileDevice) -> RunResult {
    let request = RunRequest {
        duts: vec![format!("null:{}", device.name)],
        device: Some(manual.device.name.clone()),
        filter: FilterArgs { filters: filters(manual), ..FilterArgs::default() },
        ..RunRequest::default()
    };
    let ready = request.ready(&MANUALS).map_err(|stop| stop.message).expect("a hostile device");
    let begun = Instant::now();
    let result = ready.run(&MANUALS, &|_, _, _| {}).map_err(|stop| stop.message).expect("a virtual bench");
    assert!(begun.elapsed() < LONGEST_RUN, "{}: the run took {:?}", device.name, begun.elapsed());
    result
}

/// The manuals of the bus of a device, another one each day.
fn manual_of(device: &HostileDevice, index: usize) -> &'static Manual {
    let bus = if device.is_of_profibus { Bus::Profibus } else { Bus::Profinet };
    // Not every manual has a case with alarms.
    let fits = |manual: &&Manual| {
        manual.device.bus.kind() == bus
            && (device.frames != SpoiltFrames::Alarms || manual.device.name == "profinet-io")
    };
    let fitting: Vec<&Manual> = MANUALS.iter().filter(fits).collect();
    let day = DailySample::one_of(fitting.len() as u64).part().unwrap_or(0) as usize;
    fitting[(index + day) % fitting.len()]
}

#[test]
fn no_hostile_device_is_green() {
    for (index, device) in HOSTILE_DEVICES.iter().enumerate() {
        let manual = manual_of(device, index);
        let result = run(manual, device);
        let cases = || result.runs.iter().flat_map(|run| &run.cases);
        let name = format!("null:{} as {}", device.name, manual.device.name);
        assert!(cases().count() > 3, "{name}: too few cases");
        assert_eq!(report::status(&result), ExitStatus::Red, "{name}");
        let errors: Vec<&str> =
            cases().filter(|case| case.verdict == Verdict::Error).map(|case| case.id.as_str()).collect();
        assert_eq!(errors, [""; 0], "{name}: the harness is at fault");
        let texts = [
            report::console(&result, ConsoleOptions::default()),
            report::html(&result, &|_| Default::default()),
            report::json(&result),
            report::junit(&result),
            report::tap(&result),
        ];
        for text in texts {
            assert!(!text.contains('\u{1B}'), "{name}: an escape sequence of the device");
            assert!(!text.contains("<script>alert"), "{name}: markup of the device");
        }
    }
}

/// The frames that a device sends until it exchanges data, and a few more: on PROFINET fewer than 14, on PROFIBUS fewer than 20.
const START_UP_FRAMES: usize = 24;

#[test]
fn a_device_that_dies_after_any_frame_of_a_start_up_passes_nothing() {
    for (device, frames) in ["lika-xac77-profinet/xac7718", "datalogic-amt58-profibus/hs5818"]
        .into_iter()
        .flat_map(|device| (0..START_UP_FRAMES).map(move |frames| (device, frames)))
    {
        let request = RunRequest {
            duts: vec![format!("null:dies-after-{frames}")],
            device: Some(device.to_owned()),
            filter: FilterArgs { filters: vec!["preset/".to_owned()], ..FilterArgs::default() },
            ..RunRequest::default()
        };
        let ready = request.ready(&MANUALS).map_err(|stop| stop.message).expect("a null device");
        let begun = Instant::now();
        let result = ready.run(&MANUALS, &|_, _, _| {}).map_err(|stop| stop.message).expect("a virtual bench");
        assert!(begun.elapsed() < LONGEST_RUN, "{device} {frames}: the run took {:?}", begun.elapsed());
        assert_eq!(report::status(&result), ExitStatus::Red, "{device} {frames}");
        let wrong: Vec<&str> = result
            .runs
            .iter()
            .flat_map(|run| &run.cases)
            .filter(|case| !matches!(case.verdict, Verdict::Fail | Verdict::Inconclusive))
            .map(|case| case.id.as_str())
            .collect();
        assert_eq!(wrong, [""; 0], "{device} {frames}");
    }
}

/// As `encspec run --help` says.
#[test]
fn an_unknown_kind_lists_them() {
    let request = RunRequest { duts: vec!["null:?".to_owned()], ..RunRequest::default() };
    let Err(stop) = request.ready(&MANUALS) else { panic!("no null device has this name") };
    let missing = HOSTILE_DEVICES.iter().map(|device| device.name).find(|name| !stop.message.contains(name));
    assert_eq!(missing, None, "{}", stop.message);
}
