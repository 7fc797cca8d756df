//! Every bug of the encoder can be seen: it changes what it does in a walk through all that it can do.

#[path = "../../../../reference-devices/src/models/lika_xac77/tests/bench.rs"]
#[allow(dead_code, reason = "the tests of the model use the rest")]
mod bench;
mod starts;
mod turns;
mod web;

use self::bench::*;
use crate::subject;
use crate::tables;
use alloc::vec::Vec;
use device_stack::profinet::{Access, Application, ResetScope, StationData};
use reference_devices::behaviour::Behaviour;
use reference_devices::models::lika_xac77::FACTS;
use station::StandAction;

/// Bugs that no walk without a stack can meet, beside those of the table of the stack.
const BUGS_OF_THE_STACK: &[&str] =
    &["diagnosis-as-manufacturer-data", "alarms-block-inputs", "diagnosis-record-empty", "web-at-fixed-address"];

/// What was seen on a walk, in order.
#[derive(Default)]
struct Walk {
    seen: Vec<u64>,
}

impl Walk {
    fn frames(&mut self, bench: &mut Bench, g1_stw: u16, count: usize) {
        bench.g1_stw = g1_stw;
        for _ in 0..count {
            bench.now += CYCLE;
            let stw2_enc = bench.stw2_enc | u16::from(bench.sign_of_life) << 12;
            let outputs = [stw2_enc.to_be_bytes(), g1_stw.to_be_bytes()].concat();
            if bench.sign_of_life != 0 {
                bench.sign_of_life = bench.sign_of_life % 15 + 1;
            }
            bench.encoder.outputs(bench.now, 1, 2, Some(&outputs));
            let mut inputs = alloc::vec![0; bench.telegram.input_octets.into()];
            bench.encoder.frame(bench.now);
            self.seen.push(bench.encoder.inputs(bench.now, 1, 2, &mut inputs).into());
            self.seen.extend(inputs.iter().map(|octet| u64::from(*octet)));
        }
        self.diagnoses(bench);
    }

    fn diagnoses(&mut self, bench: &mut Bench) {
        while let Some(change) = bench.encoder.next_diagnosis() {
            let diagnosis = change.diagnosis;
            self.seen.extend([change.appears.into(), diagnosis.error_type.into(), diagnosis.severity as u64]);
        }
    }

    fn request(&mut self, bench: &mut Bench, octets: &[u8]) {
        let written = bench.encoder.write_record(bench.now, access(0xB02E), octets);
        self.seen.push(written.map_or_else(|refusal| refusal.code1().into(), |()| 0));
        for _ in 0..2 {
            let mut answer = Vec::new();
            let read = bench.encoder.read_record(bench.now, access(0xB02E), &mut answer);
            self.seen.push(read.map_or_else(|refusal| refusal.code1().into(), |()| 0));
            self.seen.extend(answer.iter().map(|octet| u64::from(*octet)));
        }
    }

    fn write(&mut self, bench: &mut Bench, preset_value: u32) {
        let [a, b, c, d] = preset_value.to_be_bytes();
        self.request(bench, &[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x43, 1, a, b, c, d]);
    }

    fn parameters(&mut self, bench: &mut Bench) {
        for number in [922, 964, 965, 971, 975, 979, 980, 61001, 65000, 65001_u16] {
            let count = match number {
                964 | 979 => 6,
                975 => 8,
                980 => 9,
                65001 => 12,
                _ => 0,
            };
            let [high, low] = number.to_be_bytes();
            self.request(bench, &[1, 1, 1, 1, 0x10, count, high, low, 0, 0]);
        }
    }
}

fn handshakes(walk: &mut Walk, bench: &mut Bench) {
    walk.write(bench, 0x1000);
    let presets = [0, RELATIVE, 0, HOME, HOME | RELATIVE, ABSOLUTE, HOME, 0, HOME | RELATIVE, 0];
    let others = [HOME | RELATIVE | ABSOLUTE, ABSOLUTE, ABSOLUTE | ACKNOWLEDGE, 0x0400, 0];
    for word in presets.into_iter().chain(others) {
        walk.frames(bench, word, 30);
        walk.parameters(bench);
    }
    walk.frames(bench, HOME, 30);
    walk.frames(bench, 0, 1);
    walk.write(bench, 0);
    walk.frames(bench, HOME, 30);
    for word in [PARK | HOME | ABSOLUTE, PARK | ABSOLUTE, PARK | ABSOLUTE | HOME, ABSOLUTE] {
        walk.frames(bench, word, 30);
    }
    bench.act(StandAction::ShaftSpeed(-600.0));
    walk.frames(bench, PARK, 120);
    bench.stw2_enc = CONTROL | 0x0080;
    walk.frames(bench, 0, 3);
    bench.stw2_enc = CONTROL;
    for word in [0, ACKNOWLEDGE, 0] {
        walk.frames(bench, word, 3);
    }
    bench.act(StandAction::ShaftSpeed(0.0));
    walk.frames(bench, 0, 3);
    for (word, without_function) in [(ABSOLUTE | 1, 0), (ABSOLUTE, 1), (ABSOLUTE | PARK, 0)] {
        bench.stw2_enc = CONTROL | without_function;
        walk.frames(bench, word, 30);
        bench.stw2_enc = 0;
        walk.frames(bench, word, 3);
    }
    bench.stw2_enc = CONTROL;
    walk.frames(bench, 0, 3);
    bench.sign_of_life = 0;
    for word in [PARK, 0] {
        walk.frames(bench, word, 6);
    }
    bench.sign_of_life = 1;
    for word in [PARK, 0] {
        walk.frames(bench, word, 3);
    }
}

