//! The changed copy of the project, and its build.

use crate::Failure;
use crate::classes::Classes;
use crate::sites::{self, Change};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The crates whose sources are changed.
const CRATES: [&str; 3] = ["device-stack", "encoder-profile", "reference-devices"];
/// Files that only serve the deviations, and tests.
const LEFT_OUT: [&str; 5] = ["clock_offset.rs", "hooks.rs", "deviations.rs", "attached.rs", "tests.rs"];

/// The copy, built.
pub struct Tree {
    folder: PathBuf,
    /// The changes by their number, each with its file, its function and what is changed.
    pub changes: BTreeMap<u32, String>,
    /// File and line of each.
    pub places: BTreeMap<u32, String>,
}

/// A file of a reference device with the changes that can be made in it.
struct SourceFile {
    /// Its path in the checkout.
    path: PathBuf,
    text: String,
    /// Each with its number, from 1 over all files.
    changes: Vec<(u32, Change)>,
}

impl SourceFile {
    /// The path without what all have in common.
    fn short_path(&self) -> String {
        self.path.display().to_string().replace("device-under-test/", "").replace("/src/", "/")
    }
}

impl Tree {
    /// Copies the checkout, puts each change behind a switch, and builds the runner.
    pub fn build(checkout: &Path, folder: &Path, classes: &Classes) -> Result<Tree, Failure> {
        let mut files = find(checkout)?;
        for file in &mut files {
            let path = file.short_path();
            file.changes.retain(|(_, change)| classes.of(&format!("{path} {}", change.what)) != Some("invalid"));
        }
        share_compiled(&checkout.join("target/release"), &folder.join("target/release"))?;
        let changed: BTreeSet<&Path> = files.iter().map(|file| file.path.as_path()).collect();
        copy(checkout, folder, &changed)?;
        add_crates(checkout, folder)?;
        let all: usize = files.iter().map(|file| file.changes.len()).sum();
        eprintln!("{all} changes in {} files", files.len());
        compile(folder, &mut files)?;
        let mut tree = Tree { folder: folder.to_owned(), changes: BTreeMap::new(), places: BTreeMap::new() };
        for file in files {
            let path = file.short_path();
            for (number, change) in file.changes {
                tree.places.insert(number, format!("{}:{}", file.path.display(), change.lines.start));
                tree.changes.insert(number, format!("{path} {}", change.what));
            }
        }
        Ok(tree)
    }

    pub fn highest(&self) -> u32 {
        self.changes.keys().next_back().copied().unwrap_or(0)
    }

    pub fn runner(&self) -> PathBuf {
        self.folder.join("target/release/mutant-runner")
    }
}

/// Writes a file unless it is so already: what is written again is built again.
fn write(path: &Path, content: &[u8]) -> Result<(), Failure> {
    if fs::read(path).is_ok_and(|known| known == content) {
        return Ok(());
    }
    fs::create_dir_all(path.parent().ok_or("a file without a folder")?)?;
    Ok(fs::write(path, content)?)
}

/// Copies the files of the checkout that are under version control, with their times, without those that are changed.
fn copy(checkout: &Path, folder: &Path, changed: &BTreeSet<&Path>) -> Result<(), Failure> {
    let listed = Command::new("git").arg("-C").arg(checkout).args(["ls-files", "-z"]).output()?;
    for name in String::from_utf8(listed.stdout)?.split('\0').filter(|name| !name.is_empty()) {
        // Manifests of changed crates, and of the workspace, are written by `add_crates`; this tool is a workspace of its own.
        let is_manifest =
            name == "Cargo.toml" || CRATES.iter().any(|of| name == format!("device-under-test/{of}/Cargo.toml"));
        let is_own = [".ci/mutants/Cargo.toml", ".ci/mutants/Cargo.lock"].contains(&name);
        if is_manifest || is_own || changed.contains(Path::new(name)) || !wanted(name) {
            continue;
        }
        let (from, to) = (checkout.join(name), folder.join(name));
        // It may be deleted in the working copy.
        let Ok(content) = fs::read(&from) else { continue };
        write(&to, &content)?;
        fs::File::options().write(true).open(&to)?.set_modified(fs::metadata(&from)?.modified()?)?;
    }
    Ok(())
}

/// Whether the build needs the file.
fn wanted(name: &str) -> bool {
    !["captures/", "reports/", "docs/"].iter().any(|folder| name.starts_with(folder))
}

