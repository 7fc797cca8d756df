//! Deviations of the PROFIBUS slave that have state.

use crate::seams::slave::{diagnosis_response, frame, request, with_data};
use alloc::vec;
use alloc::vec::Vec;
use core::mem;
use core::time::Duration;
use device_stack::profibus::{SlaveApplication, SlaveHooks, SlaveStackCheck};
use station::Time;
use wire::profibus::diag::{NO_MASTER, SlaveDiag, Status1};
use wire::profibus::fdl::{AnswerFunction, DataFrame, Extension, FrameCount, FunctionCode, StationType, UNNAMED};
use wire::profibus::global_control::{GlobalCommand, GlobalControl};
use wire::profibus::prm::{SetPrm, StationStatus};
use wire::profibus::sap::{SapService, SlaveSap};

const SET_PRM: SapService = SapService::Slave(SlaveSap::SET_PRM);
const CHK_CFG: SapService = SapService::Slave(SlaveSap::CHK_CFG);

/// Parses a telegram as a Set_Prm; `None` if it is another telegram.
fn parameters(telegram: &[u8]) -> Option<(DataFrame<'_>, SetPrm)> {
    let (frame, _) = request(telegram).filter(|(_, service)| *service == SET_PRM)?;
    Some((frame, SetPrm::parse(frame.data).ok()?))
}

fn is_request(telegram: &[u8], of: SapService) -> bool {
    request(telegram).is_some_and(|(_, service)| service == of)
}

/// Writes a Set_Prm telegram like `frame` with other parameters.
fn with_parameters(frame: &DataFrame<'_>, parameters: &SetPrm) -> Vec<u8> {
    let mut data = Vec::new();
    parameters.write(&mut data);
    with_data(frame, &data)
}

/// Removes the frame count bit (FCB) from a request, so that it neither is a retry nor has one.
fn uncounted(telegram: &[u8]) -> Vec<u8> {
    let Some(frame) = frame(telegram) else { return telegram.to_vec() };
    let Some(function) = frame.fc.requested() else { return telegram.to_vec() };
    with_data(&DataFrame { fc: FunctionCode::request(function, FrameCount::Unused), ..frame }, frame.data)
}

/// Changes the diagnosis in a response to Slave_Diag; other telegrams stay as they are.
pub(super) fn change_diagnosis(telegram: &mut Vec<u8>, change: impl FnOnce(&mut SlaveDiag)) {
    let Some((frame, mut diagnosis)) = diagnosis_response(telegram) else { return };
    change(&mut diagnosis);
    let mut data = Vec::new();
    diagnosis.write(&mut data);
    *telegram = with_data(&frame, &data);
}

/// Uses a watchdog time base of 1 ms.
#[derive(Default)]
pub struct InMilliseconds {
    base: u32,
}

impl SlaveHooks for InMilliseconds {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((_, parameters)) = parameters(telegram) {
            self.base = parameters.dpv1().unwrap_or_default().watchdog_base_ms();
        }
        vec![telegram.to_vec()]
    }

    fn watchdog(&mut self, right: Duration) -> Duration {
        right / self.base.max(1)
    }
}

/// Continues after power-up with the parameters and configuration of the last session.
#[derive(Default)]
pub struct ResumedSession {
    parameters: Option<Vec<u8>>,
    configuration: Option<Vec<u8>>,
    is_new: bool,
}

impl SlaveHooks for ResumedSession {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let mut received = Vec::new();
        if mem::take(&mut self.is_new) {
            received.extend(self.parameters.as_deref().map(uncounted));
            received.extend(self.configuration.as_deref().map(uncounted));
        }
        let locks = |of: &SetPrm| of.status.has(StationStatus::LOCK_REQ) && !of.status.has(StationStatus::UNLOCK_REQ);
        if let Some((frame, mut parameters)) = parameters(telegram).filter(|(_, parameters)| locks(parameters)) {
            // The old watchdog would end the data exchange at once.
            parameters.status.0 &= !StationStatus::WD_ON.0;
            self.parameters = Some(with_parameters(&frame, &parameters));
        }
        if is_request(telegram, CHK_CFG) {
            self.configuration = Some(telegram.to_vec());
        }
        received.push(telegram.to_vec());
        received
    }

    fn starts(&mut self) {
        self.is_new = true;
    }
}

