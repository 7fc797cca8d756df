//! The application of a PROFIBUS slave in a program.

use crate::answer::ApplicationAnswer;
use crate::hex::HexText;
use crate::program::{SharedProgram, in_program};
use crate::request::{ApplicationRequest, EndWord};
use crate::stand;
use device_stack::profibus::{
    DiagnosisBits, DpState, Dpv1Access, Dpv1Channel, Dpv1RecordRefusal, ExchangeEnd, SlaveApplication, SlaveIdentity,
    SlaveStatus,
};
use station::{StandAction, Time};
use wire::profibus::cfg::IoLengths;
use wire::profibus::dpv1::RecordError;
use wire::profibus::prm::SetPrm;

/// A program behind the PROFIBUS stack. The station address is kept here, since the program has no bus.
///
/// A Data_Exchange is one message and its answer. There is none while the program says that its inputs are constant and the outputs
/// stay the same.
#[derive(Debug)]
pub struct RemoteSlaveApplication {
    program: SharedProgram,
    identity: SlaveIdentity,
    address: u8,
    takes_address: bool,
    follows_clock: bool,
    /// What Get_Cfg reports.
    configuration: Vec<u8>,
    deadline: Option<Time>,
    is_alive: bool,
    diagnosis_changed: bool,
    /// Outputs that were not sent yet.
    waiting: Option<Option<HexText>>,
    /// The last outputs.
    outputs: Option<Option<HexText>>,
    inputs: Vec<u8>,
    constant_until: Time,
}

impl RemoteSlaveApplication {
    /// The slave of `program` in factory state, except for its station address. `None` if the program has no slave.
    pub fn new(program: SharedProgram, shaft: u64, address: u8) -> Option<RemoteSlaveApplication> {
        let described = in_program(&program).description().profibus.clone()?;
        let mut application = RemoteSlaveApplication {
            program,
            identity: described.identity(),
            address,
            takes_address: described.set_address,
            follows_clock: described.clock,
            configuration: described.configuration.0,
            deadline: None,
            is_alive: true,
            diagnosis_changed: false,
            waiting: None,
            outputs: None,
            inputs: Vec::new(),
            constant_until: Time::ZERO,
        };
        application.ask(&ApplicationRequest::Reset { shaft });
        Some(application)
    }

    /// Sends a message and takes what every answer may contain.
    fn ask(&mut self, request: &ApplicationRequest) -> Option<ApplicationAnswer> {
        let answer = in_program(&self.program).ask(request);
        self.constant_until = Time::ZERO;
        let Some(answer) = answer else {
            self.deadline = None;
            return None;
        };
        self.deadline = answer.deadline.map(Time::from_nanos);
        self.is_alive = answer.alive;
        self.diagnosis_changed |= answer.diagnosis_changed;
        Some(answer)
    }

    /// Sends a message other than a Data_Exchange, after the outputs that arrived before it.
    fn ask_at(&mut self, now: Time, request: &ApplicationRequest) -> Option<ApplicationAnswer> {
        if let Some(outputs) = self.waiting.take() {
            let outputs = Some(outputs);
            self.ask(&ApplicationRequest::DataExchange { now: now.as_nanos(), outputs, inputs: false });
        }
        self.ask(request)
    }

    fn refuse(&self, request: &ApplicationRequest, why: String) {
        in_program(&self.program).refuse(request, why);
    }

    /// The result of an access to a record.
    fn accessed(
        &self,
        request: &ApplicationRequest,
        answer: Option<&ApplicationAnswer>,
    ) -> Result<(), Dpv1RecordRefusal> {
        let refused = |error| Err(Dpv1RecordRefusal::error(error));
        let Some(answer) = answer else { return refused(RecordError::STATE_CONFLICT) };
        let Some(word) = &answer.refused else { return Ok(()) };
        match RecordError::by_word(word) {
            Some(error) => refused(error),
            None => {
                self.refuse(request, format!("`refused` is `{word}`, which is no error of a record"));
                refused(RecordError::STATE_CONFLICT)
            }
        }
    }
}

fn connection(channel: Dpv1Channel) -> u32 {
    match channel {
        Dpv1Channel::Ms1 => 0,
        Dpv1Channel::Ms2(sap) => sap.into(),
    }
}

