//! Changes the reference devices, one operator or literal at a time, and lists the changes that no case notices.
//!
//! All changes are in one build, each behind a switch, so that a change costs a run and no build. The suites judge; unit tests do not
//! count. `killed` is a case or rule that fails; an inconclusive result is no kill.

mod sites;

use sites::Change;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitCode, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

const USAGE: &str = "usage: mutants CHECKOUT WORK [--sample N] [--seed N] [--seconds N]
  CHECKOUT  the project
  WORK      a folder for the changed copy and the results; results that are there are kept, so a run can go on
  --sample  how many changes are tried (all without it)
  --seed    which ones
  --seconds when no further change is begun";

/// The crates whose sources are changed.
const CRATES: [&str; 3] = ["device-stack", "encoder-profile", "reference-devices"];
/// Files that only serve the deviations.
const LEFT_OUT: [&str; 4] = ["hooks.rs", "deviations.rs", "attached.rs", "tests.rs"];
/// A change that takes longer than this does not end.
const PATIENCE: Duration = Duration::from_secs(60);
const WORKERS: usize = 2;

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("mutants: {error}");
            ExitCode::FAILURE
        }
    }
}

struct Arguments {
    checkout: PathBuf,
    work: PathBuf,
    sample: usize,
    seed: u64,
    seconds: u64,
}

impl Arguments {
    fn read() -> Result<Arguments, Failure> {
        let mut words = std::env::args().skip(1);
        let (Some(checkout), Some(work)) = (words.next(), words.next()) else { return Err(USAGE.into()) };
        let (checkout, work) = (checkout.into(), work.into());
        let mut read = Arguments { checkout, work, sample: usize::MAX, seed: 0, seconds: u64::MAX };
        while let Some(option) = words.next() {
            let value: u64 = words.next().ok_or(USAGE)?.parse()?;
            match option.as_str() {
                "--sample" => read.sample = usize::try_from(value)?,
                "--seed" => read.seed = value,
                "--seconds" => read.seconds = value,
                _ => return Err(USAGE.into()),
            }
        }
        Ok(read)
    }
}

/// A file of a reference device with the changes that can be made in it.
struct SourceFile {
    /// Its path in the checkout.
    path: PathBuf,
    text: String,
    /// Each with its number, from 1 over all files.
    changes: Vec<(u32, Change)>,
}

fn run() -> Result<(), Failure> {
    let arguments = Arguments::read()?;
    let tree = arguments.work.join("tree");
    copy(&arguments.checkout, &tree)?;
    let mut files = find(&tree)?;
    add_crates(&arguments.checkout, &tree)?;
    let all: usize = files.iter().map(|file| file.changes.len()).sum();
    eprintln!("{all} changes in {} files", files.len());
    build(&tree, &mut files)?;
    let left: BTreeMap<u32, String> = files
        .iter()
        .flat_map(|file| file.changes.iter().map(|(number, change)| (*number, describe(file, change))))
        .collect();
    eprintln!("{} of them compile", left.len());
    let results = arguments.work.join("results.txt");
    let known = known(&results);
    let mut numbers: Vec<u32> = left.keys().copied().collect();
    numbers.sort_by_key(|number| mixed(u64::from(*number) ^ arguments.seed.rotate_left(32)));
    numbers.truncate(arguments.sample);
    numbers.retain(|number| !known.contains_key(&left[number]));
    let highest = left.keys().next_back().copied().unwrap_or(0);
    tried(&tree, highest, &numbers, &left, &results, Duration::from_secs(arguments.seconds))?;
    summary(&results);
    Ok(())
}

fn describe(file: &SourceFile, change: &Change) -> String {
    format!("{}:{} {}", file.path.display(), change.line, change.what)
}

