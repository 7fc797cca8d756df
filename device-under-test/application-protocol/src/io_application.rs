//! The application of a PROFINET device in a program.

use crate::answer::{AnsweredDiagnosis, AnsweredInputs, ApplicationAnswer, SeverityWord};
use crate::dialogue::{ProgramDialogue, RemoteApplication, words_of};
use crate::hex::HexText;
use crate::program::{SharedProgram, in_program};
use crate::request::{ApplicationRequest, RequestedOutputs, ScopeWord, SubmodulePlace};
use device_stack::profinet::{
    ArKey, DiagnosisChange, DiagnosisSeverity, IoApplication, IoIdentity, PluggableSubmodule, RecordAccess,
    RecordRefusal, ResetScope, StackStatus, StationData, SubmoduleDiagnosis,
};
use station::{StandAction, Time};
use std::collections::VecDeque;
use wire::profibus::dpv1::RecordError;
use wire::profinet::dcp::station_name;

/// A program behind the PROFINET stack. The station name and the addresses are kept here, since the program has no network.
///
/// Outputs are sent to the program together with the request for the next inputs, so a cycle is one message and its answer. There
/// is none while the program says that its inputs are constant and the outputs stay the same.
#[derive(Debug)]
pub struct RemoteIoApplication {
    dialogue: ProgramDialogue,
    identity: IoIdentity,
    plugs: Vec<PluggableSubmodule>,
    stored: StationData,
    /// The MAC address, if the program wants to know the station.
    known_mac: Option<[u8; 6]>,
    diagnosis: VecDeque<DiagnosisChange>,
    /// Outputs that were not sent yet.
    waiting: Vec<RequestedOutputs>,
    /// The last outputs of each submodule.
    outputs: Vec<RequestedOutputs>,
    inputs: Vec<AnsweredInputs>,
}

impl RemoteIoApplication {
    /// The device of `program` in factory state, except for its station data. `None` if the program has no device on PROFINET.
    pub fn new(program: SharedProgram, shaft: u64, station: StationData, mac: [u8; 6]) -> Option<RemoteIoApplication> {
        let (identity, plugs, wants_station) = {
            let program = in_program(&program);
            let described = program.description().profinet.as_ref()?;
            (program.io_identity()?.clone(), described.plugs(), described.station)
        };
        let mut application = RemoteIoApplication {
            dialogue: ProgramDialogue::new(program),
            identity,
            plugs,
            stored: station,
            known_mac: wants_station.then_some(mac),
            diagnosis: VecDeque::new(),
            waiting: Vec::new(),
            outputs: Vec::new(),
            inputs: Vec::new(),
        };
        application.ask(&ApplicationRequest::Reset { shaft });
        application.report_station(Time::ZERO, &application.stored.clone());
        Some(application)
    }

    /// Sends name and addresses to a program that wants to know them.
    fn report_station(&mut self, now: Time, station: &StationData) {
        let Some(mac) = self.known_mac else { return };
        self.ask_at(
            now,
            &ApplicationRequest::Station {
                now: now.as_nanos(),
                name: String::from_utf8_lossy(&station.name).into_owned(),
                ip: station.ip.into(),
                mask: station.mask.into(),
                gateway: station.gateway.into(),
                mac: mac.as_slice().into(),
            },
        );
    }

    fn forget_outputs(&mut self) {
        self.waiting.clear();
        self.outputs.clear();
    }

    /// The result of an access to a record.
    fn accessed(&self, request: &ApplicationRequest, answer: Option<&ApplicationAnswer>) -> Result<(), RecordRefusal> {
        let answer = answer.ok_or(RecordRefusal::StateConflict)?;
        let Some(word) = &answer.refused else { return Ok(()) };
        Err(refusal(word).unwrap_or_else(|| {
            let known: Vec<&str> = REFUSALS.iter().filter_map(|refusal| RecordError(refusal.code1()).word()).collect();
            self.dialogue.refuse(request, format!("`refused` is `{word}`; use one of {}", known.join(", ")));
            RecordRefusal::StateConflict
        }))
    }

    fn inputs_length(&self, of: &AnsweredInputs) -> Option<usize> {
        let plugs = self.plugs.iter().filter(|plug| (plug.slot, plug.subslot) == (of.slot, of.subslot));
        let mut lengths = plugs.map(|plug| usize::from(plug.input_octets));
        let length = of.data.0.len();
        let first = lengths.next()?;
        if first == length || lengths.any(|other| other == length) { None } else { Some(first) }
    }
}

/// Every refusal of a record.
const REFUSALS: [RecordRefusal; 7] = [
    RecordRefusal::InvalidIndex,
    RecordRefusal::WriteLength,
    RecordRefusal::InvalidSlot,
    RecordRefusal::StateConflict,
    RecordRefusal::AccessDenied,
    RecordRefusal::InvalidRange,
    RecordRefusal::InvalidParameter,
];

