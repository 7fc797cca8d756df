//! Validation of station names (IEC 61158-6-10, NameOfStationValue: the rules of RFC 5890 with restrictions).

/// Why a station name is invalid; offsets count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameProblem {
    /// The name is empty; on the wire this means "no name".
    #[error("the name is empty")]
    Empty,
    /// The name is too long.
    #[error("the name has {0} bytes, at most 240 are allowed")]
    TooLong(usize),
    /// Two consecutive dots, or a dot at the start or end of the name.
    #[error("the label at byte {0} is empty")]
    EmptyLabel(usize),
    /// A label is too long.
    #[error("the label at byte {0} has more than 63 bytes")]
    LongLabel(usize),
    /// A byte is not one of `a-z`, `0-9`, `-` and `.`.
    #[error("byte {at} is {octet:#04x}, allowed are a-z, 0-9, hyphen and dot")]
    Octet {
        /// Its offset.
        at: usize,
        /// The byte.
        octet: u8,
    },
    /// A label starts or ends with a hyphen.
    #[error("the label at byte {0} starts or ends with a hyphen")]
    Hyphen(usize),
    /// The name has the form of an IPv4 address: four numbers of at most three digits.
    #[error("the name has the form of an IPv4 address")]
    LikeAnAddress,
    /// The first label has the form of a port name: `port-xyz` or `port-xyz-abcde` in digits.
    #[error("the first label has the form of a port: port-xyz or port-xyz-abcde")]
    LikeAPort,
}

/// Checks whether `name` may be assigned to a station.
///
/// An empty name is invalid here; on the wire it deletes the name of a station.
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