/// SplitMix64.
fn mixed(seed: u64) -> u64 {
    let mut mixed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// Copies the files of the checkout that are under version control.
fn copy(checkout: &Path, tree: &Path) -> Result<(), Failure> {
    let listed = Command::new("git").arg("-C").arg(checkout).args(["ls-files", "-z"]).output()?;
    for name in String::from_utf8(listed.stdout)?.split('\0').filter(|name| !name.is_empty()) {
        let (from, to) = (checkout.join(name), tree.join(name));
        let content = match fs::read(&from) {
            Ok(content) => content,
            // It is deleted in the working copy.
            Err(_) => continue,
        };
        if fs::read(&to).is_ok_and(|known| known == content) {
            continue;
        }
        fs::create_dir_all(to.parent().ok_or("a file without a folder")?)?;
        fs::write(to, content)?;
    }
    Ok(())
}

/// Reads the sources of the reference devices and finds what can be changed.
fn find(tree: &Path) -> Result<Vec<SourceFile>, Failure> {
    let mut paths = Vec::new();
    for name in CRATES {
        walk(&tree.join("device-under-test").join(name).join("src"), &mut paths)?;
    }
    paths.sort();
    let mut files = Vec::new();
    let mut number = 0;
    for path in paths {
        let text = fs::read_to_string(&path)?;
        let changes = sites::changes(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        let numbered = changes.into_iter().map(|change| {
            number += 1;
            (number, change)
        });
        let changes = numbered.collect();
        files.push(SourceFile { path: path.strip_prefix(tree)?.to_owned(), text, changes });
    }
    Ok(files)
}

fn walk(folder: &Path, paths: &mut Vec<PathBuf>) -> Result<(), Failure> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && name != "tests" {
            walk(&path, paths)?;
        } else if name.ends_with(".rs") && !LEFT_OUT.contains(&name.as_str()) {
            paths.push(path);
        }
    }
    Ok(())
}

/// Adds the switch and the runner to the copied workspace.
fn add_crates(checkout: &Path, tree: &Path) -> Result<(), Failure> {
    let workspace = tree.join("Cargo.toml");
    let text = fs::read_to_string(&workspace)?;
    let members = "    \".ci/mutants/switch\",\n    \".ci/mutants/runner\",\n";
    let text = text.replacen("members = [\n", &format!("members = [\n{members}"), 1);
    fs::write(&workspace, text)?;
    for name in CRATES {
        let manifest = tree.join("device-under-test").join(name).join("Cargo.toml");
        let text = fs::read_to_string(checkout.join("device-under-test").join(name).join("Cargo.toml"))?;
        let switch = "[dependencies]\nmutant-switch = { path = \"../../.ci/mutants/switch\" }\n";
        fs::write(manifest, text.replacen("[dependencies]\n", switch, 1))?;
    }
    Ok(())
}

/// Builds the runner with all changes. What does not compile is left out, and the build is repeated.
fn build(tree: &Path, files: &mut [SourceFile]) -> Result<(), Failure> {
    loop {
        for file in files.iter() {
            let changes: Vec<(u32, &Change)> = file.changes.iter().map(|(number, change)| (*number, change)).collect();
            fs::write(tree.join(&file.path), sites::instrumented(&file.text, &changes))?;
        }
        let built = Command::new("cargo")
            .current_dir(tree)
            .args(["build", "--release", "-p", "mutant-runner", "--message-format=json", "--quiet"])
            .env("RUSTFLAGS", "--cap-lints warn -Awarnings")
            .stderr(Stdio::inherit())
            .output()?;
        if built.status.success() {
            return Ok(());
        }
        let mut wrong: BTreeSet<(PathBuf, usize)> = BTreeSet::new();
        for line in String::from_utf8_lossy(&built.stdout).lines() {
            let message: serde_json::Value = serde_json::from_str(line)?;
            if message["message"]["level"] != "error" {
                continue;
            }
            for span in message["message"]["spans"].as_array().into_iter().flatten() {
                let file = PathBuf::from(span["file_name"].as_str().unwrap_or_default());
                for line in span["line_start"].as_u64().unwrap_or(0)..=span["line_end"].as_u64().unwrap_or(0) {
                    wrong.insert((file.clone(), usize::try_from(line)?));
                }
            }
        }
        let before: usize = files.iter().map(|file| file.changes.len()).sum();
        for file in files.iter_mut() {
            let path = file.path.clone();
            file.changes.retain(|(_, change)| !change.lines.clone().any(|line| wrong.contains(&(path.clone(), line))));
        }
        let after: usize = files.iter().map(|file| file.changes.len()).sum();
        eprintln!("{} changes do not compile", before - after);
        if before == after {
            return Err("the changed copy does not build, and no change is to blame".into());
        }
    }
}

