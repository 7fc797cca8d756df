//! The handshakes of the manuals.

use super::*;
use rstest::rstest;

const HOME: u16 = 0x1000;
const RELATIVE: u16 = 0x1800;
const ABSOLUTE: u16 = 0x2000;
const PARK: u16 = 0x4000;
const ACKNOWLEDGE: u16 = 0x8000;
const MEMORY: SensorError = SensorError::of(0x1001);
const PARAMETERS: SensorError = SensorError::of(0x1002);
const LIFE_SIGN: SensorError = SensorError::of(0x0F02);

fn sensor() -> Sensor {
    Sensor::new(SensorFacts::PROFILE, AttachedChecks::default())
}

fn cycle(sensor: &mut Sensor, g1_stw: u16) -> u16 {
    if sensor.cycle(SensorRequest::of(g1_stw), false).is_some() {
        sensor.preset_done(true);
    }
    sensor.g1_zsw()
}

#[rstest]
#[case(HOME, PresetMode::Absolute)]
#[case(RELATIVE, PresetMode::Relative)]
fn a_preset_is_acknowledged_when_it_is_done(#[case] word: u16, #[case] mode: PresetMode) {
    let mut sensor = sensor();
    assert_eq!(sensor.cycle(SensorRequest::of(word & 0x0800), false), None);
    assert_eq!(sensor.cycle(SensorRequest::of(word), false), Some(mode));
    assert_eq!(sensor.cycle(SensorRequest::of(word), false), None);
    assert_eq!(sensor.g1_zsw(), 0);
    sensor.preset_done(true);
    assert_eq!(sensor.g1_zsw(), HOME);
    for _ in 0..3 {
        assert_eq!(sensor.cycle(SensorRequest::of(word), false), None);
        assert_eq!(sensor.g1_zsw(), HOME);
    }
    assert_eq!(sensor.cycle(SensorRequest::of(0), false), None);
    assert_eq!(sensor.g1_zsw(), 0);
    assert_eq!(sensor.cycle(SensorRequest::of(word), false), Some(mode));
}

#[test]
fn a_failed_or_withdrawn_preset_is_not_acknowledged() {
    let mut sensor = sensor();
    sensor.cycle(SensorRequest::of(HOME), false);
    sensor.preset_done(false);
    assert_eq!(cycle(&mut sensor, HOME), 0);
    cycle(&mut sensor, 0);
    sensor.cycle(SensorRequest::of(HOME), false);
    sensor.cycle(SensorRequest::of(0), false);
    sensor.preset_done(true);
    assert_eq!(sensor.g1_zsw(), 0);
}

// Manual, 16.3: parking clears bits 12 and 13 and all errors; bit 13 comes back by itself.
#[test]
fn parking() {
    let mut sensor = sensor();
    sensor.watch(&[MEMORY]);
    assert_eq!(cycle(&mut sensor, HOME | ABSOLUTE), 0x9000);
    assert_eq!(cycle(&mut sensor, HOME | ABSOLUTE | PARK), PARK);
    sensor.watch(&[MEMORY, PARAMETERS]);
    assert_eq!((sensor.xist2(), sensor.errors().len()), (Xist2::Nothing, 0));
    assert_eq!(cycle(&mut sensor, ABSOLUTE | PARK), PARK);
    assert_eq!(sensor.cycle(SensorRequest::of(HOME | ABSOLUTE | PARK), false), None);
    assert_eq!(sensor.cycle(SensorRequest::of(HOME | ABSOLUTE), true), None);
    assert_eq!(sensor.g1_zsw(), ABSOLUTE);
    sensor.watch(&[PARAMETERS]);
    assert_eq!(sensor.xist2(), Xist2::Error(0x1002));
}

#[test]
fn a_turning_encoder_does_not_park() {
    let mut sensor = sensor();
    sensor.cycle(SensorRequest::of(PARK | ABSOLUTE), true);
    assert_eq!((sensor.g1_zsw(), sensor.xist2()), (0x8000, Xist2::Error(3)));
    for word in [PARK, PARK | ACKNOWLEDGE, PARK] {
        sensor.cycle(SensorRequest::of(word), false);
        assert_eq!(sensor.g1_zsw() & 0xC000, 0x8000);
    }
    let words = [0, ACKNOWLEDGE, 0, 0, PARK].map(|word| cycle(&mut sensor, word));
    assert_eq!(words, [0x8000, 0x8800, 0x0800, 0, PARK]);
}

// Manual, 16.4.1 and 16.4.2: bit 11 of G1_ZSW is cleared last.
#[rstest]
#[case::solved(&[], [0x8000, 0x8800, 0x8800, 0x2800, 0x2000])]
#[case::not_solved(&[MEMORY], [0x8000, 0x8800, 0x8800, 0x8800, 0x8000])]
fn acknowledgement(#[case] causes: &[SensorError], #[case] expected: [u16; 5]) {
    let mut sensor = sensor();
    assert_eq!(cycle(&mut sensor, ABSOLUTE), ABSOLUTE);
    sensor.watch(&[MEMORY]);
    sensor.watch(causes);
    for _ in 0..2 {
        let words = [0, ACKNOWLEDGE, ACKNOWLEDGE, 0, 0].map(|word| cycle(&mut sensor, word | ABSOLUTE));
        assert_eq!(words, expected);
        if causes.is_empty() {
            break;
        }
    }
}

#[test]
fn acknowledging_without_an_error_or_before_it_does_nothing() {
    let mut sensor = sensor();
    assert_eq!(cycle(&mut sensor, ACKNOWLEDGE | ABSOLUTE), ABSOLUTE);
    sensor.watch(&[MEMORY]);
    sensor.watch(&[]);
    assert_eq!(cycle(&mut sensor, ACKNOWLEDGE), 0x8000);
    assert_eq!(cycle(&mut sensor, 0), 0x8000);
}

