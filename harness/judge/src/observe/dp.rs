//! The tracker of PROFIBUS: the frames of one bus in, observations out, and what is remembered of each slave.
//!
//! One connection is one slave that one master has parameterised: it is asked for by Set_Prm, its layout is that of Chk_Cfg, and
//! it stands with the first answer of Data_Exchange that fits. This room must not know devices; user octets stay octets.

mod services;
mod states;

use super::tracker::Sink;
use super::{
    Address, Ar, ArId, CyclicStatus, DiagnosisTold, Direction, Dp, Leaving, Observation, Placed, PollPart, Stage,
    Stream, Traffic,
};
use services::Acyclic;
use station::{Duration, Time};
use wire::profibus::cfg::Sums;
use wire::profibus::fdl::{AnswerFunction, BROADCAST, DataFrame, Frame, FrameCount, FunctionCode};
use wire::profibus::global_control::GlobalControl;
use wire::profibus::sap::{Service, SlaveSap};

/// Connections that are remembered; whatever more there are in one trace are not followed.
const MOST_CONNECTIONS: usize = 10_000;
/// Data_Exchange without an answer in so many cycles one after the other is none any more.
const LOST_AFTER: u32 = 3;
/// How long a slave without a watchdog may leave requests unanswered.
const PATIENCE: Duration = Duration::from_secs(1);

/// How many frames of which kind there were on a PROFIBUS.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DpCounts {
    /// All frames.
    pub frames: u64,
    /// Tokens.
    pub tokens: u64,
    /// Requests and answers of Data_Exchange.
    pub cyclic: u64,
    /// Requests that a master repeated.
    pub repeated: u64,
    /// Frames that could not be read.
    pub unreadable: u64,
    /// Data_Exchange of slaves whose parameters and configuration were not seen.
    pub strays: u64,
}

/// Turns the frames of a PROFIBUS into observations and remembers the connections.
#[derive(Debug)]
pub struct DpTracker {
    ars: Vec<Ar>,
    slaves: Vec<Slave>,
    asked: Option<Asked>,
    /// The octets of the last request; kept so that no request allocates.
    spare: Vec<u8>,
    standing: Vec<u8>,
    counts: DpCounts,
    /// Whether somebody else recorded the frames, so that some may be missing.
    is_recorded: bool,
}

/// What is remembered of a slave, by its address.
#[derive(Clone, Debug, Default)]
struct Slave {
    /// The connection that stands or is being made.
    pub ar: Option<u32>,
    /// Octets of outputs and inputs, once the configuration was acknowledged.
    lengths: Option<Sums>,
    /// The last counted request: master, function code and sum of its octets.
    last: Option<(u8, FunctionCode, u64)>,
    /// Requests of Data_Exchange without an answer since the last one, repetitions not counted.
    unanswered: u32,
    answered: Time,
    requested: Time,
    /// From one request of Data_Exchange to the next.
    gap: Duration,
    diagnosis: Option<DiagnosisTold>,
    /// Acyclic requests that wait for their answers.
    pub acyclic: Vec<Acyclic>,
    /// Whether frames may be missing since its last answer.
    unsure: bool,
}

/// A request that waits for its answer.
#[derive(Debug)]
struct Asked {
    pub da: u8,
    pub sa: u8,
    pub service: Service,
    number: u64,
    time: Time,
    /// The data of the request.
    pub data: Vec<u8>,
}

/// An answer as the services take it in.
#[derive(Clone, Copy, Debug)]
struct Answer<'a> {
    pub function: AnswerFunction,
    pub data: &'a [u8],
    /// Where the data begin in the frame.
    pub at: usize,
    pub number: u64,
    pub time: Time,
}

impl Default for DpTracker {
    fn default() -> DpTracker {
        DpTracker::new()
    }
}

impl DpTracker {
    /// Has seen nothing.
    pub fn new() -> DpTracker {
        DpTracker {
            ars: Vec::new(),
            slaves: vec![Slave::default(); usize::from(BROADCAST) + 1],
            asked: None,
            spare: Vec::new(),
            standing: Vec::new(),
            counts: DpCounts::default(),
            is_recorded: false,
        }
    }

    /// Has seen nothing, and is going to see what somebody else recorded: [`Observation::Gap`] tells where frames are missing.
    pub fn recorded() -> DpTracker {
        DpTracker { is_recorded: true, ..DpTracker::new() }
    }

    /// The connections seen so far; an [`ArId`] is an index into them.
    pub fn ars(&self) -> &[Ar] {
        &self.ars
    }

