//! The report for the terminal: a block for each device, every failure in full, and a summary at the end.

use super::status::{ExitStatus, ResultColour, reasons, result_colour, status};
use super::text::totals;
use super::words::{bus_lines, common_need, finding, kind_of_cause, level, printable_json, reproduce};
use plain_text::{count, printable};
use results::ledger;
use results::outcome::{
    CaseFailure, CaseKind, CaseResult, DeviceFinding, DeviceRun, FailureCause, FindingSeverity, RunResult, TestedShare,
};
use results::verdict::Verdict;
use rustc_hash::{FxHashMap, FxHashSet};
use std::fmt::Write as _;

/// The options of the report.
#[derive(Clone, Copy, Debug, Default)]
pub struct ConsoleOptions {
    /// Whether colours are used.
    pub colour: bool,
    /// Whether every case is listed, in the order of the suite.
    pub verbose: bool,
    /// Whether only what is red and the last line are written.
    pub quiet: bool,
}

/// Upper limit of the ids listed for a group of cases with the same result; the rest is counted.
const SHOWN: usize = 4;
/// How many lines of the bench file are named that would make cases applicable.
const LINES: usize = 3;

/// Writes the report.
pub fn console(result: &RunResult, look: ConsoleOptions) -> String {
    let mut page = ConsoleWriter { out: String::new(), look };
    // Writing into a String cannot fail.
    let _ = page.whole(result);
    page.out
}

/// Writes the part about one case that is not green, without colours.
pub fn failed_case(result: &RunResult, run: &DeviceRun, case: &CaseResult) -> String {
    let mut page = ConsoleWriter { out: String::new(), look: ConsoleOptions::default() };
    let _ = page.failed(result, run, case);
    page.out
}

/// The results in the order in which they are read: failures by probable cause, the shortest first, then the others.
pub(super) fn by_cause(run: &DeviceRun) -> Vec<&CaseResult> {
    let order: FxHashMap<&str, usize> =
        run.causes.iter().flat_map(|cause| &cause.cases).enumerate().map(|(at, id)| (id.as_str(), at)).collect();
    let mut cases: Vec<&CaseResult> = run.cases.iter().collect();
    cases.sort_by_key(|case| order.get(case.id.as_str()).copied().unwrap_or(usize::MAX));
    cases
}

/// The number of different reasons of the results with this verdict.
fn reasons_of(result: &RunResult, verdict: Verdict) -> usize {
    let cases = result.runs.iter().flat_map(|run| &run.cases).filter(|case| case.verdict == verdict);
    cases.map(|case| case.reason.as_deref()).collect::<FxHashSet<_>>().len()
}

/// The id of a result without the manual.
pub(super) fn short<'a>(run: &DeviceRun, id: &'a str) -> &'a str {
    id.strip_prefix(run.dut.device.as_str()).and_then(|id| id.strip_prefix('/')).unwrap_or(id)
}

struct ConsoleWriter {
    out: String,
    look: ConsoleOptions,
}

#[derive(Clone, Copy)]
enum Ink {
    Good,
    Bad,
    Odd,
    Faint,
    Bold,
}

fn ink(colour: ResultColour, verdict: Verdict) -> Ink {
    match colour {
        ResultColour::Green if verdict == Verdict::Pass => Ink::Good,
        ResultColour::Red => Ink::Bad,
        ResultColour::Green | ResultColour::Neutral(_) => Ink::Odd,
    }
}

