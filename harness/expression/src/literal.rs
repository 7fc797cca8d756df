//! Parses the literals of each type as a suite writes them.

use super::{BytePattern, ExprError, Number, Type, Value};
use std::sync::Arc;
use std::time::Duration;

/// A length of time, as a duration or a number of bus cycles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DurationLiteral {
    Time(Duration),
    /// A number of cycles.
    Cycles(u64),
}

/// Nanoseconds of each unit of time.
const UNITS: [(&str, i128); 5] =
    [("ns", 1), ("us", 1_000), ("ms", 1_000_000), ("s", 1_000_000_000), ("min", 60_000_000_000)];

const DURATION_HELP: &str =
    "write a duration as `200ms`, `2s`, `50 cycles` or `0`; the units are ns, us, ms, s, min and cycles";

/// Parses a number: `4096`, `0x1F`, `-12`, `11.25`.
pub fn number(text: &str) -> Result<Number, ExprError> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let offset = text.len() - digits.len();
    let shifted = |mut error: ExprError| {
        error.span = error.span.start + offset..error.span.end + offset;
        error
    };
    let (number, unit) = quantity(digits).map_err(shifted)?;
    match unit {
        "" if offset == 1 => Ok(number.negated()),
        "" => Ok(number),
        _ => Err(ExprError::new(0..text.len(), format!("`{text}` is not a number"))
            .help("write it as 4096, 0x1F, -12 or 11.25")),
    }
}

/// Parses a duration: `200ms`, `2s`, `50 cycles`, `0`. It is never negative.
pub fn duration(text: &str) -> Result<DurationLiteral, ExprError> {
    let all = 0..text.len();
    let wrong = |message: &str| ExprError::new(all.clone(), format!("`{text}` {message}")).help(DURATION_HELP);
    if text == "0" {
        return Ok(DurationLiteral::Time(Duration::ZERO));
    }
    if let Some(count) = text.strip_suffix(" cycles") {
        let count = number(count)?.as_whole().and_then(|count| u64::try_from(count).ok());
        return count.map(DurationLiteral::Cycles).ok_or_else(|| wrong("is not a whole number of cycles"));
    }
    let Ok((amount, unit)) = quantity(text) else { return Err(wrong("is not a duration")) };
    if unit.is_empty() {
        return Err(wrong("has no unit"));
    }
    let nanos = amount.times(Number::whole(unit_of_time(unit, 0..text.len())?));
    let nanos = nanos.and_then(Number::as_whole).and_then(|nanos| u64::try_from(nanos).ok());
    nanos
        .map(|nanos| DurationLiteral::Time(Duration::from_nanos(nanos)))
        .ok_or_else(|| wrong("is not a whole number of nanoseconds in range"))
}

/// Parses bytes without wildcards: `80 00 12 34`.
pub fn bytes(text: &str) -> Result<Vec<u8>, ExprError> {
    let open = || ExprError::new(0..text.len(), "`..` and `*` are allowed in checks only").help("write every byte");
    pattern(text)?.exact().ok_or_else(open)
}

/// Parses bytes with wildcards: `80 .. 12 *`.
pub fn pattern(text: &str) -> Result<BytePattern, ExprError> {
    BytePattern::parse(text)
}

/// Parses an IPv4 address: `192.168.0.10`.
pub fn address(text: &str) -> Result<[u8; 4], ExprError> {
    text.parse::<std::net::Ipv4Addr>().map(|address| address.octets()).map_err(|_| {
        ExprError::new(0..text.len(), format!("`{text}` is not an address"))
            .help("write four decimal numbers from 0 to 255: 192.168.0.10")
    })
}