fn refusal(word: &str) -> Option<RecordRefusal> {
    let code = RecordError::by_word(word)?.0;
    REFUSALS.into_iter().find(|refusal| refusal.code1() == code)
}

fn diagnosis(of: &AnsweredDiagnosis, plugs: &[PluggableSubmodule]) -> DiagnosisChange {
    let plug = plugs.iter().find(|plug| (plug.slot, plug.subslot) == (of.slot, of.subslot));
    let diagnosis = SubmoduleDiagnosis {
        api: plug.map_or(0, |plug| plug.api),
        slot: of.slot,
        subslot: of.subslot,
        channel: of.channel,
        error_type: of.error_type,
        extended: of.extended_type.map(|extended| (extended, of.added_value)),
        severity: match of.severity {
            SeverityWord::Fault => DiagnosisSeverity::Fault,
            SeverityWord::MaintenanceDemanded => DiagnosisSeverity::MaintenanceDemanded,
            SeverityWord::MaintenanceRequired => DiagnosisSeverity::MaintenanceRequired,
        },
    };
    DiagnosisChange { appears: of.appears, diagnosis }
}

fn scope_word(scope: ResetScope) -> ScopeWord {
    match scope {
        ResetScope::Factory => ScopeWord::Factory,
        ResetScope::ApplicationData => ScopeWord::ApplicationData,
        ResetScope::Communication => ScopeWord::Communication,
        ResetScope::Engineering => ScopeWord::Engineering,
        ResetScope::AllData => ScopeWord::AllData,
        ResetScope::Device => ScopeWord::Device,
        ResetScope::FactoryImage => ScopeWord::FactoryImage,
        ResetScope::Other(_) => ScopeWord::Other,
    }
}

fn connection(ar: Option<ArKey>) -> u32 {
    ar.map_or(0, |ar| ar.0.saturating_add(1))
}

impl RemoteApplication for RemoteIoApplication {
    fn dialogue(&mut self) -> &mut ProgramDialogue {
        &mut self.dialogue
    }

    fn ask(&mut self, request: &ApplicationRequest) -> Option<ApplicationAnswer> {
        let answer = self.dialogue.ask(request)?;
        self.diagnosis.extend(answer.diagnosis.iter().map(|of| diagnosis(of, &self.plugs)));
        Some(answer)
    }

    fn send_outputs(&mut self, now: Time) {
        if !self.waiting.is_empty() {
            let outputs = std::mem::take(&mut self.waiting);
            self.ask(&ApplicationRequest::Cycle { now: now.as_nanos(), outputs, inputs: false });
        }
    }
}

impl IoApplication for RemoteIoApplication {
    fn identity(&self) -> &IoIdentity {
        &self.identity
    }

    fn plugs(&self) -> &[PluggableSubmodule] {
        &self.plugs
    }

    fn stored_station(&self) -> StationData {
        self.stored.clone()
    }

    fn set_station(&mut self, now: Time, current: &StationData, stored: &StationData) {
        self.stored = stored.clone();
        self.report_station(now, current);
    }

    fn accepts_name(&self, name: &[u8]) -> bool {
        name.is_empty() || station_name::check(name).is_ok()
    }

    fn factory_reset(&mut self, now: Time, scope: ResetScope) -> bool {
        let request = ApplicationRequest::FactoryReset { now: now.as_nanos(), scope: scope_word(scope) };
        let is_done = self.ask_at(now, &request).is_some_and(|answer| answer.done.is_some());
        let has_station = !matches!(scope, ResetScope::ApplicationData | ResetScope::Engineering);
        if is_done && has_station {
            self.stored = StationData::default();
            self.report_station(now, &StationData::default());
        }
        is_done
    }

    fn power_up(&mut self, now: Time) {
        self.ask(&ApplicationRequest::PowerUp { now: now.as_nanos() });
        self.report_station(now, &self.stored.clone());
    }

    fn power_down(&mut self, now: Time) {
        self.forget_outputs();
        self.ask(&ApplicationRequest::PowerDown { now: now.as_nanos() });
        self.diagnosis.clear();
    }

    fn started(&mut self, now: Time, ar: ArKey, plugged: &[PluggableSubmodule]) {
        let place = |plug: &PluggableSubmodule| SubmodulePlace {
            slot: plug.slot,
            subslot: plug.subslot,
            module_ident: plug.module_ident,
            submodule_ident: plug.submodule_ident,
        };
        let submodules = plugged.iter().map(place).collect();
        let request = ApplicationRequest::Connect { now: now.as_nanos(), connection: connection(Some(ar)), submodules };
        self.ask_at(now, &request);
    }

