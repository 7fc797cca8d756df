//! Start-ups: from `start` of a suite to the connection of the controller, and from its outcome to replies.

use super::persona;
use crate::record::octets;
use controllers::profinet_io::{
    ArConfig, ArStartUpResult, CallError, ConnectField, ConnectOutcome, ConnectSubmodule, ControlOutcome,
    DeviceAddress, IoRecordOutcome, RecordAddress, StartUpRecord as StartRecord,
};
use expression::Value;
use judge::answer::{NegativeResponse, ReceivedReply};
use station::Duration;
use std::sync::Arc;
use suite::device::DeviceDescription;
use suite::model::{AnswerPart, ConnectionStart, StartDeviation};
use suite::persona::{ExpectedSubmodules, Persona};
use wire::profinet::blocks::connect::{ArType, RtClass};
use wire::profinet::blocks::module_diff::{
    ArInfo, IdentInfo, ModuleDiff, ModuleDiffBlock, ModuleState, SubmoduleState,
};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::rt::FrameId;
use wire::profinet::status::{ErrorCode, PnioStatus};

/// How the controller finds the device under test, and what it gives it.
#[derive(Clone, Debug)]
pub struct DeviceLocation {
    /// Its station name, or its MAC address if a trial has changed the name.
    pub address: DeviceAddress,
    /// The IP address, mask and gateway that the controller gives it.
    pub ip: IpParameter,
    /// Whether the device is connected with the address that it has, if it has one.
    pub keeps_address: bool,
    /// How long the search for the device may take.
    pub search: Duration,
    /// The persona of the controller.
    pub persona: Option<Arc<Persona>>,
}

/// The frame ids proposed for inputs, by RT class.
const FRAME_ID_OF_CLASS_1: u16 = 0xC001;
const FRAME_ID_OF_CLASS_2: u16 = 0x8001;
const FRAME_ID_OF_CLASS_3: u16 = 0x0101;
/// Send clock factor 32 times 31.25 µs: the send clock that every device supports.
const SEND_CLOCK: Duration = Duration::from_millis(1);

/// The connection of a usual start: the first module of the manual, all start parameters with their defaults.
pub fn usual_connection(
    device: &DeviceDescription,
    variant: usize,
    address: DeviceAddress,
    ip: IpParameter,
) -> ArConfig {
    let start = ConnectionStart {
        module: 0,
        cycle: None,
        watchdog: None,
        unwatched: false,
        baud: None,
        isochronous: None,
        parameters: Vec::new(),
        instead: Vec::new(),
    };
    let search = ArConfig::new(address.clone(), ip).search;
    connection(device, variant, &start, &DeviceLocation { address, ip, keeps_address: true, search, persona: None }).0
}

