//! A small manual of a slave on PROFIBUS that loads, with each thing in it that only PROFIBUS has.

/// What the device is.
pub const DEVICE: &str = "\
device: slave
bus: profibus
title: A slave
identity: { ident: { value: 0x0C0A, from_source: invented } }
address: 5
variants: [one, two]
timing: { reaction: 100ms, start: 5s, power_up: 5s, save: 2s }
constants: { steps: { one: 4096, two: 8192 } }
words: { switch: { disabled: 0, enabled: 1 }, kind: { single: 0, multi: 1 } }
derived: { circle: if scaling == enabled then range else steps }
signals:
  preset: { from: controller, width: 32, fields: { value: { bits: [0, 30] }, trigger: 31 } }
  place: { from: device, width: 32, position_in: circle }
  speed: { from: device, width: 32, signed: true }
modules:
  short: { cfg: \"D1 E1\", octets: { out: 4, in: 4 }, outputs: [preset], inputs: [place], fixes: { with_speed: disabled } }
  long: { cfg: \"D3 E1\", octets: { out: 4, in: 8 }, outputs: [preset], inputs: [place, speed], fixes: { with_speed: enabled }, from_source: invented }
set_prm:
  octets: 5
  dpv1: \"80 00 00\"
  structured: true
  fields: { scaling: { octet: 0, bit: 3, words: switch, default: disabled }, with_speed: { octet: 0, bit: 7, words: switch, default: disabled }, range: { octets: [1, 4], default: =steps } }
diagnosis:
  octets: [6, 24]
  fields: { kind_of: { byte: 9, words: kind }, offset: { bytes: [10, 13], signed: true }, serial: { bytes: [14, 23] } }
  blocks: { after: 6, bytes: \"81 40 ..\", code: diagnosis_error }
parameters: { P965: { type: u16, access: read }, P65000: { type: u32, access: read_write, default: 0, permanent: true } }
parameter_access: { slot: 1 }
codes: { diagnosis_error: { memory: 0x38, amplitude: 0x36 } }
stand: { faults: { memory: it cannot be read }, switches: { address: [0, 127, 5] }, leds: { bus: [dark, red] } }
roles: { position: [place] }
";

/// Its requirements.
pub const REQUIREMENTS: &str = "\
requirements:
  - { id: SLV-1, cites: p. 1, statement: One., level: must, source: manual, channel: diagnosis }
";

/// Its cases and rules.
pub const TOPIC: &str = "\
suite: topic
defaults: { start: { module: short } }
cases:
  - id: diagnosis
    why: Each error has its block.
    covers: [SLV-1]
    start: { watchdog: 100ms, range: 100 }
    steps:
      - set: { fault.memory: present }
      - read: { diag.length: 9, diag.errors: [memory], diag.ext_diag: 1, diag.kind_of: multi, diag.offset: -1 }
        within: 2s
      - read: { diag.bytes: \"* 81 40 38\", diag.serial: \"30 31 *\" }
      - expect: { diag.errors: [memory], led.bus: red }
      - read: { cfg.bytes: \"D1 E1\" }
      - read: { station.address: =bench.station }
  - id: configuration
    why: Identifiers that no module has are refused.
    covers: [SLV-1]
    start: none
    with:
      - { row: bytes, cfg: \"F0\" }
      - { row: nothing, cfg: \"\" }
    steps:
      - connect: { module: short, instead: { chk_cfg: =cfg } }
        answer: { set_prm: accepted, chk_cfg: any, diag.cfg_fault: 1, diag.bytes: \"06 *\", connection: none }
      - connect: { module: long, scaling: enabled, instead: { ident: 0x1656, lock: both, freeze_req: 1, sync_req: 1, min_tsdr: 11, groups: 1, watchdog_factors: [20, 0], output_length: 3, input_length: 4 } }
        answer: { set_prm: { refused: no_service }, connection: none }
      - connect: { module: short, watchdog: none, baud: 500000, instead: { set_prm: \"88 14 05 0B 0C 0A 00\", dpv1: \"00 00 00\" } }
        answer: { diag.prm_fault: 1 }
  - id: cycles
    why: Each answer is looked at.
    covers: [SLV-1]
    start: { isochronous: 1ms }
    steps:
      - set: { io.global_control: stopped, io.clock_offset: 20us, io.cyclic: running }
      - exchange:
          - { set: { preset.trigger: 1 }, expect: { place: 0x1000 }, times: 3 }
      - observe: [ { count: rises(io.diagnosis_pending), is: 1 } ]
        steps:
          - wait: 20ms
  - id: services
    why: Each service is answered.
    covers: [SLV-1]
    start: none
    steps:
      - send: { set_slave_address: { new: =bench.free_station, ident: 0x0C0A, lock: 0, length: 3 } }
        to: 126
        answer: { refused: [no_service, no_resource] }
      - send: { global_control: { clear: 1, sync: 1, group: 0x80 } }
      - send: { fdl_status: {} }
        to: 126
        answer: none
      - send: { set_prm: { bytes: \"88 14 05 0B 0C 0A 00\" } }
      - send: { data_exchange: { bytes: \"00 00 00 00\" } }
        answer: { bytes: \"00 00 10 00\" }
      - send: { ds_read: { slot: 0, index: 255, length: 240 } }
        answer: { refused: invalid_index }
      - send: { ds_write: { slot: 0, index: 47, bytes: \"01\" } }
        answer: any
      - send: { broken: { frame: checksum } }
        answer: none
      - read: { diag.master_lock: 1, diag.master: =bench.address }
        as: second
      - read: { P965: 0x3D29 }
        instead: { slot: 3 }
      - write: { P65000: 1 }
        answer: { refused: limit }
        instead: { index: 48 }
rules:
  - id: fixed-bit
    why: It is always one.
    covers: [SLV-1]
    always: diag.fixed_one
  - id: place-in-range
    why: It lies in its range.
    covers: [SLV-1]
    always: place < circle
";

/// All files, by their paths.
pub const FILES: [(&str, &str); 3] =
    [("slave/device.yaml", DEVICE), ("slave/requirements.yaml", REQUIREMENTS), ("slave/topic.yaml", TOPIC)];
