//! A hand-made run with one result of each kind, for tests of the reports.

use encspec::result::{
    CaseFailure, CaseKind, CaseResult, Covered, DecisionCounts, DescriptionKind, DeviceFinding, DeviceRun, Dut,
    FailureCause, FailurePosition, FindingSeverity, JudgedPart, RequirementResult, RunResult,
};
use encspec::suite::Location;
use encspec::suite::model::Level;
use encspec::verdict::Verdict;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// A location in a suite.
pub fn at(line: u32) -> Location {
    Location { file: Arc::new(PathBuf::from("suites/acme-profinet/preset.yaml")), line, column: 9 }
}

/// A case with this verdict and level that covers `ACME-001`.
pub fn case(id: &str, kind: CaseKind, verdict: Verdict, level: Level) -> CaseResult {
    let why = format!("The sentence of {id}.");
    CaseResult {
        covers: vec![Covered { requirement: 0, id: "ACME-001".into(), verdict }],
        duration: Duration::from_millis(1500),
        frames: 120,
        ..CaseResult::new(format!("acme-profinet/{id}"), kind, why, (verdict, level), at(7))
    }
}

/// A failure of the step `expect: { position: 0x1000 }`.
pub fn failure() -> CaseFailure {
    CaseFailure {
        blame: FailureCause::Device,
        what: "It did not become true in time.".into(),
        step: "expect: { status.done: 1, position: 0x1000 }".into(),
        at: at(12),
        requirements: vec![(
            "ACME-001".into(),
            "section 3.1 (p. 9)".into(),
            "The position takes the preset value.".into(),
        )],
        parts: vec![
            JudgedPart {
                text: "status.done: 1".into(),
                expected: "0x1 (1)".into(),
                observed: "0x1 (1)".into(),
                held: true,
            },
            JudgedPart {
                text: "position: 0x1000".into(),
                expected: "0x1000 (4096)".into(),
                observed: "0x1001 (4097)".into(),
                held: false,
            },
        ],
        place: Some(FailurePosition { frame: 41, octet: Some(26), bit: Some(3), filter: "frame.number == 41".into() }),
        trace: vec!["     40 1.500  out".into(), ">    41 1.502  in".into()],
        next: "Compare frame 41 with the clause.".into(),
        before_test: false,
    }
}

/// A requirement with this verdict that these cases cover.
pub fn requirement(number: u32, clause: &str, level: Level, verdict: Verdict, cases: &[&str]) -> RequirementResult {
    RequirementResult {
        id: format!("ACME-{number:03}"),
        chapter: clause.strip_prefix("section 3.").map(|_| "3 position".into()),
        cites: clause.into(),
        statement: format!("Statement number {number} of the manual."),
        level,
        verdict,
        note: cases.is_empty().then(|| "no case covers it in this run".into()),
        cases: cases.iter().map(|id| format!("acme-profinet/{id}")).collect(),
    }
}

/// A run of one device with these cases.
pub fn run(cases: Vec<CaseResult>) -> RunResult {
    let device = DeviceRun {
        dut: Dut {
            kind: "model".into(),
            spec: "model:acme-profinet/single".into(),
            device: "acme-profinet".into(),
            variant: "single".into(),
            identity: "ACME ROTO (vendor 0x0123, device 0x0001)".into(),
            firmware: None,
            details: Vec::new(),
        },
        cases,
        requirements: Vec::new(),
        filtered: false,
        persona: None,
        bugs: Vec::new(),
        variations: Vec::new(),
        bug_notes: Vec::new(),
        findings: Vec::new(),
        causes: Vec::new(),
        bus: None,
    };
    RunResult { runs: vec![device], ..RunResult::default() }
}

/// One result of each kind, with all optional parts.
pub fn everything() -> RunResult {
    let trial = |id: &str, verdict, level| case(id, CaseKind::Trial, verdict, level);
    let mut passed = trial("preset/absolute", Verdict::Pass, Level::Must);
    passed.readings = vec![("either: { stays: [...], moves: [...] }".into(), "stays".into())];
    passed.saved = vec![("before".into(), "4096".into())];
    let mut failed = trial("preset/it's[row 1]", Verdict::Fail, Level::Must);
    failed.reason = Some("It did not become true in time.".into());
    failed.failures = vec![failure()];
    failed.notes = vec!["unexpected alarm in frame 43".into()];
    failed.evidence = Some("evidence/acme-profinet_single_preset_it_s[row_1].pcapng".into());
    let mut inconclusive = trial("preset/inconclusive", Verdict::Inconclusive, Level::Must);
    inconclusive.reason = Some("No station answered.".into());
    let mut excluded = trial("preset/by-hand", Verdict::NotApplicable, Level::Should);
    excluded.reason = Some("stand cannot press the preset button".into());
    let mut broken = trial("preset/broken", Verdict::Error, Level::Should);
    broken.reason = Some("The value to be set is unknown.".into());
    let mut known = trial("preset/known", Verdict::Xfail, Level::Must);
    known.reason = Some("known failure FW-7: the position is late".into());
    known.failures = vec![failure()];
    let mut gone = trial("preset/gone", Verdict::Xpass, Level::Must);
    gone.reason = Some("The test passes, but ledger entry FW-8 expects a failure: remove the entry.".into());
    let mut info = trial("preset/info", Verdict::Fail, Level::Info);
    info.reason = Some("It did not become true in time.".into());
    info.failures = vec![CaseFailure { place: None, parts: Vec::new(), trace: Vec::new(), ..failure() }];
    let mut rule = case("rules/never-both", CaseKind::Rule, Verdict::Pass, Level::Must);
    rule.decided = Some(DecisionCounts { premises: 12, undecided: 1, checked: 4312 });
    let mut unseen = case("rules/never-seen", CaseKind::Rule, Verdict::NotRun, Level::Must);
    unseen.reason = Some("the premise never occurred in 4312 frames and events".into());
    unseen.decided = Some(DecisionCounts { premises: 0, undecided: 0, checked: 4312 });
    let cases = vec![passed, failed, inconclusive, excluded, broken, known, gone, info, rule, unseen];
    let ids: Vec<String> = cases.iter().map(|case| case.id.replacen("acme-profinet/", "", 1)).collect();
    let ids: Vec<&str> = ids.iter().map(String::as_str).collect();
    let mut result = run(cases);
    result.runs[0].requirements = vec![
        requirement(1, "section 3.1 (p. 9)", Level::Must, Verdict::Fail, &ids),
        requirement(2, "section 3.1 (p. 9)", Level::Should, Verdict::NotRun, &[]),
        requirement(3, "section 3.2 (p. 10)", Level::Info, Verdict::NotRun, &[]),
    ];
    result.runs[0].bugs = vec!["preset-late".into()];
    let finding = |id: &str, severity, text: &str, device: Option<&str>| DeviceFinding {
        id: id.into(),
        severity,
        text: text.into(),
        manual: Some("16 octets".into()),
        description: Some((DescriptionKind::Gsdml, "14 octets".into())),
        device: device.map(Into::into),
    };
    result.runs[0].findings = vec![
        finding("record_0x64", FindingSeverity::Info, "The manual does not have the record 0x64.", None),
        finding("telegram_83.inputs", FindingSeverity::Error, "Input data: the two disagree.", Some("16\u{9b} octets")),
    ];
    result.runs[0].dut.identity = "ACME\u{1b}[31m \u{202e}ROTO (vendor 0x0123, device 0x0001)".into();
    result
}
