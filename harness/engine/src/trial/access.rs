//! Acyclic access: the request for a `read` or `write`, and the meaning of its answer; here parameters and counters, which are the
//! same on every bus.

use super::RunningTrial;
use super::step_error::{BoxedStepError, StepError};
use expression::{HistoryState, Value};
use judge::answer::{NegativeResponse, ReceivedReply};
use results::outcome::FailureCause;
use results::verdict::Verdict;
use station::Duration;
use suite::device::{DeviceDescription, NameKind, ParameterType};
use suite::model::{AccessChannel, AcyclicAccess, AnswerPart, Matcher, RequestDeviation};
use wire::ethernet::{EtherType, FrameHeader};
use wire::profidrive::{
    Attribute, ParameterAddress, ParameterFormat, ParameterRequest, ParameterResponse, ParameterValue, RequestId,
};
use wire::profinet::rt::FrameId;

/// How long a live stand may take to read a counter.
const LONGEST_LOOK: Duration = Duration::from_secs(2);
/// The time between two queries of the counter.
const LOOK_AGAIN: Duration = Duration::from_millis(1);

/// The answer to an access: replies by part, and a value for each item.
pub struct AccessAnswer {
    /// The reply for the whole answer and for its parts.
    pub replies: Vec<(AnswerPart, ReceivedReply)>,
    /// The values, in the order of the items of the access.
    pub values: Vec<Value>,
}

impl AccessAnswer {
    /// An answer without parts and with unknown values.
    pub fn whole(reply: ReceivedReply, items: usize) -> AccessAnswer {
        AccessAnswer { replies: vec![(AnswerPart::Whole, reply)], values: vec![Value::Unknown; items] }
    }
}

impl<'a> RunningTrial<'a> {
    /// Sends the request of an access and receives its answer.
    pub fn access(&mut self, access: &'a AcyclicAccess, write: bool) -> Result<AccessAnswer, BoxedStepError> {
        let before = self.world.trace.len();
        let answered = match access.via {
            AccessChannel::Parameters => self.parameters(access, write),
            AccessChannel::Stand => Ok(self.counters(access)),
            AccessChannel::Record(_)
            | AccessChannel::Station
            | AccessChannel::Diagnosis
            | AccessChannel::Configuration
            | AccessChannel::Pages => self.driver.access(self, access, write),
        };
        if !access.instead.is_empty() {
            self.world.mark_broken(before, is_request);
        }
        answered
    }

    /// The value to write to an item.
    pub fn written(&self, matcher: &Matcher) -> Result<Value, BoxedStepError> {
        let value = match matcher {
            Matcher::Equal(target) => target.center().eval(&self.world.view(), &HistoryState::default()),
            _ => Value::Unknown,
        };
        match value {
            Value::Unknown => {
                Err(StepError::other(FailureCause::Suite, Verdict::Error, "The value to be written is unknown."))
            }
            value => Ok(value),
        }
    }

    fn parameters(&mut self, access: &'a AcyclicAccess, write: bool) -> Result<AccessAnswer, BoxedStepError> {
        let device = &self.world.manual.device;
        let mut addressed: Vec<(u16, u16)> = Vec::new();
        let mut values = Vec::new();
        for item in &access.items {
            let Some(NameKind::Parameter { parameter, number, subindex, .. }) = self.kind(item.name) else { continue };
            if addressed.contains(&(*number, *subindex)) {
                continue;
            }
            addressed.push((*number, *subindex));
            if write {
                let format =
                    parameter.and_then(|index| device.parameters.get(index)).and_then(|of| of.kind.formats.first());
                values.push(parameter_value(
                    &self.written(&item.value)?,
                    ParameterFormat(format.copied().unwrap_or(ParameterFormat::DOUBLE_WORD.0)),
                ));
            }
        }
        self.reference = self.reference.checked_add(1).unwrap_or(1);
        let do_id = device.parameter_access.do_id;
        let addresses: Vec<_> =
            addressed.iter().map(|&(number, subindex)| ParameterAddress::value(number, subindex)).collect();
        let mut request = if write {
            ParameterRequest::change_values(self.reference, do_id, addresses.into_iter().zip(values).collect())
        } else {
            ParameterRequest::read_values(self.reference, do_id, addresses)
        };
        let octets = changed(&mut request, &access.instead);
        match self.driver.parameters(self, access, octets)? {
            Ok(octets) => Ok(self.parameter_octets(access, &addressed, write, &octets)),
            Err(reply) => Ok(AccessAnswer::whole(reply, access.items.len())),
        }
    }