/// The connection for `start`, and for each of its start-up records the index of the device's record.
pub fn connection(
    device: &DeviceDescription,
    variant: usize,
    start: &ConnectionStart,
    at: &DeviceLocation,
) -> (ArConfig, Vec<usize>) {
    let mut submodules = Vec::new();
    let module = &device.modules[start.module];
    let telegram = module.submodules.iter().copied().max_by_key(|&index| {
        let submodule = &device.submodules[index];
        submodule.input_octets + submodule.output_octets
    });
    let persona = at.persona.as_deref();
    let expects = persona.map_or(ExpectedSubmodules::AccessPoint, |persona| persona.expects);
    let access_point = device.submodules.iter().enumerate().filter(|(_, submodule)| submodule.slot == 0);
    let leaves_out = start.instead.contains(&StartDeviation::NoAccessPoint);
    let access_point = access_point.filter(|_| expects != ExpectedSubmodules::Module && !leaves_out);
    let of_module = module.submodules.iter().map(|&index| (index, &device.submodules[index]));
    for (index, submodule) in access_point.chain(of_module) {
        let mut expected = ConnectSubmodule {
            api: submodule.api,
            slot: requested_slot(start, submodule.slot),
            module_ident: submodule.module_ident(variant).or(module.ident()).unwrap_or_default(),
            subslot: submodule.subslot,
            submodule_ident: submodule.ident,
            input_octets: submodule.input_octets,
            output_octets: submodule.output_octets,
        };
        for instead in &start.instead {
            let of_telegram = Some(index) == telegram;
            match instead {
                StartDeviation::OutputLength(octets) if of_telegram => expected.output_octets = *octets,
                StartDeviation::InputLength(octets) if of_telegram => expected.input_octets = *octets,
                StartDeviation::ModuleIdent(ident) if submodule.slot != 0 => expected.module_ident = *ident,
                StartDeviation::SubmoduleIdent(ident) if of_telegram => expected.submodule_ident = *ident,
                StartDeviation::Api(api) if of_telegram => expected.api = *api,
                StartDeviation::AccessPointIdent(ident) if submodule.slot == 0 => expected.module_ident = *ident,
                _ => {}
            }
        }
        submodules.push(expected);
    }
    let adds_network = start.instead.contains(&StartDeviation::NetworkExpected);
    if expects == ExpectedSubmodules::InterfaceAndPorts || adds_network {
        let head = submodules.iter().position(|submodule| submodule.slot != 0).unwrap_or(submodules.len());
        let module_ident = submodules.first().filter(|first| first.slot == 0).map(|first| first.module_ident);
        let network = device.profinet().map_or(&[][..], |facts| &facts.network).iter().filter_map(
            |&(subslot, submodule_ident)| {
                Some(ConnectSubmodule {
                    module_ident: module_ident?,
                    subslot,
                    submodule_ident,
                    ..ConnectSubmodule::default()
                })
            },
        );
        let network: Vec<ConnectSubmodule> = network.collect();
        submodules.splice(head..head, network);
    }
    let (mut records, mut indices) = start_records(device, start, &submodules);
    let cycles = |time: Duration| (time.as_nanos() / SEND_CLOCK.as_nanos()).max(1);
    let cycle = start.cycle(device);
    let reduction = cycles(cycle);
    let watchdog = (start.watchdog(device).as_nanos() / cycle.as_nanos().max(1)).max(1);
    if persona.is_some_and(|persona| persona.records_reversed) {
        records.reverse();
        indices.reverse();
    }
    let mut connection = ArConfig::new(at.address.clone(), at.ip);
    connection.submodules = submodules;
    connection.search = at.search;
    connection.gives_address = !at.keeps_address;
    (connection.vendor_id, connection.device_id) = device.ids().unwrap_or_default();
    connection.records = records;
    if device.profinet().is_some_and(|facts| facts.rt_class == 2) {
        (connection.rt_class, connection.frame_id_in) = (RtClass::RT_CLASS_2, FRAME_ID_OF_CLASS_2);
    }
    connection.send_clock_factor = 32;
    connection.reduction_ratio = u16::try_from(reduction).unwrap_or(u16::MAX);
    connection.watchdog_factor = u16::try_from(watchdog).unwrap_or(u16::MAX);
    connection.data_hold_factor = connection.watchdog_factor;
    if let Some(persona) = persona {
        persona::apply_persona(persona, start, &mut connection);
    }
    for instead in &start.instead {
        match instead {
            StartDeviation::StationName(name) => connection.station_name = Some(name.clone().into_bytes()),
            StartDeviation::RtClass(class) => {
                connection.rt_class = RtClass(*class);
                (connection.frame_id_in, connection.unchecked) = (frame_id_of(connection.rt_class), true);
                connection.frame_id_out = FrameId::DEVICE_CHOOSES.0;
            }
            StartDeviation::ParameterPause(pause) => connection.parameter_pause = *pause,
            StartDeviation::ConnectField(word, value) => {
                connection.replaced_fields.extend(ConnectField::by_word(word).map(|field| (field, *value)));
            }
            StartDeviation::LittleEndian => connection.little_endian = true,
            StartDeviation::NoAddress => connection.gives_address = false,
            StartDeviation::SupervisorAccess => {
                (connection.ar_type, connection.device_access) = (ArType::IOSAR, true);
                connection.submodules.clear();
                connection.records.clear();
            }
            // Slot 0 has its own module, so the same subslot may occur there twice.
            StartDeviation::Slot(_) => connection.unchecked = true,
            _ => {}
        }
    }
    (connection, indices)
}

