//! The values of all names at one instant.

use super::answer::ReceivedReply;
use super::diagnosis;
use super::format::{builtin, converted, hex, left_aligned, plain, set_bits};
use super::image::{ConnectionImage, CurrentEvent};
use super::parameter_cache::{ParameterCache, ParameterVersion};
use super::{JudgeTick, TickKind};
use crate::observe::FrameDirection;
use expression::{HistoryState, NameValues, Number, Program, Value};
use station::{Duration, Time};
use std::cell::{Cell, RefCell};
use std::net::Ipv4Addr;
use suite::device::{
    BenchName, DeviceDescription, DiagnosisName, EventName, NameId, NameKind, SignalField, SignalForm, UpdatedAt,
    text_of,
};
use suite::model::{AnswerPart, SuiteVariant};
use suite::words;

/// Values of a trial that are not part of a connection: saved values, answers, LEDs. Empty for a capture.
#[derive(Clone, Debug, Default)]
pub struct TrialValues {
    /// Values of `save`, by number of the name.
    pub saved: Vec<Value>,
    /// The last answer and its parts.
    pub answers: Vec<(AnswerPart, ReceivedReply)>,
    /// The last value of each name that is read on request.
    pub read: Vec<(NameId, Value)>,
    /// State of each LED, as the number of its word.
    pub leds: Vec<Option<i64>>,
    /// The addresses of the bench.
    pub bench: Option<BenchAddresses>,
    /// By how many steps two readings of a position at rest may differ.
    pub noise: u32,
    /// Additional time for deadlines on a live bench.
    pub slack: Duration,
    version: u64,
}

impl TrialValues {
    /// A number that increases with every possible change.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Marks the notebook as possibly changed.
    pub(super) fn is_written(&mut self) {
        self.version += 1;
    }
}

/// The addresses of a bench.
#[derive(Clone, Copy, Debug)]
pub struct BenchAddresses {
    /// IP address of the first controller.
    pub controller: Ipv4Addr,
    /// IP address of the device.
    pub device: Ipv4Addr,
    /// Subnet mask.
    pub mask: Ipv4Addr,
    /// An unused IP address of the same subnet.
    pub free: Ipv4Addr,
    /// Station addresses on PROFIBUS.
    pub stations: StationNumbers,
}

/// Station addresses of a bench on PROFIBUS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StationNumbers {
    /// Station address of the device.
    pub device: u8,
    /// Station address of the first master.
    pub master: u8,
    /// Station address of the second master.
    pub second: u8,
    /// An unused station address.
    pub free: u8,
}

impl BenchAddresses {
    fn of(&self, name: BenchName, on_profibus: bool) -> Value {
        let ip = |address: Ipv4Addr| Value::Address(address.octets());
        match (name, on_profibus) {
            (BenchName::Address, false) => ip(self.controller),
            (BenchName::Address, true) => Value::whole(self.stations.master),
            (BenchName::Ip, _) => ip(self.device),
            (BenchName::Mask, _) => ip(self.mask),
            (BenchName::FreeIp, _) => ip(self.free),
            (BenchName::Station, _) => Value::whole(self.stations.device),
            (BenchName::FreeStation, _) => Value::whole(self.stations.free),
            (BenchName::Second, _) => Value::whole(self.stations.second),
        }
    }
}

/// The names of one variant at one instant of one connection.
#[derive(Clone, Copy)]
pub struct NameView<'a> {
    pub device: &'a DeviceDescription,
    /// The variant that defines the names.
    pub variant: &'a SuiteVariant,
    pub image: &'a ConnectionImage,
    /// Values that are not part of the connection.
    pub notebook: &'a TrialValues,
    pub tick: JudgeTick,
    /// Records what is read, if set.
    pub reads: Option<&'a Reads>,
    /// Cache of values that many frames share, if set.
    pub settled: Option<&'a ParameterCache>,
}

/// What was read of a view.
#[derive(Debug, Default)]
pub struct Reads {
    names: RefCell<Vec<NameId>>,
    time: Cell<bool>,
}

impl Reads {
    fn note(&self, name: NameId) {
        self.names.borrow_mut().push(name);
    }

    /// The names, in the order of reading.
    pub fn names(&mut self) -> &[NameId] {
        self.names.get_mut()
    }

    /// Whether the time of the observation was read.
    pub fn has_time(&self) -> bool {
        self.time.get()
    }

    pub fn clear(&mut self) {
        self.names.get_mut().clear();
        self.time.set(false);
    }
}

