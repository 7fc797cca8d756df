//! Which octets are a name of station (IEC 61158-6-10, NameOfStationValue: the rules of RFC 5890, narrowed).

/// What is wrong with a name of station; places are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameProblem {
    /// There is no octet; on the wire that means "no name".
    #[error("the name is empty")]
    Empty,
    /// The name is too long.
    #[error("the name has {0} octets, 240 are allowed")]
    TooLong(usize),
    /// Two dots follow each other, or the name begins or ends with one.
    #[error("the label at octet {0} is empty")]
    EmptyLabel(usize),
    /// A label is too long.
    #[error("the label at octet {0} has more than 63 octets")]
    LongLabel(usize),
    /// An octet is none of `a-z`, `0-9`, `-` and `.`.
    #[error("octet {at} is {octet:#04x}, allowed are a-z, 0-9, hyphen and dot")]
    Octet {
        /// Where it stands.
        at: usize,
        /// What it is.
        octet: u8,
    },
    /// A label begins or ends with a hyphen.
    #[error("the label at octet {0} begins or ends with a hyphen")]
    Hyphen(usize),
    /// The name looks like an IPv4 address: four numbers of at most three digits.
    #[error("the name has the form of an IPv4 address")]
    LikeAnAddress,
    /// The first label looks like the name of a port: `port-xyz` or `port-xyz-abcde` in digits.
    #[error("the first label has the form of a port: port-xyz or port-xyz-abcde")]
    LikeAPort,
}

/// Whether `name` may be given to a station.
///
/// An empty name is refused here; on the wire it takes a station's name away.
pub fn check(name: &[u8]) -> Result<(), NameProblem> {
    if name.is_empty() {
        return Err(NameProblem::Empty);
    }
    if name.len() > 240 {
        return Err(NameProblem::TooLong(name.len()));
    }
    let allowed = |octet: &u8| matches!(octet, b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.');
    if let Some((at, &octet)) = name.iter().enumerate().find(|(_, octet)| !allowed(octet)) {
        return Err(NameProblem::Octet { at, octet });
    }
    let labels = || name.split(|&octet| octet == b'.');
    let mut at = 0;
    for label in labels() {
        match label {
            [] => return Err(NameProblem::EmptyLabel(at)),
            _ if label.len() > 63 => return Err(NameProblem::LongLabel(at)),
            [b'-', ..] | [.., b'-'] => return Err(NameProblem::Hyphen(at)),
            _ => at += label.len() + 1,
        }
    }
    if labels().count() == 4 && labels().all(|label| label.len() <= 3 && is_digits(label)) {
        return Err(NameProblem::LikeAnAddress);
    }
    if labels().next().is_some_and(is_port) { Err(NameProblem::LikeAPort) } else { Ok(()) }
}

fn is_digits(octets: &[u8]) -> bool {
    octets.iter().all(u8::is_ascii_digit)
}

fn is_port(label: &[u8]) -> bool {
    let Some(rest) = label.strip_prefix(b"port-") else { return false };
    match rest {
        port if port.len() == 3 => is_digits(port),
        [x, y, z, b'-', slot @ ..] if slot.len() == 5 => is_digits(&[*x, *y, *z]) && is_digits(slot),
        _ => false,
    }
}
