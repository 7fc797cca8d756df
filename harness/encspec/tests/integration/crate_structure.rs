//! The structure of the workspace, checked in manifests and sources: allowed dependencies between crates, the size of a crate, and no
//! cyclic imports between the modules of a crate.

use crate::code_rules::{files, root, text};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The crates from bottom to top. Each may depend only on those listed before it.
const ORDER: &[&str] = &[
    "harness/station",
    "harness/plain-text",
    "harness/wire",
    "harness/controllers",
    "harness/link",
    "harness/testing",
    "harness/virtual-wire",
    "harness/expression",
    "harness/suite",
    "harness/suite-yaml",
    "harness/results",
    "harness/judge",
    "harness/description",
    "suites",
    "device-under-test/device-stack",
    "device-under-test/application-protocol",
    "device-under-test/encoder-profile",
    "device-under-test/reference-devices",
    "device-under-test/deviation-hooks",
    "device-under-test/slave-bugs",
    "device-under-test/bugs",
    "device-under-test/deviations",
    "harness/engine",
    "harness/report",
    "harness/replay",
    "harness/watch",
    "harness/compare",
    "harness/explore",
    "harness/live",
    "harness/encspec",
];

/// The maximum number of lines in `src` of a crate.
const LARGEST: usize = 15_000;

/// The names in `[dependencies]` of a manifest.
fn dependencies(manifest: &str) -> Vec<&str> {
    let section = manifest.split("[dependencies]").nth(1).unwrap_or_default();
    let lines = section.lines().take_while(|line| !line.starts_with('['));
    lines.filter_map(|line| line.split(['=', '.']).next()).map(str::trim).filter(|name| !name.is_empty()).collect()
}

/// The folder of each crate of the workspace, by its name in the dependency tables.
fn members() -> BTreeMap<String, String> {
    let manifest = text(&root().join("Cargo.toml"));
    let paths = manifest.lines().filter_map(|line| {
        let (name, rest) = line.split_once(" = {")?;
        let (_, path) = rest.split_once("path = \"")?;
        Some((name.to_owned(), path.split('"').next()?.to_owned()))
    });
    paths.collect()
}

#[test]
fn each_crate_depends_only_on_lower_crates() {
    let members = members();
    let rank = |folder: &str| ORDER.iter().position(|known| *known == folder);
    for folder in members.values() {
        assert!(rank(folder).is_some(), "{folder} is not in ORDER");
    }
    for (index, folder) in ORDER.iter().enumerate() {
        for name in dependencies(&text(&root().join(folder).join("Cargo.toml"))) {
            let Some(other) = members.get(name) else { continue };
            assert!(rank(other) < Some(index), "{folder} depends on {other}, which is listed after it");
        }
    }
}

#[test]
fn crates_stay_small() {
    for folder in ORDER.iter().filter(|folder| **folder != "suites") {
        let lines: usize =
            files(root().join(folder).join("src"), "rs").iter().map(|path| text(path).lines().count()).sum();
        assert!(lines > 0, "{folder} has no sources");
        assert!(lines <= LARGEST, "{folder}/src has {lines} lines: split it");
    }
}

#[test]
fn modules_have_no_cyclic_imports() {
    let mut edges = 0;
    for folder in ORDER.iter().filter(|folder| **folder != "suites") {
        let imports = imports(&root().join(folder).join("src"));
        edges += imports.values().map(BTreeSet::len).sum::<usize>();
        if let Some(cycle) = cycle(&imports) {
            panic!("{folder}: the modules {} import each other", cycle.join(" -> "));
        }
    }
    assert!(edges > 300, "only {edges} imports were found");
}

#[test]
fn a_cycle_is_found() {
    let graph = |edges: &[(&str, &str)]| {
        let mut graph: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        edges.iter().for_each(|(from, to)| {
            graph.entry((*from).to_owned()).or_default().insert((*to).to_owned());
        });
        cycle(&graph)
    };
    assert_eq!(graph(&[("a", "b"), ("b", "c"), ("a", "c")]), None);
    assert_eq!(graph(&[("a", "b"), ("b", "c"), ("c", "b")]), Some(vec!["b".into(), "c".into(), "b".into()]));
}

#[test]
fn imports_are_read_as_the_compiler_reads_them() {
    assert_eq!(paths("a::{b, c::{self, d as e}}"), ["a::b", "a::c::self", "a::c::d"]);
    let code = "use super::x::{Y, Z};\nfn f() { crate::w::g(); } // crate::not_this\n#[cfg(test)]\nmod tests { use crate::no; }";
    assert_eq!(named(code), ["super::x::Y", "super::x::Z", "crate::w::g"]);
}