impl NameView<'_> {
    fn kind(&self, name: NameId) -> Option<&NameKind> {
        self.variant.names.get(name.0 as usize)
    }

    /// Whether a name belongs to the event at this instant.
    pub fn is_happening(&self, name: NameId) -> bool {
        let Some(NameKind::Event(event)) = self.kind(name) else { return false };
        match self.image.happening {
            CurrentEvent::Nothing => false,
            CurrentEvent::Abort(_) => matches!(event, EventName::Abort | EventName::AbortCode),
            CurrentEvent::Lldp(_) => event.is_lldp(),
            CurrentEvent::Hello(_) => event.is_hello(),
            CurrentEvent::Ready(_) => matches!(event, EventName::Ready | EventName::ReadySequence),
            CurrentEvent::Diagnosis => false,
            CurrentEvent::Alarm(_) => event.is_alarm(),
        }
    }

    /// The last answer, or the part of it, that a name refers to.
    pub fn reply(&self, name: NameId) -> Option<&ReceivedReply> {
        let NameKind::Answer(part) = self.kind(name)? else { return None };
        self.notebook.answers.iter().find(|(known, _)| known == part).map(|(_, reply)| reply)
    }

    /// The path of a name as suites write it.
    pub fn name(&self, name: NameId) -> String {
        self.variant.paths.get(name.0 as usize).cloned().unwrap_or_default()
    }

    /// Formats a value of a name for reports: hexadecimal and decimal, words, and the names of set bits.
    pub fn show(&self, name: NameId, value: &Value) -> String {
        if let Some(&NameKind::Signal { signal, shift: shift @ 1.., .. }) = self.kind(name)
            && let Some(width) = self.device.signals.get(signal).map(|signal| signal.width)
        {
            return left_aligned(value, shift, width);
        }
        if let Some(&NameKind::Signal { signal, field: None, signed, .. }) = self.kind(name)
            && let Some(signal) = self.device.signals.get(signal)
            && let SignalForm::Scaled { .. } | SignalForm::Float = signal.form
        {
            return converted(value, signal.form, signal.width, signed);
        }
        if let (Value::Set(codes), Some(slave)) = (value, self.device.profibus()) {
            let table = slave.diagnosis.blocks.as_ref().map(|blocks| &blocks.table);
            let word = |code: &i64| {
                table.and_then(|table| table.word(*code)).map_or_else(|| hex((*code).into(), 0), str::to_owned)
            };
            return format!("[{}]", codes.iter().map(word).collect::<Vec<_>>().join(", "));
        }
        let Some(number) = value.as_whole() else { return plain(value) };
        let table: Option<&[(String, i128)]> = match self.kind(name) {
            Some(NameKind::Signal { signal, low: 0, width, field: None, circle: None, .. }) => {
                let signal = &self.device.signals[*signal];
                return format!("{}{}", hex(number, *width), set_bits(number, &signal.fields));
            }
            Some(NameKind::Signal { signal, field: Some(field), .. }) => self
                .device
                .signals
                .get(*signal)
                .and_then(|signal| signal.fields.get(*field))
                .map(|field| &field.words[..]),
            Some(NameKind::Record { record, field: Some(field) } | NameKind::StartParameter { record, field }) => {
                let record = self.device.records.get(*record);
                record.and_then(|record| record.fields.get(*field)).map(|field| &field.words[..])
            }
            Some(NameKind::Page { page, value }) => {
                let of = self.device.pages.get(*page).and_then(|page| page.shows.get(*value));
                let word = of.and_then(|of| of.table.as_ref()?.word(i64::try_from(number).ok()?));
                return word.map_or_else(|| hex(number, 0), str::to_owned);
            }
            Some(NameKind::Led(led)) => {
                let words = self.device.stand.leds.get(*led).map(|(_, words)| words);
                let word = usize::try_from(number).ok().and_then(|number| words?.get(number));
                return word.cloned().unwrap_or_else(|| number.to_string());
            }
            Some(NameKind::Diagnosis(DiagnosisName::Field(index))) => {
                let field = self.device.profibus().and_then(|slave| slave.diagnosis.fields.get(*index));
                let word = field.and_then(|field| field.table.as_ref()?.word(i64::try_from(number).ok()?));
                return word.map_or_else(|| hex(number, 0), str::to_owned);
            }
            Some(NameKind::Connection) => return builtin(words::CONNECTION, number),
            Some(NameKind::OutputStatus(_) | NameKind::InputStatus(_) | NameKind::ConsumerStatus(_)) => {
                return builtin(words::STATUS, number);
            }
            Some(NameKind::Event(EventName::AlarmChange)) => return builtin(words::ALARM_CHANGE, number),
            Some(NameKind::Event(EventName::AlarmSeverity)) => return builtin(words::ALARM_SEVERITY, number),
            _ => None,
        };
        let word = table.and_then(|table| table.iter().find(|(_, value)| *value == number));
        match (word, value) {
            (Some((word, _)), _) => word.clone(),
            (None, Value::Bit(_)) => number.to_string(),
            (None, _) => hex(number, 0),
        }
    }

    /// The time between this cyclic frame and the one before. On PROFIBUS a slave answers when it is asked, so what this host may be
    /// late with a request is not counted.
    fn elapsed(&self, direction: FrameDirection) -> Option<Duration> {
        let elapsed = self.image.elapsed(direction)?;
        let slack = self.notebook.slack;
        if slack.is_zero() || self.device.profibus().is_none() {
            return Some(elapsed);
        }
        let cycle = self.image.cycle().unwrap_or_default();
        Some(elapsed.saturating_sub(slack).max(elapsed.min(cycle)))
    }

    /// Evaluates the program of a name: the circle of a signal or a derived value.
    fn compute(&self, name: NameId, program: &Program) -> Value {
        let now = || program.eval(self, &HistoryState::default());
        let Some(settled) = self.settled else { return now() };
        settled.value(name, program, self.variant, self.parameters(), now)
    }

    /// The current version of the parameters.
    fn parameters(&self) -> ParameterVersion {
        ParameterVersion { start: self.image.parameters(), notebook: self.notebook.version() }
    }

    /// The last value of a name that is read on request.
    fn read(&self, name: NameId) -> Option<&Value> {
        self.notebook.read.iter().find(|(read, _)| *read == name).map(|(_, value)| value)
    }

    fn known(&self, name: NameId) -> Option<Value> {
        Some(match self.kind(name)? {
            NameKind::Signal { signal, low, width, signed, field, circle, code_when, shift } => {
                let form = self.device.signals.get(*signal)?.form;
                if form == SignalForm::Text {
                    return Some(Value::text(text_of(self.image.signal_octets(*signal)?)));
                }
                let number = bits(self.image.signal(*signal)?, *low, *width, *signed);
                if form != SignalForm::Whole {
                    return Some(form.value(number, *width));
                }
                let field = field.and_then(|field| self.device.signals.get(*signal)?.fields.get(field));
                let Some(number) = steps(number, *shift) else { return Some(fraction(number, *shift)) };
                match circle {
                    Some(circle) => {
                        let place = Value::place(number, self.compute(name, circle).as_whole());
                        // Without noise it makes no difference.
                        let is_code =
                            self.position_noise() > 0 && code_when.is_some_and(|bit| self.truth(bit) == Some(true));
                        if is_code { place.as_code() } else { place }
                    }
                    None => typed(number, field),
                }
            }
            NameKind::OutputOctets(of) => Value::bytes(self.image.octets(FrameDirection::ToDevice, *of)?),
            NameKind::InputOctets(of) => Value::bytes(self.image.octets(FrameDirection::ToController, *of)?),
            NameKind::InputDataStatus => Value::whole(self.image.input_apdu()?.data_status.0),
            NameKind::InputCounter => Value::whole(self.image.input_apdu()?.cycle_counter),
            NameKind::InputLength => Value::whole(self.image.input_length()? as i128),
            NameKind::OutputStatus(submodule) => Value::Word(self.image.output_status(*submodule)?.into()),
            NameKind::InputStatus(submodule) => Value::Word(self.image.input_status(*submodule)?.into()),
            NameKind::ConsumerStatus(submodule) => Value::Word(self.image.consumer_status(*submodule)?.into()),
            NameKind::Connection => Value::Word(self.image.stands().into()),
            NameKind::Parameter { .. }
            | NameKind::Record { .. }
            | NameKind::Station(_)
            | NameKind::Page { .. }
            | NameKind::Configuration
            | NameKind::Counter(_) => self.read(name)?.clone(),
            NameKind::Led(led) => Value::Word((*self.notebook.leds.get(*led)?)?),
            NameKind::Event(event) => self.event(*event)?,
            NameKind::Answer(_) => match self.reply(name)? {
                ReceivedReply::Value(value) => value.clone(),
                ReceivedReply::Accepted
                | ReceivedReply::Refused(_)
                | ReceivedReply::Wrong(_)
                | ReceivedReply::Silent(_) => return None,
            },
            NameKind::StartParameter { record, field } => {
                let field = self.device.records.get(*record)?.fields.get(*field)?;
                let number = self.image.start_parameter(*record, field)?;
                match (field.words.is_empty(), field.bits) {
                    (false, _) => Value::Word(i64::try_from(number).ok()?),
                    (true, Some((_, 1))) => Value::Bit(number != 0),
                    (true, _) => Value::whole(number),
                }
            }
            NameKind::Derived(index) => self.compute(name, &self.variant.derived.get(*index)?.1),
            NameKind::Saved(index) => self.notebook.saved.get(*index)?.clone(),
            NameKind::Elapsed => {
                let direction = match self.tick.kind {
                    TickKind::Sample | TickKind::BadSample => FrameDirection::ToController,
                    TickKind::Output => FrameDirection::ToDevice,
                    TickKind::Event => return None,
                };
                Value::nanos(self.elapsed(direction)?.as_nanos() as i128)
            }
            NameKind::Cycle => Value::nanos(self.image.cycle()?.as_nanos() as i128),
            NameKind::Bench(name) => self.notebook.bench?.of(*name, self.device.profibus().is_some()),
            NameKind::Constant(value) => value.clone(),
            NameKind::DiagnosisPending => Value::Bit(self.image.diagnosis_pending()?),
            // The requesting master derives this bit from the diagnosis.
            NameKind::Diagnosis(DiagnosisName::MasterLock) if self.read(name).is_some() => self.read(name)?.clone(),
            NameKind::Diagnosis(part) => diagnosis::value(self.device, *part, &self.image.diagnosis()?.octets, None),
            NameKind::Cyclic
            | NameKind::OutputDataStatus
            | NameKind::AlarmAcknowledge
            | NameKind::GlobalControl
            | NameKind::ClockOffset
            | NameKind::Stand(_) => return None,
        })
    }

    /// The value of an event or its parts; they have a value at the instant of the event only.
    pub fn event(&self, name: EventName) -> Option<Value> {
        let happening = &self.image.happening;
        let alarm = match happening {
            CurrentEvent::Alarm(alarm) => Some(alarm),
            _ => None,
        };
        let lldp = match happening {
            CurrentEvent::Lldp(lldp) => Some(lldp),
            _ => None,
        };
        let hello = match happening {
            CurrentEvent::Hello(hello) => Some(hello),
            _ => None,
        };
        let ready = match happening {
            CurrentEvent::Ready(alarm) => Some(*alarm),
            _ => None,
        };
        match name {
            EventName::Ready => Some(Value::Bit(ready.is_some())),
            EventName::ReadySequence => ready.map(Value::whole),
            EventName::Alarm => (alarm.is_some() || self.image.stands()).then_some(Value::Bit(alarm.is_some())),
            EventName::Abort => Some(Value::Bit(matches!(happening, CurrentEvent::Abort(_)))),
            EventName::Lldp => Some(Value::Bit(lldp.is_some())),
            EventName::LldpName => lldp?.name.as_deref().map(Value::text),
            EventName::LldpChassis => lldp?.chassis.as_deref().map(Value::bytes),
            EventName::LldpPort => lldp?.port.as_deref().map(Value::text),
            EventName::LldpMac => lldp?.mac.map(|mac| Value::bytes(&mac.0[..])),
            EventName::LldpTtl => lldp?.ttl.map(Value::whole),
            EventName::LldpBytes => lldp.map(|lldp| Value::bytes(lldp.octets.as_slice())),
            EventName::Hello => Some(Value::Bit(hello.is_some())),
            EventName::HelloName => hello?.name.as_deref().map(Value::text),
            EventName::HelloIp => hello?.ip.map(Value::Address),
            EventName::LldpSource => lldp?.source.map(|mac| Value::bytes(&mac.0[..])),
            EventName::AlarmChange => alarm?.change.map(|word| Value::Word(word.into())),
            EventName::AlarmError => alarm?.error.map(|word| Value::Word(word.into())),
            EventName::AlarmSeverity => alarm?.severity.map(|word| Value::Word(word.into())),
            EventName::AlarmType => alarm.map(|alarm| Value::Word(alarm.alarm_type.into())),
            EventName::AlarmPriority => alarm.map(|alarm| Value::Word(alarm.is_high.into())),
            EventName::AlarmPayload => alarm?.payload.as_deref().map(Value::bytes),
            EventName::AlarmSlot => alarm.map(|alarm| Value::whole(alarm.slot)),
            EventName::AlarmSubslot => alarm.map(|alarm| Value::whole(alarm.subslot)),
            EventName::AlarmChannel => alarm?.channel.map(Value::whole),
            EventName::AlarmSequence => alarm.map(|alarm| Value::whole(alarm.sequence)),
            EventName::AlarmStructure => alarm?.structure.map(Value::whole),
            EventName::AbortCode => match happening {
                // The reason is ErrorCode2, the last byte of the status.
                CurrentEvent::Abort(code) => Some(Value::Word(i64::from(code & 0xFF))),
                _ => None,
            },
        }
    }
}

