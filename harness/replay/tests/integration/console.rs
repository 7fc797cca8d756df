//! The report for the console: the summary first, repetitions once, times in the calendar, and what a user wants to see of it.

use crate::handmade::{CONTROLLER, ConnectionFrames, DEVICE};
use encspec_replay::{
    CaptureReport, FindingSeverity, ReplayReport, ReportFilter, TextOptions, capture, text, text_with,
};
use station::{Duration, Time};
use wire::profinet::rpc::Uuid;
use wire::profinet::status::{AbortReason, ErrorCode, PnioStatus, RecordError};

/// 2026-03-01 14:00:00 UTC, by `date -u`.
const AFTERNOON: Time = Time::from_nanos(1_772_373_600_000_000_000);

fn replayed(line: &ConnectionFrames) -> CaptureReport {
    capture("made", &line.capture()[..], &[]).expect("a capture")
}

fn shown(report: &CaptureReport) -> String {
    text(&ReplayReport { captures: vec![report.clone()] })
}

/// A connection that the device ends `times` times.
fn aborted(line: &mut ConnectionFrames, times: u8) {
    for round in 1..=times {
        (line.ar, line.activity) = (Uuid([round; 16]), 10 * round);
        line.start().exchange(20 + usize::from(round));
        line.abort(true, PnioStatus::abort(AbortReason::OUT_OF_MEMORY));
        line.pass(Duration::from_millis(500));
    }
}

#[test]
fn what_repeats_is_one_finding_with_a_count() {
    let mut line = ConnectionFrames::new();
    aborted(&mut line, 2);
    let report = replayed(&line);
    let [finding] = &report.findings[..] else { panic!("{:#?}", report.findings) };
    assert_eq!((finding.id.as_str(), finding.count), ("PN-ABORT", 2));
    assert_eq!(finding.last_frame, line.frames.len() as u64);
    assert!(shown(&report).contains(&format!("(2 times, last in frame {})", line.frames.len())), "{}", shown(&report));

    // Another reason is another finding.
    line.start().exchange(20);
    line.abort(true, PnioStatus::abort(AbortReason::LINK_DOWN));
    assert_eq!(replayed(&line).findings.iter().filter(|finding| finding.id == "PN-ABORT").count(), 2);
}

#[test]
fn the_refused_records_of_one_request_are_one_finding() {
    let refused = PnioStatus::record(ErrorCode::WRITE_RESPONSE, RecordError::INVALID_INDEX);
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    let records: Vec<(u16, u16, u16, &[u8])> = (0..13).map(|index| (1, 2, 0x1000 + index, &[1_u8][..])).collect();
    let frame = line.write(&records, true, &[refused; 13]);
    line.end_parameters();
    line.ready();
    line.exchange(20);
    let report = replayed(&line);
    let [finding] = &report.findings[..] else { panic!("{:#?}", report.findings) };
    assert_eq!((finding.id.as_str(), finding.frame, finding.details.len()), ("PN-RECORD-REFUSED", frame as u64, 13));
    assert!(finding.details[12].contains("0x100C"), "{:?}", finding.details);
    let text = shown(&report);
    assert_eq!(text.matches("\n      record 0x10").count(), 13, "{text}");

    // A single one needs no list.
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    line.write(&records[..1], false, &[refused]);
    line.end_parameters();
    line.ready();
    let finding = &replayed(&line).findings[0];
    assert!(finding.details.is_empty() && finding.text.contains("0x1000"), "{}", finding.text);
}

/// Errors, warnings and much else: the summary has twelve lines at most, then come the findings by severity, then the connections.
#[test]
fn the_summary_comes_first_and_the_connections_last() {
    let mut line = ConnectionFrames { now: AFTERNOON, ..ConnectionFrames::new() };
    for reason in 1..=24 {
        (line.ar, line.activity) = (Uuid([reason; 16]), 10 * reason % 250);
        line.start().exchange(20);
        line.abort(true, PnioStatus::abort(AbortReason(reason)));
        line.pass(Duration::from_millis(500));
    }
    let report = replayed(&line);
    assert!(report.findings.len() > 12, "{}", report.findings.len());
    let text = shown(&report);
    let (summary, rest) = text.split_once("\n\n").expect("an empty line");
    assert!(summary.lines().count() <= 12, "{summary}");
    assert!(summary.lines().next().is_some_and(|first| first.contains(" error")), "{summary}");
    assert!(summary.contains("recorded from 2026-03-01 14:00:00.000000 UTC"), "{summary}");
    assert!(summary.ends_with("below"), "{summary}");
    let place = |what: &str| rest.find(what).unwrap_or_else(|| panic!("{what}: {rest}"));
    assert!(place("\n  ERROR") < place("\n  WARNING") && place("\n  WARNING") < place("\n  connection 1"), "{rest}");
    assert!(place("\n  connection 1") < place("\n  events"), "{rest}");
}

