//! Mistakes of shape in the shipped YAML files: whatever the loader refuses by its shape the JSON Schema refuses too.
//!
//! The mistakes follow from a seed, another one each day; `ENCSPEC_SAMPLE=N` makes those of a day again. A validator that is not ours
//! judges the schema: `jsonschema` of Python, which `.ci/peers/install` installs beside check-jsonschema.

use controllers::random::SplitMix64;
use encspec::results;
use encspec::suite_yaml::yaml::{Node, NodeKind, parse};
use encspec::suite_yaml::{Checker, Sources};
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use testing::DailySample;

/// The least number of mistakes in a run.
pub const LEAST: usize = 200;
/// Pieces of the messages by which the loader refuses a shape. What it refuses by the meaning (an unknown signal, a number that does
/// not fit a signal) no schema can know.
const OF_SHAPE: &[&str] = &[
    "unknown key of ",
    "unknown service ",
    "unknown verb ",
    "needs the key `",
    "has exactly one of ",
    "has one of `",
    "` beside it",
    ", not both",
    " is a mapping `",
    " is a list `",
    " is a single value, not ",
    "a step without a verb",
    "a step has exactly one verb",
    "a matcher is one of ",
    "an empty ",
    " is empty",
    "a procedure without steps",
    "a case without steps",
    "a module without submodules",
    "there are no requirements",
    "breaks nothing",
    "a row without columns",
    "a table without columns",
    "here no field is declared",
    "`either` has two or more readings",
    "a reading has only ",
    "a list of answers has two or more",
    "`refused` stands alone",
    "one `send` sends one service",
    "` is `true` or left out",
    "` is no name",
    "a name has letters",
    "is a pair `[",
    "a switch has two or three positions",
    "there are two factors",
    "unknown word for ",
    "`as` is `second` or left out",
    " is out of range for ",
    "a width is 8, 16, 32 or 64 bits",
    "is no station address",
    "is no subslot of an interface or a port",
    "is no drive object",
    "of cyclic frames here",
    "is no RT class of a cyclic frame",
    " is a whole number",
    "write a number from ",
    "is no power of two",
    " has no unit",
    " is not a unit",
    " is not a duration",
    "`true` is a word of YAML itself",
    "`false` is a word of YAML itself",
    "a case needs a `start`",
    "is no whole number of cycles",
    "is a time, not a number of cycles",
    "is not a byte",
    "one space too many",
    "a path begins with a slash",
    "DP-V1 has three ",
    "a block is written in hexadecimal",
    "a block that is never done",
];

/// The same in files without steps, where the meaning of a number does not depend on a name.
const OF_SHAPE_OUTSIDE_STEPS: &[&str] = &[" is not a number", " is not a hexadecimal number", " is no power of two"];

/// A file with one mistake, and how the loader refuses it.
pub struct ShapeMistake {
    /// The file and what was changed.
    pub what: String,
    /// The kind of the mistake.
    pub kind: &'static str,
    /// What the loader says.
    pub message: String,
    /// The file as data.
    pub data: Value,
}

/// Numbers that follow from a seed.
pub struct MistakeRandom(SplitMix64);

impl MistakeRandom {
    pub fn new(seed: u64) -> MistakeRandom {
        MistakeRandom(SplitMix64::new(seed))
    }

    fn below(&mut self, end: usize) -> usize {
        (self.0.bits() % end.max(1) as u64) as usize
    }

    fn one<'t, T>(&mut self, of: &'t [T]) -> &'t T {
        &of[self.below(of.len())]
    }
}

/// A node as data, by the rules of YAML 1.2.
pub fn data(node: &Node) -> Value {
    match &node.kind {
        NodeKind::Mapping(entries) => {
            let entry = |(key, value): &(Node, Node)| (key.scalar().unwrap_or_default().to_owned(), data(value));
            Value::Object(entries.iter().map(entry).collect::<Map<_, _>>())
        }
        NodeKind::Sequence(items) => items.iter().map(data).collect(),
        NodeKind::Scalar { text, quoted: true } => json!(text),
        NodeKind::Scalar { text, quoted: false } => plain(text),
    }
}