/// Copies what the release build of the checkout has compiled, if the copy has nothing yet, with its times: what is not changed is
/// not built again.
fn share_compiled(from: &Path, to: &Path) -> Result<(), Failure> {
    if to.exists() || !from.exists() {
        return Ok(());
    }
    fs::create_dir_all(to)?;
    for name in ["deps", "build", ".fingerprint"] {
        let copied = Command::new("cp").arg("-a").arg(from.join(name)).arg(to).status()?;
        if !copied.success() {
            return Err(format!("cannot copy {}", from.join(name).display()).into());
        }
    }
    Ok(())
}

/// Reads the sources of the reference devices and finds what can be changed.
fn find(checkout: &Path) -> Result<Vec<SourceFile>, Failure> {
    let mut paths = Vec::new();
    for name in CRATES {
        walk(&checkout.join("device-under-test").join(name).join("src"), &mut paths)?;
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
        files.push(SourceFile { path: path.strip_prefix(checkout)?.to_owned(), text, changes });
    }
    Ok(files)
}

fn walk(folder: &Path, paths: &mut Vec<PathBuf>) -> Result<(), Failure> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            if name != "tests" {
                walk(&path, paths)?;
            }
        } else if name.ends_with(".rs") && !LEFT_OUT.contains(&name.as_str()) {
            paths.push(path);
        }
    }
    Ok(())
}

/// Adds the switch and the runner to the copied workspace.
fn add_crates(checkout: &Path, folder: &Path) -> Result<(), Failure> {
    let text = fs::read_to_string(checkout.join("Cargo.toml"))?;
    let members = "    \".ci/mutants/switch\",\n    \".ci/mutants/runner\",\n";
    let text = text.replacen("members = [\n", &format!("members = [\n{members}"), 1);
    write(&folder.join("Cargo.toml"), text.as_bytes())?;
    for name in CRATES {
        let manifest = Path::new("device-under-test").join(name).join("Cargo.toml");
        let text = fs::read_to_string(checkout.join(&manifest))?;
        let switch = "[dependencies]\nmutant-switch = { path = \"../../.ci/mutants/switch\" }\n";
        // Changed sources have lints that nobody reads.
        let text = text.replacen("[dependencies]\n", switch, 1).replacen("[lints]\nworkspace = true\n", "", 1);
        write(&folder.join(manifest), text.as_bytes())?;
    }
    Ok(())
}

/// Builds the runner with all changes. What does not compile is left out, and the build is repeated.
fn compile(folder: &Path, files: &mut [SourceFile]) -> Result<(), Failure> {
    loop {
        for file in files.iter() {
            let changes: Vec<(u32, &Change)> = file.changes.iter().map(|(number, change)| (*number, change)).collect();
            write(&folder.join(&file.path), sites::instrumented(&file.text, &changes).as_bytes())?;
        }
        let built = Command::new("cargo")
            .current_dir(folder)
            .args(["build", "--release", "-p", "mutant-runner", "--message-format=json", "--quiet"])
            .stderr(Stdio::null())
            .output()?;
        if built.status.success() {
            return Ok(());
        }
        let output = String::from_utf8_lossy(&built.stdout);
        let wrong = wrong_lines(&output)?;
        let before: usize = files.iter().map(|file| file.changes.len()).sum();
        for file in files.iter_mut() {
            let short = file.short_path();
            let path = file.path.clone();
            file.changes.retain(|(_, change)| {
                let is_wrong = change.lines.clone().any(|line| wrong.contains(&(path.clone(), line)));
                if is_wrong {
                    eprintln!("does not compile, see `invalid` in survivors.txt: {short} {}", change.what);
                }
                !is_wrong
            });
        }
        let after: usize = files.iter().map(|file| file.changes.len()).sum();
        if before == after {
            return Err(format!("the changed copy does not build, and no change is to blame:\n{output}").into());
        }
    }
}

/// The lines of files to which the errors of a build point.
fn wrong_lines(messages: &str) -> Result<BTreeSet<(PathBuf, usize)>, Failure> {
    let mut wrong = BTreeSet::new();
    for line in messages.lines() {
        let message: serde_json::Value = serde_json::from_str(line)?;
        if message["message"]["level"] != "error" {
            continue;
        }
        for span in message["message"]["spans"].as_array().into_iter().flatten() {
            if span["is_primary"] != true {
                continue;
            }
            let file = PathBuf::from(span["file_name"].as_str().unwrap_or_default());
            for line in span["line_start"].as_u64().unwrap_or(0)..=span["line_end"].as_u64().unwrap_or(0) {
                wrong.insert((file.clone(), usize::try_from(line)?));
            }
        }
    }
    Ok(wrong)
}
