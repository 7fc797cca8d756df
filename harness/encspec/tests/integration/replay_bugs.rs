//! Replay of a recording with a bug names the broken requirement and the packet that shows it.
//!
//! The expected packet is determined here from the bytes of the frames as the manuals describe them, without the code of the judge.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::built_in;
use crate::recordings::trace_file;
use encspec::engine::{DutKind, DutSpec, RunOptions, run_trial};
use encspec::replay::{CaptureFinding, CaptureReport, capture};
use encspec::suite::model::{Manual, SuiteVariant};
use encspec::verdict::Verdict;
use rstest::rstest;

/// A frame of the trace: number from 1, time in ns, bytes.
type TraceRow = (u64, u64, Vec<u8>);

/// A reaction time that no manual prints is ours, 100 ms, and ten times that is tolerated.
const PATIENCE_NS: u64 = 1_000_000_000;

/// Finds the frame that shows a bug.
type FrameFinder = fn(&[TraceRow]) -> Option<u64>;

/// Telegram 81 or 83 on PROFINET: 18 bytes of header and VLAN tag, the frame id, two IOPS, then the data.
mod rt {
    use super::TraceRow;

    /// ZSW2_ENC, G1_ZSW, G1_XIST1, G1_XIST2 of a frame of the device.
    pub fn inputs(row: &TraceRow) -> Option<[u32; 4]> {
        let octets = &row.2;
        let is_input = octets.get(12..14)? == [0x81, 0x00]
            && octets.get(16..20)? == [0x88, 0x92, 0xC0, 0x01]
            && octets.get(20..22)? == [0x80, 0x80];
        is_input.then(|| super::words(octets, 22)).flatten()
    }

    /// STW2_ENC and G1_STW of a frame of the controller.
    pub fn outputs(row: &TraceRow) -> Option<[u32; 2]> {
        let octets = &row.2;
        let is_output = octets.get(16..20)? == [0x88, 0x92, 0xC0, 0x00];
        is_output.then(|| Some([super::number(octets, 20, 2)?, super::number(octets, 22, 2)?])).flatten()
    }
}

fn number(octets: &[u8], at: usize, length: usize) -> Option<u32> {
    Some(octets.get(at..at + length)?.iter().fold(0, |number, octet| number << 8 | u32::from(*octet)))
}

fn words(octets: &[u8], at: usize) -> Option<[u32; 4]> {
    Some([number(octets, at, 2)?, number(octets, at + 2, 2)?, number(octets, at + 4, 4)?, number(octets, at + 8, 4)?])
}

/// The bytes of Slave_Diag: an SD2 frame from SAP 60 of the slave to SAP 62 of the master.
fn diagnosis(row: &TraceRow) -> Option<&[u8]> {
    let octets = &row.2;
    let is_it = octets.first() == Some(&0x68) && octets.get(7..9)? == [0x3E, 0x3C];
    is_it.then(|| octets.get(9..octets.len() - 2)).flatten()
}

/// The same words in Data_Exchange of PROFIBUS: an SD2 frame from the slave to master 1, without SAPs.
fn dp_inputs(row: &TraceRow) -> Option<[u32; 4]> {
    let octets = &row.2;
    let is_it = octets.first() == Some(&0x68) && octets.get(4) == Some(&1) && octets.get(5)? & 0x80 == 0;
    (is_it && octets.len() == 21).then(|| words(octets, 7)).flatten()
}

/// STW2_ENC and G1_STW in Data_Exchange of PROFIBUS: an SD2 frame of master 1 to the slave, without SAPs.
fn dp_outputs(row: &TraceRow) -> Option<[u32; 2]> {
    let octets = &row.2;
    let is_it = octets.first() == Some(&0x68) && octets.get(5) == Some(&1) && octets.get(4)? & 0x80 == 0;
    (is_it && octets.len() == 13).then(|| Some([number(octets, 7, 2)?, number(octets, 9, 2)?])).flatten()
}

