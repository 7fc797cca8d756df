//! What the loader refuses, each with the place and the words of the message.
//!
//! A small manual that loads is changed in one place at a time, so each test fails if its mistake is let through.

use encspec::suite::{LoadErrors, Sources, load};
use rstest::rstest;

const DEVICE: &str = "\
device: probe
bus: profinet
title: A probe
identity: { vendor_id: 0x0239, device_id: { value: 1, from_source: invented }, station_type: PROBE }
variants: [one, two]
timing: { reaction: 100ms, start: 10s, power_up: 10s, save: 5s }
constants: { steps: { one: 4096, two: 8192 } }
words: { switch: { disabled: 0, enabled: 1 } }
derived: { circle: if scaling == enabled then range else steps }
signals:
  STW: { from: controller, width: 16, fields: { park: 14, life: { bits: [12, 15], counts: [1, 15] }, mode: { bit: 0, words: switch } } }
  ZSW: { from: device, width: 16, fields: { parked: 14, error: 15 } }
  POS: { from: device, width: 32, position_in: circle }
  SPD: { from: device, width: 16, signed: true }
submodules:
  dap: { slot: 0, subslot: 1, ident: 1 }
  pap: { slot: 1, subslot: 1, api: 0x3D00, ident: 2 }
  long: { slot: 1, subslot: 2, ident: 81, octets: { out: 2, in: 8 }, outputs: [STW], inputs: [ZSW, POS, SPD] }
  short: { slot: 1, subslot: 2, ident: 82, octets: { out: 2, in: 4 }, outputs: [STW], inputs: [SPD, ZSW] }
modules:
  long: { ident: 1, submodules: [pap, long] }
  short: { ident: 1, submodules: [pap, short] }
records:
  bf00: { index: 0xBF00, at: pap, octets: 5, start: true, fields: { scaling: { octet: 0, bit: 3, words: switch, default: disabled }, range: { octets: [1, 4], default: =steps } } }
  only_long: { index: 0xB02E, at: pap, octets: 2, start: true, with: [long], fields: { level: { octets: [0, 1], default: 7 } } }
  longer: { index: 0xBF00, at: pap, octets: 8, fields: { scaling_in_use: { octet: 0, bit: 3, words: switch }, state: { octets: [4, 7] } } }
parameters:
  P922: { type: u16, access: read }
  P971: { type: u16, access: read_write, permanent: true }
  P1000: { type: u32, access: read, elements: { faults: 2 }, bits: { faults: { memory: 5 } } }
codes: { channel_error: { memory: 0x9000 } }
stand: { faults: { memory: it cannot be read }, leds: { bus: [dark, red] } }
roles: { position: [POS] }
pages: { home: { path: '/' }, state: { path: '/state', fields: { value: v }, shows: { level: { behind: Level, form: decimal } } } }
";

const PROCEDURES: &str = "\
procedures:
  leave:
    takes: [bit]
    steps:
      - set: { STW.park: =bit }
";

const REQUIREMENTS: &str = "\
requirements:
  - { id: PRB-1, cites: p. 1, statement: One., level: must, source: manual, channel: cyclic }
  - { id: PRB-2, cites: p. 2, statement: Two., level: should, source: manual, channel: cyclic, variants: [one] }
";

const BUGS: &str = "\
bugs:
  stuck:
    why: It never parks.
    breaks: [PRB-1]
";

const TOPIC: &str = "\
suite: topic
defaults: { start: { module: long } }
cases:
  - id: first
    why: It parks.
    covers: [PRB-1]
    catches: [stuck]
    with:
      - { row: on, value: 1, word: enabled }
      - { row: off, value: 0, word: disabled }
    given:
      - set: { STW.life: held }
    steps:
      - save: { before: POS }
      - set: { STW.park: =value, STW.mode: =word }
      - expect: { ZSW.parked: =value, POS: = before + value +/- 1 }
        within: 50 cycles
        for: =timing.save
      - read: { P922: 81, P1000.faults.memory: 0 }
      - do: leave
        give: { bit: 0 }
      - exchange: [ { set: { STW.life: counting }, times: 3 } ]
      - write: { P971: 1 }
        answer: { refused: limit }
  - id: second
    why: Only on one.
    covers: [PRB-2]
    variants: [one]
    start: none
    steps:
      - connect: { module: short, scaling: enabled, range: 100 }
        answer: { bf00: accepted, connection: data }
      - expect: { led.bus: dark, alarm.error: { not: memory } }
      - send: { http_get: { page: home } }
      - send: { http_post: { page: state, fields: { value: '1' } } }
        answer: { status: 200, contains: 'Level', lacks: ['error'] }
      - read: { page.level: 3 }
      - observe: [ { count: rises(ZSW.parked), is: 1 } ]
        steps:
          - wait: 20ms
