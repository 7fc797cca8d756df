//! What the loader refuses in cases and rules, each with the place and the words of the message.
//!
//! A small manual that loads is changed in one place at a time, so each test fails if its mistake is let through.

mod small_manual;

use encspec::suite::load;
use rstest::rstest;
use small_manual::{TOPIC, changed, refuses, sources};

#[test]
fn the_small_manual_loads() {
    if let Err(errors) = load(&sources(), None) {
        panic!("{errors}");
    }
}

#[rstest]
// keys and verbs
#[case("probe/topic.yaml", "expect: { ZSW", "expcet: { ZSW", "expcet:", "unknown verb `expcet`")]
#[case("probe/topic.yaml", "    why: It parks.", "    wyh: It parks.", "wyh: It parks.", "unknown key of a case `wyh`")]
#[case("probe/topic.yaml", "    why: It parks.\n", "", "id: first", "a case needs the key `why`")]
#[case(
    "probe/topic.yaml",
    "    why: It parks.",
    "    why: It parks.\n    why: Again.",
    "why: Again.",
    "duplicate key `why`"
)]
#[case(
    "probe/topic.yaml",
    "within: 50 cycles",
    "withn: 50 cycles",
    "withn: 50 cycles",
    "unknown modifier of expect `withn`"
)]
#[case("probe/topic.yaml", "- wait: 20ms", "- { wait: 20ms, save: { x: POS } }", "{", "a step has exactly one verb")]
#[case("probe/topic.yaml", "- wait: 20ms", "- { within: 20ms }", "{", "a step without a verb")]
#[case("probe/topic.yaml", "give: { bit: 0 }", "times: 2", "times: 2", "unknown modifier of do `times`")]
#[case("probe/topic.yaml", "times: 3", "tims: 3", "tims: 3", "unknown key of an entry of exchange `tims`")]
#[case(
    "probe/topic.yaml",
    "        answer: { refused: limit }",
    "        to: 126",
    "to: 126",
    "`to` exists on PROFIBUS only"
)]
// names, words, codes
#[case(
    "probe/topic.yaml",
    "ZSW.parked: =value",
    "ZSW.praked: =value",
    "ZSW.praked: =value",
    "unknown field `praked` of ZSW"
)]
#[case("probe/topic.yaml", "page: state", "page: stait", "stait", "unknown page `stait`")]
#[case(
    "probe/topic.yaml",
    "fields: { value: '1'",
    "fields: { valeu: '1'",
    "valeu: '1'",
    "unknown field of the page `valeu`"
)]
#[case("probe/topic.yaml", "page.level", "page.lewel", "page.lewel", "unknown value `lewel` of the web pages")]
#[case("probe/topic.yaml", "contains: 'L", "contians: 'L", "contians", "unknown part of a web answer `contians`")]
#[case("probe/topic.yaml", "lacks: ['error']", "lacks: ['']", "''", "an empty text is in every page")]
#[case("probe/device.yaml", "path: '/state'", "path: 'state'", "'state'", "a path begins with a slash")]
#[case("probe/device.yaml", "form: decimal", "form: decimel", "decimel", "unknown word for form `decimel`")]
#[case("probe/topic.yaml", "P922: 81", "P923: 81", "P923: 81", "unknown parameter `P923`")]
#[case(
    "probe/topic.yaml",
    "P1000.faults.memory",
    "P1000.fault.memory",
    "P1000.fault.memory: 0",
    "unknown element `fault` of P1000"
)]
#[case("probe/topic.yaml", "P1000.faults.memory: 0", "P1000.2: 0", "P1000.2: 0", "the element 2 of P1000 has a name")]
#[case("probe/topic.yaml", "P1000.faults.memory: 0", "P1000.7: 0", "P1000.7: 0", "P1000 has no element 7")]
#[case("probe/topic.yaml", "word: enabled", "word: enabld", "enabld", "`enabld` is no word of `switch`")]
#[case("probe/topic.yaml", "STW.life: held", "STW.life: hold", "hold", "unknown way to count `hold`")]
#[case("probe/topic.yaml", "refused: limit", "refused: limits", "limits", "unknown code `limits`")]
#[case("probe/topic.yaml", "refused: limit", "refused: 2", "2", "a code is a word, not a number")]
#[case("probe/topic.yaml", "{ not: memory }", "{ not: memry }", "memry", "`memry` is no word of `channel_error`")]
#[case("probe/topic.yaml", "module: short", "module: shrot", "shrot", "unknown module `shrot`")]
#[case("probe/topic.yaml", "range: 100", "rnage: 100", "rnage: 100", "unknown start parameter `rnage`")]
#[case("probe/topic.yaml", "bf00: accepted", "bf01: accepted", "bf01: accepted", "unknown stage of a start-up `bf01`")]
#[case("probe/topic.yaml", "connection: data", "connection: date", "date", "unknown word for state `date`")]
#[case("probe/topic.yaml", "led.bus: dark", "led.bus: green", "green", "`green` is no word of `led.bus`")]
#[case("probe/topic.yaml", "variants: [one]", "variants: [won]", "won", "unknown variant `won`")]
#[case("probe/topic.yaml", "do: leave", "do: leaf", "leaf", "unknown procedure `leaf`")]
#[case("probe/topic.yaml", "catches: [stuck]", "catches: [stick]", "stick", "unknown bug `stick`")]
#[case("probe/topic.yaml", "covers: [PRB-1]", "covers: [PRB-3]", "PRB-3", "unknown requirement `PRB-3`")]
#[case("probe/topic.yaml", "covers: [PRB-1]", "covers: [PRB-2]", "PRB-2", "PRB-2 does not apply to the variant two")]
#[case("probe/topic.yaml", "suite: topic", "suite: topics", "topics", "this is the file `topic`")]
// a name with the wrong verb, a name that the module lacks
#[case("probe/topic.yaml", "set: { STW.park", "set: { ZSW.parked", "ZSW.parked: =value", "`ZSW.parked` has no `set`")]
#[case("probe/topic.yaml", "read: { P922: 81", "read: { POS: 81", "POS: 81", "`POS` has no `read`")]
#[case("probe/topic.yaml", "led.bus: dark", "POS: 1", "POS: 1", "`POS` is not in the module `short`")]
#[case("probe/topic.yaml", "led.bus: dark", "power: up", "power: up", "`power` has no `expect`")]
#[case(
    "probe/topic.yaml",
    "P971: 1 }\n        answer: { refused: limit }",
    "P922: 1 }",
    "P922",
    "P922 can only be read"
)]
#[case("probe/topic.yaml", "P971: 1", "P971: 1, bf00.range: 5", "bf00.range: 5", "one `write` asks one service")]
// literals
#[case("probe/topic.yaml", "P922: 81", "P922: 65536", "65536", "65536 is out of range")]
#[case("probe/topic.yaml", "P922: 81", "P922: 8_1", "8_1", "has a `_` in a number")]
#[case("probe/topic.yaml", "P922: 81", "P922: 081", "081", "has a leading zero")]
#[case("probe/topic.yaml", "P922: 81", "P922: '81'", "'81'", "a whole number stands without quotes")]
#[case("probe/topic.yaml", "scaling: enabled", "scaling: on", "on", "`on` is a word of YAML itself")]
#[case("probe/topic.yaml", "wait: 20ms", "wait: 20", "20", "`20` has no unit")]
#[case("probe/topic.yaml", "wait: 20ms", "wait: 20msec", "20msec", "`msec` is no unit")]
#[case("probe/topic.yaml", "range: 100", "range: 4294967296", "4294967296", "4294967296 is out of range")]
// expressions
#[case("probe/topic.yaml", "before + value", "before + vlaue", "vlaue +/- 1", "there is no name `vlaue`")]
#[case(
    "probe/topic.yaml",
    "always: not (ZSW.parked and ZSW.error)",
    "always: not (ZSW.parked and ZSW.error",
    "",
    "`)`"
)]
#[case(
    "probe/topic.yaml",
    "always: not (ZSW.parked and ZSW.error)",
    "always: not (ZSW.parked and POS)",
    "POS)",
    "a condition is wanted here"
)]
#[case("probe/topic.yaml", "scaling == disabled", "scaling == disabeld", "disabeld", "disabeld")]
#[case("probe/topic.yaml", "=timing.save", "=timing.sav", "timing.sav", "timing")]
#[case(
    "probe/topic.yaml",
    "when: rises(STW.park) and scaling == disabled",
    "when: 1 == 1",
    "1 == 1",
    "the premise is always true"
)]
// readings that are faults
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { either: { one: [ { read: { P922: 1 } } ], two: [ { read: { P922: 2 } } ] }, finding: { tow: It is two. } }",
    "tow",
    "unknown reading `tow`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { either: { one: [ { read: { P922: 1 } } ], two: [ { read: { P922: 2 } } ] }, findign: { two: It is two. } }",
    "findign",
    "unknown modifier of either `findign`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { either: { one: [ { read: { P922: 1 } } ], two: [ { read: { P922: 2 } } ] }, finding: { one: One., two: Two. } }",
    "{ one:",
    "every reading is a fault"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { either: { one: [ { read: { P922: 1 } } ], two: [ { read: { P922: 2 } } ] }, finding: { one: One. } }",
    "two",
    "a right reading stands before those that are faults"
)]
// what only goes with something else
#[case(
    "probe/topic.yaml",
    "times: 3 }",
    "times: 3, expect: { POS: 1 } }",
    "expect: {",
    "`expect` in `exchange` exists on PROFIBUS only"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { expect: ZSW.parked, for: 1s, until: ZSW.error }",
    "ZSW.error",
    "`until` replaces `for`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- either: { one: [ { read: { P922: 1 } } ] }",
    "{ one",
    "`either` has two or more readings"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- either: { one: [ { read: { P922: 1 } } ], two: [ { wait: 1s } ] }",
    "{ wait",
    "a reading has only `expect` and `read`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { read: { P922: 1 }, as: third }",
    "third",
    "`as` is `second` or left out"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { times: 0, steps: [ { wait: 1s } ] }",
    "0",
    "a block that is never done"
)]
#[case("probe/topic.yaml", "- wait: 20ms", "- turn: { counts: 1, degrees: 2 }", "{ counts", "a turn has one of")]
#[case("probe/topic.yaml", "- wait: 20ms", "- save: { POS: 1 }", "POS", "`POS` is a name already")]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { connect: { module: long, cycle: 3ms } }",
    "3ms",
    "no send clock and reduction make this cycle"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { connect: { module: long, watchdog: 3ms } }",
    "3ms",
    "a watchdog is a whole number of cycles"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- connect: { module: long, instead: { lenght: 3 } }",
    "lenght",
    "unknown key of instead `lenght`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { read: { P922: 1 }, instead: { atribute: 3 } }",
    "atribute",
    "unknown key of instead `atribute`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { read: { P922: { refused: any } }, instead: { format: wrod } }",
    "wrod",
    "unknown format `wrod`"
)]
#[case("probe/topic.yaml", "- wait: 20ms", "- read: { P1: 5 }", "P1", "unknown parameter `P1`")]
#[case("probe/topic.yaml", "- wait: 20ms", "- read: { P922: { form: 1, to: 2 } }", "form", "unknown matcher `form`")]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- send: { dcp_rseet: { mode: factory } }",
    "dcp_rseet",
    "unknown service `dcp_rseet`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- send: { dcp_reset: { mode: factroy } }",
    "factroy",
    "unknown mode `factroy`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- send: { broken: { frame: dcp_cut } }",
    "dcp_cut",
    "unknown broken frame `dcp_cut`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- send: { fdl_status: {} }",
    "{ fdl_status",
    "`fdl_status` exists on PROFIBUS only"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- connect: { module: long, instead: { rt_class: 4 } }",
    "4",
    "4 is no RT class of a cyclic frame"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- connect: { module: long, instead: { slot: 65536 } }",
    "65536",
    "is out of range"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- connect: { module: long, instead: { dap_idnet: 2 } }",
    "dap_idnet",
    "unknown key of instead `dap_idnet`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- connect: { module: long, instead: { ip: 192.168.0.7 } }",
    "192.168.0.7",
    "`ip` is `none` here"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { read: { P922: { refused: any } }, instead: { index: 3 } }",
    "index",
    "unknown key of instead `index`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { write: { station.name: 'x' }, instead: { destination: \"02 00\" }, answer: none }",
    "\"02 00\"",
    "a MAC address has 6 octets"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- { read: { station.name: 'x' }, instead: { destination: \"02 00 00 00 00 99\" } }",
    "destination",
    "what another station is asked for has no answer to compare with"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- write: { station.mac: \"02\" }",
    "station.mac",
    "`station.mac` has no `write`"
)]
#[case("probe/topic.yaml", "- wait: 20ms", "- read: { station.mca: any }", "station.mca", "station.mca")]
#[case("probe/topic.yaml", "- wait: 20ms", "- expect: { lldp.nmae: 'x' }", "lldp.nmae", "lldp.nmae")]
#[case("probe/topic.yaml", "- wait: 20ms", "- set: { lldp.name: 'x' }", "lldp.name", "`lldp.name` has no `set`")]
#[case("probe/topic.yaml", "- wait: 20ms", "- set: { device: new }", "new", "`new` is no word of `device`")]
#[case("probe/topic.yaml", "- wait: 20ms", "- expect: { device: as_delivered }", "device", "`device` has no `expect`")]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- set: { io.alarm_acknowledge: hold }",
    "hold",
    "`hold` is no word of `io.alarm_acknowledge`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- expect: { io.alarm_acknowledge: held }",
    "io.alarm_acknowledge",
    "`io.alarm_acknowledge` has no `expect`"
)]
#[case("probe/topic.yaml", "- wait: 20ms", "- send: { arp: { pi: 192.168.0.1 } }", "pi", "unknown field of arp `pi`")]
#[case("probe/topic.yaml", "- wait: 20ms", "- send: { arp_probe: { ip: 192.168.0 } }", "192.168.0", "is no address")]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- send: { arp: { ip: =bench.adress } }",
    "bench.adress",
    "there is no name `bench.adress`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- send: { arp: { ip: =cycle } }",
    "cycle",
    "this compares an address with a duration"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- write: { station.ip: =bench.fre_ip }",
    "bench.fre_ip",
    "there is no name `bench.fre_ip`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- set: { bench.mask: 255.0.0.0 }",
    "bench.mask",
    "`bench.mask` has no `set`"
)]
#[case(
    "probe/topic.yaml",
    "- wait: 20ms",
    "- send: { dcp_identify: { alias: 'a.b', name: 'c' } }",
    "{ alias",
    "dcp_identify needs one of `name`, `alias` and `who`"
)]
#[case(
    "probe/topic.yaml",
    "      - read: { P922: 81, P1000.faults.memory: 0 }",
    "      - { read: { P922: 81, P1000.faults.memory: 0 }, covers: [PRB-9] }",
    "PRB-9",
    "unknown requirement `PRB-9`"
)]
#[case("probe/device.yaml", "range: { octets", "device: { octets", "device: {", "`device` is a name already")]
#[case("probe/topic.yaml", "is: 1 } ]", "si: 1 } ]", "si", "unknown key of an observed rule `si`")]
#[case(
    "probe/topic.yaml",
    "{ count: rises(ZSW.parked), is: 1 }",
    "{ sequence: [ZSW.parked, ZSW.error], is: [[0, 0], [1]] }",
    "[1]",
    "there are 2 names, and here 1 values"
)]
#[case("probe/topic.yaml", "- wait: 20ms", "- write: { station.name: probe }", "probe", "a text stands in quotes")]
#[case("probe/topic.yaml", "- wait: 20ms", "- write: { station.ip: 192.168.0.300 }", "192.168.0.300", "is no address")]
#[case("probe/topic.yaml", "- wait: 20ms", "- set: { io.outputs: \"4 0\" }", "4 0", "")]
#[case(
    "probe/procedures.yaml",
    "- set: { STW.park: =bit }",
    "- set: { STW.park: =bit }\n      - do: leave",
    "leave",
    "a procedure does no other procedure"
)]
// empty things
#[case("probe/topic.yaml", "set: { STW.life: held }", "set: {}", "{}", "an empty `set`")]
#[case("probe/topic.yaml", "          - wait: 20ms", "          []", "[]", "a block is empty")]
#[case(
    "probe/topic.yaml",
    "expect: { led.bus: dark, alarm.error: { not: memory } }",
    "expect: {}",
    "{}",
    "an empty condition"
)]
#[case("probe/topic.yaml", "covers: [PRB-1]\n    catches", "catches", "id: first", "`topic/first[on]` covers nothing")]
#[case("probe/topic.yaml", "within: 200ms", "for: 200ms", "id: parks", "a rule has to say `within`")]
fn refused(#[case] path: &str, #[case] old: &str, #[case] new: &str, #[case] points_at: &str, #[case] message: &str) {
    refuses(path, old, new, points_at, message);
}

