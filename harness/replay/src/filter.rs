//! What a user wants to see of a report: a severity, a station, a time. What is judged does not change.

use super::clock::parse_wall_clock;
use super::finding::{CaptureFinding, FindingSeverity};
use super::report::{CaptureEvent, CaptureReport, ConnectionReport};
use std::str::FromStr;

/// Which findings and events of a report are shown; the default shows all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReportFilter {
    /// The least severity.
    pub severity: Option<FindingSeverity>,
    /// A station: its MAC address, its station name, an IP address, or its PROFIBUS address.
    pub station: Option<String>,
    /// From this time on.
    pub from: Option<CaptureTime>,
    /// Up to this time.
    pub to: Option<CaptureTime>,
}

/// A time in a capture as a user writes it: seconds since its first frame, or a time in the calendar in UTC.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CaptureTime {
    /// Seconds since the first frame of the same recording.
    Seconds(f64),
    /// Nanoseconds since 1970.
    WallClock(u64),
}

impl FromStr for CaptureTime {
    type Err = String;

    fn from_str(text: &str) -> Result<CaptureTime, String> {
        let seconds = text.trim().trim_end_matches('s').trim_end().parse();
        seconds
            .ok()
            .filter(|seconds: &f64| seconds.is_finite())
            .map(CaptureTime::Seconds)
            .or_else(|| parse_wall_clock(text).map(CaptureTime::WallClock))
            .ok_or_else(|| {
                format!("`{text}` is no time: write seconds since the first frame (12.5) or a time in UTC (2026-03-01T14:00:00)")
            })
    }
}

impl ReportFilter {
    /// Whether it shows everything.
    pub fn is_empty(&self) -> bool {
        *self == ReportFilter::default()
    }

    /// Removes what is not to be shown from a report, and counts the findings.
    pub fn apply(&self, report: &mut CaptureReport) {
        let names = self.station.as_ref().map(|station| names(station, &report.ars));
        let before = report.findings.len();
        let CaptureReport { findings, events, ars, .. } = report;
        findings.retain(|finding| self.shows(finding, names.as_deref(), ars));
        let is_of = |event: &CaptureEvent| names.as_ref().is_none_or(|names| mentions(&event.text, names));
        events.retain(|event| self.is_in_time(Some(event.time), event.wall_clock.as_deref()) && is_of(event));
        report.hidden_findings = (before - report.findings.len()) as u64;
    }

    /// Whether a connection is one of the station.
    pub fn shows_connection(&self, ar: &ConnectionReport) -> bool {
        self.station.as_ref().is_none_or(|station| is_end(ar, &names(station, std::slice::from_ref(ar))))
    }

    fn shows(&self, finding: &CaptureFinding, names: Option<&[String]>, ars: &[ConnectionReport]) -> bool {
        let of_station = |finding: &CaptureFinding, names: &[String]| {
            let ar = finding.ar.and_then(|ar| ars.get(ar));
            ar.is_some_and(|ar| is_end(ar, names)) || mentions(&finding.text, names)
        };
        let is_of = names.is_none_or(|names| {
            of_station(finding, names) || finding.consequences.iter().any(|of| of_station(of, names))
        });
        let in_time = |of: &CaptureFinding| of.frame == 0 || self.is_in_time(of.time, of.wall_clock.as_deref());
        self.severity.is_none_or(|least| finding.severity >= least)
            && is_of
            && (in_time(finding) || finding.consequences.iter().any(in_time))
    }

    fn is_in_time(&self, seconds: Option<f64>, wall_clock: Option<&str>) -> bool {
        let nanos = wall_clock.and_then(parse_wall_clock);
        let is = |limit: Option<CaptureTime>, is_kept: fn(std::cmp::Ordering) -> bool| {
            let order = match limit {
                None => return true,
                Some(CaptureTime::Seconds(limit)) => seconds.and_then(|seconds| seconds.partial_cmp(&limit)),
                Some(CaptureTime::WallClock(limit)) => nanos.map(|nanos| nanos.cmp(&limit)),
            };
            // What has no time is not hidden.
            order.is_none_or(is_kept)
        };
        is(self.from, std::cmp::Ordering::is_ge) && is(self.to, std::cmp::Ordering::is_le)
    }
}

/// The names under which texts mention a station.
fn names(station: &str, ars: &[ConnectionReport]) -> Vec<String> {
    let station = station.trim();
    let mut names = vec![station.to_lowercase(), station.to_owned()];
    for ar in ars {
        for (mac, name) in [(&ar.controller.mac, &ar.controller.station), (&ar.device.mac, &ar.device.station)] {
            let is = |of: &Option<String>| of.as_ref().is_some_and(|of| of.eq_ignore_ascii_case(station));
            if is(mac) || is(name) {
                names.extend([mac, name].into_iter().flatten().cloned());
            }
        }
    }
    if station.parse::<u8>().is_ok() {
        names = ["slave", "station", "master"].map(|word| format!("{word} {station}")).to_vec();
    }
    names.sort();
    names.dedup();
    names
}

fn is_end(ar: &ConnectionReport, names: &[String]) -> bool {
    let named = |of: &Option<String>| of.as_ref().is_some_and(|of| names.contains(of));
    let numbered = |of: Option<u8>| of.is_some_and(|number| names.contains(&format!("station {number}")));
    named(&ar.controller.mac)
        || named(&ar.controller.station)
        || named(&ar.device.mac)
        || named(&ar.device.station)
        || numbered(ar.controller.address)
        || numbered(ar.device.address)
}

/// Whether a text contains one of these names as a whole word.
fn mentions(text: &str, names: &[String]) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || matches!(c, '-' | '.' | '_');
    names.iter().filter(|name| !name.is_empty()).any(|name| {
        text.match_indices(name.as_str()).any(|(at, found)| {
            let before = text.get(..at).and_then(|before| before.chars().next_back());
            let mut after = text.get(at + found.len()..).unwrap_or_default().chars();
            let next = after.next();
            // A full stop ends a sentence where no further letter follows.
            let ends =
                next.is_none_or(|c| !is_part(c)) || next == Some('.') && after.next().is_none_or(|c| !is_part(c));
            before.is_none_or(|c| !is_part(c)) && ends
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    #[rstest]
    #[case("slave 5 reports", "slave 5", true)]
    #[case("slave 52 reports", "slave 5", false)]
    #[case("device 'enc-1' (02:..) is off", "enc-1", true)]
    #[case("device 'enc-12' is off", "enc-1", false)]
    #[case("device 'line.enc-1' is off", "enc-1", false)]
    #[case("it has the address 192.168.0.1.", "192.168.0.1", true)]
    #[case("it has the address 192.168.0.10", "192.168.0.1", false)]
    fn a_station_is_a_whole_word(#[case] text: &str, #[case] name: &str, #[case] is: bool) {
        assert_eq!(mentions(text, &[name.to_owned()]), is);
    }

    #[rstest]
    #[case("12.5", Some(CaptureTime::Seconds(12.5)))]
    #[case("12 s", Some(CaptureTime::Seconds(12.0)))]
    #[case("2017-03-01T14:00:00Z", Some(CaptureTime::WallClock(1_488_376_800_000_000_000)))]
    #[case("yesterday", None)]
    #[case("NaN", None)]
    fn a_time_of_a_user(#[case] text: &str, #[case] time: Option<CaptureTime>) {
        assert_eq!(text.parse().ok(), time);
    }
}