/// The results of earlier runs: what was changed, and the outcome.
fn known(results: &Path) -> BTreeMap<String, String> {
    let text = fs::read_to_string(results).unwrap_or_default();
    text.lines().filter_map(|line| line.split_once('\t')).map(|(outcome, what)| (what.to_owned(), outcome.to_owned())).collect()
}

/// Tries the changes on some processes, and appends each result to the file.
fn tried(
    tree: &Path,
    highest: u32,
    numbers: &[u32],
    what: &BTreeMap<u32, String>,
    results: &Path,
    seconds: Duration,
) -> Result<(), Failure> {
    let queue = Mutex::new(numbers.iter());
    let file = Mutex::new(fs::OpenOptions::new().create(true).append(true).open(results)?);
    let begin = Instant::now();
    std::thread::scope(|scope| {
        for _ in 0..WORKERS {
            scope.spawn(|| {
                let mut runner: Option<Runner> = None;
                while begin.elapsed() < seconds {
                    let next = queue.lock().unwrap_or_else(PoisonError::into_inner).next().copied();
                    let Some(number) = next else { return };
                    if runner.is_none() {
                        runner = Runner::start(tree, highest);
                    }
                    let answer = runner.as_mut().and_then(|runner| runner.ask(number));
                    let outcome = answer.unwrap_or_else(|| {
                        runner = None;
                        "hung".to_owned()
                    });
                    let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
                    // A result that cannot be written is made again by the next run.
                    let _ = writeln!(file, "{outcome}\t{}", what[&number]);
                }
            });
        }
    });
    Ok(())
}

/// A process that tries one change after the other.
struct Runner {
    process: Child,
    questions: ChildStdin,
    answers: Receiver<String>,
}

impl Runner {
    fn start(tree: &Path, highest: u32) -> Option<Runner> {
        let mut command = Command::new(tree.join("target/release/mutant-runner"));
        command.arg(highest.to_string()).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut process = command.spawn().ok()?;
        let (questions, output) = (process.stdin.take()?, process.stdout.take()?);
        let (sender, answers) = channel();
        std::thread::spawn(move || {
            let lines = BufReader::new(output).lines().map_while(Result::ok);
            lines.for_each(|line| drop(sender.send(line)));
        });
        let runner = Runner { process, questions, answers };
        runner.answers.recv_timeout(PATIENCE * 5).ok().map(|_| runner)
    }

    /// The outcome of a change; `None` if the process hangs or ends.
    fn ask(&mut self, number: u32) -> Option<String> {
        writeln!(self.questions, "{number}").ok()?;
        match self.answers.recv_timeout(PATIENCE) {
            Ok(line) => line.split_once(' ').map(|(_, outcome)| outcome.trim().to_owned()),
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => None,
        }
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Prints how many changes had which outcome, and lists those that nothing noticed.
fn summary(results: &Path) {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for (what, outcome) in known(results) {
        let word = outcome.split(' ').next().unwrap_or_default().to_owned();
        if word != "killed" && word != "crashed" && word != "hung" {
            println!("{word:<13} {what}");
        }
        *counts.entry(word).or_default() += 1;
    }
    let counts: Vec<String> = counts.iter().map(|(word, count)| format!("{count} {word}")).collect();
    println!("{}", counts.join(", "));
}
