//! Compares names: a manual and a vendor rarely use the same name for the same thing.

/// Words and numbers of a name, in lower case: `Telegram_81` is `telegram` and `81`.
fn parts(name: &str) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    let mut before = None;
    for c in name.chars() {
        let kind = if c.is_ascii_digit() {
            Some(true)
        } else if c.is_alphabetic() {
            Some(false)
        } else {
            None
        };
        match (kind, parts.last_mut()) {
            (Some(_), Some(last)) if kind == before => last.extend(c.to_lowercase()),
            (Some(_), _) => parts.push(c.to_lowercase().collect()),
            (None, _) => {}
        }
        before = kind;
    }
    parts
}

/// How well a name of the manual fits the names in a GSDML (id, name, order number). All numbers in the manual's name must occur;
/// then each number counts four and each common word one. 0 means nothing in common.
pub(super) fn likeness(name: &str, called: &[&str]) -> u32 {
    let own = parts(name);
    let theirs: Vec<String> = called.iter().flat_map(|name| parts(name)).collect();
    let is_number = |part: &&String| part.starts_with(|c: char| c.is_ascii_digit());
    if own.iter().filter(is_number).any(|number| !theirs.contains(number)) {
        return 0;
    }
    own.iter().filter(|part| theirs.contains(part)).map(|part| if is_number(&part) { 4 } else { 1 }).sum()
}

/// Whether all numbers of a name, at least one, also occur in the names in a GSDML.
pub(super) fn same_numbers(name: &str, called: &[&str]) -> bool {
    likeness(name, called) >= 4
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    #[rstest]
    #[case::number_and_word("telegram_81", &["IDS_81", "Standard Telegram 81"], 5)]
    #[case::another_number("telegram_81", &["Telegram 810"], 0)]
    #[case::only_the_number("telegram_81", &["TEL81"], 4)]
    #[case::words("parameter_access_point", &["Parameter Access Point (PAP)"], 3)]
    #[case::nothing("parameter_access_point", &["PAP"], 0)]
    #[case::order_number("xac7716-16384", &["XAC7716/16384PT"], 9)]
    #[case::another_order_number("xac7718", &["XAC7716/16384PT"], 0)]
    fn likeness_counts_numbers_and_words(#[case] name: &str, #[case] called: &[&str], #[case] expected: u32) {
        assert_eq!(likeness(name, called), expected);
    }
}
