//! What the loader refuses: each folder below `tests/load_errors` is a mistake, and the whole of what is said about it.
//!
//! `probe/topic/NAME/case.yaml` stands for `probe/topic.yaml` in the small manual (`tests/fixtures`), and so on; a `device.yaml` has
//! only the requirements beside it. `error.txt` is the message: `INSTA_UPDATE=always cargo test -p encspec --test integration
//! load_errors` writes it. Without the mistake the file would load, so that a test fails if the mistake is let through.

use crate::small_manual;
use encspec::suite_yaml::load;
use rstest::rstest;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

const CASE: &str = "case.yaml";
const ERROR: &str = "error.txt";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/load_errors")
}

/// What is wrong with the folder of a case.
fn look(folder: &Path) -> Result<(), String> {
    let shown = folder.strip_prefix(root()).unwrap_or(folder).display().to_string();
    let file = |name: &str| fs::read_to_string(folder.join(name)).map_err(|error| format!("{shown}/{name}: {error}"));
    let of = shown.rsplit_once('/').ok_or_else(|| format!("{shown} names no file of the small manual"))?.0;
    let Err(errors) = load(&small_manual::with(&format!("{of}.yaml"), file(CASE)?), None) else {
        return Err(format!("{shown}: it loads, and nothing is said"));
    };
    let seen = format!("{errors}\n");
    if std::env::var_os("INSTA_UPDATE").is_some_and(|how| how == "always") {
        return fs::write(folder.join(ERROR), seen).map_err(|error| format!("{shown}/{ERROR}: {error}"));
    }
    let wanted = file(ERROR)?;
    if seen == wanted { Ok(()) } else { Err(format!("{shown}\n{}", difference(&wanted, &seen))) }
}

/// Both texts line by line: ` ` in both, `-` wanted only, `+` seen only.
fn difference(wanted: &str, seen: &str) -> String {
    let (wanted, seen): (Vec<&str>, Vec<&str>) = (wanted.lines().collect(), seen.lines().collect());
    let alike = wanted.iter().zip(&seen).take_while(|(wanted, seen)| wanted == seen).count();
    let behind = wanted[alike..].iter().rev().zip(seen[alike..].iter().rev());
    let alike_behind = behind.take_while(|(wanted, seen)| wanted == seen).count();
    let lines = |mark: char, lines: &[&str]| lines.iter().map(|line| format!("{mark} {line}\n")).collect::<String>();
    [
        lines(' ', &wanted[..alike]),
        lines('-', &wanted[alike..wanted.len() - alike_behind]),
        lines('+', &seen[alike..seen.len() - alike_behind]),
        lines(' ', &wanted[wanted.len() - alike_behind..]),
    ]
    .concat()
}

#[rstest]
fn refused(#[files("tests/load_errors/*/*/*/case.yaml")] case: PathBuf) {
    if let Err(wrong) = look(case.parent().expect("a file in a folder")) {
        panic!("{wrong}");
    }
}

/// A folder that has come since the tests were built is looked at too, and one without one of its files is found.
#[test]
fn every_folder_is_looked_at() {
    let (mut folders, mut cases, mut wrong) = (vec![root()], 0, Vec::new());
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("an entry").path());
        let (inside, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
        let names: BTreeSet<_> = files.iter().filter_map(|path| path.file_name()).collect();
        if inside.is_empty() {
            cases += 1;
            wrong.extend(look(&folder).err());
        }
        let whole = if inside.is_empty() { BTreeSet::from([CASE.as_ref(), ERROR.as_ref()]) } else { BTreeSet::new() };
        if names != whole {
            wrong.push(format!("{}: it has {names:?}, which are to be {whole:?}", folder.display()));
        }
        folders.extend(inside);
    }
    assert!(cases > 200, "only {cases} folders were looked at");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_difference_is_shown_line_by_line() {
    assert_eq!(difference("a\nb\nc\n", "a\nx\ny\nc\n"), "  a\n- b\n+ x\n+ y\n  c\n");
    assert_eq!(difference("a\n", ""), "- a\n");
}