/// The last frame of the device within [`PATIENCE_NS`] after a request that it did not answer. A later frame proves the missing
/// answer.
fn late(rows: &[TraceRow], requests: impl Fn([u32; 2]) -> bool, answers: impl Fn([u32; 4]) -> bool) -> Option<u64> {
    let (mut before, mut open, mut last) = (true, None, None);
    for row in rows {
        if let Some(of) = rt::outputs(row).or_else(|| dp_outputs(row)) {
            if requests(of) && !before {
                (open, last) = (Some(row.1), None);
            }
            before = requests(of);
        } else if let Some(of) = rt::inputs(row).or_else(|| dp_inputs(row)) {
            match open {
                Some(_) if answers(of) => open = None,
                Some(since) if row.1 > since + PATIENCE_NS => return last,
                _ => last = Some(row.0),
            }
        }
    }
    None
}

/// The last frame of the device within [`PATIENCE_NS`] after bit 14 of G1_ZSW rose, if one of these bits stays set all that time.
fn parked_with(rows: &[TraceRow], wrong: u32) -> Option<u64> {
    let (mut since, mut last) = (None, None);
    for row in rows {
        let Some([_, g1, ..]) = rt::inputs(row) else { continue };
        if g1 & 0x4000 == 0 || g1 & wrong == 0 {
            (since, last) = (None, None);
        } else if row.1 > *since.get_or_insert(row.1) + PATIENCE_NS {
            return last;
        } else {
            last = Some(row.0);
        }
    }
    None
}

/// The first frame in which the time stamp in these two bytes increased by more than one.
fn stamp(rows: &[TraceRow], at: usize) -> Option<u64> {
    let mut before = None;
    for row in rows {
        let octets = &row.2;
        let is_input = octets.first() == Some(&0x68)
            && octets.get(4) == Some(&1)
            && octets.get(5).is_some_and(|of| of & 0x80 == 0);
        let Some(now) = number(octets, at, 2).filter(|_| is_input) else { continue };
        if before.is_some_and(|before: u32| now != before && now != (before + 1) & 0xFFFF) {
            return Some(row.0);
        }
        before = Some(now);
    }
    None
}

fn first(rows: &[TraceRow], wrong: impl Fn(&TraceRow) -> bool) -> Option<u64> {
    rows.iter().find(|row| wrong(row)).map(|row| row.0)
}

/// The first frame of the device whose ZSW2_ENC, G1_ZSW, G1_XIST1 and G1_XIST2 satisfy `wrong`.
fn input(rows: &[TraceRow], wrong: impl Fn([u32; 4]) -> bool) -> Option<u64> {
    first(rows, |row| rt::inputs(row).or_else(|| dp_inputs(row)).is_some_and(&wrong))
}

/// The first diagnosis that satisfies `wrong`, from the last one before data exchange on. Rules are only judged on a connection.
fn first_diagnosis(rows: &[TraceRow], wrong: impl Fn(&[u8]) -> bool) -> Option<u64> {
    let is_exchange =
        |row: &TraceRow| row.2.first() == Some(&0x68) && row.2.get(4..6).is_some_and(|of| of[0] | of[1] < 0x80);
    let begin = rows.iter().position(is_exchange)?;
    let last = rows.get(..begin)?.iter().rposition(|row| diagnosis(row).is_some())?;
    first(rows.get(last..)?, |row| diagnosis(row).is_some_and(&wrong))
}

/// The first frame in which these bits of G1_ZSW rise later than [`PATIENCE_NS`] after these bits of G1_STW were set, and after the
/// first inputs.
fn rises_without(rows: &[TraceRow], answer: u32, request: u32) -> Option<u64> {
    let (mut before, mut requested) = (0, None);
    for row in rows {
        if rt::outputs(row).is_some_and(|of| of[1] & request != 0) {
            requested = Some(row.1);
        }
        let Some(of) = rt::inputs(row) else { continue };
        let is_late = row.1 > *requested.get_or_insert(row.1) + PATIENCE_NS;
        if of[1] & answer != 0 && before & answer == 0 && is_late {
            return Some(row.0);
        }
        before = of[1];
    }
    None
}