/// Parses a literal of the type `ty`; a set is parsed word by word, as a [`Type::Word`].
///
/// Bytes with wildcards become a [`Value::Pattern`], which is allowed in checks only.
pub fn literal(text: &str, ty: &Type) -> Result<Value, ExprError> {
    let wrong = |message: String| ExprError::new(0..text.len(), message);
    match ty {
        Type::Number(kind) => {
            let value = number(text)?;
            if kind.whole && !value.is_whole() {
                return Err(wrong(format!("expected {ty}, found the fraction `{text}`")).help("write a whole number"));
            }
            outside(kind.limits, value).map_or(Ok(Value::Number(value)), |limits| Err(wrong(limits)))
        }
        Type::Place(_) => match number(text)?.as_whole() {
            Some(at) if at >= 0 => Ok(Value::whole(at)),
            _ => Err(wrong(format!("`{text}` is not a position"))
                .help("a position is a whole number from 0 to the range minus 1")),
        },
        Type::Bit => match text {
            "0" => Ok(Value::Bit(false)),
            "1" => Ok(Value::Bit(true)),
            _ => Err(wrong(format!("`{text}` is not a bit")).help("write 0 or 1")),
        },
        Type::Time | Type::Cycles => match (duration(text)?, ty) {
            (DurationLiteral::Time(time), Type::Time) => Ok(Value::nanos(i128::from(super::number::nanos(time)))),
            (DurationLiteral::Cycles(cycles), Type::Cycles) => Ok(Value::Cycles(Number::whole(cycles.into()))),
            (DurationLiteral::Time(Duration::ZERO), _) => Ok(Value::Cycles(Number::ZERO)),
            _ => Err(wrong(format!("`{text}` is not {ty}")).help("a number of cycles is not a duration")),
        },
        Type::Text if text.starts_with('=') => {
            Err(wrong("a text cannot begin with `=`".to_owned()).help("`=` begins an expression"))
        }
        Type::Text => Ok(Value::text(text)),
        Type::Bytes => Ok(bytes_or_pattern(pattern(text)?)),
        Type::Address => Ok(Value::Address(address(text)?)),
        Type::Word(table) | Type::Set(table) => table.number(text).map(Value::Word).ok_or_else(|| {
            let nearest = plain_text::nearest(text, table.iter());
            let error = wrong(format!("`{text}` is not a word of `{}`", table.name));
            if nearest.is_some() {
                error.did_you_mean(nearest)
            } else {
                error.help(format!("write one of {}", table.listed()))
            }
        }),
    }
}

/// The error message if `value` is outside `limits`.
pub(super) fn outside(limits: Option<(i128, i128)>, value: Number) -> Option<String> {
    let (low, high) = limits?;
    let inside = (Number::whole(low)..=Number::whole(high)).contains(&value);
    (!inside).then(|| format!("{value} is out of range ({low} to {high})"))
}

pub(super) fn bytes_or_pattern(pattern: BytePattern) -> Value {
    match pattern.exact() {
        Some(octets) => Value::bytes(octets),
        None => Value::Pattern(Arc::new(pattern)),
    }
}

/// The nanoseconds of `unit`; `span` is its position for the error.
pub(super) fn unit_of_time(unit: &str, span: std::ops::Range<usize>) -> Result<i128, ExprError> {
    UNITS
        .iter()
        .find(|(known, _)| *known == unit)
        .map(|&(_, nanos)| nanos)
        .ok_or_else(|| ExprError::new(span, format!("`{unit}` is not a unit")).help(DURATION_HELP))
}

/// Splits a text into a number without sign and the letters that follow it directly, which may be a unit.
pub(super) fn quantity(text: &str) -> Result<(Number, &str), ExprError> {
    let wrong = |message: &str, help: &str| ExprError::new(0..text.len(), format!("`{text}` {message}")).help(help);
    let too_large = || wrong("is too large", "a number has at most 38 digits");
    if text.contains('_') {
        return Err(wrong("has a `_` in a number", "write the digits without `_`"));
    }
    if let Some(digits) = text.strip_prefix("0x") {
        if digits.is_empty() || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return Err(wrong("is not a hexadecimal number", "write it as 0x1F"));
        }
        let value = i128::from_str_radix(digits, 16).map_err(|_| too_large())?;
        return Ok((Number::whole(value), ""));
    }
    let end = |text: &str| text.bytes().position(|octet| !octet.is_ascii_digit()).unwrap_or(text.len());
    let (digits, rest) = text.split_at(end(text));
    if digits.is_empty() {
        return Err(wrong("is not a number", "write it as 4096, 0x1F, -12 or 11.25"));
    }
    if digits.len() > 1 && digits.starts_with('0') {
        return Err(wrong("has a leading zero", "remove it, or write 0x for a hexadecimal number"));
    }
    if digits == "0" && rest.starts_with(['o', 'b', 'X']) {
        return Err(wrong("is not a number", "write it in decimal, or in hexadecimal with 0x and a lowercase x"));
    }
    let (places, rest) = match rest.strip_prefix('.') {
        Some(fraction) if end(fraction) == 0 => return Err(wrong("has no digit after the dot", "write it as 11.25")),
        Some(fraction) => fraction.split_at(end(fraction)),
        None => ("", rest),
    };
    if rest.starts_with('.') {
        return Err(wrong("has more than one dot", "write an address in quotes: \"192.168.0.10\""));
    }
    let over = format!("{digits}{places}").parse::<i128>().map_err(|_| too_large())?;
    let under = u32::try_from(places.len()).ok().and_then(|places| 10i128.checked_pow(places)).ok_or_else(too_large)?;
    let value = Number::new(over, under).ok_or_else(too_large)?;
    Ok((value, rest))
}