    /// Replies and values from the bytes of a parameter response.
    fn parameter_octets(
        &self,
        access: &AcyclicAccess,
        addressed: &[(u16, u16)],
        write: bool,
        octets: &[u8],
    ) -> AccessAnswer {
        let items = access.items.len();
        let bytes = (AnswerPart::Bytes, ReceivedReply::Value(Value::bytes(octets)));
        let response = match ParameterResponse::parse(octets) {
            Ok(response) => response,
            Err(error) => {
                let why = format!("the answer cannot be read: {error}");
                let mut answered = AccessAnswer::whole(ReceivedReply::Wrong(why), items);
                answered.replies.push(bytes);
                return answered;
            }
        };
        let expected = if write { RequestId::CHANGE } else { RequestId::REQUEST };
        let own_id = access
            .instead
            .iter()
            .any(|instead| matches!(instead, RequestDeviation::Request(_) | RequestDeviation::Bytes(_)));
        let negative = response.header.id.is_negative();
        if !own_id && response.header.id.0 & 0x7F != expected.0 {
            let why =
                format!("the answer has response id 0x{:02X}, the request 0x{:02X}", response.header.id.0, expected.0);
            let mut answered = AccessAnswer::whole(ReceivedReply::Wrong(why), items);
            answered.replies.push(bytes);
            return answered;
        }
        let mut replies = vec![bytes];
        let mut whole = None;
        for (index, &(number, subindex)) in addressed.iter().enumerate() {
            let reply = self.parameter_reply(access, (number, subindex), write, &response, index);
            if reply != ReceivedReply::Accepted {
                whole.get_or_insert(reply.clone());
            }
            replies.push((AnswerPart::Parameter(number, subindex), reply));
        }
        if negative && whole.is_none() {
            let error = response.values.iter().find_map(ParameterValue::error);
            whole = Some(match error {
                Some(error) => ReceivedReply::Refused(NegativeResponse::Parameter(error.number.0)),
                None => ReceivedReply::Wrong(format!(
                    "a negative answer without an error number, id 0x{:02X}",
                    response.header.id.0
                )),
            });
        }
        replies.insert(0, (AnswerPart::Whole, whole.unwrap_or(ReceivedReply::Accepted)));
        let values = access
            .items
            .iter()
            .map(|item| match self.kind(item.name) {
                Some(NameKind::Parameter { parameter, number, subindex, bits }) => {
                    let position = addressed.iter().position(|of| *of == (*number, *subindex));
                    let entry = position
                        .and_then(|position| response.values.get(position))
                        .filter(|entry| entry.error().is_none());
                    entry.map_or(Value::Unknown, |entry| value_of(&self.world.manual.device, *parameter, *bits, entry))
                }
                _ => Value::Unknown,
            })
            .collect();
        AccessAnswer { replies, values }
    }

    /// The reply for the parameter that was addressed at position `index`.
    fn parameter_reply(
        &self,
        access: &AcyclicAccess,
        (number, subindex): (u16, u16),
        write: bool,
        response: &ParameterResponse,
        index: usize,
    ) -> ReceivedReply {
        let negative = response.header.id.is_negative();
        let entry = response.values.get(index);
        let error = entry.and_then(ParameterValue::error).or_else(|| {
            let only = response.values.first().filter(|_| negative && response.values.len() == 1);
            only.and_then(ParameterValue::error)
        });
        match (error, entry) {
            (Some(error), _) => ReceivedReply::Refused(NegativeResponse::Parameter(error.number.0)),
            (None, None) if !write => ReceivedReply::Wrong("the answer does not contain this parameter".into()),
            (None, Some(entry)) if !write && access.instead.is_empty() => {
                let parameters = &self.world.manual.device.parameters;
                let known = parameters.iter().find(|parameter| parameter.number == number);
                match known.filter(|known| !is_octets(known.kind)) {
                    Some(known) if entry.format.width() != Some(known.kind.width as usize / 8) || entry.count != 1 => {
                        let format = entry.format.word().unwrap_or("unknown");
                        ReceivedReply::Wrong(format!(
                            "P{number}.{subindex} has {} value(s) of format {format} (0x{:02X})",
                            entry.count, entry.format.0
                        ))
                    }
                    _ => ReceivedReply::Accepted,
                }
            }
            (None, _) => ReceivedReply::Accepted,
        }
    }

    fn counters(&mut self, access: &AcyclicAccess) -> AccessAnswer {
        let value = |run: &mut RunningTrial<'a>, item: &suite::model::AccessItem| match run.kind(item.name) {
            Some(NameKind::Counter(counter)) => {
                let (name, _) = &run.world.manual.device.stand.counters[*counter];
                run.count(name).map_or(Value::Unknown, Value::whole)
            }
            _ => Value::Unknown,
        };
        let values: Vec<Value> = access.items.iter().map(|item| value(self, item)).collect();
        let reply = if values.iter().any(Value::is_unknown) {
            ReceivedReply::Silent("the stand does not read this counter".into())
        } else {
            ReceivedReply::Accepted
        };
        AccessAnswer { replies: vec![(AnswerPart::Whole, reply)], values }
    }
}

