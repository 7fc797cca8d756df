//! Requests and responses byte by byte, and the order of the checks.

use super::*;
use alloc::vec::Vec;
use rstest::rstest;
use wire::profidrive::{ParameterFormat, ParameterResponse};

/// 922: word. 65000: writable double word. 965: byte string. 964: three words. 61000: a string. 1006: two writable
/// words. 1009: three double words, two of them writable.
struct SampleParameters(u64);

impl ParameterStore for SampleParameters {
    fn parameter(&self, number: u16) -> Option<ParameterContent> {
        let (format, shape, writable, values) = match number {
            922 => (ParameterFormat::WORD, ParameterShape::Value, 0..0, alloc::vec![81]),
            964 => (ParameterFormat::WORD, ParameterShape::Array, 0..0, alloc::vec![0x239, 1, 110]),
            965 => (ParameterFormat::OCTET_STRING, ParameterShape::Value, 0..0, alloc::vec![0x3D, 41]),
            1006 => (ParameterFormat::WORD, ParameterShape::Array, 0..2, alloc::vec![self.0 >> 16, self.0 & 0xFFFF]),
            1009 => (ParameterFormat::DOUBLE_WORD, ParameterShape::Array, 0..2, alloc::vec![2, 3, 4]),
            61000 => (ParameterFormat::OCTET_STRING, ParameterShape::Octets, 0..0, b"afm60".map(u64::from).to_vec()),
            65000 => (ParameterFormat::DOUBLE_WORD, ParameterShape::Value, 0..1, alloc::vec![self.0]),
            _ => return None,
        };
        Some(ParameterContent { format, shape, writable, values })
    }

    fn write(&mut self, number: u16, subindex: u16, values: &[u64]) -> Result<(), ErrorNumber> {
        let limits = if number == 1006 { 0..0x8000 } else { 0..1 << 32 };
        if values.iter().any(|value| !limits.contains(value)) {
            return Err(ErrorNumber::LIMIT);
        }
        self.0 = match (number, subindex, values) {
            (1006, 0, &[low, high]) => low << 16 | high,
            (1006, 0, &[low]) => low << 16 | self.0 & 0xFFFF,
            (1006, _, &[high]) => self.0 & !0xFFFF | high,
            (_, _, &[value, ..]) => value,
            _ => self.0,
        };
        Ok(())
    }
}

fn ask(request: &[u8]) -> Result<Vec<u8>, BadRequest> {
    Ok(ParameterManager::default().answer(request, &mut SampleParameters(0x64))?.octets())
}

