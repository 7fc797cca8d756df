//! Parameter access against the examples in manuals and against tshark.
#![allow(clippy::unwrap_used, reason = "an unwrap fails the test")]

use crate::round_trip::written;
use encspec_wire::profidrive::{
    Attribute, ErrorNumber, ParameterAddress, ParameterError, ParameterFormat, ParameterRequest, ParameterResponse,
    ParameterValue, RequestHeader, RequestId, ResponseId,
};
use rstest::rstest;
use std::fmt::Write as _;
use testing::hex as octets;

/// SICK AFS60/AFM60 PROFINET manual, tables 29 and 31 (which prints five bytes for the four of the value).
#[rstest]
#[case::table_29("01 01 00 01 10 00 FDE8 0000", ParameterRequest::read_values(1, 0, vec![ParameterAddress::value(65000, 0)]))]
#[case::table_31(
    "01 02 00 01 10 00 FDE8 0000 43 01 00000064",
    ParameterRequest::change_values(1, 0, vec![(ParameterAddress::value(65000, 0), ParameterValue::numbers(ParameterFormat::DOUBLE_WORD, &[100]))])
)]
fn requests_of_the_sick_manual(#[case] printed: &str, #[case] request: ParameterRequest) {
    assert_eq!(written(|out| request.write(out)), octets(printed));
    assert_eq!(ParameterRequest::parse(&octets(printed)), Ok(request));
}

/// The same manual, tables 30 and 32.
#[rstest]
#[case::table_30("01 01 00 01 43 01 00000064", RequestId::REQUEST, &[100])]
#[case::table_32("01 02 00 01", RequestId::CHANGE, &[])]
fn responses_of_the_sick_manual(#[case] printed: &str, #[case] id: RequestId, #[case] values: &[u64]) {
    let header = RequestHeader { reference: 1, id, do_id: 0, parameter_count: 1 };
    let response = match id {
        RequestId::REQUEST => {
            ParameterResponse::to_read(&header, vec![ParameterValue::numbers(ParameterFormat::DOUBLE_WORD, values)])
        }
        _ => ParameterResponse::to_change(&header, &[Ok(())]),
    };
    assert_eq!(written(|out| response.write(out)), octets(printed));
    let parsed = ParameterResponse::parse(&octets(printed)).unwrap();
    assert_eq!(parsed, response);
    assert!(!parsed.header.id.is_negative());
    assert_eq!(parsed.values.first().and_then(ParameterValue::to_number), values.first().map(|value| *value as i64));
}

/// Kübler Sendix 58xx manual, 9.2: the manual prints each pair of single bytes swapped; this follows its list of fields.
#[test]
fn request_of_the_kuebler_manual() {
    let mut printed = octets("02 AB 01 CD 00 10 FD E8 00 00 01 43 00 00 12 34");
    for pair in [0, 2, 4, 10] {
        printed.swap(pair, pair + 1);
    }
    let request = ParameterRequest::parse(&printed).unwrap();
    assert_eq!(
        request.header,
        RequestHeader { reference: 0xAB, id: RequestId::CHANGE, do_id: 0xCD, parameter_count: 1 }
    );
    assert_eq!(
        request.addresses,
        [ParameterAddress { attribute: Attribute::VALUE, element_count: 0, number: 65000, subindex: 0 }]
    );
    assert_eq!(request.values, [ParameterValue::numbers(ParameterFormat::DOUBLE_WORD, &[0x1234])]);
    assert_eq!(written(|out| request.write(out)), printed);
}

