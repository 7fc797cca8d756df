//! Each name made from its path: the table under "Names" of `docs/suite-language.md`.

use super::super::device_yaml::parameter_number;
use super::{Names, Verbs, built_in, field_type, plain_words};
use expression::{Circle, Number, NumberType, Type, Value, WordTable};
use suite::device::{
    AnswerPart, BenchName, DeviceParameter, DeviceSignal, EventName, NameKind, OurSpan, PageForm, PrintedSpan,
    SignalForm, SignalSender, StandName, StationName,
};
use suite::words;
use wire::profinet::alarm::AlarmType;
use wire::profinet::status::AbortReason;

/// What a path is, or what is wrong with it and what to write instead.
pub(super) type Built = Result<(NameKind, Type, Verbs), (String, Option<String>)>;

/// The type of a scaled number: a literal that no number on the wire comes near is out of range.
fn scaled_type(signal: &DeviceSignal) -> Type {
    let all = 1i128 << signal.width.clamp(1, 64);
    let ends = if signal.signed { [-(all / 2), all / 2 - 1] } else { [0, all - 1] };
    let values = ends.map(|raw| match signal.form.value(raw, signal.width) {
        Value::Number(number) => Some(number),
        _ => None,
    });
    let limits = match values {
        [Some(one), Some(other)] => {
            let above = one.max(other).negated().floor().negated();
            one.min(other).floor().as_whole().zip(above.as_whole())
        }
        _ => None,
    };
    Type::Number(NumberType { limits, ..NumberType::FRACTION })
}

/// An address of the bench.
fn bench(rest: &str) -> Option<Built> {
    let name = match rest {
        "address" => BenchName::Address,
        "ip" => BenchName::Ip,
        "mask" => BenchName::Mask,
        "free_ip" => BenchName::FreeIp,
        _ => return None,
    };
    good(NameKind::Bench(name), Type::Address, Verbs::NONE)
}