fn plain(text: &str) -> Value {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let is_whole = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_digit());
    let is_number = digits.starts_with(|first: char| first.is_ascii_digit() || first == '.');
    match text {
        "" | "~" | "null" | "Null" | "NULL" => Value::Null,
        "true" | "True" | "TRUE" => json!(true),
        "false" | "False" | "FALSE" => json!(false),
        _ if is_whole => {
            text.parse::<i64>().map_or_else(|_| json!(text.parse::<f64>().unwrap_or(0.0)), |number| json!(number))
        }
        _ => match text.strip_prefix("0x").map(|digits| u64::from_str_radix(digits, 16)) {
            Some(Ok(number)) => json!(number),
            _ if is_number => text.parse::<f64>().map_or_else(|_| json!(text), |number| json!(number)),
            _ => json!(text),
        },
    }
}

/// A node as text in flow style.
pub fn text(node: &Node) -> String {
    match &node.kind {
        NodeKind::Mapping(entries) => {
            let entries: Vec<String> =
                entries.iter().map(|(key, value)| format!("{}: {}", text(key), text(value))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
        NodeKind::Sequence(items) => format!("[{}]", items.iter().map(text).collect::<Vec<_>>().join(", ")),
        NodeKind::Scalar { text, quoted } => {
            let is_safe = text.chars().all(|letter| letter.is_alphanumeric() || "_-. =+/".contains(letter))
                && !text.starts_with(['-', ' ', '='])
                && !text.ends_with(' ');
            let is_safe = is_safe || text.starts_with('-') && plain(text).is_number();
            match !quoted && is_safe {
                true => text.clone(),
                false => format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"")),
            }
        }
    }
}

fn scalar(text: &str) -> Node {
    Node { spot: Default::default(), kind: NodeKind::Scalar { text: text.to_owned(), quoted: false } }
}

/// Every node below `node`, which it is part of, as the path of indices to it.
fn paths(node: &Node, path: &mut Vec<usize>, found: &mut Vec<Vec<usize>>) {
    found.push(path.clone());
    let count = match &node.kind {
        NodeKind::Mapping(entries) => entries.len(),
        NodeKind::Sequence(items) => items.len(),
        NodeKind::Scalar { .. } => 0,
    };
    for index in 0..count {
        path.push(index);
        let inner = match &node.kind {
            NodeKind::Mapping(entries) => &entries[index].1,
            NodeKind::Sequence(items) => &items[index],
            NodeKind::Scalar { .. } => unreachable!("a scalar has nothing inside"),
        };
        paths(inner, path, found);
        path.pop();
    }
}

fn at<'n>(node: &'n mut Node, path: &[usize]) -> &'n mut Node {
    path.iter().fold(node, |node, index| match &mut node.kind {
        NodeKind::Mapping(entries) => &mut entries[*index].1,
        NodeKind::Sequence(items) => &mut items[*index],
        NodeKind::Scalar { .. } => unreachable!("a scalar has nothing inside"),
    })
}

fn one_letter(word: &str, random: &mut MistakeRandom) -> String {
    let mut letters: Vec<char> = word.chars().collect();
    if letters.is_empty() {
        return "x".to_owned();
    }
    let index = random.below(letters.len());
    match random.below(3) {
        0 => letters[index] = if letters[index] == 'q' { 'w' } else { 'q' },
        1 => letters.insert(index, 'q'),
        _ if letters.len() > 2 => drop(letters.remove(index)),
        _ => letters.push('q'),
    }
    letters.into_iter().collect()
}

/// Values that are wrong at most positions.
const WRONG: &[&str] = &[
    "banana",
    "7",
    "-1",
    "1.5",
    "99999999999",
    "300",
    "65536",
    "5 parsecs",
    "5 cycles",
    "2s",
    "20",
    "9bad",
    "two words",
    "0x1G",
    "true",
    "false",
    "on",
    "none",
    "any",
    "256",
    "0",
    "4294967296",
    "-0x10",
    "a/b",
    "P65000",
    "",
];
/// Texts in quotes that are wrong at most positions.
const WRONG_QUOTED: &[&str] =
    &["", " ", "0G", "0a 0b", "00  00", "00 00 00 00 00", "a b", "*", ".. ..", "12", "x: 00", "=", "/ x"];
