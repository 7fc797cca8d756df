//! A small manual that loads, with a common suite of each kind, and how to change it in one place.

#![allow(dead_code, reason = "each test file uses its part")]

use encspec::suite::{LoadErrors, Sources, load};

/// What the device is.
pub const DEVICE: &str = "\
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

/// Its procedures.
pub const PROCEDURES: &str = "\
procedures:
  leave:
    takes: [bit]
    steps:
      - set: { STW.park: =bit }
";

/// Its requirements.
pub const REQUIREMENTS: &str = "\
requirements:
  - { id: PRB-1, cites: p. 1, statement: One., level: must, source: manual, channel: cyclic }
  - { id: PRB-2, cites: p. 2, statement: Two., level: should, source: manual, channel: cyclic, variants: [one] }
";

/// Its bugs.
pub const BUGS: &str = "\
bugs:
  stuck:
    why: It never parks.
    breaks: [PRB-1]
";

/// Cases and rules of its own.
pub const TOPIC: &str = "\
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

/// A common suite.
pub const COMMON: &str = "\
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

/// How it uses the common suite.
pub const USES: &str = "\
suite: shared
use: shared
defaults: { start: { module: long } }
give: { asked: P922, right: 81 }
covers: { reads: [PRB-1] }
omit: { reads-again: once is enough }
";

/// The bugs of another manual.
pub const FOREIGN: &str = "bugs: { foreign: { why: It is of another manual., breaks: [OTH-1] } }\n";

/// All files, by their paths.
pub const FILES: [(&str, &str); 10] = [
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
pub const WIDE: &str = "\
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

/// How it uses the wide one.
pub const USES_WIDE: &str = "\
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

/// The small manual.
pub fn sources() -> Sources {
    FILES.iter().fold(Sources::none(), |sources, (path, text)| sources.with(path, *text))
}

/// Loads the manual with `old` replaced by `new` in one file, at its first place.
pub fn changed(path: &str, old: &str, new: &str) -> Result<(), LoadErrors> {
    let text = FILES.iter().find(|(known, _)| *known == path).map_or("", |(_, text)| text);
    assert!(text.contains(old), "{path} has {old:?}");
    load(&sources().with(path, text.replacen(old, new, 1)), None).map(|_| ())
}

/// Checks that the manual with `old` replaced by `new` in one file is refused: the place begins with `points_at`, and the message
/// contains `message`.
pub fn refuses(path: &str, old: &str, new: &str, points_at: &str, message: &str) {
    let errors = changed(path, old, new).expect_err("the change is a mistake");
    let first = &errors.0[0];
    let at: String = first.line.chars().skip(first.at.column as usize - 1).collect();
    let good = first.at.file.ends_with(path) && at.starts_with(points_at) && first.message.contains(message);
    assert!(good, "wanted {path}: {message}, at {points_at}\n{errors}");
}