fn faults(walk: &mut Walk, bench: &mut Bench) {
    walk.frames(bench, ABSOLUTE, 3);
    bench.fault("memory", true);
    for word in [ABSOLUTE, ABSOLUTE | ACKNOWLEDGE, ABSOLUTE, HOME, 0, PARK, 0] {
        walk.frames(bench, word, 30);
        walk.parameters(bench);
    }
    walk.frames(bench, PARK, 3);
    bench.fault("sensor", true);
    bench.fault("commissioning", true);
    walk.frames(bench, PARK, 3);
    bench.fault("sensor", false);
    walk.frames(bench, 0, 3);
    bench.fault("memory", false);
    bench.fault("commissioning", false);
    for word in [0, ABSOLUTE | ACKNOWLEDGE, ABSOLUTE, 0] {
        walk.frames(bench, word, 3);
        walk.parameters(bench);
    }
}

fn life_signs(walk: &mut Walk, bench: &mut Bench) {
    for round in 0..2 {
        bench.stw2_enc = if round == 0 { CONTROL } else { 0 };
        walk.frames(bench, ABSOLUTE, 20);
        for failures in [1, 1, 2, 5] {
            for _ in 0..failures {
                bench.sign_of_life = (bench.sign_of_life + 13) % 15 + 1;
                walk.frames(bench, ABSOLUTE, 1);
            }
            walk.frames(bench, ABSOLUTE, 30);
        }
        bench.stw2_enc = CONTROL;
        walk.frames(bench, ACKNOWLEDGE, 3);
        walk.frames(bench, 0, 3);
    }
}

fn requests(walk: &mut Walk, bench: &mut Bench) {
    let too_long = [&[1, 1, 1, 39][..], &[0x10, 12, 0xFD, 0xE9, 0, 0].repeat(39)].concat();
    for request in [
        &[1, 1, 1, 1, 0x10, 0, 0, 1, 0, 0][..],
        &[1, 2, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0, 0x42, 1, 0, 82],
        &[1, 1, 1, 1, 0x10, 1, 0x03, 0xC4, 0, 6],
        &[1, 1, 1, 1, 0x10, 1, 0x03, 0x9A, 0, 1],
        &[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x42, 1, 0, 5],
        &[1, 1, 1, 1, 0x00, 0, 0x03, 0x9A, 0, 0],
        &[1, 1, 5, 1, 0x10, 0, 0x03, 0x9A, 0, 0],
        &[1, 2, 1, 2, 0x10, 0, 0x03, 0x9A, 0, 0, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x42, 1, 0, 82, 0x43, 1, 0, 0, 0, 9],
        &[1, 1, 1],
        &[9, 1, 1, 2, 0x10, 2, 0x03, 0xC4, 0, 1, 0x10, 0, 0x03, 0x9A, 0, 0],
        &[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x07, 1, 0x12, 0x34, 0x56, 0x78],
        &[1, 2, 1, 1, 0x10, 1, 0xFD, 0xE8, 0, 0, 0x43, 2, 0, 0, 0, 5, 0, 0, 0, 6],
        &[1, 2, 1, 1, 0x10, 0, 0x03, 0xCB, 0, 0, 0x42, 1, 0, 2],
        &[1, 2, 1, 1, 0x10, 0, 0x03, 0xCB, 0, 0, 0x42, 1, 0, 1],
        &[1, 1, 1, 2, 0x10, 0, 0x03, 0x9A, 0, 0, 0x10, 0, 0, 1, 0, 0],
        &[1, 2, 1, 1, 0x10, 0, 0xFD, 0xEA, 0, 0, 0x43, 1, 0, 0, 0, 5],
        &[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x3F, 1, 0, 0, 0, 5],
        &[1, 0x7F, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0],
        &too_long,
        &[1, 1, 1, 40, 0x10, 0, 0x03, 0x9A, 0, 0],
        &[0, 1, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0],
    ] {
        walk.request(bench, request);
        walk.parameters(bench);
    }
    bench.wait(500);
    walk.parameters(bench);
}