#[test]
fn an_acknowledgement_may_follow_the_last_one_at_once() {
    let mut sensor = sensor();
    sensor.watch(&[MEMORY]);
    let words = [ACKNOWLEDGE, 0, ACKNOWLEDGE, 0, 0].map(|word| cycle(&mut sensor, word));
    assert_eq!(words, [0x8800, 0x8800, 0x8800, 0x8800, 0x8000]);
}

#[test]
fn the_oldest_error_is_shown_and_a_new_connection_keeps_persistent_errors() {
    let mut sensor = sensor();
    sensor.watch(&[LIFE_SIGN]);
    sensor.watch(&[LIFE_SIGN, MEMORY]);
    assert_eq!(sensor.xist2(), Xist2::Error(0x0F02));
    sensor.restart(&[MEMORY]);
    assert_eq!((sensor.xist2(), sensor.g1_zsw()), (Xist2::Error(0x1001), 0x8000));
    sensor.watch(&[]);
    sensor.restart(&[]);
    assert_eq!(sensor.g1_zsw(), 0);
}

// Catalogue SIG-021, SIG-022, SIG-028, SIG-036: bits without function, and bits that are never set together.
#[test]
fn every_control_word_results_in_a_consistent_status_word() {
    for word in 0..=u16::MAX {
        let mut sensor = sensor();
        sensor.watch(&[MEMORY]);
        sensor.watch(&[]);
        for word in [word, word ^ 0x8000, 0x2000, word] {
            let status = cycle(&mut sensor, word);
            assert_eq!(status & 0x07FF, 0);
            assert_ne!(status & 0xA000, 0xA000);
            assert_eq!(cycle(&mut sensor.clone(), word & 0xF800), cycle(&mut sensor.clone(), word));
        }
    }
}

/// The sensor interface of the Kübler Sendix 58xx: errors are not latched, and parking freezes positions.
fn state_sensor() -> Sensor {
    let facts = SensorFacts {
        transfers: PositionTransfer::Always,
        parks: ParkingEffect::Freezes,
        answers: AcknowledgeAnswer::Echo,
        latches_errors: false,
        parks_while_turning: true,
        parking_clears_errors: false,
        ..SensorFacts::PROFILE
    };
    Sensor::new(facts, AttachedChecks::default())
}

// Sendix 58xx: bit 13 of G1_ZSW is set without a request, and 8800h answers a request while there is a fault.
#[test]
fn errors_that_are_not_latched() {
    let mut sensor = state_sensor();
    let sent = [0, ACKNOWLEDGE, PARK, 0].map(|word| cycle(&mut sensor, word));
    assert_eq!(sent, [0x2000, 0x2000, 0x6000, 0x2000]);
    sensor.watch(&[SensorError::of(0x0020)]);
    let sent = [0, ACKNOWLEDGE, ACKNOWLEDGE, 0].map(|word| cycle(&mut sensor, word));
    assert_eq!((sent, sensor.xist2()), ([0x8000, 0x8800, 0x8800, 0x8000], Xist2::Error(0x0020)));
    sensor.watch(&[]);
    assert_eq!((sensor.g1_zsw(), sensor.xist2()), (0x2000, Xist2::Position));
}

#[test]
fn parking_ends_with_the_connection() {
    let mut sensor = state_sensor();
    cycle(&mut sensor, PARK);
    assert!(sensor.is_frozen());
    sensor.ended();
    assert!(!sensor.is_parked());
}

// SICK AFS60/AFM60: two errors share the code 1001h, and one has none.
#[test]
fn errors_that_share_a_code_or_have_none() {
    let [first, second] = [1, 2].map(|number| SensorError { number, code: Some(0x1001) });
    let commissioning = SensorError { number: 3, code: None };
    let mut sensor = sensor();
    sensor.watch(&[commissioning]);
    assert_eq!((cycle(&mut sensor, ABSOLUTE), sensor.errors().len()), (ABSOLUTE, 1));
    sensor.watch(&[commissioning, first, second]);
    sensor.watch(&[second]);
    let sent = [ACKNOWLEDGE, 0, 0].map(|word| cycle(&mut sensor, word));
    assert_eq!((sent, sensor.errors()), ([0x8800, 0x8800, 0x8000], &[second][..]));
}

// SICK AFS60/AFM60: parking clears no errors, and acknowledging works while parked.
#[test]
fn acknowledging_while_parked() {
    let facts = SensorFacts { parking_clears_errors: false, acknowledges_while_parked: true, ..SensorFacts::PROFILE };
    let mut sensor = Sensor::new(facts, AttachedChecks::default());
    sensor.watch(&[MEMORY]);
    sensor.watch(&[]);
    let sent = [PARK, PARK | ACKNOWLEDGE, PARK, PARK, 0].map(|word| cycle(&mut sensor, word));
    assert_eq!(sent, [0xC000, 0xC800, 0x4800, 0x4000, 0]);
}

#[test]
fn a_request_that_was_not_valid_before_is_not_new() {
    let mut sensor = sensor();
    assert_eq!(sensor.cycle(SensorRequest::default(), false), None);
    sensor.note_invalid_preset(true);
    assert_eq!(sensor.cycle(SensorRequest::of(HOME), false), None);
    assert_eq!(sensor.cycle(SensorRequest::of(0), false), None);
    assert_eq!(sensor.cycle(SensorRequest::of(HOME), false), Some(PresetMode::Absolute));
}
