//! Bugs of station names.

use super::Deviation;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = encoder_bugs! {
    "name-check-total-length-only" "Only the total length of a name is checked."
        => |b| b.names.checks_labels = false;
    "name-check-ascii-missing" "Octets above 7F are accepted in a name."
        => |b| b.names.is_allowed = |octet| octet.is_ascii_alphanumeric() || octet == b'-' || !octet.is_ascii();
    "digit-first-refused" "A name whose label begins with a digit is refused."
        => |b| b.names.may_begin = |octet| octet != b'-' && !octet.is_ascii_digit();
    "any-character-in-names" "Of a name the first and the last character alone are looked at."
        => |b| b.names.is_allowed = |_| true;
    "empty-labels-accepted" "A name may begin with a dot, end with one, and have two in a row."
        => |b| b.names.shortest_label = 0;
    "number-at-the-end-refused" "A name that ends in a dash and a digit is refused."
        => |b| b.names.last_word = |name, is_right| is_right && !matches!(name, [.., b'-', b'0'..=b'9']);
    "empty-name-refused" "An empty name is refused."
        => |b| b.names.last_word = |name, is_right| is_right && !name.is_empty();
    "dash-at-the-ends-accepted" "A label may begin and end with a dash."
        => |b| (b.names.may_begin, b.names.may_end) = (|_| true, |_| true);
};

/// The bugs of this seam that not all manuals have.
pub static OTHERS: &[Deviation] = encoder_bugs! {
    "name-refused-after-reset" "After a factory reset no name is taken until the next power-on."
        => |b| b.names.takes_after_reset = false;
};
