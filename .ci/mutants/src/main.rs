//! Changes the reference devices, one operator or literal at a time, and lists the changes that no case notices.
//!
//! All changes are in one build, each behind a switch, so that a change costs a run and no build. The suites judge; unit tests do not
//! count. `killed` is a case or rule that fails; an inconclusive result is no kill.

mod classes;
mod processes;
mod sites;
mod tree;

use classes::Classes;
use processes::Runner;
use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use tree::Tree;

const USAGE: &str = "usage: mutants CHECKOUT WORK [--sample N] [--seed N] [--seconds N] [--processes N] [--only TEXT] [--again WORD] [--quick] [--afresh] [--strict]
  CHECKOUT     the project; what its release build has compiled is used again
  WORK         a folder for the changed copy and the results; results that are there are kept, so a run can go on
  --sample     how many of the changes that a case reaches are tried (all without it)
  --seed       which ones
  --seconds    when no further change is begun, from the start of trying
  --processes  how many changes are tried at a time (2 without it)
  --only       only changes whose description has this text, a file or a function for instance
  --again      tries again what had this outcome: survived, inconclusive, ...; may be given more than once
  --quick      each case on one variant only: some survivors would be killed on another
  --afresh     forgets the results of earlier runs
  --strict     tries only what survivors.txt does not name, and fails if more than one in a hundred is not killed";

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
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
    processes: u64,
    only: String,
    again: Vec<String>,
    is_strict: bool,
    is_quick: bool,
    is_afresh: bool,
}

impl Arguments {
    fn read() -> Result<Arguments, Failure> {
        let mut words = std::env::args().skip(1);
        let (Some(checkout), Some(work)) = (words.next(), words.next()) else { return Err(USAGE.into()) };
        let mut read = Arguments {
            checkout: fs::canonicalize(checkout)?,
            work: work.into(),
            sample: usize::MAX,
            seed: 0,
            seconds: u64::MAX,
            processes: 2,
            only: String::new(),
            again: Vec::new(),
            is_strict: false,
            is_quick: false,
            is_afresh: false,
        };
        while let Some(option) = words.next() {
            let mut value = || words.next().ok_or(USAGE);
            match option.as_str() {
                "--sample" => read.sample = value()?.parse()?,
                "--seed" => read.seed = value()?.parse()?,
                "--seconds" => read.seconds = value()?.parse()?,
                "--processes" => read.processes = value()?.parse()?,
                "--only" => read.only = value()?,
                "--again" => read.again.push(value()?),
                "--strict" => read.is_strict = true,
                "--afresh" => read.is_afresh = true,
                "--quick" => read.is_quick = true,
                _ => return Err(USAGE.into()),
            }
        }
        Ok(read)
    }
}