// Bytes from catalogue BMP-003 to BMP-014 and ERR-001 to ERR-032. 0x39A is 922, 0x3C4 is 964, 0x3C5 is 965, 0xFDE8 is
// 65000.
#[rstest]
#[case::word(&[1, 1, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0], &[1, 1, 1, 1, 0x42, 1, 0, 81])]
#[case::double_word(&[9, 1, 0, 1, 0x10, 1, 0xFD, 0xE8, 0, 0], &[9, 1, 0, 1, 0x43, 1, 0, 0, 0, 0x64])]
#[case::byte_string(&[1, 1, 1, 1, 0x10, 0, 0x03, 0xC5, 0, 0], &[1, 1, 1, 1, 0x0A, 2, 0x3D, 41])]
#[case::two_elements(&[1, 1, 1, 1, 0x10, 2, 0x03, 0xC4, 0, 1], &[1, 1, 1, 1, 0x42, 2, 0, 1, 0, 110])]
#[case::write(&[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x43, 1, 0, 0, 3, 0xE8], &[1, 2, 1, 1])]
#[case::write_by_type(&[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x07, 1, 0, 0, 3, 0xE8], &[1, 2, 1, 1])]
#[case::unknown(&[1, 1, 1, 1, 0x10, 0, 0, 1, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x00])]
#[case::read_only(&[1, 2, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0, 0x42, 1, 0, 82], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x01])]
#[case::past_the_end(&[1, 1, 1, 1, 0x10, 1, 0x03, 0xC4, 0, 3], &[1, 0x81, 1, 1, 0x44, 2, 0, 0x03, 0, 3])]
#[case::over_the_end(&[1, 1, 1, 1, 0x10, 3, 0x03, 0xC4, 0, 1], &[1, 0x81, 1, 1, 0x44, 2, 0, 0x03, 0, 3])]
#[case::no_array(&[1, 1, 1, 1, 0x10, 1, 0x03, 0x9A, 0, 1], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x04])]
#[case::narrow(&[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x42, 1, 0, 5], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x05])]
#[case::write_description(&[1, 2, 1, 1, 0x20, 0, 0xFD, 0xE8, 0, 0, 0x43, 1, 0, 0, 0, 5], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x07])]
#[case::description(&[1, 1, 1, 1, 0x20, 0, 0xFD, 0xE8, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x09])]
#[case::text(&[1, 1, 1, 1, 0x30, 0, 0xFD, 0xE8, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x0F])]
#[case::attribute_0(&[1, 1, 1, 1, 0x00, 0, 0x03, 0x9A, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x16])]
#[case::elements_235(&[1, 1, 1, 1, 0x10, 235, 0x03, 0xC4, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x16])]
#[case::format_ff(&[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0xFF, 1, 0, 0, 0, 5], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x17])]
#[case::two_values(&[1, 2, 1, 1, 0x10, 1, 0xFD, 0xE8, 0, 0, 0x43, 2, 0, 0, 0, 5, 0, 0, 0, 6], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x18])]
#[case::axis(&[1, 1, 5, 1, 0x10, 0, 0x03, 0x9A, 0, 0], &[1, 0x81, 5, 1, 0x44, 1, 0, 0x19])]
#[case::write_text(&[1, 2, 1, 1, 0x30, 0, 0xFD, 0xE8, 0, 0, 0x43, 1, 0, 0, 0, 5], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x20])]
#[case::whole_string(&[1, 1, 1, 1, 0x10, 0, 0xEE, 0x48, 0, 0], &[1, 1, 1, 1, 0x0A, 5, 0x61, 0x66, 0x6D, 0x36, 0x30, 0])]
#[case::part_of_a_string(&[1, 1, 1, 1, 0x10, 3, 0xEE, 0x48, 0, 2], &[1, 1, 1, 1, 0x0A, 3, 0x6D, 0x36, 0x30, 0])]
#[case::over_the_string(&[1, 1, 1, 1, 0x10, 6, 0xEE, 0x48, 0, 0], &[1, 0x81, 1, 1, 0x44, 2, 0, 0x03, 0, 5])]
#[case::two_elements_written(&[1, 2, 1, 1, 0x10, 2, 0x03, 0xEE, 0, 0, 0x42, 2, 0, 5, 0, 6], &[1, 2, 1, 1])]
#[case::fixed_element(&[1, 2, 1, 1, 0x10, 1, 0x03, 0xF1, 0, 2, 0x43, 1, 0, 0, 0, 5], &[1, 0x82, 1, 1, 0x44, 2, 0, 0x01, 0, 2])]
#[case::limit(&[1, 2, 1, 1, 0x10, 1, 0x03, 0xEE, 0, 1, 0x42, 1, 0x80, 0], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x02])]
#[case::request_7f(&[1, 0x7F, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x21])]
#[case::mixed_read(&[1, 1, 1, 2, 0x10, 0, 0x03, 0x9A, 0, 0, 0x10, 0, 0, 1, 0, 0],
                   &[1, 0x81, 1, 2, 0x42, 1, 0, 81, 0x44, 1, 0, 0])]
#[case::mixed_write(&[1, 2, 1, 2, 0x10, 0, 0x03, 0x9A, 0, 0, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x42, 1, 0, 82, 0x43, 1, 0, 0, 0, 5],
                    &[1, 0x82, 1, 2, 0x44, 1, 0, 1, 0x40, 0])]
fn requests(#[case] request: &[u8], #[case] response: &[u8]) {
    assert_eq!(ask(request).as_deref(), Ok(response));
    for length in 0..request.len() {
        // After an unknown format no byte counts as missing; the request is refused nevertheless.
        assert!(ask(&request[..length]).map_or(true, |response| response[1] >= 0x80), "{length} bytes");
    }
    for bit in 0..8 * request.len() {
        let mut flipped = request.to_vec();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let _ = ask(&flipped);
    }
}

