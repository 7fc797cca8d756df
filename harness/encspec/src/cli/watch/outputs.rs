//! Where findings go: a file of JSON lines, the system log, a command, the counts for Prometheus, the terminal.

use super::{CommandError, Source, WatchArgs};
use crate::cli::print_message;
use link::system_log::{LogSeverity, SystemLog};
use link::text_server::TextServer;
use link::{Clock, pause};
use station::Duration;
use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use watch::{LiveWatch, WatchCounts, WatchLine, json_line, prometheus, screen, text_line};

/// A hook is ended after this time.
const HOOK_TIME: Duration = Duration::from_secs(10);
/// How often it is checked whether a hook has ended.
const HOOK_CHECK: Duration = Duration::from_millis(20);
/// Findings that wait for the hook; further ones are left out and counted.
const MOST_HOOKS: usize = 64;
/// The last findings wait so long for their hooks when the watch ends.
const HOOKS_END: Duration = Duration::from_secs(15);

/// The outputs of a watch.
pub(super) struct Outputs {
    findings: PathBuf,
    file: Option<File>,
    log: Option<SystemLog>,
    hook: Option<FindingHook>,
    counts: Arc<Mutex<WatchCounts>>,
    server: Option<TextServer>,
    /// The source, where the terminal shows a view.
    view: Option<String>,
    failed: u64,
    has_failed: bool,
}

impl Outputs {
    pub fn open(args: &WatchArgs, source: &Source) -> Result<Outputs, CommandError> {
        let findings = args.findings.clone().unwrap_or_else(|| args.dir.join("findings.jsonl"));
        let is_stdout = findings == Path::new("-");
        let log = match &args.syslog {
            None => None,
            Some(path) => Some(SystemLog::open(path).map_err(|error| {
                CommandError::bench(format!("the system log at {} cannot be reached: {error}", path.display()))
            })?),
        };
        let counts = Arc::new(Mutex::new(WatchCounts::default()));
        let server = match args.metrics {
            None => None,
            Some(address) => {
                let counts = Arc::clone(&counts);
                let text = move || counts.lock().map(|counts| prometheus(&counts)).unwrap_or_default();
                Some(TextServer::listen(address, text).map_err(|error| {
                    CommandError::bench(format!("cannot listen at {address}: {error}; choose another port"))
                })?)
            }
        };
        if let Some(server) = server.as_ref().filter(|_| args.metrics.is_some_and(|address| address.port() == 0)) {
            print_message(&format!("counts at http://{}/metrics", server.address()));
        }
        let mut outputs = Outputs {
            findings,
            file: None,
            log,
            hook: args.hook.as_deref().map(FindingHook::start),
            counts,
            server,
            view: (!is_stdout && io::stdout().is_terminal()).then(|| source.describe()),
            failed: 0,
            has_failed: false,
        };
        outputs.rotate()?;
        Ok(outputs)
    }

    /// Opens the file of findings again, which may have been moved away.
    pub fn rotate(&mut self) -> Result<(), CommandError> {
        if self.findings == Path::new("-") {
            return Ok(());
        }
        let unwritable =
            |error: io::Error| CommandError::bench(format!("{} cannot be written: {error}", self.findings.display()));
        if let Some(folder) = self.findings.parent() {
            std::fs::create_dir_all(folder).map_err(unwritable)?;
        }
        self.file = Some(File::options().append(true).create(true).open(&self.findings).map_err(unwritable)?);
        Ok(())
    }

    /// Passes lines on to all outputs. What one does not take is counted and does not keep the others waiting.
    pub fn pass_on(&mut self, lines: &[WatchLine]) {
        for line in lines {
            let json = json_line(line);
            let written = match &mut self.file {
                Some(file) => file.write_all(json.as_bytes()),
                None => {
                    let mut out = io::stdout().lock();
                    out.write_all(json.as_bytes()).and_then(|()| out.flush())
                }
            };
            self.note(written.is_ok());
            if let Err(error) = written
                && !std::mem::replace(&mut self.has_failed, true)
            {
                print_message(&format!("{} cannot be written: {error}", self.findings.display()));
            }
            if let Some(log) = &self.log
                && let Some(severity) = severity(line)
            {
                let sent = log.send(severity, "encspec", &text_line(line));
                self.note(sent.is_ok());
            }
            if let (Some(hook), WatchLine::Finding(_)) = (&self.hook, line) {
                hook.run(json);
            }
        }
    }

