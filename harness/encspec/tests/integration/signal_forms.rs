//! Signals that are no whole numbers: the bytes on the wire of floating-point numbers, scaled numbers and texts, and the other byte order.
//!
//! The plain PROFINET device returns its outputs as inputs, so each value is seen on the wire, where it has the bytes of IEEE 754 or of
//! plain arithmetic, and read back by its name.

use crate::common::program::{ProgramOutput, encspec};
use rstest::rstest;
use testing::{Folder, workspace};

const REQUIREMENTS: &str = "source: profile\nchannel: cyclic\nrequirements:\n  - { id: FORM-1, cites: none, statement: It is tried., level: should }\n";

/// A manual for the plain device, whose signal `given` is `output` and whose `mirrored` is `input`, with a case of these steps.
fn manual(test: &str, output: &str, input: &str, steps: &str) -> Folder {
    let folder = Folder::new(test);
    let device = std::fs::read_to_string(workspace().join("suites/profinet-io/device.yaml")).expect("the plain device");
    let lines = device.lines().map(|line| match line.split_whitespace().next() {
        Some("given:") => format!("  given: {{ from: controller, {output} }}\n"),
        Some("mirrored:") => format!("  mirrored: {{ from: device, {input} }}\n"),
        _ => format!("{line}\n"),
    });
    let device: String = lines.collect();
    assert!(device.contains(output) && device.contains(input), "{device}");
    folder.write("profinet-io/device.yaml", device);
    folder.write("profinet-io/requirements.yaml", REQUIREMENTS);
    let case = format!(
        "suite: forms\ndefaults: {{ start: {{ module: mirror }} }}\ncases:\n  - id: form\n    why: It is tried.\n    covers: [FORM-1]\n    \
         steps:\n{steps}"
    );
    folder.write("profinet-io/forms.yaml", case);
    folder
}

fn run(folder: &Folder) -> ProgramOutput {
    encspec(folder, &["run", "--suites", "profinet-io", "--dut", "model:profinet-io/plain", "--no-evidence"])
}

/// Steps that set `given`, look for bytes of the inputs, and read the value back by its name.
fn steps(given: &str, bytes: &str, mirrored: &str) -> String {
    format!(
        "      - set: {{ given: {given} }}\n      - expect: {{ io.inputs: \"{bytes} *\" }}\n      - expect: {{ mirrored: {mirrored} }}\n"
    )
}

#[rstest]
#[case("float", "width: 32, float: true", "width: 32, float: true", "25.5", "41 CC 00 00", "25.5")]
#[case("near", "width: 32, float: true", "width: 32, float: true", "0.1", "3D CC CC CD", "'= 0.1 +/- 0.0001'")]
#[case("whole", "width: 32, float: true", "width: 32", "-2", "C0 00 00 00", "0xC0000000")]
#[case("last", "width: 32, float: true, little_endian: true", "width: 32", "25.5", "00 00 CC 41", "0x0000CC41")]
#[case("first", "width: 32", "width: 32, float: true, little_endian: true", "0x0000CC41", "00 00 CC 41", "25.5")]
#[case("scaled", "width: 32, scale: 0.1, zero: -40", "width: 32, scale: 0.1, zero: -40", "23.5", "00 00 02 7B", "23.5")]
#[case("nearest", "width: 32, scale: 0.1", "width: 32", "0.26", "00 00 00 03", "3")]
#[case("signed", "width: 32, signed: true, scale: 0.1", "width: 32, scale: 0.5", "-0.2", "FF FF FF FE", "2147483647")]
#[case("signs", "width: 32, scale: 1", "width: 32, signed: true, scale: 0.1", "0xFFFFFF83", "FF FF FF 83", "-12.5")]
#[case("order", "width: 32, little_endian: true", "width: 32", "0x11223344", "44 33 22 11", "0x44332211")]
#[case("text", "width: 32", "text: 4", "0x41463300", "41 46 33 00", "\"AF3\"")]
#[case("blanks", "width: 32", "text: 4", "0x41202020", "41 20 20 20", "\"A\"")]
fn the_bytes_of_a_value(
    #[case] name: &str,
    #[case] output: &str,
    #[case] input: &str,
    #[case] given: &str,
    #[case] bytes: &str,
    #[case] mirrored: &str,
) {
    let folder = manual(&format!("form-{name}"), output, input, &steps(given, bytes, mirrored));
    let said = run(&folder);
    assert_eq!(said.status, Some(0), "{}", said.all());
    assert!(said.out.ends_with("Green: 1 result on 1 device: 1 pass.\n"), "{}", said.out);
}

