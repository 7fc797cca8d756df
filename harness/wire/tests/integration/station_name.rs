//! Valid and invalid station names by the rules of IEC 61158-6-10 (NameOfStationValue), with the examples of the Lika XAC77
//! manual.

use encspec_wire::profinet::dcp::station_name::{NameProblem, check};
use rstest::rstest;

#[rstest]
#[case::digits_and_dots(b"abc-01.line2")]
#[case::one_letter(b"a")]
#[case::one_digit(b"7")]
#[case::appended_number(b"lika-rotacod-1")]
#[case::label_of_63(&[b'a'; 63])]
#[case::three_numbers(b"192.168.0")]
#[case::five_numbers(b"1.2.3.4.5")]
#[case::four_digits(b"1921.168.0.1")]
#[case::an_address_with_a_letter(b"192.168.0.1a")]
#[case::port_of_two_digits(b"port-01")]
#[case::port_of_four_digits(b"port-0001")]
#[case::port_of_letters(b"port-xyz")]
#[case::port_and_short_slot(b"port-001-0001")]
#[case::port_in_the_second_label(b"enc.port-001")]
#[case::hyphens_inside(b"a--b")]
fn a_valid_name_is_accepted(#[case] name: &[u8]) {
    assert_eq!(check(name), Ok(()));
}

#[rstest]
#[case::nothing(b"", NameProblem::Empty)]
#[case::label_of_64(&[b'a'; 64], NameProblem::LongLabel(0))]
#[case::capital(b"Enc", NameProblem::Octet { at: 0, octet: b'E' })]
#[case::parenthesis(b"enc(1)", NameProblem::Octet { at: 3, octet: b'(' })]
#[case::underscore(b"enc_1", NameProblem::Octet { at: 3, octet: b'_' })]
#[case::slash(b"enc/1", NameProblem::Octet { at: 3, octet: b'/' })]
#[case::backslash(b"enc\\1", NameProblem::Octet { at: 3, octet: b'\\' })]
#[case::space(b"enc 1", NameProblem::Octet { at: 3, octet: b' ' })]
#[case::colon(b"a:b", NameProblem::Octet { at: 1, octet: b':' })]
#[case::zero(b"ab\0", NameProblem::Octet { at: 2, octet: 0 })]
#[case::umlaut("ger\u{e4}t-1".as_bytes(), NameProblem::Octet { at: 3, octet: 0xc3 })]
#[case::umlaut_latin_1(b"ger\xe4t-1", NameProblem::Octet { at: 3, octet: 0xe4 })]
#[case::format_string(b"%n%n%n ", NameProblem::Octet { at: 0, octet: b'%' })]
#[case::leading_hyphen(b"-enc", NameProblem::Hyphen(0))]
#[case::trailing_hyphen(b"enc-", NameProblem::Hyphen(0))]
#[case::lone_hyphen(b"-", NameProblem::Hyphen(0))]
#[case::hyphen_before_a_dot(b"enc.a-.b", NameProblem::Hyphen(4))]
#[case::empty_label(b"a..b", NameProblem::EmptyLabel(2))]
#[case::leading_dot(b".a", NameProblem::EmptyLabel(0))]
#[case::trailing_dot(b"a.", NameProblem::EmptyLabel(2))]
#[case::an_address(b"192.168.0.1", NameProblem::LikeAnAddress)]
#[case::no_address_but_its_form(b"999.0.00.000", NameProblem::LikeAnAddress)]
#[case::port(b"port-001", NameProblem::LikeAPort)]
#[case::port_and_slot(b"port-001-00001", NameProblem::LikeAPort)]
#[case::port_in_the_first_label(b"port-001.enc", NameProblem::LikeAPort)]
fn an_invalid_name_is_rejected_with_its_reason(#[case] name: &[u8], #[case] problem: NameProblem) {
    assert_eq!(check(name), Err(problem));
}

#[rstest]
#[case(127, Ok(()))]
#[case(240, Ok(()))]
#[case(241, Err(NameProblem::TooLong(241)))]
fn the_length_of_the_whole_name_is_limited(#[case] length: usize, #[case] outcome: Result<(), NameProblem>) {
    let name: Vec<u8> = (1..=length).map(|at| if at % 60 == 0 && at < length - 1 { b'.' } else { b'a' }).collect();
    assert_eq!(check(&name), outcome);
}

/// Checks every byte value in the middle of a name.
#[test]
fn only_letters_digits_hyphen_and_dot_are_allowed() {
    let allowed: Vec<u8> = (0..=u8::MAX).filter(|octet| check(&[b'a', *octet, b'a']).is_ok()).collect();
    assert_eq!(allowed, b"-.0123456789abcdefghijklmnopqrstuvwxyz");
}