/// A case passes on a dead device if it waits for silence only.
#[rstest]
#[case("- expect: { connection: none }")]
#[case("- send: { dcp_signal: {} }\n        answer: none")]
#[case("- wait: 1s\n      - observe: [ { always: connection == none } ]\n        steps: [ { wait: 1s } ]")]
fn dead_device(#[case] step: &str) {
    let topic = format!(
        "suite: more\ndefaults: {{ start: {{ module: long }} }}\ncases:\n  - id: dead\n    why: Nothing.\n    covers: [PRB-1]\n    steps:\n      {step}\n"
    );
    let errors = load(&sources().with("probe/more.yaml", topic), None).expect_err("nothing alive is asked for");
    assert!(errors.to_string().contains("a dead device passes `more/dead`"), "{errors}");
}

#[test]
fn a_case_without_a_check_is_refused() {
    let topic = "suite: more\ndefaults: { start: { module: long } }\ncases:\n  - id: idle\n    why: It looks at nothing.\n    covers: [PRB-1]\n    steps:\n      - wait: 1s\n";
    let errors = load(&sources().with("probe/more.yaml", topic), None).expect_err("nothing is checked");
    assert!(errors.to_string().contains("`more/idle` checks nothing"), "{errors}");
}

/// Checks with `covers` of their own are not judged for what the case covers, so that nothing could fail it.
#[rstest]
#[case("- read: { P922: 81 }\n        covers: [PRB-1]", false)]
#[case("- send: { dcp_signal: {} }\n      - read: { P922: 81 }\n        covers: [PRB-1]", false)]
#[case("- write: { P971: 1 }\n      - expect: ZSW.parked\n        covers: [PRB-1]", false)]
#[case("- steps: [ { expect: ZSW.parked, covers: [PRB-1] } ]", false)]
#[case("- read: { P922: 81 }\n        covers: [PRB-1]\n      - expect: ZSW.parked", true)]
#[case("- read: { P922: 81 }\n        covers: [PRB-1]\n      - steps: [ { expect: ZSW.parked } ]", true)]
#[case(
    "- read: { P922: 81 }\n        covers: [PRB-1]\n      - send: { dcp_signal: {} }\n        answer: accepted",
    true
)]
#[case("- observe: [ { always: ZSW.parked } ]\n        steps: [ { read: { P922: 81 }, covers: [PRB-1] } ]", true)]
fn requirements_that_no_check_can_fail(#[case] steps: &str, #[case] loads: bool) {
    let topic = |covers: &str| {
        format!(
            "suite: more\ndefaults: {{ start: {{ module: long }} }}\ncases:\n  - id: blind\n    why: Nothing.\n{covers}    steps:\n      {steps}\n"
        )
    };
    let loaded = load(&sources().with("probe/more.yaml", topic("    covers: [PRB-1]\n")), None);
    match loaded {
        Ok(_) => assert!(loads, "{steps}"),
        Err(errors) => {
            let said = errors.to_string();
            let good = said.contains("nothing in `more/blind` can fail what the case itself covers");
            assert!(
                !loads && good && said.contains("covers: [PRB-1]") && said.contains("name these requirements"),
                "{said}"
            );
            // Without requirements of its own there is nothing to object to.
            if let Err(errors) = load(&sources().with("probe/more.yaml", topic("")), None) {
                panic!("{errors}");
            }
        }
    }
}

