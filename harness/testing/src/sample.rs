//! Samples of long tests: each day another part runs; `ENCSPEC_SAMPLE=all` runs everything.

use std::fmt;
use std::time::SystemTime;

/// The environment variable with the number of a part, or `all`.
const NAME: &str = "ENCSPEC_SAMPLE";

/// The part of a long test that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DailySample {
    /// The day or the number from the environment; `None` for everything.
    number: Option<u64>,
    parts: u64,
}

impl DailySample {
    /// One of `parts` parts: the number in `ENCSPEC_SAMPLE` modulo `parts`, everything for `all`, otherwise the part of the day.
    ///
    /// # Panics
    ///
    /// If `ENCSPEC_SAMPLE` is anything else.
    pub fn one_of(parts: u64) -> DailySample {
        let day = SystemTime::UNIX_EPOCH.elapsed().map_or(0, |since| since.as_secs() / 86_400);
        DailySample::read(std::env::var(NAME).ok().as_deref(), day, parts)
    }

    fn read(setting: Option<&str>, day: u64, parts: u64) -> DailySample {
        let number = match setting {
            Some("all") => None,
            Some(text) => Some(text.parse().unwrap_or_else(|_| panic!("{NAME} is `{text}`: write a number or `all`"))),
            None => Some(day),
        };
        DailySample { number, parts: parts.max(1) }
    }

    /// Whether the item with this index belongs to the part.
    pub fn has(&self, index: usize) -> bool {
        self.number.is_none_or(|number| index as u64 % self.parts == number % self.parts)
    }

    /// The items that belong to the part.
    pub fn items<T>(&self, all: impl IntoIterator<Item = T>) -> Vec<T> {
        all.into_iter().enumerate().filter(|(index, _)| self.has(*index)).map(|(_, item)| item).collect()
    }

    /// The number of the part, from 0; `None` for everything.
    pub fn part(&self) -> Option<u64> {
        self.number.map(|number| number % self.parts)
    }
}

impl fmt::Display for DailySample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.number {
            Some(number) => write!(f, "{NAME}={number}"),
            None => write!(f, "{NAME}=all"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::DailySample;

    #[test]
    fn consecutive_days_cover_everything_once() {
        for index in 0..100 {
            let days = (20_000..20_004).filter(|day| DailySample::read(None, *day, 4).has(index)).count();
            assert_eq!(days, 1, "{index}");
        }
    }

    #[test]
    fn a_number_repeats_a_day_and_all_covers_everything() {
        let day = DailySample::read(None, 20_781, 3);
        assert_eq!(day.to_string(), "ENCSPEC_SAMPLE=20781");
        assert_eq!(DailySample::read(Some("20781"), 5, 3), day);
        assert!((0..9).all(|index| DailySample::read(Some("all"), 5, 3).has(index)));
    }

    #[test]
    #[should_panic(expected = "ENCSPEC_SAMPLE is `most`: write a number or `all`")]
    fn any_other_setting_panics() {
        DailySample::read(Some("most"), 0, 3);
    }
}