/// Does not pass parameters to the encoder after a data exchange.
#[derive(Default)]
pub struct ParametersTakenOnce {
    has_exchanged: bool,
}

impl SlaveHooks for ParametersTakenOnce {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        vec![telegram.to_vec()]
    }

    fn parameters(&mut self, _: &mut SetPrm) -> bool {
        !self.has_exchanged
    }

    fn inputs(&mut self, _: Time, _: &mut [u8]) {
        self.has_exchanged = true;
    }

    fn starts(&mut self) {
        self.has_exchanged = false;
    }
}

/// Accepts a configuration after an invalid one as if Set_Prm had been repeated.
#[derive(Default)]
pub struct ConfigurationRetry {
    parameters: Option<Vec<u8>>,
    had_configuration: bool,
}

impl SlaveHooks for ConfigurationRetry {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((_, set_prm)) = parameters(telegram) {
            let is_lock = set_prm.status.has(StationStatus::LOCK_REQ) && !set_prm.status.has(StationStatus::UNLOCK_REQ);
            self.parameters = is_lock.then(|| telegram.to_vec());
            self.had_configuration = false;
        }
        let mut received = vec![telegram.to_vec()];
        if is_request(telegram, CHK_CFG) && mem::replace(&mut self.had_configuration, true) {
            received.splice(..0, self.parameters.as_deref().map(uncounted));
        }
        received
    }

    fn starts(&mut self) {
        *self = ConfigurationRetry::default();
    }
}

/// Starts data exchange after Set_Prm as if a valid Chk_Cfg had been received.
#[derive(Default)]
pub struct ConfiguresEarly {
    /// The Set_Prm, until a configuration follows.
    parameters: Option<Vec<u8>>,
}

impl SlaveHooks for ConfiguresEarly {
    fn received_telegrams(&mut self, encoder: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let mut received = vec![telegram.to_vec()];
        match request(telegram) {
            Some((_, SET_PRM)) => self.parameters = Some(telegram.to_vec()),
            Some((_, CHK_CFG)) => self.parameters = None,
            Some((_, SapService::DataExchange)) => {
                let before = self.parameters.take();
                let configuration = before.as_deref().and_then(frame).map(|frame| {
                    let mut identifiers = Vec::new();
                    encoder.configuration(&mut identifiers);
                    let sap = Some(SlaveSap::CHK_CFG.0);
                    let destination = Extension { sap, ..frame.destination };
                    uncounted(&with_data(&DataFrame { destination, ..frame }, &identifiers))
                });
                received.splice(..0, configuration);
            }
            _ => {}
        }
        received
    }

    fn starts(&mut self) {
        self.parameters = None;
    }
}

/// Keeps the outputs during Clear.
#[derive(Default)]
pub struct OutputsHeldInClear {
    outputs: Option<Vec<u8>>,
    is_clear: bool,
}

impl SlaveHooks for OutputsHeldInClear {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        match request(telegram) {
            Some((frame, SapService::Slave(SlaveSap::GLOBAL_CONTROL))) => {
                let Ok(mut control) = GlobalControl::parse(frame.data) else { return vec![telegram.to_vec()] };
                self.is_clear = control.command.has(GlobalCommand::CLEAR_DATA);
                control.command.0 &= !GlobalCommand::CLEAR_DATA.0;
                let mut data = Vec::new();
                control.write(&mut data);
                return vec![with_data(&frame, &data)];
            }
            Some((frame, SapService::DataExchange)) if self.is_clear => {
                if let Some(outputs) = self.outputs.as_ref().filter(|outputs| outputs.len() == frame.data.len()) {
                    return vec![with_data(&frame, outputs)];
                }
            }
            Some((frame, SapService::DataExchange)) => self.outputs = Some(frame.data.to_vec()),
            _ => {}
        }
        vec![telegram.to_vec()]
    }
}

/// Sends inputs of 0 during Clear.
#[derive(Default)]
pub struct ZeroInputsInClear {
    is_clear: bool,
}