    fn parameter_end(&mut self, now: Time, ar: ArKey) -> Time {
        let request = ApplicationRequest::ParameterEnd { now: now.as_nanos(), connection: connection(Some(ar)) };
        let ready = self.ask_at(now, &request).and_then(|answer| answer.ready);
        ready.map_or(now, Time::from_nanos).max(now)
    }

    fn ended(&mut self, now: Time, ar: ArKey) {
        let request = ApplicationRequest::Disconnect { now: now.as_nanos(), connection: connection(Some(ar)) };
        self.ask_at(now, &request);
        self.outputs.clear();
    }

    fn write_record(&mut self, now: Time, access: RecordAccess, data: &[u8]) -> Result<(), RecordRefusal> {
        let request = ApplicationRequest::WriteRecord {
            now: now.as_nanos(),
            connection: connection(access.ar),
            slot: access.slot,
            subslot: Some(access.subslot),
            index: access.index,
            data: data.into(),
        };
        let answer = self.ask_at(now, &request);
        self.accessed(&request, answer.as_ref())
    }

    fn read_record(&mut self, now: Time, access: RecordAccess, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        let request = ApplicationRequest::ReadRecord {
            now: now.as_nanos(),
            connection: connection(access.ar),
            slot: access.slot,
            subslot: Some(access.subslot),
            index: access.index,
        };
        let answer = self.ask_at(now, &request);
        self.accessed(&request, answer.as_ref())?;
        self.dialogue.take_record(&request, answer, out);
        Ok(())
    }

    fn outputs(&mut self, now: Time, slot: u16, subslot: u16, data: Option<&[u8]>) {
        let last = self.outputs.iter_mut().find(|of| (of.slot, of.subslot) == (slot, subslot));
        let is_same = last.as_ref().is_some_and(|last| last.data.as_ref().map(|data| data.0.as_slice()) == data);
        if is_same && now < self.dialogue.constant_until && self.waiting.is_empty() {
            return;
        }
        let new = RequestedOutputs { at: now.as_nanos(), slot, subslot, data: data.map(HexText::from) };
        match last {
            Some(_) if is_same => {}
            Some(last) => last.data.clone_from(&new.data),
            None => self.outputs.push(new.clone()),
        }
        self.waiting.push(new);
    }

    fn frame(&mut self, now: Time) {
        if self.waiting.is_empty() && now < self.dialogue.constant_until {
            return;
        }
        let outputs = std::mem::take(&mut self.waiting);
        let request = ApplicationRequest::Cycle { now: now.as_nanos(), outputs, inputs: true };
        let Some(answer) = self.ask(&request) else {
            self.inputs.clear();
            return;
        };
        let Some(inputs) = answer.inputs else {
            return self.dialogue.refuse(&request, "it has no `inputs`".to_owned());
        };
        if let Some((of, length)) = inputs.iter().find_map(|of| Some((of, self.inputs_length(of)?))) {
            let (slot, subslot, given) = (of.slot, of.subslot, of.data.0.len());
            let why = format!("the inputs of slot {slot} subslot {subslot} have {given} bytes instead of {length}");
            self.dialogue.refuse(&request, why);
        }
        self.inputs = inputs;
        self.dialogue.constant_until = answer.constant_until.map_or(Time::ZERO, Time::from_nanos);
    }

    fn inputs(&mut self, now: Time, slot: u16, subslot: u16, data: &mut [u8]) -> bool {
        if let Some(of) = self.inputs.iter().find(|of| (of.slot, of.subslot) == (slot, subslot)) {
            if of.data.0.len() == data.len() {
                data.copy_from_slice(&of.data.0);
                return of.good;
            }
        } else if in_program(&self.dialogue.program).failure().is_none() {
            let request = ApplicationRequest::Cycle { now: now.as_nanos(), outputs: Vec::new(), inputs: true };
            self.dialogue.refuse(&request, format!("it has no inputs of slot {slot} subslot {subslot}"));
        }
        data.fill(0);
        false
    }

    fn next_diagnosis(&mut self) -> Option<DiagnosisChange> {
        self.diagnosis.pop_front()
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        self.act_on_device(now, action)
    }

    fn is_alive(&self) -> bool {
        self.dialogue.is_alive
    }

    fn led(&mut self, now: Time, name: &str, status: &StackStatus) -> Option<&'static str> {
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
fn words(status: &StackStatus) -> Vec<String> {
    words_of(&[
        (status.has_supply, "supply"),
        (status.is_booting, "booting"),
        (status.is_linked, "link"),
        (status.has_connection, "connection"),
        (status.exchanges_data, "data_exchange"),
        (status.module_differs, "wrong_module"),
        (status.is_signalling, "signal"),
    ])
}