/// The first frame in which bit 9 of ZSW2_ENC, Control Requested, falls.
fn control_ends(rows: &[TraceRow]) -> Option<u64> {
    let mut before = 0;
    for row in rows {
        let Some([z2, ..]) = rt::inputs(row) else { continue };
        if before & 0x0200 != 0 && z2 & 0x0200 == 0 {
            return Some(row.0);
        }
        before = z2;
    }
    None
}

/// The first frame in which these bits of G1_ZSW fall while G1_STW satisfies `condition`.
fn falls_while(rows: &[TraceRow], answer: u32, condition: impl Fn(u32) -> bool) -> Option<u64> {
    let (mut before, mut g1_stw) = (0, 0);
    for row in rows {
        g1_stw = rt::outputs(row).map_or(g1_stw, |of| of[1]);
        let Some(of) = rt::inputs(row) else { continue };
        if of[1] & answer == 0 && before & answer != 0 && condition(g1_stw) {
            return Some(row.0);
        }
        before = of[1];
    }
    None
}

/// The trace of a trial, with the bug, as a file and as rows.
fn recording(
    manual: &Manual,
    variant: &SuiteVariant,
    case: &str,
    bug: Option<&str>,
) -> Option<(Vec<u8>, Vec<TraceRow>)> {
    let trial = variant.trials.iter().find(|trial| trial.id == case)?;
    let kind = DutKind::Model { deviations: bug.map(str::to_owned).into_iter().collect() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run");
    let rows = outcome.trace.iter().zip(1..).map(|(of, number)| (number, of.time.as_nanos(), of.octets.to_vec()));
    // Some bugs break only a rule.
    assert!(outcome.case.verdict == Verdict::Pass || bug.is_some(), "{case} with {bug:?}");
    Some((trace_file(manual, &outcome.trace), rows.collect()))
}

fn of_rules(report: &CaptureReport) -> Vec<&CaptureFinding> {
    report.findings.iter().filter(|finding| !finding.requirements.is_empty()).collect()
}

#[rstest]
#[case::xac77("lika-xac77-profinet", XAC77)]
#[case::amt58("datalogic-amt58-profibus", AMT58)]
#[case::sendix("kuebler-sendix58xx-profinet", SENDIX)]
#[case::a3m60("sick-a3m60-profibus", A3M60)]
#[case::afx60("sick-afx60-profinet", AFX60)]
fn each_bug_is_reported_with_its_requirement_and_packet(
    #[case] manual: &str,
    #[case] bugs: &[(&str, &str, &str, FrameFinder)],
) {
    assert!(bugs.len() >= 10);
    let manuals = built_in::only(manual);
    let manual = &manuals[0];
    let mut missed = Vec::new();
    for &(bug, case, requirement, wrong) in bugs {
        let breaks = &manual.bugs.iter().find(|of| of.name == bug).expect("a bug of the manual").breaks;
        assert!(breaks.iter().any(|&of| manual.requirements[of].id == requirement), "{bug} breaks {requirement}");
        let mut variants = 0;
        for variant in &manual.variants {
            let what = format!("{bug} in {case} of {}", variant.name);
            let Some((conforming, _)) = recording(manual, variant, case, None) else { continue };
            let report = capture("conforming", &conforming[..], manuals).expect("a capture");
            if !of_rules(&report).is_empty() {
                missed.push(format!("{what}: found without the bug: {:?}", of_rules(&report)));
            }
            let (broken, rows) = recording(manual, variant, case, Some(bug)).expect("the same trial");
            let report = capture("broken", &broken[..], manuals).expect("a capture");
            let right = wrong(&rows);
            let found = of_rules(&report);
            let named: Vec<&&CaptureFinding> =
                found.iter().filter(|of| of.requirements.iter().any(|id| id == requirement)).collect();
            match named.first() {
                None => missed.push(format!("{what}: no finding names {requirement}: {:?}", report.findings)),
                Some(of) if right != Some(of.frame) => {
                    missed.push(format!("{what}: {} in packet {}, not {right:?}", of.id, of.frame));
                }
                Some(of) => {
                    assert!(of.clause.is_some() && of.octet.is_some() && of.cause.is_some() && of.next.is_some());
                    assert_eq!(of.context.at.as_ref().map(|at| at.frame), right, "{what}");
                    assert!(!of.context.before.is_empty() && of.ar.is_some(), "{what}: {of:?}");
                    assert_eq!(of.filter.is_some(), manual.device.profinet().is_some());
                }
            }
            variants += 1;
        }
        assert!(variants > 0, "no variant has {case}");
    }
    assert!(missed.is_empty(), "{} of {}:\n{}", missed.len(), bugs.len(), missed.join("\n"));
}

const XAC77: &[(&str, &str, &str, FrameFinder)] = &[
    ("acknowledge-answer-without-request", "sign-of-life/failures-not-tolerated[255]", "XAC77-SIG-030", |rows| {
        rises_without(rows, 0x0800, 0x8000)
    }),
    ("error-clears-itself", "error-acknowledgement/error-is-latched", "XAC77-ACK-003", |rows| {
        falls_while(rows, 0x8000, |g1_stw| g1_stw & 0xC000 == 0)
    }),
    ("error-survives-parking", "parking/clears-errors", "XAC77-PRK-007", |rows| parked_with(rows, 0x8000)),
    ("park-keeps-preset-bit", "parking/clears-the-acknowledgement", "XAC77-PRK-003", |rows| parked_with(rows, 0x1000)),
    ("error-without-code", "error-acknowledgement/error-displaces-the-position[requested]", "XAC77-G1E-009", |rows| {
        input(rows, |[_, g1, _, x2]| g1 & 0x8000 != 0 && ![3, 0x0F02, 0x0F04, 0x1001, 0x1002].contains(&x2))
    }),
    ("life-sign-shown-as-bus-cycle", "error-acknowledgement/error-is-latched", "XAC77-G1E-002", |rows| {
        input(rows, |[_, g1, _, x2]| g1 & 0x8000 != 0 && x2 == 0x0F04)
    }),
    ("missing-synchronization-is-error", "telegrams/free-running", "XAC77-G1E-002", |rows| {
        input(rows, |[_, g1, _, x2]| g1 & 0x8000 != 0 && x2 == 0x0F04)
    }),
    (
        "position-bit-stays-with-error",
        "error-acknowledgement/error-displaces-the-position[requested]",
        "XAC77-SIG-036",
        |rows| input(rows, |[_, g1, ..]| g1 & 0xA000 == 0xA000),
    ),
    ("not-used-bits-mirrored", "telegrams/bits-without-function[g1-0-to-7]", "XAC77-SIG-028", |rows| {
        input(rows, |[_, g1, ..]| g1 & 0x03FF != 0)
    }),
    ("control-requested-follows-control", "start-parameters/compatibility-on[1]", "XAC77-CMP-002", |rows| {
        input(rows, |[z2, ..]| z2 & 0x0200 != 0)
    }),
];

const AMT58: &[(&str, &str, &str, FrameFinder)] = &[
    ("always-one-missing", "diagnosis/after-power-on", "AMT58-DIA-011", |rows| {
        first_diagnosis(rows, |of| of[1] & 0x04 == 0)
    }),
    ("station-non-existent-set", "diagnosis/after-power-on", "AMT58-DIA-001", |rows| {
        first_diagnosis(rows, |of| of[0] & 0x01 != 0)
    }),
    ("invalid-response-set", "diagnosis/after-power-on", "AMT58-DIA-006", |rows| {
        first_diagnosis(rows, |of| of[0] & 0x20 != 0)
    }),
    ("deactivated-set", "diagnosis/after-power-on", "AMT58-DIA-015", |rows| {
        first_diagnosis(rows, |of| of[1] & 0x80 != 0)
    }),
    ("overflow-with-extended-diagnosis", "diagnosis/in-data-exchange[watched-extended]", "AMT58-DIA-016", |rows| {
        first_diagnosis(rows, |of| of[2] & 0x80 != 0)
    }),
    ("ext-diag-always-set", "diagnosis/in-data-exchange[watched]", "AMT58-DIA-004", |rows| {
        first_diagnosis(rows, |of| of[0] & 0x08 != 0 && of.get(7) == Some(&0))
    }),
    ("header-without-itself", "diagnosis/lengths[reduced]", "AMT58-DIA-021", |rows| {
        first_diagnosis(rows, |of| of.len() > 6 && usize::from(of[6]) != of.len() - 6)
    }),
    ("header-of-the-whole", "diagnosis/lengths[reduced]", "AMT58-DIA-022", |rows| {
        first_diagnosis(rows, |of| of.len() > 6 && usize::from(of[6]) != of.len() - 6)
    }),
    ("alarms-uninitialised", "diagnosis/without-a-fault", "AMT58-DIA-023", |rows| {
        first_diagnosis(rows, |of| of.get(7).is_some_and(|alarms| ![0, 0x10].contains(alarms)))
    }),
    ("additional-alarms-uninitialised", "diagnosis/without-a-fault", "AMT58-DIA-040", |rows| {
        first_diagnosis(rows, |of| of.get(16).is_some_and(|&of| of != 0))
    }),
    ("warnings-uninitialised", "diagnosis/without-a-fault", "AMT58-DIA-042", |rows| {
        first_diagnosis(rows, |of| of.get(19..21).is_some_and(|of| of != [0, 0]))
    }),
    ("reserved-bytes-left-over", "diagnosis/without-a-fault", "AMT58-DIA-049", |rows| {
        first_diagnosis(rows, |of| of.get(57..63).is_some_and(|of| of != [0; 6]))
    }),
];

const SENDIX: &[(&str, &str, &str, FrameFinder)] = &[
    ("control-requested-follows-control", "controller/normal-operation", "SENDIX-SIG-004", control_ends),
    ("control-requested-never-set", "signals/acknowledgement-with-an-error", "SENDIX-SIG-004", |rows| {
        late(rows, |of| of[0] & 0x0400 != 0, |of| of[0] & 0x0200 != 0)
    }),
    ("error-code-in-upper-word", "controller/memory-error", "SENDIX-G1E-007", |rows| {
        input(rows, |[_, g1, _, x2]| g1 & 0x8000 != 0 && ![1, 0x20, 0x1002].contains(&x2))
    }),
    ("error-without-code", "position/no-code-in-xist1[sensor]", "SENDIX-SIG-018", |rows| {
        input(rows, |[_, g1, _, x2]| g1 & 0x8000 != 0 && ![1, 0x20, 0x1002].contains(&x2))
    }),
    ("error-codes-combined", "faults/two-errors", "SENDIX-G1E-009", |rows| {
        input(rows, |[_, g1, _, x2]| g1 & 0x8000 != 0 && ![1, 0x20, 0x1002].contains(&x2))
    }),
    ("internal-state-in-status-word", "signals/status-word-in-each-state", "SENDIX-SIG-007", |rows| {
        input(rows, |[z2, ..]| z2 & 0x0DF7 != 0)
    }),
    ("not-used-bits-mirrored", "telegrams/bits-without-function[g1-0-to-10]", "SENDIX-SIG-023", |rows| {
        input(rows, |[_, g1, ..]| g1 & 0x07FF != 0)
    }),
    ("position-bit-stays-with-error", "controller/memory-error", "SENDIX-SIG-019", |rows| {
        input(rows, |[_, g1, ..]| g1 & 0xA000 == 0xA000)
    }),
    ("preset-mode-alone-shifts", "preset-relative/mode-bit-alone", "SENDIX-SIG-016", |rows| {
        rises_without(rows, 0x1000, 0x1000)
    }),
    ("acknowledge-answer-without-request", "signals/hardware-errors[sensor]", "SENDIX-SIG-022", |rows| {
        rises_without(rows, 0x0800, 0x8000)
    }),
];

/// The codes of G1_XIST2 in the manual of the A3M60.
const A3M60_CODES: [u32; 9] = [1, 2, 4, 8, 0x0F02, 0x0F03, 0x0F04, 0x1001, 0x1002];

const A3M60: &[(&str, &str, &str, FrameFinder)] = &[
    ("control-requested-never-set", "signals/control-is-requested", "A3M60-SIG-009", |rows| {
        input(rows, |[z2, ..]| z2 & 0x0200 == 0)
    }),
    ("error-code-in-upper-word", "error-codes/codes[amplitude]", "A3M60-G1E-010", |rows| {
        input(rows, |[_, g1, _, x2]| g1 & 0x8000 != 0 && !A3M60_CODES.contains(&x2))
    }),
    ("error-without-code", "error-codes/codes[amplitude]", "A3M60-G1E-010", |rows| {
        input(rows, |[_, g1, _, x2]| g1 & 0x8000 != 0 && !A3M60_CODES.contains(&x2))
    }),
    ("status-bit-10-shows-motion", "signals/idle-word", "A3M60-SIG-014", |rows| {
        input(rows, |[_, g1, ..]| g1 & 0x07FF != 0)
    }),
    ("parking-ignored", "parking/stays-parked", "A3M60-PRK-001", |rows| {
        late(rows, |of| of[1] & 0x4000 != 0, |of| of[1] & 0x4000 != 0)
    }),
    ("park-never-ends", "parking/stays-parked", "A3M60-PRK-004", |rows| {
        late(rows, |of| of[1] & 0x4000 == 0, |of| of[1] & 0x4000 == 0)
    }),
    ("absolute-value-not-served", "position/on-request", "A3M60-SIG-002", |rows| {
        late(rows, |of| of[1] & 0x2000 != 0, |of| of[1] & 0xA000 != 0)
    }),
    ("internal-state-in-status-word", "parking/stays-parked", "A3M60-SIG-010", |rows| {
        input(rows, |[z2, ..]| z2 & 0x0DFF != 0)
    }),
    ("time-stamp-by-two", "time-stamp/once-a-second", "A3M60-TIM-001", |rows| stamp(rows, 13)),
    ("time-stamp-in-milliseconds", "time-stamp/once-a-second", "A3M60-TIM-001", |rows| stamp(rows, 13)),
];

const AFX60: &[(&str, &str, &str, FrameFinder)] = &[
    ("xist2-one-frame-late", "telegrams/positions-of-one-frame", "AFX60-TLG-018", |rows| {
        input(rows, |[_, g1, x1, x2]| g1 & 0x2000 != 0 && x2 << 2 != x1 && x2 << 14 != x1)
    }),
    ("error-codes-combined", "faults/two-errors", "AFX60-G1E-010", |rows| {
        let known = [0x0001, 0x0F01, 0x0F05, 0x1001, 0x1003, 0x1004];
        input(rows, |[_, g1, _, x2]| g1 & 0x8000 != 0 && !known.contains(&x2))
    }),
    ("position-bit-stays-with-error", "position/code-for-position[requested]", "AFX60-XIST-020", |rows| {
        input(rows, |[_, g1, ..]| g1 & 0xA000 == 0xA000)
    }),
    ("xist2-always-shows-position", "position/without-a-request[telegram_81]", "AFX60-SIG-012", |rows| {
        input(rows, |[_, g1, _, x2]| g1 & 0xA000 == 0 && x2 != 0)
    }),
    ("status-bit-3-shows-error", "faults/shown-in-both-places[status-word]", "AFX60-SIG-010", |rows| {
        input(rows, |[z2, ..]| z2 & 0x0008 != 0)
    }),
    ("not-used-bits-mirrored", "telegrams/bits-without-function[g1-0-to-7]", "AFX60-SIG-019", |rows| {
        input(rows, |[_, g1, ..]| g1 & 0x07FF != 0)
    }),
    ("control-requested-never-set", "telegrams/absolute-value-on-request", "AFX60-SIG-008", |rows| {
        input(rows, |[z2, ..]| z2 & 0x0200 == 0)
    }),
    ("control-requested-follows-control", "telegrams/absolute-value-on-request", "AFX60-SIG-008", |rows| {
        input(rows, |[z2, ..]| z2 & 0x0200 == 0)
    }),
    ("sign-of-life-carries", "telegrams/absolute-value-on-request", "AFX60-SIG-010", |rows| {
        input(rows, |[z2, ..]| z2 & 0x0DFF != 0)
    }),
    ("internal-state-in-status-word", "parking/stays-parked", "AFX60-SIG-010", |rows| {
        input(rows, |[z2, ..]| z2 & 0x0DFF != 0)
    }),
];
