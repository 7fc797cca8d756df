//! Each number that decides a verdict in the shipped suites is printed by a manual or has a name among the times and tolerances of ours.
//!
//! Stimuli are free: what `set`, `turn`, `write`, `start` and `connect` bring about, and times between two `cyclic: paused` and
//! `running`.

use super::code_rules::{files, relative_path, text};
use std::collections::BTreeMap;
use suite_yaml::yaml::{self, Node, NodeKind};

/// Numbers that stay, by file, with the reason: cycles that the protocol itself counts, and times that a case is about.
const NOT_OURS: &[(&str, &str, &str)] = &[
    ("suites/common/parking.yaml", "60 cycles", "the sign of life of the device counts in cycles"),
    ("suites/common/protocol-cyclic.yaml", "160ms", "the watchdog time that the case sets"),
    ("suites/common/protocol-cyclic.yaml", "320ms", "twice the watchdog time that the case sets"),
    ("suites/common/protocol-alarm-transfer.yaml", "1500ms", "three of the repetitions that the case agrees on"),
    ("suites/common/protocol-alarm-transfer.yaml", "1s", "two of the repetitions that the case agrees on"),
    ("suites/common/protocol-alarm-transfer.yaml", "2s", "more than the repetitions that the case agrees on take"),
    ("suites/common/protocol-alarm-transfer.yaml", "1200ms", "less than the repetitions that the case agrees on take"),
    ("suites/common/protocol-alarm-transfer.yaml", "5s", "more than the repetitions that the case agrees on take"),
    ("suites/common/protocol-snmp.yaml", "10ms", "the unit of sysUpTime, RFC 1155"),
    ("suites/common/protocol-snmp.yaml", "20ms", "twice that unit"),
    ("suites/common/protocol-dcp.yaml", "500ms", "a part of the 3 s that the LED flashes"),
    ("suites/common/protocol-hello.yaml", "3s", "longer than any watchdog"),
    ("suites/common/protocol-hello.yaml", "2s", "more than the repetitions of the record take"),
    ("suites/common/protocol-hello.yaml", "900ms", "less than the delay of the record"),
    ("suites/common/protocol-interruptions.yaml", "3s", "longer than any watchdog"),
    ("suites/common/protocol-neighbours.yaml", "8s", "one and a half times the 5 s of IEEE 802.1AB in PROFINET"),
    ("suites/common/protocol-transactions.yaml", "5s", "longer than a transaction may last"),
    ("suites/common/sign-of-life-ignored.yaml", "20 cycles", "the sign of life of the controller counts in cycles"),
    ("suites/common/parameter-requests.yaml", "2 cycles", "the pace of the requests, which decides nothing"),
    ("suites/kuebler-sendix58xx-profinet/controller.yaml", "60 cycles", "the sign of life counts in cycles"),
    ("suites/kuebler-sendix58xx-profinet/outputs.yaml", "60 cycles", "the sign of life counts in cycles"),
    ("suites/kuebler-sendix58xx-profinet/parameter-requests.yaml", "2 cycles", "the pace of the requests"),
    ("suites/kuebler-sendix58xx-profinet/start-up.yaml", "5 cycles", "the status of inputs is seen in cycles"),
    ("suites/kuebler-sendix58xx-profinet/signals.yaml", "100 cycles", "new inputs are counted in cycles"),
    ("suites/kuebler-sendix58xx-profinet/signals.yaml", "200 cycles", "the sign of life counts in cycles"),
    ("suites/lika-xac77-profinet/alarms.yaml", "50 cycles", "new inputs are counted in cycles"),
    ("suites/lika-xac77-profinet/memory.yaml", "1ms", "how soon the power fails"),
    ("suites/lika-xac77-profinet/memory.yaml", "10ms", "how soon the power fails"),
    ("suites/lika-xac77-profinet/memory.yaml", "100ms", "how soon the power fails"),
    ("suites/lika-xac77-profinet/parking.yaml", "60 cycles", "the sign of life counts in cycles"),
    ("suites/lika-xac77-profinet/sign-of-life.yaml", "50 cycles", "the sign of life counts in cycles"),
    ("suites/lika-xac77-profinet/sign-of-life.yaml", "60 cycles", "the sign of life counts in cycles"),
    ("suites/lika-xac77-profinet/sign-of-life.yaml", "100 cycles", "the sign of life counts in cycles"),
    ("suites/lika-xac77-profinet/telegrams.yaml", "5 cycles", "the pace of the requests"),
    ("suites/lika-xac77-profinet/telegrams.yaml", "50 cycles", "new inputs and the sign of life are counted in cycles"),
    ("suites/lika-xac77-profinet/telegrams.yaml", "500 cycles", "new inputs are counted in cycles"),
    ("suites/lika-xac77-profinet/web.yaml", "4 cycles", "the pace of the requests"),
    ("suites/profidrive-encoder/memory.yaml", "1ms", "how soon the power fails"),
    ("suites/profidrive-encoder/memory.yaml", "10ms", "how soon the power fails"),
    ("suites/profidrive-encoder/memory.yaml", "100ms", "how soon the power fails"),
    ("suites/profidrive-encoder/sign-of-life.yaml", "50 cycles", "the sign of life counts in cycles"),
    ("suites/profidrive-encoder/sign-of-life.yaml", "60 cycles", "the sign of life counts in cycles"),
    ("suites/profidrive-encoder/sign-of-life.yaml", "100 cycles", "the sign of life counts in cycles"),
    ("suites/profidrive-encoder/telegrams.yaml", "50 cycles", "new inputs and the sign of life are counted in cycles"),
    ("suites/profinet-io/protocol-dcp.yaml", "400ms", "the delay that the Identify allows"),
    ("suites/sick-afx60-profinet/memory.yaml", "2ms", "how soon the power fails"),
    ("suites/sick-afx60-profinet/memory.yaml", "8ms", "how soon the power fails"),
    ("suites/sick-afx60-profinet/operating-status.yaml", "6min", "one unit of the operating time"),
    ("suites/sick-afx60-profinet/sensor-status.yaml", "50 cycles", "new inputs are counted in cycles"),
    ("suites/sick-afx60-profinet/service-log.yaml", "5s", "half of the ramp of the shaft"),
    ("suites/sick-afx60-profinet/service-log.yaml", "10s", "the ramp of the shaft ends meanwhile"),
    ("suites/sick-afx60-profinet/service-log.yaml", "20s", "the time that the device counts"),
    ("suites/sick-afx60-profinet/service-log.yaml", "60s", "the time that the device counts"),
    ("suites/sick-afx60-profinet/signals.yaml", "50 cycles", "new inputs are counted in cycles"),
    ("suites/sick-afx60-profinet/telegrams.yaml", "1000 cycles", "new inputs are counted in cycles"),
    ("suites/sick-a3m60-profibus/isochronous.yaml", "100 cycles", "signs of life count in cycles"),
    ("suites/sick-a3m60-profibus/isochronous.yaml", "500 cycles", "signs of life count in cycles"),
    ("suites/sick-a3m60-profibus/isochronous.yaml", "1000 cycles", "signs of life count in cycles"),
    ("suites/sick-a3m60-profibus/isochronous.yaml", "1500 cycles", "signs of life count in cycles"),
    ("suites/sick-a3m60-profibus/parking.yaml", "100 cycles", "the sign of life of the device counts in cycles"),
    ("suites/sick-a3m60-profibus/signals.yaml", "100 cycles", "the sign of life of the device counts in cycles"),
    ("suites/common/protocol-cyclic.yaml", "3ms", "frames of another station come in several phases of the cycle"),
    ("suites/common/protocol-plug.yaml", "1s", "half of the pause before the parameters that the case sets"),
    ("suites/common/protocol-snmp.yaml", "1s", "sysUpTime counts hundredths of a second"),
    ("suites/common/protocol-snmp.yaml", "25s", "longer than the time to live of the announcement that the case sends"),
    ("suites/common/protocol-supervisor.yaml", "5s", "five times the time-out that the case sets"),
    ("suites/dp-slave/diagnosis.yaml", "100ms", "the watchdog that the case sets"),
    ("suites/dp-slave/parameters.yaml", "50ms", "a quarter of the watchdog that the case sets"),
    ("suites/dp-slave/parameters.yaml", "100ms", "the watchdog that the case sets, or a third of it"),
    ("suites/dp-slave/parameters.yaml", "300ms", "the watchdog that the case sets, or half of it"),
    ("suites/dp-slave/parameters.yaml", "400ms", "two thirds of the watchdog that the case sets"),
    ("suites/dp-slave/records.yaml", "1s", "more than twice the time-out that the case sets"),
    ("suites/sick-afx60-profinet/velocity.yaml", "200ms", "the window of the mean that the case sets"),
    ("suites/sick-afx60-profinet/velocity.yaml", "400ms", "the window of the mean that the case sets"),
];

