//! `docs/suite-language.md`: its second half is made from the schema, so it has every key and every word with its sentence.
//!
//! `INSTA_UPDATE=always cargo test -p encspec --test integration suite_language_page::` writes it.

use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;

const PAGE: &str = "docs/suite-language.md";
const BEGIN: &str = "## Every word\n";

/// The groups of key sets: heading, and the key sets by their names in the schema.
const GROUPS: [(&str, &[&str]); 5] = [
    (
        "Keys of topic files",
        &[
            "TOPIC",
            "USES",
            "COMMON_SUITE",
            "TAKES",
            "PROCEDURES",
            "PROCEDURE",
            "DEFAULTS",
            "CASE",
            "RULE",
            "ROW",
            "OBSERVED",
            "EXCHANGED",
            "TURN",
            "RECORD_WRITE",
        ],
    ),
    ("Keys of requirements, bugs and masks", &["REQUIREMENTS", "REQUIREMENT", "BUGS", "MASKS"]),
    (
        "Keys of device.yaml",
        &[
            "DEVICE",
            "IDENTITY",
            "OURS",
            "PRINTED",
            "SIGNAL",
            "FIELD",
            "SUBMODULE",
            "OCTETS",
            "MODULE",
            "RECORD",
            "RECORD_FIELD",
            "PARAMETER",
            "PARAMETER_ACCESS",
            "STAND",
            "SUPPLY",
            "PAGE",
            "PAGE_VALUE",
            "CHANGED",
            "VARIANT_IDENTIFICATION",
            "ALSO",
            "CONTRADICTED",
            "CODES",
            "SOURCED_DATUM",
            "SLAVE",
            "SLAVE_IDENTITY",
            "SLAVE_MODULE",
            "SET_PRM",
            "DIAGNOSIS",
            "DIAGNOSIS_FIELD",
            "DIAGNOSIS_BLOCKS",
            "SLAVE_PARAMETER_ACCESS",
        ],
    ),
    (
        "Keys of personas",
        &[
            "PERSONA",
            "PERSONA_BLOCKS",
            "PERSONA_CLASS",
            "PERSONA_CYCLE",
            "PERSONA_FACTORS",
            "PERSONA_RECONNECT",
            "PERSONA_REFERENCES",
            "PERSONA_RTA",
            "PERSONA_TAGS",
        ],
    ),
    (
        "Keys of bench files and ledgers",
        &[
            "BENCH",
            "BENCH_CONTROLLER",
            "BENCH_LINE",
            "BENCH_STAND",
            "BENCH_PAGE",
            "BENCH_CONSENT",
            "LEDGER",
            "KNOWN_FAILURE",
            "FIRMWARE",
        ],
    ),
];

fn object<'a>(value: &'a Value, key: &str) -> &'a Map<String, Value> {
    value[key].as_object().unwrap_or_else(|| panic!("the schema has no {key}"))
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_default()
}

/// The heading of a key set: several are distinguished by what they belong to.
fn heading(name: &str, set: &Value) -> String {
    let description = text(set, "description");
    match name.split_once('_') {
        Some(("BENCH", _)) => format!("bench file: {description}"),
        Some(("PERSONA", _)) => format!("persona: {description}"),
        _ => description.to_owned(),
    }
}

/// What GitHub makes of a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|one| one.is_alphanumeric() || matches!(one, ' ' | '-' | '_'));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

