//! Reads the ledger file and checks its entries.

use super::date::Date;
use super::keys::{firmware, known_failure, ledger};
use plain_text::nearest;
use std::fs;
use std::path::{Path, PathBuf};
use suite::model::Manual;
use suite_yaml::error::Read;
use suite_yaml::keys::{Key, Keyed};
use suite_yaml::yaml::Node;
use suite_yaml::{LoadError, read_file};

/// The known failures of one or more devices.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    /// The entries in the order of the file.
    pub entries: Vec<LedgerEntry>,
}

/// A known failure.
#[derive(Clone, Debug)]
pub struct LedgerEntry {
    /// The test, `<suite>/<case>[row]` with or without the manual before it; `*` matches any text.
    pub test: String,
    /// Name of the manual.
    pub device: String,
    /// The variant; `None`: all variants.
    pub variant: Option<String>,
    /// The firmware versions that have the failure; `None`: all versions.
    pub firmware: Option<Firmware>,
    /// Why it fails, in one sentence.
    pub reason: String,
    /// The ticket that tracks the failure.
    pub ticket: String,
    /// The last day on which the entry excuses anything.
    pub expires: Date,
    /// The signature of the failure, as in the JSON report; `*` matches any text.
    pub signature: String,
}

/// A range of firmware versions, both ends inclusive; one end may be open.
#[derive(Clone, Debug)]
pub struct Firmware {
    /// The first version that has the failure, for instance `"1.0"`.
    pub from: Option<String>,
    /// The last version that has the failure.
    pub to: Option<String>,
}

/// Errors of a ledger file.
#[derive(Debug, thiserror::Error)]
pub enum LedgerError {
    /// The file could not be read.
    #[error("the ledger {} cannot be read: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    /// Something is wrong in the file.
    #[error("{0}")]
    Text(Box<LoadError>),
    /// An entry names a device or variant that does not exist.
    #[error("{}: {message}", path.display())]
    Unknown {
        path: PathBuf,
        /// The unknown name and a suggestion.
        message: String,
    },
}

impl Ledger {
    /// Reads the ledger file `path`; each device in it must be one of `manuals`.
    pub fn read(path: &Path, manuals: &[Manual]) -> Result<Ledger, LedgerError> {
        let text = fs::read_to_string(path).map_err(|source| LedgerError::File { path: path.to_owned(), source })?;
        let ledger = Ledger::parse(path, &text)?;
        for entry in &ledger.entries {
            let known: Vec<(&str, &[String])> =
                manuals.iter().map(|of| (of.device.name.as_str(), of.device.variants.as_slice())).collect();
            entry.check(&known).map_err(|message| LedgerError::Unknown { path: path.to_owned(), message })?;
        }
        Ok(ledger)
    }

    /// Parses the text of a ledger; `path` is used in messages.
    pub fn parse(path: &Path, text: &str) -> Result<Ledger, LedgerError> {
        let entries = |node: &Node| {
            let list = Keyed::new(node, &ledger::KEYS)?.must(&ledger::known_failures)?;
            list.items("known_failures")?.iter().map(LedgerEntry::read).collect()
        };
        let entries = read_file(path, text, entries).map_err(|error| LedgerError::Text(Box::new(error)))?;
        Ok(Ledger { entries })
    }
}

/// A text that is not empty.
fn filled(node: &Node, what: &str) -> Read<String> {
    let text = node.text(what)?;
    if text.trim().is_empty() { Err(node.wrong("this text is empty")) } else { Ok(text.to_owned()) }
}

impl LedgerEntry {
    fn read(node: &Node) -> Read<LedgerEntry> {
        let keyed = Keyed::new(node, &known_failure::KEYS)?;
        let text = |key: &Key| filled(keyed.must(key)?, key.name);
        let expires = keyed.must(&known_failure::expires)?;
        Ok(LedgerEntry {
            test: text(&known_failure::test)?,
            device: text(&known_failure::device)?,
            variant: keyed.get(&known_failure::variant).map(|node| filled(node, "a variant")).transpose()?,
            firmware: keyed.get(&known_failure::firmware).map(Firmware::read).transpose()?,
            reason: text(&known_failure::reason)?,
            ticket: text(&known_failure::ticket)?,
            expires: expires.text("a day")?.parse().map_err(|error: String| expires.wrong(error))?,
            signature: text(&known_failure::signature)?,
        })
    }

    /// The entry as notes name it.
    pub fn name(&self) -> String {
        format!("ledger entry {} for {}", self.ticket, self.test)
    }

    /// Whether the entry names the test `id` (`<manual>/<suite>/<case>[row]`) of `device`.
    pub fn names(&self, device: &str, id: &str) -> bool {
        let short = id.strip_prefix(device).and_then(|id| id.strip_prefix('/')).unwrap_or(id);
        glob(&self.test, id) || glob(&self.test, short)
    }

    /// Whether the entry describes a failure with this signature.
    pub fn describes(&self, signature: &str) -> bool {
        glob(&self.signature, signature)
    }

    fn check(&self, known: &[(&str, &[String])]) -> Result<(), String> {
        if self.signature.chars().all(|letter| letter == '*' || letter.is_whitespace()) {
            let name = self.name();
            return Err(format!("{name} excuses every failure: copy the signature from `encspec run -v`"));
        }
        let unknown = |what: &str, word: &str, words: Vec<&str>| {
            let meant = nearest(word, words.iter().copied())
                .map_or_else(|| format!("use one of {}", words.join(", ")), |meant| format!("did you mean `{meant}`?"));
            format!("{}: unknown {what} `{word}`; {meant}", self.name())
        };
        let Some((_, variants)) = known.iter().find(|(device, _)| *device == self.device) else {
            return Err(unknown("device", &self.device, known.iter().map(|(device, _)| *device).collect()));
        };
        match &self.variant {
            Some(variant) if !variants.contains(variant) => {
                Err(unknown("variant", variant, variants.iter().map(String::as_str).collect()))
            }
            _ => Ok(()),
        }
    }
}