impl Names<'_> {
    /// What the path stands for; none if nothing begins like it.
    pub(super) fn build(&self, path: &str) -> Option<Built> {
        let (head, rest) = match path.split_once('.') {
            Some((head, rest)) => (head, Some(rest)),
            None => (path, None),
        };
        if let Some(built) = self.signal(head, rest).or_else(|| self.record(head, rest)) {
            return Some(built);
        }
        if let Some(built) = self.of_bus(head, rest) {
            return built;
        }
        if let Some(number) = parameter_number(head) {
            return Some(self.parameter(head, number, rest));
        }
        match (head, rest) {
            ("io", Some(rest)) => self.io(rest),
            ("connection", None) => {
                good(NameKind::Connection, built_in("connection", words::CONNECTION), Verbs::EXPECT)
            }
            ("station", Some(rest)) => station(rest),
            (
                "power" | "link" | "device" | "shaft" | "fault" | "button" | "switch" | "supply" | "led" | "counter",
                _,
            ) => self.stand(head, rest),
            ("alarm" | "abort" | "lldp" | "hello" | "ready", _) => self.event(head, rest),
            ("answer", rest) => self.answer(rest),
            ("page", Some(rest)) => Some(self.page(rest)),
            ("bench", Some(rest)) => bench(rest),
            ("elapsed", None) => good(NameKind::Elapsed, Type::Time, Verbs::EXPECT),
            ("cycle", None) => good(NameKind::Cycle, Type::Time, Verbs::NONE),
            ("timing" | "tolerance" | "printed", Some(name)) => self.span(head, name),
            (name, None) => self.value(name),
            _ => None,
        }
    }

    fn signal(&self, head: &str, rest: Option<&str>) -> Option<Built> {
        let device = self.device();
        let index = device.signals.iter().position(|signal| signal.name == head)?;
        let signal = &device.signals[index];
        let verbs = match signal.from {
            SignalSender::Controller => Verbs::SET.and(Verbs::EXPECT),
            SignalSender::Device => Verbs::EXPECT,
        };
        let Some(rest) = rest else {
            self.mark("signal", head);
            let number = signal
                .position_in
                .as_ref()
                .and_then(|text| self.described.circles.iter().position(|node| node.scalar() == Some(text)));
            let shift = signal.shift.get(self.variant).copied().unwrap_or_default();
            let circle = number.and_then(|number| self.circles.borrow().get(number).cloned().flatten());
            let ty = match (number, signal.form) {
                (Some(number), _) => Type::Place(Circle(number as u32)),
                (None, SignalForm::Whole) => Type::whole(signal.width - shift, signal.signed),
                (None, SignalForm::Scaled { .. }) => scaled_type(signal),
                (None, SignalForm::Float) => Type::FRACTION,
                (None, SignalForm::Text) => Type::Text,
            };
            let code_when = match signal.code_when.as_ref().map(|bit| self.find(bit)) {
                Some(Some(Ok(bit))) => Some(bit.id),
                _ => None,
            };
            let kind = NameKind::Signal {
                signal: index,
                low: 0,
                width: signal.width,
                signed: signal.signed,
                field: None,
                circle,
                code_when,
                shift,
            };
            return Some(Ok((kind, ty, verbs)));
        };
        let Some(field) = signal.fields.iter().position(|field| field.name == rest) else {
            return Some(unknown("field", rest, head, signal.fields.iter().map(|field| field.name.as_str())));
        };
        self.mark("signal", head);
        self.mark("field", &format!("{head}.{rest}"));
        let of = &signal.fields[field];
        let kind = NameKind::Signal {
            signal: index,
            low: of.low,
            width: of.width,
            signed: of.signed,
            field: Some(field),
            circle: None,
            code_when: None,
            shift: 0,
        };
        Some(Ok((kind, field_type(of.table.as_ref(), of.width, of.signed), verbs)))
    }

    fn record(&self, head: &str, rest: Option<&str>) -> Option<Built> {
        let device = self.device();
        // The only record of a slave goes with a start-up and with nothing else.
        let index = device.records.iter().position(|record| record.name == head && device.profibus().is_none())?;
        let record = &device.records[index];
        let verbs = Verbs::READ.and(Verbs::WRITE);
        let Some(rest) = rest else {
            self.mark("record", head);
            return Some(Ok((NameKind::Record { record: index, field: None }, Type::Bytes, verbs)));
        };
        let Some(field) = record.fields.iter().position(|field| field.name == rest) else {
            return Some(unknown("field", rest, head, record.fields.iter().map(|field| field.name.as_str())));
        };
        self.mark("record", head);
        self.mark("field", &format!("{head}.{rest}"));
        Some(Ok((NameKind::Record { record: index, field: Some(field) }, self.record_type(index, field), verbs)))
    }

    /// The type of a field of a record.
    pub(in super::super) fn record_type(&self, record: usize, field: usize) -> Type {
        match self.device().records.get(record).and_then(|record| record.fields.get(field)) {
            Some(field) if field.text => Type::Text,
            Some(field) => match field.bits {
                Some((_, width)) => field_type(field.table.as_ref(), width, false),
                None => field_type(field.table.as_ref(), field.octets as u32 * 8, false),
            },
            None => Type::WHOLE,
        }
    }

    fn parameter(&self, head: &str, number: u16, rest: Option<&str>) -> Built {
        let device = self.device();
        let verbs = Verbs::READ.and(Verbs::WRITE);
        let index = device.parameters.iter().position(|parameter| parameter.number == number);
        let Some((index, parameter)) = index.map(|index| (index, &device.parameters[index])) else {
            return match rest {
                None => Ok((
                    NameKind::Parameter { parameter: None, number, subindex: 0, bits: None },
                    Type::whole(32, false),
                    verbs,
                )),
                Some(_) => Err((format!("the device has no parameter {head}, so it has no elements"), None)),
            };
        };
        self.mark("parameter", head);
        let whole = |subindex: u16| NameKind::Parameter { parameter: Some(index), number, subindex, bits: None };
        let Some(rest) = rest else { return Ok((whole(0), parameter_type(parameter), verbs)) };
        if let Ok(subindex) = rest.parse::<u16>() {
            return match parameter.elements.iter().find(|(_, known)| *known == subindex) {
                Some((name, _)) => {
                    Err((format!("the element {subindex} of {head} has a name"), Some(format!("write {head}.{name}"))))
                }
                None => Ok((whole(subindex), parameter_type(parameter), verbs)),
            };
        }
        let (element, bit) = match rest.split_once('.') {
            Some((element, bit)) => (element, Some(bit)),
            None if parameter.elements.is_empty() => ("", Some(rest)),
            None => (rest, None),
        };
        let subindex = match parameter.elements.iter().find(|(name, _)| name == element) {
            Some((_, subindex)) => {
                self.mark("element", &format!("{head}.{element}"));
                *subindex
            }
            None if element.is_empty() => 0,
            None => return unknown("element", element, head, parameter.elements.iter().map(|(name, _)| name.as_str())),
        };
        let Some(bit) = bit else { return Ok((whole(subindex), parameter_type(parameter), verbs)) };
        let fields = parameter.bits.iter().find(|(of, _)| of == element).map_or(&[][..], |(_, fields)| fields);
        let Some(field) = fields.iter().find(|field| field.name == bit) else {
            return unknown("bit", bit, head, fields.iter().map(|field| field.name.as_str()));
        };
        self.mark(
            "field",
            &format!(
                "{path}.{bit}",
                path = if element.is_empty() { head.to_owned() } else { format!("{head}.{element}") }
            ),
        );
        let kind =
            NameKind::Parameter { parameter: Some(index), number, subindex, bits: Some((field.low, field.width)) };
        Ok((kind, field_type(field.table.as_ref(), field.width, field.signed), Verbs::READ))
    }

    fn io(&self, rest: &str) -> Option<Built> {
        let status = || built_in("status", words::STATUS);
        let (head, of) = match rest.split_once('.') {
            Some((head, of)) => (head, Some(of)),
            None => (rest, None),
        };
        let submodules = &self.device().submodules;
        let submodule = match of {
            None => None,
            Some(of) => match submodules.iter().position(|submodule| submodule.name == of) {
                Some(index) => {
                    self.mark("submodule", of);
                    Some(index)
                }
                None => {
                    return Some(unknown(
                        "submodule",
                        of,
                        head,
                        submodules.iter().map(|submodule| submodule.name.as_str()),
                    ));
                }
            },
        };
        match (head, submodule) {
            ("output_status", of) => good(NameKind::OutputStatus(of), status(), Verbs::SET.and(Verbs::EXPECT)),
            ("input_status", of) => good(NameKind::InputStatus(of), status(), Verbs::EXPECT),
            ("consumer_status", of) => good(NameKind::ConsumerStatus(of), status(), Verbs::EXPECT),
            ("outputs", None) => good(NameKind::OutputOctets(None), Type::Bytes, Verbs::SET.and(Verbs::EXPECT)),
            ("outputs", of) => good(NameKind::OutputOctets(of), Type::Bytes, Verbs::EXPECT),
            ("inputs", of) => good(NameKind::InputOctets(of), Type::Bytes, Verbs::EXPECT),
            ("input_length", None) => good(NameKind::InputLength, Type::whole(16, false), Verbs::EXPECT),
            ("input_data_status", None) => good(NameKind::InputDataStatus, Type::whole(8, false), Verbs::EXPECT),
            ("input_counter", None) => good(NameKind::InputCounter, Type::whole(16, false), Verbs::EXPECT),
            ("output_data_status", None) => good(NameKind::OutputDataStatus, Type::whole(8, false), Verbs::SET),
            ("cyclic", None) => good(NameKind::Cyclic, built_in("io.cyclic", words::CYCLIC), Verbs::SET),
            ("alarm_acknowledge", None) => {
                let word = built_in("io.alarm_acknowledge", words::ALARM_ACKNOWLEDGE);
                good(NameKind::AlarmAcknowledge, word, Verbs::SET)
            }
            _ => None,
        }
    }

    fn stand(&self, head: &str, rest: Option<&str>) -> Option<Built> {
        let stand = &self.device().stand;
        let set = |name: StandName, ty: Type| good(NameKind::Stand(name), ty, Verbs::SET);
        let place = |list: &[&str], name: &str| {
            let found = list.iter().position(|known| *known == name);
            if found.is_some() {
                self.mark(head, name);
            }
            found
        };
        let faults: Vec<&str> = stand.faults.iter().map(|(name, _)| name.as_str()).collect();
        let buttons: Vec<&str> = stand.buttons.iter().map(|(name, _)| name.as_str()).collect();
        let switches: Vec<&str> = stand.switches.iter().map(|switch| switch.name.as_str()).collect();
        let leds: Vec<&str> = stand.leds.iter().map(|(name, _)| name.as_str()).collect();
        let counters: Vec<&str> = stand.counters.iter().map(|(name, _)| name.as_str()).collect();
        let homeless = |name: &str, usual: &str| {
            let help = format!("write `supply: {{ {name}: {usual} }}` under `stand` in device.yaml");
            Some(Err((format!("what `supply.{name}` is put back to after a trial is not said"), Some(help))))
        };
        let missing = |known: Vec<&str>, name: &str| Some(unknown(head, name, "the stand", known));
        match (head, rest) {
            ("power", None) => set(StandName::Power, built_in("power", words::UP_DOWN)),
            ("link", None) => set(StandName::Link, built_in("link", words::UP_DOWN)),
            ("device", None) => set(StandName::Delivery, built_in("device", words::DELIVERY)),
            ("shaft", Some("speed")) => set(StandName::ShaftSpeed, Type::FRACTION),
            ("shaft", Some("counts")) => set(StandName::ShaftCounts, Type::whole(64, false)),
            ("shaft", Some("acceleration")) => set(StandName::ShaftAcceleration, Type::FRACTION),
            ("supply", Some("voltage")) if stand.voltage.is_none() => homeless("voltage", "24"),
            ("supply", Some("temperature")) if stand.temperature.is_none() => homeless("temperature", "25"),
            ("supply", Some("voltage")) => set(StandName::SupplyVoltage, Type::FRACTION),
            ("supply", Some("temperature")) => set(StandName::Temperature, Type::FRACTION),
            ("fault", Some(name)) => match place(&faults, name) {
                Some(index) => set(StandName::Fault(index), built_in("fault", words::PRESENCE)),
                None => missing(faults, name),
            },
            ("button", Some(name)) => match place(&buttons, name) {
                Some(index) => set(StandName::Button(index), built_in("button", words::BUTTON)),
                None => missing(buttons, name),
            },
            ("switch", Some(name)) => match place(&switches, name) {
                Some(index) => {
                    let switch = &stand.switches[index];
                    let limits = Some((switch.lowest.into(), switch.highest.into()));
                    let kind = NumberType { limits, ..NumberType::WHOLE };
                    set(StandName::Switch(index), Type::Number(kind))
                }
                None => missing(switches, name),
            },
            ("led", Some(name)) => match place(&leds, name) {
                Some(index) => good(
                    NameKind::Led(index),
                    plain_words(&format!("led.{name}"), stand.leds[index].1.clone()),
                    Verbs::EXPECT,
                ),
                None => missing(leds, name),
            },
            ("counter", Some(name)) => match place(&counters, name) {
                Some(index) => good(NameKind::Counter(index), Type::whole(64, false), Verbs::READ),
                None => missing(counters, name),
            },
            _ => None,
        }
    }

    fn event(&self, head: &str, rest: Option<&str>) -> Option<Built> {
        let event = |name: EventName, ty: Type| good(NameKind::Event(name), ty, Verbs::EXPECT);
        match (head, rest) {
            ("alarm", None) => event(EventName::Alarm, Type::Bit),
            ("alarm", Some("change")) => event(EventName::AlarmChange, built_in("alarm.change", words::ALARM_CHANGE)),
            ("alarm", Some("severity")) => {
                event(EventName::AlarmSeverity, built_in("alarm.severity", words::ALARM_SEVERITY))
            }
            ("alarm", Some("error")) => {
                let codes = self
                    .device()
                    .codes
                    .iter()
                    .find(|(table, _)| table == "channel_error")
                    .map_or(&[][..], |(_, words)| words);
                let table = WordTable::new(
                    "channel_error",
                    codes.iter().map(|(word, number)| (word.clone(), i64::from(*number))),
                );
                event(EventName::AlarmError, Type::Word(table))
            }
            ("alarm", Some("type")) => {
                let types = AlarmType::TABLE.iter().map(|(code, word, _)| (*word, i64::from(code.0)));
                event(EventName::AlarmType, Type::Word(WordTable::new("alarm.type", types)))
            }
            ("alarm", Some("priority")) => {
                event(EventName::AlarmPriority, built_in("alarm.priority", words::ALARM_PRIORITY))
            }
            ("alarm", Some("payload")) => event(EventName::AlarmPayload, Type::Bytes),
            ("alarm", Some("slot")) => event(EventName::AlarmSlot, Type::whole(16, false)),
            ("alarm", Some("subslot")) => event(EventName::AlarmSubslot, Type::whole(16, false)),
            ("alarm", Some("channel")) => event(EventName::AlarmChannel, Type::whole(16, false)),
            ("alarm", Some("structure")) => event(EventName::AlarmStructure, Type::whole(16, false)),
            ("alarm", Some("sequence")) => event(EventName::AlarmSequence, Type::whole(11, false)),
            ("abort", None) => event(EventName::Abort, Type::Bit),
            ("abort", Some("code")) => {
                let table = WordTable::new(
                    "abort.code",
                    AbortReason::TABLE.iter().map(|(code, word, _)| (*word, i64::from(code.0))),
                );
                event(EventName::AbortCode, Type::Word(table))
            }
            ("lldp", None) => event(EventName::Lldp, Type::Bit),
            ("lldp", Some("name")) => event(EventName::LldpName, Type::Text),
            ("lldp", Some("chassis")) => event(EventName::LldpChassis, Type::Bytes),
            ("lldp", Some("port")) => event(EventName::LldpPort, Type::Text),
            ("lldp", Some("mac")) => event(EventName::LldpMac, Type::Bytes),
            ("lldp", Some("ttl")) => event(EventName::LldpTtl, Type::whole(16, false)),
            ("lldp", Some("bytes")) => event(EventName::LldpBytes, Type::Bytes),
            ("hello", None) => event(EventName::Hello, Type::Bit),
            ("hello", Some("name")) => event(EventName::HelloName, Type::Text),
            ("hello", Some("ip")) => event(EventName::HelloIp, Type::Address),
            ("ready", None) => event(EventName::Ready, Type::Bit),
            ("ready", Some("sequence")) => event(EventName::ReadySequence, Type::whole(16, false)),
            ("lldp", Some("source")) => event(EventName::LldpSource, Type::Bytes),
            _ => None,
        }
    }

    fn answer(&self, rest: Option<&str>) -> Option<Built> {
        let device = self.device();
        let part = match rest {
            None => AnswerPart::Whole,
            Some("bytes") => AnswerPart::Bytes,
            Some("set_prm") if device.profibus().is_some() => AnswerPart::SetPrm,
            Some("chk_cfg") if device.profibus().is_some() => AnswerPart::ChkCfg,
            Some("connect") => AnswerPart::Connect,
            Some("parameter_end") => AnswerPart::ParameterEnd,
            Some("application_ready") => AnswerPart::ApplicationReady,
            Some("status") => AnswerPart::Status,
            Some("contains") => AnswerPart::Contains,
            Some("lacks") => AnswerPart::Lacks,
            Some("text") => AnswerPart::Text,
            Some("number") if device.profinet().is_some() => AnswerPart::Number,
            Some(rest) => {
                if let Some(record) = device.records.iter().position(|record| record.name == rest) {
                    AnswerPart::Record(record)
                } else {
                    match self.find(rest)? {
                        Ok(super::Name { kind: NameKind::Parameter { number, subindex, bits: None, .. }, .. }) => {
                            AnswerPart::Parameter(number, subindex)
                        }
                        Ok(_) => return None,
                        Err(wrong) => return Some(Err(wrong)),
                    }
                }
            }
        };
        let ty = match part {
            AnswerPart::Bytes => Type::Bytes,
            AnswerPart::Status => Type::whole(16, false),
            AnswerPart::Number => Type::whole(32, false),
            AnswerPart::Contains | AnswerPart::Lacks | AnswerPart::Text => Type::Text,
            _ => Type::Bit,
        };
        good(NameKind::Answer(part), ty, Verbs::EXPECT)
    }

    fn page(&self, name: &str) -> Built {
        let pages = &self.device().pages;
        let place = |page: usize| Some((page, pages[page].shows.iter().position(|value| value.name == name)?));
        let Some((page, value)) = (0..pages.len()).find_map(place) else {
            let known = pages.iter().flat_map(|page| &page.shows).map(|value| value.name.as_str());
            return unknown("value", name, "the web pages", known);
        };
        self.mark("page", &pages[page].name);
        self.mark("page value", name);
        let of = &pages[page].shows[value];
        let ty = match (&of.table, of.form) {
            (Some(table), _) => Type::Word(table.clone()),
            (None, PageForm::Text) => Type::Text,
            (None, _) => Type::Number(NumberType { steps: of.steps, ..NumberType::WHOLE }),
        };
        Ok((NameKind::Page { page, value }, ty, Verbs::READ))
    }

    /// A time of ours (`timing`), a tolerance of ours (`tolerance`), or what the manual prints (`printed`).
    fn span<'s>(&'s self, head: &str, name: &str) -> Option<Built> {
        let timing = &self.device().timing;
        if (head, name) == ("timing", "patience") {
            let factor = Value::Number(Number::whole(timing.patience.into()));
            return good(NameKind::Constant(factor), Type::WHOLE, Verbs::NONE);
        }
        let ours = |list: &'s [OurSpan]| list.iter().map(|of| (of.name.as_str(), Some(&of.value))).collect();
        let printed = |of: &'s PrintedSpan| (of.name.as_str(), of.values.get(self.variant));
        let (what, spans): (&str, Vec<(&str, Option<&Value>)>) = match head {
            "timing" => ("time", ours(&timing.ours)),
            "tolerance" => ("tolerance", ours(&timing.tolerances)),
            _ => ("printed value", timing.printed.iter().map(printed).collect()),
        };
        let Some(value) = spans.iter().find(|(known, _)| *known == name).and_then(|(_, value)| *value) else {
            return Some(unknown(what, name, head, spans.iter().map(|(known, _)| *known)));
        };
        self.mark(what, name);
        let ty = match value {
            Value::Time(_) => Type::Time,
            Value::Cycles(_) => Type::Cycles,
            Value::Number(number) if number.is_whole() => Type::WHOLE,
            _ => Type::FRACTION,
        };
        good(NameKind::Constant(value.clone()), ty, Verbs::NONE)
    }

    /// Constants, start parameters and derived values.
    fn value(&self, name: &str) -> Option<Built> {
        if let Some((_, values)) = self.described.constants.iter().find(|(known, _)| known == name) {
            self.mark("constant", name);
            let value = *values.get(self.variant)?;
            let ty = if value.is_whole() { Type::WHOLE } else { Type::FRACTION };
            return good(NameKind::Constant(Value::Number(value)), ty, Verbs::NONE);
        }
        let starts = self.device().records.iter().enumerate().filter(|(_, record)| record.start);
        for (record, of) in starts {
            if let Some(field) = of.fields.iter().position(|field| field.name == name) {
                self.mark("record", &of.name);
                self.mark("field", &format!("{}.{name}", of.name));
                return good(NameKind::StartParameter { record, field }, self.record_type(record, field), Verbs::NONE);
            }
        }
        let derived = self.derived.borrow();
        let index = derived.iter().position(|(known, _)| known == name)?;
        self.mark("derived value", name);
        good(NameKind::Derived(index), derived[index].1.ty().clone(), Verbs::NONE)
    }
}

