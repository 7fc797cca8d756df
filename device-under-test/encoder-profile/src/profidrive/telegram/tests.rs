use super::*;
use rstest::rstest;

const IMAGE: SignalImage = SignalImage {
    zsw2_enc: 0x3200,
    g1_zsw: 0x2000,
    g1_xist1: 0x0001_2345,
    shift: 0,
    g1_xist2: 0x1002,
    g1_xist3: 0x0012_3456_789A_BCDE,
    velocity: -60,
    good: true,
    position: 0,
    offset: 0,
    plain_position: 0x1234_5678,
    single_turn: 0x0678,
    multi_turn: 0x0001_2345,
    time_stamp: 0,
    is_transferred: false,
    request: SensorRequest { relative: false, home: false, absolute: false, park: false, acknowledge: false },
    outputs: [0; 2],
    trigger: 0,
};

// Layouts: XAC77 manual, 9.1.1 to 9.1.4.
#[rstest]
#[case(0, &[0x32, 0x00, 0x20, 0x00, 0x00, 0x01, 0x23, 0x45, 0x00, 0x00, 0x10, 0x02])]
#[case(1, &[0x32, 0x00, 0x20, 0x00, 0x00, 0x01, 0x23, 0x45, 0x00, 0x00, 0x10, 0x02, 0xFF, 0xC4])]
#[case(2, &[0x32, 0x00, 0x20, 0x00, 0x00, 0x01, 0x23, 0x45, 0x00, 0x00, 0x10, 0x02, 0xFF, 0xFF, 0xFF, 0xC4])]
#[case(3, &[0x32, 0x00, 0x20, 0x00, 0x00, 0x12, 0x34, 0x56, 0x78, 0x9A, 0xBC, 0xDE, 0x00, 0x00, 0x10, 0x02, 0xFF,
            0xFF, 0xFF, 0xC4])]
fn layouts(#[case] index: usize, #[case] expected: &[u8]) {
    let telegram = &STANDARD[index];
    let mut inputs = alloc::vec![0xAA; telegram.input_octets.into()];
    telegram.write(&IMAGE, &mut inputs);
    assert_eq!(inputs, expected);
}

#[rstest]
#[case(65536, [0x7F, 0xFF], [0x00, 0x01, 0x00, 0x00])]
#[case(-65536, [0x80, 0x00], [0xFF, 0xFF, 0x00, 0x00])]
#[case(1 << 40, [0x7F, 0xFF], [0x7F, 0xFF, 0xFF, 0xFF])]
#[case(6000, [0x17, 0x70], [0x00, 0x00, 0x17, 0x70])]
fn velocities_saturate(#[case] velocity: i64, #[case] a: [u8; 2], #[case] b: [u8; 4]) {
    let image = SignalImage { velocity, ..IMAGE };
    let both = Telegram { inputs: &[NistA, NistB], ..STANDARD[1] };
    assert_eq!(both.octets(&image), [&a[..], &b].concat());
}

#[rstest]
#[case(&[0x04, 0x00, 0x20, 0x00], Some([0x0400, 0x2000]))]
#[case(&[0x04, 0x00, 0x20], None)]
#[case(&[], None)]
fn control_words(#[case] octets: &[u8], #[case] words: Option<[u16; 2]>) {
    let mut taken = OutputValues { words: Some([1, 2]), preset: Some(3), separate: Some(4), unused: None };
    taken.replace(&STANDARD[0], OutputValues::read(&STANDARD[0], Some(octets)));
    assert_eq!(taken, OutputValues { words, preset: Some(3), separate: Some(4), unused: None });
    taken.replace(&STANDARD[0], OutputValues::read(&STANDARD[0], None));
    assert_eq!(taken.words, None);
}

// Kübler Sendix 58xx, telegram 860: 8 input bytes with position and velocity, 4 output bytes with the preset word.
// Separate submodules have the speed, the parts of the position and a second pair of sensor words.
static TELEGRAM_860: Telegram = Telegram {
    number: 860,
    inputs: &[Position, NistB],
    input_octets: 8,
    outputs: &[OutputWord::Preset],
    output_octets: 4,
};
static PARTS: Telegram = Telegram {
    number: 0,
    inputs: &[NistA, SingleTurn, MultiTurn, SeparateG1Zsw],
    input_octets: 12,
    outputs: &[OutputWord::SeparateG1Stw],
    output_octets: 2,
};

#[test]
fn several_telegrams_share_a_frame() {
    let (first, second) = (TELEGRAM_860.octets(&IMAGE), PARTS.octets(&IMAGE));
    assert_eq!(first, [0x12, 0x34, 0x56, 0x78, 0xFF, 0xFF, 0xFF, 0xC4]);
    assert_eq!(second, [0xFF, 0xC4, 0, 0, 0x06, 0x78, 0x00, 0x01, 0x23, 0x45, 0x20, 0x00]);
    let mut taken = OutputValues::default();
    let mut take = |telegram, octets: &[u8]| {
        taken.replace(telegram, OutputValues::read(telegram, Some(octets)));
        taken
    };
    take(&TELEGRAM_860, &[0x80, 0, 0x12, 0x34]);
    let all = take(&PARTS, &[0x40, 0]);
    assert_eq!(all, OutputValues { words: None, preset: Some(0x8000_1234), separate: Some(0x4000), unused: None });
    assert_eq!(
        take(&TELEGRAM_860, &[0x80, 0, 0x12]),
        OutputValues { words: None, preset: None, separate: Some(0x4000), unused: None }
    );
}

// SICK AFS60/AFM60: 65536 is sent as 00 04 00 00 with 30 bits and as 40 00 00 00 with 18.
#[rstest]
#[case(2, [0x00, 0x04, 0x00, 0x00])]
#[case(14, [0x40, 0x00, 0x00, 0x00])]
fn position_1_is_shifted(#[case] shift: u32, #[case] octets: [u8; 4]) {
    let image = SignalImage { g1_xist1: 0x1_0000, shift, ..IMAGE };
    assert_eq!(Telegram { inputs: &[G1Xist1], ..STANDARD[0] }.octets(&image), octets);
}

// Kübler Sendix 58xx: 4096 units per revolution, position 0x3456 of a range of 0x4000 units; and a position below one revolution.
#[rstest]
#[case(0x3456, 0x1000, [0x456, 3])]
#[case(0x07FF, 0x1000, [0x7FF, 0])]
fn positions_have_two_parts(#[case] position: u64, #[case] units: u64, #[case] expected: [u32; 2]) {
    let scaling = Scaling { units_per_revolution: units, range: 0x4000 };
    assert_eq!(parts(position, &scaling), expected);
}
