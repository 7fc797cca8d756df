//! A master under test and a minimal slave on a virtual bus. The slave is written from the standard and uses only the frame
//! codec.

use core::time::Duration;
use encspec_controllers::profibus_dp::{
    MasterOutcome, MasterRequest, MasterSettings, ProfibusMaster, SlaveConfig, SlaveStartUpResult,
};
use station::{Outbox, Station, Time};
use virtual_wire::{TappedFrame, VirtualBus};
use wire::profibus::fdl::{
    AnswerFunction, BaudRate, BitTimes, DataFrame, Extension, FdlFrame, FrameCount, FunctionCode, RequestFunction,
    StationType,
};

pub const BAUD: BaudRate = BaudRate(1_500_000);
pub const SLAVE: u8 = 3;
pub const IDENT: [u8; 2] = [0x16, 0x55];

/// The answer of the toy slave to a request: function and data, a short acknowledgement, or nothing.
pub enum SlaveReaction {
    Short,
    Data(AnswerFunction, Vec<u8>),
    Nothing,
}

/// A slave with four bytes of outputs and inputs; the inputs are the outputs plus one.
pub struct ScriptedSlave {
    pub address: u8,
    /// Delay from the end of a request to its answer.
    pub delay: BitTimes,
    /// Number of further requests that are executed but not answered.
    pub deaf: usize,
    /// Whether Data_Exchange is answered with high priority until the diagnosis is read.
    pub is_high: bool,
    pub diagnosis: [u8; 6],
    pub is_exchanging: bool,
    /// Replaces the answer; receives access point and data.
    pub say: fn(&mut ScriptedSlave, Option<u8>, &[u8]) -> Option<SlaveReaction>,
    /// New requests by access point (`None` for Data_Exchange), in order.
    pub executed: Vec<(Option<u8>, Vec<u8>)>,
    /// Polls until an acyclic answer is ready.
    pub polls: usize,
    pub record: Option<Vec<u8>>,
    pub last: Option<(FrameCount, Vec<u8>, Vec<u8>)>,
    pub reply: Option<(Time, Vec<u8>)>,
}

impl ScriptedSlave {
    pub fn new() -> ScriptedSlave {
        ScriptedSlave {
            address: SLAVE,
            delay: BitTimes(11),
            deaf: 0,
            is_high: false,
            diagnosis: [0x02, 0x05, 0x00, 0xFF, IDENT[0], IDENT[1]],
            is_exchanging: false,
            say: |_, _, _| None,
            executed: Vec::new(),
            polls: 2,
            record: None,
            last: None,
            reply: None,
        }
    }

    fn serve(&mut self, dsap: Option<u8>, master: u8, data: &[u8]) -> SlaveReaction {
        if let Some(said) = (self.say)(self, dsap, data) {
            return said;
        }
        let low = |data: &[u8]| SlaveReaction::Data(AnswerFunction::DATA_LOW, data.to_vec());
        match dsap {
            None if self.is_exchanging => {
                let inputs: Vec<u8> = data.iter().map(|octet| octet.wrapping_add(1)).collect();
                let function = if self.is_high { AnswerFunction::DATA_HIGH } else { AnswerFunction::DATA_LOW };
                SlaveReaction::Data(function, inputs)
            }
            Some(60) => {
                self.is_high = false;
                low(&self.diagnosis.clone())
            }
            Some(61) => {
                self.diagnosis[3] = master;
                SlaveReaction::Short
            }
            Some(62) => {
                (self.diagnosis[0], self.diagnosis[1]) = (0x00, 0x0C);
                self.is_exchanging = true;
                SlaveReaction::Short
            }
            Some(59) => low(&[0xD1, 0xE1]),
            Some(51) if !data.is_empty() => {
                let answer = match data {
                    [0x5F, slot, index, length, ..] => vec![0x5F, *slot, *index, *length],
                    [0x5E, slot, index, _] => vec![0x5E, *slot, *index, 2, 0xAB, 0xCD],
                    _ => vec![0xDE, 0x80, 0xB7, 0x00],
                };
                self.record = Some(answer);
                self.polls = 2;
                SlaveReaction::Short
            }
            Some(51) if self.polls > 0 => {
                self.polls -= 1;
                SlaveReaction::Short
            }
            Some(51) => self.record.take().map_or(SlaveReaction::Short, |answer| low(&answer)),
            _ => SlaveReaction::Data(AnswerFunction::NO_SERVICE, Vec::new()),
        }
    }
}

