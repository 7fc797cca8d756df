//! Suggestions for a filter that matches no case and no rule.

use plain_text::nearest;

/// The nearest id, or part of an id between slashes, to a filter that matches none of `ids`.
pub fn suggest_id(filter: &str, ids: &[String]) -> Option<String> {
    let whole = ids.iter().map(String::as_str);
    let without_manual = || whole.clone().filter_map(|id| id.split_once('/').map(|(_, rest)| rest));
    let without_row = || without_manual().filter_map(|id| id.split_once('[').map(|(rest, _)| rest));
    let parts = || without_manual().flat_map(|id| id.split('/'));
    let cases = || parts().filter_map(|part| part.split_once('[').map(|(case, _)| case));
    let words = if filter.contains('/') {
        whole.clone().chain(without_manual()).chain(without_row()).collect::<Vec<_>>()
    } else {
        parts().chain(cases()).collect()
    };
    // With --exact the last part of an id is not enough.
    let ended = whole.clone().find(|id| id.strip_suffix(filter).is_some_and(|before| before.ends_with('/')));
    let near = ended.map(str::to_owned).or_else(|| nearest(filter, words.iter().copied()));
    near.or_else(|| filter.rsplit_once('/').and_then(|(_, last)| nearest(last, parts().chain(cases()))))
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    const IDS: [&str; 4] =
        ["enc/preset/absolute", "enc/preset/shifted[mode 1]", "enc/rules/one-position", "enc/park/park"];

    #[rstest]
    #[case("presett", Some("preset"))]
    #[case("shiftet", Some("shifted"))]
    #[case("enc/preset/absolut", Some("enc/preset/absolute"))]
    #[case("preset/absolut", Some("preset/absolute"))]
    #[case("one-positoin", Some("one-position"))]
    #[case("absolute", Some("enc/preset/absolute"))]
    #[case("preset/shifted[mode 1]", Some("enc/preset/shifted[mode 1]"))]
    #[case("xyzzy", None)]
    fn the_nearest_id_is_suggested(#[case] filter: &str, #[case] meant: Option<&str>) {
        let ids: Vec<String> = IDS.iter().map(|id| (*id).to_owned()).collect();
        assert_eq!(super::suggest_id(filter, &ids).as_deref(), meant);
    }
}