#[test]
fn a_refused_parameter_does_not_prevent_writing_the_others() {
    let mut sample = SampleParameters(0x64);
    let request =
        [1, 2, 1, 2, 0x10, 0, 0x03, 0x9A, 0, 0, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x42, 1, 0, 82, 0x43, 1, 0, 0, 0, 5];
    ParameterManager::default().answer(&request, &mut sample).expect("the request is well formed");
    assert_eq!(sample.0, 5);
}

#[rstest]
#[case(0)]
#[case(40)]
#[case(255)]
fn a_wrong_number_of_parameters_is_refused(#[case] count: u8) {
    assert_eq!(ask(&[1, 1, 1, count, 0x10, 0, 0x03, 0x9A, 0, 0]), Err(BadRequest::Count));
}

#[test]
fn the_longest_request_is_answered_in_240_bytes() {
    let mut request = alloc::vec![1, 1, 1, 39];
    (0..39).for_each(|_| request.extend([0x10, 3, 0x03, 0xC4, 0, 0]));
    let response = ask(&request).expect("39 parameters are allowed");
    assert!(response.len() <= MAX_OCTETS);
    let response = ParameterResponse::parse(&response).expect("a valid response");
    let refused = response.values.iter().filter(|value| value.error().is_some()).count();
    assert_eq!((response.values.len(), refused), (39, 19));
    assert!(response.values[38].error().is_some() && response.values[0].error().is_none());
}

#[test]
fn a_response_is_fetched_once_and_by_its_connection() {
    let mut responses = PendingResponses::default();
    assert_eq!(responses.fetch(1), None);
    responses.keep(1, alloc::vec![7]);
    responses.keep(1, alloc::vec![8]);
    assert_eq!(responses.fetch(2), None);
    assert_eq!(responses.fetch(1), Some(alloc::vec![8]));
    assert_eq!(responses.fetch(1), None);
    responses.keep(1, alloc::vec![9]);
    responses.forget(2);
    responses.forget(1);
    assert_eq!(responses.fetch(1), None);
}

// SICK AFS60/AFM60, P1006: two limits, each with its subindex or both at once.
#[test]
fn elements_are_written_by_their_subindex() {
    let mut sample = SampleParameters(0x0007_0008);
    let mut write = |octets: &[u8]| {
        ParameterManager::default().answer(octets, &mut sample).expect("the request is well formed");
        sample.0
    };
    assert_eq!(write(&[1, 2, 1, 1, 0x10, 1, 0x03, 0xEE, 0, 1, 0x42, 1, 0, 9]), 0x0007_0009);
    assert_eq!(write(&[1, 2, 1, 1, 0x10, 2, 0x03, 0xEE, 0, 0, 0x42, 2, 0, 5, 0, 6]), 0x0005_0006);
    assert_eq!(write(&[1, 2, 1, 1, 0x10, 2, 0x03, 0xEE, 0, 0, 0x42, 2, 0, 1, 0xFF, 0xFF]), 0x0005_0006);
}

// Kübler Sendix 58xx: any axis is answered and mirrored.
#[test]
fn any_axis_is_served_if_the_manual_says_so() {
    let request = [1, 1, 0xCD, 1, 0x10, 0, 0x03, 0x9A, 0, 0];
    let manager = ParameterManager { serves_any_axis: true, ..ParameterManager::default() };
    let exchange = manager.answer(&request, &mut SampleParameters(0)).expect("well formed");
    assert_eq!(exchange.octets(), [1, 1, 0xCD, 1, 0x42, 1, 0, 81]);
}

#[cfg(feature = "deviations")]
#[test]
fn a_deviation_flips_a_decision() {
    use crate::profidrive::checks::{AttachedChecks, EncoderCheck, EncoderChecks};
    use alloc::rc::Rc;
    use core::cell::RefCell;

    struct AnyFormat;

    impl EncoderChecks for AnyFormat {
        fn check(&mut self, check: EncoderCheck, verdict: bool) -> bool {
            verdict || matches!(check, EncoderCheck::ValueFormat { .. })
        }
    }

    let checks = AttachedChecks(device_stack::Attached::new(Rc::new(RefCell::new(AnyFormat))));
    let manager = ParameterManager { checks, ..ParameterManager::default() };
    let (mut sample, narrow) = (SampleParameters(0x64), [1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x42, 1, 0, 5]);
    let exchange = manager.answer(&narrow, &mut sample).expect("well formed");
    assert_eq!((exchange.octets(), sample.0), (alloc::vec![1, 2, 1, 1], 5));
}
