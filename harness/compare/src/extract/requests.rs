//! Acyclic requests in the words of the manual: parameters and records by their names if they have some, else by numbers.

use crate::action::ControllerAction;
use crate::conversation::SuiteValue;
use judge::image::field_number;
use plain_text::hex;
use suite::device::{DeviceDescription, DeviceParameter, DeviceRecord, RecordField};
use wire::profidrive::{Attribute, ParameterRequest, ParameterResponse, ParameterValue, RequestId};
use wire::profinet::status::PnioStatus;

/// The address of a record: API, slot, subslot, index.
pub(super) type RecordTarget = (u32, u16, u16, u16);

/// A refusal as a word.
pub(super) fn refused(status: &PnioStatus) -> SuiteValue {
    let number = Some(i128::from(u32::from(*status)));
    let text = format!("{{ refused: {} }}", status.word().unwrap_or("any"));
    SuiteValue { text, number }
}

/// An answer without parts.
pub(super) fn whole(status: &PnioStatus) -> (String, SuiteValue) {
    let value = if status.is_ok() { SuiteValue::word("accepted") } else { refused(status) };
    ("answer".to_owned(), value)
}

/// Whether a record is the base mode parameter access of the manual.
pub(super) fn is_parameter_access(device: &DeviceDescription, target: RecordTarget) -> bool {
    let access = &device.parameter_access;
    match device.profibus() {
        None => {
            let mut points = device.parameter_points().filter_map(|at| device.submodules.get(at));
            let is_there = points.any(|of| (of.slot, of.subslot) == (target.1, target.2));
            target.3 == access.index && is_there && !device.parameters.is_empty()
        }
        Some(slave) => {
            target.3 == access.index && target.1 == u16::from(slave.parameter_slot) && !device.parameters.is_empty()
        }
    }
}

/// A parameter request by names; `None` if it is not a correct request for names of the manual.
pub(super) fn parameter_ask(device: &DeviceDescription, request: &ParameterRequest) -> Option<ControllerAction> {
    let header = &request.header;
    let single =
        request.addresses.iter().all(|address| address.attribute == Attribute::VALUE && address.element_count <= 1);
    let usual = header.do_id == device.parameter_access.do_id
        && usize::from(header.parameter_count) == request.addresses.len()
        && request.rest.is_empty()
        && !request.addresses.is_empty()
        && single;
    if !usual || !request.addresses.iter().all(|address| has_name(device, address.number, address.subindex)) {
        return None;
    }
    let paths: Vec<String> =
        request.addresses.iter().map(|address| path(device, address.number, address.subindex)).collect();
    let mut once = paths.clone();
    once.sort();
    once.dedup();
    if once.len() < paths.len() {
        return None;
    }
    match header.id {
        RequestId::REQUEST if request.values.is_empty() => Some(ControllerAction::Read(paths)),
        RequestId::CHANGE if request.values.len() == paths.len() => {
            let values = request.addresses.iter().zip(&request.values).map(|(address, value)| {
                let parameter = parameter(device, address.number)?;
                let usual = parameter.kind.formats.first() == Some(&value.format.0) && value.count == 1;
                usual.then(|| literal(Some(parameter), value)).flatten()
            });
            let values: Option<Vec<SuiteValue>> = values.collect();
            Some(ControllerAction::Write(paths.into_iter().zip(values?.into_iter().map(|value| value.text)).collect()))
        }
        _ => None,
    }
}

