//! The tracker for PROFIBUS: turns the frames of one bus into observations and stores the state of each slave.
//!
//! A connection is a slave that a master has parameterised: it begins with Set_Prm, has the layout of Chk_Cfg, and is established
//! with the first matching answer of Data_Exchange. User data are not interpreted.

mod services;
mod states;

use super::tracker::Sink;
use super::{
    Address, ArId, ArStage, CyclicStatus, CyclicStream, DiagnosisFrame, Dp, FrameDirection, Leaving, Observation,
    ObservedAr, PollFault, PollPart, SubmodulePlacement, Traffic,
};
use services::Acyclic;
use station::{Duration, Time};
use wire::profibus::cfg::IoLengths;
use wire::profibus::fdl::{AnswerFunction, BROADCAST, DataFrame, FdlFrame, FrameCount, FunctionCode};
use wire::profibus::global_control::GlobalControl;
use wire::profibus::prm::Dpv1;
use wire::profibus::sap::{SapService, SlaveSap};

/// Maximum number of connections in a trace; further ones are not followed.
const MOST_CONNECTIONS: usize = 10_000;
/// Number of consecutive Data_Exchange cycles without an answer after which data exchange has ended, whichever the master is.
const LOST_AFTER: u32 = 3;
/// Maximum time without an answer from a slave without a watchdog.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time base of the watchdog factors in Set_Prm without DP-V1, in milliseconds (IEC 61158-6-3, Set_Prm).
const WATCHDOG_BASE_MS: u32 = 10;

/// Number of frames of each kind on a PROFIBUS.
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
    /// Unreadable frames.
    pub unreadable: u64,
    /// Data_Exchange of slaves whose parameters and configuration are not in the trace.
    pub strays: u64,
}

/// Turns the frames of a PROFIBUS into observations and stores the connections.
#[derive(Debug)]
pub struct DpTracker {
    ars: Vec<ObservedAr>,
    slaves: Vec<TrackedSlave>,
    asked: Option<PendingDpRequest>,
    /// Buffer for the bytes of the last request, so that requests do not allocate.
    spare: Vec<u8>,
    /// The ids of forgotten connections, which later ones get.
    unused: Vec<u32>,
    standing: Vec<u8>,
    counts: DpCounts,
    /// Whether the frames are from a recording, in which frames may be missing.
    is_recorded: bool,
    /// Number of consecutive Data_Exchange cycles without an answer that ends data exchange.
    lost_after: u32,
}

/// The state of a slave.
#[derive(Clone, Debug, Default)]
struct TrackedSlave {
    /// The current connection, established or being established.
    pub ar: Option<u32>,
    /// Lengths of outputs and inputs, after the configuration was acknowledged.
    lengths: Option<IoLengths>,
    /// The last request with a frame count bit: master, function code and checksum of its bytes.
    last: Option<(u8, FunctionCode, u64)>,
    /// Whether that request was answered; its repetitions get the same answer.
    is_settled: bool,
    /// Data_Exchange requests since the last answer, without repetitions.
    unanswered: u32,
    answered: Time,
    requested: Time,
    /// Time between the last two Data_Exchange requests.
    gap: Duration,
    diagnosis: Option<DiagnosisFrame>,
    /// Acyclic requests that wait for their responses.
    pub acyclic: Vec<Acyclic>,
    /// Whether frames may be missing since its last answer.
    unsure: bool,
}

/// The request on the bus that waits for its answer.
#[derive(Debug)]
struct PendingDpRequest {
    pub da: u8,
    pub sa: u8,
    pub service: SapService,
    /// The access points of slave and master in the request.
    access_points: (Option<u8>, Option<u8>),
    number: u64,
    time: Time,
    /// Whether it repeats a request that was answered before.
    is_settled: bool,
    pub data: Vec<u8>,
}

