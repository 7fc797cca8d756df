//! Start-up: identity, what can be plugged, user parameters, telegrams, parameters at rest.

use super::*;
use device_stack::profinet::ResetScope;
use rstest::rstest;

#[test]
fn what_can_be_plugged() {
    let bench = Xac77Bench::alone(SINGLETURN, None, 0);
    let plugs = bench.encoder.plugs().iter();
    let submodules: Vec<_> = plugs
        .map(|plug| (plug.slot, plug.subslot, plug.api, plug.submodule_ident, plug.output_octets, plug.input_octets))
        .collect();
    // Lengths: manual, 9.1.1 to 9.1.4.
    assert_eq!(
        submodules,
        [
            (0, 1, 0, 1, 0, 0),
            (1, 1, 0x3D00, 2, 0, 0),
            (1, 2, 0x3D00, 81, 4, 12),
            (1, 2, 0x3D00, 82, 4, 14),
            (1, 2, 0x3D00, 83, 4, 16),
            (1, 2, 0x3D00, 84, 4, 20),
        ]
    );
    let identity = bench.encoder.identity();
    assert_eq!((identity.vendor_id, identity.station_type), (0x0239, "LIKA ROTACOD"));
    assert!(identity.order_id.len() <= 20 && identity.serial_number.len() <= 16);
}

// Manual, 11.2 and 11.3: parameters of both encoders at their defaults.
#[rstest]
#[case(SINGLETURN, 262_144, 1, 262_144)]
#[case(MULTITURN, 65536, 16384, 1 << 30)]
fn parameters_at_default(#[case] variant: usize, #[case] steps: u64, #[case] revolutions: u64, #[case] range: u64) {
    let mut bench = Xac77Bench::alone(variant, None, 0);
    bench.connect(83, &record(0x22, steps, range)).expect("the default record");
    assert_eq!(bench.value(922, 0), 83);
    assert_eq!(bench.read(964, 0, 6), Ok(alloc::vec![0x239, 1, 110, 2013, 2410, 1]));
    assert_eq!(bench.read(965, 0, 0), Ok(alloc::vec![0x3D, 41]));
    assert_eq!(bench.value(971, 0), 0);
    assert_eq!(bench.read(975, 0, 8), Ok(alloc::vec![0x239, 1, 110, 2013, 2410, 5, 0x8000, 1]));
    assert_eq!(bench.read(979, 0, 6), Ok(alloc::vec![0x5011, 0x8000_0000, steps, 0, 0, revolutions]));
    assert_eq!(bench.read(980, 0, 9), Ok(alloc::vec![922, 964, 965, 971, 975, 979, 61001, 65000, 65001]));
    assert_eq!(bench.value(65000, 0), 0);
    assert_eq!(
        bench.read(65001, 0, 12),
        Ok(alloc::vec![0x000C_0101, 0x22, 0, 0x30, 0, 0, 0x401, 0xFFFF_FFFF, 0, steps, range, 0])
    );
    for unknown in [1, 925, 978, 60000, 61000, 65002] {
        assert_eq!(bench.read(unknown, 0, 1), Err(0x00));
    }
    for fixed in [922, 964, 965, 975, 979, 980, 61001, 65001] {
        assert_eq!(bench.write(fixed, 1), Err(0x01));
    }
}

// Manual, 17.1, example of an address; bytes as in catalogue PAR-044.
#[test]
fn p61001_is_the_address_in_use() {
    let mut bench = Xac77Bench::connected(None, 0);
    let station = StationData { ip: [192, 168, 20, 195], ..StationData::default() };
    bench.encoder.set_station(bench.now, &station, &StationData::default());
    assert_eq!(bench.value(61001, 0), 0xC0A8_14C3);
    assert_eq!(bench.encoder.stored_station(), StationData::default());
}

#[test]
fn operating_status_has_byte_0_and_the_scaling_in_force() {
    let mut bench = Xac77Bench::connected(None, 0);
    for bits in 0..=0xFF {
        let mut octets = record(bits, 4096, 1 << 20);
        octets[18] = 3;
        bench.connect(81, &octets).expect("the record is right");
        let scaled = bits & 0x0A == 0x0A;
        assert_eq!(bench.value(65001, 1), u64::from(bits & 0x3F));
        assert_eq!(bench.value(65001, 9), if scaled { 4096 } else { 65536 });
        assert_eq!(bench.value(65001, 10), if scaled { 1 << 20 } else { 1 << 30 });
        assert_eq!(bench.value(65001, 11), 3);
        assert_eq!(bench.read(965, 0, 0), Ok(alloc::vec![0x3D, if bits & 0x20 == 0 { 31 } else { 41 }]));
        assert_eq!(bench.value(65001, 6), 0x401);
    }
}

