//! Points in time for reports.

use crate::ledger::Date;
use std::time::{SystemTime, UNIX_EPOCH};

/// A point in time in UTC to the second, as RFC 3339 writes it: `2026-11-28T04:05:06Z`.
pub fn time_stamp(time: SystemTime) -> String {
    let of_day = time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs() % 86_400);
    let (hours, minutes, seconds) = (of_day / 3600, of_day / 60 % 60, of_day % 60);
    format!("{}T{hours:02}:{minutes:02}:{seconds:02}Z", Date::of(time))
}

#[cfg(test)]
mod tests {
    use super::time_stamp;
    use rstest::rstest;
    use std::time::{Duration, UNIX_EPOCH};

    // `date -u -d @N +%FT%TZ` gives the same.
    #[rstest]
    #[case(0, "1970-01-01T00:00:00Z")]
    #[case(951_782_400, "2000-02-29T00:00:00Z")]
    #[case(1_795_838_706, "2026-11-28T04:05:06Z")]
    fn a_time_is_written_in_utc(#[case] seconds: u64, #[case] text: &str) {
        assert_eq!(time_stamp(UNIX_EPOCH + Duration::from_secs(seconds)), text);
    }
}
