//! The blocks of Connect: builds the request and checks that the response matches it.
//!
//! This module must not know RPC, time or state.

use super::connection::{ArConfig, ConnectPart};
use super::layout::{FrameLayout, Layout, expected};
use super::request::ControllerSettings;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use wire::ethernet::{EtherType, Mac};
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{
    AlarmCrBlockReq, AlarmCrProperties, ArBlockReq, Connect, ConnectContent, IocrBlockReq, IocrProperties, IocrType,
};
use wire::profinet::blocks::module_diff::{
    ArInfo, IdentInfo, ModuleDiff, ModuleDiffBlock, ModuleState, SubmoduleState,
};
use wire::profinet::rpc::{ObjectUuid, Uuid};
use wire::profinet::rt::FrameId;

/// FrameSendOffset for "as soon as possible".
const SEND_OFFSET: u32 = 0xFFFF_FFFF;
/// InitiatorUDPRTPort; RT over UDP is not used.
const UDP_RT_PORT: u16 = 0x8892;

/// The identifiers of an AR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ArNames {
    pub(super) uuid: Uuid,
    pub(super) session_key: u16,
    /// LocalAlarmReference of the controller.
    pub(super) alarm_reference: u16,
}

/// What the device has agreed to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct AcceptedConnect {
    /// Frame IDs of input and output, and the alarm reference of the device; `None` in an AR without data.
    pub(super) data: Option<AcceptedData>,
    /// The ModuleDiffBlock of the response.
    pub(super) module_diff: Option<ModuleDiffBlock>,
}

/// What the device has agreed to for an AR with data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct AcceptedData {
    pub(super) frame_id_in: u16,
    pub(super) frame_id_out: u16,
    pub(super) alarm_reference: u16,
}

/// The blocks of the request.
pub(super) fn request(
    connection: &ArConfig,
    layout: &Layout,
    names: ArNames,
    settings: &ControllerSettings,
) -> Vec<u8> {
    let object = ObjectUuid { instance: 1, device_id: settings.device_id, vendor_id: settings.vendor_id };
    let ar = ArBlockReq {
        ar_type: connection.ar_type,
        ar_uuid: names.uuid,
        session_key: names.session_key,
        cm_initiator_mac_add: settings.mac,
        cm_initiator_object_uuid: object.into(),
        ar_properties: connection.ar_properties(),
        cm_initiator_activity_timeout_factor: connection.activity_timeout_factor,
        initiator_udp_rt_port: UDP_RT_PORT,
        cm_initiator_station_name: connection.station_name.clone().unwrap_or_else(|| settings.station_name.clone()),
    };
    let mut octets = Connect::of([ConnectContent::ArReq(ar)]).to_vec();
    for part in connection.order.iter().filter(|_| connection.has_data()) {
        let blocks = match part {
            ConnectPart::Inputs => {
                Vec::from([ConnectContent::IocrReq(iocr(connection, &layout.input, IocrType::INPUT))])
            }
            ConnectPart::Outputs => {
                Vec::from([ConnectContent::IocrReq(iocr(connection, &layout.output, IocrType::OUTPUT))])
            }
            ConnectPart::Submodules => {
                expected(&connection.submodules).into_iter().map(ConnectContent::ExpectedSubmodule).collect()
            }
            ConnectPart::Alarms => Vec::from([ConnectContent::AlarmCrReq(alarm_cr(connection, names))]),
            ConnectPart::Extra => {
                octets.extend(&connection.extra_blocks);
                continue;
            }
        };
        octets.extend(Connect::of(blocks).to_vec());
    }
    for (field, value) in &connection.replaced_fields {
        field.replace(&mut octets, *value);
    }
    octets
}

/// The Connect blocks of `connection` for a controller with these settings, with this AR UUID and session key 1. A start-up sends
/// the same blocks; this function needs no device, so that they can be compared with captured ones.
pub fn connect_blocks(connection: &ArConfig, settings: &ControllerSettings, uuid: Uuid) -> Vec<u8> {
    let names = ArNames { uuid, session_key: 1, alarm_reference: connection.alarm_reference.unwrap_or(1) };
    request(connection, &Layout::of(&connection.submodules), names, settings)
}

fn iocr(connection: &ArConfig, frame: &FrameLayout, kind: IocrType) -> IocrBlockReq {
    let (reference, id, phase) = match kind {
        IocrType::OUTPUT => (connection.iocr_references.1, connection.frame_id_out, connection.phase_out),
        _ => (connection.iocr_references.0, connection.frame_id_in, connection.phase_in),
    };
    IocrBlockReq {
        iocr_type: kind,
        iocr_reference: reference,
        lt: EtherType::PROFINET.0,
        iocr_properties: IocrProperties::from(connection.rt_class),
        data_length: frame.data_length as u16,
        frame_id: id,
        send_clock_factor: connection.send_clock_factor,
        reduction_ratio: connection.reduction_ratio,
        phase,
        sequence: 0,
        frame_send_offset: SEND_OFFSET,
        watchdog_factor: connection.watchdog_factor,
        data_hold_factor: connection.data_hold_factor,
        iocr_tag_header: connection.iocr_tag,
        iocr_multicast_mac_add: Mac::ZERO,
        apis: frame.apis(),
    }
}

