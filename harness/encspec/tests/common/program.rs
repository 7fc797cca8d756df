//! Runs the `encspec` binary as a user does.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Output, Stdio};

/// Exit status and output of a run of the binary.
#[derive(Debug)]
pub struct ProgramOutput {
    pub status: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl ProgramOutput {
    pub fn of(output: &Output) -> ProgramOutput {
        let text = |octets: &[u8]| String::from_utf8(octets.to_vec()).expect("UTF-8");
        ProgramOutput { status: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) }
    }

    /// Standard output followed by standard error.
    pub fn all(&self) -> String {
        format!("{}{}", self.out, self.err)
    }
}

/// The binary with these arguments, to be run in `folder`, which must outlive the run. Standard input is empty.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_encspec"));
    command.args(arguments).current_dir(folder).env_remove("NO_COLOR").stdin(Stdio::null());
    command
}

/// Runs the binary to its end. A temporary folder that is passed by value is deleted afterwards.
pub fn encspec(folder: impl AsRef<Path>, arguments: &[&str]) -> ProgramOutput {
    ProgramOutput::of(&command(folder.as_ref(), arguments).output().expect("the binary"))
}

/// A running `encspec serve`. It is killed on drop.
pub struct ServeProcess {
    child: Child,
    out: BufReader<ChildStdout>,
    /// The lines of its output up to `ready`.
    pub said: Vec<String>,
}

impl ServeProcess {
    /// Starts `encspec serve` with these arguments and waits until it is ready.
    pub fn start(arguments: &[&str]) -> ServeProcess {
        let mut child = command(Path::new("."), &[&["serve"], arguments].concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary");
        let out = BufReader::new(child.stdout.take().expect("its output"));
        let mut serving = ServeProcess { child, out, said: Vec::new() };
        loop {
            let mut line = String::new();
            if serving.out.read_line(&mut line).expect("text") == 0 {
                panic!("it exited before it was ready: {}", serving.end());
            }
            serving.said.push(line.trim_end().to_owned());
            if line.starts_with("ready ") {
                return serving;
            }
        }
    }

    /// The process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Interrupts the process as Ctrl-C does. Returns the exit status.
    pub fn interrupt(&mut self) -> Option<i32> {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args(["-INT", &id]).status().expect("kill");
        assert!(sent.success(), "the process is still running");
        self.child.wait().expect("its end").code()
    }

    /// Kills the process. Returns its standard error.
    pub fn end(&mut self) -> String {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let mut text = String::new();
        if let Some(mut errors) = self.child.stderr.take() {
            errors.read_to_string(&mut text).expect("text");
        }
        text
    }
}

impl Drop for ServeProcess {
    fn drop(&mut self) {
        self.end();
    }
}