/// The values in a parameter response, by the same names; the bytes after the reference come last.
pub(super) fn parameter_answer(
    device: &DeviceDescription,
    request: &ParameterRequest,
    octets: &[u8],
) -> Vec<(String, SuiteValue)> {
    let mut answer = Vec::new();
    if let Ok(response) = ParameterResponse::parse(octets) {
        let written = request.header.id == RequestId::CHANGE;
        for (index, address) in request.addresses.iter().enumerate() {
            let value = response.values.get(index);
            let refusal = value.and_then(ParameterValue::error).filter(|error| error.number.0 != 0 || !written);
            let observed = match (refusal, value) {
                (Some(error), _) => {
                    let own = device.codes.iter().find(|(table, _)| table == "parameter_error");
                    let own = own.and_then(|(_, words)| words.iter().find(|(_, n)| *n == u32::from(error.number.0)));
                    let word = own.map(|(word, _)| word.as_str()).or(error.number.word()).unwrap_or("any");
                    SuiteValue { text: format!("{{ refused: {word} }}"), number: Some(error.number.0.into()) }
                }
                (None, _) if written => SuiteValue::word("accepted"),
                (None, Some(value)) => match literal(parameter(device, address.number), value) {
                    Some(value) => value,
                    None => continue,
                },
                (None, None) => continue,
            };
            answer.push((path(device, address.number, address.subindex), observed));
        }
    }
    answer.push(("bytes".to_owned(), SuiteValue::octets(octets.get(1..).unwrap_or_default())));
    answer
}

fn parameter(device: &DeviceDescription, number: u16) -> Option<&DeviceParameter> {
    device.parameters.iter().find(|parameter| parameter.number == number)
}

/// Whether the manual has a parameter, and an element of it with this subindex.
fn has_name(device: &DeviceDescription, number: u16, subindex: u16) -> bool {
    parameter(device, number).is_some_and(|parameter| {
        if parameter.elements.is_empty() {
            subindex == 0
        } else {
            parameter.elements.iter().any(|(_, known)| *known == subindex)
        }
    })
}

/// The name of a parameter or of one of its elements.
fn path(device: &DeviceDescription, number: u16, subindex: u16) -> String {
    let elements = parameter(device, number).map_or(&[][..], |parameter| &parameter.elements);
    match elements.iter().find(|(_, known)| *known == subindex) {
        Some((element, _)) => format!("P{number}.{element}"),
        None if subindex == 0 => format!("P{number}"),
        None => format!("P{number}.{subindex}"),
    }
}

/// The first value as a literal of the parameter's type.
fn literal(parameter: Option<&DeviceParameter>, value: &ParameterValue) -> Option<SuiteValue> {
    match parameter.map(|parameter| &parameter.kind) {
        Some(kind) if kind.text => {
            let text = std::str::from_utf8(&value.data).ok()?.trim_end_matches('\0');
            plain_text(text)
        }
        Some(kind) if kind.octets.is_some() => Some(SuiteValue::octets(&value.data)),
        kind => {
            let number = i128::from(value.to_number()?);
            let (width, signed) = kind.map_or((32, false), |kind| (kind.width, kind.signed));
            // The format of a value need not say whether it is signed.
            let negative = signed && number >= 1_i128 << (width.max(1) - 1);
            Some(SuiteValue::number(if negative { number - (1_i128 << width) } else { number }, width, signed))
        }
    }
}

/// A text in quotes; `None` if YAML would have to escape its characters.
fn plain_text(text: &str) -> Option<SuiteValue> {
    let is_plain = text.chars().all(|letter| (letter.is_ascii_graphic() && letter != '\'') || letter == ' ');
    (is_plain && !text.starts_with('=')).then(|| SuiteValue::word(format!("'{text}'")))
}

/// The API of a request for a submodule that the manual has in another API.
pub(super) fn other_api(device: &DeviceDescription, (api, slot, subslot, _): RecordTarget) -> Option<u32> {
    let known = || device.submodules.iter().filter(|of| (of.slot, of.subslot) == (slot, subslot));
    let differs = device.profinet().is_some() && known().next().is_some() && known().all(|of| of.api != api);
    differs.then_some(api)
}

/// The manual's record with this address.
pub(super) fn record(device: &DeviceDescription, target: RecordTarget) -> Option<&DeviceRecord> {
    let (_, slot, subslot, index) = target;
    let is_at = |record: &&DeviceRecord| {
        let at = device.submodules.get(record.at).map(|at| (at.slot, at.subslot));
        device.profinet().is_some() && record.index == index && at == Some((slot, subslot))
    };
    device.records.iter().find(is_at)
}

