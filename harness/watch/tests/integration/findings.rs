//! Findings as they are decided.

use crate::machine::{GOOD, STOP, findings, run, time};
use encspec_watch::{LiveWatch, WatchLine, json_line, prometheus};
use station::Duration;

/// A finding comes no later than this after its fault.
const SOON: Duration = Duration::from_secs(2);

#[test]
fn a_machine_without_a_fault_has_no_finding_at_any_time() {
    let mut watch = LiveWatch::new(&[], None);
    let lines = run(&mut watch, 0..20_000, |_, _| Some(GOOD));
    assert_eq!(findings(&lines), []);
    let (lines, counts) = watch.end();
    assert!(lines.iter().all(|line| !matches!(line, WatchLine::Finding(_))), "{lines:?}");
    assert_eq!(counts.frames, 80_000);
}

#[test]
fn each_fault_is_found_soon_and_once() {
    let mut watch = LiveWatch::new(&[], None);
    let (stop, lost, again) = (5_000..5_400, 12_000..12_007, 30_000..30_007);
    let lines = run(&mut watch, 0..40_000, |from, cycle| match from {
        0x10 if stop.contains(&cycle) => Some(STOP),
        0x13 if lost.contains(&cycle) || again.contains(&cycle) => None,
        _ => Some(GOOD),
    });
    let found = findings(&lines);
    let ids: Vec<_> = found.iter().map(|(id, ..)| id.as_str()).collect();
    assert_eq!(ids, ["PN-STATUS-STOP", "PN-CYCLE-LOST", "PN-CYCLE-LOST"]);
    for ((_, _, when), began) in found.iter().zip([stop.start, lost.start, again.start]) {
        let after = when.since(time(began));
        assert!(after <= SOON, "{after:?} after cycle {began}");
    }
}

#[test]
fn what_the_kernel_lost_is_a_loss_of_the_capture_and_nothing_else() {
    let mut watch = LiveWatch::new(&[], None);
    let mut lines = run(&mut watch, 0..5_000, |_, _| Some(GOOD));
    watch.lost(400);
    lines.extend(run(&mut watch, 5_100..15_000, |_, _| Some(GOOD)));
    assert_eq!(findings(&lines), []);
    let lost: Vec<_> = lines.iter().filter(|(_, line)| matches!(line, WatchLine::Lost { .. })).collect();
    assert!(
        matches!(lost.as_slice(), [(_, WatchLine::Lost { by: "kernel", blame: "capture", frames: 400, .. })]),
        "{lost:?}"
    );
    assert!(prometheus(watch.counts()).contains("\nencspec_kernel_lost_frames_total 400\n"));
}

/// The kernel loses frames before each frame of a second, twice. All frames are counted, and what follows is judged again.
#[test]
fn a_watch_that_is_behind_catches_up() {
    let mut watch = LiveWatch::new(&[], None);
    let mut lines = run(&mut watch, 0..5_000, |_, _| Some(GOOD));
    for cycle in (5_000..6_000).chain(7_000..8_000) {
        watch.lost(3);
        lines.extend(run(&mut watch, cycle..cycle + 1, |from, _| (from == 0x10).then_some(GOOD)));
    }
    lines.extend(run(&mut watch, 8_000..20_000, |from, cycle| {
        Some(if from == 0x10 && (15_000..15_400).contains(&cycle) { STOP } else { GOOD })
    }));
    let found = findings(&lines);
    assert_eq!(found.iter().map(|(id, ..)| id.as_str()).collect::<Vec<_>>(), ["PN-STATUS-STOP"]);
    let (_, counts) = watch.end();
    assert_eq!((counts.frames, counts.lost_by_kernel), (20_000 + 2_000 + 48_000, 6_000));
    // Each time the first two losses cut what is measured, the frames after them wait, and so do those of 50 ms after the last loss.
    assert_eq!(counts.not_judged, 998 + 998 + 4 * 50 - 4);
}

#[test]
fn a_side_that_falls_silent_for_good_is_found_when_its_watchdog_must_have_expired() {
    let mut watch = LiveWatch::new(&[], None);
    let lines = run(&mut watch, 0..12_000, |from, cycle| (from != 0x12 || cycle < 5_000).then_some(GOOD));
    let found = findings(&lines);
    assert_eq!(found.iter().map(|(id, ..)| id.as_str()).collect::<Vec<_>>(), ["PN-CYCLE-SILENT"]);
    // Without the Connect the longest watchdog of PROFINET counts, 1.92 s.
    let after = found[0].2.since(time(5_000));
    assert!(after > Duration::from_millis(1_920) && after < Duration::from_millis(1_920) + SOON, "{after:?}");
}

#[test]
fn jitter_and_lost_frames_are_counted_by_direction() {
    let mut watch = LiveWatch::new(&[], None);
    run(&mut watch, 0..10_000, |from, cycle| (from != 0x11 || cycle != 7_000).then_some(GOOD));
    let (_, counts) = watch.end();
    let of = &counts.connections[&("02:00:00:00:00:10".to_owned(), "02:00:00:00:00:11".to_owned())];
    assert_eq!([of.directions[0].frames, of.directions[1].frames], [10_000, 9_999]);
    assert_eq!(of.directions[1].longest_interval, Duration::from_millis(2));
    let text = prometheus(&counts);
    assert!(text.contains("direction=\"from_device\",le=\"0.000001\"} 9999\n"), "{text}");
}

#[test]
fn a_finding_is_one_line_of_json_with_the_keys_of_a_report() {
    let mut watch = LiveWatch::new(&[], None);
    let lines = run(&mut watch, 0..8_000, |from, cycle| Some(if from == 0x10 && cycle > 6_000 { STOP } else { GOOD }));
    let line = lines.iter().map(|(_, line)| json_line(line)).find(|line| line.contains("\"finding\"")).expect("one");
    assert_eq!(line.matches('\n').count(), 1);
    for key in [
        "\"event\":\"finding\"",
        "\"wall_clock\":\"2026-11-28T00:00:06.00",
        "\"blame\":\"undecided\"",
        "\"frame\":24005",
    ] {
        assert!(line.contains(key), "{key} is not in {line}");
    }
}