impl RunningTrial<'_> {
    /// The value of a counter; a live stand needs a moment to read it.
    fn count(&mut self, name: &str) -> Option<u64> {
        let latest = self.world.now() + LONGEST_LOOK;
        loop {
            let now = self.world.now();
            let count = self.world.segment.stand().counter(now, name);
            if count.is_some() || self.world.segment.is_virtual() || now >= latest {
                return count;
            }
            self.world.run(now + LOOK_AGAIN, |_| false);
        }
    }
}

/// Whether a frame may contain an acyclic request: all but cyclic frames may.
pub fn is_request(frame: &[u8]) -> bool {
    let Ok((header, payload)) = FrameHeader::parse(frame) else { return false };
    header.ether_type != EtherType::PROFINET || FrameId::peek(payload).is_ok_and(|id| !id.is_cyclic())
}

fn parameter_value(value: &Value, format: ParameterFormat) -> ParameterValue {
    match value {
        Value::Bytes(octets) => ParameterValue::new(format, octets.len() as u8, octets.to_vec()),
        value => ParameterValue::numbers(format, &[value.as_whole().unwrap_or_default() as u64]),
    }
}

/// The bytes of a request with the changes of `instead`.
fn changed(request: &mut ParameterRequest, instead: &[RequestDeviation]) -> Vec<u8> {
    for instead in instead {
        match instead {
            RequestDeviation::Reference(reference) => request.header.reference = *reference,
            RequestDeviation::Request(id) => request.header.id = RequestId(*id),
            RequestDeviation::DoId(id) => request.header.do_id = *id,
            RequestDeviation::Count(count) => request.header.parameter_count = *count,
            RequestDeviation::Attribute(attribute) => {
                each(&mut request.addresses, |of| of.attribute = Attribute(*attribute))
            }
            RequestDeviation::Elements(count) => each(&mut request.addresses, |of| of.element_count = *count),
            RequestDeviation::Subindex(subindex) => each(&mut request.addresses, |of| of.subindex = *subindex),
            RequestDeviation::Format(format) => each(&mut request.values, |of| reformat(of, ParameterFormat(*format))),
            RequestDeviation::Values(count) => each(&mut request.values, |of| of.count = *count),
            _ => {}
        }
    }
    let mut octets = Vec::new();
    request.write(&mut octets);
    for instead in instead {
        match instead {
            RequestDeviation::Length(length) => octets.resize(*length, 0),
            RequestDeviation::Bytes(other) => octets.clone_from(other),
            _ => {}
        }
    }
    octets
}

fn each<T>(list: &mut [T], change: impl FnMut(&mut T)) {
    list.iter_mut().for_each(change);
}

/// The same number in another format, cut or extended to its width, so that only the format is wrong.
fn reformat(value: &mut ParameterValue, format: ParameterFormat) {
    let number = value.to_numbers().and_then(|numbers| numbers.first().copied()).unwrap_or_default();
    *value = match format.width() {
        Some(width) if width > 0 => ParameterValue::numbers(format, &[number]),
        _ => ParameterValue { format, ..value.clone() },
    };
}

/// The value of a parameter, an element of it, or bits of an element.
fn value_of(
    device: &DeviceDescription,
    parameter: Option<usize>,
    bits: Option<(u32, u32)>,
    value: &ParameterValue,
) -> Value {
    let kind = parameter.and_then(|index| device.parameters.get(index)).map(|parameter| parameter.kind);
    if kind.is_some_and(is_octets) {
        return if kind.is_some_and(|kind| kind.text) {
            Value::text(String::from_utf8_lossy(&value.data).into_owned())
        } else {
            Value::bytes(value.data.as_slice())
        };
    }
    let Some(number) = value.to_numbers().and_then(|numbers| numbers.first().copied()) else { return Value::Unknown };
    let width = kind.map_or(64, |kind| kind.width).clamp(1, 64);
    match bits {
        Some((low, 1)) => Value::Bit(number >> low & 1 == 1),
        Some((low, width)) => Value::whole((number >> low) & ((1u64 << width) - 1)),
        None if kind.is_some_and(|kind| kind.signed) => Value::whole((number << (64 - width)) as i64 >> (64 - width)),
        None => Value::whole(number),
    }
}

/// Whether the elements of a parameter are bytes that form one value.
fn is_octets(kind: ParameterType) -> bool {
    kind.text || kind.octets.is_some()
}
