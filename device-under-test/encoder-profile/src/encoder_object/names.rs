//! The station names that an encoder accepts.
//!
//! The rules of PROFINET hold; a manual may limit the length further (XAC77, 7.4.5: at most 127 characters). The empty name clears
//! the name.

use wire::profinet::dcp::station_name;

/// Whether an encoder whose names have at most `longest` characters accepts `name`.
pub fn accepts(name: &[u8], longest: usize) -> bool {
    name.is_empty() || name.len() <= longest && station_name::check(name).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::String;
    use alloc::vec::Vec;
    use rstest::rstest;

    // Catalogue DCP-011 to DCP-025.
    #[rstest]
    #[case("", true)]
    #[case("enc-1", true)]
    #[case("abc-01.line2", true)]
    #[case("lika-rotacod-1", true)]
    #[case("1", true)]
    #[case("enc(1)", false)]
    #[case("enc_1", false)]
    #[case("enc/1", false)]
    #[case("enc\\1", false)]
    #[case("enc 1", false)]
    #[case("enc ", false)]
    #[case("a:b", false)]
    #[case("-enc", false)]
    #[case("enc-", false)]
    #[case("a-.b", false)]
    #[case("a..b", false)]
    #[case(".a", false)]
    #[case("a.", false)]
    #[case("Enc", false)]
    #[case("port-001", false)]
    #[case("1.2.3.4", false)]
    #[case("ger\u{e4}t-1", false)]
    fn names(#[case] name: &str, #[case] accepted: bool) {
        assert_eq!(accepts(name.as_bytes(), 127), accepted);
    }

    #[rstest]
    #[case(&[63], true)]
    #[case(&[64], false)]
    #[case(&[63, 63], true)]
    #[case(&[63, 62, 1], false)]
    #[case(&[42, 42, 41], true)]
    fn lengths(#[case] labels: &[usize], #[case] accepted: bool) {
        let labels: Vec<String> = labels.iter().map(|length| "a".repeat(*length)).collect();
        assert_eq!(accepts(labels.join(".").as_bytes(), 127), accepted);
    }

    #[test]
    fn bytes_above_7f_are_refused_even_if_they_are_no_utf8() {
        assert!(!accepts(&[0x67, 0x65, 0x72, 0xE4, 0x74], 127));
    }
}