impl SlaveHooks for ZeroInputsInClear {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((frame, SapService::Slave(SlaveSap::GLOBAL_CONTROL))) = request(telegram)
            && let Ok(control) = GlobalControl::parse(frame.data)
        {
            self.is_clear = control.command.has(GlobalCommand::CLEAR_DATA);
        }
        vec![telegram.to_vec()]
    }

    fn inputs(&mut self, _: Time, inputs: &mut [u8]) {
        if self.is_clear {
            inputs.fill(0);
        }
    }
}

/// Answers RD_Inp with the inputs of the first Data_Exchange.
#[derive(Default)]
pub struct OldInputs {
    first: Option<Vec<u8>>,
}

impl SlaveHooks for OldInputs {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if is_request(telegram, CHK_CFG) {
            self.first = None;
        }
        vec![telegram.to_vec()]
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        let Some(frame) = frame(telegram) else { return };
        match (SapService::of(&frame), &self.first) {
            (SapService::DataExchange, None) => self.first = Some(frame.data.to_vec()),
            (SapService::Slave(SlaveSap::READ_INPUTS), Some(first)) => *telegram = with_data(&frame, first),
            _ => {}
        }
    }
}

/// Answers RD_Outp with the outputs of the first Data_Exchange.
#[derive(Default)]
pub struct OldOutputs {
    first: Option<Vec<u8>>,
}

impl SlaveHooks for OldOutputs {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        match request(telegram) {
            Some((_, CHK_CFG)) => self.first = None,
            Some((frame, SapService::DataExchange)) if self.first.is_none() => self.first = Some(frame.data.to_vec()),
            _ => {}
        }
        vec![telegram.to_vec()]
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        let Some(frame) = frame(telegram) else { return };
        if let (SapService::Slave(SlaveSap::READ_OUTPUTS), Some(first)) = (SapService::of(&frame), &self.first)
            && !frame.data.is_empty()
        {
            *telegram = with_data(&frame, first);
        }
    }
}

/// Ends the data exchange after a Slave_Diag.
#[derive(Default)]
pub struct EndsAtDiagnosis {
    /// A Set_Prm that unlocks the slave.
    unlock: Option<Vec<u8>>,
    is_reported: bool,
}

impl SlaveHooks for EndsAtDiagnosis {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let mut received = vec![telegram.to_vec()];
        if mem::take(&mut self.is_reported) {
            received.splice(..0, self.unlock.take().as_deref().map(uncounted));
        }
        if let Some((frame, mut parameters)) = parameters(telegram) {
            parameters.status = StationStatus::UNLOCK_REQ;
            self.unlock = Some(with_parameters(&frame, &parameters));
        }
        received
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if let Some((_, diagnosis)) = diagnosis_response(telegram) {
            self.is_reported = !diagnosis.status_1.has(Status1::STATION_NOT_READY);
        }
    }
}

/// Announces the diagnosis by high priority in the wrong answers.
pub struct DiagnosisAnnouncement {
    /// The number of answers, every tenth of which announces a fault; `None` if no answer announces anything.
    pub counts: Option<u32>,
    /// Whether the last diagnosis had Ext_Diag set.
    pub is_faulty: bool,
}

impl SlaveHooks for DiagnosisAnnouncement {
    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if let Some((_, diagnosis)) = diagnosis_response(telegram) {
            self.is_faulty = diagnosis.status_1.has(Status1::EXT_DIAG);
            return;
        }
        let Some(frame) = frame(telegram).filter(|frame| SapService::of(frame) == SapService::DataExchange) else {
            return;
        };
        let function = match &mut self.counts {
            None => AnswerFunction::DATA_LOW,
            Some(count) => {
                *count += 1;
                let is_due = self.is_faulty && count.is_multiple_of(10);
                if frame.fc.answered() == Some(AnswerFunction::DATA_HIGH) || is_due {
                    AnswerFunction::DATA_HIGH
                } else {
                    AnswerFunction::DATA_LOW
                }
            }
        };
        let fc = FunctionCode::answer(function, StationType::SLAVE);
        *telegram = with_data(&DataFrame { fc, ..frame }, frame.data);
    }
}

/// Keeps reporting a fault after it has disappeared.
pub struct StickingFault {
    bit: Status1,
    was_there: bool,
}

impl StickingFault {
    /// Creates one for the fault of this bit.
    pub fn new(bit: Status1) -> StickingFault {
        StickingFault { bit, was_there: false }
    }
}