/// Fields with the names of tshark.
#[derive(Default)]
struct ParameterLine(Vec<(&'static str, Vec<u64>)>);

impl ParameterLine {
    fn put(&mut self, field: &'static str, value: impl Into<u64>) {
        match self.0.iter_mut().find(|(name, _)| *name == field) {
            Some((_, values)) => values.push(value.into()),
            None => self.0.push((field, vec![value.into()])),
        }
    }

    fn values(&mut self, values: &[ParameterValue]) {
        for value in values {
            self.put("format", value.format.0);
            self.put("no_of_values", value.count);
            if let Some(error) = value.error() {
                self.put("error_num", error.number.0);
                error.subindex.into_iter().for_each(|subindex| self.put("error_subindex", subindex));
                continue;
            }
            let field = match value.format {
                ParameterFormat::BYTE => "value_b",
                ParameterFormat::WORD => "value_w",
                _ => "value_dw",
            };
            value.to_numbers().into_iter().flatten().for_each(|number| self.put(field, number));
        }
    }

    /// The line that `parameter.py` writes: fields in the order of its table.
    fn line(mut self) -> String {
        const ORDER: [&str; 16] = [
            "request_reference",
            "request_id",
            "response_id",
            "do",
            "no_of_parameters",
            "attribute",
            "no_of_elems",
            "number",
            "index",
            "format",
            "no_of_values",
            "value_b",
            "value_w",
            "value_dw",
            "error_num",
            "error_subindex",
        ];
        self.0.sort_by_key(|(name, _)| ORDER.iter().position(|other| other == name));
        let mut line = String::new();
        for (name, values) in self.0 {
            let values: Vec<String> = values.iter().map(|value| format!("{value:#x}")).collect();
            write!(line, " {name}={}", values.join(",")).unwrap();
        }
        line
    }
}

fn parsed_line(data: &[u8], is_request: bool) -> (String, Vec<u8>) {
    let mut reading = ParameterLine::default();
    let back = if is_request {
        let request = ParameterRequest::parse(data).unwrap();
        reading.put("request_reference", request.header.reference);
        reading.put("request_id", request.header.id.0);
        reading.put("do", request.header.do_id);
        reading.put("no_of_parameters", request.header.parameter_count);
        for address in &request.addresses {
            reading.put("attribute", address.attribute.0);
            reading.put("no_of_elems", address.element_count);
            reading.put("number", address.number);
            reading.put("index", address.subindex);
        }
        reading.values(&request.values);
        assert_eq!(request.rest, [], "nothing is left");
        written(|out| request.write(out))
    } else {
        let response = ParameterResponse::parse(data).unwrap();
        reading.put("request_reference", response.header.reference);
        reading.put("response_id", response.header.id.0);
        reading.put("do", response.header.do_id);
        reading.put("no_of_parameters", response.header.parameter_count);
        reading.values(&response.values);
        assert_eq!(response.rest, [], "nothing is left");
        written(|out| response.write(out))
    };
    (reading.line(), back)
}

#[test]
fn data_are_parsed_like_tshark() {
    let lines = include_str!("../golden/tshark-parameter.txt").lines().filter(|line| !line.starts_with('#'));
    let mut compared = 0;
    for line in lines {
        let mut parts = line.splitn(3, ' ');
        let (name, hex, fields) = (parts.next().unwrap(), parts.next().unwrap(), parts.next().unwrap());
        let data = octets(hex);
        let (reading, back) = parsed_line(&data, fields.contains("request_id="));
        assert_eq!(reading.trim_start(), fields, "{name}");
        assert_eq!(back, data, "{name}");
        compared += 1;
    }
    assert_eq!(compared, 16, "all lines of the file were compared");
}

/// A change of two parameters of which one is refused: the entries are those that tshark dissects as formats 40 and 44.
#[test]
fn a_partly_refused_change() {
    let request = RequestHeader { reference: 0x0A, id: RequestId::CHANGE, do_id: 1, parameter_count: 2 };
    let refused = ParameterError { number: ErrorNumber::READ_ONLY, subindex: None };
    let response = ParameterResponse::to_change(&request, &[Ok(()), Err(refused)]);
    assert_eq!(written(|out| response.write(out)), octets("0A 82 01 02 40 00 44 01 0001"));
    assert_eq!(response.header.id, ResponseId::CHANGE_FAILED);
    assert_eq!(response.values[1].error(), Some(refused));
}

/// The profile pads an odd number of bytes with zero, so every entry starts at a word boundary.
#[rstest]
#[case::one_byte(ParameterValue::numbers(ParameterFormat::BYTE, &[0x7F]), "41 01 7F 00")]
#[case::two_bytes(ParameterValue::numbers(ParameterFormat::UNSIGNED8, &[1, 2]), "05 02 01 02")]
#[case::string(ParameterValue::new(ParameterFormat::VISIBLE_STRING, 3, b"abc".to_vec()), "09 03 61 62 63 00")]
#[case::date(ParameterValue::new(ParameterFormat::DATE, 1, vec![1, 2, 3, 4, 5, 6, 7]), "32 01 01 02 03 04 05 06 07 00")]
fn entries_start_at_word_boundaries(#[case] value: ParameterValue, #[case] encoded: &str) {
    let expected = octets(&format!("01 81 00 02 {encoded} 44 01 0000"));
    let request = RequestHeader { reference: 1, id: RequestId::REQUEST, do_id: 0, parameter_count: 2 };
    let unknown = ParameterValue::refused(ParameterError { number: ErrorNumber::UNKNOWN_PARAMETER, subindex: None });
    let response = ParameterResponse::to_read(&request, vec![value, unknown]);
    assert_eq!(written(|out| response.write(out)), expected);
    assert_eq!(ParameterResponse::parse(&expected), Ok(response));
}

/// Widths from the profile's table of data types; two's complement from the value range of the type.
#[rstest]
#[case(ParameterFormat::INTEGER8, "FE", -2)]
#[case(ParameterFormat::INTEGER16, "FFFE", -2)]
#[case(ParameterFormat::INTEGER32, "FFFFFFFE", -2)]
#[case(ParameterFormat::INTEGER64, "FFFFFFFFFFFFFFFE", -2)]
#[case(ParameterFormat::UNSIGNED8, "FE", 0xFE)]
#[case(ParameterFormat::UNSIGNED16, "FFFE", 0xFFFE)]
#[case(ParameterFormat::UNSIGNED32, "FFFFFFFE", 0xFFFF_FFFE)]
#[case(ParameterFormat::N2, "C000", -0x4000)]
#[case(ParameterFormat::N4, "C0000000", -0x4000_0000)]
#[case(ParameterFormat::V2, "C000", 0xC000)]
#[case(ParameterFormat::BOOLEAN, "01", 1)]
#[case(ParameterFormat::TIME_OF_DAY_WITHOUT_DATE, "00000010", 16)]
#[case(ParameterFormat::TIME_DIFFERENCE_WITH_DATE, "000000100001", 0x0010_0001)]
fn numbers_of_each_width(#[case] format: ParameterFormat, #[case] hex: &str, #[case] number: i64) {
    let value = ParameterValue::new(format, 1, octets(hex));
    assert_eq!(value.to_number(), Some(number));
    assert_eq!(ParameterValue::numbers(format, &[number as u64]), value);
}

/// Invalid requests, which a device must parse in order to refuse them, and which a test case builds.
#[rstest]
#[case::axis_and_attribute("01 01 05 01 F0 EB 039A 0000")]
#[case::request_id("01 7F 00 01 10 00 039A 0000")]
#[case::no_parameter("01 01 00 00 10 00 039A 0000")]
#[case::bytes_after_the_addresses("01 01 00 01 10 00 039A 0000 43 01 00000064")]
#[case::unknown_format("01 02 00 02 10 00 FDE8 0000 10 00 FDE8 0000 4F 01 00000064 43 01 00000064")]
#[case::padding_not_zero("01 02 00 01 10 00 03E8 0000 41 01 7F FF")]
#[case::padding_missing("01 02 00 01 10 00 03E8 0000 41 01 7F")]
fn invalid_requests_are_preserved(#[case] hex: &str) {
    let data = octets(hex);
    assert_eq!(written(|out| ParameterRequest::parse(&data).unwrap().write(out)), data);
}

#[rstest]
#[case::three_bytes("01 01 00", 3)]
#[case::second_address_missing("01 01 00 02 10 00 039A 0000", 10)]
#[case::values_missing("01 02 00 01 10 00 FDE8 0000 43 02 00000064", 12)]
fn the_error_for_missing_bytes_has_their_offset(#[case] hex: &str, #[case] at: usize) {
    let error = ParameterRequest::parse(&octets(hex)).unwrap_err().to_string();
    assert!(error.starts_with(&format!("PROFIdrive parameter request: byte {at}:")), "{error}");
}

#[test]
fn counts_can_be_set_to_invalid_values() {
    let mut request = ParameterRequest::read_values(1, 0, vec![ParameterAddress::value(922, 0)]);
    request.header.parameter_count = 40;
    request.addresses[0].element_count = 235;
    assert_eq!(written(|out| request.write(out)), octets("01 01 00 28 10 EB 039A 0000"));
}

/// Numbers of the profile's table of error numbers; the words are those of the suites.
#[rstest]
#[case(0x00, "unknown_parameter")]
#[case(0x01, "read_only")]
#[case(0x02, "limit")]
#[case(0x03, "no_such_subindex")]
#[case(0x04, "no_array")]
#[case(0x05, "wrong_type")]
#[case(0x16, "bad_address")]
#[case(0x17, "bad_format")]
#[case(0x19, "no_such_axis")]
fn error_numbers_and_their_words(#[case] number: u16, #[case] word: &str) {
    assert_eq!(ErrorNumber(number).word(), Some(word));
    assert_eq!(ErrorNumber::by_word(word), Some(ErrorNumber(number)));
}