/// Keys whose contents are stimuli or text.
const FREE: [&str; 15] = [
    "id", "why", "set", "turn", "write", "start", "connect", "send", "finding", "covers", "catches", "instead",
    "exchange", "row", "takes",
];
/// Units of time, and cycles.
const UNITS: [&str; 6] = ["ns", "us", "ms", "s", "min", "cycles"];

/// A number of a text with the letters behind it: `100ms`, `5 cycles`, `1`.
fn numbers(text: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let (mut rest, mut before) = (text, ' ');
    while let Some(first) = rest.chars().next() {
        let is_begin = first.is_ascii_digit() && !before.is_alphanumeric() && !['_', '.'].contains(&before);
        if !is_begin {
            before = first;
            rest = &rest[first.len_utf8()..];
            continue;
        }
        let digits = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '.')).unwrap_or(rest.len());
        let (word, after) = rest.split_at(digits);
        let end =
            word.find(|c: char| c.is_ascii_alphabetic()).filter(|_| !word.starts_with("0x")).unwrap_or(word.len());
        let (number, unit) = word.split_at(end);
        let cycles = after.strip_prefix(" cycles").map_or("", |_| "cycles");
        found.push((number.to_owned(), if unit.is_empty() { cycles } else { unit }.to_owned()));
        (before, rest) = ('0', after);
    }
    found
}

