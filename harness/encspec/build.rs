//! Says from which commit the program is built, for `encspec --version` and the reports; nothing where that is not known.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// How many digits of a commit are shown.
const DIGITS: usize = 12;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let here = env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from).unwrap_or_default();
    let (commit, date) = of_git(&here).or_else(|| of_package(&here)).unwrap_or_default();
    println!("cargo::rustc-env=ENCSPEC_COMMIT={commit}");
    println!("cargo::rustc-env=ENCSPEC_COMMIT_DATE={date}");
}

/// Commit and date of a checkout of encspec, not of another repository around a copy of the sources.
fn of_git(here: &Path) -> Option<(String, String)> {
    git(here, &["ls-files", "--error-unmatch", "build.rs"])?;
    for path in ["HEAD", "logs/HEAD"] {
        let file = here.join(git(here, &["rev-parse", "--git-path", path])?);
        if file.is_file() {
            println!("cargo::rerun-if-changed={}", file.display());
        }
    }
    let said = git(here, &["log", "-1", "--format=%H %cs"])?;
    let (commit, date) = said.split_once(' ')?;
    Some((commit.get(..DIGITS)?.to_owned(), date.to_owned()))
}

/// The commit that `cargo package` noted in a published package.
fn of_package(here: &Path) -> Option<(String, String)> {
    let text = fs::read_to_string(here.join(".cargo_vcs_info.json")).ok()?;
    let (_, after) = text.split_once("\"sha1\"")?;
    let commit = after.split('"').nth(1)?.get(..DIGITS)?;
    commit.bytes().all(|octet| octet.is_ascii_hexdigit()).then(|| (commit.to_owned(), String::new()))
}

fn git(here: &Path, arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").arg("-C").arg(here).args(arguments).output().ok()?;
    let said = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| said.trim().to_owned())
}
