//! The report as JUnit XML, with properties for requirement, clause, level, evidence and findings.
//!
//! JUnit has success, failure, error and skipped. A result that does not count is skipped, with the reason; a red result that is no
//! finding about the device is an error.

use super::status::{ResultColour, reasons, result_colour};
use super::words::level;
use super::xml::XmlWriter;
use plain_text::printable;
use results::outcome::{CaseKind, CaseResult, DeviceFinding, DeviceRun, RunResult};
use results::verdict::Verdict;
use rustc_hash::FxHashMap;

/// Writes the report.
pub fn junit(result: &RunResult) -> String {
    let runs: Vec<Vec<JunitOutcome>> =
        result.runs.iter().map(|run| run.cases.iter().map(|of| JunitOutcome::of(result, run, of)).collect()).collect();
    let whole: Vec<String> = reasons(result).iter().map(|reason| printable(reason)).collect();
    let of_whole = JunitCounts { tests: whole.len(), failures: whole.len(), ..JunitCounts::default() };
    let all = runs.iter().flatten().fold(of_whole, JunitCounts::and);
    let mut xml = XmlWriter::new();
    let [tests, skipped, errors, failures] = all.texts();
    xml.start(
        "testsuites",
        &[("name", "encspec"), ("tests", &tests), ("skipped", &skipped), ("failures", &failures), ("errors", &errors)],
    );
    for (run, outcomes) in result.runs.iter().zip(&runs) {
        let name = format!("{}/{}", run.dut.device, run.dut.variant);
        let counts = outcomes.iter().fold(JunitCounts::default(), JunitCounts::and);
        suite(&mut xml, &name, counts, &of_device(result, run));
        about(&mut xml, result, run);
        let clauses: FxHashMap<&str, &str> =
            run.requirements.iter().map(|of| (of.id.as_str(), of.cites.as_str())).collect();
        for (of, outcome) in run.cases.iter().zip(outcomes) {
            case(&mut xml, run, of, outcome, &clauses);
        }
        xml.end();
    }
    if !whole.is_empty() {
        suite(&mut xml, "run as a whole", of_whole, &[]);
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
struct JunitCounts {
    tests: usize,
    skipped: usize,
    errors: usize,
    failures: usize,
}

impl JunitCounts {
    fn and(self, outcome: &JunitOutcome) -> JunitCounts {
        let one = |is: bool| usize::from(is);
        JunitCounts {
            tests: self.tests + 1,
            skipped: self.skipped + one(matches!(outcome, JunitOutcome::Skipped { .. })),
            errors: self.errors + one(matches!(outcome, JunitOutcome::Red { element: "error", .. })),
            failures: self.failures + one(matches!(outcome, JunitOutcome::Red { element: "failure", .. })),
        }
    }

    fn texts(self) -> [String; 4] {
        [self.tests, self.skipped, self.errors, self.failures].map(|count| count.to_string())
    }
}

/// Begins a suite; its properties and cases follow.
fn suite(xml: &mut XmlWriter, name: &str, counts: JunitCounts, more: &[(&'static str, String)]) {
    let [tests, skipped, errors, failures] = counts.texts();
    let mut attributes =
        vec![("name", name), ("tests", &tests), ("skipped", &skipped), ("errors", &errors), ("failures", &failures)];
    attributes.extend(more.iter().map(|(name, value)| (*name, value.as_str())));
    xml.start("testsuite", &attributes);
}

/// The attributes of the suite of a device: the duration of its cases, and of a live run when and where it was.
fn of_device(result: &RunResult, run: &DeviceRun) -> Vec<(&'static str, String)> {
    let time: f64 = run.cases.iter().map(|case| case.duration.as_secs_f64()).sum();
    let mut more = vec![("time", format!("{time:.3}"))];
    // JUnit has no time zone; the time is UTC.
    let started = result.origin.started.as_deref().map(|started| started.trim_end_matches('Z').to_owned());
    more.extend(started.map(|started| ("timestamp", started)));
    more.extend(result.origin.host.clone().map(|host| ("hostname", printable(&host))));
    more
}

/// The properties of a run.
fn about(xml: &mut XmlWriter, result: &RunResult, run: &DeviceRun) {
    xml.start("properties", &[]);
    let commit = result.origin.commit.iter().map(|commit| format!(" ({commit})"));
    property(xml, "encspec", &format!("{}{}", env!("CARGO_PKG_VERSION"), commit.collect::<String>()));
    property(xml, "gate", if result.gate_must { "must" } else { "should" });
    if let Some(part) = result.part {
        property(xml, "part", &part.to_string());
    }
    result.filters.iter().for_each(|filter| property(xml, "filter", filter));
    property(xml, "dut", &run.dut.spec);
    property(xml, "identity", &run.dut.identity);
    if let Some(firmware) = &run.dut.firmware {
        property(xml, "firmware", firmware);
    }
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

fn case(
    xml: &mut XmlWriter,
    run: &DeviceRun,
    of: &CaseResult,
    outcome: &JunitOutcome,
    clauses: &FxHashMap<&str, &str>,
) {
    let (class, name) = of.id.rsplit_once('/').unwrap_or(("", &of.id));
    let (name, class) = (printable(name), printable(&class.replace('/', ".")));
    let time = format!("{:.3}", of.duration.as_secs_f64());
    xml.start("testcase", &[("name", &name), ("classname", &class), ("time", &time)]);
    xml.start("properties", &[]);
    property(xml, "kind", if of.kind == CaseKind::Trial { "case" } else { "rule" });
    property(xml, "verdict", of.verdict.word());
    property(xml, "level", level(of.level));
    if let Some(attempt) = of.passed_in_attempt {
        property(xml, "flaky", &format!("it passed in attempt {attempt}"));
    }
    for covered in &of.covers {
        property(xml, "requirement", &covered.id);
        if let Some(clause) = clauses.get(covered.id.as_str()) {
            property(xml, "clause", clause);
        }
    }
    if of.verdict == Verdict::Fail {
        findings(run, of).for_each(|finding| property(xml, "finding", &finding.text));
    }
    of.notes.iter().for_each(|note| property(xml, "note", note));
    if let Some(evidence) = &of.evidence {
        property(xml, "evidence", evidence);
    }
    xml.end();
    match outcome {
        JunitOutcome::Passed => {}
        JunitOutcome::Skipped { message } => xml.empty("skipped", &[("message", message)]),
        JunitOutcome::Red { element, kind, message, text } => {
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
enum JunitOutcome {
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

impl JunitOutcome {
    fn of(result: &RunResult, run: &DeviceRun, of: &CaseResult) -> JunitOutcome {
        let reason = of.reason.as_deref().unwrap_or(&of.why);
        let skipped = |message: String| JunitOutcome::Skipped { message: printable(&message) };
        match (of.verdict, result_colour(result, run, of)) {
            (Verdict::Pass, _) => JunitOutcome::Passed,
            (Verdict::NotApplicable, ResultColour::Green | ResultColour::Neutral(_)) => skipped(reason.to_owned()),
            (verdict, ResultColour::Green) => skipped(format!("{verdict}: {reason}")),
            (verdict, ResultColour::Neutral(why)) => skipped(format!("{verdict}, {why}: {reason}")),
            (verdict, ResultColour::Red) => {
                let device = matches!(verdict, Verdict::Fail | Verdict::Xpass);
                JunitOutcome::Red {
                    element: if device { "failure" } else { "error" },
                    kind: verdict.word(),
                    message: printable(reason),
                    text: super::console::failed_case(result, run, of),
                }
            }
        }
    }
}
