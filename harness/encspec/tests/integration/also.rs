//! `also` in `device.yaml`: a manual uses the topics of a suite for any device too.

use crate::built_in::{self, manuals};
use crate::small_manual::{DEVICE, profinet};
use encspec::engine::{RunOptions, run_trial};
use encspec::suite::model::{GenericSuite, Manual, RequirementClass};
use encspec::suite_yaml::{LoadErrors, load};
use encspec::verdict::Verdict;
use rstest::rstest;
use std::collections::BTreeSet;

/// The other suite: a topic with a table and a case, and one that the small manual has as well.
const REQUIREMENTS: &str = "
source: profile
channel: acyclic
requirements:
  - { id: ANY-1, cites: p. 1, statement: One., level: should }
  - { id: ANY-2, cites: p. 2, statement: Two., level: should }
  - { id: ANY-3, cites: p. 3, statement: Three., level: should }
  - { id: ANY-4, cites: p. 4, statement: Four., level: should }
";
const EXTRA: &str = "
suite: extra
use: extra
give: { module: plain, right: 5 }
covers: { single: [ANY-1] }
rows:
  table:
    - { row: first, value: 1, covers: [ANY-2], catches: [bug-of-the-other] }
    - { row: second, value: 2, covers: [ANY-3] }
omit: {}
";
const COMMON: &str = "
common: extra
why: For all.
takes:
  module: { is: word, why: the module }
  right: { is: number, why: what P922 reads }
cases:
  - id: single
    why: It reads.
    start: { module: =module }
    steps:
      - read: { P922: =right }
  - id: table
    why: It reads what the row says.
    catches: [bug-of-the-other]
    with: { value: { is: number, why: what P922 reads } }
    start: { module: =module }
    steps:
      - read: { P922: =value }
";
const TOPIC: &str = "
suite: topic
cases:
  - { id: other, why: It reads., covers: [ANY-4], start: { module: plain }, steps: [{ read: { P922: 7 } }] }
";

fn probe(also: &str) -> Result<Manual, LoadErrors> {
    let sources = profinet()
        .with("probe/device.yaml", format!("{DEVICE}\n{also}"))
        .with("any/device.yaml", DEVICE.replace("device: probe", "device: any"))
        .with("any/requirements.yaml", REQUIREMENTS)
        .with("any/extra.yaml", EXTRA)
        .with("any/topic.yaml", TOPIC)
        .with("any/bugs.yaml", "bugs: { bug-of-the-other: [ANY-1] }")
        .with("common/extra.yaml", COMMON);
    load(&sources, Some("probe")).map(|mut manuals| manuals.pop().expect("it is there"))
}

const USED: &str = "
also:
  any:
    give: { module: long, right: 81 }
    except:
      topic: the manual has its own
      extra/table[second]: no such value
";

#[test]
fn topics_come_with_their_requirements_and_what_is_left_out_says_why() {
    let manual = probe(USED).unwrap_or_else(|errors| panic!("it loads:\n{errors}"));
    let suite = &manual.also[0];
    assert_eq!((suite.name.as_str(), suite.topics.as_slice()), ("any", &["extra".to_owned()][..]));
    let taken: Vec<&str> =
        manual.variants[0].trials.iter().filter(|of| !manual.is_own(of)).map(|of| of.id.as_str()).collect();
    assert_eq!(taken, ["extra/single", "extra/table[first]"]);
    let trial = manual.variants[0].trials.iter().find(|of| of.id == "extra/single").expect("it is taken");
    assert_eq!(manual.device.modules[trial.start().expect("a connection").module].name, "long");
    assert!(trial.how().steps[0].text.contains("81"), "{}", trial.how().steps[0].text);
    assert!(manual.variants[0].trials.iter().filter(|of| !manual.is_own(of)).all(|of| of.catches.is_empty()));
    let classes: Vec<(&str, &RequirementClass)> =
        manual.requirements[suite.requirements.clone()].iter().map(|of| (of.id.as_str(), &of.class)).collect();
    let out = |why: &str| RequirementClass::OutOfScope(why.to_owned());
    assert_eq!(
        classes,
        [
            ("ANY-1", &RequirementClass::Testable),
            ("ANY-2", &RequirementClass::Testable),
            ("ANY-3", &out("no such value")),
            ("ANY-4", &out("the manual has its own")),
        ]
    );
}

