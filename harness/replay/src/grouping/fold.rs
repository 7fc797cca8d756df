//! Findings that repeat each other are one finding with a count. Frame numbers and durations do not matter, since they differ each time.

use crate::finding::CaptureFinding;
use crate::protocol::MORE_OF_A_CHECK;
use crate::protocol::table::START_AGAIN;
use crate::report::ConnectionReport;
use rustc_hash::FxHashMap;

/// The units of a duration in the text of a finding.
const UNITS: [&str; 3] = ["us", "ms", "s"];

/// Folds repeated findings into the first of them.
pub(crate) fn folded(findings: Vec<CaptureFinding>, ars: &[ConnectionReport]) -> Vec<CaptureFinding> {
    let mut known: FxHashMap<String, usize> = FxHashMap::default();
    let mut kept: Vec<CaptureFinding> = Vec::with_capacity(findings.len());
    for finding in findings {
        match known.get(&key(&finding, ars)).and_then(|at| kept.get_mut(*at)) {
            Some(first) => {
                first.count += finding.count;
                first.last_frame = first.last_frame.max(finding.last_frame);
                // The last finding of a check says how many more there are.
                if let Some((_, more)) = without_count(&finding.text) {
                    first.text += more;
                }
            }
            None => {
                known.insert(key(&finding, ars), kept.len());
                kept.push(finding);
            }
        }
    }
    kept
}

/// What repeated findings have in common: check, severity, blame, stations, and the text without frames and durations.
fn key(finding: &CaptureFinding, ars: &[ConnectionReport]) -> String {
    let CaptureFinding { id, severity, blame, text, octet, bit, .. } = finding;
    let ar = finding.ar.and_then(|ar| ars.get(ar));
    let stations = ar.map(|ar| (&ar.controller.mac, ar.controller.address, &ar.device.mac, ar.device.address));
    let text = without_count(text).map_or(text.as_str(), |(text, _)| text);
    let mut key = format!("{id} {severity:?} {blame:?} {stations:?} {octet:?} {bit:?} {}", lasting(text));
    for detail in &finding.details {
        key += &lasting(detail);
    }
    // That a connection broke repeatedly is said once, under the first time.
    for of in finding.consequences.iter().filter(|of| of.id != START_AGAIN.id) {
        key += &format!("\n{} {}", of.id, lasting(&of.text));
    }
    key
}

/// A text without its count of further findings of the same check, and that count.
fn without_count(text: &str) -> Option<(&str, &str)> {
    let end = text.find(MORE_OF_A_CHECK)?;
    let begin = text.get(..end)?.rfind(" (and ")?;
    Some(text.split_at(begin))
}

/// A text without the numbers that differ with each repetition: `frame 17`, `1.25 ms`.
fn lasting(text: &str) -> String {
    let words: Vec<&str> = text.split(' ').collect();
    let bare = |word: &'_ str| word.trim_matches(|c: char| !c.is_ascii_alphanumeric()).to_owned();
    let is_number = |word: &str| {
        let number = word.trim_matches(|c: char| !c.is_ascii_digit());
        !number.is_empty() && number.bytes().all(|octet| octet.is_ascii_digit() || octet == b'.')
    };
    let is_unit = |at: usize| words.get(at).is_some_and(|word| UNITS.contains(&bare(word).as_str()));
    let of_frame = |at: usize| ["frame", "frames"].contains(&bare(words[at]).as_str());
    let each = words.iter().enumerate().map(|(at, word)| {
        let before = at.checked_sub(1);
        let is_duration =
            is_number(word) && is_unit(at + 1) || is_unit(at) && before.is_some_and(|at| is_number(words[at]));
        if is_duration || is_number(word) && before.is_some_and(of_frame) { "#" } else { word }
    });
    each.collect::<Vec<&str>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::{CaptureBlame, FindingSeverity};
    use rstest::rstest;

    fn finding(frame: u64, text: &str) -> CaptureFinding {
        CaptureFinding::protocol("PN-ABORT", FindingSeverity::Error, CaptureBlame::Device, frame, text)
    }

    #[rstest]
    #[case("it stopped (frame 3 1.5 ms earlier)", "it stopped (frame 9 20 us earlier)", 1)]
    #[case("slot 1 subslot 0x0002", "slot 2 subslot 0x0002", 2)]
    #[case("02:00:00:00:00:01 is silent for 3 s", "02:00:00:00:00:02 is silent for 3 s", 2)]
    #[case("3 of 9 frames are missing", "4 of 9 frames are missing", 2)]
    fn only_frames_and_durations_may_differ(#[case] one: &str, #[case] other: &str, #[case] expected: usize) {
        let found = folded(vec![finding(3, one), finding(9, other)], &[]);
        assert_eq!(found.len(), expected);
        if expected == 1 {
            assert_eq!((found[0].frame, found[0].count, found[0].last_frame), (3, 2, 9));
        }
    }
}
