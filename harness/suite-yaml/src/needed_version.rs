//! The versions of encspec that a file says can read it: `encspec: ">=0.2"`.
//!
//! A file for a newer version has keys that this one does not know, so this is checked before anything else in it is.

use super::LoadErrors;
use super::error::{Mistake, Mistakes, Read};
use super::keys::Pattern;
use super::source::{COMMON, Files, PERSONAS, Sources};
use super::yaml::{self, Node};
use semver::{Version, VersionReq};

/// The key.
const KEY: &str = "encspec";

/// A comparison of versions, or several separated by commas.
pub(super) static VERSIONS: Pattern =
    Pattern { regex: r"^\s*((>=|<=|>|<|=|~|\^)?\s*\d+(\.\d+)?(\.\d+)?(-[0-9A-Za-z.-]+)?\s*(,\s*(?=\S)|$))+$" };

/// Fails if a file of the manuals that are wanted, or one that they share, needs another version of encspec.
pub(super) fn check(sources: &Sources, is_wanted: &dyn Fn(&str) -> bool) -> Result<(), LoadErrors> {
    let (mut files, mistakes) = (Files::default(), Mistakes::default());
    for (path, text) in sources.files() {
        let Some((folder, name)) = path.split_once('/') else { continue };
        let is_shared = [COMMON, PERSONAS].contains(&folder);
        if !(is_shared || is_wanted(folder)) || !text.lines().any(has_key) {
            continue;
        }
        let Some((file, text)) = files.open(sources, folder, name.trim_end_matches(".yaml")) else { continue };
        // What is no YAML at all is reported when the file is read.
        let Ok(node) = yaml::parse(file, &text) else { continue };
        mistakes.keep(check_file(&node, env!("CARGO_PKG_VERSION")));
    }
    if mistakes.count() > 0 { Err(files.errors(&mistakes)) } else { Ok(()) }
}

/// Whether a line may have the key at the top level of a file.
fn has_key(line: &str) -> bool {
    line.trim_start_matches(['{', '"', '\'', ' ']).starts_with(KEY)
}

fn check_file(node: &Node, version: &str) -> Read<()> {
    let Some(value) = node.get(KEY) else { return Ok(()) };
    let text = value.text("the versions of encspec that can read this file")?;
    let needed = VersionReq::parse(text).map_err(|error| {
        value
            .wrong(format!("`{}` says no versions: {error}", text.escape_default()))
            .help("for instance \">=0.2\", or \">=0.2, <1\"")
    })?;
    let is_met = Version::parse(version).is_ok_and(|version| needed.matches(&version));
    if is_met {
        return Ok(());
    }
    Err(Mistake::new(value.spot, format!("this file needs encspec {needed}, and this is encspec {version}"))
        .help("install that version, or see docs/compatibility.md for what changed"))
}

#[cfg(test)]
mod tests {
    use super::{check_file, yaml};
    use rstest::rstest;

    // The comparisons are those of Cargo: `0.2` means `>=0.2.0, <0.3.0`.
    #[rstest]
    #[case("encspec: \">=0.1\"", None)]
    #[case("encspec: \"0.1\"", None)]
    #[case("suite: a", None)]
    #[case("encspec: \">=0.1, <1\"", None)]
    #[case("encspec: \">=0.2\"", Some("this file needs encspec >=0.2, and this is encspec 0.1.7"))]
    #[case("encspec: 0.2", Some("this file needs encspec ^0.2, and this is encspec 0.1.7"))]
    #[case("encspec: \"<0.1.7\"", Some("this file needs encspec <0.1.7, and this is encspec 0.1.7"))]
    #[case("encspec: newest", Some("`newest` says no versions"))]
    #[case("encspec: \"\"", Some("`` says no versions"))]
    #[case("encspec: [1]", Some("a single value"))]
    fn a_file_says_which_versions_can_read_it(#[case] text: &str, #[case] error: Option<&str>) {
        let node = yaml::parse(0, text).expect("YAML");
        let said = check_file(&node, "0.1.7").err().map(|mistake| mistake.message);
        match error {
            None => assert_eq!(said, None),
            Some(error) => assert!(said.as_deref().is_some_and(|said| said.contains(error)), "{said:?}"),
        }
    }
}
