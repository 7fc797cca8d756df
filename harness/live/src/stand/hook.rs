//! A hook: a command that runs without a shell, with limits on its time and its output.

use station::Duration;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Instant;

/// Timeout for a command.
pub(super) const HOOK_TIMEOUT: Duration = Duration::from_secs(60);
/// Interval of the checks whether it has ended.
const EXIT_POLL_INTERVAL: Duration = Duration::from_millis(2);
/// Timeout for the rest of its output after it has ended.
const OUTPUT_TIMEOUT: Duration = Duration::from_millis(100);
/// Maximum number of bytes read from its output.
const MOST_OUTPUT: u64 = 4_096;

/// Runs a program with its arguments in `folder` and returns the first line of its output.
///
/// Fails with a sentence if it cannot be run, ends with another status than 0, or runs longer than `patience`; then it is killed.
/// The path of a program with a `/` in its name is relative to `folder`.
pub(super) fn run(words: &[String], folder: &Path, patience: Duration) -> Result<String, String> {
    let [program, arguments @ ..] = words else { return Err("there is no command".to_owned()) };
    let shown = program.escape_default().to_string();
    let path = if program.contains('/') { absolute(folder).join(program) } else { PathBuf::from(program) };
    let mut command = Command::new(path);
    command.args(arguments).current_dir(absolute(folder));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| format!("the hook {shown} cannot be run: {error}"))?;
    let said = read(child.stdout.take());
    let complained = read(child.stderr.take());
    let status = wait(&mut child, patience).map_err(|why| format!("the hook {shown} {why}"))?;
    let line = |from: &Receiver<Vec<u8>>| first_line(&from.recv_timeout(OUTPUT_TIMEOUT).unwrap_or_default());
    if status.success() {
        return Ok(line(&said));
    }
    let why = [line(&complained), line(&said)].into_iter().find(|line| !line.is_empty());
    let why = why.map_or_else(String::new, |why| format!(": {why}"));
    Err(format!("the hook {shown} ended with {status}{why}"))
}

/// The folder as an absolute path, so that a program in it is found whatever the current folder is.
fn absolute(folder: &Path) -> PathBuf {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned())
}

/// Waits for the end of a process; kills it after the timeout.
fn wait(child: &mut Child, patience: Duration) -> Result<ExitStatus, String> {
    let began = Instant::now();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return Ok(status),
            Ok(None) if began.elapsed() >= patience => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("has not ended after {} s", patience.as_secs_f64()));
            }
            Ok(None) => thread::park_timeout(EXIT_POLL_INTERVAL),
            Err(error) => return Err(format!("cannot be waited for: {error}")),
        }
    }
}

/// Reads the start of a pipe in a thread and drains the rest, so that a process with much output does not block.
fn read(pipe: Option<impl Read + Send + 'static>) -> Receiver<Vec<u8>> {
    let (give, take) = channel();
    if let Some(mut pipe) = pipe {
        thread::spawn(move || {
            let mut begin = Vec::new();
            let _ = pipe.by_ref().take(MOST_OUTPUT).read_to_end(&mut begin);
            // The receiver may be gone.
            let _ = give.send(begin);
            let _ = std::io::copy(&mut pipe, &mut std::io::sink());
        });
    }
    take
}

/// The first line without control characters.
fn first_line(octets: &[u8]) -> String {
    let text = String::from_utf8_lossy(octets);
    text.lines().next().unwrap_or_default().trim().chars().flat_map(shown).collect()
}

fn shown(c: char) -> Vec<char> {
    if c == ' ' || c.is_ascii_graphic() { vec![c] } else { c.escape_default().collect() }
}