/// A request for a record: by names if the manual has it, else by numbers.
pub(super) fn record_ask(device: &DeviceDescription, target: RecordTarget, written: Option<&[u8]>) -> ControllerAction {
    let (_, slot, subslot, index) = target;
    if let Some(record) = record(device, target) {
        match written {
            None => {
                let names = record.fields.iter().map(|field| format!("{}.{}", record.name, field.name));
                return ControllerAction::Read(names.collect());
            }
            Some(octets) => {
                if let Some(fields) = fields(record, octets) {
                    let entry = |(field, value): (&RecordField, SuiteValue)| {
                        (format!("{}.{}", record.name, field.name), value.text)
                    };
                    return ControllerAction::Write(fields.into_iter().map(entry).collect());
                }
            }
        }
    }
    let on_profibus = device.profibus().is_some();
    let address = if on_profibus {
        format!("slot: {slot}, index: {index}")
    } else {
        format!("slot: {slot}, subslot: 0x{subslot:X}, index: 0x{index:X}")
    };
    let (service, rest) = match (written, on_profibus) {
        (Some(octets), false) => ("record_write", format!("bytes: \"{}\"", hex(octets))),
        (None, false) => ("record_read", "length: 4096".to_owned()),
        (Some(octets), true) => ("ds_write", format!("bytes: \"{}\"", hex(octets))),
        (None, true) => ("ds_read", "length: 240".to_owned()),
    };
    ControllerAction::Send { service: service.to_owned(), fields: format!("{{ {address}, {rest} }}"), answered: true }
}

/// The values in a record that was read, by names; its bytes come last.
pub(super) fn record_answer(
    device: &DeviceDescription,
    target: RecordTarget,
    octets: &[u8],
) -> Vec<(String, SuiteValue)> {
    let mut answer = Vec::new();
    if let Some(record) = record(device, target) {
        answer.extend(
            record
                .fields
                .iter()
                .filter_map(|field| Some((format!("{}.{}", record.name, field.name), field_value(field, octets)?))),
        );
    }
    answer.push(("bytes".to_owned(), SuiteValue::octets(octets)));
    answer
}

/// The fields of a record with their values; `None` if the fields do not cover all its bytes.
pub(super) fn fields<'r>(record: &'r DeviceRecord, octets: &[u8]) -> Option<Vec<(&'r RecordField, SuiteValue)>> {
    if octets.len() != record.octets {
        return None;
    }
    let mut rest = octets.to_vec();
    let mut fields = Vec::new();
    for field in &record.fields {
        fields.push((field, field_value(field, octets)?));
        let own = rest.get_mut(field.octet..field.octet + field.octets)?;
        match field.bits {
            None => own.fill(0),
            Some((low, width)) => {
                let mask = ((1_u64 << width) - 1) << low;
                let size = own.len();
                for (index, octet) in own.iter_mut().enumerate() {
                    *octet &= !((mask >> (8 * (size - 1 - index))) as u8);
                }
            }
        }
    }
    rest.iter().all(|octet| *octet == 0).then_some(fields)
}

/// A field of a record as a literal.
pub(super) fn field_value(field: &RecordField, octets: &[u8]) -> Option<SuiteValue> {
    if field.text {
        let octets = octets.get(field.octet..field.octet + field.octets)?;
        return plain_text(std::str::from_utf8(octets).ok()?.trim_end_matches(['\0', ' ']));
    }
    let number = field_number(field, octets)?;
    // A number without a word cannot be written as a value.
    let has_word = field.words.is_empty() || field.words.iter().any(|(_, known)| *known == number);
    if !has_word {
        return None;
    }
    let width = field.bits.map_or(field.octets as u32 * 8, |(_, width)| width);
    Some(SuiteValue::of_table(number, width, false, &field.words))
}