/// Verbs of steps, of which a step has one.
const VERBS: &[&str] = &["set", "expect", "read", "write", "wait", "send", "connect", "do", "save", "turn", "steps"];

/// Whether a text is a duration: after a name it depends on the name whether one is right.
fn expression_of_time(text: &str) -> bool {
    encspec::expression::duration(text).is_ok() && text.ends_with('s')
}

/// Whether a node is the value of a column or of something that is given, or stands after a key that is one: it may be anything until
/// it is used.
fn is_column(node: &Node, path: &[usize]) -> bool {
    let (mut node, mut keys) = (node, Vec::new());
    for index in path {
        node = match &node.kind {
            NodeKind::Mapping(entries) => {
                keys.push(entries[*index].0.scalar().unwrap_or_default().to_owned());
                &entries[*index].1
            }
            NodeKind::Sequence(items) => &items[*index],
            NodeKind::Scalar { .. } => return false,
        };
    }
    let inside = |of: &[&str]| keys.iter().position(|key| of.contains(&key.as_str())).map(|at| &keys[at + 1..]);
    let reserved =
        |keys: &[String]| keys.iter().any(|key| ["row", "covers", "catches", "variants"].contains(&key.as_str()));
    inside(&["give"]).is_some_and(|keys| !keys.is_empty())
        || keys.iter().any(|key| key.starts_with('='))
        || inside(&["with", "rows"]).is_some_and(|keys| !reserved(keys))
        || inside(&["set", "expect", "read", "write"]).is_some_and(|keys| !keys.is_empty() && node.scalar().is_some())
            && node.scalar().is_some_and(expression_of_time)
}

/// Keys of conditions.
const CONDITIONS: &[&str] = &["always", "when", "then", "until", "expect", "count", "sequence", "position_in"];

/// Whether a node is inside of expressions, whose mistakes are not of shape.
fn is_expression(node: &Node, path: &[usize]) -> bool {
    let mut node = node;
    for index in path {
        node = match &node.kind {
            NodeKind::Mapping(entries) => {
                let (key, value) = &entries[*index];
                let holds = |keys: &[&str]| key.scalar().is_some_and(|key| keys.contains(&key));
                let is_text = value.scalar().is_some();
                if holds(&["save", "derived"]) && !is_text || holds(CONDITIONS) && is_text {
                    return true;
                }
                value
            }
            NodeKind::Sequence(items) => &items[*index],
            NodeKind::Scalar { .. } => return false,
        };
    }
    false
}

/// Whether a node is a default, which is a number or a word as its field is.
fn is_default(node: &Node, path: &[usize]) -> bool {
    let mut node = node;
    for index in path {
        node = match &node.kind {
            NodeKind::Mapping(entries)
                if ["default", "fixes"].iter().any(|key| entries[*index].0.scalar() == Some(key)) =>
            {
                return true;
            }
            NodeKind::Mapping(entries) => &entries[*index].1,
            NodeKind::Sequence(items) => &items[*index],
            NodeKind::Scalar { .. } => return false,
        };
    }
    false
}

