//! How a report is written for the console: colours, and the time of the reader.

use crate::clock::parse_wall_clock;
use crate::filter::ReportFilter;
use crate::finding::FindingSeverity;

/// How a report is written.
#[derive(Clone, Debug, Default)]
pub struct TextOptions {
    /// Whether severities are coloured.
    pub colour: bool,
    /// The seconds by which local time is ahead of UTC at a time in seconds since 1970; without it only UTC is written.
    pub local: Option<fn(u64) -> i64>,
    /// What was left out of the report; only the connections are selected here.
    pub filter: ReportFilter,
}

impl TextOptions {
    /// A word in the colour of a severity.
    pub(super) fn severity(&self, severity: FindingSeverity, word: &str) -> String {
        let code = match severity {
            FindingSeverity::Error => "31",
            FindingSeverity::Warning => "33",
            FindingSeverity::Info => "36",
        };
        self.paint(code, word)
    }

    pub(super) fn paint(&self, code: &str, word: &str) -> String {
        if self.colour { format!("\x1b[{code}m{word}\x1b[0m") } else { word.to_owned() }
    }

    /// A time as date and time in UTC, and in local time if that is another.
    pub(super) fn date(&self, wall_clock: &str) -> String {
        let utc = wall_clock.replace('T', " ").replace('Z', " UTC");
        match self.local_time(wall_clock) {
            Some((_, offset)) if offset == "+00:00" => utc,
            Some((time, offset)) => format!("{utc} ({time} local, UTC{offset})"),
            None => utc,
        }
    }

    /// The time of day in local time, with its offset as `+01:00`.
    pub(super) fn local_time(&self, wall_clock: &str) -> Option<(String, String)> {
        let nanos = parse_wall_clock(wall_clock)?;
        let seconds = nanos / 1_000_000_000;
        let offset = (self.local?)(seconds);
        let of_day = (i64::try_from(seconds).ok()? + offset).rem_euclid(86_400);
        let [hours, minutes, rest] = [of_day / 3_600, of_day / 60 % 60, of_day % 60];
        let micros = nanos / 1_000 % 1_000_000;
        let (sign, ahead) = (if offset < 0 { '-' } else { '+' }, offset.unsigned_abs() / 60);
        let offset = format!("{sign}{:02}:{:02}", ahead / 60, ahead % 60);
        Some((format!("{hours:02}:{minutes:02}:{rest:02}.{micros:06}"), offset))
    }
}

/// The time of day of a time in UTC: `14:00:00.123456`.
pub(super) fn time_of_day(wall_clock: &str) -> &str {
    wall_clock.split_once('T').map_or(wall_clock, |(_, time)| time.trim_end_matches('Z'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn local_time_stands_beside_utc() {
        let options = TextOptions { local: Some(|_| -5_400), ..TextOptions::default() };
        let text = "2017-03-01 00:30:00.250000 UTC (23:00:00.250000 local, UTC-01:30)";
        assert_eq!(options.date("2017-03-01T00:30:00.250000Z"), text);
        assert_eq!(TextOptions::default().date("2017-03-01T00:30:00.250000Z"), "2017-03-01 00:30:00.250000 UTC");
    }
}