/// An answer frame.
#[derive(Clone, Copy, Debug)]
struct DpAnswer<'a> {
    pub function: AnswerFunction,
    pub data: &'a [u8],
    /// Offset of the data in the frame.
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
    /// A tracker without frames.
    pub fn new() -> DpTracker {
        DpTracker {
            ars: Vec::new(),
            slaves: vec![TrackedSlave::default(); usize::from(BROADCAST) + 1],
            asked: None,
            spare: Vec::new(),
            unused: Vec::new(),
            standing: Vec::new(),
            counts: DpCounts::default(),
            is_recorded: false,
            lost_after: LOST_AFTER,
        }
    }

    /// Forgets a connection that has ended and is not that of a slave any more, so that a later one may have its id.
    pub fn forget(&mut self, ArId(index): ArId) {
        if self.slaves.iter().any(|slave| slave.ar == Some(index)) {
            return;
        }
        let Some(ar) = self.ars.get_mut(index as usize).filter(|ar| !ar.stage.stands()) else { return };
        *ar = ObservedAr::forgotten();
        self.unused.push(index);
    }

    /// A tracker for a bus whose only masters are those of the harness: they give a slave up after the first cycle without an answer.
    pub fn of_harness() -> DpTracker {
        DpTracker { lost_after: 1, ..DpTracker::new() }
    }

    /// A tracker for a recording: reports missing frames as [`Observation::Gap`].
    pub fn recorded() -> DpTracker {
        DpTracker { is_recorded: true, ..DpTracker::new() }
    }

    /// The connections so far; an [`ArId`] is an index into them.
    pub fn ars(&self) -> &[ObservedAr] {
        &self.ars
    }

    /// Number of frames of each kind.
    pub fn counts(&self) -> &DpCounts {
        &self.counts
    }

    /// Reports that frames may be missing before `now`, or that the clock was set.
    ///
    /// A slave that does not answer after the gap is not reported as silent, since the end of its connection may be missing.
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

    /// Processes one frame, from start delimiter to end delimiter, and passes its observations to `sink`.
    ///
    /// `number` is the number of the frame in the trace, from 1; `time` is the time of its first start bit.
    pub fn frame(&mut self, number: u64, time: Time, octets: &[u8], sink: Sink<'_>) {
        self.counts.frames += 1;
        self.time(time, sink);
        match FdlFrame::parse(octets) {
            Err(error) => {
                self.counts.unreadable += 1;
                sink(&self.ars, Observation::Unreadable { why: &error.to_string() });
            }
            Ok(FdlFrame::Token { da, sa }) => {
                self.counts.tokens += 1;
                self.end_wait(false, sink);
                sink(&self.ars, Observation::Traffic(Traffic::Token { from: sa & BROADCAST, to: da & BROADCAST }));
            }
            Ok(FdlFrame::ShortAcknowledgement) => {
                let Some(asked) = self.asked.take() else { return self.unexpected_answer(sink) };
                let answer = DpAnswer { function: AnswerFunction::OK, data: &[], at: 0, number, time };
                self.answered(asked, answer, sink);
            }
            Ok(FdlFrame::Data(frame)) if frame.fc.is_request() => self.request(number, time, octets, &frame, sink),
            Ok(FdlFrame::Data(frame)) => {
                let is_answer = |asked: &mut PendingDpRequest| (asked.da, asked.sa) == (frame.sa, frame.da);
                let Some(asked) = self.asked.take_if(is_answer) else {
                    let to_other = self.asked.as_ref().filter(|asked| asked.da == frame.sa && asked.sa != frame.da);
                    if let Some((master, station, service)) = to_other.map(|asked| (asked.sa, asked.da, asked.service))
                    {
                        let fault = PollFault::OtherReceiver { receiver: frame.da & BROADCAST };
                        self.fault((master, station, service), fault, sink);
                    }
                    return self.unexpected_answer(sink);
                };
                let (answered, receiver) = (frame.source.sap, frame.destination.sap);
                if !frame.data.is_empty() && asked.access_points != (answered, receiver) {
                    let fault = PollFault::OtherAccessPoint { requested: asked.access_points.0, answered };
                    self.fault((asked.sa, asked.da, asked.service), fault, sink);
                }
                let function = frame.fc.answered().unwrap_or(AnswerFunction::OK);
                let at = place_of(octets, frame.data);
                self.answered(asked, DpAnswer { function, data: frame.data, at, number, time }, sink);
            }
        }
    }

    /// Advances time: reports connections that are silent for longer than their watchdog time.
    pub fn time(&mut self, now: Time, sink: Sink<'_>) {
        let mut place = 0;
        while let Some(&address) = self.standing.get(place) {
            let slave = &self.slaves[usize::from(address)];
            let watchdog = self.watchdog(slave);
            let silent = |since: Time, limit: Duration| now > since + limit + slave.gap.min(limit);
            let direction = match (slave.unanswered, watchdog.is_zero()) {
                (0, true) => None,
                (0, false) => silent(slave.requested, watchdog).then_some(FrameDirection::ToDevice),
                (_, true) => silent(slave.answered, PATIENCE).then_some(FrameDirection::ToController),
                (_, false) => silent(slave.answered, watchdog).then_some(FrameDirection::ToController),
            };
            match direction {
                Some(direction) => self.fell_silent(address, direction, sink),
                None => place += 1,
            }
        }
    }

    fn watchdog(&self, slave: &TrackedSlave) -> Duration {
        slave.ar.and_then(|ar| self.ars.get(ar as usize)).map_or(Duration::ZERO, |ar| ar.outputs.watchdog)
    }

    fn polled(&self, (master, station, service): (u8, u8, SapService), part: PollPart, sink: Sink<'_>) {
        sink(&self.ars, Observation::Traffic(Traffic::Poll { master, station, service, part }));
    }

    /// Ends the wait for an answer, because a new request or the token was sent; `again`: the request is repeated.
    fn end_wait(&mut self, again: bool, sink: Sink<'_>) {
        let Some(asked) = self.asked.take() else { return };
        let station = asked.da;
        self.polled((asked.sa, asked.da, asked.service), PollPart::Unanswered, sink);
        self.spare = asked.data;
        if asked.service == SapService::DataExchange && !again {
            let slave = &mut self.slaves[usize::from(station)];
            slave.unanswered += 1;
            if slave.unanswered >= self.lost_after {
                self.fell_silent(station, FrameDirection::ToController, sink);
            }
        }
    }

    /// Reports an answer that does not fit; in a recording only.
    fn fault(&self, (master, station, service): (u8, u8, SapService), fault: PollFault, sink: Sink<'_>) {
        if self.is_recorded {
            let ar = self.slaves.get(usize::from(station)).and_then(|slave| slave.ar).map(ArId);
            sink(&self.ars, Observation::Traffic(Traffic::PollFault { ar, master, station, service, fault }));
        }
    }

    /// Processes an answer without a request: the request is missing in the recording.
    fn unexpected_answer(&self, sink: Sink<'_>) {
        if self.is_recorded {
            sink(&self.ars, Observation::Gap { ar: None });
        }
    }

    fn fell_silent(&mut self, station: u8, direction: FrameDirection, sink: Sink<'_>) {
        let unsure = self.slaves.get(usize::from(station)).is_some_and(|slave| slave.unsure);
        let observation = |ar: ArId| {
            if unsure { Observation::Gap { ar: Some(ar) } } else { Observation::Starved { ar, direction } }
        };
        self.end(station, ArStage::Starved, observation, sink);
    }

    fn request(&mut self, number: u64, time: Time, octets: &[u8], frame: &DataFrame<'_>, sink: Sink<'_>) {
        let service = SapService::of(frame);
        let (da, sa) = (frame.da & BROADCAST, frame.sa & BROADCAST);
        let repeated = self.is_repeated(da, sa, frame.fc, octets);
        self.end_wait(repeated, sink);
        self.counts.repeated += u64::from(repeated);
        if let (SapService::Slave(SlaveSap::GLOBAL_CONTROL), Ok(control)) = (service, GlobalControl::parse(frame.data))
        {
            sink(&self.ars, Observation::Dp { ar: None, event: Dp::Control { master: sa, station: da, control } });
        }
        if service == SapService::DataExchange {
            self.outputs(number, time, (da, sa), repeated, place_of(octets, frame.data), frame.data, sink);
        } else if self.master_of(da) == Some(sa) {
            self.slaves[usize::from(da)].requested = time;
        }
        if frame.fc.requested().is_some_and(|function| function.expects_response()) && da != BROADCAST {
            let mut data = std::mem::take(&mut self.spare);
            data.clear();
            data.extend_from_slice(frame.data);
            self.polled((sa, da, service), if repeated { PollPart::Again } else { PollPart::Asked }, sink);
            let slave = &mut self.slaves[usize::from(da)];
            slave.is_settled &= repeated;
            let is_settled = slave.is_settled;
            let access_points = (frame.destination.sap, frame.source.sap);
            self.asked = Some(PendingDpRequest { da, sa, service, access_points, number, time, is_settled, data });
        }
    }

    /// Whether a master repeats its request: frame count bit and bytes are those of the previous one.
    fn is_repeated(&mut self, da: u8, sa: u8, fc: FunctionCode, octets: &[u8]) -> bool {
        let Some(slave) = self.slaves.get_mut(usize::from(da)) else { return false };
        let counted = matches!(fc.count(), Some(FrameCount::Zero | FrameCount::One));
        let sum = octets.iter().fold(0u64, |sum, octet| sum.wrapping_mul(31).wrapping_add(u64::from(*octet)));
        let before = slave.last.replace((sa, fc, sum));
        counted && before == Some((sa, fc, sum))
    }

    /// The master that has parameterised the slave.
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
        if ar.stage == ArStage::Ready {
            let (ar, direction) = (ArId(index), FrameDirection::ToDevice);
            let status = CyclicStatus::Fdl { diagnosis_pending: false };
            sink(&self.ars, Observation::Cyclic { ar, direction, data, at, status });
        }
    }

    fn answered(&mut self, asked: PendingDpRequest, answer: DpAnswer<'_>, sink: Sink<'_>) {
        let positive = answer.function == AnswerFunction::OK;
        self.polled((asked.sa, asked.da, asked.service), PollPart::Answered, sink);
        let slave = &mut self.slaves[usize::from(asked.da)];
        if asked.is_settled {
            // The answer is the one before: the slave has not carried out the request again.
            if asked.service == SapService::DataExchange {
                (slave.unanswered, slave.answered) = (0, answer.time);
            }
            self.spare = asked.data;
            return;
        }
        slave.is_settled = true;
        match asked.service {
            SapService::DataExchange => self.inputs(&asked, answer, sink),
            SapService::Slave(SlaveSap::SLAVE_DIAG) if answer.function.has_data() => {
                self.diagnosis(&asked, answer, sink);
            }
            SapService::Slave(SlaveSap::SET_PRM) if positive => self.parameters(&asked, sink),
            SapService::Slave(SlaveSap::CHK_CFG) if positive => {
                self.configuration(&asked, &asked.data, answer.number, sink)
            }
            SapService::Slave(SlaveSap::GET_CFG) if answer.function.has_data() => {
                self.take_get_cfg(&asked, answer.data)
            }
            SapService::Slave(SlaveSap::SET_SLAVE_ADDRESS) if positive => self.address_given(&asked, sink),
            SapService::Slave(SlaveSap::SERVER) | SapService::Connection(_) => self.acyclic(&asked, answer, sink),
            _ => {}
        }
        if is_refusal(answer.function) && asked.service != SapService::DataExchange {
            let ar = self.slaves[usize::from(asked.da)].ar.map(ArId);
            let (service, why) = (asked.service.word().unwrap_or("service"), answer.function.sentence());
            sink(&self.ars, Observation::CallFailed { ar, service, why: why.unwrap_or("unknown function code") });
        }
        self.spare = asked.data;
    }

    fn inputs(&mut self, asked: &PendingDpRequest, answer: DpAnswer<'_>, sink: Sink<'_>) {
        self.counts.cyclic += 1;
        let slave = &mut self.slaves[usize::from(asked.da)];
        slave.unanswered = 0;
        slave.answered = answer.time;
        slave.unsure = false;
        let (index, lengths) = (slave.ar, slave.lengths);
        let Some((index, ar)) = index.and_then(|index| Some((index, self.ars.get_mut(index as usize)?))) else {
            self.counts.strays += 1;
            if self.add_established_slave(asked) {
                self.inputs(asked, answer, sink);
            }
            return;
        };
        if ar.controller.address != Address::Fdl(asked.sa) {
            return;
        }
        match answer.function {
            AnswerFunction::NO_SERVICE if ar.stage == ArStage::Ready => {
                let event = Dp::Left { why: Leaving::NoService };
                self.end(asked.da, ArStage::Left, |ar| Observation::Dp { ar: Some(ar), event }, sink);
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
            let (expected, observed) = (lengths.inputs, answer.data.len());
            if self.is_recorded {
                let fault = PollFault::InputLength { expected, observed };
                return self.fault((asked.sa, asked.da, asked.service), fault, sink);
            }
            let why = format!("Data_Exchange answer has {observed} bytes, expected {expected}");
            sink(&self.ars, Observation::Unreadable { why: &why });
            return;
        }
        note(&mut ar.inputs, answer.number, answer.time);
        if ar.stage != ArStage::Ready {
            ar.stage = ArStage::Ready;
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
        let (ar, direction) = (ArId(index), FrameDirection::ToController);
        sink(&self.ars, Observation::Cyclic { ar, direction, data: answer.data, at: answer.at, status });
    }
}

/// Time base of the watchdog factors in Set_Prm in milliseconds; `dpv1` are the DP-V1 bytes, if Set_Prm has them.
pub(super) fn watchdog_base_ms(dpv1: Option<Dpv1>) -> u32 {
    dpv1.map_or(WATCHDOG_BASE_MS, Dpv1::watchdog_base_ms)
}

/// The whole configuration as one submodule.
fn placed(lengths: IoLengths) -> SubmodulePlacement {
    SubmodulePlacement {
        input: Some(0..lengths.inputs),
        output: Some(0..lengths.outputs),
        ..SubmodulePlacement::bare((0, 1, 1), 0)
    }
}

/// Whether the FDL answer says that the service is not available.
fn is_refusal(function: AnswerFunction) -> bool {
    matches!(function, AnswerFunction::USER_ERROR | AnswerFunction::NO_RESOURCE | AnswerFunction::NO_SERVICE)
}

fn note(stream: &mut CyclicStream, number: u64, time: Time) {
    if let Some(last) = stream.last {
        stream.max_gap_ns = stream.max_gap_ns.max(time.since(last).as_nanos() as u64);
    }
    stream.first_frame.get_or_insert(number);
    stream.frames += 1;
    stream.last = Some(time);
}

/// Offset of the data of a frame; they end before the checksum and the end delimiter.
fn place_of(octets: &[u8], data: &[u8]) -> usize {
    octets.len().saturating_sub(data.len() + 2)
}
