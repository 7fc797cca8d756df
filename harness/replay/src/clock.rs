//! The times of a capture: seconds since the first frame of the same clock, and the calendar.

use results::ledger::Date;
use station::{Duration, Time};
use std::time::UNIX_EPOCH;

/// Two frames further apart than this belong to recordings of their own, whose distance means nothing.
const APART: Duration = Duration::from_secs(24 * 60 * 60);
/// Upper limit of the recordings that are distinguished.
const MOST: usize = 64;
/// Before this time, in seconds since 1970, a clock was not set: 1990-01-01.
const NOT_SET: u64 = 631_152_000;

/// The clocks of a capture. Captures merged from several recordings have several, and frames of one may stand between those of another.
#[derive(Clone, Debug, Default)]
pub(super) struct CaptureClock {
    /// The first frame of each recording, and its latest one.
    recordings: Vec<(Time, Time)>,
    current: usize,
}

impl CaptureClock {
    /// Takes in the time of a frame.
    #[inline]
    pub fn take(&mut self, time: Time) {
        match self.recordings.get_mut(self.current) {
            Some((_, last)) if time >= *last && time.since(*last) < APART => *last = time,
            _ => self.change(time),
        }
    }

    #[cold]
    fn change(&mut self, time: Time) {
        match self.recording(time) {
            Some(known) => {
                self.current = known;
                let (_, last) = &mut self.recordings[known];
                *last = time.max(*last);
            }
            None if self.recordings.len() < MOST => {
                self.current = self.recordings.len();
                self.recordings.push((time, time));
            }
            None => {}
        }
    }

    fn recording(&self, time: Time) -> Option<usize> {
        self.recordings.iter().position(|(first, last)| time + APART > *first && time < *last + APART)
    }

    /// Seconds since the first frame of the recording to which this time belongs; negative where its clock stepped back.
    pub fn seconds(&self, time: Time) -> f64 {
        let nanos = |time: Time| i128::from(time.as_nanos());
        let known = self.recording(time).or_else(|| self.recordings.len().checked_sub(1));
        let first = known.and_then(|known| self.recordings.get(known)).map_or(Time::ZERO, |(first, _)| *first);
        (nanos(time) - nanos(first)) as f64 / 1e9
    }

    /// The first and the last time of each recording.
    pub fn recordings(&self) -> &[(Time, Time)] {
        &self.recordings
    }
}

/// A time as RFC 3339 in UTC with microseconds; `None` where the clock of the recorder was not set.
pub(super) fn wall_clock(time: Time) -> Option<String> {
    (time.as_nanos() / 1_000_000_000 >= NOT_SET).then(|| utc(time))
}

/// A time since 1970 as `2026-11-28T04:05:06.123456Z` (RFC 3339), in UTC.
pub fn utc(time: Time) -> String {
    let nanos = time.as_nanos();
    let seconds = nanos / 1_000_000_000;
    let date = Date::of(UNIX_EPOCH + Duration::from_secs(seconds));
    let [hours, minutes, rest] = [seconds / 3_600 % 24, seconds / 60 % 60, seconds % 60];
    let micros = nanos / 1_000 % 1_000_000;
    format!("{date}T{hours:02}:{minutes:02}:{rest:02}.{micros:06}Z")
}

/// The nanoseconds since 1970 of a time as [`wall_clock`] writes it, or of another in RFC 3339 in UTC; the `T` may be a blank, and
/// the `Z` and the fraction may be missing.
pub(super) fn parse_wall_clock(text: &str) -> Option<u64> {
    let text = text.trim().trim_end_matches(" UTC").trim_end_matches(['Z', 'z']);
    let (date, time) = text.split_once(['T', 't', ' '])?;
    let [year, month, day] = numbers::<3>(date, '-')?;
    let (time, fraction) = time.split_once('.').unwrap_or((time, ""));
    let [hour, minute, second] = match time.matches(':').count() {
        1 => numbers::<2>(time, ':').map(|[hour, minute]| [hour, minute, 0])?,
        _ => numbers::<3>(time, ':')?,
    };
    let is_possible = (1970..2500).contains(&year) && (1..=12).contains(&month) && (1..=31).contains(&day);
    if !is_possible || hour > 23 || minute > 59 || second > 60 || !fraction.bytes().all(|octet| octet.is_ascii_digit())
    {
        return None;
    }
    let fraction: u64 = format!("{:0<9.9}", fraction).parse().ok()?;
    let seconds = ((days(year, month, day) * 24 + hour) * 60 + minute) * 60 + second;
    Some(seconds * 1_000_000_000 + fraction)
}

