//! The names and words of the project: a type name is defined once, and texts use the terms of the field instead of words that
//! only this project would understand.

use crate::code_rules::{files, relative_path, text};
use std::collections::{BTreeMap, BTreeSet};

/// Type names that are defined in several files, each with the reason.
const SHARED_NAMES: &[(&str, &str)] = &[];

/// The most names, in percent, that may be defined more than once.
const SHARED_AT_MOST: f64 = 3.0;

/// The name of the type that a line defines, if it defines one. Associated types do not count.
fn defined_type(line: &str) -> Option<&str> {
    let line = match line.strip_prefix("pub(") {
        Some(rest) => rest.split_once(") ")?.1,
        None => line.strip_prefix("pub ").unwrap_or(line),
    };
    let rest = ["struct ", "enum ", "trait ", "union ", "type "].iter().find_map(|word| line.strip_prefix(word))?;
    let name = rest.split(|letter: char| !letter.is_alphanumeric() && letter != '_').next()?;
    name.starts_with(char::is_uppercase).then_some(name)
}

#[test]
fn a_type_name_is_defined_once() {
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for path in files("harness", "rs").into_iter().chain(files("device-under-test", "rs")) {
        for line in text(&path).lines() {
            let is_associated = line.starts_with(' ') && line.trim_start().starts_with("type ");
            if let Some(name) = defined_type(line.trim_start()).filter(|_| !is_associated) {
                found.entry(name.to_owned()).or_default().insert(relative_path(&path));
            }
        }
    }
    assert!(found.len() > 1000, "only {} types were found", found.len());
    let shared: BTreeMap<_, _> = found.iter().filter(|(_, files)| files.len() > 1).collect();
    for (name, files) in &shared {
        let reason = SHARED_NAMES.iter().find(|(shared, _)| shared == name);
        assert!(reason.is_some(), "`{name}` is defined in {files:?}: give each a name that says what it holds");
    }
    for (name, reason) in SHARED_NAMES {
        assert!(shared.contains_key(&(*name).to_owned()), "`{name}` is defined once; delete its exception ({reason})");
    }
    let percent = shared.len() as f64 / found.len() as f64 * 100.0;
    assert!(percent < SHARED_AT_MOST, "{percent:.1} % of the type names are defined more than once");
}

/// Words that only this project would use, each with what to write instead.
const PRIVATE_WORDS: &[(&str, &str)] = &[
    ("stranger", "peer, third-party tool"),
    ("strangers", "peers, third-party tools"),
    ("told", "reported"),
    ("mended", "fixed"),
    ("halts", "stalls"),
    ("halted", "stalled"),
    ("nobody", "no station, no controller"),
    ("somebody", "a controller, another program"),
    ("everybody", "all stations"),
    ("hears", "receives"),
    ("manner", "persona, like"),
    ("healthy", "conforming"),
    ("anew", "again"),
];

/// Files in which such a word is right, each with the word and the reason.
const EXCEPTIONS: &[(&str, &str, &str)] = &[
    ("harness/link/tests/process.rs", "nobody", "the user of Unix"),
    ("harness/wire/tests/golden/frames.py", "nobody", "the payload of a recorded frame"),
    ("harness/wire/tests/integration/frames_scapy.rs", "nobody", "the payload of a recorded frame"),
];

#[test]
fn texts_use_the_terms_of_the_field() {
    let folders =
        [("harness", "rs"), ("harness", "py"), ("harness", "yaml"), ("device-under-test", "rs"), ("suites", "yaml")];
    let mut paths: Vec<_> = folders.iter().flat_map(|(folder, extension)| files(folder, extension)).collect();
    for (folder, extension) in [("docs", "md"), (".ci", "py")] {
        paths.extend(files(folder, extension));
    }
    let scripts =
        ["live", "pages", "pictures", "referee", "browser", "run", "peers/run", "peers/install", "waiting-times"];
    let pages = ["README.md", "CONTRIBUTING.md", "captures/README.md"];
    let others = scripts.iter().map(|name| format!(".ci/{name}")).chain(pages.map(str::to_owned));
    paths.extend(others.map(|name| testing::workspace().canonicalize().expect("the workspace").join(name)));
    let mut found = Vec::new();
    for path in paths {
        let name = relative_path(&path);
        let is_exception = |word: &str| EXCEPTIONS.iter().any(|(file, known, _)| *file == name && *known == word);
        if name.ends_with("integration/wording.rs") {
            continue;
        }
        for (number, line) in text(&path).lines().enumerate() {
            for word in line.to_lowercase().split(|letter: char| !letter.is_alphabetic()) {
                let instead = PRIVATE_WORDS.iter().find(|(private, _)| *private == word);
                if let Some((_, instead)) = instead.filter(|_| !is_exception(word)) {
                    found.push(format!("{name}:{}: `{word}`, write {instead}: {}", number + 1, line.trim()));
                }
            }
        }
    }
    assert!(found.is_empty(), "{} private words:\n{}", found.len(), found.join("\n"));
}