pub(super) fn good(kind: NameKind, ty: Type, verbs: Verbs) -> Option<Built> {
    Some(Ok((kind, ty, verbs)))
}

pub(super) fn unknown<'a>(what: &str, name: &str, of: &str, known: impl IntoIterator<Item = &'a str>) -> Built {
    let help = plain_text::nearest(name, known).map(|meant| format!("did you mean `{meant}`?"));
    Err((format!("unknown {what} `{name}` of {of}"), help))
}

fn station(rest: &str) -> Option<Built> {
    let both = Verbs::READ.and(Verbs::WRITE);
    let (name, ty, verbs) = match rest {
        "name" => (StationName::Name, Type::Text, both),
        "ip" => (StationName::Ip, Type::Address, both),
        "mask" => (StationName::Mask, Type::Address, both),
        "gateway" => (StationName::Gateway, Type::Address, both),
        "vendor_id" => (StationName::VendorId, Type::whole(16, false), Verbs::READ),
        "device_id" => (StationName::DeviceId, Type::whole(16, false), Verbs::READ),
        "type" => (StationName::Type, Type::Text, Verbs::READ),
        "mac" => (StationName::Mac, Type::Bytes, Verbs::READ),
        _ => return None,
    };
    good(NameKind::Station(name), ty, verbs)
}

/// The type of an element of a parameter.
fn parameter_type(parameter: &DeviceParameter) -> Type {
    match (parameter.kind.text, parameter.kind.octets) {
        (true, _) => Type::Text,
        (false, Some(_)) => Type::Bytes,
        (false, None) => Type::whole(parameter.kind.width, parameter.kind.signed),
    }
}
