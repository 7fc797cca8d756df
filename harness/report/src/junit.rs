//! The report as JUnit XML, with properties for requirement, clause, level, evidence and findings.
//!
//! JUnit knows success, failure, error and skipped. What does not count is skipped and says why; what is red and no finding
//! about the device is an error.

use super::status::{Light, light, reasons};
use super::words::level;
use plain_text::printable;
use quick_junit::{NonSuccessKind, Property, Report, TestCase, TestCaseStatus, TestSuite};
use results::outcome::{CaseKind, CaseResult, DeviceRun, Finding, RunResult};
use results::verdict::Verdict;
use rustc_hash::FxHashMap;

/// Writes the report.
pub fn junit(result: &RunResult) -> String {
    let mut report = Report::new("encspec");
    for run in &result.runs {
        let clauses: FxHashMap<&str, &str> =
            run.requirements.iter().map(|of| (of.id.as_str(), of.cites.as_str())).collect();
        let mut suite = TestSuite::new(format!("{}/{}", run.dut.device, run.dut.variant));
        suite.add_property(Property::new("dut", printable(&run.dut.spec)));
        suite.add_property(Property::new("identity", printable(&run.dut.identity)));
        if let Some(persona) = &run.persona {
            suite.add_property(Property::new("persona", persona.as_str()));
        }
        run.bugs.iter().for_each(|bug| {
            suite.add_property(Property::new("bug", bug.as_str()));
        });
        run.findings.iter().for_each(|of| {
            let told = format!("{} {}: {}", of.severity.word(), of.id, of.text);
            suite.add_property(Property::new("finding", printable(&told)));
        });
        run.cases.iter().for_each(|of| {
            suite.add_test_case(case(result, run, of, &clauses));
        });
        report.add_test_suite(suite);
    }
    let whole = reasons(result);
    if !whole.is_empty() {
        let mut suite = TestSuite::new("the run as a whole");
        for reason in whole {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_message(printable(&reason)).set_type("run");
            suite.add_test_case(TestCase::new(printable(&reason), status));
        }
        report.add_test_suite(suite);
    }
    // Only a writer that fails can make this fail, and a String is none.
    let mut xml = report.to_string().unwrap_or_default();
    if !xml.ends_with('\n') {
        xml.push('\n');
    }
    xml
}

fn case(result: &RunResult, run: &DeviceRun, of: &CaseResult, clauses: &FxHashMap<&str, &str>) -> TestCase {
    let (class, name) = of.id.rsplit_once('/').unwrap_or(("", &of.id));
    let mut case = TestCase::new(printable(name), status(result, run, of));
    case.set_classname(printable(&class.replace('/', "."))).set_time(of.duration);
    let mut property = |name: &str, value: &str| {
        case.add_property(Property::new(name, printable(value)));
    };
    property("kind", if of.kind == CaseKind::Trial { "case" } else { "rule" });
    property("verdict", of.verdict.word());
    property("level", level(of.level));
    for covered in &of.covers {
        property("requirement", &covered.id);
        if let Some(clause) = clauses.get(covered.id.as_str()) {
            property("clause", clause);
        }
    }
    if of.verdict == Verdict::Fail {
        findings(run, of).for_each(|finding| property("finding", &finding.text));
    }
    if let Some(evidence) = &of.evidence {
        property("evidence", evidence);
    }
    case
}

/// The findings of a case: they are called after it and the reading that is a fault.
fn findings<'a>(run: &'a DeviceRun, of: &CaseResult) -> impl Iterator<Item = &'a Finding> {
    let id = of.id.split_once('/').map_or(of.id.as_str(), |(_, id)| id);
    let case = id.split_once('[').map_or(id, |(case, _)| case).to_owned();
    run.findings.iter().filter(move |of| of.id.rsplit_once(':').is_some_and(|(found_by, _)| found_by == case))
}

fn status(result: &RunResult, run: &DeviceRun, of: &CaseResult) -> TestCaseStatus {
    let reason = of.reason.as_deref().unwrap_or(&of.why);
    let skipped = |message: String| {
        let mut status = TestCaseStatus::skipped();
        status.set_message(printable(&message));
        status
    };
    match (of.verdict, light(result, run, of)) {
        (Verdict::Pass, _) => TestCaseStatus::success(),
        (Verdict::NotApplicable, _) => skipped(reason.to_owned()),
        (verdict, Light::Green) => skipped(format!("{verdict}: {reason}")),
        (verdict, Light::Neutral(why)) => skipped(format!("{verdict}, {why}: {reason}")),
        (verdict, Light::Red) => {
            let device = matches!(verdict, Verdict::Fail | Verdict::Xpass);
            let kind = if device { NonSuccessKind::Failure } else { NonSuccessKind::Error };
            let mut status = TestCaseStatus::non_success(kind);
            status.set_message(printable(reason)).set_type(verdict.word());
            status.set_description(super::console::one(result, run, of));
            status
        }
    }
}