fn walk(bug: Option<&Behaviour>) -> Vec<u64> {
    let mut walk = Walk::default();
    let default = record(0x22, 65536, 1 << 30);
    let mut records = alloc::vec![default.clone(), default[..30].to_vec()];
    for bits in [0x02, 0x12, 0x26, 0x20, 0x2A, 0x28, 0x23] {
        records.push(record(bits, 4096, 4096 * 16384));
    }
    records.push(record(0x21, 4096, 1 << 24));
    records.push(record(0x2A, 65536, 1 << 30));
    records.push(record(0x2A, 1, 32768));
    records.push(record(0x2A, 1 << 32 | 4096, 1 << 24));
    for (speed_unit, failures) in [(1, 3), (2, 255), (4, 1)] {
        let mut record = record(0x02, 65536, 1 << 30);
        (record[17], record[18]) = (failures, speed_unit);
        records.push(record);
    }
    let mut v41 = record(0x22, 65536, 1 << 30);
    v41[17] = 200;
    records.push(v41);
    for (n, record) in records.iter().enumerate() {
        let mut bench = Bench::alone(MULTITURN, bug, 0x0123_4567);
        walk.seen.push(bench.connect(81, &default).map_or(1, |()| 0));
        walk.seen.push(bench.connect(81 + (n % 4) as u32, record).map_or(1, |()| 0));
        handshakes(&mut walk, &mut bench);
        faults(&mut walk, &mut bench);
        life_signs(&mut walk, &mut bench);
        requests(&mut walk, &mut bench);
        walk.write(&mut bench, 0x77);
        bench.power_cycle();
        walk.parameters(&mut bench);
        bench.fault("memory", true);
        bench.power_cycle();
        walk.diagnoses(&mut bench);
        bench.fault("memory", false);
        bench.power_cycle();
        let ip = [192, 168, 0, 10];
        let station = StationData { name: b"enc-1".to_vec(), ip, mask: [255; 4], gateway: [192, 168, 0, 1] };
        bench.encoder.set_station(bench.now, &station, &station);
        walk.parameters(&mut bench);
        for _ in 0..2 {
            let station = bench.encoder.stored_station();
            walk.seen.extend(station.name.iter().chain(&station.gateway).map(|octet| u64::from(*octet)));
            walk.seen.push(bench.encoder.factory_reset(bench.now, ResetScope::Factory).into());
            walk.parameters(&mut bench);
        }
        let names = [&b"a_b"[..], b"ger\xE4t", b"1a", b"a-", b"a..b", b"enc-1", b""];
        walk.seen.extend(names.map(|name| u64::from(bench.encoder.accepts_name(name))));
    }
    for telegram in 81..=84 {
        let mut bench = Bench::alone(MULTITURN, bug, 884_473_855);
        let class_3 = record(0x20, 65536, 1 << 30);
        walk.seen.extend([&class_3, &default].map(|record| bench.connect(telegram, record).map_or(1, |()| 0)));
        walk.frames(&mut bench, PARK, 3);
        bench.act(StandAction::ShaftSpeed(-600.0));
        walk.frames(&mut bench, PARK, 120);
        walk.frames(&mut bench, ABSOLUTE, 120);
        walk.seen.push(bench.encoder.factory_reset(bench.now, ResetScope::ApplicationData).into());
    }
    let mut bench = Bench::alone(MULTITURN, bug, 1_073_741_823);
    walk.seen.push(bench.connect(81, &record(0x2A, 65536, 442_236_928)).map_or(1, |()| 0));
    for steps in [1.0, 1.0, -1.0, -1.0] {
        bench.act(StandAction::Turn { steps, rpm: 60.0 });
        walk.frames(&mut bench, 0, 1);
    }
    web::walk(&mut walk.seen, bug);
    starts::walk(&mut walk.seen, bug);
    turns::walk(&mut walk.seen, bug);
    walk.seen
}

#[test]
fn every_bug_leaves_a_trace() {
    let subject = subject("lika-xac77-profinet").expect("it is known");
    let healthy = walk(None);
    assert!(healthy == walk(None), "the walk is the same each time");
    let groups = || tables::stack::GROUPS.iter().chain(tables::stack_data::GROUPS).chain(tables::station::GROUPS);
    let of_the_stack = |name: &str| groups().flat_map(|group| group.deviations).any(|bug| bug.name == name);
    let names = subject.bugs().map(|bug| bug.name).filter(|name| !of_the_stack(name));
    let with = |name: &str| walk(Some(&subject.behaviour(&[name]).expect("a bug of its own")));
    let unseen: Vec<&str> = names.filter(|name| with(name) == healthy).collect();
    assert_eq!(unseen, BUGS_OF_THE_STACK);
}
