//! The calendar time of a frame.

use station::Time;

/// A time since 1970 as `2026-11-28T04:05:06.123456Z` (RFC 3339), in UTC.
pub fn utc(time: Time) -> String {
    let nanos = time.as_nanos();
    let (seconds, micros) = (nanos / 1_000_000_000, nanos % 1_000_000_000 / 1_000);
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    // Days are counted from 0000-03-01, so that a leap day is the last day of a year of 365.2425 days.
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * from_march + 2) / 5 + 1;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    format!(
        "{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}.{micros:06}Z",
        second / 3_600,
        second / 60 % 60,
        second % 60
    )
}

#[cfg(test)]
mod tests {
    use super::utc;
    use rstest::rstest;
    use station::Time;

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
}