impl Firmware {
    fn read(node: &Node) -> Read<Firmware> {
        let keyed = Keyed::new(node, &firmware::KEYS)?;
        let end = |key: &Key| keyed.get(key).map(|node| filled(node, "a version")).transpose();
        Ok(Firmware { from: end(&firmware::from)?, to: end(&firmware::to)? })
    }

    /// Whether a version lies in the range; versions are compared number by number.
    pub fn contains(&self, firmware: &str) -> bool {
        let observed = version(firmware);
        self.from.as_ref().is_none_or(|from| version(from) <= observed)
            && self.to.as_ref().is_none_or(|to| observed <= version(to))
    }
}

/// The numbers of a version without trailing zeros: `V1.3.0` is 1, 3.
fn version(text: &str) -> Vec<u64> {
    let mut numbers: Vec<u64> =
        text.split(|c: char| !c.is_ascii_digit()).filter_map(|number| number.parse().ok()).collect();
    while numbers.last() == Some(&0) {
        numbers.pop();
    }
    numbers
}

/// Whether `text` matches `pattern`, in which `*` matches any text, including none.
fn glob(pattern: &str, text: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|first| text.strip_prefix(first)) else { return false };
    let mut parts = parts.peekable();
    if parts.peek().is_none() {
        return rest.is_empty();
    }
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            return rest.ends_with(part);
        }
        let Some(at) = rest.find(part) else { return false };
        rest = rest.get(at + part.len()..).unwrap_or_default();
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    #[rstest]
    #[case("a/b", "a/b", true)]
    #[case("a/b", "a/bc", false)]
    #[case("a/b", "xa/b", false)]
    #[case("a/*", "a/", true)]
    #[case("a/*", "a/b[1]", true)]
    #[case("*", "", true)]
    #[case("*b", "abab", true)]
    #[case("*b", "abac", false)]
    #[case("a*a", "a", false)]
    #[case("a*b*c", "a1b2b3c", true)]
    #[case("a*b*c", "a1c2b", false)]
    #[case("a[1]", "a1", false)]
    #[case("", "", true)]
    #[case("", "a", false)]
    #[case("ä*", "äö", true)]
    fn patterns(#[case] pattern: &str, #[case] text: &str, #[case] matches: bool) {
        assert_eq!(glob(pattern, text), matches);
    }

    #[rstest]
    #[case(Some("1.2"), Some("1.4"), "1.2.0", true)]
    #[case(Some("1.2"), Some("1.4"), "V1.10.0", false)]
    #[case(Some("1.2"), None, "1.10", true)]
    #[case(None, Some("1.4"), "0.9", true)]
    #[case(Some("1.2"), None, "1.1.9", false)]
    fn firmware(#[case] from: Option<&str>, #[case] to: Option<&str>, #[case] observed: &str, #[case] inside: bool) {
        let range = Firmware { from: from.map(str::to_owned), to: to.map(str::to_owned) };
        assert_eq!(range.contains(observed), inside);
    }

    const GOOD: &str = "known_failures:\n- test: preset/absolute\n  device: enc\n  variant: v1\n  reason: It is late.\n  \
                        ticket: FW-1\n  expires: 2027-01-31\n  signature: 'expect | A'\n";

    fn read(text: &str) -> Result<Ledger, String> {
        Ledger::parse(Path::new("ledger.yaml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn an_entry_is_read() {
        let ledger = read(GOOD).expect("a good ledger");
        assert_eq!(ledger.entries.len(), 1);
        assert_eq!(ledger.entries[0].expires.to_string(), "2027-01-31");
    }

    #[rstest]
    #[case("  ticket: FW-1\n", "  tickt: FW-1\n", "unknown key of a known failure `tickt`")]
    #[case("  ticket: FW-1\n", "  tickt: FW-1\n", "did you mean `ticket`?")]
    #[case("  ticket: FW-1\n", "", "a known failure needs the key `ticket`")]
    #[case("  ticket: FW-1\n", "  ticket: ''\n", "this text is empty")]
    #[case("  ticket: FW-1\n", "  ticket: FW-1\n  ticket: FW-2\n", "duplicate")]
    #[case("2027-01-31", "2027-02-31", "`2027-02-31` is not a date")]
    #[case("known_failures", "known_failure", "unknown key of a ledger of known failures `known_failure`")]
    fn errors_have_a_line(#[case] good: &str, #[case] bad: &str, #[case] said: &str) {
        let text = GOOD.replacen(good, bad, 1);
        assert_ne!(text, GOOD, "each row of this test must change the text");
        let error = read(&text).expect_err("a bad ledger");
        assert!(error.contains(said), "{error}");
        assert!(error.starts_with("ledger.yaml:"), "{error}");
    }

    #[rstest]
    #[case("enx", None, "unknown device `enx`; did you mean `enc`?")]
    #[case("enc", Some("v2"), "unknown variant `v2`")]
    fn unknown_devices_and_variants_are_reported(
        #[case] device: &str,
        #[case] variant: Option<&str>,
        #[case] said: &str,
    ) {
        let mut entry = read(GOOD).expect("a good ledger").entries.remove(0);
        entry.device = device.to_owned();
        entry.variant = variant.map(str::to_owned);
        let message = entry.check(&[("enc", &["v1".to_owned()])]).expect_err("an unknown name");
        assert!(message.contains(said), "{message}");
    }
}