    /// How many frames of which kind were seen.
    pub fn counts(&self) -> &DpCounts {
        &self.counts
    }

    /// Frames may be missing before `now`, or the clock was set: nothing that was remembered is simply continued.
    ///
    /// A slave that does not answer any more from here on has not fallen silent, since its end may be what is missing.
    pub fn gap(&mut self, now: Time, sink: Sink<'_>) {
        self.asked = None;
        for slave in &mut self.slaves {
            (slave.answered, slave.requested) = (now, now);
            slave.unanswered = 0;
            slave.last = None;
            slave.acyclic.clear();
            slave.unsure = slave.ar.is_some();
        }
        sink(&self.ars, Observation::Gap { ar: None });
    }

    /// Takes in one frame, from its start delimiter to its end delimiter, and tells `sink` what it means.
    ///
    /// `number` is the number of the frame in the trace, from 1; `time` is that of its first start bit.
    pub fn frame(&mut self, number: u64, time: Time, octets: &[u8], sink: Sink<'_>) {
        self.counts.frames += 1;
        self.time(time, sink);
        match Frame::parse(octets) {
            Err(error) => {
                self.counts.unreadable += 1;
                sink(&self.ars, Observation::Unreadable { why: &error.to_string() });
            }
            Ok(Frame::Token { da, sa }) => {
                self.counts.tokens += 1;
                self.nobody_answers(false, sink);
                sink(&self.ars, Observation::Traffic(Traffic::Token { from: sa & BROADCAST, to: da & BROADCAST }));
            }
            Ok(Frame::ShortAcknowledgement) => {
                let Some(asked) = self.asked.take() else { return self.nobody_asked(sink) };
                let answer = Answer { function: AnswerFunction::OK, data: &[], at: 0, number, time };
                self.answered(asked, answer, sink);
            }
            Ok(Frame::Data(frame)) if frame.fc.is_request() => self.request(number, time, octets, &frame, sink),
            Ok(Frame::Data(frame)) => {
                let is_answer = |asked: &mut Asked| (asked.da, asked.sa) == (frame.sa, frame.da);
                let Some(asked) = self.asked.take_if(is_answer) else { return self.nobody_asked(sink) };
                let function = frame.fc.answered().unwrap_or(AnswerFunction::OK);
                let at = place_of(octets, frame.data);
                self.answered(asked, Answer { function, data: frame.data, at, number, time }, sink);
            }
        }
    }

    /// Lets time go by: tells which connections have been silent for longer than their watchdog.
    pub fn time(&mut self, now: Time, sink: Sink<'_>) {
        let mut place = 0;
        while let Some(&address) = self.standing.get(place) {
            let slave = &self.slaves[usize::from(address)];
            let watchdog = self.watchdog(slave);
            let silent = |since: Time, limit: Duration| now > since + limit + slave.gap.min(limit);
            let direction = match (slave.unanswered, watchdog.is_zero()) {
                (0, true) => None,
                (0, false) => silent(slave.requested, watchdog).then_some(Direction::ToDevice),
                (_, true) => silent(slave.answered, PATIENCE).then_some(Direction::ToController),
                (_, false) => silent(slave.answered, watchdog).then_some(Direction::ToController),
            };
            match direction {
                Some(direction) => self.fell_silent(address, direction, sink),
                None => place += 1,
            }
        }
    }

    fn watchdog(&self, slave: &Slave) -> Duration {
        slave.ar.and_then(|ar| self.ars.get(ar as usize)).map_or(Duration::ZERO, |ar| ar.outputs.watchdog)
    }

    fn polled(&self, (master, station, service): (u8, u8, Service), part: PollPart, sink: Sink<'_>) {
        sink(&self.ars, Observation::Traffic(Traffic::Poll { master, station, service, part }));
    }

    /// A request, or the token, shows that the request before will not be answered any more; `again` if it is a repetition.
    fn nobody_answers(&mut self, again: bool, sink: Sink<'_>) {
        let Some(asked) = self.asked.take() else { return };
        let station = asked.da;
        self.polled((asked.sa, asked.da, asked.service), PollPart::Unanswered, sink);
        self.spare = asked.data;
        if asked.service == Service::DataExchange && !again {
            let slave = &mut self.slaves[usize::from(station)];
            slave.unanswered += 1;
            if slave.unanswered >= LOST_AFTER {
                self.fell_silent(station, Direction::ToController, sink);
            }
        }
    }

