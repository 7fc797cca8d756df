//! Values as literals of the suite language.

use compare::conversation::SuiteValue;
use engine::step_log::ObservedName;
use expression::Value;
use judge::answer::{NegativeResponse, ReceivedReply};
use plain_text::hex;
use suite::device::{DeviceDescription, DeviceSignal, SignalForm};
use suite::model::AnswerPart;
use suite::words;
use wire::octets::mask;

/// A value that was read or sent in an event, under a name with these words; `None` if no literal can say it.
pub(crate) fn of_value(value: &Value, words: &[(String, i128)]) -> Option<String> {
    Some(match value {
        Value::Bit(bit) => u8::from(*bit).to_string(),
        Value::Word(number) => match words.iter().find(|(_, known)| *known == i128::from(*number)) {
            Some((word, _)) => word.clone(),
            None => number.to_string(),
        },
        Value::Text(text) => {
            let is_plain = text.chars().all(|letter| letter.is_ascii_graphic() && letter != '\'' || letter == ' ');
            is_plain.then(|| format!("'{text}'"))?
        }
        Value::Bytes(octets) => format!("\"{}\"", hex(octets)),
        Value::Address([a, b, c, d]) => format!("{a}.{b}.{c}.{d}"),
        Value::Number(_) | Value::Place(_) => match value.as_whole() {
            Some(number) => number.to_string(),
            None => SuiteValue::fraction(value).text,
        },
        Value::Unknown | Value::Time(_) | Value::Cycles(_) | Value::Pattern(_) | Value::Set(_) => return None,
    })
}

/// The key of a part of an answer, beside `answer`.
pub(crate) fn part_name(device: &DeviceDescription, part: &AnswerPart) -> Option<String> {
    Some(match part {
        AnswerPart::Bytes => "bytes".to_owned(),
        AnswerPart::Connect => "connect".to_owned(),
        AnswerPart::ParameterEnd => "parameter_end".to_owned(),
        AnswerPart::ApplicationReady => "application_ready".to_owned(),
        AnswerPart::Connection => "connection".to_owned(),
        AnswerPart::SetPrm => "set_prm".to_owned(),
        AnswerPart::ChkCfg => "chk_cfg".to_owned(),
        AnswerPart::Record(index) => device.records.get(*index)?.name.clone(),
        AnswerPart::ModuleDiff(index) => format!("module_diff.{}", device.submodules.get(*index)?.name),
        AnswerPart::Parameter(number, subindex) => {
            let of = device.parameters.iter().find(|of| of.number == *number)?;
            match of.elements.iter().find(|(_, at)| at == subindex) {
                Some((element, _)) => format!("P{number}.{element}"),
                None => format!("P{number}"),
            }
        }
        AnswerPart::Diagnosis(name) => format!("diag.{}", device.diagnosis_name(*name)),
        AnswerPart::Whole
        | AnswerPart::Status
        | AnswerPart::Contains
        | AnswerPart::Lacks
        | AnswerPart::Text
        | AnswerPart::Number => {
            return None;
        }
    })
}

/// An answer as what is right.
pub(crate) fn of_reply(device: &DeviceDescription, reply: &ReceivedReply) -> Option<String> {
    Some(match reply {
        ReceivedReply::Accepted => "accepted".to_owned(),
        ReceivedReply::Silent(_) => "none".to_owned(),
        ReceivedReply::Value(value) => of_value(value, &[])?,
        ReceivedReply::Refused(refusal) => format!("{{ refused: {} }}", code(device, refusal)),
        ReceivedReply::Wrong(_) => return None,
    })
}

fn code(device: &DeviceDescription, refusal: &NegativeResponse) -> String {
    let number = match refusal {
        NegativeResponse::Parameter(number) => u32::from(*number),
        NegativeResponse::Dcp(number) | NegativeResponse::Fdl(number) | NegativeResponse::Abort(number) => {
            u32::from(*number)
        }
        NegativeResponse::Pnio(status) => return status.word().unwrap_or("any").to_owned(),
        NegativeResponse::Dpv1 { code1, .. } => {
            let word = wire::profibus::dpv1::RecordError(*code1).word();
            return word.unwrap_or("any").to_owned();
        }
        NegativeResponse::NotSupported | NegativeResponse::Http(_) => return "any".to_owned(),
    };
    let NegativeResponse::Parameter(short) = refusal else { return number.to_string() };
    let own = device.codes.iter().find(|(table, _)| table == "parameter_error");
    let own =
        own.and_then(|(_, words)| words.iter().find(|(_, known)| *known == number)).map(|(word, _)| word.as_str());
    let word = own.or(wire::profidrive::ErrorNumber(*short).word());
    word.map_or_else(|| format!("0x{number:X}"), str::to_owned)
}

/// The name of what a device sends by itself, the part of it in which two values differ, and the first value as a literal.
pub(crate) fn of_sent(
    device: &DeviceDescription,
    variant: usize,
    name: ObservedName,
    right: Option<u64>,
    other: Option<u64>,
) -> Option<(String, String)> {
    let builtin = |table: words::WordList, number: Option<u64>| {
        words::word(table, i64::try_from(number?).ok()?).map(str::to_owned)
    };
    let submodule = |index: usize| device.submodules.get(index).map(|of| of.name.as_str());
    Some(match name {
        ObservedName::Connection => ("connection".to_owned(), builtin(words::CONNECTION, right)?),
        ObservedName::InputStatus(index) => {
            (format!("io.input_status.{}", submodule(index)?), builtin(words::STATUS, right)?)
        }
        ObservedName::ConsumerStatus(index) => {
            (format!("io.consumer_status.{}", submodule(index)?), builtin(words::STATUS, right)?)
        }
        ObservedName::DiagnosisPending => ("io.diagnosis_pending".to_owned(), right?.to_string()),
        ObservedName::DataStatus => ("io.input_data_status".to_owned(), right?.to_string()),
        ObservedName::InputLength => ("io.input_length".to_owned(), right?.to_string()),
        ObservedName::Led(led) => {
            let (name, words) = device.stand.leds.get(led)?;
            (format!("led.{name}"), words.get(usize::try_from(right?).ok()?)?.clone())
        }
        ObservedName::Signal(index) => of_signal(device.signals.get(index)?, variant, right?, other)?,
    })
}

fn of_signal(signal: &DeviceSignal, variant: usize, right: u64, other: Option<u64>) -> Option<(String, String)> {
    let differing = other.map_or(u64::MAX, |other| right ^ other);
    // A sign of life counts from the start of the device.
    let field = signal
        .fields
        .iter()
        .filter(|field| field.counts.is_none())
        .find(|field| field.width < signal.width && differing & field.mask() != 0);
    if let Some(field) = field {
        let raw = (right >> field.low) & mask(0, field.width);
        let negative = field.signed && raw >> (field.width - 1) & 1 == 1;
        let number = if negative { i128::from(raw) - (1 << field.width) } else { i128::from(raw) };
        let value = SuiteValue::of_table(number, 1, false, &field.words);
        return Some((format!("{}.{}", signal.name, field.name), value.text));
    }
    let shift = signal.shift.get(variant).copied().unwrap_or_default();
    let raw = i128::from(right & mask(0, signal.width));
    let raw = if signal.signed && raw >> (signal.width - 1) & 1 == 1 { raw - (1_i128 << signal.width) } else { raw };
    let text = match signal.form {
        SignalForm::Whole => (raw >> shift).to_string(),
        SignalForm::Text => return None,
        form => SuiteValue::fraction(&form.value(raw, signal.width)).text,
    };
    Some((signal.name.clone(), text))
}