#[test]
fn findings_and_events_have_a_time_in_the_calendar() {
    let mut line = ConnectionFrames { now: AFTERNOON, ..ConnectionFrames::new() };
    aborted(&mut line, 1);
    let report = replayed(&line);
    let at = line.frames.last().unwrap().0;
    let seconds = at.since(AFTERNOON).as_secs_f64();
    let finding = &report.findings[0];
    assert!((finding.time.unwrap() - seconds).abs() < 1e-9, "{:?}", finding.time);
    let micros = at.since(AFTERNOON).as_micros();
    let wall_clock = format!("2026-03-01T14:00:00.{micros:06}Z");
    assert_eq!(finding.wall_clock.as_deref(), Some(wall_clock.as_str()));
    assert_eq!(report.events.last().unwrap().wall_clock.as_deref(), Some(wall_clock.as_str()));
    let options = TextOptions { local: Some(|_| 3_600), ..TextOptions::default() };
    let text = text_with(&ReplayReport { captures: vec![report] }, &options);
    assert!(
        text.contains(&format!(", 2026-03-01 14:00:00.{micros:06} UTC (15:00:00.{micros:06} local, UTC+01:00)")),
        "{text}"
    );
    assert!(text.contains(&format!("{seconds:.6} 14:00:00.{micros:06}  alarm low ERR-RTA")), "{text}");

    // A recorder whose clock was not set has no calendar.
    let mut line = ConnectionFrames::new();
    aborted(&mut line, 1);
    assert_eq!(replayed(&line).findings[0].wall_clock, None);
}

/// Files of several years in one: each recording has its own seconds.
#[test]
fn merged_recordings_have_no_absurd_times() {
    let mut line = ConnectionFrames { now: AFTERNOON, ..ConnectionFrames::new() };
    aborted(&mut line, 1);
    line.now = Time::from_nanos(AFTERNOON.as_nanos() + 400_000_000_000_000_000);
    line.ar = Uuid([9; 16]);
    line.start().exchange(20);
    line.abort(true, PnioStatus::abort(AbortReason::LINK_DOWN));
    let report = replayed(&line);
    assert_eq!(report.recordings.len(), 2);
    assert!(
        report.findings.iter().all(|finding| finding.time.is_some_and(|time| time < 1.0)),
        "{:#?}",
        report.findings
    );
    assert!(shown(&report).contains("2 recordings of different times"), "{}", shown(&report));
    assert_eq!(replayed(&ConnectionFrames { now: AFTERNOON, ..ConnectionFrames::new() }).recordings.len(), 0);
}

#[test]
fn a_filter_hides_and_says_so() {
    let mut line = ConnectionFrames { now: AFTERNOON, ..ConnectionFrames::new() };
    aborted(&mut line, 1);
    let report = replayed(&line);
    let filtered = |filter: &ReportFilter| {
        let mut filtered = report.clone();
        filter.apply(&mut filtered);
        filtered
    };
    let hides = |filter: ReportFilter| {
        let report = filtered(&filter);
        assert_eq!(report.hidden_findings as usize + report.findings.len(), 1);
        report.hidden_findings == 1
    };
    let all = ReportFilter::default;
    let station = |name: &str| ReportFilter { station: Some(name.to_owned()), ..all() };
    for name in [DEVICE.to_string(), CONTROLLER.to_string(), "controller-1".to_owned()] {
        assert!(!hides(station(&name)), "{name}");
    }
    assert!(hides(station("02:00:00:00:00:77")));
    assert!(!hides(ReportFilter { severity: Some(FindingSeverity::Error), ..all() }));
    assert!(!hides(ReportFilter { from: "0.01".parse().ok(), ..all() }));
    assert!(hides(ReportFilter { from: "10".parse().ok(), ..all() }));
    assert!(hides(ReportFilter { to: "0.01".parse().ok(), ..all() }));
    assert!(hides(ReportFilter { to: "2026-03-01T13:59:59Z".parse().ok(), ..all() }));
    assert!(!hides(ReportFilter { from: "2026-03-01 14:00".parse().ok(), ..all() }));
    let text = shown(&filtered(&station("02:00:00:00:00:77")));
    assert!(text.starts_with("made: ") && text.contains("no findings shown"), "{text}");
    assert!(text.contains("1 finding is not shown"), "{text}");
}

#[test]
fn colours_stand_around_severities_only_where_requested() {
    let mut line = ConnectionFrames::new();
    aborted(&mut line, 1);
    let report = ReplayReport { captures: vec![replayed(&line)] };
    assert!(!text(&report).contains('\x1b'));
    let coloured = text_with(&report, &TextOptions { colour: true, ..TextOptions::default() });
    assert!(coloured.contains("\x1b[31mERROR  \x1b[0m"), "{coloured}");
}
