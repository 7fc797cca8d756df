//! A hook: a command that is run without a shell, bounded in time and in what it may say.

use station::Duration;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Instant;

/// How long a command may run.
pub(super) const PATIENCE: Duration = Duration::from_secs(60);
/// How often is looked whether it has ended.
const LOOK: Duration = Duration::from_millis(2);
/// How long its last words may take after it has ended.
const LAST_WORDS: Duration = Duration::from_millis(100);
/// The most that is read of what it writes, in octets.
const MOST_OUTPUT: u64 = 4_096;

/// Runs a program with its arguments in `folder` and gives the first line that it writes.
///
/// Fails with a sentence if it cannot be run, ends with another status than 0, or runs longer than `patience`; then it is
/// ended. A program with a `/` in its name is looked for from `folder` on.
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
    let line = |from: &Receiver<Vec<u8>>| first_line(&from.recv_timeout(LAST_WORDS).unwrap_or_default());
    if status.success() {
        return Ok(line(&said));
    }
    let why = [line(&complained), line(&said)].into_iter().find(|line| !line.is_empty());
    let why = why.map_or_else(String::new, |why| format!(": {why}"));
    Err(format!("the hook {shown} ended with {status}{why}"))
}

/// The folder as a full path, so that a program in it is found whatever the present folder is.
fn absolute(folder: &Path) -> PathBuf {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned())
}

/// Waits for the end of a process; ends it when its time is over.
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
            Ok(None) => thread::park_timeout(LOOK),
            Err(error) => return Err(format!("cannot be waited for: {error}")),
        }
    }
}

/// Reads the begin of a pipe to its end in a thread, so that a process that writes much is not held up.
fn read(pipe: Option<impl Read + Send + 'static>) -> Receiver<Vec<u8>> {
    let (give, take) = channel();
    if let Some(mut pipe) = pipe {
        thread::spawn(move || {
            let mut begin = Vec::new();
            let _ = pipe.by_ref().take(MOST_OUTPUT).read_to_end(&mut begin);
            // Nobody may be waiting any more.
            let _ = give.send(begin);
            let _ = std::io::copy(&mut pipe, &mut std::io::sink());
        });
    }
    take
}

/// The first line, fit to be shown.
fn first_line(octets: &[u8]) -> String {
    let text = String::from_utf8_lossy(octets);
    text.lines().next().unwrap_or_default().trim().chars().flat_map(shown).collect()
}

fn shown(c: char) -> Vec<char> {
    if c == ' ' || c.is_ascii_graphic() { vec![c] } else { c.escape_default().collect() }
}
