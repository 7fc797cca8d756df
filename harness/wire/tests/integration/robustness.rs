//! Every prefix, flipped bits and overwritten bytes of whole records and alarms; every parsed result can be written again.
#![allow(clippy::unwrap_used, reason = "an unwrap fails the test")]

use crate::round_trip::try_hard;
use encspec_wire::octets::ByteReader;
use encspec_wire::profidrive::{ParameterRequest, ParameterResponse, ParameterValue};
use encspec_wire::profinet::alarm::RtaPdu;
use encspec_wire::profinet::blocks::identification::{ApiData, IdentificationData};
use encspec_wire::profinet::blocks::im::{Im0, ImText};
use encspec_wire::profinet::blocks::module_diff::ModuleDiffBlock;
use encspec_wire::profinet::diagnosis::DiagnosisData;
use rstest::rstest;
use testing::{every_prefix_and_flip, golden, hex};

/// The lines `name hex ...` of a golden file.
fn lines(text: &'static str) -> impl Iterator<Item = (&'static str, Vec<u8>)> {
    text.lines().filter(|line| !line.starts_with('#')).map(|line| {
        let mut parts = line.split(' ');
        (parts.next().unwrap(), hex(parts.next().unwrap()))
    })
}

#[test]
fn alarms() {
    let alarms = golden("scapy-alarm.txt").into_iter().filter(|(name, _)| !name.starts_with("im"));
    for (_, octets) in alarms {
        try_hard(&octets, RtaPdu::parse, RtaPdu::write);
    }
}

#[test]
fn parameter_requests_and_responses() {
    for (name, octets) in lines(include_str!("../golden/tshark-parameter.txt")) {
        if ParameterRequest::parse(&octets).is_ok_and(|request| request.rest.is_empty()) {
            try_hard(&octets, ParameterRequest::parse, ParameterRequest::write);
        }
        if ParameterResponse::parse(&octets).is_ok_and(|response| response.rest.is_empty()) {
            try_hard(&octets, ParameterResponse::parse, ParameterResponse::write);
        }
        every_prefix_and_flip(&octets, |octets| {
            let request = ParameterRequest::parse(octets).map(|request| request.values).unwrap_or_default();
            let response = ParameterResponse::parse(octets).map(|response| response.values).unwrap_or_default();
            for value in request.iter().chain(&response) {
                let _ = (value.error(), value.to_numbers(), ParameterValue::to_number(value), name);
            }
        });
    }
}

#[rstest]
#[case::im0("im0")]
fn im0(#[case] name: &str) {
    let octets = golden("scapy-alarm.txt").into_iter().find(|(other, _)| other == name).unwrap().1;
    try_hard(&octets, Im0::parse, Im0::write);
}

#[rstest]
#[case("im1")]
#[case("im2")]
#[case("im3")]
#[case("im4")]
fn im_texts(#[case] name: &str) {
    let octets = golden("scapy-alarm.txt").into_iter().find(|(other, _)| other == name).unwrap().1;
    try_hard(&octets, ImText::parse, ImText::write);
}

#[test]
fn module_diff() {
    let octets = hex("8104 0024 0100 0001 00003d00 0001 0001 00000007 0002 0002 0001 00000001 8040 0002 00000051 9800");
    try_hard(&octets, ModuleDiffBlock::parse, ModuleDiffBlock::write);
}

#[rstest]
#[case::version_1_0("0013 0012 0100 0001 0001 00000007 0001 0001 00000008")]
#[case::version_1_1("0012 001e 0101 0001 00003d00 0001 0001 00000007 0002 0001 00000008 0002 00000009")]
#[case::filter("0030 0018 0100 0001 00003d00 0001 0001 00000007 0001 0001 00000008")]
fn identification(#[case] octets: &str) {
    let parse = |octets: &[u8]| IdentificationData::read(&mut ByteReader::new("identification", octets));
    try_hard(&hex(octets), parse, IdentificationData::write);
    every_prefix_and_flip(&hex(octets), |octets| drop(IdentificationData::parse_record(octets)));
}

#[test]
fn api_data() {
    try_hard(&hex("001a 000c 0100 0002 00000000 00003d00"), ApiData::parse, ApiData::write);
}

#[rstest]
#[case::channels("0010 0018 0100 0001 0002 8000 0800 8000 8000 0800 9000 8000 0A00 9005")]
#[case::extended("0010 001c 0101 00000000 0000 8002 8000 0800 8002 8000 0800 8001 8000 00000000")]
#[case::qualified("0010 0020 0101 00000000 0000 8002 8000 0800 8003 8000 0e00 8001 8000 00000000 00000080")]
#[case::vendor("0010 0010 0100 0001 0002 8000 0800 0001 aabbccdd")]
#[case::nested(
    "0010 0026 0100 0001 0002 8000 0800 8001 0010 0016 0101 00003d00 0001 0002 8000 0800 8000 8000 0800 9000"
)]
fn diagnosis(#[case] octets: &str) {
    fn parse(octets: &[u8]) -> encspec_wire::Result<DiagnosisData> {
        DiagnosisData::read(&mut ByteReader::new("diagnosis", octets))
    }
    try_hard(&hex(octets), parse, DiagnosisData::write);
    every_prefix_and_flip(&hex(octets), |octets| drop(DiagnosisData::parse_record(octets)));
}

/// Deeply nested items and blocks must not overflow the stack.
#[test]
fn nesting_is_limited() {
    let mut record = Vec::new();
    for _ in 0..4000 {
        let mut outer = hex("0010 0000 0100 0001 0002 8000 0800 8001");
        outer.extend(&record);
        let length = (outer.len() - 4).min(0xFFFF) as u16;
        outer[2..4].copy_from_slice(&length.to_be_bytes());
        record = outer;
        if length > 0xFF00 {
            break;
        }
    }
    assert_eq!(DiagnosisData::parse_record(&record).unwrap().len(), 1);
}