fn frame_id_of(class: RtClass) -> u16 {
    match class {
        RtClass::RT_CLASS_2 => FRAME_ID_OF_CLASS_2,
        RtClass::RT_CLASS_3 => FRAME_ID_OF_CLASS_3,
        _ => FRAME_ID_OF_CLASS_1,
    }
}

fn start_records(
    device: &DeviceDescription,
    start: &ConnectionStart,
    submodules: &[ConnectSubmodule],
) -> (Vec<StartRecord>, Vec<usize>) {
    let mut records = Vec::new();
    let mut indices = Vec::new();
    for (index, record) in device.records.iter().enumerate().filter(|(_, record)| record.starts(start.module)) {
        let at = &device.submodules[record.at];
        let slot = requested_slot(start, at.slot);
        if !submodules.iter().any(|submodule| (submodule.slot, submodule.subslot) == (slot, at.subslot)) {
            continue;
        }
        let mut data =
            octets(record, start.parameters.iter().filter(|of| of.record == index).map(|of| (of.field, of.value)));
        let mut sent = true;
        for instead in &start.instead {
            match instead {
                StartDeviation::RecordNone(of) if *of == index => sent = false,
                StartDeviation::RecordBytes(of, octets) if *of == index => data.clone_from(octets),
                _ => {}
            }
        }
        if sent {
            let target = RecordAddress { api: at.api, slot, subslot: at.subslot, index: record.index };
            records.push(StartRecord { target, data });
            indices.push(index);
        }
    }
    (records, indices)
}

/// A refusal; its error code has to be that of the service.
pub fn refused(status: &PnioStatus, of: ErrorCode) -> ReceivedReply {
    if status.error_code == of {
        ReceivedReply::Refused(NegativeResponse::Pnio(*status))
    } else {
        ReceivedReply::Wrong(format!("{status} is not an answer of this service"))
    }
}

/// The reply for a call that the service itself did not answer.
pub fn failed(error: &CallError) -> ReceivedReply {
    match error {
        CallError::Rejected(_) | CallError::Faulted(_) | CallError::Unfit(_) => ReceivedReply::Wrong(error.to_string()),
        CallError::NoAnswer(_) | CallError::ArEnded => ReceivedReply::Silent(error.to_string()),
    }
}

fn connect(outcome: &ConnectOutcome) -> ReceivedReply {
    match outcome {
        ConnectOutcome::Accepted => ReceivedReply::Accepted,
        ConnectOutcome::Refused(status) => refused(status, ErrorCode::CONNECT_RESPONSE),
        ConnectOutcome::Failed(error) => failed(error),
    }
}

/// The reply for a Control or Release, given by its error code.
pub fn control(outcome: &ControlOutcome, of: ErrorCode) -> ReceivedReply {
    match outcome {
        ControlOutcome::Accepted => ReceivedReply::Accepted,
        ControlOutcome::Refused(status) => refused(status, of),
        ControlOutcome::Failed(error) => failed(error),
    }
}

/// The reply for an access to a record.
pub fn record(outcome: &IoRecordOutcome, written: bool) -> ReceivedReply {
    let of = if written { ErrorCode::WRITE_RESPONSE } else { ErrorCode::READ_RESPONSE };
    match outcome {
        IoRecordOutcome::Accepted { .. } => ReceivedReply::Accepted,
        IoRecordOutcome::Refused(status) => refused(status, of),
        IoRecordOutcome::Failed(error) => failed(error),
    }
}

/// The slot in which the connection requests a submodule of the device.
fn requested_slot(start: &ConnectionStart, slot: u16) -> u16 {
    let moved = start.instead.iter().find_map(|instead| match instead {
        StartDeviation::Slot(moved) => Some(*moved),
        _ => None,
    });
    moved.filter(|_| slot != 0).unwrap_or(slot)
}

