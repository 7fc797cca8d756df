//! Words shared by all reports; texts from devices are escaped.

use plain_text::{count, printable, steers};
use results::outcome::{
    BitTimeRange, BusStatistics, CaseResult, DeviceFinding, DeviceRun, FindingSeverity, ProbableCause, RunResult,
};
use std::fmt::Write as _;
use suite::model::Level;

/// The word of a level: `must`, `should`, `info`.
pub fn level(level: Level) -> &'static str {
    match level {
        Level::Must => "must",
        Level::Should => "should",
        Level::Info => "info",
    }
}

/// JSON in which every character that could control a terminal is written as a number; its value stays the same.
pub(super) fn printable_json(json: &str) -> String {
    let mut printable = String::with_capacity(json.len());
    for c in json.chars() {
        // Outside of strings JSON has no such character but the line feed; all of them have four hexadecimal digits.
        if steers(c) && c != '\n' {
            printable.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            printable.push(c);
        }
    }
    printable
}

/// A finding in full: what disagrees, and the values of manual, description and device; each line is indented by two.
pub fn finding(of: &DeviceFinding) -> String {
    let mut text = format!("  {} {}: {}\n", of.severity.word(), printable(&of.id), printable(&of.text));
    if of.parties().all(|(_, said)| said.is_none()) {
        return text;
    }
    for (who, said) in of.parties() {
        let said = said.map_or_else(|| "no value".to_owned(), printable);
        // Writing into a String cannot fail.
        let _ = writeln!(text, "    {who:<10} {said}");
    }
    text
}

/// What a group of failures is: one failure, or several that probably have one cause.
pub(super) fn kind_of_cause(cause: &ProbableCause) -> &'static str {
    if cause.cases.len() == 1 { "one failure" } else { "probably one cause" }
}

/// What all failures of a group need: `all need procedure preset`; `None` if they have nothing in common.
pub(super) fn common_need(cause: &ProbableCause) -> Option<String> {
    (!cause.common.is_empty()).then(|| format!("all need {}", cause.common.join(", ")))
}

/// The number of findings, in all and by severity.
pub(super) fn severities(findings: &[DeviceFinding]) -> String {
    let of = |severity| (findings.iter().filter(|of| of.severity == severity).count(), severity);
    let each = [FindingSeverity::Error, FindingSeverity::Warning, FindingSeverity::Info].map(of);
    let parts: Vec<String> =
        each.iter().filter(|(n, _)| *n > 0).map(|(n, severity)| format!("{n} {}", severity.word())).collect();
    if parts.is_empty() { "none".into() } else { format!("{}: {}", findings.len(), parts.join(", ")) }
}

/// The command that runs `case` alone on the same device.
pub fn reproduce(result: &RunResult, run: &DeviceRun, case: &CaseResult) -> String {
    let mut line = String::from("encspec run");
    let mut add = |argument: &str| {
        // Writing into a String cannot fail.
        let _ = write!(line, " {}", quoted(argument));
    };
    result.repeat.iter().for_each(|argument| add(argument));
    add("--dut");
    add(&run.dut.spec);
    // A bench file itself says which device it is.
    if run.dut.kind != "model" && !run.dut.spec.ends_with(".yaml") && !run.dut.spec.ends_with(".yml") {
        add("--device");
        add(&format!("{}/{}", run.dut.device, run.dut.variant));
    }
    if let Some(persona) = &run.persona {
        add("--persona");
        add(persona);
    }
    for bug in &run.bugs {
        add("--bug");
        add(bug);
    }
    for variation in &run.variations {
        add("--vary");
        add(variation);
    }
    add(&case.id);
    add("--exact");
    line
}

/// An argument quoted for a POSIX shell.
fn quoted(argument: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+@%".contains(c);
    if !argument.is_empty() && argument.chars().all(plain) {
        return argument.to_owned();
    }
    format!("'{}'", printable(argument).replace('\'', "'\\''"))
}

/// What the master measured on PROFIBUS in at most two lines: the station with the most answers, and the rotation of the token.
pub(super) fn bus_lines(bus: &BusStatistics) -> Vec<String> {
    let range = |range: &BitTimeRange| {
        let [least, mean, most] = range.least_mean_most()?.map(|bits| bits.0);
        Some(format!("{least}/{mean}/{most} bits"))
    };
    let mut lines = Vec::new();
    let first = bus.stations().iter().max_by_key(|of| (of.answers.count(), std::cmp::Reverse(of.station)));
    if let Some(of) = first {
        let mut line = format!("station {}: ", of.station);
        match range(&of.answers) {
            Some(answers) => {
                let _ =
                    write!(line, "answers after {answers} (min/mean/max; TSDR {} to {}", bus.tsdr.0.0, bus.tsdr.1.0);
                line += &if of.late > 0 { format!(", {} later)", of.late) } else { ")".to_owned() };
            }
            None => line += "no answer",
        }
        let _ = write!(line, ", {}", count(number(of.retries), "retry", "retries"));
        let others = bus.stations().len() - 1;
        if others > 0 {
            let _ = write!(line, "; {}", count(others, "more address asked", "more addresses asked"));
        }
        lines.push(line);
    }
    lines.extend(range(&bus.rotation).map(|of| format!("token rotation {of} (min/mean/max)")));
    lines
}

fn number(of: u64) -> usize {
    usize::try_from(of).unwrap_or(usize::MAX)
}
