//! Deviations of station names.

use super::Group;
use super::station_state::NoNameAfterReset;
use crate::needs::Need;
use crate::seams::stack::Stack;
use alloc::vec::Vec;
use device_stack::profinet::StackCheck;
use encoder_profile::encoder_object::names::accepts;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Profinet],
    deviations: bugs! {
        "name-check-total-length-only" "Only the total length of a name is checked."
            => |d| names(&mut d.stack, |name, _| name.len() <= 127);
        "name-check-ascii-missing" "Bytes above 7F are accepted in a name."
            => |d| names(&mut d.stack, |name, right| right || is_name(&with_letters(name, |octet| !octet.is_ascii())));
        "digit-first-refused" "A name whose label begins with a digit is refused."
            => |d| names(&mut d.stack, |name, right| right && !labels(name).any(|label| label.first().is_some_and(u8::is_ascii_digit)));
        "any-character-in-names" "Only the first and the last character of a name are checked."
            => |d| names(&mut d.stack, |name, _| is_name(&with_letters(name, |octet| octet != b'-' && octet != b'.')));
        "empty-labels-accepted" "Empty labels are accepted: a dot at the start or end, or two consecutive dots."
            => |d| names(&mut d.stack, |name, _| name.len() <= 127 && labels(name).all(is_name));
        "number-at-the-end-refused" "A name that ends with a hyphen and a digit is refused."
            => |d| names(&mut d.stack, |name, right| right && !matches!(name, [.., b'-', b'0'..=b'9']));
        "empty-name-refused" "An empty name is refused."
            => |d| names(&mut d.stack, |name, right| right && !name.is_empty());
        "dash-at-the-ends-accepted" "Labels that begin or end with a hyphen are accepted."
            => |d| names(&mut d.stack, |name, _| is_name(&with_letters(name, |octet| octet == b'-')));
        "name-refused-after-reset" "After a factory reset no name is accepted until the next power-up."
            => |d| d.stack.add(NoNameAfterReset::default());
    },
}];

/// Changes whether a name is accepted, given the name and the decision of the device.
fn names(stack: &mut Stack, mut takes: impl FnMut(&[u8], bool) -> bool + 'static) {
    stack.check(move |check, right| match check {
        StackCheck::Name(name) => takes(name, right),
        _ => right,
    });
}

/// Whether a name is valid that is not longer than the shortest limit of a manual.
fn is_name(name: &[u8]) -> bool {
    accepts(name, 127)
}

fn labels(name: &[u8]) -> impl Iterator<Item = &[u8]> {
    name.split(|octet| *octet == b'.')
}

/// Replaces each byte for which `is_replaced` returns `true` by a letter.
fn with_letters(name: &[u8], is_replaced: fn(u8) -> bool) -> Vec<u8> {
    name.iter().map(|octet| if is_replaced(*octet) { b'a' } else { *octet }).collect()
}