/// A bit of a number whose lowest byte comes first stands in that byte.
#[test]
fn a_bit_of_the_other_byte_order() {
    let output = "width: 32, little_endian: true, fields: { lowest: 0, ninth: 8 }";
    let expected = "      - set: { given.ninth: 1 }\n      - expect: { io.inputs: \"00 01 00 00 *\" }\n      - set: { given.lowest: 1 }\n      \
                    - expect: { mirrored.both: 0x101 }\n";
    let input = "width: 32, little_endian: true, fields: { both: [0, 8] }";
    let said = run(&manual("form-bit", output, input, expected));
    assert_eq!(said.status, Some(0), "{}", said.all());
}

#[rstest]
#[case("width: 32, float: true", "25.5", "26", "25.5, on the wire 0x41CC0000")]
#[case("width: 32, scale: 0.1", "0x000000EB", "24", "23.5, on the wire 0x000000EB")]
#[case("width: 32, float: true", "0x7FC00000", "1", "unknown")]
#[case("text: 4", "0x41463300", "\"AFM\"", "'AF3'")]
fn a_failure_shows_value_and_number(
    #[case] input: &str,
    #[case] given: &str,
    #[case] expected: &str,
    #[case] observed: &str,
) {
    let output = if given == "25.5" { "width: 32, float: true" } else { "width: 32" };
    let steps = format!("      - set: {{ given: {given} }}\n      - expect: {{ mirrored: {expected} }}\n");
    let said = run(&manual("form-failure", output, input, &steps));
    assert_eq!(said.status, Some(1), "{}", said.all());
    assert!(said.out.contains(&format!("observed {observed}")), "{}", said.out);
}

#[rstest]
#[case("text: 4", "width: 32", "only the device sends texts")]
#[case("width: 16, float: true", "width: 32", "a floating-point number has 32 or 64 bits")]
#[case("width: 32, float: true, fields: { a: 1 }", "width: 32", "a floating-point number has no `fields`")]
#[case("width: 32, float: true, signed: true", "width: 32", "a floating-point number has no `signed`")]
#[case("width: 32, float: true, scale: 2", "width: 32", "this signal is a floating-point number already")]
#[case("width: 32, scale: 0", "width: 32", "times 0 nothing is left")]
#[case("width: 32, zero: 3", "width: 32", "`zero`")]
#[case("width: 32", "text: 4, width: 32", "`text`")]
#[case("width: 32", "text: 4, little_endian: true", "a text begins with its first character")]
fn mistakes(#[case] output: &str, #[case] input: &str, #[case] message: &str) {
    let said = run(&manual("form-mistake", output, input, "      - expect: { io.input_length: 6 }\n"));
    assert_eq!(said.status, Some(2), "{}", said.all());
    assert!(said.err.contains(message) && said.err.contains("device.yaml:"), "{}", said.err);
}

#[test]
fn a_literal_that_does_not_fit() {
    let steps = "      - set: { given: 500000000 }\n      - expect: { io.input_length: 6 }\n";
    let said = run(&manual("form-beyond", "width: 32, scale: 0.1", "width: 32", steps));
    assert_eq!(said.status, Some(2), "{}", said.all());
    assert!(said.err.contains("500000000 is out of range (0 to 429496730)"), "{}", said.err);
}

#[test]
fn a_computed_value_that_does_not_fit() {
    let steps = "      - save: { length: io.input_length }\n      - set: { given: = length * 400000000 }\n      \
                 - expect: { io.input_length: any }\n";
    let said = run(&manual("form-computed", "width: 32, scale: 0.1", "width: 32", steps));
    assert_eq!(said.status, Some(1), "{}", said.all());
    assert!(said.out.contains("does not fit into the 32 bits of `given`"), "{}", said.out);
}
