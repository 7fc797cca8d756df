//! Rules of this codebase, checked in the sources. Rules that the compiler checks are only tested for being enabled.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

pub fn root() -> PathBuf {
    testing::workspace().canonicalize().expect("the workspace")
}

pub fn files(folder: impl AsRef<Path>, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let folder = root().join(folder);
    let mut folders = vec![folder.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
            let path = entry.expect("an entry of a folder").path();
            if path.is_dir() && path.file_name().is_none_or(|name| name != "target") {
                folders.push(path);
            } else if path.extension().is_some_and(|found| found == extension) {
                found.push(path);
            }
        }
    }
    assert!(!found.is_empty(), "there is no .{extension} file under {}", folder.display());
    found.sort();
    found
}

pub fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

pub fn relative_path(path: &Path) -> String {
    path.strip_prefix(root()).expect("inside the workspace").display().to_string()
}

/// Lines of code that contain one of `words`, as `file:line`. Comments are ignored.
fn lines_with(paths: &[PathBuf], words: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    for path in paths {
        for (number, line) in text(path).lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            if words.iter().any(|word| code.contains(word)) {
                found.push(format!("{}:{}: {}", relative_path(path), number + 1, line.trim()));
            }
        }
    }
    found
}

fn dependencies(manifest: &str) -> Vec<String> {
    let manifest = text(&root().join(manifest));
    let section = manifest.split("[dependencies]").nth(1).unwrap_or_default();
    section
        .lines()
        .take_while(|line| !line.starts_with('['))
        .filter_map(|line| line.split(['=', '.']).next())
        .map(|name| name.trim().to_owned())
        .filter(|name| !name.is_empty() && !name.starts_with('#'))
        .collect()
}

#[test]
fn unsafe_code_is_forbidden_outside_the_link_crate() {
    let workspace = text(&root().join("Cargo.toml"));
    assert!(workspace.contains("unsafe_code = \"forbid\""));
    let manifests: Vec<_> = files("harness", "toml").into_iter().chain(files("device-under-test", "toml")).collect();
    for manifest in manifests.iter().filter(|path| path.ends_with("Cargo.toml")) {
        if relative_path(manifest) == "harness/link/Cargo.toml" {
            assert!(
                text(manifest).contains("unsafe_code = \"deny\""),
                "the link crate must deny unsafe code by default"
            );
        } else {
            assert!(
                text(manifest).contains("[lints]\nworkspace = true"),
                "{} does not inherit the lints of the workspace",
                relative_path(manifest)
            );
        }
    }
}

#[test]
fn unsafe_code_is_in_one_folder_and_has_safety_comments() {
    let sources: Vec<_> = files("harness", "rs").into_iter().chain(files("device-under-test", "rs")).collect();
    let sources: Vec<_> = sources.into_iter().filter(|path| relative_path(path) != file!()).collect();
    let folder = "harness/link/src/sys/";
    let found = lines_with(&sources, &["unsafe {", "unsafe fn", "unsafe impl", "(unsafe_code"]);
    let (inside, outside): (Vec<_>, Vec<_>) = found.into_iter().partition(|line| line.starts_with(folder));
    assert_eq!(outside, [""; 0]);
    assert!(!inside.is_empty(), "there is no unsafe code in {folder}");
    for path in sources.iter().filter(|path| relative_path(path).starts_with(folder)) {
        let text = text(path);
        let lines: Vec<_> = text.lines().collect();
        for (number, _) in lines.iter().enumerate().filter(|(_, line)| line.contains("unsafe {")) {
            let reason = lines[number.saturating_sub(3)..number].iter().any(|line| line.contains("// SAFETY:"));
            assert!(reason, "{}:{}: a `SAFETY:` comment is missing", relative_path(path), number + 1);
        }
    }
}