/// What is wrong with a text in a suite: durations without a name, tolerances without a name, multiples of the cycle.
fn unnamed(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for (number, unit) in numbers(text).into_iter().filter(|(_, unit)| UNITS.contains(&unit.as_str())) {
        found.push(if unit == "cycles" { format!("{number} cycles") } else { format!("{number}{unit}") });
    }
    for part in text.split("+/-").skip(1) {
        let part = part.split([',', ']', '}']).next().unwrap_or_default();
        let is_percent = part.contains('%');
        let own = numbers(part).into_iter().filter(|(_, unit)| unit.is_empty());
        let is_step = |number: &str| matches!(number, "0" | "1") && !is_percent;
        let factors = part.contains("tolerance.") || part.contains("printed.");
        found.extend(own.filter(|(number, _)| !is_step(number) && !factors).map(|(number, _)| format!("+/- {number}")));
    }
    for (at, _) in text.match_indices("* cycle") {
        let ends =
            text[at + "* cycle".len()..].chars().next().is_none_or(|next| !next.is_alphanumeric() && next != '_');
        let factor = text[..at].rsplit(|c: char| c.is_whitespace() || c == '(').find(|word| !word.is_empty());
        let is_named = factor.is_some_and(|factor| factor.starts_with("tolerance."));
        found.extend((ends && !is_named).then(|| "a multiple of the cycle".to_owned()));
    }
    found
}

