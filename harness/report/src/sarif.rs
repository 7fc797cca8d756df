//! Mistakes in suites as SARIF 2.1.0, which code hosts and editors show beside the line.

use super::words::printable_json;
use serde_json::{Value, json};
use suite::Location;

/// How bad a remark about a suite is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RemarkLevel {
    /// The suite cannot be loaded.
    Error,
    /// Something is defined and not used.
    Note,
}

/// A remark about a line of a suite.
#[derive(Clone, Debug)]
pub struct SuiteRemark {
    pub level: RemarkLevel,
    pub text: String,
    /// The position; line 0 stands for the file as a whole.
    pub at: Location,
    /// How many characters of the line are meant.
    pub width: usize,
}

/// Writes the remarks.
pub fn sarif(remarks: &[SuiteRemark]) -> String {
    let rule = |id: &str, text: &str, level: &str| {
        json!({
            "id": id,
            "shortDescription": { "text": text },
            "defaultConfiguration": { "level": level },
        })
    };
    let report = json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": {
                "name": "encspec",
                "version": env!("CARGO_PKG_VERSION"),
                "rules": [
                    rule("suite-error", "The suite cannot be loaded.", "error"),
                    rule("unused", "Something is defined and not used.", "note"),
                ],
            } },
            "columnKind": "unicodeCodePoints",
            "results": remarks.iter().map(remark).collect::<Vec<_>>(),
        }],
    });
    format!("{}\n", printable_json(&format!("{report:#}")))
}

fn remark(of: &SuiteRemark) -> Value {
    let (rule, level) = match of.level {
        RemarkLevel::Error => ("suite-error", "error"),
        RemarkLevel::Note => ("unused", "note"),
    };
    let mut place = json!({ "artifactLocation": { "uri": uri(&of.at) } });
    if of.at.line > 0 {
        let column = of.at.column.max(1) as usize;
        place["region"] =
            json!({ "startLine": of.at.line, "startColumn": column, "endColumn": column + of.width.max(1) });
    }
    json!({
        "ruleId": rule,
        "level": level,
        "message": { "text": of.text },
        "locations": [{ "physicalLocation": place }],
    })
}

/// The file as a relative or absolute URI reference.
fn uri(at: &Location) -> String {
    let path = at.file.display().to_string().replace('\\', "/");
    let mut uri = String::with_capacity(path.len());
    for octet in path.bytes() {
        match octet {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'-' | b'.' | b'_' | b'~' => uri.push(char::from(octet)),
            _ => uri.push_str(&format!("%{octet:02X}")),
        }
    }
    if path.starts_with('/') { format!("file://{uri}") } else { uri }
}