rules:
  - id: never-both
    why: They exclude each other.
    covers: [PRB-1]
    always: not (ZSW.parked and ZSW.error)
  - id: parks
    why: It follows.
    covers: [PRB-1]
    when: rises(STW.park) and scaling == disabled
    then: ZSW.parked
    within: 200ms
";

const COMMON: &str = "\
common: shared
why: For all.
takes:
  asked: { is: parameter, why: any }
  right: { is: number, why: what it reads }
cases:
  - id: reads
    why: It reads.
    steps:
      - read: { =asked: =right }
  - id: reads-again
    why: It reads twice.
    steps:
      - read: { =asked: =right }
      - read: { =asked: =right }
";

const USES: &str = "\
suite: shared
use: shared
defaults: { start: { module: long } }
give: { asked: P922, right: 81 }
covers: { reads: [PRB-1] }
omit: { reads-again: once is enough }
";

/// The bugs of another manual.
const FOREIGN: &str = "bugs: { foreign: { why: It is of another manual., breaks: [OTH-1] } }\n";

const FILES: [(&str, &str); 10] = [
    ("probe/device.yaml", DEVICE),
    ("probe/procedures.yaml", PROCEDURES),
    ("probe/requirements.yaml", REQUIREMENTS),
    ("probe/bugs.yaml", BUGS),
    ("probe/topic.yaml", TOPIC),
    ("probe/shared.yaml", USES),
    ("common/shared.yaml", COMMON),
    ("probe/wide.yaml", USES_WIDE),
    ("common/wide.yaml", WIDE),
    ("other/bugs.yaml", FOREIGN),
];

/// A common suite with all that a manual can say of one.
const WIDE: &str = "\
common: wide
why: For all, and more.
takes:
  asked: { is: parameter, why: any }
  seen: { is: name, why: an input of one bit }
  octets: { is: bytes, why: outputs }
  time: { is: span, why: how long }
  wrong: { is: words, why: refusals }
  settings: { is: values, why: how it starts }
  premise: { is: condition, why: of the rule }
  checked: { is: requirements, why: those of the second check }
  spare: { is: text, why: a name }
  right: { is: any, why: what it reads }
cases:
  - id: table
    why: The manual gives the rows.
    catches: [stuck, foreign]
    with: { value: { is: number, why: one }, word: { is: word, why: other } }
    start: =settings
    steps:
      - set: { STW.park: =value, STW.mode: =word }
      - expect: { =seen: =value }
        within: =time
      - read: { =asked: =right }
        covers: =checked
  - id: more
    why: The manual adds rows.
    catches: [foreign]
    with: [ { row: usual, number: 1 } ]
    steps:
      - set: { io.outputs: =octets }
      - write: { P971: =number }
        answer: { refused: =wrong }
      - read: { =asked: =right }
  - id: left
    why: The manual leaves it out.
    steps:
      - read: { station.name: =spare }
rules:
  - id: follows
    why: It follows.
    when: =premise
    then: ZSW.parked
    within: 200ms
";

