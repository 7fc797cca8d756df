//! What a device did in each step of a trial that is recorded and not judged: its answers, and each change of what it sends.
//!
//! Nothing ends such a trial: whatever the device answers, the next step follows.

use expression::Value;
use judge::answer::ReceivedReply;
use judge::image::{ConnectionImage, CurrentEvent};
use judge::observed_state::ObservedState;
use judge::{JudgeTick, TickKind};
use station::{Duration, Time};
use suite::device::{DeviceDescription, EventName, SignalSender};
use suite::model::AnswerPart;

/// The steps of a trial, and what is wrong on the bus whatever the device is.
#[derive(Clone, Debug, Default)]
pub struct StepLog {
    /// The steps in their order, blocks without the steps in them.
    pub steps: Vec<LoggedStep>,
    /// Answers that fit no request, frames out of turn, unreadable frames, and a device that is silent at the end.
    pub protocol_errors: Vec<ProtocolError>,
    watch: Watch,
}

/// What is wrong on the bus whatever the device is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProtocolError {
    /// The kind, one word for each.
    pub kind: &'static str,
    pub what: String,
}

/// A step with what the device did until the next one.
#[derive(Clone, Debug, Default)]
pub struct LoggedStep {
    /// The line of the step in its file.
    pub line: u32,
    pub began: Time,
    pub ended: Time,
    /// The number of the last frame of the step.
    pub frame: u64,
    /// Why the step could not be done.
    pub error: Option<String>,
    /// The answer of the device, by its parts.
    pub answers: Vec<(AnswerPart, ReceivedReply)>,
    /// The values that were read.
    pub reads: Vec<(String, Value)>,
    /// The changes of what the device sends by itself.
    pub changes: Vec<LoggedChange>,
}

/// A change of what the device sends by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedChange {
    /// The time since the begin of the step.
    pub after: Duration,
    pub frame: u64,
    pub what: Observed,
}

/// A value or an event.
#[derive(Clone, Debug, PartialEq)]
pub enum Observed {
    /// A value that is now another one; `None` if it is unknown.
    Value(ObservedName, Option<u64>),
    /// An alarm, an abort or an announcement: its names with their values.
    Event(Vec<(String, Value)>),
}

/// What a device sends by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ObservedName {
    /// `connection`.
    Connection,
    /// An input signal (index into `device.signals`).
    Signal(usize),
    /// The status of the inputs of a submodule.
    InputStatus(usize),
    /// The status with which the device takes in the outputs of a submodule.
    ConsumerStatus(usize),
    /// Whether a diagnosis is pending (PROFIBUS).
    DiagnosisPending,
    /// DataStatus of the frames (PROFINET).
    DataStatus,
    /// The length of the inputs in bytes.
    InputLength,
    /// An LED.
    Led(usize),
}

/// The parts of an event that are recorded. Sequence numbers are not: they depend on what was before.
const EVENTS: [(EventName, &str); 16] = [
    (EventName::AlarmError, "alarm.error"),
    (EventName::AlarmChange, "alarm.change"),
    (EventName::AlarmSeverity, "alarm.severity"),
    (EventName::AlarmType, "alarm.type"),
    (EventName::AlarmPriority, "alarm.priority"),
    (EventName::AlarmSlot, "alarm.slot"),
    (EventName::AlarmSubslot, "alarm.subslot"),
    (EventName::AlarmChannel, "alarm.channel"),
    (EventName::AlarmStructure, "alarm.structure"),
    (EventName::AlarmPayload, "alarm.payload"),
    (EventName::AbortCode, "abort.code"),
    (EventName::LldpName, "lldp.name"),
    (EventName::LldpPort, "lldp.port"),
    (EventName::LldpTtl, "lldp.ttl"),
    (EventName::HelloName, "hello.name"),
    (EventName::HelloIp, "hello.ip"),
];

/// The last values of what is recorded.
#[derive(Clone, Debug, Default)]
struct Watch {
    names: Vec<(ObservedName, Option<u64>)>,
    changes: Vec<LoggedChange>,
    began: Time,
}

impl StepLog {
    /// A log without steps for a device.
    pub fn new(device: &DeviceDescription) -> StepLog {
        let signals = device.signals.iter().enumerate().filter(|(_, of)| of.from == SignalSender::Device);
        let mut names = vec![ObservedName::Connection];
        names.extend(signals.map(|(index, _)| ObservedName::Signal(index)));
        for index in 0..device.submodules.len() {
            if device.profinet().is_some() {
                names.extend([ObservedName::InputStatus(index), ObservedName::ConsumerStatus(index)]);
            }
        }
        match device.profinet() {
            Some(_) => names.push(ObservedName::DataStatus),
            None => names.push(ObservedName::DiagnosisPending),
        }
        names.push(ObservedName::InputLength);
        names.extend((0..device.stand.leds.len()).map(ObservedName::Led));
        let watch = Watch { names: names.into_iter().map(|name| (name, None)).collect(), ..Watch::default() };
        StepLog { watch, ..StepLog::default() }
    }

    /// Takes in a frame or an event of the connection.
    pub fn tick(&mut self, scene: &ObservedState<'_>, tick: JudgeTick) {
        let image = &scene.follower.image;
        let after = tick.time.since(self.watch.began);
        if tick.kind != TickKind::Output {
            for (name, last) in &mut self.watch.names {
                let value = present(*name, image, scene);
                if value != *last {
                    *last = value;
                    let what = Observed::Value(*name, value);
                    self.watch.changes.push(LoggedChange { after, frame: tick.frame, what });
                }
            }
        }
        if tick.kind == TickKind::Event
            && !matches!(image.happening, CurrentEvent::Nothing | CurrentEvent::Diagnosis | CurrentEvent::Ready(_))
        {
            let view = scene.view(tick);
            let named =
                EVENTS.iter().filter_map(|(name, path)| Some(((*path).to_owned(), view.event(*name)?))).collect();
            self.watch.changes.push(LoggedChange { after, frame: tick.frame, what: Observed::Event(named) });
        }
    }

    /// A step begins.
    pub fn begin(&mut self, now: Time) {
        self.watch.began = now;
    }

    /// A step has ended.
    pub fn end(&mut self, step: LoggedStep) {
        let changes = std::mem::take(&mut self.watch.changes);
        self.steps.push(LoggedStep { changes, began: self.watch.began, ..step });
    }
}

fn present(name: ObservedName, image: &ConnectionImage, scene: &ObservedState<'_>) -> Option<u64> {
    match name {
        ObservedName::Connection => Some(image.stands().into()),
        ObservedName::Signal(signal) => image.signal(signal),
        ObservedName::InputStatus(submodule) => image.input_status(Some(submodule)).map(u64::from),
        ObservedName::ConsumerStatus(submodule) => image.consumer_status(Some(submodule)).map(u64::from),
        ObservedName::DiagnosisPending => image.diagnosis_pending().map(u64::from),
        ObservedName::DataStatus => image.input_apdu().map(|apdu| apdu.data_status.0.into()),
        ObservedName::InputLength => image.input_length().map(|length| length as u64),
        ObservedName::Led(led) => {
            scene.notebook().leds.get(led).copied().flatten().and_then(|word| word.try_into().ok())
        }
    }
}
