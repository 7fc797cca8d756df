//! The processes that try changes.

use crate::Failure;
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Runs every case once, and notes in the file `reach` which changes each of them reaches; returns all of these.
pub fn reached(runner: &Path, suites: &Path, highest: u32, reach: &Path) -> Result<BTreeSet<u32>, Failure> {
    let status = Command::new(runner).arg("reach").arg(suites).arg(highest.to_string()).arg(reach).status()?;
    if !status.success() {
        return Err("the reference devices do not run".into());
    }
    let text = fs::read_to_string(reach)?;
    let numbers = text.lines().flat_map(|line| line.split(' ').skip(1));
    Ok(numbers.filter_map(|number| number.trim_start_matches('=').parse().ok()).collect())
}

/// A process that tries one change after the other.
pub struct Runner {
    process: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Runner {
    pub fn start(runner: &Path, suites: &Path, reach: &Path, is_quick: bool) -> Option<Runner> {
        let mut command = Command::new(runner);
        command.arg("try").arg(suites).arg(reach).args(is_quick.then_some("quick"));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut process = command.spawn().ok()?;
        let (questions, answers) = (process.stdin.take()?, BufReader::new(process.stdout.take()?));
        Some(Runner { process, questions, answers })
    }

    /// The outcome of a change; `None` if the process ends without an answer.
    pub fn ask(&mut self, number: u32) -> Option<String> {
        writeln!(self.questions, "{number}").ok()?;
        let mut line = String::new();
        self.answers.read_line(&mut line).ok()?;
        line.split_once(' ').map(|(_, outcome)| outcome.trim().to_owned())
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