/// The steps of a number that is shifted left by `shift` bits; `None` if it is not a whole number of steps.
fn steps(number: i128, shift: u32) -> Option<i128> {
    let steps = number >> shift;
    (steps << shift == number).then_some(steps)
}

/// The steps of a shifted number with a fraction: the bits below the lowest step are not 0, so it equals no whole number.
fn fraction(number: i128, shift: u32) -> Value {
    Number::new(number, 1 << shift).map_or(Value::Unknown, Value::Number)
}

/// The number in the bits `low` to `low + width - 1` of a signal.
pub fn bits(number: u64, low: u32, width: u32, signed: bool) -> i128 {
    let mask = if width >= 64 { u64::MAX } else { (1 << width) - 1 };
    let number = number.checked_shr(low).unwrap_or(0) & mask;
    let negative = signed && width > 0 && number >> (width - 1) & 1 == 1;
    if negative { i128::from(number) - (1 << width) } else { i128::from(number) }
}

fn typed(number: i128, field: Option<&SignalField>) -> Value {
    match field {
        Some(field) if !field.words.is_empty() => i64::try_from(number).map_or(Value::Unknown, Value::Word),
        Some(field) if field.width == 1 => Value::Bit(number != 0),
        _ => Value::whole(number),
    }
}

impl NameValues for NameView<'_> {
    fn value(&self, name: NameId) -> Value {
        if let Some(reads) = self.reads {
            reads.note(name);
        }
        self.known(name).unwrap_or(Value::Unknown)
    }

    fn truth(&self, name: NameId) -> Option<bool> {
        if let Some(reads) = self.reads {
            reads.note(name);
        }
        // Fast path for most names in conditions: a single bit of a signal.
        if let Some(NameKind::Signal { signal, low, width: 1, field: Some(field), circle: None, shift: 0, .. }) =
            self.kind(name)
            && let Some(SignalField { width: 1, words, .. }) = self.device.signals.get(*signal)?.fields.get(*field)
            && words.is_empty()
        {
            return Some(self.image.signal(*signal)?.checked_shr(*low).unwrap_or(0) & 1 == 1);
        }
        self.value(name).truth()
    }

    fn whole(&self, name: NameId) -> Option<Option<i128>> {
        let whole = match self.kind(name)? {
            NameKind::Signal { signal, low, width, signed, field: None, shift, .. } => {
                match self.image.signal(*signal) {
                    _ if self.device.signals.get(*signal)?.form != SignalForm::Whole => return None,
                    Some(number) => Some(steps(bits(number, *low, *width, *signed), *shift)?),
                    None => None,
                }
            }
            NameKind::Derived(_) => self.settled?.whole(name, self.parameters())?,
            _ => return None,
        };
        if let Some(reads) = self.reads {
            reads.note(name);
        }
        Some(whole)
    }

    fn fresh(&self, name: NameId) -> bool {
        let is_input = || matches!(self.tick.kind, TickKind::Sample | TickKind::BadSample);
        let is_output = || self.tick.kind == TickKind::Output;
        match self.kind(name).map_or(UpdatedAt::Always, |kind| kind.observability().updated) {
            UpdatedAt::Signal(signal) => match self.image.direction(signal) {
                Some(FrameDirection::ToController) => is_input(),
                Some(FrameDirection::ToDevice) => is_output(),
                None => false,
            },
            UpdatedAt::Output => is_output(),
            UpdatedAt::Input => is_input(),
            UpdatedAt::Event => self.tick.kind == TickKind::Event,
            UpdatedAt::Diagnosis => {
                self.tick.kind == TickKind::Event && self.image.happening == CurrentEvent::Diagnosis
            }
            UpdatedAt::Always => true,
        }
    }

    fn now(&self) -> Time {
        if let Some(reads) = self.reads {
            reads.time.set(true);
        }
        self.tick.time
    }

    fn position_noise(&self) -> u32 {
        self.notebook.noise
    }
}