impl SlaveApplication for RemoteSlaveApplication {
    fn identity(&self) -> &SlaveIdentity {
        &self.identity
    }

    fn power_up(&mut self, now: Time) {
        if let Some(described) = &in_program(&self.program).description().profibus {
            self.configuration.clone_from(&described.configuration.0);
        }
        self.ask(&ApplicationRequest::PowerUp { now: now.as_nanos() });
    }

    fn power_down(&mut self, now: Time) {
        (self.waiting, self.outputs) = (None, None);
        self.ask(&ApplicationRequest::PowerDown { now: now.as_nanos() });
    }

    fn address(&self) -> u8 {
        self.address
    }

    fn takes_address(&self) -> bool {
        self.takes_address
    }

    fn set_address(&mut self, _: Time, address: u8, is_final: bool) {
        self.address = address;
        self.takes_address &= !is_final;
    }

    fn parameters(&mut self, now: Time, parameters: &SetPrm) -> bool {
        let request =
            ApplicationRequest::SetPrm { now: now.as_nanos(), data: HexText::from(parameters.user.as_slice()) };
        let Some(answer) = self.ask_at(now, &request) else { return false };
        answer.accepted.unwrap_or_else(|| {
            self.refuse(&request, "it has no `accepted`".to_owned());
            false
        })
    }

    fn check_configuration(&mut self, now: Time, identifiers: &[u8]) -> Option<IoLengths> {
        let request = ApplicationRequest::ChkCfg { now: now.as_nanos(), data: identifiers.into() };
        let answer = self.ask_at(now, &request)?;
        match (answer.accepted, answer.input_length, answer.output_length) {
            (Some(true), Some(inputs), Some(outputs)) => {
                self.configuration = identifiers.to_vec();
                Some(IoLengths { inputs: inputs.into(), outputs: outputs.into() })
            }
            (Some(false), ..) => None,
            _ => {
                let why = "it needs `accepted`, and if that is true `input_length` and `output_length`";
                self.refuse(&request, why.to_owned());
                None
            }
        }
    }