/// Makes one mistake somewhere in `node`; the kind of the mistake and what was changed.
fn spoil(node: &mut Node, random: &mut MistakeRandom) -> Option<(&'static str, String)> {
    let mut all = Vec::new();
    paths(node, &mut Vec::new(), &mut all);
    let path = random.one(&all).clone();
    if is_column(node, &path) || is_expression(node, &path) || is_default(node, &path) {
        return None;
    }
    let target = at(node, &path);
    if target.expression().is_some() {
        return None;
    }
    let before: String = text(target).chars().take(60).collect();
    let kind = match &mut target.kind {
        NodeKind::Mapping(entries) => match random.below(8) {
            0 => {
                entries.push((scalar(random.one::<&str>(&["unknown_key", "titel", "value", "is", "id"])), scalar("1")));
                "unknown key"
            }
            1 if !entries.is_empty() => {
                let index = random.below(entries.len());
                let name = one_letter(entries[index].0.scalar().unwrap_or_default(), random);
                entries[index].0 = scalar(&name);
                "misspelt key"
            }
            2 if !entries.is_empty() => {
                entries.remove(random.below(entries.len()));
                "missing key"
            }
            3 => {
                let verb = *random.one(VERBS);
                if entries.iter().any(|(key, _)| VERBS.iter().any(|verb| key.scalar() == Some(verb))) {
                    entries.push((scalar(verb), scalar("10ms")));
                }
                "two verbs"
            }
            4 => {
                entries.clear();
                "empty mapping"
            }
            5 => {
                target.kind = NodeKind::Sequence(vec![target.clone()]);
                "list for mapping"
            }
            6 => {
                target.kind = scalar(random.one::<&str>(WRONG)).kind;
                "text for mapping"
            }
            _ => {
                let verb = *random.one(VERBS);
                entries.retain(|(key, _)| key.scalar() == Some("id"));
                entries.push((scalar(verb), scalar("1")));
                "another mapping"
            }
        },
        NodeKind::Sequence(items) => match random.below(5) {
            0 => {
                items.clear();
                "empty list"
            }
            1 => {
                target.kind = scalar(random.one::<&str>(WRONG)).kind;
                "text for list"
            }
            2 => {
                let inner = target.clone();
                target.kind = NodeKind::Mapping(vec![(scalar("first"), inner)]);
                "mapping for list"
            }
            3 if !items.is_empty() => {
                items.pop();
                "shorter list"
            }
            _ => {
                let more = items.first().cloned().unwrap_or_else(|| scalar("1"));
                items.push(more);
                "longer list"
            }
        },
        NodeKind::Scalar { text, quoted } => match random.below(7) {
            0 => {
                target.kind = NodeKind::Sequence(vec![target.clone()]);
                "list for value"
            }
            1 => {
                let inner = target.clone();
                target.kind = NodeKind::Mapping(vec![(scalar(random.one::<&str>(&["value", "from", "first"])), inner)]);
                "mapping for value"
            }
            2 => {
                *text = one_letter(text, random);
                "misspelt word"
            }
            3 => {
                (*text, *quoted) = ((*random.one(WRONG_QUOTED)).to_owned(), true);
                "text for value"
            }
            _ => {
                (*text, *quoted) = ((*random.one::<&str>(WRONG)).to_owned(), false);
                "another value"
            }
        },
    };
    let after: String = text(target).chars().take(60).collect();
    Some((kind, format!("{path:?} {before} -> {after}")))
}

/// How a file is read: the first mistake that the loader finds in it.
pub type FileReader<'r> = Box<dyn Fn(&str) -> Option<String> + 'r>;

/// The readers of all suite files, by path.
pub fn readers<'r>(
    sources: &'r Sources,
    checkers: &'r BTreeMap<String, Checker>,
) -> Vec<(&'r str, &'r str, FileReader<'r>)> {
    let uses = |path: &str, name: &str| {
        let line = format!("use: {name}");
        sources.files().any(|(of, text)| of.starts_with(path) && text.lines().any(|known| known == line))
    };
    let reader = |(path, text): (&'r str, &'r str)| -> Option<(&'r str, &'r str, FileReader<'r>)> {
        let folder = path.split('/').next().unwrap_or_default();
        let name = path.rsplit('/').next().unwrap_or_default().trim_end_matches(".yaml");
        if folder == "personas" {
            let read = move |text: &str| {
                let sources = Sources::none().with(path, text);
                let errors = encspec::suite_yaml::persona::load_personas(&sources).err()?;
                errors.0.first().map(|error| format!("{} {}", error.message, error.help.clone().unwrap_or_default()))
            };
            return Some((path, text, Box::new(read)));
        }
        let checker = match folder {
            "common" => checkers
                .iter()
                .find(|(manual, _)| name == "procedures" || uses(&format!("{manual}/"), name))
                .map(|(_, checker)| checker)?,
            _ => checkers.get(folder)?,
        };
        let read = move |text: &str| {
            let errors = checker.check(path, text).err()?;
            errors.0.first().map(|error| format!("{} {}", error.message, error.help.clone().unwrap_or_default()))
        };
        Some((path, text, Box::new(read)))
    };
    sources.files().filter_map(reader).collect()
}