/// The parts of the answer to a start-up.
pub fn replies(
    device: &DeviceDescription,
    asked: &ConnectionStart,
    start: &ArStartUpResult,
    records: &[usize],
) -> Vec<(AnswerPart, ReceivedReply)> {
    let mut replies = Vec::new();
    if let Some(outcome) = &start.connect {
        replies.push((AnswerPart::Connect, connect(outcome)));
    }
    for (outcome, &index) in start.records.iter().zip(records) {
        replies.push((AnswerPart::Record(index), record(outcome, true)));
    }
    if let Some(outcome) = &start.parameter_end {
        replies.push((AnswerPart::ParameterEnd, control(outcome, ErrorCode::CONTROL_RESPONSE)));
    }
    let ready = match start.application_ready {
        Some(true) => ReceivedReply::Accepted,
        Some(false) | None => ReceivedReply::Silent("no ApplicationReady".into()),
    };
    replies.push((AnswerPart::ApplicationReady, ready));
    let word = |word: &str| ReceivedReply::Value(Value::Text(Arc::from(word)));
    // Only after an accepted Connect does a missing ModuleDiffBlock mean that all submodules are proper.
    let connected = start.connect == Some(ConnectOutcome::Accepted);
    for (index, submodule) in device.submodules.iter().enumerate().filter(|_| connected) {
        let state = match &start.module_diff {
            Some(diff) => module_state(diff, requested_slot(asked, submodule.slot), submodule.subslot),
            None => "proper",
        };
        replies.push((AnswerPart::ModuleDiff(index), word(state)));
    }
    replies.push((AnswerPart::Connection, word(if start.standing { "data" } else { "none" })));
    let whole = match (&start.connect, start.standing) {
        (_, true) => ReceivedReply::Accepted,
        (Some(outcome), false) if *outcome != ConnectOutcome::Accepted => connect(outcome),
        _ => ReceivedReply::Silent(start.failed.as_ref().map_or_else(String::new, ToString::to_string)),
    };
    replies.push((AnswerPart::Whole, whole));
    replies
}

/// The state of a submodule in a ModuleDiffBlock, as a word of the suite language.
fn module_state(diff: &ModuleDiffBlock, slot: u16, subslot: u16) -> &'static str {
    // A slot may be listed in more than one API, and proper submodules may be listed too.
    let in_slot = || diff.apis.iter().flat_map(|api| &api.modules).filter(|module| module.slot == slot);
    let lists_it = |module: &&ModuleDiff| module.submodules.iter().any(|submodule| submodule.subslot == subslot);
    let is_absent = |module: &&ModuleDiff| matches!(module.state, ModuleState::NO_MODULE | ModuleState::WRONG_MODULE);
    let found = in_slot().rfind(lists_it).or_else(|| in_slot().rfind(is_absent)).or_else(|| in_slot().next_back());
    let Some(module) = found else { return "proper" };
    match module.state {
        ModuleState::NO_MODULE => return "missing",
        ModuleState::WRONG_MODULE => return "wrong",
        _ => {}
    }
    match module.submodules.iter().find(|submodule| submodule.subslot == subslot) {
        Some(submodule) => submodule_state(submodule.state),
        None if module.state == ModuleState::SUBSTITUTE => "substitute",
        None => "proper",
    }
}

fn submodule_state(state: SubmoduleState) -> &'static str {
    let is_of_other = matches!(
        state.ar_info(),
        ArInfo::SUPERORDINATED_LOCKED | ArInfo::LOCKED_BY_CONTROLLER | ArInfo::LOCKED_BY_SUPERVISOR
    );
    match state.ident_info() {
        IdentInfo::OK | IdentInfo::SUBSTITUTE if state.format_indicator() && is_of_other => "locked",
        IdentInfo::OK => "proper",
        IdentInfo::SUBSTITUTE => "substitute",
        IdentInfo::NO_SUBMODULE => "missing",
        _ => "wrong",
    }
}