const USES_WIDE: &str = "\
suite: wide
use: wide
defaults: { start: { module: long } }
give: { asked: P922, seen: ZSW.parked, octets: \"40 00\", time: 20ms, wrong: [limit, read_only], settings: { scaling: enabled, range: 100 }, premise: rises(STW.park) and not ZSW.error, checked: [PRB-1], right: { one: 81, two: 82 } }
covers: { more: [PRB-1], follows: [PRB-1] }
omit: { left: not here }
variants: { more: [two] }
rows:
  table:
    - { value: 1, word: enabled, covers: [PRB-1] }
    - { row: only, value: 0, word: disabled, covers: [PRB-2], variants: [one] }
  more: [ { row: unusual, number: 2 } ]
catches: { more: [stuck] }
cases:
  - id: own
    why: The manual has it alone.
    covers: [PRB-1]
    with: [ { asked: 1 } ]
    steps:
      - set: { STW.park: =asked }
      - read: { P922: 81 }
rules:
  - id: own-rule
    why: The manual has it alone.
    covers: [PRB-1]
    always: not (ZSW.parked and ZSW.error)
";

fn sources() -> Sources {
    FILES.iter().fold(Sources::none(), |sources, (path, text)| sources.with(path, *text))
}

/// Loads the manual with `old` replaced by `new` in one file, at its first place.
fn changed(path: &str, old: &str, new: &str) -> Result<(), LoadErrors> {
    let text = FILES.iter().find(|(known, _)| *known == path).map_or("", |(_, text)| text);
    assert!(text.contains(old), "{path} has {old:?}");
    load(&sources().with(path, text.replacen(old, new, 1)), None).map(|_| ())
}

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
// tables, procedures, common suites
#[case("probe/topic.yaml", "STW.mode: =word", "STW.mode: enabled", "enabled", "the column `word` is never used")]
#[case(
    "probe/topic.yaml",
    "value: 0, word: disabled",
    "value: 0",
    "{ row: off",
    "this row has other columns than the first"
)]
#[case("probe/topic.yaml", "row: off", "row: on", "{ row: on, value: 0", "two rows are called `on`")]
#[case(
    "probe/topic.yaml",
    "row: off, value: 0, word: disabled",
    "row: off, value: 1, word: enabled",
    "{ row: off",
    "this trial is the same as `topic/first[on]`"
)]
#[case("probe/topic.yaml", "value: 1", "POS: 1", "POS: 1", "`POS` is a name of the device")]
#[case("probe/topic.yaml", "id: second", "id: first", "first", "duplicate id `first`")]
#[case("probe/topic.yaml", "give: { bit: 0 }", "give: { bti: 0 }", "bti", "unknown entry of give `bti`")]
#[case("probe/topic.yaml", "        give: { bit: 0 }\n", "", "leave", "`leave` has to be given `bit`")]
#[case("probe/procedures.yaml", "=bit", "1", "takes: [bit", "`bit` is taken and never used")]
#[case(
    "common/shared.yaml",
    "takes:",
    "takes:\n  more: { is: word, why: none }",
    "{",
    "`more` is taken and never used"
)]
#[case(
    "probe/shared.yaml",
    "give: { asked: P922, right: 81 }",
    "give: { asked: P922 }",
    "shared",
    "has to be given `right`"
)]
#[case("probe/shared.yaml", "asked: P922", "asekd: P922", "asekd", "unknown entry of give `asekd`")]
#[case("probe/shared.yaml", "asked: P922", "asked: Q922", "Q922", "is not what the common suite takes here")]
#[case("probe/shared.yaml", "use: shared", "use: sharde", "sharde", "unknown common suite `sharde`")]
#[case(
    "probe/shared.yaml",
    "omit: { reads-again: once is enough }",
    "omit: {}",
    "shared",
    "`reads-again` is neither in `covers` nor in `omit`"
)]
#[case("probe/shared.yaml", "reads: [PRB-1]", "read: [PRB-1]", "read:", "unknown case of the common suite `read`")]
#[case(
    "probe/shared.yaml",
    "give: { asked: P922",
    "give: { more: 1, asked: P922",
    "more: 1",
    "unknown entry of give `more`"
)]
#[case("common/shared.yaml", "is: number", "is: numbr", "numbr", "unknown word for is `numbr`")]
#[case(
    "probe/wide.yaml",
    "seen: ZSW.parked",
    "seen: ZSW..parked",
    "ZSW..",
    "`ZSW..parked` is not what the common suite takes here"
)]
#[case("probe/wide.yaml", "seen: ZSW.parked", "seen: ZSW.praked", "ZSW.praked", "unknown field `praked` of ZSW")]
#[case("probe/wide.yaml", "octets: \"40 00\"", "octets: 40", "40", "`40` is not what the common suite takes here")]
#[case("probe/wide.yaml", "time: 20ms", "time: 20", "20", "`20` is not what the common suite takes here")]
#[case(
    "probe/wide.yaml",
    "wrong: [limit, read_only]",
    "wrong: limit",
    "limit",
    "`limit` is not what the common suite takes here"
)]
#[case(
    "probe/wide.yaml",
    "wrong: [limit, read_only]",
    "wrong: [limit, read_onyl]",
    "read_onyl",
    "unknown code `read_onyl`"
)]
#[case(
    "probe/wide.yaml",
    "settings: { scaling: enabled, range: 100 }",
    "settings: [scaling]",
    "[scaling]",
    "a list is not what the common suite takes here"
)]
#[case(
    "probe/wide.yaml",
    "scaling: enabled, range",
    "scailng: enabled, range",
    "scailng",
    "unknown start parameter `scailng`"
)]
#[case("probe/wide.yaml", "rises(STW.park) and", "rises(STW.prak) and", "STW.prak", "prak")]
#[case(
    "probe/wide.yaml",
    "checked: [PRB-1]",
    "checked: PRB-1",
    "PRB-1",
    "`PRB-1` is not what the common suite takes here"
)]
#[case("probe/wide.yaml", "checked: [PRB-1]", "checked: [PRB-7]", "PRB-7", "unknown requirement `PRB-7`")]
#[case("probe/wide.yaml", "{ one: 81, two: 82 }", "{ one: 81 }", "{ one", "there is no value for the variant `two`")]
#[case("probe/wide.yaml", "{ one: 81, two: 82 }", "{ one: 81, tow: 82 }", "tow", "unknown variant `tow`")]
#[case("probe/wide.yaml", "{ one: 81, two: 82 }", "{ one: 81, two: 65536 }", "65536", "65536 is out of range")]
#[case("probe/wide.yaml", "give: {", "give: { spare: 'x', ", "spare", "`spare` is given and never used")]
#[case(
    "probe/wide.yaml",
    "omit: { left: not here }",
    "omit: {}",
    "wide",
    "`left` is neither in `covers` nor in `omit`"
)]
#[case(
    "probe/wide.yaml",
    "omit: { left: not here }",
    "omit: { left: not here, table: no }",
    "no",
    "`table` is spoken of and left out"
)]
#[case("probe/wide.yaml", "variants: { more: [two] }", "variants: { more: [tow] }", "tow", "unknown variant `tow`")]
#[case("probe/wide.yaml", "variants: { more", "variants: { moer", "moer", "unknown case of the common suite `moer`")]
#[case("probe/wide.yaml", "more: [ { row", "moer: [ { row", "moer", "unknown case of the common suite `moer`")]
#[case(
    "probe/wide.yaml",
    "more: [ { row: unusual, number: 2 } ]",
    "follows: [ { number: 2 } ]",
    "follows",
    "`follows` has no table"
)]
#[case("probe/wide.yaml", "number: 2", "numbre: 2", "{ row: unusual", "this row has other columns than the first")]
#[case("probe/wide.yaml", "{ value: 1, word", "{ vlaue: 1, word", "vlaue", "unknown column `vlaue`")]
#[case("probe/wide.yaml", "{ value: 1, word: enabled", "{ value: 1", "{ value: 1", "this row has no `word`")]
#[case("probe/wide.yaml", "{ value: 1", "{ value: one", "one", "`one` is not what the common suite takes here")]
#[case("probe/wide.yaml", "word: enabled", "word: enabeld", "enabeld", "`enabeld` is no word of `switch`")]
#[case(
    "probe/wide.yaml",
    "covers: [PRB-2], variants: [one]",
    "covers: [PRB-2]",
    "PRB-2",
    "PRB-2 does not apply to the variant two"
)]
#[case(
    "probe/wide.yaml",
    "  table:\n    - { value: 1, word: enabled, covers: [PRB-1] }\n    - { row: only, value: 0, word: disabled, covers: [PRB-2], variants: [one] }\n",
    "",
    "wide",
    "`table` is neither in `covers` nor in `omit`"
)]
#[case(
    "probe/wide.yaml",
    "covers: { more: [PRB-1], follows: [PRB-1] }",
    "covers: { more: [], follows: [PRB-1] }",
    "more: []",
    "`wide/more[usual]` covers nothing"
)]
#[case("probe/wide.yaml", "catches: { more: [stuck] }", "", "more: [PRB", "no bug of this manual makes `more` fail")]
#[case(
    "probe/wide.yaml",
    "catches: { more: [stuck] }",
    "catches: { more: [stuck], table: [stuck] }",
    "stuck] }",
    "names `stuck` already"
)]
#[case(
    "probe/wide.yaml",
    "catches: { more: [stuck] }",
    "catches: { more: [foreign] }",
    "foreign",
    "unknown bug `foreign`"
)]
#[case(
    "common/wide.yaml",
    "catches: [stuck, foreign]",
    "catches: [stuck, foriegn]",
    "foriegn",
    "unknown bug `foriegn`"
)]
#[case("probe/topic.yaml", "catches: [stuck]", "catches: [stuck, foreign]", "foreign", "unknown bug `foreign`")]
#[case("probe/wide.yaml", "id: own\n", "id: table\n", "table", "`table` is a case or rule of the common suite")]
#[case("probe/wide.yaml", "id: own\n", "id: left\n", "left", "`left` is a case or rule of the common suite")]
#[case("probe/wide.yaml", "id: own-rule\n", "id: own\n", "own", "duplicate id `own`")]
#[case("probe/wide.yaml", "P922: 81", "P922: =right", "right", "there is no name `right`")]
#[case(
    "probe/topic.yaml",
    "    with:\n      - { row: on, value: 1, word: enabled }\n      - { row: off, value: 0, word: disabled }\n",
    "    with: { value: { is: number, why: one } }\n",
    "{ value",
    "a table is a list of rows here"
)]
#[case("common/wide.yaml", "word: { is: word", "word: { is: wrod", "wrod", "unknown word for is `wrod`")]
#[case("common/wide.yaml", "why: one }", "wyh: one }", "wyh", "unknown key of an entry of takes `wyh`")]
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
// records of the start-up that some modules have
#[case(
    "probe/device.yaml",
    "start: true, fields",
    "start: true, with: [lnog], fields",
    "lnog",
    "unknown module `lnog`"
)]
#[case(
    "probe/device.yaml",
    "start: true, fields",
    "with: [long], fields",
    "[long]",
    "only a record of the start-up goes `with` modules"
)]
#[case(
    "probe/topic.yaml",
    "module: short, scaling",
    "module: short, level: 1, scaling",
    "level: 1",
    "the record `only_long` is not sent with the module `short`"
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
// device.yaml
#[case("probe/device.yaml", "device: probe", "device: prob", "prob", "this is the folder `probe`")]
#[case("probe/device.yaml", "bus: profinet", "bus: profibus", "profibus", "PROFIBUS suites are not loaded")]
#[case("probe/device.yaml", "octets: { out: 2, in: 8 }", "octets: { out: 2, in: 6 }", "{", "the inputs have 8 octets")]
#[case("probe/device.yaml", "inputs: [ZSW, POS, SPD]", "inputs: [ZSW, POZ, SPD]", "POZ", "unknown signal `POZ`")]
#[case("probe/device.yaml", "outputs: [STW]", "outputs: [ZSW]", "ZSW", "`ZSW` goes the other way")]
#[case("probe/device.yaml", "submodules: [pap, long]", "submodules: [pap, lng]", "lng", "unknown submodule `lng`")]
#[case("probe/device.yaml", "park: 14", "park: 16", "16", "bit 16 is beyond the 16 bits")]
#[case("probe/device.yaml", "{ octets: [1, 4]", "{ octets: [1, 5]", "{", "octet 5 is beyond the 5 octets")]
#[case("probe/device.yaml", "default: =steps", "default: =setps", "setps", "there is no name `setps`")]
#[case("probe/device.yaml", "default: disabled", "default: disable", "disable", "`disable` is no word of `switch`")]
#[case(
    "probe/device.yaml",
    "{ one: 4096, two: 8192 }",
    "{ one: 4096 }",
    "{",
    "there is no value for the variant `two`"
)]
#[case("probe/device.yaml", "signed: true", "signed: yes", "yes", "`signed` is `true` or left out")]
#[case("probe/device.yaml", "then range else", "then rnage else", "rnage else steps", "there is no name `rnage`")]
#[case("probe/device.yaml", "position_in: circle", "position_in: cirle", "cirle", "there is no name `cirle`")]
#[case(
    "probe/device.yaml",
    "from_source: invented",
    "from_source: invnted",
    "invnted",
    "unknown word for from_source `invnted`"
)]
#[case("probe/device.yaml", "position: [POS]", "position: [PSO]", "PSO", "unknown signal `PSO`")]
#[case("probe/device.yaml", "type: u16", "type: u17", "u17", "unknown word for type `u17`")]
#[case("probe/device.yaml", "constants: { steps", "constants: { POS", "POS: {", "`POS` is a name already")]
#[case("probe/device.yaml", "range: { octets", "shaft: { octets", "shaft: {", "`shaft` is a name already")]
// the lists
#[case("probe/requirements.yaml", "level: should", "level: shuold", "shuold", "unknown variant `shuold`")]
#[case(
    "probe/requirements.yaml",
    "source: manual,",
    "source: profile,",
    "PRB-1",
    "only what the manual says without ambiguity is `must`"
)]
#[case("probe/requirements.yaml", "id: PRB-2", "id: PRB-1", "PRB-1", "duplicate id `PRB-1`")]
#[case("probe/bugs.yaml", "breaks: [PRB-1]", "breaks: [PRB-9]", "PRB-9", "unknown requirement `PRB-9`")]
#[case(
    "probe/bugs.yaml",
    "  stuck:",
    "  lazy: { why: It is., breaks: [PRB-1] }\n  stuck:",
    "lazy:",
    "no case catches the bug `lazy`"
)]
fn refused(#[case] path: &str, #[case] old: &str, #[case] new: &str, #[case] points_at: &str, #[case] message: &str) {
    let errors = changed(path, old, new).expect_err("the change is a mistake");
    let first = &errors.0[0];
    let at: String = first.line.chars().skip(first.at.column as usize - 1).collect();
    let good = first.at.file.ends_with(path) && at.starts_with(points_at) && first.message.contains(message);
    assert!(good, "wanted {path}: {message}, at {points_at}\n{errors}");
}

