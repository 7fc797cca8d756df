//! Compiles every expression of the worked cases with the options of its place in a suite.

use super::{Allow, Program, TestNames, Type, condition, target, ty};
use rstest::rstest;

#[rstest]
#[case("not G1_ZSW.sensor_error")]
#[case("G1_ZSW.sensor_error and G1_XIST2 == 0x00001001")]
#[case("not (G1_ZSW.parked and G1_ZSW.transmit_absolute_value)")]
#[case("G1_ZSW.parked or G1_XIST1 == 0x1234")]
#[case("G1_ZSW.transmit_absolute_value or G1_XIST2 == 0")]
#[case("not (G1_ZSW.transmit_absolute_value and G1_ZSW.sensor_error)")]
#[case("G1_ZSW.transmit_absolute_value or G1_ZSW.sensor_error or G1_XIST2 == 0")]
#[case("rises(G1_STW.request_home_position) and STW2_ENC.control_by_plc and not G1_ZSW.parked")]
#[case("rises(G1_STW.request_home_position) and STW2_ENC.control_by_plc")]
#[case("G1_ZSW.home_position_executed")]
#[case("rises(G1_ZSW.home_position_executed)")]
#[case("not G1_STW.request_home_position or G1_STW.park")]
#[case("changes(ZSW2_ENC.sign_of_life) and prev(ZSW2_ENC.sign_of_life) != 0")]
#[case("ZSW2_ENC.sign_of_life == prev(ZSW2_ENC.sign_of_life) mod 15 + 1")]
#[case("not alarm")]
#[case("alarm")]
#[case("not (led.encoder == green_flashing)")]
#[case("G1_ZSW.transmit_absolute_value and g1_xist1_preset_control == enabled")]
#[case("G1_XIST1 == G1_XIST2 << xist1_shift")]
#[case("G1_ZSW.sensor_error")]
#[case("G1_XIST2 in [0x0001, 0x0F01, 0x0F05, 0x1001, 0x1003, 0x1004]")]
#[case("abs(G1_XIST2 - prev(G1_XIST2)) <= 8")]
#[case("rises(io.diagnosis_pending)")]
#[case("changes(time_stamp)")]
#[case("time_stamp == (prev(time_stamp) + 1) mod 65536 and since(changes(time_stamp)) == 1s +/- 2%")]
#[case("changes(G1_ZSW.sensor_error)")]
#[case("changes(G1_XIST2)")]
#[case("diag.fixed_one")]
#[case("connection == data and position == place")]
#[case("position < total_range")]
#[case("abs(position - prev(position)) <= 1 or position == 0x1000 +/- 40")]
#[case(
    "ZSW2_ENC.sign_of_life != 0 and (ZSW2_ENC.sign_of_life - prev(ZSW2_ENC.sign_of_life)) mod 15 == floor(cycle / 1ms) mod 15"
)]
#[case("MT_POS * units_per_revolution + ST_POS == position +/- 1")]
fn conditions(#[case] text: &str) {
    let program = condition(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    assert_eq!(program.ty(), &Type::Bit);
    assert!(!program.is_constant() && program.names().next().is_some());
}

#[rstest]
#[case("G1_XIST1", " before + 3 * shift")]
#[case("position", " before + 3 * shift")]
#[case("position", " shown +/- 1")]
#[case("position", " 240 +/- 1")]
#[case("NIST_B", " 300 +/- 5%")]
#[case("NIST_B", " 600 +/- 1")]
#[case("position", " before + 20 * 360 +/- 1")]
#[case("position", " before +/- 1")]
#[case("NIST_B", " shown +/- 1%")]
#[case("NIST_B", " long +/- 1%")]
#[case("position", " 0x1334 +/- 1")]
#[case("position", " after +/- 1")]
#[case("position", " 0x1000 +/- 40")]
#[case("position", "place")]
#[case("NIST_B", "short")]
#[case("station.name", "name")]
#[case("station.name", r#" "a" * 63 + "." + "b" * 63"#)]
fn right_sides(#[case] name: &str, #[case] text: &str) {
    // Comparing positions of different circles is an error, so `before` is compared with a position of its own circle.
    let name = if text.contains("before") { "position" } else { name };
    let target = target(text, name).unwrap_or_else(|error| panic!("{text}: {error}"));
    assert_eq!(target.tolerance.is_some(), text.contains("+/-"));
}

#[rstest]
#[case("if class_4 == enabled and scaling == enabled then total_range else hardware_range")]
#[case("if class_4 == enabled and (scaling == enabled or round_axis == enabled) then total_range else hardware_range")]
#[case("if class_2 == enabled and scaling == enabled then total_range else hardware_range")]
#[case("total_range << xist1_shift")]
#[case("total_range << 1")]
#[case("hardware_range")]
fn derived_values(#[case] text: &str) {
    let program =
        Program::value(text, None, &TestNames::new(), Allow::DEVICE).unwrap_or_else(|error| panic!("{text}: {error}"));
    assert!(matches!(program.ty(), Type::Number(kind) if kind.whole));
}

#[rstest]
#[case("G1_XIST1")]
#[case("position")]
#[case("G1_XIST2")]
fn saved_values(#[case] text: &str) {
    let program = Program::value(text, None, &TestNames::new(), Allow::VALUE).expect("a value");
    assert_eq!(program.ty(), &ty(text));
}