/// Collects what is wrong under a node; `stimuli` are the columns that only set something.
fn walk(node: &Node, stimuli: &[String], found: &mut Vec<(u32, String)>) {
    match &node.kind {
        NodeKind::Scalar { text, .. } => {
            found.extend(unnamed(text).into_iter().map(|wrong| (node.spot.line, wrong)));
        }
        NodeKind::Sequence(items) => {
            let mut is_paused = false;
            for item in items {
                let said = item.to_string();
                is_paused = said.contains("io.cyclic: paused") || is_paused && !said.contains("io.cyclic: running");
                if !(is_paused && item.get("wait").is_some()) {
                    walk(item, stimuli, found);
                }
            }
        }
        NodeKind::Mapping(entries) => {
            for (key, value) in entries {
                let name = key.scalar().unwrap_or_default();
                if !FREE.contains(&name) && !stimuli.iter().any(|column| column == name) {
                    walk(value, stimuli, found);
                }
            }
        }
    }
}

/// The columns that a file uses for a cycle or a watchdog.
fn stimuli(text: &str) -> Vec<String> {
    let uses = ["cycle: =", "watchdog: =", "isochronous: ="].iter().flat_map(|key| text.split(key).skip(1));
    uses.filter_map(|rest| rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next()).map(str::to_owned).collect()
}

fn places() -> BTreeMap<String, Vec<(u32, String)>> {
    let mut all = BTreeMap::new();
    for path in files("suites", "yaml") {
        let (name, content) = (relative_path(&path), text(&path));
        let file = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let is_list = ["device", "masks"].contains(&file.as_str())
            || file.starts_with("requirements")
            || file.starts_with("bugs");
        if is_list || name.starts_with("suites/personas") {
            continue;
        }
        let node = yaml::parse(0, &content).unwrap_or_else(|mistake| panic!("{name}: {}", mistake.message));
        let mut found = Vec::new();
        walk(&node, &stimuli(&content), &mut found);
        found.retain(|(_, wrong)| !NOT_OURS.iter().any(|(file, number, _)| *file == name && number == wrong));
        if !found.is_empty() {
            all.insert(name, found);
        }
    }
    all
}

#[test]
fn what_decides_is_printed_or_has_a_name() {
    let wrong: Vec<String> = places()
        .into_iter()
        .flat_map(|(file, found)| found.into_iter().map(move |(line, what)| format!("{file}:{line}: {what}")))
        .collect();
    assert_eq!(wrong, [""; 0], "use `printed`, `timing` or `tolerance` of device.yaml:\n{}", wrong.join("\n"));
}

#[test]
fn each_number_that_stays_is_in_its_file() {
    for (file, number, why) in NOT_OURS {
        let path = files("suites", "yaml").into_iter().find(|path| relative_path(path) == *file);
        let content = path.map(|path| text(&path)).unwrap_or_default();
        assert!(content.contains(number), "{file} has no {number}: {why}");
    }
}

#[test]
fn unnamed_numbers_are_found() {
    for (text, expected) in [
        ("100ms", vec!["100ms"]),
        ("0", vec![]),
        ("=timing.reaction", vec![]),
        ("= 2 * printed.filter + 5ms", vec!["5ms"]),
        ("50 cycles", vec!["50 cycles"]),
        ("since(changes(x)) <= 10 * cycle", vec!["a multiple of the cycle"]),
        ("since(changes(x)) <= 2 * tolerance.late_frames * cycle", vec![]),
        ("= before + 1000 +/- 1", vec![]),
        ("= before + 1000 +/- 3", vec!["+/- 3"]),
        ("= shown +/- 1 %", vec!["+/- 1"]),
        ("= shown +/- tolerance.speed %", vec![]),
        ("= shown +/- 2 * printed.accuracy", vec![]),
        ("80 00 12 34", vec![]),
        ("0x5s", vec![]),
        ("telegram_81 and 5 min", vec![]),
    ] {
        assert_eq!(unnamed(text), expected, "{text}");
    }
}