/// A record may be part of the start-up of some modules only, two may go to one submodule, and one index may be written with
/// one layout and read with another.
#[test]
fn records_of_the_start_up() {
    let topic = TOPIC.replacen("connect: { module: short, scaling", "connect: { module: long, level: 3, scaling", 1);
    let topic =
        topic.replacen("- read: { page.level: 3 }", "- read: { longer.scaling_in_use: enabled, longer.state: 1 }", 1);
    let manuals = load(&sources().with("probe/topic.yaml", topic), None).unwrap_or_else(|errors| panic!("{errors}"));
    let device = &manuals[0].device;
    let fields = |start: &encspec::suite::model::Start| -> Vec<(String, i128)> {
        let field =
            |of: &encspec::suite::model::StartParameter| device.records[of.record].fields[of.field].name.clone();
        start.parameters.iter().map(|of| (field(of), of.value)).collect()
    };
    let trials = &manuals[0].variants[0].trials;
    let first = trials.iter().find(|trial| trial.id == "topic/first[on]").and_then(|trial| trial.start.as_ref());
    let wanted = [("scaling".to_owned(), 0), ("range".to_owned(), 4096), ("level".to_owned(), 7)];
    assert_eq!(fields(first.expect("it connects")), wanted);
    let short = load(&sources(), None).expect("it loads");
    let second = short[0].variants[0].trials.iter().find(|trial| trial.id == "topic/second").expect("it is there");
    let Some(encspec::suite::model::Verb::Connect { start, .. }) = second.steps.first().map(|step| &step.verb) else {
        panic!("it connects first")
    };
    assert_eq!(
        fields(start),
        wanted[..2].iter().map(|(name, value)| (name.clone(), if *value == 0 { 1 } else { 100 })).collect::<Vec<_>>()
    );
}

#[test]
fn a_manual_says_which_rows_and_variants_it_has_of_a_common_case() {
    let manuals = load(&sources(), None).expect("it loads");
    let ids = |variant: usize| -> Vec<&str> {
        let trials = &manuals[0].variants[variant].trials;
        trials.iter().filter_map(|trial| trial.id.strip_prefix("wide/")).collect()
    };
    assert_eq!(ids(0), ["table[1]", "table[only]", "own[1]"]);
    assert_eq!(ids(1), ["table[1]", "more[usual]", "more[unusual]", "own[1]"]);
    let trials = &manuals[0].variants[1].trials;
    let more = trials.iter().find(|trial| trial.id == "wide/more[unusual]").expect("it is there");
    assert_eq!((more.covers.as_slice(), more.catches.as_slice()), (&[0][..], &["stuck".to_owned()][..]));
    let rules: Vec<&str> = manuals[0].variants[0].rules.iter().map(|rule| rule.id.as_str()).collect();
    assert_eq!(rules, ["topic/never-both", "topic/parks", "wide/follows", "wide/own-rule"]);
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