impl Station for ScriptedSlave {
    fn receive(&mut self, now: Time, octets: &[u8], _out: &mut Outbox) {
        let Ok(FdlFrame::Data(frame)) = FdlFrame::parse(octets) else { return };
        let Some(function) = frame.fc.requested() else { return };
        if frame.da == 127 {
            self.executed.push((frame.destination.sap, frame.data.to_vec()));
        }
        if frame.da != self.address || !function.expects_response() {
            return;
        }
        let count = frame.fc.count().expect("a request has a count");
        let due = now + Duration::from_nanos(BAUD.nanoseconds(self.delay));
        let is_counted = matches!(count, FrameCount::Zero | FrameCount::One);
        if let Some((last, request, answer)) = &self.last
            && is_counted
            && *last == count
        {
            assert_eq!(request, octets, "a repetition is the same frame");
            self.reply = Some((due, answer.clone()));
            return;
        }
        let mut answer = Vec::new();
        let said = match function {
            RequestFunction::FDL_STATUS => SlaveReaction::Data(AnswerFunction::OK, Vec::new()),
            _ => {
                self.executed.push((frame.destination.sap, frame.data.to_vec()));
                self.serve(frame.destination.sap, frame.sa, frame.data)
            }
        };
        match said {
            SlaveReaction::Short => answer.push(0xE5),
            SlaveReaction::Nothing => return,
            SlaveReaction::Data(function, data) => {
                let fc = FunctionCode::answer(function, StationType::SLAVE);
                let (to, from) = if data.is_empty() {
                    (Extension::NONE, Extension::NONE)
                } else {
                    (frame.source, frame.destination)
                };
                DataFrame::new((frame.sa, to), (self.address, from), fc, &data).write(&mut answer);
            }
        }
        let stored = if count == FrameCount::First { FrameCount::One } else { count };
        self.last = Some((stored, octets.to_vec(), answer.clone()));
        if self.deaf > 0 {
            self.deaf -= 1;
            return;
        }
        self.reply = Some((due, answer));
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        if let Some((_, answer)) = self.reply.take_if(|(due, _)| now >= *due) {
            out.push(&answer);
        }
    }

    fn deadline(&self) -> Option<Time> {
        self.reply.as_ref().map(|(due, _)| *due)
    }
}

/// One frame of the log: begin and end in nanoseconds, sending port, bytes.
pub type Logged = (u64, u64, usize, Vec<u8>);

/// The master at port 0, the slave at port 1.
pub struct MasterRig<D = ScriptedSlave> {
    pub bus: VirtualBus,
    pub master: ProfibusMaster,
    pub slave: D,
    pub log: Vec<Logged>,
}

pub fn settings() -> MasterSettings {
    MasterSettings::new(2, BAUD)
}

/// Set_Prm: lock, no watchdog, min TSDR 11, ident, no group.
pub const SET_PRM: [u8; 7] = [0x80, 0x01, 0x01, 0x0B, 0x16, 0x55, 0x00];

pub fn connection() -> SlaveConfig {
    SlaveConfig::new(SLAVE, SET_PRM.to_vec(), vec![0xD1, 0xE1], (4, 4))
}

impl MasterRig {
    pub fn new() -> MasterRig {
        MasterRig::with(ScriptedSlave::new())
    }

    /// A rig with an established connection.
    pub fn standing(connection: SlaveConfig) -> MasterRig {
        let mut rig = MasterRig::new();
        let result = rig.start(connection);
        assert!(result.standing && result.failed.is_none(), "{result:?}");
        rig
    }
}

impl<D: Station> MasterRig<D> {
    pub fn with(slave: D) -> MasterRig<D> {
        let settings = settings();
        let bus = VirtualBus::new(BAUD, settings.slot_time);
        MasterRig { bus, master: ProfibusMaster::new(settings), slave, log: Vec::new() }
    }

    pub fn run(&mut self, time: Duration) {
        let until = self.bus.now() + time;
        let log = &mut self.log;
        let mut tap = |frame: TappedFrame<'_>| {
            log.push((frame.begin.as_nanos(), frame.time.as_nanos(), frame.port, frame.frame.to_vec()));
        };
        self.bus.run(&mut [&mut self.master, &mut self.slave], until, &mut tap);
    }

    /// Sends a request to the master and runs until its outcome is there.
    pub fn ask(&mut self, request: MasterRequest) -> MasterOutcome {
        self.master.request(self.bus.now(), request).expect("the master has nothing else to do");
        for _ in 0..200_000 {
            if let Some(outcome) = self.master.take_outcome() {
                return outcome;
            }
            let log = &mut self.log;
            let mut tap = |frame: TappedFrame<'_>| {
                log.push((frame.begin.as_nanos(), frame.time.as_nanos(), frame.port, frame.frame.to_vec()));
            };
            self.bus.step(&mut [&mut self.master, &mut self.slave], Time::MAX, &mut tap);
        }
        panic!("no outcome after {:?}", self.bus.now());
    }

    pub fn start(&mut self, connection: SlaveConfig) -> SlaveStartUpResult {
        match self.ask(MasterRequest::Connect(Box::new(connection))) {
            MasterOutcome::StartUp(result) => *result,
            other => panic!("a start-up gave {other:?}"),
        }
    }

    /// The log without tokens and FDL status requests.
    pub fn services(&self) -> Vec<&Logged> {
        let is_search = |octets: &[u8]| octets[0] == 0xDC || (octets[0] == 0x10 && matches!(octets[3], 0x00 | 0x49));
        self.log.iter().filter(|(_, _, _, octets)| !is_search(octets)).collect()
    }

    /// The requests to the slave that carry cyclic data, with their start times.
    pub fn exchanges(&self) -> Vec<(u64, Vec<u8>)> {
        let is_exchange = |(begin, _, port, octets): &&Logged| {
            let Ok(FdlFrame::Data(frame)) = FdlFrame::parse(octets) else { return None };
            (*port == 0 && frame.destination.is_empty() && frame.fc.requested() == Some(RequestFunction::SRD_HIGH))
                .then(|| (*begin, octets.clone()))
        };
        self.log.iter().filter_map(|entry| is_exchange(&entry)).collect()
    }
}

/// Bytes as hexadecimal digits with spaces.
pub fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ")
}

/// The duration of `bits` at the baud rate of the tests, in nanoseconds.
pub fn bits(bits: u64) -> u64 {
    BAUD.nanoseconds(BitTimes(bits))
}
