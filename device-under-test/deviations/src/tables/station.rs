//! Deviations of station names.

use super::Group;
use super::station_memory::NoNameAfterReset;
use crate::needs::Need;
use crate::seams::stack::Stack;
use alloc::vec::Vec;
use device_stack::profinet::StackCheck;
use encoder_profile::encoder_object::names::accepts;

/// The deviations, by what they need of a device.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Profinet, Need::EncoderProfile],
    deviations: bugs! {
        "name-check-total-length-only" "Only the total length of a name is checked."
            => |d| names(&mut d.stack, |name, _| name.len() <= 127);
        "name-check-ascii-missing" "Octets above 7F are accepted in a name."
            => |d| names(&mut d.stack, |name, right| right || accepts(&with_letters(name, |octet| !octet.is_ascii())));
        "digit-first-refused" "A name whose label begins with a digit is refused."
            => |d| names(&mut d.stack, |name, right| right && !labels(name).any(|label| label.first().is_some_and(u8::is_ascii_digit)));
        "any-character-in-names" "Of a name the first and the last character alone are looked at."
            => |d| names(&mut d.stack, |name, _| accepts(&with_letters(name, |octet| octet != b'-' && octet != b'.')));
        "empty-labels-accepted" "A name may begin with a dot, end with one, and have two in a row."
            => |d| names(&mut d.stack, |name, _| name.len() <= 127 && labels(name).all(accepts));
        "number-at-the-end-refused" "A name that ends in a dash and a digit is refused."
            => |d| names(&mut d.stack, |name, right| right && !matches!(name, [.., b'-', b'0'..=b'9']));
        "empty-name-refused" "An empty name is refused."
            => |d| names(&mut d.stack, |name, right| right && !name.is_empty());
        "dash-at-the-ends-accepted" "A label may begin and end with a dash."
            => |d| names(&mut d.stack, |name, _| accepts(&with_letters(name, |octet| octet == b'-')));
        "name-refused-after-reset" "After a factory reset no name is taken until the next power-on."
            => |d| d.stack.add(NoNameAfterReset::default());
    },
}];

/// Decides about names otherwise: from the name and what the device has decided.
fn names(stack: &mut Stack, mut takes: impl FnMut(&[u8], bool) -> bool + 'static) {
    stack.check(move |check, right| match check {
        StackCheck::Name(name) => takes(name, right),
        _ => right,
    });
}

fn labels(name: &[u8]) -> impl Iterator<Item = &[u8]> {
    name.split(|octet| *octet == b'.')
}

/// The name with a letter in the place of each octet that `is_replaced`.
fn with_letters(name: &[u8], is_replaced: fn(u8) -> bool) -> Vec<u8> {
    name.iter().map(|octet| if is_replaced(*octet) { b'a' } else { *octet }).collect()
}