#[test]
fn only_the_link_crate_opens_sockets() {
    let sources: Vec<_> = files("harness", "rs")
        .into_iter()
        .chain(files("device-under-test", "rs"))
        .filter(|path| !relative_path(path).starts_with("harness/link/") && relative_path(path) != file!())
        .collect();
    let words = [
        "TcpStream",
        "TcpListener",
        "UdpSocket",
        "UnixStream",
        "UnixListener",
        "RawFd",
        "pnet",
        "libc::",
        "signal_hook",
    ];
    assert_eq!(lines_with(&sources, &words), [""; 0]);
    for manifest in files("harness", "toml").into_iter().chain(files("device-under-test", "toml")) {
        if manifest.ends_with("Cargo.toml") && relative_path(&manifest) != "harness/link/Cargo.toml" {
            let named = dependencies(&relative_path(&manifest));
            let sockets = named.iter().find(|name| {
                ["pnet", "pnet_datalink", "libc", "signal-hook", "rustix", "nix"].contains(&name.as_str())
            });
            assert_eq!(
                sockets,
                None,
                "{} depends on a library that only the link crate may use",
                relative_path(&manifest)
            );
        }
    }
}

#[test]
fn the_link_crate_depends_on_no_protocol() {
    for name in dependencies("harness/link/Cargo.toml") {
        let allowed = ["plain-text", "station", "libc", "pnet_datalink", "rustix", "signal-hook", "thiserror"]
            .contains(&name.as_str());
        assert!(allowed, "link depends on {name}");
    }
}

#[test]
fn crates_without_io_are_no_std() {
    let harness = ["harness/station", "harness/plain-text", "harness/wire", "harness/controllers"];
    for name in harness.iter().chain(&DEVICES.map(|(name, _)| name)) {
        let library = text(&root().join(name).join("src/lib.rs"));
        assert!(library.contains("#![no_std]"), "{name} is not no_std");
    }
}

/// The device crates from bottom to top, each with its allowed dependencies beside `station` and `wire`.
const DEVICES: [(&str, &[&str]); 7] = [
    ("device-under-test/device-stack", &["smoltcp"]),
    ("device-under-test/encoder-profile", &["device-stack"]),
    ("device-under-test/reference-devices", &["device-stack", "encoder-profile"]),
    ("device-under-test/deviation-hooks", &["device-stack", "encoder-profile", "reference-devices"]),
    ("device-under-test/slave-bugs", &["deviation-hooks", "device-stack", "reference-devices"]),
    (
        "device-under-test/bugs",
        &["deviation-hooks", "device-stack", "encoder-profile", "reference-devices", "slave-bugs"],
    ),
    (
        "device-under-test/deviations",
        &["bugs", "deviation-hooks", "device-stack", "encoder-profile", "reference-devices", "thiserror"],
    ),
];

#[test]
fn controllers_and_devices_depend_on_wire_and_station_only() {
    for name in dependencies("harness/controllers/Cargo.toml") {
        let allowed = ["plain-text", "station", "wire", "smoltcp", "thiserror"].contains(&name.as_str());
        assert!(allowed, "the controllers depend on {name}");
    }
    for (folder, below) in DEVICES {
        for name in dependencies(&format!("{folder}/Cargo.toml")) {
            let allowed = ["station", "wire"].iter().chain(below).any(|allowed| *allowed == name);
            assert!(allowed, "{folder} depends on {name}");
        }
    }
    // Programs behind the stacks are processes, which need an operating system.
    let with_processes = "device-under-test/application-protocol";
    for name in dependencies(&format!("{with_processes}/Cargo.toml")) {
        let allowed = ["device-stack", "plain-text", "serde", "serde_json", "station", "thiserror", "wire"];
        assert!(allowed.contains(&name.as_str()), "{with_processes} depends on {name}");
    }
    assert_eq!(files("device-under-test", "toml").len(), DEVICES.len() + 1, "a device crate is missing in DEVICES");
    for name in dependencies("harness/wire/Cargo.toml") {
        assert!(["smoltcp", "thiserror"].contains(&name.as_str()), "wire depends on {name}");
    }
    assert!(dependencies("harness/station/Cargo.toml").is_empty());
}

#[test]
fn the_wire_crate_does_not_use_time() {
    let words = ["Duration", "Instant", "station::"];
    let sources: Vec<_> = files("harness/wire", "rs")
        .into_iter()
        .filter(|path| relative_path(path).starts_with("harness/wire/src"))
        .collect();
    assert_eq!(lines_with(&sources, &words), [""; 0]);
}