fn run() -> Result<bool, Failure> {
    let begin = Instant::now();
    let arguments = Arguments::read()?;
    let classes = Classes::read(&arguments.checkout.join(".ci/mutants/survivors.txt"))?;
    let tree = Tree::build(&arguments.checkout, &arguments.work.join("tree"), &classes)?;
    eprintln!("built after {} s", begin.elapsed().as_secs());
    let listed = tree.changes.iter().map(|(number, what)| format!("{number}\t{}\t{what}\n", tree.places[number]));
    fs::write(arguments.work.join("changes.txt"), listed.collect::<String>())?;
    for what in classes.gone(&tree.changes.values().map(String::as_str).collect()) {
        eprintln!("no longer there, take it out of survivors.txt: {what}");
    }
    let suites = arguments.checkout.join("suites");
    let reach = arguments.work.join("reach.txt");
    let reached = processes::reached(&tree.runner(), &suites, tree.highest(), &reach)?;
    let unreached: Vec<&str> =
        tree.changes.iter().filter(|(number, _)| !reached.contains(number)).map(|(_, what)| what.as_str()).collect();
    fs::write(arguments.work.join("unreached.txt"), unreached.join("\n") + "\n")?;
    let unknown = unreached.iter().filter(|what| classes.of(what).is_none()).count();
    eprintln!(
        "{} changes, {} unreached ({unknown} not in survivors.txt) after {} s",
        tree.changes.len(),
        unreached.len(),
        begin.elapsed().as_secs()
    );
    let results = arguments.work.join("results.txt");
    if arguments.is_afresh && results.exists() {
        fs::remove_file(&results)?;
    }
    let is_wanted = |number: &u32| {
        let what = &tree.changes[number];
        what.contains(&arguments.only) && !(arguments.is_strict && classes.of(what).is_some())
    };
    let mut numbers: Vec<u32> = reached.into_iter().filter(is_wanted).collect();
    numbers.sort_by_key(|number| sampled_at(&tree.changes[number], arguments.seed));
    numbers.truncate(arguments.sample);
    let earlier = outcomes(&results);
    let is_known = |what: &String| earlier.get(what).is_some_and(|outcome| !arguments.again.contains(&word(outcome)));
    let open: Vec<u32> = numbers.iter().copied().filter(|number| !is_known(&tree.changes[number])).collect();
    let end = Instant::now().checked_add(Duration::from_secs(arguments.seconds));
    let is_time = || end.is_none_or(|end| Instant::now() < end);
    let start = || Runner::start(&tree.runner(), &suites, &reach, arguments.is_quick);
    tried(arguments.processes, &open, &tree.changes, &results, is_time, start)?;
    let all = outcomes(&results);
    let sample = numbers.iter().map(|number| tree.changes[number].as_str());
    let sample: Vec<(&str, &str)> = sample.filter_map(|what| Some((what, all.get(what)?.as_str()))).collect();
    println!("seed {}: {} of {} changes tried", arguments.seed, sample.len(), numbers.len());
    let is_green = classes.summary(&sample);
    Ok(is_green || !arguments.is_strict)
}

/// The place of a change in the order of a seed, whatever other changes there are.
fn sampled_at(what: &str, seed: u64) -> u64 {
    mixed(what.bytes().fold(mixed(seed), |sum, byte| mixed(sum ^ u64::from(byte))))
}

/// SplitMix64.
fn mixed(seed: u64) -> u64 {
    let mut mixed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

fn word(outcome: &str) -> String {
    outcome.split(' ').next().unwrap_or_default().to_owned()
}

/// The results so far: what was changed, and the outcome.
fn outcomes(results: &Path) -> BTreeMap<String, String> {
    let text = fs::read_to_string(results).unwrap_or_default();
    text.lines()
        .filter_map(|line| line.split_once('\t'))
        .map(|(outcome, what)| (what.to_owned(), outcome.to_owned()))
        .collect()
}

/// Tries the changes on some processes, and appends each result to the file.
fn tried(
    processes: u64,
    numbers: &[u32],
    what: &BTreeMap<u32, String>,
    results: &Path,
    is_time: impl Fn() -> bool + Sync,
    start: impl Fn() -> Option<Runner> + Sync,
) -> Result<(), Failure> {
    let queue = Mutex::new(numbers.iter());
    let file = Mutex::new(fs::OpenOptions::new().create(true).append(true).open(results)?);
    std::thread::scope(|scope| {
        for _ in 0..processes {
            scope.spawn(|| {
                let mut runner: Option<Runner> = None;
                while is_time() {
                    let next = queue.lock().unwrap_or_else(PoisonError::into_inner).next().copied();
                    let Some(number) = next else { return };
                    if runner.is_none() {
                        runner = start();
                    }
                    let answer = runner.as_mut().and_then(|runner| runner.ask(number));
                    let outcome = answer.unwrap_or_else(|| "crashed".to_owned());
                    if outcome.starts_with("hung") || outcome.starts_with("crashed") {
                        runner = None;
                    }
                    let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
                    // A result that cannot be written is made again by the next run.
                    let _ = writeln!(file, "{outcome}\t{}", what[&number]);
                }
            });
        }
    });
    Ok(())
}
