//! The report as JUnit XML, with properties for requirement, clause, level, evidence and findings.
//!
//! JUnit has success, failure, error and skipped. A result that does not count is skipped, with the reason; a red result that is no
//! finding about the device is an error.

use super::status::{Light, light, reasons};
use super::words::level;
use super::xml::XmlWriter;
use plain_text::printable;
use results::outcome::{CaseKind, CaseResult, DeviceFinding, DeviceRun, RunResult};
use results::verdict::Verdict;
use rustc_hash::FxHashMap;

/// Writes the report.
pub fn junit(result: &RunResult) -> String {
    let runs: Vec<Vec<Outcome>> =
        result.runs.iter().map(|run| run.cases.iter().map(|of| Outcome::of(result, run, of)).collect()).collect();
    let whole: Vec<String> = reasons(result).iter().map(|reason| printable(reason)).collect();
    let of_whole = Counts { tests: whole.len(), failures: whole.len(), ..Counts::default() };
    let all = runs.iter().flatten().fold(of_whole, Counts::and);
    let mut xml = XmlWriter::new();
    let [tests, skipped, errors, failures] = all.texts();
    xml.start(
        "testsuites",
        &[("name", "encspec"), ("tests", &tests), ("skipped", &skipped), ("failures", &failures), ("errors", &errors)],
    );
    for (run, outcomes) in result.runs.iter().zip(&runs) {
        let name = format!("{}/{}", run.dut.device, run.dut.variant);
        suite(&mut xml, &name, outcomes.iter().fold(Counts::default(), Counts::and));
        about(&mut xml, run);
        let clauses: FxHashMap<&str, &str> =
            run.requirements.iter().map(|of| (of.id.as_str(), of.cites.as_str())).collect();
        for (of, outcome) in run.cases.iter().zip(outcomes) {
            case(&mut xml, run, of, outcome, &clauses);
        }
        xml.end();
    }
    if !whole.is_empty() {
        suite(&mut xml, "run as a whole", of_whole);
        for reason in &whole {
            xml.start("testcase", &[("name", reason)]);
            xml.empty("failure", &[("message", reason), ("type", "run")]);
            xml.end();
        }
        xml.end();
    }
    xml.finish()
}

/// The number of results in a suite or in the report.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    tests: usize,
    skipped: usize,
    errors: usize,
    failures: usize,
}

impl Counts {
    fn and(self, outcome: &Outcome) -> Counts {
        let one = |is: bool| usize::from(is);
        Counts {
            tests: self.tests + 1,
            skipped: self.skipped + one(matches!(outcome, Outcome::Skipped { .. })),
            errors: self.errors + one(matches!(outcome, Outcome::Red { element: "error", .. })),
            failures: self.failures + one(matches!(outcome, Outcome::Red { element: "failure", .. })),
        }
    }

    fn texts(self) -> [String; 4] {
        [self.tests, self.skipped, self.errors, self.failures].map(|count| count.to_string())
    }
}

/// Begins a suite; its properties and cases follow.
fn suite(xml: &mut XmlWriter, name: &str, counts: Counts) {
    let [tests, skipped, errors, failures] = counts.texts();
    xml.start(
        "testsuite",
        &[("name", name), ("tests", &tests), ("skipped", &skipped), ("errors", &errors), ("failures", &failures)],
    );
}

/// The properties of a run.
fn about(xml: &mut XmlWriter, run: &DeviceRun) {
    xml.start("properties", &[]);
    property(xml, "dut", &run.dut.spec);
    property(xml, "identity", &run.dut.identity);
    if let Some(persona) = &run.persona {
        property(xml, "persona", persona);
    }
    run.bugs.iter().for_each(|bug| property(xml, "bug", bug));
    run.variations.iter().for_each(|variation| property(xml, "variation", variation));
    for of in &run.findings {
        property(xml, "finding", &format!("{} {}: {}", of.severity.word(), of.id, of.text));
    }
    xml.end();
}

fn property(xml: &mut XmlWriter, name: &str, value: &str) {
    xml.empty("property", &[("name", name), ("value", &printable(value))]);
}

fn case(xml: &mut XmlWriter, run: &DeviceRun, of: &CaseResult, outcome: &Outcome, clauses: &FxHashMap<&str, &str>) {
    let (class, name) = of.id.rsplit_once('/').unwrap_or(("", &of.id));
    let (name, class) = (printable(name), printable(&class.replace('/', ".")));
    let time = format!("{:.3}", of.duration.as_secs_f64());
    xml.start("testcase", &[("name", &name), ("classname", &class), ("time", &time)]);
    xml.start("properties", &[]);
    property(xml, "kind", if of.kind == CaseKind::Trial { "case" } else { "rule" });
    property(xml, "verdict", of.verdict.word());
    property(xml, "level", level(of.level));
    for covered in &of.covers {
        property(xml, "requirement", &covered.id);
        if let Some(clause) = clauses.get(covered.id.as_str()) {
            property(xml, "clause", clause);
        }
    }
    if of.verdict == Verdict::Fail {
        findings(run, of).for_each(|finding| property(xml, "finding", &finding.text));
    }
    if let Some(evidence) = &of.evidence {
        property(xml, "evidence", evidence);
    }
    xml.end();
    match outcome {
        Outcome::Passed => {}
        Outcome::Skipped { message } => xml.empty("skipped", &[("message", message)]),
        Outcome::Red { element, kind, message, text } => {
            xml.text(element, &[("message", message), ("type", kind)], text);
        }
    }
    xml.end();
}

/// The findings of a case: their ids consist of its id and the reading.
fn findings<'a>(run: &'a DeviceRun, of: &CaseResult) -> impl Iterator<Item = &'a DeviceFinding> {
    let id = of.id.split_once('/').map_or(of.id.as_str(), |(_, id)| id);
    let case = id.split_once('[').map_or(id, |(case, _)| case).to_owned();
    run.findings.iter().filter(move |of| of.id.rsplit_once(':').is_some_and(|(found_by, _)| found_by == case))
}

/// The JUnit result of a case.
#[derive(Debug)]
enum Outcome {
    Passed,
    Skipped {
        message: String,
    },
    /// The element is `failure` or `error`.
    Red {
        element: &'static str,
        kind: &'static str,
        message: String,
        text: String,
    },
}

impl Outcome {
    fn of(result: &RunResult, run: &DeviceRun, of: &CaseResult) -> Outcome {
        let reason = of.reason.as_deref().unwrap_or(&of.why);
        let skipped = |message: String| Outcome::Skipped { message: printable(&message) };
        match (of.verdict, light(result, run, of)) {
            (Verdict::Pass, _) => Outcome::Passed,
            (Verdict::NotApplicable, _) => skipped(reason.to_owned()),
            (verdict, Light::Green) => skipped(format!("{verdict}: {reason}")),
            (verdict, Light::Neutral(why)) => skipped(format!("{verdict}, {why}: {reason}")),
            (verdict, Light::Red) => {
                let device = matches!(verdict, Verdict::Fail | Verdict::Xpass);
                Outcome::Red {
                    element: if device { "failure" } else { "error" },
                    kind: verdict.word(),
                    message: printable(reason),
                    text: super::console::one(result, run, of),
                }
            }
        }
    }
}
