//! The station names that an encoder accepts.
//!
//! XAC77 manual, 7.4.5: at most 127 characters; labels between dots of at most 63; letters, digits and dashes, no
//! other special character; no dash at the beginning or the end. For the DNS rules to which the manual refers: no
//! label is empty, and the dash rule applies to each label. Capital letters are accepted, because the manual does not
//! exclude them. The empty name clears the name.

const LONGEST_NAME: usize = 127;
const LONGEST_LABEL: usize = 63;

/// Whether the encoder accepts `name`.
pub fn accepts(name: &[u8]) -> bool {
    name.is_empty() || name.len() <= LONGEST_NAME && name.split(|byte| *byte == b'.').all(is_label)
}

fn is_label(label: &[u8]) -> bool {
    (1..=LONGEST_LABEL).contains(&label.len())
        && label.iter().all(|byte| byte.is_ascii_alphanumeric() || *byte == b'-')
        && label.first() != Some(&b'-')
        && label.last() != Some(&b'-')
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
    #[case("ger\u{e4}t-1", false)]
    fn names(#[case] name: &str, #[case] accepted: bool) {
        assert_eq!(accepts(name.as_bytes()), accepted);
    }

    #[rstest]
    #[case(&[63], true)]
    #[case(&[64], false)]
    #[case(&[63, 63], true)]
    #[case(&[63, 62, 1], false)]
    #[case(&[42, 42, 41], true)]
    fn lengths(#[case] labels: &[usize], #[case] accepted: bool) {
        let labels: Vec<String> = labels.iter().map(|length| "a".repeat(*length)).collect();
        assert_eq!(accepts(labels.join(".").as_bytes()), accepted);
    }

    #[test]
    fn bytes_above_7f_are_refused_even_if_they_are_no_utf8() {
        assert!(!accepts(&[0x67, 0x65, 0x72, 0xE4, 0x74]));
    }
}
