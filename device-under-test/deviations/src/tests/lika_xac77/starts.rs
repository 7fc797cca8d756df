//! Starts, power cycles and resets: what is about records and memory.

use super::*;

fn see(seen: &mut Vec<u64>, bench: &mut Bench) {
    for _ in 0..20 {
        let frame = bench.frame();
        seen.extend([frame.zsw2_enc, frame.g1_zsw].map(u64::from));
        seen.extend([frame.xist1, frame.xist2].map(u64::from));
    }
    for (number, count) in [(965, 0), (971, 1), (65000, 1), (65001, 12)] {
        seen.extend(bench.read(number, 0, count).unwrap_or_else(|error| alloc::vec![error.into()]));
    }
    seen.extend(
        bench.diagnoses().iter().map(|(appears, error_type)| u64::from(*appears) << 16 | u64::from(*error_type)),
    );
}

fn records(seen: &mut Vec<u64>, variant: usize, bug: Option<&Behaviour>) {
    let hardware = FACTS.variants[variant].hardware;
    let (steps, range) = (hardware.steps_per_revolution, hardware.range());
    let default = record(0x22, steps, range);
    let changed = |places: &[(usize, u8)]| {
        let mut octets = default.clone();
        places.iter().for_each(|(at, octet)| octets[*at] = *octet);
        octets
    };
    let mut all =
        alloc::vec![default.clone(), record(0xA2, steps, range), record(0x22, 0, 0), record(0x26, 1000, 1000)];
    for (units, range) in [(steps, range), (1000, 1000), (1, 32768), (65537, 65537), (steps + 1, range), (2, 2)] {
        all.push(record(0x2A, units, range));
    }
    all.extend([changed(&[(30, 7)]), changed(&[(18, 3)]), changed(&[(18, 1), (19, 2)]), changed(&[(0, 2), (17, 0)])]);
    for octets in &all {
        let mut bench = Bench::alone(variant, bug, 0x1234);
        seen.push(bench.connect(81, octets).map_or(1, |()| 0));
        bench.act(StandAction::Turn { steps: 100.0, rpm: 60.0 });
        see(seen, &mut bench);
    }
    let mut bench = Bench::alone(variant, bug, 0x1234);
    let telegram = bench.telegram;
    bench.encoder.started(bench.now, AR, &[telegram]);
    seen.push(bench.encoder.parameter_end(bench.now, AR).as_nanos());
    see(seen, &mut bench);
    bench.sign_of_life = 1;
    for failures in [1, 2] {
        bench.set(0);
        (0..failures).for_each(|_| {
            bench.sign_of_life = (bench.sign_of_life + 13) % 15 + 1;
            bench.frame();
        });
        see(seen, &mut bench);
    }
    let late = bench.encoder.write_record(bench.now, access(0xBF00), &record(0x2A, 1024, 1024));
    seen.push(late.map_or_else(|refusal| refusal.code1().into(), |()| 0));
    see(seen, &mut bench);
    let elsewhere = Access { subslot: 2, ..access(0xB02E) };
    let answer = bench.encoder.read_record(bench.now, elsewhere, &mut Vec::new());
    seen.push(answer.map_or_else(|refusal| refusal.code1().into(), |()| 0));
    bench.connect(81, &record(0x22, 0, 0)).ok();
    seen.push(bench.encoder.parameter_end(bench.now, AR).as_nanos());
}

fn memory(seen: &mut Vec<u64>, bug: Option<&Behaviour>) {
    let default = record(0x22, 65536, 1 << 30);
    let mut bench = Bench::alone(MULTITURN, bug, 5000);
    let cycle = |seen: &mut Vec<u64>, bench: &mut Bench| {
        bench.power_cycle();
        bench.g1_stw = 0;
        seen.push(bench.connect(81, &default).map_or(1, |()| 0));
        see(seen, bench);
    };
    cycle(seen, &mut bench);
    for (mode, value) in [(0, 0x1234), (RELATIVE, 1000)] {
        bench.write(65000, value).ok();
        bench.set(mode | HOME);
        bench.set(0);
        for _ in 0..2 {
            cycle(seen, &mut bench);
        }
    }
    for pauses in [true, false] {
        for value in [0x1111, 0x2222] {
            bench.write(65000, value).ok();
            bench.write(971, 1).ok();
            bench.wait(if pauses { 500 } else { 10 });
        }
        bench.wait(500);
        cycle(seen, &mut bench);
    }
    bench.fault("memory", true);
    bench.write(971, 1).ok();
    bench.wait(500);
    see(seen, &mut bench);
    bench.fault("memory", false);
    bench.set(PARK);
    cycle(seen, &mut bench);
}

fn resets(seen: &mut Vec<u64>, bug: Option<&Behaviour>) {
    let mut bench = Bench::alone(MULTITURN, bug, 5000);
    bench.connect(81, &record(0x22, 65536, 1 << 30)).ok();
    let ip = [192, 168, 0, 10];
    let station = StationData { name: b"enc-1".to_vec(), ip, mask: [255; 4], gateway: [192, 168, 0, 1] };
    for is_connected in [true, false] {
        if !is_connected {
            bench.encoder.ended(bench.now, AR);
        }
        bench.encoder.set_station(bench.now, &station, &station);
        bench.power_cycle();
        let mut told = |bench: &Bench| {
            let StationData { name, ip, mask, gateway } = bench.encoder.stored_station();
            let octets = name.iter().chain(&ip).chain(&mask).chain(&gateway);
            seen.extend(octets.map(|octet| u64::from(*octet)));
            seen.push(bench.encoder.identity().serial_number.len() as u64);
        };
        told(&bench);
        let done = bench.encoder.factory_reset(bench.now, ResetScope::Factory);
        told(&bench);
        bench.power_cycle();
        told(&bench);
        seen.push(done.into());
        seen.extend(bench.read(65000, 0, 1).unwrap_or_default());
    }
}

/// What is seen of starts, memory and resets.
pub(super) fn walk(seen: &mut Vec<u64>, bug: Option<&Behaviour>) {
    records(seen, SINGLETURN, bug);
    records(seen, MULTITURN, bug);
    memory(seen, bug);
    resets(seen, bug);
}

// Catalogue PRK-011: what happens to the sensor while parked leaves nothing behind.
