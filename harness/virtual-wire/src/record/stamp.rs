//! Timestamps of logs: seconds, a time of day, or a date with a time of day.
//!
//! | written | meaning |
//! | --- | --- |
//! | `12.345678`, `12,345678`, `12.3s`, `12345ms`, `12345678us` | time since a beginning, or since 1970 |
//! | `10:00:00.123456` | time of day; after midnight the next day begins |
//! | `2026-11-22 10:00:00.123456`, `2026/11/22T10:00:00,5`, `22.11.2026 10:00:00` | date and time of day |
//!
//! A date and time of day may have a zone, `Z` or `+01:00`; without one it is UTC. Brackets around a timestamp are ignored. A
//! whole number without a unit is not a timestamp: it might be a byte.

use station::Time;

const SECOND: u64 = 1_000_000_000;
const DAY: u64 = 86_400 * SECOND;

/// What a timestamp counts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimestampKind {
    /// From a start that only the logging program knows.
    Seconds,
    /// From midnight.
    TimeOfDay,
    /// From 1970.
    Date,
}

impl TimestampKind {
    /// The kind as text.
    pub fn word(self) -> &'static str {
        match self {
            TimestampKind::Seconds => "seconds",
            TimestampKind::TimeOfDay => "a time of day",
            TimestampKind::Date => "a date",
        }
    }
}

/// Reads the timestamp at the beginning of a line; also returns the rest of the line.
pub fn stamp(line: &str) -> Option<(TimestampKind, Time, &str)> {
    let line = line.trim_start();
    let (bracket, inside) = match line.as_bytes().first() {
        Some(b'[') => (Some(']'), &line[1..]),
        Some(b'(') => (Some(')'), &line[1..]),
        _ => (None, line),
    };
    let mut cursor = TimestampParser { rest: inside.trim_start() };
    let (kind, nanos) = cursor.stamp()?;
    let mut rest = cursor.rest;
    if let Some(bracket) = bracket {
        rest = rest.trim_start().strip_prefix(bracket)?;
    }
    // Bytes separated by colons are not a time of day.
    let mut behind = rest.chars();
    let is_over = match behind.next() {
        None => true,
        Some(':') => behind.next().is_none_or(char::is_whitespace),
        Some(next) => bracket.is_some() || next.is_whitespace() || matches!(next, ',' | ';' | '|' | '>' | '<'),
    };
    is_over.then_some((kind, Time::from_nanos(nanos), rest))
}

struct TimestampParser<'a> {
    rest: &'a str,
}

impl<'a> TimestampParser<'a> {
    fn stamp(&mut self) -> Option<(TimestampKind, u64)> {
        let before = self.rest;
        let first = self.digits()?;
        match (self.peek(), first.len()) {
            (Some('-' | '/'), 4) => {
                let separator = self.peek()?;
                self.accept(separator);
                let month = self.number()?;
                self.accept(separator).then_some(())?;
                let day = self.number()?;
                self.after_date(days(first.parse().ok()?, month, day)?)
            }
            (Some(':'), 1 | 2) => {
                self.rest = before;
                Some((TimestampKind::TimeOfDay, self.clock()?))
            }
            _ => {
                self.rest = before;
                match self.german_date() {
                    Some(days) => self.after_date(days),
                    None => {
                        self.rest = before;
                        Some((TimestampKind::Seconds, self.seconds()?))
                    }
                }
            }
        }
    }

    /// `22.11.2026` as days since 1970.
    fn german_date(&mut self) -> Option<u64> {
        let day = self.number()?;
        self.accept('.').then_some(())?;
        let month = self.number()?;
        self.accept('.').then_some(())?;
        let year = self.digits().filter(|digits| digits.len() == 4)?;
        days(year.parse().ok()?, month, day)
    }

    fn after_date(&mut self, days: u64) -> Option<(TimestampKind, u64)> {
        if !(self.accept('T') || self.accept('_')) {
            let clock = self.rest.trim_start();
            if clock.len() == self.rest.len() {
                return None;
            }
            self.rest = clock;
        }
        let nanos = days.checked_mul(DAY)?.checked_add(self.clock()?)?;
        let zone = match self.peek() {
            Some('Z') => {
                self.accept('Z');
                return Some((TimestampKind::Date, nanos));
            }
            Some(sign @ ('+' | '-')) => sign,
            _ => return Some((TimestampKind::Date, nanos)),
        };
        self.accept(zone);
        let digits = self.digits()?;
        let (hours, minutes): (u64, u64) = match digits.len() {
            4 => (digits[..2].parse().ok()?, digits[2..].parse().ok()?),
            2 => (digits.parse().ok()?, if self.accept(':') { self.number()? } else { 0 }),
            _ => return None,
        };
        let ahead = (hours < 24 && minutes < 60).then_some((hours * 60 + minutes) * 60 * SECOND)?;
        let nanos = if zone == '+' { nanos.checked_sub(ahead) } else { nanos.checked_add(ahead) };
        Some((TimestampKind::Date, nanos?))
    }

    /// `10:00:00` with or without a fraction, in nanoseconds.
    fn clock(&mut self) -> Option<u64> {
        let hours = self.number().filter(|hours| *hours < 24)?;
        self.accept(':').then_some(())?;
        let minutes = self.number().filter(|minutes| *minutes < 60)?;
        self.accept(':').then_some(())?;
        // 60 is a leap second.
        let seconds = self.number().filter(|seconds| *seconds <= 60)?;
        let fraction = self.fraction().unwrap_or_default();
        Some(((hours * 60 + minutes) * 60 + seconds) * SECOND + fraction)
    }

