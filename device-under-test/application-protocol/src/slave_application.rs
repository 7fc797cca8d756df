//! The application of a PROFIBUS slave in a program.

use crate::answer::ApplicationAnswer;
use crate::dialogue::{ProgramDialogue, RemoteApplication, words_of};
use crate::hex::HexText;
use crate::program::{SharedProgram, in_program};
use crate::request::{ApplicationRequest, EndWord};
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
    dialogue: ProgramDialogue,
    identity: SlaveIdentity,
    address: u8,
    takes_address: bool,
    follows_clock: bool,
    /// What Get_Cfg reports.
    configuration: Vec<u8>,
    diagnosis_changed: bool,
    /// Outputs that were not sent yet.
    waiting: Option<Option<HexText>>,
    /// The last outputs.
    outputs: Option<Option<HexText>>,
    inputs: Vec<u8>,
}

impl RemoteSlaveApplication {
    /// The slave of `program` in factory state, except for its station address. `None` if the program has no slave.
    pub fn new(program: SharedProgram, shaft: u64, address: u8) -> Option<RemoteSlaveApplication> {
        let described = in_program(&program).description().profibus.clone()?;
        let mut application = RemoteSlaveApplication {
            dialogue: ProgramDialogue::new(program),
            identity: described.identity(),
            address,
            takes_address: described.set_address,
            follows_clock: described.clock,
            configuration: described.configuration.0,
            diagnosis_changed: false,
            waiting: None,
            outputs: None,
            inputs: Vec::new(),
        };
        application.ask(&ApplicationRequest::Reset { shaft });
        Some(application)
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
                self.dialogue.refuse(request, format!("`refused` is `{word}`, which is no error of a record"));
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

impl RemoteApplication for RemoteSlaveApplication {
    fn dialogue(&mut self) -> &mut ProgramDialogue {
        &mut self.dialogue
    }

    fn ask(&mut self, request: &ApplicationRequest) -> Option<ApplicationAnswer> {
        let answer = self.dialogue.ask(request)?;
        self.diagnosis_changed |= answer.diagnosis_changed;
        Some(answer)
    }

    fn send_outputs(&mut self, now: Time) {
        if let Some(outputs) = self.waiting.take() {
            let outputs = Some(outputs);
            self.ask(&ApplicationRequest::DataExchange { now: now.as_nanos(), outputs, inputs: false });
        }
    }
}

impl SlaveApplication for RemoteSlaveApplication {
    fn identity(&self) -> &SlaveIdentity {
        &self.identity
    }

    fn power_up(&mut self, now: Time) {
        if let Some(described) = &in_program(&self.dialogue.program).description().profibus {
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
            self.dialogue.refuse(&request, "it has no `accepted`".to_owned());
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
                self.dialogue.refuse(&request, why.to_owned());
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
        if is_same && now < self.dialogue.constant_until {
            return;
        }
        self.send_outputs(now);
        let outputs = Some(data.map(HexText::from));
        self.outputs.clone_from(&outputs);
        self.waiting = outputs;
    }

    fn inputs(&mut self, now: Time, data: &mut [u8]) {
        if self.waiting.is_some() || now >= self.dialogue.constant_until || self.inputs.len() != data.len() {
            let outputs = self.waiting.take();
            let request = ApplicationRequest::DataExchange { now: now.as_nanos(), outputs, inputs: true };
            let Some(answer) = self.ask(&request) else { return data.fill(0) };
            match answer.data {
                Some(HexText(inputs)) if inputs.len() == data.len() => {
                    self.inputs = inputs;
                    self.dialogue.constant_until = answer.constant_until.map_or(Time::ZERO, Time::from_nanos);
                }
                Some(HexText(inputs)) => {
                    let (given, length) = (inputs.len(), data.len());
                    self.dialogue.refuse(&request, format!("the inputs have {given} bytes instead of {length}"));
                }
                None => self.dialogue.refuse(&request, "it has no `data` with the inputs".to_owned()),
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
        self.dialogue.take_record(&request, answer, out);
        Ok(())
    }

    fn forget(&mut self, now: Time, channel: Dpv1Channel) {
        self.ask_at(now, &ApplicationRequest::Disconnect { now: now.as_nanos(), connection: connection(channel) });
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        self.act_on_device(now, action)
    }

    fn is_alive(&self) -> bool {
        self.dialogue.is_alive
    }

    fn led(&mut self, now: Time, name: &str, status: &SlaveStatus) -> Option<&'static str> {
        self.shown_by_led(now, name, words(status))
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.counted(now, name)
    }

    fn deadline(&self) -> Option<Time> {
        self.dialogue.deadline
    }

    fn advance(&mut self, now: Time) {
        self.advance_program(now);
    }
}

/// What holds of the stack, as words.
fn words(status: &SlaveStatus) -> Vec<String> {
    words_of(&[
        (status.has_supply, "supply"),
        (status.is_booting, "booting"),
        (status.is_linked, "link"),
        (status.state == DpState::DataExchange, "data_exchange"),
        (status.state == DpState::WaitCfg, "wait_cfg"),
        (status.prm_fault, "prm_fault"),
        (status.cfg_fault, "cfg_fault"),
        (status.watchdog_expired, "watchdog_expired"),
        (status.is_clear, "clear"),
    ])
}