#[rstest]
#[case::suite("  any:", "  anq:", "unknown suite `anq`", "did you mean `any`?")]
#[case::topic(
    "      topic:",
    "      extrq: not here\n      topic:",
    "unknown topic of `any` `extrq`",
    "did you mean `extra`?"
)]
#[case::case_of_a_topic("extra/table[second]", "extra/tablq", "`any` has no case or row `extra/tablq`", "")]
#[case::row("[second]", "[secqnd]", "`any` has no case or row `extra/table[secqnd]`", "")]
#[case::same_topic(
    "      topic: the manual has its own\n",
    "",
    "both have a topic `topic`",
    "leave it out with the reason"
)]
#[case::given_in_vain("right: 81", "right: 81, left: 1", "no topic that is taken of `any` is given `left`", "")]
#[case::unknown_module("module: long", "module: lonq", "unknown module `lonq`", "did you mean `long`?")]
#[case::without_a_clause(
    "    except:",
    "    contradicted: { extra/single: { why: it is so } }\n    except:",
    "`cites`",
    ""
)]
fn mistakes_are_reported(#[case] text: &str, #[case] instead: &str, #[case] message: &str, #[case] help: &str) {
    assert!(USED.contains(text), "{text}");
    let errors = probe(&USED.replacen(text, instead, 1)).err().map(|errors| errors.to_string()).unwrap_or_default();
    assert!(errors.contains(message) && errors.contains(help), "{errors}");
}

fn encoders() -> impl Iterator<Item = (&'static Manual, &'static GenericSuite)> {
    manuals().iter().filter_map(|manual| Some((manual, manual.also.first()?)))
}

/// Whatever an encoder does not leave out is run as it stands in the suite for any PROFINET device.
#[test]
fn each_encoder_on_profinet_runs_the_suite_for_any_device() {
    let generic = manuals().iter().find(|manual| manual.device.name == "profinet-io").expect("a built-in suite");
    let all: BTreeSet<&str> = generic.variants[0].trials.iter().map(|trial| trial.id.as_str()).collect();
    let mut using = Vec::new();
    for (manual, suite) in encoders() {
        using.push(manual.device.name.as_str());
        let is_left_out = |id: &str| {
            let case = id.split('[').next().unwrap_or(id);
            let topic = id.split('/').next().unwrap_or(id);
            suite.except.iter().any(|of| [id, case, topic].contains(&of.what.as_str()))
        };
        let expected: BTreeSet<&str> = all.iter().copied().filter(|id| !is_left_out(id)).collect();
        for variant in &manual.variants {
            let taken = variant.trials.iter().filter(|trial| !manual.is_own(trial));
            assert_eq!(taken.map(|trial| trial.id.as_str()).collect::<BTreeSet<&str>>(), expected, "{}", variant.name);
        }
        assert!(expected.len() > 400, "{}: {}", manual.device.name, expected.len());
    }
    assert_eq!(using, ["kuebler-sendix58xx-profinet", "lika-xac77-profinet", "sick-afx60-profinet"]);
}

/// The bugs of the suite are proven with its own reference device; those of the stack can be tried with an encoder too.
#[rstest]
#[case("echo-cut-short", "protocol-ping/echo[ordinary]")]
#[case("labels-of-60-at-most", "protocol-station/valid-names[label-of-63]")]
fn a_bug_of_the_suite_can_be_tried_with_an_encoder(#[case] bug: &str, #[case] trial: &str) {
    for (manual, _) in encoders() {
        let variant = &manual.variants[0];
        let trial = variant.trials.iter().find(|of| of.id == trial).expect("it is taken");
        let verdict = |bugs: &[&str]| {
            let dut = built_in::model(manual, variant, bugs);
            run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run").case.verdict
        };
        assert_eq!((verdict(&[]), verdict(&[bug])), (Verdict::Pass, Verdict::Fail), "{}", manual.device.name);
    }
}

/// No requirement is lost: one that is not covered says why.
#[test]
fn each_requirement_that_no_case_of_an_encoder_covers_says_why() {
    for (manual, suite) in encoders() {
        let covered = encspec::suite::reach::of_requirements(manual);
        let silent: Vec<&str> = suite
            .requirements
            .clone()
            .filter(|&index| covered[index].is_none() && manual.requirements[index].class == RequirementClass::Testable)
            .map(|index| manual.requirements[index].id.as_str())
            .collect();
        assert!(silent.is_empty(), "{}: {silent:?}", manual.device.name);
    }
}