fn alarm_cr(connection: &ArConfig, names: ArNames) -> AlarmCrBlockReq {
    AlarmCrBlockReq {
        alarm_cr_type: 1,
        lt: EtherType::PROFINET.0,
        alarm_cr_properties: AlarmCrProperties(0),
        rta_timeout_factor: connection.rta_timeout_factor,
        rta_retries: connection.rta_retries,
        local_alarm_reference: names.alarm_reference,
        max_alarm_data_length: connection.max_alarm_data_length,
        alarm_cr_tag_header_high: connection.alarm_tags.0,
        alarm_cr_tag_header_low: connection.alarm_tags.1,
    }
}

/// Compares the answer of the device at `device` with the request; the error is a sentence that says what does not match.
pub(super) fn accept(
    connection: &ArConfig,
    names: ArNames,
    device: Mac,
    blocks: &[u8],
) -> Result<AcceptedConnect, String> {
    let answer = Connect::parse(blocks).map_err(|error| error.to_string())?;
    let ar = answer.ar_res().ok_or("there is no ARBlockRes")?;
    if (ar.ar_uuid, ar.session_key) != (names.uuid, names.session_key) {
        return Err(format!("ARBlockRes is about AR {} in session {}", ar.ar_uuid, ar.session_key));
    }
    if ar.ar_type != connection.ar_type {
        return Err(format!("ARType is {:#06x}", ar.ar_type.0));
    }
    let data =
        if connection.has_data() { Some(data(connection, &answer, ar.cm_responder_mac_add, device)?) } else { None };
    let module_diff = match answer.block(BlockType::MODULE_DIFF) {
        Some(block) => Some(ModuleDiffBlock::parse(&block).map_err(|error| error.to_string())?),
        None => None,
    };
    Ok(AcceptedConnect { data, module_diff })
}

fn data(connection: &ArConfig, answer: &Connect, responder: Mac, device: Mac) -> Result<AcceptedData, String> {
    if responder != device {
        return Err(format!("CMResponderMacAdd is {responder}, the answer came from {device}"));
    }
    let frame_id = |kind: IocrType, reference: u16| {
        let word = kind.word().unwrap_or_default();
        let block = answer.iocr_responses().find(|block| (block.iocr_type, block.iocr_reference) == (kind, reference));
        let id = block.ok_or_else(|| format!("there is no IOCRBlockRes for the {word} connection"))?.frame_id;
        if FrameId(id).is_cyclic() { Ok(id) } else { Err(format!("FrameID of the {word} connection is {id:#06x}")) }
    };
    let alarms = answer.alarm_cr_res().ok_or("there is no AlarmCRBlockRes")?;
    let (input, output) = connection.iocr_references;
    Ok(AcceptedData {
        frame_id_in: frame_id(IocrType::INPUT, input)?,
        frame_id_out: frame_id(IocrType::OUTPUT, output)?,
        alarm_reference: alarms.local_alarm_reference,
    })
}

/// Whether, according to `diff`, the submodule cannot deliver data to this AR.
pub(super) fn is_improper(diff: &ModuleDiffBlock, slot: u16, subslot: u16) -> bool {
    let modules = || diff.apis.iter().flat_map(|api| &api.modules).filter(|module| module.slot == slot);
    let submodule =
        |module: &ModuleDiff| module.submodules.iter().any(|one| one.subslot == subslot && improper(one.state));
    modules().any(|module| match module.state {
        ModuleState::NO_MODULE | ModuleState::WRONG_MODULE => true,
        _ => submodule(module),
    })
}

/// Whether another controller, or a supervisor, owns the submodule.
pub(super) fn is_locked(diff: &ModuleDiffBlock, slot: u16, subslot: u16) -> bool {
    let modules = diff.apis.iter().flat_map(|api| &api.modules).filter(|module| module.slot == slot);
    let mut submodules = modules.flat_map(|module| &module.submodules).filter(|of| of.subslot == subslot);
    submodules.any(|of| {
        let owners = [ArInfo::SUPERORDINATED_LOCKED, ArInfo::LOCKED_BY_CONTROLLER, ArInfo::LOCKED_BY_SUPERVISOR];
        of.state.format_indicator() && owners.contains(&of.state.ar_info())
    })
}

fn improper(state: SubmoduleState) -> bool {
    if !state.format_indicator() {
        // The older coding: 4 is "application ready pending", 7 is "substitute"; all else is missing, wrong or locked.
        return !matches!(state.0, 4 | 7);
    }
    let plugged = matches!(state.ident_info(), IdentInfo::OK | IdentInfo::SUBSTITUTE);
    let own = matches!(state.ar_info(), ArInfo::OWN | ArInfo::APPLICATION_READY_PENDING);
    !(plugged && own)
}