impl ConsoleWriter {
    fn paint(&self, ink: Ink, text: &str) -> String {
        let code = match ink {
            Ink::Good => 32,
            Ink::Bad => 31,
            Ink::Odd => 33,
            Ink::Faint => 2,
            Ink::Bold => 1,
        };
        if self.look.colour { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
    }

    fn whole(&mut self, result: &RunResult) -> std::fmt::Result {
        for run in &result.runs {
            if self.look.quiet {
                self.red(result, run)?;
                continue;
            }
            self.device(result, run)?;
            self.out.push('\n');
        }
        for note in result.ledger_notes.iter().filter(|note| note.red || !self.look.quiet) {
            writeln!(self.out, "ledger: {}", printable(&note.text))?;
        }
        let summary = self.summary(result);
        writeln!(self.out, "{summary}")
    }

    /// The red results of a device.
    fn red(&mut self, result: &RunResult, run: &DeviceRun) -> std::fmt::Result {
        for case in by_cause(run) {
            if result_colour(result, run, case) == ResultColour::Red {
                self.failed(result, run, case)?;
                self.out.push('\n');
            }
        }
        Ok(())
    }

    fn device(&mut self, result: &RunResult, run: &DeviceRun) -> std::fmt::Result {
        let mut title = printable(&run.dut.spec);
        if run.dut.kind != "model" {
            let _ = write!(title, " as {}/{}", run.dut.device, run.dut.variant);
        }
        let title = self.paint(Ink::Bold, &title);
        writeln!(self.out, "{title}")?;
        writeln!(self.out, "  identity      {}", printable(&run.dut.identity))?;
        if let Some(firmware) = &run.dut.firmware {
            writeln!(self.out, "  firmware      {}", printable(firmware))?;
        }
        if let Some(persona) = &run.persona {
            writeln!(self.out, "  persona       {persona}")?;
        }
        if !run.bugs.is_empty() {
            writeln!(self.out, "  bugs          {}", run.bugs.join(", "))?;
            for note in &run.bug_notes {
                writeln!(self.out, "                {note}")?;
            }
        }
        if !run.variations.is_empty() {
            writeln!(self.out, "  variations    {}", run.variations.join(", "))?;
        }
        self.tested(run)?;
        for (index, line) in run.bus.iter().flat_map(bus_lines).enumerate() {
            writeln!(self.out, "  {:<13} {line}", if index == 0 { "bus" } else { "" })?;
        }
        let of_kind = |kind: CaseKind| run.cases.iter().filter(move |case| case.kind == kind).map(|case| case.verdict);
        writeln!(self.out, "  cases         {}", totals(of_kind(CaseKind::Trial)))?;
        writeln!(self.out, "  rules         {}", totals(of_kind(CaseKind::Rule)))?;
        writeln!(self.out, "  requirements  {}", totals(run.requirements.iter().map(|of| of.verdict)))?;
        self.causes(run)?;
        self.findings(run)?;
        if self.look.verbose {
            self.out.push('\n');
            run.cases.iter().try_for_each(|case| self.listed(result, run, case))?;
        }
        let mut printed: Vec<(Verdict, Option<&str>)> = Vec::new();
        let mut rest: Vec<&CaseResult> = Vec::new();
        for case in by_cause(run).into_iter().filter(|case| case.verdict != Verdict::Pass) {
            let outcome = (case.verdict, case.reason.as_deref());
            // An unusable bench fails every case in the same way; it is printed once.
            let is_printed = case.verdict != Verdict::Fail && printed.contains(&outcome);
            if case.verdict == Verdict::Xfail || case.failures.is_empty() || is_printed {
                rest.push(case);
                continue;
            }
            printed.push(outcome);
            self.out.push('\n');
            self.failed(result, run, case)?;
        }
        if self.look.verbose {
            return Ok(());
        }
        self.groups(result, run, &rest)?;
        self.slow(run)
    }

    /// How much a live run could test, what would change it, and how often trials were repeated.
    fn tested(&mut self, run: &DeviceRun) -> std::fmt::Result {
        if let Some(share) = run.tested_share().filter(|share| share.tested < share.all) {
            let TestedShare { tested, all, lines } = &share;
            let cannot = if share.is_little() { ": this bench cannot test most of this device yet" } else { "" };
            let text = format!("{tested} of {}{cannot}", count(*all, "case", "cases"));
            let text = if share.is_little() { self.paint(Ink::Odd, &text) } else { text };
            writeln!(self.out, "  tested        {text}")?;
            let lines: Vec<String> = lines.iter().take(LINES).map(|(line, of)| format!("{line} ({of})")).collect();
            if !lines.is_empty() {
                writeln!(self.out, "                what would change most: {}", printable(&lines.join(", ")))?;
            }
        }
        let repeated = run.cases.iter().filter(|case| case.repeats > 0);
        let (times, trials) =
            repeated.clone().fold((0, 0), |(times, of), case| (times + case.repeats as usize, of + 1));
        if trials > 0 {
            let spoilt = repeated.filter(|case| case.verdict == Verdict::Inconclusive).count();
            writeln!(
                self.out,
                "  stalls        {} of {} because the harness or the line was late; {spoilt} still without a verdict",
                count(times, "repetition", "repetitions"),
                count(trials, "case", "cases")
            )?;
        }
        Ok(())
    }

    /// Where to begin: the failures grouped by probable cause.
    fn causes(&mut self, run: &DeviceRun) -> std::fmt::Result {
        let failures: usize = run.causes.iter().map(|cause| cause.cases.len()).sum();
        for (index, cause) in run.causes.iter().take(SHOWN).enumerate() {
            let Some(first) = cause.cases.first() else { continue };
            let title = if run.causes.len() == 1 { "cause".to_owned() } else { format!("cause {}", index + 1) };
            let begin = self.paint(Ink::Bold, &format!("begin with {}", printable(short(run, first))));
            let of = cause.cases.len();
            let kind = kind_of_cause(cause);
            writeln!(self.out, "  {title:<13} {kind}; {begin} ({of} of {})", count(failures, "failure", "failures"))?;
            if let Some(need) = common_need(cause) {
                writeln!(self.out, "                {}", printable(&need))?;
            }
        }
        if run.causes.len() > SHOWN {
            let rest = run.causes.len() - SHOWN;
            writeln!(self.out, "                and {}", count(rest, "more cause", "more causes"))?;
        }
        Ok(())
    }

    /// The findings outside the cases, errors first.
    fn findings(&mut self, run: &DeviceRun) -> std::fmt::Result {
        if run.findings.is_empty() {
            return Ok(());
        }
        writeln!(self.out, "  findings      {}", super::words::severities(&run.findings))?;
        let mut findings: Vec<&DeviceFinding> = run.findings.iter().collect();
        findings.sort_by_key(|of| std::cmp::Reverse(of.severity));
        for of in findings {
            let text = finding(of);
            let (first, rest) = text.split_once('\n').unwrap_or((&text, ""));
            let ink = if of.severity == FindingSeverity::Error { Ink::Bad } else { Ink::Odd };
            let first = self.paint(ink, first);
            write!(self.out, "{first}\n{rest}")?;
        }
        Ok(())
    }

    /// A line for a case, with its readings, saved values and notes.
    fn listed(&mut self, result: &RunResult, run: &DeviceRun, case: &CaseResult) -> std::fmt::Result {
        let verdict = self.paint(ink(result_colour(result, run, case), case.verdict), &format!("{:<14}", case.verdict));
        write!(self.out, "  {verdict} {}", printable(&case.id))?;
        if let Some(decided) = case.decided {
            write!(self.out, " (decided {} times, {} samples)", decided.premises, decided.checked)?;
        }
        if let Some(reason) = &case.reason {
            write!(self.out, ": {}", printable(reason))?;
        }
        self.out.push('\n');
        for (step, reading) in &case.readings {
            writeln!(self.out, "      reading {}: {}", printable(reading), printable(step))?;
        }
        for (name, value) in &case.saved {
            writeln!(self.out, "      saved {} = {}", printable(name), printable(value))?;
        }
        for note in &case.notes {
            writeln!(self.out, "      {}", printable(note))?;
        }
        Ok(())
    }

    /// A case that is not green, in full.
    fn failed(&mut self, result: &RunResult, run: &DeviceRun, case: &CaseResult) -> std::fmt::Result {
        let colour = result_colour(result, run, case);
        let verdict = self.paint(ink(colour, case.verdict), &case.verdict.word().to_uppercase());
        write!(self.out, "  {verdict} {} ({}", printable(&case.id), level(case.level))?;
        if let ResultColour::Neutral(why) = colour {
            write!(self.out, ", {why}")?;
        }
        if case.passed_in_attempt.is_some() {
            write!(self.out, ", flaky")?;
        }
        writeln!(self.out, ")\n    {}", printable(&case.why))?;
        if let Some(attempt) = case.passed_in_attempt {
            writeln!(self.out, "    flaky      it passed in attempt {attempt}; use --accept-flaky to let it pass")?;
        }
        if let Some(reason) = &case.reason
            && case.failures.first().is_none_or(|failure| failure.what != *reason)
        {
            writeln!(self.out, "    {}", printable(reason))?;
        }
        for (index, failure) in case.failures.iter().enumerate() {
            self.failure(failure, index == 0)?;
        }
        for note in &case.notes {
            writeln!(self.out, "    note       {}", printable(note))?;
        }
        if let Some(evidence) = &case.evidence {
            writeln!(self.out, "    evidence   {}", printable(evidence))?;
        }
        writeln!(self.out, "    reproduce  {}", reproduce(result, run, case))?;
        if self.look.verbose
            && case.verdict == Verdict::Fail
            && let Some(failure) = case.failures.first()
        {
            writeln!(self.out, "    to accept this failure, add this entry to the ledger:")?;
            for line in printable_json(&ledger::entry(run, case, failure)).lines() {
                writeln!(self.out, "      {line}")?;
            }
        }
        Ok(())
    }

    fn failure(&mut self, failure: &CaseFailure, first: bool) -> std::fmt::Result {
        let what = self.paint(Ink::Bold, &printable(&failure.what));
        writeln!(self.out, "    {what}")?;
        for (id, clause, statement) in &failure.requirements {
            writeln!(self.out, "    {id}, {}\n      {}", printable(clause), printable(statement))?;
        }
        writeln!(self.out, "    step       {}", printable(&failure.step))?;
        let at = self.paint(Ink::Faint, &super::json::place(&failure.at));
        writeln!(self.out, "    source     {at}")?;
        for part in &failure.parts {
            if part.held {
                writeln!(self.out, "    held       {}", printable(&part.text))?;
                continue;
            }
            writeln!(self.out, "    not held   {}", printable(&part.text))?;
            writeln!(self.out, "      expected {}", printable(&part.expected))?;
            writeln!(self.out, "      observed {}", printable(&part.observed))?;
        }
        if let Some(place) = &failure.place {
            write!(self.out, "    where      frame {}", place.frame)?;
            if let Some(octet) = place.octet {
                write!(self.out, ", byte {octet}")?;
            }
            if let Some(bit) = place.bit {
                write!(self.out, ", bit {bit}")?;
            }
            writeln!(self.out, "\n    Wireshark  {}", printable(&place.filter))?;
        }
        writeln!(self.out, "    blame      {}", failure.blame.word())?;
        if first {
            for (index, line) in failure.trace.iter().enumerate() {
                let line = self.paint(Ink::Faint, &printable(line));
                writeln!(self.out, "    {}{line}", if index == 0 { "trace      " } else { "           " })?;
            }
        }
        if first || failure.blame != FailureCause::Device {
            writeln!(self.out, "    next       {}", printable(&failure.next))?;
        }
        Ok(())
    }

    /// What was later than a limit of ours in results that passed.
    fn slow(&mut self, run: &DeviceRun) -> std::fmt::Result {
        let passed = run.cases.iter().filter(|case| case.verdict == Verdict::Pass);
        let slow: Vec<(&str, &str)> =
            passed.flat_map(|case| case.slow().map(|note| (case.id.as_str(), note))).collect();
        if slow.is_empty() {
            return Ok(());
        }
        let word = self.paint(Ink::Odd, "slow");
        writeln!(self.out, "\n  {word} ({}), which fails nothing:", count(slow.len(), "note", "notes"))?;
        for (id, note) in slow.iter().take(SHOWN) {
            writeln!(self.out, "    {}\n      {}", printable(id), printable(note))?;
        }
        if slow.len() > SHOWN {
            writeln!(self.out, "    and {} more; use -v to list them", slow.len() - SHOWN)?;
        }
        Ok(())
    }

    /// Results that are not printed in full, grouped by verdict and reason.
    fn groups(&mut self, result: &RunResult, run: &DeviceRun, cases: &[&CaseResult]) -> std::fmt::Result {
        let mut groups: Vec<(Verdict, String, Vec<&CaseResult>)> = Vec::new();
        for case in cases.iter().copied() {
            let reason = case.reason.clone().unwrap_or_default();
            match groups.iter_mut().find(|(verdict, other, _)| *verdict == case.verdict && *other == reason) {
                Some((_, _, cases)) => cases.push(case),
                None => groups.push((case.verdict, reason, vec![case])),
            }
        }
        for (verdict, reason, cases) in groups {
            let Some(first) = cases.first() else { continue };
            let colour = result_colour(result, run, first);
            let word = self.paint(ink(colour, verdict), verdict.word());
            let neutral = match colour {
                ResultColour::Neutral(why) if verdict != Verdict::NotApplicable => format!(", {why}"),
                _ => String::new(),
            };
            let reason = if reason.is_empty() { "no reason given".into() } else { printable(&reason) };
            writeln!(self.out, "\n  {word} ({}{neutral}): {reason}", count(cases.len(), "result", "results"))?;
            for case in cases.iter().take(SHOWN) {
                writeln!(self.out, "    {}", printable(&case.id))?;
            }
            if cases.len() > SHOWN {
                writeln!(self.out, "    and {} more; use -v to list them", cases.len() - SHOWN)?;
            }
        }
        Ok(())
    }

    /// The last line: the number of results by verdict.
    fn summary(&self, result: &RunResult) -> String {
        let all = || result.runs.iter().flat_map(|run| run.cases.iter().map(move |case| (run, case)));
        let of = |wanted: Verdict, lit: fn(ResultColour) -> bool| {
            all().filter(|(run, case)| case.verdict == wanted && lit(result_colour(result, run, case))).count()
        };
        let listed = |lit: fn(ResultColour) -> bool| {
            let parts: Vec<String> = Verdict::ALL
                .into_iter()
                .map(|verdict| (of(verdict, lit), verdict))
                .filter(|(n, _)| *n > 0)
                .map(|(n, verdict)| match reasons_of(result, verdict) {
                    few if verdict == Verdict::Inconclusive && few < n => {
                        format!("{n} {verdict} for {}", count(few, "reason", "reasons"))
                    }
                    _ => format!("{n} {verdict}"),
                })
                .collect();
            parts.join(", ")
        };
        let total = format!(
            "{} on {}",
            count(all().count(), "result", "results"),
            count(result.runs.len(), "device", "devices")
        );
        let flaky = all().filter(|(_, case)| case.passed_in_attempt.is_some()).count();
        let flaky = if flaky > 0 { format!(" ({flaky} flaky)") } else { String::new() };
        let total = format!("{total}{flaky}");
        let red = listed(|colour| colour == ResultColour::Red);
        let rest = listed(|colour| colour != ResultColour::Red);
        let mut parts: Vec<String> =
            reasons(result).iter().map(|reason| printable(reason.trim_end_matches('.'))).collect();
        if !red.is_empty() {
            parts.insert(0, red);
        }
        match status(result) {
            ExitStatus::Green if result.runs.iter().any(is_little_tested) => {
                let little = self.paint(Ink::Odd, "Green, but little was tested:");
                format!("{little} {total}: {rest}.")
            }
            ExitStatus::Green => format!("{} {total}: {rest}.", self.paint(Ink::Good, "Green:")),
            _ if rest.is_empty() => format!("{} {total}: {}.", self.paint(Ink::Bad, "Red:"), parts.join("; ")),
            _ => format!("{} {total}: {}; not red: {rest}.", self.paint(Ink::Bad, "Red:"), parts.join("; ")),
        }
    }
}

fn is_little_tested(run: &DeviceRun) -> bool {
    run.tested_share().is_some_and(|share| share.is_little())
}