/// The readers of bench files and ledgers.
pub fn other_readers() -> Vec<(&'static str, &'static str, FileReader<'static>)> {
    let bench = |text: &str| {
        let folder = std::env::temp_dir().join(format!("encspec-mistakes-{}", std::process::id()));
        std::fs::create_dir_all(&folder).ok()?;
        let path = folder.join("bench.yaml");
        std::fs::write(&path, text).ok()?;
        let errors = results::bench_file::read_alone(&path).err()?;
        errors.0.first().map(|error| format!("{} {}", error.message, error.help.clone().unwrap_or_default()))
    };
    let ledger =
        |text: &str| results::ledger::Ledger::parse(Path::new("known.yaml"), text).err().map(|error| error.to_string());
    vec![("bench.yaml", BENCH, Box::new(bench)), ("known.yaml", LEDGER, Box::new(ledger))]
}

/// Which of the files `schema` accepts, by `jsonschema` of Python; none where it is not installed.
const JUDGE: &str = "
import json, sys
import jsonschema
given = json.load(sys.stdin)
validator = jsonschema.Draft202012Validator(given['schema'])
json.dump([index for index, data in enumerate(given['files']) if validator.is_valid(data)], sys.stdout)
";

fn accepted(schema: &Value, files: &[&Value]) -> Result<Vec<usize>, String> {
    let peers = testing::workspace().join("target/peers/python/bin/python");
    let python = if peers.is_file() { peers } else { "python3".into() };
    let missing =
        |why: &dyn std::fmt::Display| format!("jsonschema of Python is needed, .ci/peers/install installs it: {why}");
    let mut child = Command::new(python)
        .args(["-c", JUDGE])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| missing(&error))?;
    let given = json!({ "schema": schema, "files": files }).to_string();
    let mut input = child.stdin.take().expect("the input is a pipe");
    let writer = std::thread::spawn(move || input.write_all(given.as_bytes()));
    let output = child.wait_with_output().map_err(|error| missing(&error))?;
    let _ = writer.join();
    match output.status.success() {
        true => serde_json::from_slice(&output.stdout).map_err(|error| error.to_string()),
        false => Err(missing(&String::from_utf8_lossy(&output.stderr))),
    }
}

/// The mistakes of a day: the loader refuses each by its shape, and so does the schema, which accepts the files as they are.
#[test]
fn the_schema_refuses_every_shape_that_the_loader_refuses() {
    let day = DailySample::one_of(u64::MAX);
    let sources = suites::sources();
    let manuals = sources.manuals().into_iter();
    let checkers: BTreeMap<String, Checker> =
        manuals.map(|manual| (manual.clone(), Checker::unchecked(&sources, &manual).expect("it loads"))).collect();
    let mut readers = readers(&sources, &checkers);
    readers.extend(other_readers());
    let (mistakes, _) = mistakes(&readers, &mut MistakeRandom::new(day.part().unwrap_or_default()), LEAST);
    assert!(mistakes.len() >= LEAST, "{day}: only {} mistakes", mistakes.len());
    let kinds: BTreeSet<&str> = mistakes.iter().map(|mistake| mistake.kind).collect();
    assert!(kinds.len() > 10, "{day}: only mistakes of the kinds {kinds:?}");
    let right: Vec<Value> =
        readers.iter().filter_map(|(_, text, _)| parse(0, text).ok()).map(|node| data(&node)).collect();
    let all: Vec<&Value> = mistakes.iter().map(|mistake| &mistake.data).chain(&right).collect();
    let accepted = match accepted(&results::schema(), &all) {
        Ok(accepted) => accepted,
        Err(why) => {
            testing::available(Err(why));
            return;
        }
    };
    let slipped: Vec<String> = accepted
        .iter()
        .filter_map(|index| mistakes.get(*index))
        .map(|mistake| format!("{} ({}): the loader says: {}", mistake.what, mistake.kind, mistake.message))
        .collect();
    assert!(slipped.is_empty(), "{day}: the schema accepts {} mistakes:\n{}", slipped.len(), slipped.join("\n"));
    let refused: Vec<&str> = readers
        .iter()
        .enumerate()
        .filter(|(index, _)| !accepted.contains(&(mistakes.len() + index)))
        .map(|(_, (path, ..))| *path)
        .collect();
    assert!(refused.is_empty(), "the schema refuses {refused:?}");
}

