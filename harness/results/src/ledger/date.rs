//! Calendar days for the expiry of ledger entries.

use std::fmt;
use std::str::FromStr;
use std::time::{SystemTime, UNIX_EPOCH};

/// A day, written `2027-01-31`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Date {
    year: u16,
    month: u8,
    day: u8,
}

impl Date {
    /// The day of a point in time in UTC; 1970-01-01 for earlier times.
    pub fn of(time: SystemTime) -> Date {
        let mut days = time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs() / 86_400);
        let mut year = 1970;
        while days >= length_of_year(year) {
            days -= length_of_year(year);
            year += 1;
        }
        let mut month = 1;
        while days >= u64::from(length_of_month(year, month)) {
            days -= u64::from(length_of_month(year, month));
            month += 1;
        }
        Date { year, month, day: days as u8 + 1 }
    }
}

fn is_leap(year: u16) -> bool {
    (year.is_multiple_of(4) && !year.is_multiple_of(100)) || year.is_multiple_of(400)
}

fn length_of_year(year: u16) -> u64 {
    if is_leap(year) { 366 } else { 365 }
}

fn length_of_month(year: u16, month: u8) -> u8 {
    match month {
        2 if is_leap(year) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

impl FromStr for Date {
    type Err = String;

    fn from_str(text: &str) -> Result<Date, String> {
        let wrong = || format!("`{text}` is not a date; write it as 2027-01-31");
        let parts: Vec<&str> = text.split('-').collect();
        let [year, month, day] = parts.as_slice() else { return Err(wrong()) };
        if (year.len(), month.len(), day.len()) != (4, 2, 2) || !text.bytes().all(|c| c.is_ascii_digit() || c == b'-') {
            return Err(wrong());
        }
        match (year.parse(), month.parse(), day.parse()) {
            (Ok(year), Ok(month @ 1..=12), Ok(day)) if (1..=length_of_month(year, month)).contains(&day) => {
                Ok(Date { year, month, day })
            }
            _ => Err(wrong()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;
    use std::time::Duration;

    // Seconds from `date -u -d ... +%s`.
    #[rstest]
    #[case(0, "1970-01-01")]
    #[case(951_782_400, "2000-02-29")]
    #[case(1_709_164_799, "2024-02-28")]
    #[case(1_709_164_800, "2024-02-29")]
    #[case(1_735_689_599, "2024-12-31")]
    #[case(4_107_542_400, "2100-03-01")]
    fn the_day_of_a_time(#[case] seconds: u64, #[case] day: &str) {
        assert_eq!(Date::of(UNIX_EPOCH + Duration::from_secs(seconds)).to_string(), day);
        assert_eq!(day.parse::<Date>().map(|date| date.to_string()).as_deref(), Ok(day));
    }

    #[rstest]
    #[case("2027-02-29")]
    #[case("2027-00-01")]
    #[case("2027-13-01")]
    #[case("2027-01-00")]
    #[case("2027-1-1")]
    #[case("27-01-01")]
    #[case("2027-01")]
    #[case("+027-01-01")]
    #[case("tomorrow")]
    #[case("")]
    fn invalid_dates_are_refused(#[case] text: &str) {
        assert!(text.parse::<Date>().is_err());
    }

    #[test]
    fn days_have_an_order() {
        let day = |text: &str| text.parse::<Date>().expect("a day");
        assert!(day("2026-12-31") < day("2027-01-01"));
        assert!(day("2027-01-31") < day("2027-02-01"));
    }
}
