//! Extracts from frames the conversation of a controller and a device, by the names of the manual.
//!
//! The connections come from the tracker, the layout of the data from the image on which rules are judged. Of several devices in a
//! trace that fit the manual it follows the first. This module must not know how the conversation is used.

mod clock;
mod connect;
mod others;
mod outputs;
mod parts;
mod requests;
mod slave;

use super::action::ControllerAction;
use super::conversation::{AnsweredAction, Conversation, DeviceEvent, SkippedAction, SuiteValue};
use judge::follow::{ConnectionChange, Ending, Follower};
use judge::image::{ConnectionImage, CurrentEvent, ObservedAlarm};
use judge::observe::{Address, ArId, ArStage, BusTracker, FrameDirection, Observation, ObservedAr, Role, Traffic};
use judge::{JudgeTick, TickKind};
use outputs::OutputTracker;
use parts::{CyclicName, carried, parts};
use replay::{fits_manual, fits_modules};
use requests::RecordTarget;
use slave::SlaveStartUp;
use station::Time;
use suite::device::{DeviceDescription, SignalSender};
use suite::model::Manual;
use suite::words;
use wire::ethernet::Mac;
use wire::profidrive::ParameterRequest;
use wire::profinet::status::{AbortReason, PnioStatus, RecordError};

/// If the next connection follows an end within this many cycles, the end belongs to it.
const RECONNECT: u32 = 3;

/// A variant of a manual.
#[derive(Clone, Copy, Debug)]
pub struct ManualVariant<'m> {
    pub manual: &'m Manual,
    /// The index of the variant among those of the device.
    pub variant: usize,
}

/// Extracts the conversation from the frames of a run: number from 1, time, bytes. The device may have other vendor and device IDs.
pub fn extract<'f>(whom: ManualVariant<'_>, frames: impl Iterator<Item = (u64, Time, &'f [u8])>) -> Conversation {
    let mut ear = ConversationReader::of_any_identity(whom);
    for (number, time, octets) in frames {
        ear.frame(number, time, octets);
    }
    ear.end()
}

/// Extracts a conversation frame by frame; it keeps only the conversation.
pub struct ConversationReader<'m> {
    tracker: BusTracker,
    listener: ConversationState<'m>,
}