    /// Somebody answers what was not seen to be asked: the request is missing in the recording.
    fn nobody_asked(&self, sink: Sink<'_>) {
        if self.is_recorded {
            sink(&self.ars, Observation::Gap { ar: None });
        }
    }

    fn fell_silent(&mut self, station: u8, direction: Direction, sink: Sink<'_>) {
        let unsure = self.slaves.get(usize::from(station)).is_some_and(|slave| slave.unsure);
        let seen = |ar: ArId| match unsure {
            true => Observation::Gap { ar: Some(ar) },
            false => Observation::Starved { ar, direction },
        };
        self.end(station, Stage::Starved, seen, sink);
    }

    fn request(&mut self, number: u64, time: Time, octets: &[u8], frame: &DataFrame<'_>, sink: Sink<'_>) {
        let service = Service::of(frame);
        let (da, sa) = (frame.da & BROADCAST, frame.sa & BROADCAST);
        let repeated = self.is_repeated(da, sa, frame.fc, octets);
        self.nobody_answers(repeated, sink);
        self.counts.repeated += u64::from(repeated);
        if let (Service::Slave(SlaveSap::GLOBAL_CONTROL), Ok(control)) = (service, GlobalControl::parse(frame.data)) {
            sink(&self.ars, Observation::Dp { ar: None, event: Dp::Control { master: sa, station: da, control } });
        }
        if service == Service::DataExchange {
            self.outputs(number, time, (da, sa), repeated, place_of(octets, frame.data), frame.data, sink);
        } else if self.master_of(da) == Some(sa) {
            self.slaves[usize::from(da)].requested = time;
        }
        if frame.fc.requested().is_some_and(|function| function.wants_answer()) && da != BROADCAST {
            let mut data = std::mem::take(&mut self.spare);
            data.clear();
            data.extend_from_slice(frame.data);
            self.polled((sa, da, service), if repeated { PollPart::Again } else { PollPart::Asked }, sink);
            self.asked = Some(Asked { da, sa, service, number, time, data });
        }
    }

    /// Whether a master sends again what it has sent: the count of the frame is that of the one before.
    fn is_repeated(&mut self, da: u8, sa: u8, fc: FunctionCode, octets: &[u8]) -> bool {
        let Some(slave) = self.slaves.get_mut(usize::from(da)) else { return false };
        let counted = matches!(fc.count(), Some(FrameCount::Zero | FrameCount::One));
        let sum = octets.iter().fold(0u64, |sum, octet| sum.wrapping_mul(31).wrapping_add(u64::from(*octet)));
        let before = slave.last.replace((sa, fc, sum));
        counted && before == Some((sa, fc, sum))
    }

    /// The master that has the slave or is about to have it.
    fn master_of(&self, station: u8) -> Option<u8> {
        let ar = self.ars.get(self.slaves.get(usize::from(station))?.ar? as usize)?;
        match ar.controller.address {
            Address::Fdl(master) => Some(master),
            Address::Mac(_) => None,
        }
    }

    #[allow(clippy::too_many_arguments, reason = "the parts of one frame")]
    fn outputs(
        &mut self,
        number: u64,
        time: Time,
        (da, sa): (u8, u8),
        repeated: bool,
        at: usize,
        data: &[u8],
        sink: Sink<'_>,
    ) {
        self.counts.cyclic += 1;
        if self.master_of(da) != Some(sa) {
            return;
        }
        let slave = &mut self.slaves[usize::from(da)];
        if !repeated && slave.requested > Time::ZERO {
            slave.gap = time.since(slave.requested);
        }
        slave.requested = time;
        let Some(index) = slave.ar else { return };
        let Some(ar) = self.ars.get_mut(index as usize) else { return };
        if repeated {
            return;
        }
        note(&mut ar.outputs, number, time);
        if ar.stage == Stage::Ready {
            let (ar, direction) = (ArId(index), Direction::ToDevice);
            let status = CyclicStatus::Fdl { diagnosis_pending: false };
            sink(&self.ars, Observation::Cyclic { ar, direction, data, at, status });
        }
    }

