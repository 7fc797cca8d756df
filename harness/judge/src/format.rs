//! Formats numbers and values for reports.

use expression::{FormattedValue, Number, Type, Value};
use suite::device::{SignalField, SignalForm};
use suite::words;

/// Formats a value without a name.
pub fn plain(value: &Value) -> String {
    match (value, value.as_whole()) {
        (Value::Bit(_), Some(number)) => number.to_string(),
        (_, Some(number)) => hex(number, 0),
        _ => FormattedValue(value, &Type::WHOLE).to_string(),
    }
}

/// The word of a number in a built-in table; the number if it has none.
pub(super) fn builtin(table: words::WordList, number: i128) -> String {
    let word = i64::try_from(number).ok().and_then(|number| words::word(table, number));
    word.map_or_else(|| number.to_string(), str::to_owned)
}

/// Formats a number of steps that is shifted left on the wire, with its raw value: `0x100 (256), on the wire 0x00000400`.
pub(super) fn left_aligned(value: &Value, shift: u32, width: u32) -> String {
    let on_the_wire = |number: Number| number.times(Number::whole(1 << shift)).and_then(Number::as_whole);
    let raw = |number: i128| format!("0x{number:0digits$X}", digits = width as usize / 4);
    match (value.as_whole(), value) {
        (Some(steps), _) if steps >= 0 => format!("{}, on the wire {}", hex(steps, 0), raw(steps << shift)),
        (None, Value::Number(number)) => match on_the_wire(*number) {
            Some(number) => format!("{}, of which the lowest {shift} bits are not 0", raw(number)),
            None => plain(value),
        },
        _ => plain(value),
    }
}

/// Formats a value that is no whole number on the wire, with its raw value: `23.5, on the wire 0x00EB`.
pub(super) fn converted(value: &Value, form: SignalForm, width: u32, signed: bool) -> String {
    let Value::Number(number) = value else { return plain(value) };
    // Seven digits tell numbers of 32 bits apart, and say more of one of 64 bits than a person compares.
    let text = match form {
        SignalForm::Float => (number.to_f64() as f32).to_string(),
        SignalForm::Whole | SignalForm::Scaled { .. } | SignalForm::Text => number.to_string(),
    };
    let Some(raw) = form.raw(value, width) else { return text };
    let raw = if signed { raw & ((1 << width) - 1) } else { raw };
    format!("{text}, on the wire 0x{raw:0digits$X}", digits = width as usize / 4)
}

/// Formats a number as `0x00012345 (74565)`; small numbers in decimal only.
pub(super) fn hex(number: i128, width: u32) -> String {
    match (number, width as usize / 4) {
        (..=-1, _) => number.to_string(),
        (0..=9, 0) => number.to_string(),
        (_, 0) => format!("0x{number:X} ({number})"),
        (_, digits) => format!("0x{number:0digits$X} ({number})"),
    }
}

/// The names of set bits: ` [parked, sensor_error]`.
pub(super) fn set_bits(number: i128, fields: &[SignalField]) -> String {
    let set: Vec<String> = fields
        .iter()
        .filter_map(|field| {
            let value = (number >> field.low) & ((1i128 << field.width) - 1);
            match (value, field.width) {
                (0, _) => None,
                (_, 1) => Some(field.name.clone()),
                (value, _) => Some(format!("{} {value}", field.name)),
            }
        })
        .collect();
    if set.is_empty() { String::new() } else { format!(" [{}]", set.join(", ")) }
}