#[test]
fn suites_and_reference_devices_are_independent() {
    let devices = files("device-under-test", "rs");
    assert_eq!(lines_with(&devices, &["suites/", "include_str!", "include_bytes!"]), [""; 0]);
    for suite in files("suites", "yaml") {
        assert!(!text(&suite).contains("device-under-test"), "{} mentions the reference device", relative_path(&suite));
    }
}

#[test]
fn the_harness_names_no_device() {
    let sources: Vec<_> =
        files("harness", "rs").into_iter().filter(|path| relative_path(path).contains("/src/")).collect();
    let words = ["xac77", "XAC77", "afs60", "AFx60", "a3m60", "amt58", "sendix", "Lika ", "LIKA"];
    let found: Vec<_> =
        lines_with(&sources, &words).into_iter().filter(|line| !line.contains("#[case") && !in_tests(line)).collect();
    assert_eq!(found, [""; 0]);
}

/// Whether a line is in a unit test, which may use examples from manuals: after `mod tests` in a file, or in `tests.rs`.
fn in_tests(line: &str) -> bool {
    let mut parts = line.splitn(3, ':');
    let (Some(file), Some(number)) = (parts.next(), parts.next()) else { return false };
    let number: usize = number.parse().expect("a line number");
    file.ends_with("tests.rs")
        || file.contains("/tests/")
        || text(&root().join(file)).lines().take(number).any(|line| line.starts_with("mod tests"))
}

#[test]
fn only_one_file_uses_the_yaml_library() {
    let sources = files("harness", "rs");
    let found: Vec<_> = lines_with(&sources, &["saphyr_parser"])
        .into_iter()
        .filter(|line| !line.starts_with("harness/suite-yaml/src/yaml.rs:"))
        .filter(|line| !line.starts_with(file!()))
        .collect();
    assert_eq!(found, [""; 0]);
}

#[test]
fn thread_sleep_is_not_used() {
    let sources: Vec<_> = files("harness", "rs").into_iter().chain(files("device-under-test", "rs")).collect();
    let found: Vec<_> =
        lines_with(&sources, &["thread::sleep"]).into_iter().filter(|line| !line.starts_with(file!())).collect();
    assert_eq!(found, [""; 0]);
}

#[test]
fn files_stay_small() {
    for path in files("harness", "rs").into_iter().chain(files("device-under-test", "rs")) {
        let lines = text(&path).lines().count();
        assert!(lines <= 800, "{} has {lines} lines: split it", relative_path(&path));
    }
}

#[test]
fn lines_of_yaml_are_at_most_140_characters_long() {
    let mut found = Vec::new();
    for path in ["suites", "harness", ".ci"].into_iter().flat_map(|folder| files(folder, "yaml")) {
        for (number, line) in text(&path).lines().enumerate().filter(|(_, line)| line.chars().count() > 140) {
            found.push(format!("{}:{}: {} characters", relative_path(&path), number + 1, line.chars().count()));
        }
    }
    assert_eq!(found, [""; 0]);
}

/// What a fuzz target reads by way of another type.
const FUZZED_INSIDE: [&str; 1] = ["Ipv4"];

#[test]
fn each_format_of_the_wire_has_a_fuzz_target() {
    let targets = text(&root().join("fuzz/src/wires.rs"));
    let (mut count, mut missing) = (0, Vec::new());
    for path in files("harness/wire/src", "rs") {
        let mut parsed = String::new();
        for line in text(&path).lines() {
            if let Some(rest) = line.strip_prefix("impl") {
                let rest = rest.strip_prefix("<'a>").unwrap_or(rest).trim_start();
                parsed = rest.chars().take_while(|letter| letter.is_alphanumeric()).collect();
            } else if line.starts_with("    pub fn parse") {
                count += 1;
                if !targets.contains(&format!("{parsed}::parse")) && !FUZZED_INSIDE.contains(&parsed.as_str()) {
                    missing.push(format!("{}: {parsed}", relative_path(&path)));
                }
            }
        }
    }
    assert!(count > 40, "only {count} formats were found");
    assert_eq!(missing, [""; 0], "formats without a fuzz target");
}

