//! The program as a user calls it.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Output, Stdio};

/// How it ended and what it said.
#[derive(Debug)]
pub struct Said {
    pub status: Option<i32>,
    pub out: String,
    /// What it has complained about.
    pub err: String,
}

impl Said {
    pub fn of(output: &Output) -> Said {
        let text = |octets: &[u8]| String::from_utf8(octets.to_vec()).expect("UTF-8");
        Said { status: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) }
    }

    /// What it said, with what it complained about behind it.
    pub fn all(&self) -> String {
        format!("{}{}", self.out, self.err)
    }
}

/// The program with these arguments, to be started in `folder`; there is nobody to answer it.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_encspec"));
    command.args(arguments).current_dir(folder).env_remove("NO_COLOR").stdin(Stdio::null());
    command
}

/// Lets the program run to its end.
pub fn encspec(folder: &Path, arguments: &[&str]) -> Said {
    Said::of(&command(folder, arguments).output().expect("the binary"))
}

/// `encspec serve` at work; it ends with this.
pub struct Serving {
    child: Child,
    out: BufReader<ChildStdout>,
    /// What it has said before it was ready, line by line.
    pub said: Vec<String>,
}

impl Serving {
    /// Serves with these arguments and waits until it is ready.
    pub fn start(arguments: &[&str]) -> Serving {
        let mut child = command(Path::new("."), &[&["serve"], arguments].concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary");
        let out = BufReader::new(child.stdout.take().expect("its output"));
        let mut serving = Serving { child, out, said: Vec::new() };
        loop {
            let mut line = String::new();
            if serving.out.read_line(&mut line).expect("text") == 0 {
                panic!("it ended before it was ready: {}", serving.end());
            }
            serving.said.push(line.trim_end().to_owned());
            if line.starts_with("ready ") {
                return serving;
            }
        }
    }

    /// Its process number.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Asks it to end as Ctrl-C does and gives its status.
    pub fn interrupt(&mut self) -> Option<i32> {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args(["-INT", &id]).status().expect("kill");
        assert!(sent.success(), "it is still there");
        self.child.wait().expect("its end").code()
    }

    /// Ends it and gives what it has complained about.
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

impl Drop for Serving {
    fn drop(&mut self) {
        self.end();
    }
}