    /// `12.345` or `12345ms`, in nanoseconds.
    fn seconds(&mut self) -> Option<u64> {
        let whole = self.number()?;
        let fraction = self.fraction();
        let units = [("ms", 1_000_000), ("us", 1_000), ("µs", 1_000), ("ns", 1), ("s", SECOND)];
        let unit = units.into_iter().find_map(|(unit, each)| {
            self.rest = self.rest.strip_prefix(unit)?;
            Some(each)
        });
        if unit.is_none() && fraction.is_none() {
            return None;
        }
        let unit = unit.unwrap_or(SECOND);
        // The fraction is counted in billionths of the unit.
        let part = u128::from(fraction.unwrap_or_default()) * u128::from(unit) / u128::from(SECOND);
        u64::try_from(u128::from(whole) * u128::from(unit) + part).ok()
    }

    /// The digits after a point or a comma, as billionths; finer digits are ignored.
    fn fraction(&mut self) -> Option<u64> {
        let before = self.rest;
        if !(self.accept('.') || self.accept(',')) {
            return None;
        }
        let Some(digits) = self.digits() else {
            self.rest = before;
            return None;
        };
        let billionths: String = digits.chars().chain("000000000".chars()).take(9).collect();
        billionths.parse().ok()
    }

    fn number(&mut self) -> Option<u64> {
        self.digits()?.parse().ok()
    }

    fn digits(&mut self) -> Option<&'a str> {
        let end = self.rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(self.rest.len());
        let (digits, rest) = self.rest.split_at(end);
        self.rest = rest;
        (!digits.is_empty()).then_some(digits)
    }

    fn peek(&self) -> Option<char> {
        self.rest.chars().next()
    }

    fn accept(&mut self, expected: char) -> bool {
        self.rest.strip_prefix(expected).map(|rest| self.rest = rest).is_some()
    }
}

/// Days from 1970 to a calendar date; `None` for an invalid date, or before 1970.
fn days(year: u64, month: u64, day: u64) -> Option<u64> {
    let is_leap = |year: u64| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let lengths = [31, if is_leap(year) { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let index = usize::try_from(month.checked_sub(1)?).ok()?;
    let is_there = (1970..10_000).contains(&year) && (1..=*lengths.get(index)?).contains(&day);
    let years = (1970..year).map(|year| if is_leap(year) { 366 } else { 365 });
    is_there.then(|| years.sum::<u64>() + lengths[..index].iter().sum::<u64>() + day - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    /// The seconds of dates are the output of `date -u -d ... +%s` of GNU coreutils 9.1.
    #[rstest]
    #[case("12.345678 68", TimestampKind::Seconds, 12_345_678_000, " 68")]
    #[case("  0.0000000019 E5", TimestampKind::Seconds, 1, " E5")]
    #[case("[12,5] 68", TimestampKind::Seconds, 12_500_000_000, " 68")]
    #[case("12.345;RX;68", TimestampKind::Seconds, 12_345_000_000, ";RX;68")]
    #[case("12.345: 68", TimestampKind::Seconds, 12_345_000_000, ": 68")]
    #[case("12.3s 68", TimestampKind::Seconds, 12_300_000_000, " 68")]
    #[case("12345ms 68", TimestampKind::Seconds, 12_345_000_000, " 68")]
    #[case("7.25us>68", TimestampKind::Seconds, 7_250, ">68")]
    #[case("1795341600.5", TimestampKind::Seconds, 1_795_341_600_500_000_000, "")]
    #[case("10:00:00.123456 10 02", TimestampKind::TimeOfDay, 36_000_123_456_000, " 10 02")]
    #[case("[10:00:00,5] 10", TimestampKind::TimeOfDay, 36_000_500_000_000, " 10")]
    #[case("[2026-11-22 10:00:00.123456] 10 02", TimestampKind::Date, 1_795_341_600_123_456_000, " 10 02")]
    #[case("2026-11-22T10:00:00Z 10", TimestampKind::Date, 1_795_341_600_000_000_000, " 10")]
    #[case("2026/11/22_11:30:00+01:30 10", TimestampKind::Date, 1_795_341_600_000_000_000, " 10")]
    #[case("2026-11-22 08:00:00-0200 10", TimestampKind::Date, 1_795_341_600_000_000_000, " 10")]
    #[case("22.11.2026 10:00:00.5 10", TimestampKind::Date, 1_795_341_600_500_000_000, " 10")]
    #[case("(2024-02-29 23:59:60) 10", TimestampKind::Date, 1_709_251_200_000_000_000, " 10")]
    fn timestamps_are_read(#[case] line: &str, #[case] kind: TimestampKind, #[case] nanos: u64, #[case] rest: &str) {
        assert_eq!(stamp(line), Some((kind, Time::from_nanos(nanos), rest)));
    }

    #[rstest]
    #[case::bytes("68 05 05 68")]
    #[case::bytes_with_colons("10:02:05:49:50:16")]
    #[case::bytes_with_dashes("10-02-05-49-50-16")]
    #[case::whole_number("1234 68 05")]
    #[case::no_seconds("10:00 68")]
    #[case::no_such_hour("24:00:00 68")]
    #[case::no_such_day("2026-02-29 10:00:00 68")]
    #[case::no_such_month("2026-13-01 10:00:00 68")]
    #[case::before_1970("1969-12-31 23:59:59 68")]
    #[case::date_alone("2026-11-22 68 05")]
    #[case::open_bracket("[12.5 68")]
    #[case::no_end("12.5RX 68")]
    #[case::beyond_the_range("99999999999999999999.5 68")]
    #[case::far_future("99999999999.5 68")]
    #[case::words("hello")]
    #[case::nothing("")]
    fn other_text_is_not_a_timestamp(#[case] line: &str) {
        assert_eq!(stamp(line), None);
    }
}