const BENCH: &str = r#"
device: lika-xac77-profinet/xac7718
link: nic:eth1
station_name: enc-1
mac: 10:b9:fe:00:00:01
ip: 192.168.0.10
mask: 255.255.255.0
controller: { ip: 192.168.0.1, mac: 02:00:00:00:00:01 }
cycle: 4ms
watchdog: 40ms
persona: advanced-fast
boot_time: 5s
telegrams: [telegram_81]
lacks: [P61001]
firmware: 1.1.0
direct_cable: true
position_noise: 2
pages: { home: { path: /index.htm }, preset: { fields: { value: v } } }
stand:
  hooks: { power: 'stand power {value}' }
  ask: [turn]
  shaft: [hand, position(+/-2)]
consent: { factory_reset: true, set_name: true, set_ip: true, nvm_write: 20, position_reference: true, firmware: true, overstress: true,
  alone: true }
"#;
const LEDGER: &str = r#"
known_failures:
  - test: preset/absolute
    device: lika-xac77-profinet
    variant: xac7718
    firmware: { from: 1.0.0, to: 1.2.0 }
    reason: the preset is added
    ticket: FW-17
    expires: 2027-06-30
    signature: 'expect: *'
"#;

/// Whether a message that sounds of shape is about a relation that no schema can express.
fn is_of_meaning(node: &Node, kind: &str, message: &str) -> bool {
    let is_of_time = message.contains("write a duration as");
    // A start-up also has the records of the device, by name; a common case may have a start of its own.
    message.starts_with("unknown key of instead `")
        || message.starts_with("a case needs a `start`") && (node.get("use").is_some() || node.get("common").is_some())
        // One number that depends on another.
        || ["`data_hold` is ", "`phase_in` is ", "`phase_out` is ", " is not a position", "a watchdog is "].iter().any(|piece| message.contains(piece))
        // A default is a word where its field has words.
        || kind == "missing key" && message.contains(" is not a number")
        // A text where names and values stood is a condition, whose mistakes are its own.
        || kind == "text for mapping" && is_of_time
        // Which names have bytes or words depends on the device.
        || kind.ends_with(" value") && message.contains(" is not a byte") && node.get("cases").is_some()
        || message.starts_with("a word of `") && message.contains("not a list")
}

/// Mistakes of shape, at least `least` of them, in files of each kind.
pub fn mistakes(
    readers: &[(&str, &str, FileReader<'_>)],
    random: &mut MistakeRandom,
    least: usize,
) -> (Vec<ShapeMistake>, BTreeMap<String, usize>) {
    let (mut found, mut other) = (Vec::new(), BTreeMap::new());
    let mut tried = 0;
    while found.len() < least && tried < least * 200 {
        tried += 1;
        let (path, original, read) = random.one(readers);
        let Ok(mut node) = parse(0, original) else { continue };
        let Some((kind, change)) = spoil(&mut node, random) else { continue };
        let Some(message) = read(&text(&node)) else { continue };
        if is_of_meaning(&node, kind, &message) {
            continue;
        }
        let has_steps = node.get("cases").or(node.get("rules")).or(node.get("procedures")).is_some();
        let outside = OF_SHAPE_OUTSIDE_STEPS.iter().filter(|_| !has_steps);
        if !OF_SHAPE.iter().chain(outside).any(|piece| message.contains(piece)) {
            *other.entry(message).or_default() += 1;
            continue;
        }
        found.push(ShapeMistake { what: format!("{path} {change}"), kind, message, data: data(&node) });
    }
    (found, other)
}