/// The entries, name and rest of the line, in the sections of a manifest whose heading ends with `section`.
fn entries(manifest: &str, section: &str) -> Vec<(String, String)> {
    let mut inside = false;
    let mut found = Vec::new();
    for line in manifest.lines().map(str::trim) {
        if let Some(head) = line.strip_prefix('[') {
            inside =
                head.strip_suffix(']').is_some_and(|head| head == section || head.ends_with(&format!(".{section}")));
        } else if let Some((name, rest)) = line.split_once(['.', '=', ' ']).filter(|_| inside && !line.starts_with('#'))
        {
            found.push((name.to_owned(), rest.to_owned()));
        }
    }
    found
}

/// The dependency table in CONTRIBUTING.md has a row for each third-party crate in the manifests, and no other.
#[test]
fn each_dependency_has_a_row_that_says_why() {
    let page = text(&root().join("CONTRIBUTING.md"));
    let section = page.split("\n## ").find(|section| section.starts_with("Dependencies\n"));
    let section = section.expect("CONTRIBUTING.md has a section Dependencies");
    let mut rows = BTreeSet::new();
    for row in section.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        let [name, purpose, weighed] = cells[..] else { panic!("a row needs three cells: {row}") };
        assert!(purpose.len() > 10 && weighed.len() > 10, "a cell is too short: {row}");
        assert!(rows.insert(name.trim_matches('`').to_owned()), "{name} has two rows");
    }
    let workspace = entries(&text(&root().join("Cargo.toml")), "workspace.dependencies");
    let (own, third_party): (Vec<_>, Vec<_>) = workspace.into_iter().partition(|(_, rest)| rest.contains("path ="));
    let own: BTreeSet<String> = own.into_iter().map(|(name, _)| name).collect();
    let third_party: BTreeSet<String> = third_party.into_iter().map(|(name, _)| name).collect();
    let mut used = BTreeSet::new();
    for folder in ["harness", "device-under-test", "suites"].iter().filter(|folder| has_manifest(folder)) {
        for manifest in files(folder, "toml").iter().filter(|path| path.ends_with("Cargo.toml")) {
            for section in ["dependencies", "dev-dependencies", "build-dependencies"] {
                let named = entries(&text(manifest), section).into_iter().map(|(name, _)| name);
                used.extend(named.filter(|name| !own.contains(name)));
            }
        }
    }
    assert_eq!(
        third_party.difference(&used).collect::<Vec<_>>(),
        [""; 0],
        "a dependency of the workspace that no crate uses"
    );
    assert!(used.len() > 15, "only these dependencies were found: {used:?}");
    assert_eq!(used.difference(&rows).collect::<Vec<_>>(), [""; 0], "a row is missing");
    assert_eq!(rows.difference(&used).collect::<Vec<_>>(), [""; 0], "a row is stale");
}

fn has_manifest(folder: &str) -> bool {
    fs::read_dir(root().join(folder))
        .into_iter()
        .flatten()
        .flatten()
        .any(|entry| entry.path().join("Cargo.toml").is_file() || entry.file_name() == "Cargo.toml")
}

/// A section of a page, from its heading to the next one.
fn section(page: &str, heading: &str) -> String {
    let text = text(&root().join(page));
    let found = text.split("\n## ").find_map(|section| section.strip_prefix(&format!("{heading}\n")));
    found.unwrap_or_else(|| panic!("{page} has no section {heading}")).to_owned()
}

/// The paths in backquotes that a text names; commands, globs and addresses are none.
fn paths(text: &str) -> Vec<&str> {
    let is_path = |name: &&str| {
        name.contains('/') && !name.contains([' ', '<', '*', ':', '$', '=']) && !name.starts_with(['/', '-'])
    };
    text.split('`').skip(1).step_by(2).filter(is_path).collect()
}

#[test]
fn the_paths_of_the_source_map_exist() {
    let map = section("CONTRIBUTING.md", "Source map");
    let named = paths(&map);
    let absent: Vec<_> = named.iter().filter(|path| !root().join(path).exists()).collect();
    assert_eq!(absent, [&""; 0], "paths of the source map that do not exist");
    for folder in ["harness", "device-under-test"] {
        for manifest in files(folder, "toml").iter().filter(|path| path.ends_with("Cargo.toml")) {
            let source = relative_path(&manifest.with_file_name("src"));
            assert!(named.iter().any(|path| path.starts_with(&source)), "{source} is not in the source map");
        }
    }
}