/// The top-level modules of the crate in `src`, each with the modules that it imports.
fn imports(src: &Path) -> BTreeMap<String, BTreeSet<String>> {
    let library = text(&src.join("lib.rs"));
    let modules: BTreeSet<String> = fs::read_dir(src)
        .expect("the sources")
        .filter_map(|entry| entry.expect("an entry").path().file_stem()?.to_str().map(str::to_owned))
        .filter(|name| !["lib", "main"].contains(&name.as_str()))
        .collect();
    // A re-exported name belongs to the module that defines it.
    let reexported: BTreeMap<String, String> = statements(&library, "pub use ")
        .iter()
        .flat_map(|tree| paths(tree))
        .filter_map(|path| {
            let parts: Vec<&str> = path.split("::").filter(|part| *part != "crate" && *part != "self").collect();
            Some(((*parts.last()?).to_owned(), (*parts.first()?).to_owned()))
        })
        .collect();
    let mut graph: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in files(src, "rs") {
        let below = file.strip_prefix(src).expect("below src").with_extension("");
        let mut module_path: Vec<String> = below.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        if module_path.last().is_some_and(|name| name == "mod") {
            module_path.pop();
        }
        let Some(module) = module_path.first().filter(|name| modules.contains(*name)).cloned() else { continue };
        if module_path.iter().any(|name| name.contains("test")) {
            continue;
        }
        for path in named(&text(&file)) {
            let mut parts = path.split("::").peekable();
            let mut at = match parts.next() {
                Some("crate") => Vec::new(),
                _ => module_path[..module_path.len() - 1].to_vec(),
            };
            while parts.next_if_eq(&"super").is_some() {
                at.pop();
            }
            at.extend(parts.map(str::to_owned));
            let Some(first) = at.first() else { continue };
            let target = if modules.contains(first) { Some(first) } else { reexported.get(first) };
            if let Some(target) = target.filter(|target| **target != module && modules.contains(*target)) {
                graph.entry(module.clone()).or_default().insert(target.clone());
            }
        }
    }
    graph
}

/// The paths in `code` that begin with `crate` or `super`, except in comments and unit tests.
fn named(code: &str) -> Vec<String> {
    let code: String = code.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned() + "\n").collect();
    let code = code.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let mut found: Vec<String> = statements(code, "use ").iter().flat_map(|tree| paths(tree)).collect();
    found.retain(|path| path.starts_with("crate::") || path.starts_with("super::"));
    let without_use: String =
        code.split(';').filter(|of| !of.trim_start().trim_start_matches("pub ").starts_with("use ")).collect();
    for word in without_use.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')) {
        if word.starts_with("crate::") || word.starts_with("super::") {
            found.push(word.trim_end_matches(':').to_owned());
        }
    }
    found
}

/// The text between each `begin`, at the start of a word, and the next semicolon.
fn statements<'c>(code: &'c str, begin: &str) -> Vec<&'c str> {
    let starts =
        code.match_indices(begin).filter(|(at, _)| !code[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_'));
    starts.filter_map(|(at, _)| code[at + begin.len()..].split(';').next()).collect()
}

/// The paths of an import tree, without `as` names.
fn paths(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some((prefix, inner)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap_or_default().trim().to_owned()];
    };
    let inner = inner.trim_end().strip_suffix('}').unwrap_or(inner);
    let mut depth = 0;
    let parts = inner.split(|c: char| {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        c == ',' && depth == 0
    });
    let parts = parts.filter(|part| !part.trim().is_empty());
    parts.flat_map(paths).map(|path| format!("{}{path}", prefix.trim())).collect()
}

/// A path from a module back to itself, if there is one.
fn cycle(graph: &BTreeMap<String, BTreeSet<String>>) -> Option<Vec<String>> {
    fn walk(
        at: &str,
        graph: &BTreeMap<String, BTreeSet<String>>,
        path: &mut Vec<String>,
        done: &mut BTreeSet<String>,
    ) -> bool {
        if let Some(index) = path.iter().position(|known| known == at) {
            path.drain(..index);
            path.push(at.to_owned());
            return true;
        }
        if !done.insert(at.to_owned()) {
            return false;
        }
        path.push(at.to_owned());
        if graph.get(at).is_some_and(|next| next.iter().any(|next| walk(next, graph, path, done))) {
            return true;
        }
        path.pop();
        false
    }
    let mut done = BTreeSet::new();
    graph.keys().find_map(|module| {
        let mut path = Vec::new();
        walk(module, graph, &mut path, &mut done).then_some(path)
    })
}