fn numbers<const N: usize>(text: &str, separator: char) -> Option<[u64; N]> {
    let parts: Vec<u64> = text.split(separator).map(|part| part.parse().ok()).collect::<Option<_>>()?;
    parts.try_into().ok()
}

/// The days from 1970-01-01 to a day of the Gregorian calendar: years that begin in March have their leap day at the end.
fn days(year: u64, month: u64, day: u64) -> u64 {
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let of_year = (153 * month + 2) / 5 + day - 1;
    year * 365 + year / 4 - year / 100 + year / 400 + of_year - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    const SECOND: u64 = 1_000_000_000;

    /// The times are those of `date -u`.
    #[rstest]
    #[case(1_488_376_800 * SECOND + 123_456_789, "2017-03-01T14:00:00.123456Z")]
    #[case(1_709_164_799 * SECOND, "2024-02-28T23:59:59.000000Z")]
    #[case(1_709_251_199 * SECOND, "2024-02-29T23:59:59.000000Z")]
    #[case(1_798_761_600 * SECOND, "2027-01-01T00:00:00.000000Z")]
    fn a_time_in_the_calendar(#[case] nanos: u64, #[case] text: &str) {
        assert_eq!(wall_clock(Time::from_nanos(nanos)).as_deref(), Some(text));
        assert_eq!(parse_wall_clock(text), Some(nanos / 1_000 * 1_000));
    }

    // The expected dates are those of `date -u -d @SECONDS`.
    #[rstest]
    #[case(0, "1970-01-01T00:00:00.000000Z")]
    #[case(951_782_400, "2000-02-29T00:00:00.000000Z")]
    #[case(1_795_838_706, "2026-11-28T04:05:06.000000Z")]
    #[case(4_107_542_399, "2100-02-28T23:59:59.000000Z")]
    #[case(4_107_542_400, "2100-03-01T00:00:00.000000Z")]
    fn dates_are_those_of_the_calendar(#[case] seconds: u64, #[case] expected: &str) {
        assert_eq!(utc(Time::from_nanos(seconds * 1_000_000_000)), expected);
    }

    #[test]
    fn a_clock_that_was_not_set_has_no_calendar() {
        assert_eq!(wall_clock(Time::from_nanos(5 * SECOND)), None);
    }

    #[rstest]
    #[case("2017-03-01 14:00", Some(1_488_376_800 * SECOND))]
    #[case("2017-03-01 14:00:00.5 UTC", Some(1_488_376_800 * SECOND + SECOND / 2))]
    #[case("2017-13-01 14:00", None)]
    #[case("14:00", None)]
    #[case("2017-03-01T25:00:00Z", None)]
    fn a_time_of_a_user(#[case] text: &str, #[case] nanos: Option<u64>) {
        assert_eq!(parse_wall_clock(text), nanos);
    }

    #[test]
    fn recordings_that_are_merged_have_times_of_their_own() {
        let mut clock = CaptureClock::default();
        let years = 400_000_000 * SECOND;
        for nanos in [years, 5, years + 2 * SECOND, 7 * SECOND, years + 3 * SECOND] {
            clock.take(Time::from_nanos(nanos));
        }
        assert_eq!(clock.recordings().len(), 2);
        assert!((clock.seconds(Time::from_nanos(years + 3 * SECOND)) - 3.0).abs() < 1e-6);
        assert!((clock.seconds(Time::from_nanos(7 * SECOND)) - 7.0).abs() < 1e-6);
    }
}