impl SlaveHooks for StickingFault {
    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        change_diagnosis(telegram, |diag| {
            self.was_there |= diag.status_1.has(self.bit);
            if self.was_there {
                diag.status_1 = diag.status_1.with(self.bit);
            }
        });
    }

    fn starts(&mut self) {
        self.was_there = false;
    }
}

/// Reports the first master since power-up.
#[derive(Default)]
pub struct FirstMaster(Option<u8>);

impl SlaveHooks for FirstMaster {
    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        change_diagnosis(telegram, |diag| {
            if diag.master != NO_MASTER {
                self.0.get_or_insert(diag.master);
            }
            diag.master = self.0.unwrap_or(NO_MASTER);
        });
    }

    fn starts(&mut self) {
        self.0 = None;
    }
}

/// Reports the last master after power-up until there is another one.
#[derive(Default)]
pub struct LastMaster {
    last: Option<u8>,
    /// Whether there was a master since power-up.
    is_of_now: bool,
}

impl SlaveHooks for LastMaster {
    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        change_diagnosis(telegram, |diag| {
            if diag.master != NO_MASTER {
                (self.last, self.is_of_now) = (Some(diag.master), true);
            } else if !self.is_of_now {
                diag.master = self.last.unwrap_or(NO_MASTER);
            }
        });
    }

    fn starts(&mut self) {
        self.is_of_now = false;
    }
}

/// Keeps the address of power-up until the next power-up.
#[derive(Default)]
pub struct EarlierAddress {
    at_start: Option<u8>,
}

impl SlaveHooks for EarlierAddress {
    fn received_telegrams(&mut self, encoder: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let (now, at_start) = (encoder.address(), *self.at_start.get_or_insert(encoder.address()));
        match request(telegram) {
            Some((frame, _)) if now != at_start && frame.da == at_start => {
                vec![with_data(&DataFrame { da: now, ..frame }, frame.data)]
            }
            Some((frame, _)) if now != at_start && frame.da == now => Vec::new(),
            _ => vec![telegram.to_vec()],
        }
    }

    fn sent_telegram(&mut self, encoder: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if let (Some(at_start), Some(frame)) = (self.at_start, frame(telegram))
            && frame.sa == encoder.address()
        {
            *telegram = with_data(&DataFrame { sa: at_start, ..frame }, frame.data);
        }
    }

    fn starts(&mut self) {
        self.at_start = None;
    }
}

/// Sets Not_Supported if Set_Prm had reserved operating bits.
#[derive(Default)]
pub struct NotSupported {
    had_bits: bool,
}

impl SlaveHooks for NotSupported {
    fn parameters(&mut self, parameters: &mut SetPrm) -> bool {
        self.had_bits = parameters.user.get(3).is_some_and(|bits| bits & 0x34 != 0);
        true
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        let had_bits = self.had_bits;
        change_diagnosis(telegram, |diag| {
            if had_bits {
                diag.status_1 = diag.status_1.with(Status1::NOT_SUPPORTED);
            }
        });
    }

    fn starts(&mut self) {
        self.had_bits = false;
    }
}

/// Uses a new address of switches or memory at once, not only after power-up.
pub struct FollowsAddress;

impl SlaveHooks for FollowsAddress {
    fn check(&mut self, encoder: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        match check {
            SlaveStackCheck::Address(address) => address == encoder.address() && address <= UNNAMED,
            _ => verdict,
        }
    }

    fn sent_telegram(&mut self, encoder: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if let Some(frame) = frame(telegram) {
            *telegram = with_data(&DataFrame { sa: encoder.address(), ..frame }, frame.data);
        }
    }
}

/// Does not answer Data_Exchange on a fast bus.
#[derive(Default)]
pub struct NoFastExchange {
    is_fast: bool,
}

impl SlaveHooks for NoFastExchange {
    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        if let SlaveStackCheck::Rate(baud) = check {
            self.is_fast = baud > 1_500_000;
        }
        verdict
    }

    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let exchange = request(telegram).filter(|(_, service)| *service == SapService::DataExchange);
        if self.is_fast && exchange.is_some() { Vec::new() } else { vec![telegram.to_vec()] }
    }
}