    fn note(&mut self, is_done: bool) {
        self.failed += u64::from(!is_done);
    }

    /// What an output did not take.
    pub fn not_passed_on(&self) -> u64 {
        self.failed + self.hook.as_ref().map_or(0, |hook| hook.failed.load(Ordering::Relaxed))
    }

    /// Shows the counts.
    pub fn update(&mut self, watch: &LiveWatch<'_>) {
        if self.server.is_some()
            && let Ok(mut counts) = self.counts.lock()
        {
            counts.clone_from(watch.counts());
        }
        if let Some(source) = &self.view {
            let text = screen(watch.counts(), source, watch.recent(), link::terminal_size());
            // Home, the text with the rest of each line cleared, and the rest of the screen cleared.
            super::super::show(&format!("\x1b[H{}\x1b[K\n\x1b[J", text.replace('\n', "\x1b[K\n")));
        }
    }

    /// Waits for what is on its way.
    pub fn end(mut self) {
        if let Some(hook) = self.hook.take() {
            hook.end();
        }
    }
}

/// The severity of a line in the system log; `None` for what does not belong there.
fn severity(line: &WatchLine) -> Option<LogSeverity> {
    match line {
        WatchLine::Finding(line) => Some(match line.severity {
            "error" => LogSeverity::Error,
            "warning" => LogSeverity::Warning,
            _ => LogSeverity::Info,
        }),
        WatchLine::Lost { .. } => Some(LogSeverity::Warning),
        WatchLine::Started { .. } | WatchLine::Note { .. } | WatchLine::Ended { .. } => Some(LogSeverity::Info),
        WatchLine::Incident { .. } => None,
    }
}

/// The command that is run for each finding, one at a time.
struct FindingHook {
    lines: SyncSender<String>,
    failed: Arc<AtomicU64>,
    thread: JoinHandle<()>,
}

impl FindingHook {
    fn start(command: &str) -> FindingHook {
        let (lines, receiver) = sync_channel(MOST_HOOKS);
        let failed = Arc::new(AtomicU64::new(0));
        let (command, count) = (command.to_owned(), Arc::clone(&failed));
        let thread = thread::spawn(move || run_hooks(&command, &receiver, &count));
        FindingHook { lines, failed, thread }
    }

    fn run(&self, line: String) {
        if self.lines.try_send(line).is_err() {
            self.failed.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn end(self) {
        drop(self.lines);
        let clock = Clock::start();
        let until = clock.now() + HOOKS_END;
        while !self.thread.is_finished() && clock.now() < until {
            pause(&clock, clock.now() + HOOK_CHECK);
        }
    }
}

fn run_hooks(command: &str, lines: &Receiver<String>, failed: &AtomicU64) {
    for line in lines {
        let started = Command::new("sh").arg("-c").arg(command).stdin(Stdio::piped()).stdout(Stdio::null()).spawn();
        let is_done = started.is_ok_and(|mut child| {
            if let Some(mut input) = child.stdin.take() {
                // A command that does not read its input is fine; a line fits into the buffer of a pipe.
                let _ = input.write_all(line.get(..line.len().min(60_000)).unwrap_or(&line).as_bytes());
            }
            ends_well(&mut child)
        });
        if !is_done {
            failed.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Waits for a hook, and ends it after its time.
fn ends_well(child: &mut Child) -> bool {
    let clock = Clock::start();
    let until = clock.now() + HOOK_TIME;
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return status.success(),
            Ok(None) if clock.now() < until => pause(&clock, clock.now() + HOOK_CHECK),
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                return false;
            }
        }
    }
}
