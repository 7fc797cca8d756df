//! How the bits of a signal are a value: whole numbers, scaled numbers, IEEE 754 and texts.

use expression::{Number, Value};
use serde::{Deserialize, Serialize};

/// How the bits of a signal are a value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum SignalForm {
    /// A whole number.
    #[default]
    Whole,
    /// A whole number times `scale`, plus `zero`, in the unit of the manual.
    Scaled { scale: Number, zero: Number },
    /// A number of IEEE 754: binary32 or binary64, by the width of the signal.
    Float,
    /// ASCII characters, filled up with NUL or blanks at the end.
    Text,
}

/// Fractions of a floating-point number are read to this power of two; what is smaller is rounded.
const SMALLEST_PLACE: i32 = -64;

impl SignalForm {
    /// The value of a number on the wire, `raw` as a two's complement where the signal has a sign and `width` bits wide.
    ///
    /// Unknown are infinity, NaN, numbers of 2^127 and more, and texts, which are no number.
    pub fn value(self, raw: i128, width: u32) -> Value {
        let number = match self {
            SignalForm::Whole => Some(Number::whole(raw)),
            SignalForm::Scaled { scale, zero } => Number::whole(raw).times(scale).and_then(|number| number.plus(zero)),
            SignalForm::Float if width == 32 => number_of(f32::from_bits(raw as u32).into()),
            SignalForm::Float => number_of(f64::from_bits(raw as u64)),
            SignalForm::Text => None,
        };
        number.map_or(Value::Unknown, Value::Number)
    }

    /// The nearest number on the wire for a value; a negative one where the signal has a sign. `None` if there is none.
    pub fn raw(self, value: &Value, width: u32) -> Option<i128> {
        let number = || match value {
            Value::Number(number) => Some(*number),
            value => value.as_whole().map(Number::whole),
        };
        match self {
            SignalForm::Whole => value.as_whole(),
            SignalForm::Scaled { scale, zero } => number()?.minus(zero)?.divided_by(scale)?.round().as_whole(),
            SignalForm::Float if width == 32 => Some((number()?.to_f64() as f32).to_bits().into()),
            SignalForm::Float => Some(number()?.to_f64().to_bits().into()),
            SignalForm::Text => None,
        }
    }
}

/// The text in the bytes of a signal, without what fills it up; bytes that are no printable ASCII stand as `\xNN`.
pub fn text_of(octets: &[u8]) -> String {
    let filling = |octet: &&u8| matches!(octet, 0 | b' ');
    let length = octets.len() - octets.iter().rev().take_while(filling).count();
    octets[..length].escape_ascii().to_string()
}

/// A floating-point number, with fractions down to [`SMALLEST_PLACE`]; `None` if it is none or too large.
fn number_of(float: f64) -> Option<Number> {
    const MANTISSA_BITS: u64 = 52;
    if !float.is_finite() {
        return None;
    }
    let bits = float.to_bits();
    let (exponent, fraction) = ((bits >> MANTISSA_BITS & 0x7FF) as i32, bits & ((1 << MANTISSA_BITS) - 1));
    // A subnormal number has no hidden bit and the exponent of the smallest normal one.
    let mantissa = if exponent == 0 { fraction } else { fraction | 1 << MANTISSA_BITS };
    let place = exponent.max(1) - 1075;
    let mantissa = if float.is_sign_negative() { -i128::from(mantissa) } else { mantissa.into() };
    match place {
        0.. => mantissa.checked_mul(1i128.checked_shl(place as u32).filter(|power| *power > 0)?).map(Number::whole),
        SMALLEST_PLACE..0 => Number::new(mantissa, 1 << -place),
        _ => {
            let rounded = (float * 2f64.powi(-SMALLEST_PLACE)).round();
            Number::new(rounded as i128, 1 << -SMALLEST_PLACE)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    fn n(over: i128, under: i128) -> Value {
        Number::new(over, under).map_or(Value::Unknown, Value::Number)
    }

    /// The bits are those of IEEE 754-2019, table 3.5, and of its examples in any computer.
    #[rstest]
    #[case(32, 0x41C8_0000, n(25, 1))]
    #[case(32, 0xC148_0000, n(-25, 2))]
    #[case(32, 0x3DCC_CCCD, n(13_421_773, 1 << 27))]
    #[case(32, 0x8000_0000, n(0, 1))]
    #[case(32, 0x7F80_0000, Value::Unknown)]
    #[case(32, 0x7FC0_0000, Value::Unknown)]
    #[case(32, 0x0000_0001, n(0, 1))]
    #[case(64, 0x4059_0000_0000_0000, n(100, 1))]
    #[case(64, 0xBFE0_0000_0000_0000, n(-1, 2))]
    #[case(64, 0x7FEF_FFFF_FFFF_FFFF, Value::Unknown)]
    fn floats(#[case] width: u32, #[case] raw: i128, #[case] value: Value) {
        assert_eq!(SignalForm::Float.value(raw, width), value);
        if value != Value::Unknown && value != n(0, 1) {
            assert_eq!(SignalForm::Float.raw(&value, width), Some(raw));
        }
    }

    #[rstest]
    #[case(n(1, 10), n(0, 1), 235, n(47, 2))]
    #[case(n(1, 10), n(-40, 1), 0, n(-40, 1))]
    #[case(n(-1, 4), n(0, 1), 3, n(-3, 4))]
    fn scaled(#[case] scale: Value, #[case] zero: Value, #[case] raw: i128, #[case] value: Value) {
        let (Value::Number(scale), Value::Number(zero)) = (scale, zero) else { panic!("numbers") };
        let form = SignalForm::Scaled { scale, zero };
        assert_eq!(form.value(raw, 16), value);
        assert_eq!(form.raw(&value, 16), Some(raw));
    }

    #[test]
    fn the_nearest_step_of_a_scaled_number_is_sent() {
        let form = SignalForm::Scaled { scale: Number::new(1, 10).expect("a number"), zero: Number::ZERO };
        assert_eq!(form.raw(&n(127, 1000), 16), Some(1));
        assert_eq!(form.raw(&n(151, 1000), 16), Some(2));
    }

    #[rstest]
    #[case(b"AFM60\0\0\0", "AFM60")]
    #[case(b"AFM 60  ", "AFM 60")]
    #[case(b"\0\0\0\0", "")]
    #[case(b"A\x1B[1m", "A\\x1b[1m")]
    fn texts(#[case] octets: &[u8], #[case] text: &str) {
        assert_eq!(text_of(octets), text);
    }
}