    fn answered(&mut self, asked: Asked, answer: Answer<'_>, sink: Sink<'_>) {
        let positive = answer.function == AnswerFunction::OK;
        self.polled((asked.sa, asked.da, asked.service), PollPart::Answered, sink);
        match asked.service {
            Service::DataExchange => self.inputs(&asked, answer, sink),
            Service::Slave(SlaveSap::SLAVE_DIAG) if answer.function.has_data() => {
                self.diagnosis(&asked, answer, sink);
            }
            Service::Slave(SlaveSap::SET_PRM) if positive => self.parameters(&asked, sink),
            Service::Slave(SlaveSap::CHK_CFG) if positive => {
                self.configuration(&asked, &asked.data, answer.number, sink)
            }
            Service::Slave(SlaveSap::GET_CFG) if answer.function.has_data() => self.learnt(&asked, answer.data),
            Service::Slave(SlaveSap::SET_SLAVE_ADDRESS) if positive => self.address_given(&asked, sink),
            Service::Slave(SlaveSap::SERVER) | Service::Connection(_) => self.acyclic(&asked, answer, sink),
            _ => {}
        }
        if is_refusal(answer.function) && asked.service != Service::DataExchange {
            let ar = self.slaves[usize::from(asked.da)].ar.map(ArId);
            let (service, why) = (asked.service.word().unwrap_or("service"), answer.function.sentence());
            sink(&self.ars, Observation::CallFailed { ar, service, why: why.unwrap_or("an answer of no table") });
        }
        self.spare = asked.data;
    }

    fn inputs(&mut self, asked: &Asked, answer: Answer<'_>, sink: Sink<'_>) {
        self.counts.cyclic += 1;
        let slave = &mut self.slaves[usize::from(asked.da)];
        slave.unanswered = 0;
        slave.answered = answer.time;
        slave.unsure = false;
        let (index, lengths) = (slave.ar, slave.lengths);
        let Some((index, ar)) = index.and_then(|index| Some((index, self.ars.get_mut(index as usize)?))) else {
            self.counts.strays += 1;
            if self.met(asked) {
                self.inputs(asked, answer, sink);
            }
            return;
        };
        if ar.controller.address != Address::Fdl(asked.sa) {
            return;
        }
        match answer.function {
            AnswerFunction::NO_SERVICE if ar.stage == Stage::Ready => {
                let event = Dp::Left { why: Leaving::NoService };
                self.end(asked.da, Stage::Left, |ar| Observation::Dp { ar: Some(ar), event }, sink);
                return;
            }
            function if function.has_data() || function == AnswerFunction::OK => {}
            _ => return,
        }
        let Some(lengths) = lengths else {
            note(&mut ar.inputs, answer.number, answer.time);
            return;
        };
        if answer.data.len() != lengths.inputs {
            let why = format!("the answer of Data_Exchange has {} octets, not {}", answer.data.len(), lengths.inputs);
            sink(&self.ars, Observation::Unreadable { why: &why });
            return;
        }
        note(&mut ar.inputs, answer.number, answer.time);
        if ar.stage != Stage::Ready {
            ar.stage = Stage::Ready;
            ar.application_ready_frame = Some(answer.number);
            (ar.inputs.data_length, ar.outputs.data_length) = (lengths.inputs, lengths.outputs);
            ar.submodules = vec![placed(lengths)];
            ar.slave.get_or_insert_default().diagnosis = slave.diagnosis.clone();
            if !self.standing.contains(&asked.da) {
                self.standing.push(asked.da);
            }
            sink(&self.ars, Observation::Connected { ar: ArId(index) });
        }
        let status = CyclicStatus::Fdl { diagnosis_pending: answer.function.is_high() };
        let (ar, direction) = (ArId(index), Direction::ToController);
        sink(&self.ars, Observation::Cyclic { ar, direction, data: answer.data, at: answer.at, status });
    }
}

/// The whole configuration as one submodule.
fn placed(lengths: Sums) -> Placed {
    Placed { input: Some(0..lengths.inputs), output: Some(0..lengths.outputs), ..Placed::bare((0, 1, 1), 0) }
}

/// Whether the data link of the slave says that the service cannot be had.
fn is_refusal(function: AnswerFunction) -> bool {
    matches!(function, AnswerFunction::USER_ERROR | AnswerFunction::NO_RESOURCE | AnswerFunction::NO_SERVICE)
}

fn note(stream: &mut Stream, number: u64, time: Time) {
    if let Some(last) = stream.last {
        stream.max_gap_ns = stream.max_gap_ns.max(time.since(last).as_nanos() as u64);
    }
    stream.first_frame.get_or_insert(number);
    stream.frames += 1;
    stream.last = Some(time);
}

/// Where the data of a frame begin: they stand before the checksum and the end delimiter.
fn place_of(octets: &[u8], data: &[u8]) -> usize {
    octets.len().saturating_sub(data.len() + 2)
}
