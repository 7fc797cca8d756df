//! What the texts of values mean: vendors write `CW`, `On` or `RpM` where a suite has the words `clockwise`, `enabled` and `rpm`.

/// Words of suites, each with texts that vendors write for it, as [`plain_words`] returns them.
const TEXTS: [(&str, &[&str]); 17] = [
    ("clockwise", &["cw", "clockwise cw", "cw clockwise", "im uhrzeigersinn", "rechts"]),
    (
        "counterclockwise",
        &[
            "ccw",
            "counter clockwise",
            "counterclockwise ccw",
            "ccw counterclockwise",
            "counter clockwise ccw",
            "anticlockwise",
            "anti clockwise",
            "gegen den uhrzeigersinn",
            "links",
        ],
    ),
    ("enabled", &["enable", "on", "yes", "active", "activated", "true", "ein", "ja", "aktiv", "aktiviert"]),
    (
        "disabled",
        &[
            "disable",
            "off",
            "no",
            "inactive",
            "not active",
            "deactivated",
            "false",
            "aus",
            "nein",
            "inaktiv",
            "deaktiviert",
        ],
    ),
    ("used", &["enable", "enabled", "on", "yes", "active"]),
    ("unused", &["disable", "disabled", "off", "no", "not used", "inactive"]),
    (
        "steps_per_second",
        &["steps s", "step s", "steps sec", "steps per s", "increments per second", "inc s", "schritte s", "units s"],
    ),
    ("steps_per_100ms", &["steps 100 ms", "step 100 ms", "schritte 100 ms"]),
    ("steps_per_10ms", &["steps 10 ms", "step 10 ms", "schritte 10 ms"]),
    (
        "rpm",
        &[
            "r pm",
            "rev min",
            "r min",
            "u min",
            "1 min",
            "revolutions per minute",
            "revolution per minute",
            "rounds per minute",
            "rotations per minute",
            "umdrehungen pro minute",
        ],
    ),
    ("rps", &["rpsec", "rev s", "r s", "1 s", "revolutions per second", "rounds per second"]),
    ("auto", &["automatic", "automatically", "automatisch"]),
    ("by_p971", &["p 971", "with p 971", "on p 971", "manual", "manually"]),
    ("reduced", &["short", "reduced diagnosis", "reduced diagnostics", "6 bytes"]),
    ("extended", &["long", "extended diagnosis", "extended diagnostics", "16 bytes"]),
    ("absolute", &["absolute preset", "absolute mode"]),
    ("relative", &["relative preset", "relative mode"]),
];

/// What a text means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// This word of the suite.
    One(String),
    /// None of the words, or more than one.
    Unknown,
}

/// The word among `words` that a text means.
pub fn meaning(text: &str, words: &[(String, i128)]) -> Meaning {
    let text = plain_words(text).join(" ");
    let means = |word: &String| {
        plain_words(word).join(" ") == text
            || TEXTS.iter().any(|(known, texts)| known == word && texts.contains(&text.as_str()))
    };
    let fitting: Vec<&String> = words.iter().map(|(word, _)| word).filter(|word| means(word)).collect();
    match fitting.as_slice() {
        [only] => Meaning::One((*only).clone()),
        _ => Meaning::Unknown,
    }
}

/// The words of a name or a text in lower case, numbers apart: `G1_XIST1` is `g`, `1`, `xist`, `1`.
pub fn plain_words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = None;
    for letter in text.chars() {
        let kind = letter.is_alphanumeric().then(|| letter.is_numeric());
        match (kind, words.last_mut()) {
            (Some(_), Some(last)) if kind == before => last.extend(letter.to_lowercase()),
            (Some(_), _) => words.push(letter.to_lowercase().collect()),
            (None, _) => {}
        }
        before = kind;
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    #[rstest]
    #[case::abbreviated("CCW", "counterclockwise")]
    #[case::in_two_words("Counter-clockwise", "counterclockwise")]
    #[case::in_german("Im Uhrzeigersinn", "clockwise")]
    #[case::as_the_word("clockwise", "clockwise")]
    fn directions_have_one_meaning(#[case] text: &str, #[case] word: &str) {
        let words = [("clockwise".to_owned(), 0), ("counterclockwise".to_owned(), 1)];
        assert_eq!(meaning(text, &words), Meaning::One(word.to_owned()));
    }

    #[rstest]
    #[case("steps/100ms", "steps_per_100ms")]
    #[case("Steps per second", "steps_per_second")]
    #[case("RpM", "rpm")]
    #[case("RpSec", "rps")]
    fn units_have_one_meaning(#[case] text: &str, #[case] word: &str) {
        let words = ["steps_per_second", "steps_per_100ms", "rpm", "rps"];
        let words: Vec<(String, i128)> = words.iter().map(|word| ((*word).to_owned(), 0)).collect();
        assert_eq!(meaning(text, &words), Meaning::One(word.to_owned()));
    }

    #[test]
    fn an_unknown_text_means_nothing() {
        assert_eq!(meaning("Mode B", &[("auto".to_owned(), 0)]), Meaning::Unknown);
    }
}