impl<'m> ConversationReader<'m> {
    /// No frame yet.
    pub fn new(whom: ManualVariant<'m>) -> ConversationReader<'m> {
        let tracker = BusTracker::new(whom.manual.device.bus.kind());
        ConversationReader { tracker, listener: ConversationState::new(whom) }
    }

    /// No frame yet; a device is also followed if only the idents of its submodules are those of the manual.
    pub fn of_any_identity(whom: ManualVariant<'m>) -> ConversationReader<'m> {
        let mut reader = ConversationReader::new(whom);
        reader.listener.any_identity = true;
        reader
    }

    /// Takes in one frame of the manual's bus; `number` counts from 1.
    pub fn frame(&mut self, number: u64, time: Time, octets: &[u8]) {
        let ConversationReader { tracker, listener } = self;
        listener.now = (time, number);
        tracker.frame(number, time, octets, &mut |ars, observation| listener.observe(ars, &observation));
    }

    /// The whole conversation.
    pub fn end(self) -> Conversation {
        let ars = self.tracker.ars().to_vec();
        self.listener.end(&ars)
    }
}

/// The state between two frames.
struct ConversationState<'m> {
    manual: &'m Manual,
    device: &'m DeviceDescription,
    variant: usize,
    /// Whether vendor and device ID may be others than those of the manual.
    any_identity: bool,
    follower: Follower,
    inputs: Vec<CyclicName>,
    outputs: OutputTracker,
    conversation: Conversation,
    /// Controller and device, known from the first connection on.
    pair: Option<(Address, Address)>,
    /// The Connect that is not complete: its index among the actions, and its connection.
    open: Option<(usize, ArId)>,
    /// The last Connect that led to good data.
    stood: Option<(usize, ArId)>,
    /// A parameter request without answer so far.
    pending: Option<(RecordTarget, Vec<u8>, Time, u64)>,
    /// DCP Sets before the device was known, with their destination and transaction.
    early: Vec<(Mac, u32, AnsweredAction)>,
    /// The last DCP Set without answer so far: its transaction and its index among the actions.
    unanswered: Option<(u32, usize)>,
    /// An alarm of the device that is not acknowledged.
    alarm: Option<(Time, u64)>,
    /// The start-up of a slave.
    start_up: SlaveStartUp,
    /// The time of the last outputs.
    last_output: Option<Time>,
    /// Whether the outputs are paused.
    paused: bool,
    /// Whether the last outputs were good; `None` until the first good ones.
    output_good: Option<bool>,
    now: (Time, u64),
}

impl<'m> ConversationState<'m> {
    fn new(ManualVariant { manual, variant }: ManualVariant<'m>) -> ConversationState<'m> {
        let device: &DeviceDescription = &manual.device;
        ConversationState {
            manual,
            device,
            variant,
            any_identity: false,
            follower: Follower::new(device),
            inputs: parts(device, variant, SignalSender::Device),
            outputs: OutputTracker::new(parts(device, variant, SignalSender::Controller)),
            conversation: Conversation::default(),
            pair: None,
            open: None,
            stood: None,
            pending: None,
            early: Vec::new(),
            unanswered: None,
            alarm: None,
            start_up: SlaveStartUp::default(),
            last_output: None,
            paused: false,
            output_good: None,
            now: (Time::ZERO, 0),
        }
    }

    fn ask(&mut self, at: Time, ask: ControllerAction, answer: Vec<(String, SuiteValue)>) {
        let (done, frame) = self.now;
        self.conversation.actions.push(AnsweredAction { answer, ..AnsweredAction::new(ask, (at, done), frame) });
    }

    /// Notes an action that cannot be repeated and changes nothing.
    fn left_out(&mut self, what: impl Into<String>) {
        self.conversation.left_out.push(SkippedAction {
            frame: self.now.1,
            what: what.into(),
            since: None,
            until: None,
        });
    }

    /// Notes an action that cannot be repeated and changes later answers of the device.
    fn left_open(&mut self, since: Time, what: impl Into<String>) {
        self.conversation.left_out.push(SkippedAction {
            frame: self.now.1,
            what: what.into(),
            since: Some(since),
            until: None,
        });
    }

    fn fits(&self, ar: &ObservedAr) -> bool {
        fits_manual(self.manual, ar) || (self.any_identity && fits_modules(&self.manual.device, ar))
    }

    /// Whether a connection is between the two parties; the first connection that fits decides which they are.
    fn is_followed(&mut self, ar: &ObservedAr) -> bool {
        let pair = (ar.controller.address, ar.device.address);
        match self.pair {
            Some(known) => known == pair,
            None if ar.role == Role::Exchange && self.fits(ar) => {
                self.pair = Some(pair);
                self.take_early_sets();
                true
            }
            None => false,
        }
    }

    fn observe(&mut self, ars: &[ObservedAr], observation: &Observation<'_>) {
        self.conversation.end = self.now.0;
        if self.device.profibus().is_some() {
            self.slave(ars, observation);
        }
        if let Some(ar) = observation.ar() {
            let Some(of) = ars.get(ar.0 as usize) else { return };
            if !self.is_followed(of) {
                self.other_party(of, observation);
                return;
            }
        }
        self.before(ars, observation);
        let pair = self.pair;
        let ours = |ar: &ObservedAr| Some((ar.controller.address, ar.device.address)) == pair;
        let change = self.follower.observe(self.device, ars, ours, self.now, observation);
        match change {
            Some(ConnectionChange::Opened) | None => {}
            Some(ConnectionChange::Tick(tick)) => self.tick(tick),
            Some(ConnectionChange::Closed(tick, ending)) => self.closed(tick, ending),
        }
    }

    /// Takes in an observation before the image does.
    fn before(&mut self, ars: &[ObservedAr], observation: &Observation<'_>) {
        let seen = |ar: &ArId| ars.get(ar.0 as usize);
        match observation {
            Observation::Connected { ar } | Observation::ConnectRefused { ar, .. } => {
                if let (Some(of), Some(_)) = (seen(ar), self.device.profinet()) {
                    self.connect(*ar, of, observation);
                }
            }
            Observation::ParameterEnd { ar } => self.stage(ars, *ar, "parameter_end"),
            Observation::ApplicationReady { ar } => self.stage(ars, *ar, "application_ready"),
            Observation::Record { ar, written, target, data, status } => {
                let starts = requests::record(self.device, *target).is_some_and(|record| record.start);
                let in_start = self.device.profinet().is_some()
                    && ar.as_ref().and_then(seen).is_some_and(|ar| ar.stage == ArStage::Connected)
                    && (starts || (*written && !requests::is_parameter_access(self.device, *target)));
                if ar.is_some() && !in_start {
                    self.record(*written, *target, data, status);
                }
            }
            Observation::CallFailed { service, why, ar: Some(_) } => {
                let value = SuiteValue::word(format!("failed ({why})"));
                if let Some(last) = self.open.and_then(|(place, _)| self.conversation.actions.get_mut(place)) {
                    last.part(service.replace(' ', "_"), value, self.now.1);
                }
            }
            Observation::Dcp { source, destination, pdu } => self.dcp(*source, *destination, pdu),
            Observation::Traffic(Traffic::Rta { direction, kind, .. }) => self.alarm_channel(*direction, *kind),
            _ => {}
        }
    }

    fn record(&mut self, written: bool, target: RecordTarget, data: &[u8], status: &PnioStatus) {
        let (time, frame) = self.now;
        if let Some(api) = requests::other_api(self.device, target) {
            return self.left_out(format!(
                "a request for index 0x{:04X} in API 0x{api:X}; the device has another API there",
                target.3
            ));
        }
        if requests::is_parameter_access(self.device, target) {
            if written {
                self.flush();
                if status.is_ok() {
                    self.pending = Some((target, data.to_vec(), time, frame));
                } else {
                    let ask =
                        ParameterRequest::parse(data).ok().and_then(|of| requests::parameter_ask(self.device, &of));
                    let ask = ask.unwrap_or_else(|| requests::record_ask(self.device, target, Some(data)));
                    self.ask(time, ask, vec![requests::whole(status)]);
                }
                return;
            }
            // The answer may not be ready; then the controller reads it again.
            let waits = status.record_error() == Some(RecordError::STATE_CONFLICT);
            if waits && self.pending.is_some() {
                return;
            }
            let request =
                self.pending.as_ref().and_then(|(_, octets, at, _)| Some((ParameterRequest::parse(octets).ok()?, *at)));
            let named = request.and_then(|(of, at)| Some((requests::parameter_ask(self.device, &of)?, of, at)));
            if let Some((ask, request, at)) = named {
                self.pending = None;
                let answer = if status.is_ok() {
                    requests::parameter_answer(self.device, &request, data)
                } else {
                    vec![requests::whole(status)]
                };
                return self.ask(at, ask, answer);
            }
            self.flush();
        }
        let ask = requests::record_ask(self.device, target, written.then_some(data));
        let answer = match (status.is_ok(), written) {
            (true, false) => requests::record_answer(self.device, target, data),
            _ => vec![requests::whole(status)],
        };
        self.ask(time, ask, answer);
    }

    /// Ends a parameter request whose answer was not read, or that has no names: it is a record that was written.
    fn flush(&mut self) {
        let Some((target, octets, at, frame)) = self.pending.take() else { return };
        let ask = requests::record_ask(self.device, target, Some(&octets));
        let answer = vec![requests::whole(&PnioStatus::OK)];
        self.conversation.actions.push(AnsweredAction { answer, ..AnsweredAction::new(ask, (at, at), frame) });
    }

    fn tick(&mut self, tick: JudgeTick) {
        match tick.kind {
            TickKind::Output => self.output(tick),
            TickKind::Sample | TickKind::BadSample => self.sample(tick),
            TickKind::Event => self.event(tick),
        }
    }

    fn output(&mut self, tick: JudgeTick) {
        self.last_output = Some(tick.time);
        let stumbles = self.outputs.is_sign_of_life_wrong(&self.follower.image);
        let (mut set, earlier) = self.outputs.frame(&self.follower.image, tick.time);
        for (since, set) in earlier {
            self.earlier(since, ControllerAction::Set(set));
        }
        if stumbles {
            self.out_of_step(tick.time, "in isochronous mode the master's sign of life did not advance");
        }
        if std::mem::take(&mut self.paused) {
            set.push(("io.cyclic".to_owned(), "running".to_owned()));
        }
        let good = self.follower.image.output_status(None);
        if self.output_good.is_some() && good.is_some() && self.output_good != good {
            let word = words::word(words::STATUS, good.unwrap_or_default().into()).unwrap_or_default();
            set.push(("io.output_status".to_owned(), word.to_owned()));
        }
        if good == Some(true) || self.output_good.is_some() {
            self.output_good = good;
        }
        if !set.is_empty() {
            self.ask(tick.time, ControllerAction::Set(set), Vec::new());
        }
    }

    /// Notes an action that was taken at an earlier time; `None` is before the last connection.
    fn earlier(&mut self, since: Option<Time>, ask: ControllerAction) {
        let actions = &self.conversation.actions;
        let is_connect = |asked: &AnsweredAction| matches!(asked.ask, ControllerAction::Connect(_));
        let connected = actions.iter().rposition(is_connect).unwrap_or_default();
        let place = since.map_or(connected, |since| actions.partition_point(|asked| asked.at <= since));
        let at = since.or_else(|| actions.get(place).map(|asked| asked.at)).unwrap_or(self.now.0);
        let asked = AnsweredAction::new(ask, (at, at), self.now.1);
        self.conversation.actions.insert(place, asked);
        for open in [&mut self.open, &mut self.stood].into_iter().flatten().filter(|(of, _)| *of >= place) {
            open.0 += 1;
        }
        self.unanswered = self.unanswered.map(|(xid, of)| (xid, if of >= place { of + 1 } else { of }));
    }

    fn sample(&mut self, tick: JudgeTick) {
        let image = &self.follower.image;
        let statuses =
            [("io.input_status", image.input_status(None)), ("io.consumer_status", image.consumer_status(None))];
        for (name, status) in statuses {
            let value = status.and_then(|good| words::word(words::STATUS, good.into())).map(SuiteValue::word);
            self.conversation.tracks.entry(name.to_owned()).or_default().take(tick.time, tick.frame, value);
        }
        if let Some(pending) = image.diagnosis_pending() {
            let value = Some(SuiteValue::number(pending.into(), 1, false));
            let track = self.conversation.tracks.entry("io.diagnosis_pending".to_owned()).or_default();
            track.take(tick.time, tick.frame, value);
        }
        for (_, part) in carried(&self.inputs, image, FrameDirection::ToController) {
            let value = part.present(image);
            let track = self.conversation.tracks.entry(part.path.clone()).or_default();
            (track.measured, track.is_place) = (part.measured, part.is_place);
            track.stands = part.stands(image).or(track.stands);
            track.take(tick.time, tick.frame, value);
        }
        if tick.kind == TickKind::Sample {
            self.stands(tick);
        }
    }

    /// Takes in the first good sample of a connection.
    fn stands(&mut self, tick: JudgeTick) {
        let connection = self.conversation.tracks.entry("connection".to_owned()).or_default();
        connection.take(tick.time, tick.frame, Some(SuiteValue::word("data")));
        self.stood = self.open.or(self.stood);
        if let Some((place, _)) = self.open.take()
            && let Some(asked) = self.conversation.actions.get_mut(place)
        {
            asked.part("connection", SuiteValue::word("data"), tick.frame);
            (asked.done, asked.frame) = (tick.time, tick.frame);
        }
        self.conversation.cycle = self.follower.image.cycle().or(self.conversation.cycle);
    }

    fn event(&mut self, tick: JudgeTick) {
        let said = match &self.follower.image.happening {
            CurrentEvent::Alarm(alarm) => alarm_words(self.device, alarm),
            CurrentEvent::Abort(_)
            | CurrentEvent::Lldp(_)
            | CurrentEvent::Hello(_)
            | CurrentEvent::Ready(_)
            | CurrentEvent::Diagnosis
            | CurrentEvent::Nothing => return,
        };
        self.conversation.events.push(DeviceEvent { at: tick.time, frame: tick.frame, said });
    }

    fn closed(&mut self, tick: JudgeTick, ending: Ending) {
        self.flush();
        self.open = None;
        self.alarm_ends(tick.time);
        self.start_up.stands = false;
        self.start_up.clock = None;
        for (name, track) in &mut self.conversation.tracks {
            let none = (name == "connection").then(|| SuiteValue::word("none"));
            track.take(tick.time, tick.frame, none);
        }
        let watched = self.last_output.filter(|last| {
            let cycle = self.conversation.cycle.unwrap_or_default();
            tick.time.since(*last) > cycle * 3
        });
        let starved = matches!(
            ending,
            Ending::Starved(FrameDirection::ToDevice) | Ending::Aborted(FrameDirection::ToController, _)
        );
        match ending {
            Ending::Released => self.ask(tick.time, ControllerAction::Disconnect, Vec::new()),
            Ending::Aborted(FrameDirection::ToDevice, _) => {
                let ask =
                    ControllerAction::Send { service: "abort".to_owned(), fields: "{}".to_owned(), answered: false };
                self.ask(tick.time, ask, Vec::new());
            }
            _ => {}
        }
        if let (true, Some(at), false) = (starved, watched, self.paused) {
            self.paused = true;
            let ask = ControllerAction::Set(vec![("io.cyclic".to_owned(), "paused".to_owned())]);
            let asked = AnsweredAction::new(ask, (at, at), tick.frame);
            let place = self.conversation.actions.partition_point(|asked| asked.at <= at);
            self.conversation.actions.insert(place, asked);
        }
        if let Ending::Aborted(FrameDirection::ToController, code) = ending {
            let word = abort_word(code);
            let said = vec![("abort.code".to_owned(), word)];
            self.conversation.events.push(DeviceEvent { at: tick.time, frame: tick.frame, said });
        }
    }

    fn end(mut self, ars: &[ObservedAr]) -> Conversation {
        self.flush();
        self.alarm_ends(self.now.0);
        self.slave_end();
        if let Some((_, ar)) = self.open {
            self.stage(ars, ar, "");
        }
        let mut conversation = self.conversation;
        // An end that is followed by the next connection at once belongs to it.
        let mut place = 0;
        while place < conversation.actions.len() {
            let next = conversation.actions.get(place + 1);
            let ends = conversation.actions[place].ask == ControllerAction::Disconnect;
            let made_again = next.is_none_or(|next| {
                let cycle = conversation.cycle.unwrap_or_default();
                matches!(next.ask, ControllerAction::Connect(_))
                    && next.at.since(conversation.actions[place].done) <= cycle * RECONNECT
            });
            if ends && made_again {
                if next.is_none() {
                    conversation.end = conversation.actions[place].at;
                }
                conversation.actions.remove(place);
            } else {
                place += 1;
            }
        }
        conversation
    }
}

/// The fields of an alarm, by the names of the suite language.
fn alarm_words(device: &DeviceDescription, alarm: &ObservedAlarm) -> Vec<(String, SuiteValue)> {
    let table = |number: u8, table| {
        let number = i64::from(number);
        let value =
            words::word(table, number).map(|word| SuiteValue { text: word.to_owned(), number: Some(number.into()) });
        value.unwrap_or_else(|| SuiteValue::number(number.into(), 8, false))
    };
    let mut said = Vec::new();
    if let Some(error) = alarm.error {
        let words = device.codes.iter().find(|(table, _)| table == "channel_error").map_or(&[][..], |(_, words)| words);
        let word = words.iter().find(|(_, number)| *number == u32::from(error)).map(|(word, _)| word.clone());
        let value = SuiteValue::number(error.into(), 16, false);
        said.push(("alarm.error", word.map_or(value, |text| SuiteValue { text, number: Some(error.into()) })));
    }
    said.extend(alarm.change.map(|change| ("alarm.change", table(change, words::ALARM_CHANGE))));
    said.extend(alarm.severity.map(|severity| ("alarm.severity", table(severity, words::ALARM_SEVERITY))));
    said.push(("alarm.slot", SuiteValue::number(alarm.slot.into(), 16, false)));
    said.push(("alarm.subslot", SuiteValue::number(alarm.subslot.into(), 16, false)));
    said.extend(alarm.structure.map(|structure| ("alarm.structure", SuiteValue::number(structure.into(), 16, false))));
    said.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// The reason of an abort as a word.
fn abort_word(code: u32) -> SuiteValue {
    let reason = AbortReason(code as u8);
    SuiteValue { text: reason.word().unwrap_or("any").to_owned(), number: Some(code.into()) }
}

/// The module that fits the layout of a connection.
fn module_of(device: &DeviceDescription, ar: &ObservedAr) -> Option<usize> {
    let mut image = ConnectionImage::new(device);
    image.open(device, ar);
    image.module()
}
