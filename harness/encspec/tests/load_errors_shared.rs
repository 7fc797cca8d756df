//! What the loader refuses in tables, procedures and common suites, and what a manual can say of a common suite.

mod small_manual;

use encspec::suite::load;
use rstest::rstest;
use small_manual::{refuses, sources};

#[rstest]
// tables, procedures, common suites
#[case("probe/topic.yaml", "STW.mode: =word", "STW.mode: enabled", "enabled", "the column `word` is never used")]
#[case(
    "probe/topic.yaml",
    "value: 0, word: disabled",
    "value: 0",
    "{ row: off",
    "this row has other columns than the first"
)]
#[case("probe/topic.yaml", "row: off", "row: on", "{ row: on, value: 0", "two rows are called `on`")]
#[case(
    "probe/topic.yaml",
    "row: off, value: 0, word: disabled",
    "row: off, value: 1, word: enabled",
    "{ row: off",
    "this trial is the same as `topic/first[on]`"
)]
#[case("probe/topic.yaml", "value: 1", "POS: 1", "POS: 1", "`POS` is a name of the device")]
#[case("probe/topic.yaml", "id: second", "id: first", "first", "duplicate id `first`")]
#[case("probe/topic.yaml", "give: { bit: 0 }", "give: { bti: 0 }", "bti", "unknown entry of give `bti`")]
#[case("probe/topic.yaml", "        give: { bit: 0 }\n", "", "leave", "`leave` has to be given `bit`")]
#[case("probe/procedures.yaml", "=bit", "1", "takes: [bit", "`bit` is taken and never used")]
#[case(
    "common/shared.yaml",
    "takes:",
    "takes:\n  more: { is: word, why: none }",
    "{",
    "`more` is taken and never used"
)]
#[case(
    "probe/shared.yaml",
    "give: { asked: P922, right: 81 }",
    "give: { asked: P922 }",
    "shared",
    "has to be given `right`"
)]
#[case("probe/shared.yaml", "asked: P922", "asekd: P922", "asekd", "unknown entry of give `asekd`")]
#[case("probe/shared.yaml", "asked: P922", "asked: Q922", "Q922", "is not what the common suite takes here")]
#[case("probe/shared.yaml", "use: shared", "use: sharde", "sharde", "unknown common suite `sharde`")]
#[case(
    "probe/shared.yaml",
    "omit: { reads-again: once is enough }",
    "omit: {}",
    "shared",
    "`reads-again` is neither in `covers` nor in `omit`"
)]
#[case("probe/shared.yaml", "reads: [PRB-1]", "read: [PRB-1]", "read:", "unknown case of the common suite `read`")]
#[case(
    "probe/shared.yaml",
    "give: { asked: P922",
    "give: { more: 1, asked: P922",
    "more: 1",
    "unknown entry of give `more`"
)]
#[case("common/shared.yaml", "is: number", "is: numbr", "numbr", "unknown word for is `numbr`")]
#[case(
    "probe/wide.yaml",
    "seen: ZSW.parked",
    "seen: ZSW..parked",
    "ZSW..",
    "`ZSW..parked` is not what the common suite takes here"
)]
#[case("probe/wide.yaml", "seen: ZSW.parked", "seen: ZSW.praked", "ZSW.praked", "unknown field `praked` of ZSW")]
#[case("probe/wide.yaml", "octets: \"40 00\"", "octets: 40", "40", "`40` is not what the common suite takes here")]
#[case("probe/wide.yaml", "time: 20ms", "time: 20", "20", "`20` is not what the common suite takes here")]
#[case(
    "probe/wide.yaml",
    "wrong: [limit, read_only]",
    "wrong: limit",
    "limit",
    "`limit` is not what the common suite takes here"
)]
#[case(
    "probe/wide.yaml",
    "wrong: [limit, read_only]",
    "wrong: [limit, read_onyl]",
    "read_onyl",
    "unknown code `read_onyl`"
)]
#[case(
    "probe/wide.yaml",
    "settings: { scaling: enabled, range: 100 }",
    "settings: [scaling]",
    "[scaling]",
    "a list is not what the common suite takes here"
)]
#[case(
    "probe/wide.yaml",
    "scaling: enabled, range",
    "scailng: enabled, range",
    "scailng",
    "unknown start parameter `scailng`"
)]
#[case("probe/wide.yaml", "rises(STW.park) and", "rises(STW.prak) and", "STW.prak", "prak")]
#[case(
    "probe/wide.yaml",
    "checked: [PRB-1]",
    "checked: PRB-1",
    "PRB-1",
    "`PRB-1` is not what the common suite takes here"
)]
#[case("probe/wide.yaml", "checked: [PRB-1]", "checked: [PRB-7]", "PRB-7", "unknown requirement `PRB-7`")]
#[case("probe/wide.yaml", "{ one: 81, two: 82 }", "{ one: 81 }", "{ one", "there is no value for the variant `two`")]
#[case("probe/wide.yaml", "{ one: 81, two: 82 }", "{ one: 81, tow: 82 }", "tow", "unknown variant `tow`")]
#[case("probe/wide.yaml", "{ one: 81, two: 82 }", "{ one: 81, two: 65536 }", "65536", "65536 is out of range")]
#[case("probe/wide.yaml", "give: {", "give: { spare: 'x', ", "spare", "`spare` is given and never used")]
#[case(
    "probe/wide.yaml",
    "omit: { left: not here }",
    "omit: {}",
    "wide",
    "`left` is neither in `covers` nor in `omit`"
)]
#[case(
    "probe/wide.yaml",
    "omit: { left: not here }",
    "omit: { left: not here, table: no }",
    "no",
    "`table` is spoken of and left out"
)]
#[case("probe/wide.yaml", "variants: { more: [two] }", "variants: { more: [tow] }", "tow", "unknown variant `tow`")]
#[case("probe/wide.yaml", "variants: { more", "variants: { moer", "moer", "unknown case of the common suite `moer`")]
#[case("probe/wide.yaml", "more: [ { row", "moer: [ { row", "moer", "unknown case of the common suite `moer`")]
#[case(
    "probe/wide.yaml",
    "more: [ { row: unusual, number: 2 } ]",
    "follows: [ { number: 2 } ]",
    "follows",
    "`follows` has no table"
)]
#[case("probe/wide.yaml", "number: 2", "numbre: 2", "{ row: unusual", "this row has other columns than the first")]
#[case("probe/wide.yaml", "{ value: 1, word", "{ vlaue: 1, word", "vlaue", "unknown column `vlaue`")]
#[case("probe/wide.yaml", "{ value: 1, word: enabled", "{ value: 1", "{ value: 1", "this row has no `word`")]
#[case("probe/wide.yaml", "{ value: 1", "{ value: one", "one", "`one` is not what the common suite takes here")]
#[case("probe/wide.yaml", "word: enabled", "word: enabeld", "enabeld", "`enabeld` is no word of `switch`")]
#[case(
    "probe/wide.yaml",
    "covers: [PRB-2], variants: [one]",
    "covers: [PRB-2]",
    "PRB-2",
    "PRB-2 does not apply to the variant two"
)]
#[case(
    "probe/wide.yaml",
    "  table:\n    - { value: 1, word: enabled, covers: [PRB-1] }\n    - { row: only, value: 0, word: disabled, covers: [PRB-2], variants: [one] }\n",
    "",
    "wide",
    "`table` is neither in `covers` nor in `omit`"
)]
#[case(
    "probe/wide.yaml",
    "covers: { more: [PRB-1], follows: [PRB-1] }",
    "covers: { more: [], follows: [PRB-1] }",
    "more: []",
    "`wide/more[usual]` covers nothing"
)]
#[case("probe/wide.yaml", "catches: { more: [stuck] }", "", "more: [PRB", "no bug of this manual makes `more` fail")]
#[case(
    "probe/wide.yaml",
    "catches: { more: [stuck] }",
    "catches: { more: [stuck], table: [stuck] }",
    "stuck] }",
    "names `stuck` already"
)]
#[case(
    "probe/wide.yaml",
    "catches: { more: [stuck] }",
    "catches: { more: [foreign] }",
    "foreign",
    "unknown bug `foreign`"
)]
#[case(
    "common/wide.yaml",
    "catches: [stuck, foreign]",
    "catches: [stuck, foriegn]",
    "foriegn",
    "unknown bug `foriegn`"
)]
#[case("probe/topic.yaml", "catches: [stuck]", "catches: [stuck, foreign]", "foreign", "unknown bug `foreign`")]
#[case("probe/wide.yaml", "id: own\n", "id: table\n", "table", "`table` is a case or rule of the common suite")]
#[case("probe/wide.yaml", "id: own\n", "id: left\n", "left", "`left` is a case or rule of the common suite")]
#[case("probe/wide.yaml", "id: own-rule\n", "id: own\n", "own", "duplicate id `own`")]
#[case("probe/wide.yaml", "P922: 81", "P922: =right", "right", "there is no name `right`")]
#[case(
    "probe/topic.yaml",
    "    with:\n      - { row: on, value: 1, word: enabled }\n      - { row: off, value: 0, word: disabled }\n",
    "    with: { value: { is: number, why: one } }\n",
    "{ value",
    "a table is a list of rows here"
)]
#[case("common/wide.yaml", "word: { is: word", "word: { is: wrod", "wrod", "unknown word for is `wrod`")]
#[case("common/wide.yaml", "why: one }", "wyh: one }", "wyh", "unknown key of an entry of takes `wyh`")]
fn refused(#[case] path: &str, #[case] old: &str, #[case] new: &str, #[case] points_at: &str, #[case] message: &str) {
    refuses(path, old, new, points_at, message);
}

#[test]
fn a_manual_says_which_rows_and_variants_it_has_of_a_common_case() {
    let manuals = load(&sources(), None).expect("it loads");
    let ids = |variant: usize| -> Vec<&str> {
        let trials = &manuals[0].variants[variant].trials;
        trials.iter().filter_map(|trial| trial.id.strip_prefix("wide/")).collect()
    };
    assert_eq!(ids(0), ["table[1]", "table[only]", "own[1]"]);
    assert_eq!(ids(1), ["table[1]", "more[usual]", "more[unusual]", "own[1]"]);
    let trials = &manuals[0].variants[1].trials;
    let more = trials.iter().find(|trial| trial.id == "wide/more[unusual]").expect("it is there");
    assert_eq!((more.covers.as_slice(), more.catches.as_slice()), (&[0][..], &["stuck".to_owned()][..]));
    let rules: Vec<&str> = manuals[0].variants[0].rules.iter().map(|rule| rule.id.as_str()).collect();
    assert_eq!(rules, ["topic/never-both", "topic/parks", "wide/follows", "wide/own-rule"]);
}