    fn configuration(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.configuration);
    }

    fn exchange_begins(&mut self, now: Time) {
        self.outputs = None;
        self.ask_at(now, &ApplicationRequest::ExchangeBegins { now: now.as_nanos() });
    }

    fn exchange_ends(&mut self, now: Time, end: ExchangeEnd) {
        let reason = match end {
            ExchangeEnd::Watchdog => EndWord::Watchdog,
            ExchangeEnd::Unlocked => EndWord::Unlocked,
            ExchangeEnd::Parameters => EndWord::Parameters,
            ExchangeEnd::Fault => EndWord::Fault,
        };
        self.ask_at(now, &ApplicationRequest::ExchangeEnds { now: now.as_nanos(), reason });
    }

    fn outputs(&mut self, now: Time, data: Option<&[u8]>) {
        let is_same = self.outputs.as_ref().is_some_and(|last| last.as_ref().map(|of| of.0.as_slice()) == data);
        if is_same && now < self.constant_until {
            return;
        }
        if let Some(outputs) = self.waiting.take() {
            let outputs = Some(outputs);
            self.ask(&ApplicationRequest::DataExchange { now: now.as_nanos(), outputs, inputs: false });
        }
        let outputs = Some(data.map(HexText::from));
        self.outputs.clone_from(&outputs);
        self.waiting = outputs;
    }

    fn inputs(&mut self, now: Time, data: &mut [u8]) {
        if self.waiting.is_some() || now >= self.constant_until || self.inputs.len() != data.len() {
            let outputs = self.waiting.take();
            let request = ApplicationRequest::DataExchange { now: now.as_nanos(), outputs, inputs: true };
            let Some(answer) = self.ask(&request) else { return data.fill(0) };
            match answer.data {
                Some(HexText(inputs)) if inputs.len() == data.len() => {
                    self.inputs = inputs;
                    self.constant_until = answer.constant_until.map_or(Time::ZERO, Time::from_nanos);
                }
                Some(HexText(inputs)) => {
                    let (given, length) = (inputs.len(), data.len());
                    self.refuse(&request, format!("the inputs have {given} bytes instead of {length}"));
                }
                None => self.refuse(&request, "it has no `data` with the inputs".to_owned()),
            }
        }
        data.fill(0);
        data.iter_mut().zip(&self.inputs).for_each(|(to, from)| *to = *from);
    }

    fn clock(&mut self, now: Time) {
        if self.follows_clock {
            self.ask_at(now, &ApplicationRequest::Clock { now: now.as_nanos() });
        }
    }

    fn diagnosis(&mut self, now: Time, out: &mut Vec<u8>) -> DiagnosisBits {
        let request = ApplicationRequest::Diagnosis { now: now.as_nanos() };
        let Some(answer) = self.ask_at(now, &request) else { return DiagnosisBits::default() };
        if let Some(HexText(blocks)) = answer.data {
            out.extend_from_slice(&blocks);
        }
        DiagnosisBits { ext_diag: answer.ext_diag, stat_diag: answer.stat_diag, overflow: answer.overflow }
    }

    fn diagnosis_changed(&mut self) -> bool {
        std::mem::take(&mut self.diagnosis_changed)
    }

    fn write(&mut self, now: Time, access: Dpv1Access, data: &[u8]) -> Result<(), Dpv1RecordRefusal> {
        let request = ApplicationRequest::WriteRecord {
            now: now.as_nanos(),
            connection: connection(access.channel),
            slot: access.slot.into(),
            subslot: None,
            index: access.index.into(),
            data: data.into(),
        };
        let answer = self.ask_at(now, &request);
        self.accessed(&request, answer.as_ref())
    }

    fn read(&mut self, now: Time, access: Dpv1Access, out: &mut Vec<u8>) -> Result<(), Dpv1RecordRefusal> {
        let request = ApplicationRequest::ReadRecord {
            now: now.as_nanos(),
            connection: connection(access.channel),
            slot: access.slot.into(),
            subslot: None,
            index: access.index.into(),
        };
        let answer = self.ask_at(now, &request);
        self.accessed(&request, answer.as_ref())?;
        match answer.and_then(|answer| answer.data) {
            Some(HexText(data)) => out.extend_from_slice(&data),
            None => self.refuse(&request, "it has neither `data` nor `refused`".to_owned()),
        }
        Ok(())
    }

    fn forget(&mut self, now: Time, channel: Dpv1Channel) {
        self.ask_at(now, &ApplicationRequest::Disconnect { now: now.as_nanos(), connection: connection(channel) });
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        let request = stand::act(now, action)?;
        self.ask_at(now, &request)?.done.map(|done| Time::from_nanos(done).max(now))
    }

    fn is_alive(&self) -> bool {
        self.is_alive
    }

    fn led(&mut self, now: Time, name: &str, status: &SlaveStatus) -> Option<&'static str> {
        let request = ApplicationRequest::Led { now: now.as_nanos(), name: name.to_owned(), stack: words(status) };
        let constant_until = self.constant_until;
        let shows = self.ask_at(now, &request)?.shows?;
        // To read an LED changes nothing.
        self.constant_until = constant_until;
        in_program(&self.program).led_word(&shows)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.ask_at(now, &ApplicationRequest::Counter { now: now.as_nanos(), name: name.to_owned() })?.value
    }

    fn deadline(&self) -> Option<Time> {
        self.deadline
    }

    fn advance(&mut self, now: Time) {
        if self.deadline.is_none_or(|due| due > now) {
            return;
        }
        let request = ApplicationRequest::Advance { now: now.as_nanos() };
        self.ask_at(now, &request);
        if let Some(due) = self.deadline.filter(|due| *due <= now) {
            self.refuse(&request, format!("`deadline` is {}, which is not after `now`", due.as_nanos()));
            self.deadline = None;
        }
    }
}

/// What holds of the stack, as words.
fn words(status: &SlaveStatus) -> Vec<String> {
    let words = [
        (status.has_supply, "supply"),
        (status.is_booting, "booting"),
        (status.is_linked, "link"),
        (status.state == DpState::DataExchange, "data_exchange"),
        (status.state == DpState::WaitCfg, "wait_cfg"),
        (status.prm_fault, "prm_fault"),
        (status.cfg_fault, "cfg_fault"),
        (status.watchdog_expired, "watchdog_expired"),
        (status.is_clear, "clear"),
    ];
    words.into_iter().filter(|(holds, _)| *holds).map(|(_, word)| word.to_owned()).collect()
}
