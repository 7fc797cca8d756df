//! Load errors: each folder below `tests/load_errors` holds a file with an error, and the complete error message.
//!
//! `probe/topic/NAME/case.yaml` replaces `probe/topic.yaml` in the small manual (`tests/fixtures`), and so on; a `device.yaml` is
//! loaded with the requirements only. `error.txt` is the message: `INSTA_UPDATE=always cargo test -p encspec --test integration
//! load_errors` writes it. Without the error the file would load, so a test fails if the error is not detected.

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

/// Loads the case in a folder and compares the message.
fn check(folder: &Path) -> Result<(), String> {
    let shown = folder.strip_prefix(root()).unwrap_or(folder).display().to_string();
    let file = |name: &str| fs::read_to_string(folder.join(name)).map_err(|error| format!("{shown}/{name}: {error}"));
    let of =
        shown.rsplit_once('/').ok_or_else(|| format!("{shown} is not below the name of a file of the small manual"))?.0;
    let Err(errors) = load(&small_manual::with(&format!("{of}.yaml"), file(CASE)?), None) else {
        return Err(format!("{shown}: it loads without an error"));
    };
    let observed = format!("{errors}\n");
    if std::env::var_os("INSTA_UPDATE").is_some_and(|how| how == "always") {
        return fs::write(folder.join(ERROR), observed).map_err(|error| format!("{shown}/{ERROR}: {error}"));
    }
    let expected = file(ERROR)?;
    if observed == expected { Ok(()) } else { Err(format!("{shown}\n{}", difference(&expected, &observed))) }
}

/// A line diff: ` ` marks lines of both texts, `-` expected lines, `+` observed lines.
fn difference(expected: &str, observed: &str) -> String {
    let (expected, observed): (Vec<&str>, Vec<&str>) = (expected.lines().collect(), observed.lines().collect());
    let head = expected.iter().zip(&observed).take_while(|(one, other)| one == other).count();
    let from_the_end = expected[head..].iter().rev().zip(observed[head..].iter().rev());
    let tail = from_the_end.take_while(|(one, other)| one == other).count();
    let lines = |mark: char, lines: &[&str]| lines.iter().map(|line| format!("{mark} {line}\n")).collect::<String>();
    [
        lines(' ', &expected[..head]),
        lines('-', &expected[head..expected.len() - tail]),
        lines('+', &observed[head..observed.len() - tail]),
        lines(' ', &expected[expected.len() - tail..]),
    ]
    .concat()
}

#[rstest]
fn refused(#[files("tests/load_errors/*/*/*/case.yaml")] case: PathBuf) {
    if let Err(wrong) = check(case.parent().expect("a file in a folder")) {
        panic!("{wrong}");
    }
}

/// Folders added since the tests were built are checked too, and folders with missing files are found.
#[test]
fn every_folder_is_checked() {
    let (mut folders, mut cases, mut wrong) = (vec![root()], 0, Vec::new());
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("an entry").path());
        let (inside, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
        let names: BTreeSet<_> = files.iter().filter_map(|path| path.file_name()).collect();
        if inside.is_empty() {
            cases += 1;
            wrong.extend(check(&folder).err());
        }
        let whole = if inside.is_empty() { BTreeSet::from([CASE.as_ref(), ERROR.as_ref()]) } else { BTreeSet::new() };
        if names != whole {
            wrong.push(format!("{}: expected the files {whole:?}, observed {names:?}", folder.display()));
        }
        folders.extend(inside);
    }
    assert!(cases > 200, "only {cases} folders were checked");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_difference_is_shown_line_by_line() {
    assert_eq!(difference("a\nb\nc\n", "a\nx\ny\nc\n"), "  a\n- b\n+ x\n+ y\n  c\n");
    assert_eq!(difference("a\n", ""), "- a\n");
}
