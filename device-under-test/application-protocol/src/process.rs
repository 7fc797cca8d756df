//! The process of a program: lines in, lines out, and the end of it. It has no sockets; only real time limits how long it waits.

use crate::failure::{ProgramFailure, shown};
use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// The longest line of a program in bytes.
const LONGEST_LINE: u64 = 1 << 20;
/// How many lines a program may be ahead before it is blocked.
const LINES_AHEAD: usize = 16;
/// How many of the last lines on standard error are kept.
const KEPT_LINES: usize = 8;
/// How long a program may take to end after its standard input was closed.
const END_TIMEOUT: Duration = Duration::from_millis(500);
/// How long the rest of its output may take after it has ended.
const REST_TIMEOUT: Duration = Duration::from_millis(200);
/// Interval of the checks whether it has ended.
const END_POLL_INTERVAL: Duration = Duration::from_millis(2);

/// A program with its arguments, and the folder in which it runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProgramCommand {
    words: Vec<String>,
    folder: PathBuf,
}

impl ProgramCommand {
    /// A command of `words`, of which the first is the program; a path with a `/` in it is relative to `folder`.
    pub fn new(words: Vec<String>, folder: &Path) -> ProgramCommand {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        ProgramCommand { words, folder: std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned()) }
    }
}

/// A running program.
pub(crate) struct ProgramProcess {
    child: Child,
    /// `None` once it was closed.
    stdin: Option<ChildStdin>,
    lines: Receiver<Result<String, String>>,
    complaints: Arc<Mutex<VecDeque<String>>>,
    /// Whether standard error was read to its end.
    complained: Receiver<()>,
    patience: Duration,
    line: Vec<u8>,
}

impl ProgramProcess {
    /// Starts the program.
    pub(crate) fn start(command: &ProgramCommand, patience: Duration) -> Result<ProgramProcess, ProgramFailure> {
        let ProgramCommand { words, folder } = command;
        let program = words.first().map_or("", String::as_str);
        let path = if program.contains('/') { folder.join(program) } else { PathBuf::from(program) };
        let mut process = Command::new(path);
        process.args(words.iter().skip(1)).current_dir(folder);
        process.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = process.spawn().map_err(|error| ProgramFailure::Start {
            program: shown(program),
            why: error.to_string(),
            folder: folder.display().to_string(),
        })?;
        let (give, lines) = sync_channel(LINES_AHEAD);
        if let Some(stdout) = child.stdout.take() {
            thread::spawn(move || read_lines(stdout, &give));
        }
        let complaints = Arc::new(Mutex::new(VecDeque::new()));
        let (finished, complained) = sync_channel(1);
        if let Some(stderr) = child.stderr.take() {
            let kept = Arc::clone(&complaints);
            thread::spawn(move || {
                keep_last_lines(stderr, &kept);
                // The receiver may be gone.
                let _ = finished.send(());
            });
        }
        let stdin = child.stdin.take();
        Ok(ProgramProcess { child, stdin, lines, complaints, complained, patience, line: Vec::new() })
    }

    /// Sends a line and returns the line that answers it. `asked` names the message.
    pub(crate) fn ask(&mut self, line: &[u8], asked: &dyn Fn() -> String) -> Result<String, ProgramFailure> {
        if let Ok(Ok(line)) = self.lines.try_recv() {
            return Err(ProgramFailure::Unasked { line: shown(&line) });
        }
        self.line.clear();
        self.line.extend_from_slice(line);
        self.line.push(b'\n');
        let sent = self.stdin.as_mut().map(|stdin| stdin.write_all(&self.line).and_then(|()| stdin.flush()));
        if !matches!(sent, Some(Ok(()))) {
            return Err(self.ended(asked()));
        }
        match self.lines.recv_timeout(self.patience) {
            Ok(Ok(line)) => Ok(line),
            Ok(Err(why)) => Err(ProgramFailure::Nonsense { asked: asked(), why, line: String::new() }),
            Err(RecvTimeoutError::Timeout) => {
                let _ = self.child.kill();
                Err(ProgramFailure::Silent { asked: asked(), patience: self.patience, stderr: self.stderr() })
            }
            Err(RecvTimeoutError::Disconnected) => Err(self.ended(asked())),
        }
    }

    /// The failure of a program that has closed its input or its output.
    fn ended(&mut self, asked: String) -> ProgramFailure {
        self.stdin = None;
        let status = match self.wait() {
            Some(status) => status,
            None => "it closed its standard output and was killed".to_owned(),
        };
        ProgramFailure::Ended { asked, status, stderr: self.stderr() }
    }

    /// The last lines of standard error, with an introduction; empty if there are none.
    pub(crate) fn stderr(&self) -> String {
        let _ = self.complained.recv_timeout(REST_TIMEOUT);
        let kept = self.complaints.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.is_empty() {
            return String::new();
        }
        let lines: Vec<&str> = kept.iter().map(String::as_str).collect();
        format!("; its last lines on standard error: {}", lines.join(" / "))
    }

    /// Waits for the end of the program, and kills it after a time. `None` if it had to be killed.
    fn wait(&mut self) -> Option<String> {
        let began = Instant::now();
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) => return Some(status.to_string()),
                Ok(None) if began.elapsed() < END_TIMEOUT => thread::park_timeout(END_POLL_INTERVAL),
                Ok(None) | Err(_) => {
                    let _ = self.child.kill();
                    let _ = self.child.wait();
                    return None;
                }
            }
        }
    }
}

impl Drop for ProgramProcess {
    fn drop(&mut self) {
        self.stdin = None;
        self.wait();
    }
}

impl std::fmt::Debug for ProgramProcess {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ProgramProcess({})", self.child.id())
    }
}

/// The next line with its line feed, or the next part of one that is too long; `None` at the end.
fn next_line(reader: &mut impl BufRead) -> Option<Vec<u8>> {
    let mut line = Vec::new();
    let read = reader.take(LONGEST_LINE).read_until(b'\n', &mut line);
    read.is_ok_and(|count| count > 0).then_some(line)
}

/// Gives each line of `stdout`; an error says why a line is not text.
fn read_lines(stdout: impl Read, give: &SyncSender<Result<String, String>>) {
    let mut reader = BufReader::new(stdout);
    while let Some(mut line) = next_line(&mut reader) {
        let line = match line.pop() {
            Some(b'\n') => String::from_utf8(line).map_err(|_| "it is not UTF-8".to_owned()),
            last => {
                line.extend(last);
                let is_long = line.len() as u64 >= LONGEST_LINE;
                let why = if is_long { "it has more than 1 MiB" } else { "it has no line feed" };
                Err(format!("{why}: {}", shown(&String::from_utf8_lossy(&line))))
            }
        };
        if give.send(line).is_err() {
            return;
        }
    }
}

/// Keeps the last lines of `stderr`.
fn keep_last_lines(stderr: impl Read, kept: &Mutex<VecDeque<String>>) {
    let mut reader = BufReader::new(stderr);
    while let Some(line) = next_line(&mut reader) {
        let text = shown(String::from_utf8_lossy(&line).trim_end());
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() == KEPT_LINES {
            kept.pop_front();
        }
        if !text.is_empty() {
            kept.push_back(text);
        }
    }
}