#[test]
fn record_of_another_length_or_outside_start_up_is_refused() {
    let mut bench = Xac77Bench::connected(None, 0);
    let default = record(0x22, 65536, 1 << 30);
    for length in 0..31 {
        assert_eq!(bench.connect(81, &default[..length]), Err(RecordRefusal::WriteLength));
        assert_eq!((bench.value(65001, 1), bench.value(65001, 2)), (0x22, 0));
    }
    assert_eq!(bench.connect(81, &[&default[..], &[0]].concat()), Err(RecordRefusal::WriteLength));
    let now = bench.now;
    assert_eq!(bench.encoder.write_record(now, access(0xBF00), &default), Err(RecordRefusal::StateConflict));
    bench.encoder.ended(now, AR);
    assert_eq!(bench.encoder.write_record(now, access(0xBF00), &default), Err(RecordRefusal::StateConflict));
}

#[test]
fn each_start_begins_with_the_defaults() {
    let mut bench = Xac77Bench::connected(None, 0);
    bench.connect(84, &record(0x0B, 4096, 4096)).expect("the record is right");
    bench.encoder.ended(bench.now, AR);
    bench.encoder.started(bench.now, ArKey(2), &[]);
    bench.encoder.parameter_end(bench.now, ArKey(2));
    assert_eq!((bench.value(922, 0), bench.value(65001, 1), bench.value(65001, 10)), (81, 0x22, 1 << 30));
}

#[rstest]
#[case(0xB02F, 1, RecordRefusal::InvalidIndex)]
#[case(0x1234, 1, RecordRefusal::InvalidIndex)]
#[case(0xB02E, 2, RecordRefusal::InvalidIndex)]
#[case(0xB02E, 1, RecordRefusal::StateConflict)]
fn records_that_cannot_be_read(#[case] index: u16, #[case] subslot: u16, #[case] refusal: RecordRefusal) {
    let mut bench = Xac77Bench::connected(None, 0);
    let access = RecordAccess { subslot, ..access(index) };
    assert_eq!(bench.encoder.read_record(bench.now, access, &mut Vec::new()), Err(refusal));
}

#[test]
fn a_response_does_not_outlive_its_connection() {
    let mut bench = Xac77Bench::connected(None, 0);
    let request = [1, 1, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0];
    bench.encoder.write_record(bench.now, access(0xB02E), &request).expect("the request is right");
    bench.encoder.ended(bench.now, AR);
    let read = bench.encoder.read_record(bench.now, access(0xB02E), &mut Vec::new());
    assert_eq!(read, Err(RecordRefusal::StateConflict));
}

// Manual, 7.6.
#[rstest]
#[case(ResetScope::Factory, true, true, true)]
#[case(ResetScope::AllData, true, true, true)]
#[case(ResetScope::Device, true, true, true)]
#[case(ResetScope::ApplicationData, true, true, false)]
#[case(ResetScope::Communication, true, false, true)]
#[case(ResetScope::Engineering, false, false, false)]
#[case(ResetScope::FactoryImage, false, false, false)]
#[case(ResetScope::Other(99), false, false, false)]
fn factory_reset(#[case] scope: ResetScope, #[case] is_supported: bool, #[case] values: bool, #[case] name: bool) {
    let mut bench = Xac77Bench::connected(None, 5000);
    let station =
        StationData { name: b"enc-1".to_vec(), ip: [192, 168, 0, 10], mask: [255; 4], gateway: [192, 168, 0, 1] };
    bench.encoder.set_station(bench.now, &station, &station);
    bench.preset(0x1234, 0);
    bench.write(971, 1).expect("saved");
    bench.wait(1000);
    assert_eq!(bench.encoder.factory_reset(bench.now, scope), is_supported);
    for _ in 0..2 {
        assert_eq!(bench.encoder.stored_station(), if name { StationData::default() } else { station.clone() });
        assert_eq!(bench.value(65000, 0), if values { 0 } else { 0x1234 });
        assert_eq!(bench.value(65001, 8), if values { 0 } else { (1 << 30) + 0x1234 - 5000 });
        bench.power_cycle();
    }
}

#[test]
fn bytes_of_every_telegram() {
    let mut bench = Xac77Bench::alone(MULTITURN, None, 0x0005_1234);
    bench.g1_stw = ABSOLUTE;
    let position = [0x00, 0x05, 0x12, 0x34];
    for (telegram, xist1) in [(81, 4..8), (82, 4..8), (83, 4..8), (84, 8..12)] {
        bench.connect(telegram, &record(0x22, 65536, 1 << 30)).expect("the default record");
        let octets = bench.octets();
        assert!(bench.good);
        assert_eq!((&octets[1..4], &octets[xist1.clone()]), (&[0x00, 0x20, 0x00][..], &position[..]));
        assert_eq!(octets[0] & 0x0F, 0x02);
        assert_eq!(&octets[xist1.end..xist1.end + 4], &position[..]);
        assert!(octets[xist1.end + 4..].iter().all(|octet| *octet == 0));
    }
}