/// The minimum number of topics of the index.
const FEWEST_TOPICS: usize = 25;

#[test]
fn the_paths_of_the_topic_index_exist() {
    let index = section("CONTRIBUTING.md", "I look for");
    let rows: Vec<&str> = index.lines().filter(|line| line.starts_with("- ")).collect();
    assert!(rows.len() >= FEWEST_TOPICS, "the index has {} topics", rows.len());
    for row in rows {
        let named = paths(row);
        assert!(!named.is_empty(), "no path in {row}");
        assert!(named.iter().all(|path| root().join(path).exists()), "a path does not exist: {row}");
    }
}

#[test]
fn the_paths_and_links_of_the_readme_exist() {
    let readme = text(&root().join("README.md"));
    for path in paths(&readme) {
        assert!(root().join(path).exists(), "README.md names {path}, which does not exist");
    }
    for link in readme.split(['(', '"']).filter_map(|rest| rest.split([')', '"', '#', ' ']).next()) {
        if ["docs/", "captures/"].iter().any(|folder| link.starts_with(folder)) || link.ends_with(".md") {
            assert!(root().join(link).exists(), "README.md links to {link}, which does not exist");
        }
    }
}

/// The maximum number of files between a case and its verdict.
const LONGEST_PATH: usize = 18;

/// The heading of the section in CONTRIBUTING.md that lists the files between a case and its verdict.
const PATH_SECTION: &str = "## The way from YAML to verdict";

/// The numbered list of the section [`PATH_SECTION`] in CONTRIBUTING.md: each file, with the function that it names.
fn files_of_the_path() -> Vec<(String, Option<String>)> {
    let text = text(&root().join("CONTRIBUTING.md"));
    let section = text.split(PATH_SECTION).nth(1).expect("the section");
    let section = section.split("\n## ").next().unwrap_or_default();
    let lines =
        section.lines().filter_map(|line| line.split_once(". `").filter(|(number, _)| number.parse::<u8>().is_ok()));
    lines
        .map(|(_, line)| {
            let (path, rest) = line.split_once('`').expect("a path in backquotes");
            let function =
                rest.strip_prefix(" `").and_then(|rest| rest.split_once('`')).map(|(name, _)| name.to_owned());
            (path.to_owned(), function)
        })
        .collect()
}

/// Whether a line calls a function. Definitions and comments are ignored.
fn calls(line: &str, function: &str) -> bool {
    let code = line.split("//").next().unwrap_or_default();
    code.match_indices(&format!("{function}(")).any(|(at, _)| {
        let before = &code[..at];
        !before.ends_with("fn ") && !before.ends_with(|last: char| last.is_alphanumeric() || last == '_')
    })
}

#[test]
fn the_path_from_yaml_to_verdict_is_short_and_correct() {
    let path = files_of_the_path();
    assert!(path.len() > 10 && path.len() <= LONGEST_PATH, "the path has {} files", path.len());
    let (suite, sources) = path.split_first().expect("a path");
    let case = text(&root().join(&suite.0));
    assert!(case.contains("set:") && case.contains("expect:"), "{} has no such case", suite.0);
    let all = files("harness", "rs");
    let all: Vec<_> = all
        .iter()
        .filter(|path| !relative_path(path).contains("/tests/"))
        .map(|path| (relative_path(path), text(path)))
        .collect();
    for (path, function) in sources {
        let function = function.as_deref().unwrap_or_else(|| panic!("{path}: a function is missing"));
        let own = all.iter().find(|(known, _)| known == path).unwrap_or_else(|| panic!("{path} does not exist"));
        assert!(own.1.contains(&format!("fn {function}")), "{path} defines no `{function}`");
        let others = || all.iter().filter(|(known, _)| known != path);
        let is_called = others().any(|(_, text)| text.lines().any(|line| calls(line, function)));
        assert!(is_called, "nothing outside {path} calls `{function}`");
    }
    let mut unique: Vec<&str> = path.iter().map(|(file, _)| file.as_str()).collect();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), path.len(), "a file is listed twice");
}