#[test]
fn the_line_is_shown_and_the_nearest_word_suggested() {
    let errors = changed("probe/topic.yaml", "ZSW.parked: =value", "ZSW.praked: =value").expect_err("misspelt");
    let shown = "suites/probe/topic.yaml:16:19: unknown field `praked` of ZSW\n   \
                 | - expect: { ZSW.praked: =value, POS: = before + value +/- 1 }\n   \
                 |             ^^^^^^^^^^\n   \
                 = did you mean `parked`?";
    assert_eq!(errors.to_string(), shown);
}

#[test]
fn all_mistakes_of_a_file_come_at_once() {
    let text =
        TOPIC.replacen("ZSW.parked", "ZSW.praked", 1).replacen("P922", "P923", 1).replacen("wait: 20ms", "wait: 20", 1);
    let errors = load(&sources().with("probe/topic.yaml", text), None).expect_err("three mistakes");
    let lines: Vec<u32> = errors.0.iter().map(|error| error.at.line).collect();
    assert_eq!(lines, [16, 19, 40], "{errors}");
}

#[rstest]
#[case("a: &b 1", "suites have no anchors")]
#[case("a: !b 1", "suites have no tags")]
#[case("a: [1, 2", "this is no YAML")]
#[case("a: 1\n---\nb: 2", "a second one begins")]
#[case("", "the file is empty")]
fn yaml_that_is_refused(#[case] text: &str, #[case] message: &str) {
    let errors = load(&sources().with("probe/topic.yaml", text), None).expect_err("no suite");
    assert!(errors.to_string().contains(message), "{errors}");
}

#[test]
fn an_unknown_manual_is_named() {
    let errors = load(&sources(), Some("prboe")).expect_err("there is none");
    assert_eq!(errors.to_string(), "suites: there is no manual `prboe`\n   = did you mean `probe`?");
}

#[test]
fn what_nothing_uses_is_listed() {
    let manuals = load(&sources(), None).expect("it loads");
    let unused: Vec<&str> = manuals[0].unused.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        unused,
        [
            "signal `SPD`",
            "field `only_long.level`",
            "record `longer`",
            "field `longer.scaling_in_use`",
            "field `longer.state`",
            "fault `memory`",
            "role `position`",
        ]
    );
}