/// What a value can be, where the schema says more than that it is a text, a number or a mapping.
fn value_of(schema: &Value, sets: &Map<String, Value>) -> String {
    if let Some(name) = schema["$ref"].as_str().and_then(|reference| reference.strip_prefix("#/$defs/")) {
        if name == "STEP" {
            return "[step](#verbs-and-their-modifiers)".to_owned();
        }
        if !GROUPS.iter().any(|(_, names)| names.contains(&name)) {
            return text(&sets[name], "description").to_owned();
        }
        let heading = heading(name, &sets[name]);
        return format!("[{heading}](#{})", anchor(&heading));
    }
    if let Some(words) = schema["enum"].as_array() {
        return words.iter().filter_map(Value::as_str).map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ");
    }
    if schema["const"] == true {
        return "`true`".to_owned();
    }
    if schema["if"].is_object() {
        let each = [&schema["then"], &schema["else"]].map(|schema| value_of(schema, sets));
        return each.into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join(" or ");
    }
    let list = |schema: &Value| {
        let item = value_of(&schema["items"], sets);
        if item.is_empty() { "list".to_owned() } else { format!("list of {item}") }
    };
    if schema["type"] == "array" {
        return list(schema);
    }
    if let Some(items) = schema["anyOf"].as_array() {
        let mut each: Vec<String> =
            items.iter().map(|item| value_of(item, sets)).filter(|text| !text.is_empty()).collect();
        each.dedup();
        return each.join(" or ");
    }
    if schema["type"] == "object" {
        let item = value_of(&schema["additionalProperties"], sets);
        return if item.is_empty() { "mapping".to_owned() } else { format!("mapping of names to {item}") };
    }
    String::new()
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// A key set as a section; a key that must be there is in bold type.
fn section(out: &mut String, name: &str, sets: &Map<String, Value>) {
    let set = &sets[name];
    let required: BTreeSet<&str> = set["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let _ = writeln!(out, "\n#### {}\n\n| key | value | meaning |\n| --- | --- | --- |", heading(name, set));
    for (key, schema) in object(set, "properties") {
        let bold = if required.contains(key.as_str()) { "**" } else { "" };
        let value = value_of(schema, sets);
        let _ = writeln!(out, "| {bold}`{key}`{bold} | {} | {} |", cell(&value), cell(text(schema, "description")));
    }
}

/// A list of words, each with its sentence.
fn words(out: &mut String, heading: &str, list: &Map<String, Value>) {
    let _ = writeln!(out, "\n### {heading}\n\n| word | meaning |\n| --- | --- |");
    for (word, sentence) in list {
        let _ = writeln!(out, "| `{word}` | {} |", cell(sentence.as_str().unwrap_or_default()));
    }
}

fn listed(value: &Value) -> String {
    value
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_str)
        .map(|word| format!("`{word}`"))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Verbs or services: what each does, and what goes with it.
fn actions(out: &mut String, heading: &str, (word, with): (&str, &str), list: &Map<String, Value>) {
    let _ = writeln!(out, "\n### {heading}\n\n| {word} | {with} | what it does |\n| --- | --- | --- |");
    for (name, action) in list {
        let _ = writeln!(out, "| `{name}` | {} | {} |", listed(&action[with]), cell(text(action, "does")));
    }
}

fn codes(out: &mut String, heading: &str, list: &Map<String, Value>) {
    let _ = writeln!(out, "\n### {heading}\n");
    let of = |words: &Value| words.as_array().cloned().unwrap_or_default();
    let holders = |word: &Value| list.values().filter(|words| of(words).contains(word)).count();
    let mut shared: Vec<Value> = Vec::new();
    for (service, words) in list {
        let (own, others): (Vec<Value>, Vec<Value>) = of(words).into_iter().partition(|word| holders(word) == 1);
        shared.extend(others);
        if !own.is_empty() {
            let _ = writeln!(out, "- {service} only: {}", listed(&own.into()));
        }
    }
    let mut once: Vec<Value> = Vec::new();
    shared.into_iter().for_each(|word| {
        if !once.contains(&word) {
            once.push(word)
        }
    });
    let several: Vec<&str> = list
        .iter()
        .filter(|(_, words)| of(words).iter().any(|word| once.contains(word)))
        .map(|(name, _)| name.as_str())
        .collect();
    let _ = writeln!(out, "- {}: {}", several.join(", "), listed(&once.into()));
}

/// The second half of the page.
fn generated() -> String {
    let schema = encspec::results::schema();
    let sets = object(&schema, "$defs");
    let encspec = &schema["x-encspec"];
    let bus = &encspec["profibus"];
    let mut out = format!("{BEGIN}\nMade from `encspec schema`. A key in bold type must be there.\n");
    actions(&mut out, "Verbs and their modifiers", ("verb", "modifiers"), object(encspec, "verbs"));
    words(&mut out, "Names on PROFINET", object(encspec, "names"));
    words(&mut out, "Names on PROFIBUS", object(bus, "names"));
    words(&mut out, "Settings of start on PROFINET", object(encspec, "start"));
    words(&mut out, "Settings of start on PROFIBUS", object(bus, "start"));
    actions(&mut out, "Services of send on PROFINET", ("service", "fields"), object(encspec, "services"));
    actions(&mut out, "Services of send on PROFIBUS", ("service", "fields"), object(bus, "services"));
    let _ = writeln!(out, "\n### What instead changes");
    for (of, list) in object(encspec, "instead") {
        words(&mut out, &format!("In {of}"), list.as_object().expect("a list"));
    }
    for (of, list) in object(bus, "instead") {
        words(&mut out, &format!("In {of} on PROFIBUS"), list.as_object().expect("a list"));
    }
    words(&mut out, "Fields of a Connect", object(encspec, "connect_fields"));
    words(&mut out, "Damaged frames on PROFINET", object(encspec, "broken"));
    words(&mut out, "Damaged frames on PROFIBUS", object(bus, "broken"));
    codes(&mut out, "Codes of refusals", object(encspec, "codes"));
    codes(&mut out, "Codes of refusals on PROFIBUS", object(bus, "codes"));
    let _ = writeln!(out, "\n### States of a module in module_diff\n\n{}", listed(&encspec["module_diff"]));
    words(&mut out, "Times of ours", object(encspec, "times"));
    words(&mut out, "Hooks of a bench file", object(encspec, "hooks"));
    for (group, names) in GROUPS {
        let _ = writeln!(out, "\n### {group}");
        names.iter().for_each(|name| section(&mut out, name, sets));
    }
    out
}

#[test]
fn every_word_of_the_schema_is_on_the_page() {
    let path = testing::workspace().join(PAGE);
    let page = fs::read_to_string(&path).expect("the page");
    let (written, shown) = page.split_at(page.find(BEGIN).expect("the page has the section"));
    let expected = generated();
    if shown != expected && std::env::var_os("INSTA_UPDATE").is_some_and(|how| how == "always") {
        fs::write(&path, format!("{written}{expected}")).expect("the page");
    } else if let Some((found, wanted)) = shown.lines().zip(expected.lines()).find(|(found, wanted)| found != wanted) {
        panic!(
            "{PAGE} is no longer what the schema says; set INSTA_UPDATE=always.\n  page:   {found}\n  schema: {wanted}"
        );
    } else {
        assert_eq!(shown.len(), expected.len(), "{PAGE} is no longer what the schema says; set INSTA_UPDATE=always");
    }
}

#[test]
fn no_key_set_of_the_schema_is_left_out() {
    let schema = encspec::results::schema();
    let shown: BTreeSet<&str> = GROUPS.iter().flat_map(|(_, names)| *names).copied().collect();
    // Verbs, services and what `instead` changes are listed as words.
    let is_listed = |name: &str| name.ends_with("_STEP") || name.ends_with("_REQUEST") || name.starts_with("SERVICE_");
    let is_set = |set: &Value| set["properties"].is_object() && set["type"] == "object" && set["required"].is_array();
    let sets = object(&schema, "$defs").iter().filter(|(name, set)| is_set(set) && !is_listed(name));
    let known: BTreeSet<&str> = sets.map(|(name, _)| name.as_str()).chain(["ROW"]).collect();
    assert_eq!(shown, known, "a key set is missing in the groups, or is no longer there");
    let listed = [
        "verbs",
        "names",
        "start",
        "services",
        "instead",
        "broken",
        "connect_fields",
        "codes",
        "module_diff",
        "hooks",
        "times",
        "profibus",
    ];
    let words: BTreeSet<&str> = object(&schema, "x-encspec").keys().map(String::as_str).collect();
    assert_eq!(words, listed.into_iter().collect(), "a list of words is missing on the page");
}

/// Each anchor that the page links to within itself is a heading.
#[test]
fn links_within_the_page_lead_somewhere() {
    let page = fs::read_to_string(testing::workspace().join(PAGE)).expect("the page");
    let headings: BTreeSet<String> = page
        .lines()
        .filter(|line| line.starts_with('#'))
        .map(|line| anchor(line.trim_start_matches('#').trim()))
        .collect();
    let lost: Vec<&str> = page
        .split("](#")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
        .filter(|to| !headings.contains(*to))
        .collect();
    assert_eq!(lost, [""; 0], "nothing has this heading");
}
