//! Checks every block and every field of a Connect and gives the status for a refusal.
//!
//! ErrorCode1 of a status names the block. ErrorCode2 is the number of the field in the block, the header fields
//! included (IEC 61158-6-10). [`super::layout`] checks the layout of the frames.

use super::super::hooks::{AttachedStackHooks, StackCheck};
use super::super::plugged::{ExpectedSubmoduleData, PluggedConfiguration};
use super::{cmrpc, layout};
use alloc::vec::Vec;
use wire::octets::ByteReader;
use wire::profinet::blocks::connect::{
    AlarmCrBlockReq, ArBlockReq, ArProperties, ArType, ConnectBlock, ConnectContent, ExpectedSubmoduleBlockReq,
    IocrBlockReq, IocrType, RtClass, SubmoduleProperties, SubmoduleType,
};
use wire::profinet::blocks::{BlockType, RawBlock};
use wire::profinet::dcp::station_name;
use wire::profinet::rpc::ObjectUuid;
use wire::profinet::status::{CmrpcError, ErrorCode, ErrorSource, PnioStatus};

/// A Connect that passed all checks.
#[derive(Debug)]
pub(super) struct ConnectPlan {
    pub ar: ArBlockReq,
    /// Cyclic data and alarms; `None` for a connection for records only.
    pub exchange: Option<ExchangePlan>,
    /// The UDP port of the initiator for calls from the device, if the request contains it.
    pub rpc_port: Option<u16>,
}

/// Cyclic data and alarms of a requested connection.
#[derive(Debug)]
pub(super) struct ExchangePlan {
    /// The IOCRs in the order of the request: one for inputs, one for outputs.
    pub iocrs: Vec<IocrBlockReq>,
    pub alarm_cr: AlarmCrBlockReq,
    pub expected: Vec<ExpectedSubmoduleData>,
}

pub(super) const fn fault(finder: ErrorSource, field: u8) -> PnioStatus {
    PnioStatus::found(ErrorCode::CONNECT_RESPONSE, finder, field)
}

const fn refusal(error: CmrpcError) -> PnioStatus {
    cmrpc(ErrorCode::CONNECT_RESPONSE, error)
}

/// Returns a fault for the first field (by number) whose demand does not hold.
pub(super) fn demand<const N: usize>(finder: ErrorSource, demands: [(u8, bool); N]) -> Result<(), PnioStatus> {
    match demands.into_iter().find(|(_, holds)| !holds) {
        Some((field, _)) => Err(fault(finder, field)),
        None => Ok(()),
    }
}

/// The ErrorCode1 of a block; `None` for an unknown block.
fn finder(kind: BlockType) -> Option<ErrorSource> {
    Some(match kind {
        BlockType::AR_REQ => ErrorSource::AR_BLOCK,
        BlockType::IOCR_REQ => ErrorSource::IOCR_BLOCK,
        BlockType::EXPECTED_SUBMODULE => ErrorSource::EXPECTED_SUBMODULE_BLOCK,
        BlockType::ALARM_CR_REQ => ErrorSource::ALARM_CR_BLOCK,
        BlockType::AR_RPC_REQ => ErrorSource::AR_RPC_BLOCK,
        _ => return None,
    })
}

/// Blocks that controllers send to every device and that this device ignores: fast start-up (ARFSUBlock) and its
/// parameters (FSParameterBlock, 0x0601), which the device does not support. IRInfoBlock is not part of the list: a
/// controller that sends it requires RT class 3.
const PASSED_OVER: [BlockType; 2] = [BlockType::AR_FSU, BlockType(0x0601)];

const BLOCK_LENGTH: u8 = 1;
const VERSION_HIGH: u8 = 2;
const VERSION_LOW: u8 = 3;

fn read_blocks(octets: &[u8], hooks: &AttachedStackHooks) -> Result<Vec<ConnectContent>, PnioStatus> {
    let mut reader = ByteReader::new("Connect", octets);
    let mut contents = Vec::new();
    while !reader.is_empty() {
        let mut head = reader;
        let unknown = refusal(CmrpcError::UNKNOWN_BLOCKS);
        let kind = BlockType(head.u16().map_err(|_| unknown)?);
        if hooks.check(StackCheck::IgnoredBlock(kind), PASSED_OVER.contains(&kind)) {
            RawBlock::read(&mut reader).map_err(|_| unknown)?;
            continue;
        }
        let finder = finder(kind).ok_or(unknown)?;
        let raw = RawBlock::read(&mut { reader }).map_err(|_| fault(finder, BLOCK_LENGTH))?;
        let version = |field, is_own| (field, hooks.check(StackCheck::BlockVersion(kind), is_own));
        let (high, low) = (raw.header.version_high, raw.header.version_low);
        demand(finder, [version(VERSION_HIGH, high == 1), version(VERSION_LOW, low == 0)])?;
        let block = ConnectBlock::read(&mut reader).map_err(|_| fault(finder, BLOCK_LENGTH))?;
        demand(finder, [(BLOCK_LENGTH, block.rest.is_empty())])?;
        contents.push(block.content);
    }
    Ok(contents)
}

/// Checks a complete Connect.
pub(super) fn connect(
    octets: &[u8],
    plugged: &PluggedConfiguration,
    hooks: &AttachedStackHooks,
) -> Result<ConnectPlan, PnioStatus> {
    let mut ars = Vec::new();
    let (mut iocrs, mut alarm_crs, mut expected_blocks) = (Vec::new(), Vec::new(), Vec::new());
    let mut rpc_port = None;
    for content in read_blocks(octets, hooks)? {
        match content {
            ConnectContent::ArReq(block) => ars.push(block),
            ConnectContent::IocrReq(block) => iocrs.push(block),
            ConnectContent::AlarmCrReq(block) => alarm_crs.push(block),
            ConnectContent::ExpectedSubmodule(block) => expected_blocks.push(block),
            ConnectContent::ArRpcReq(block) => rpc_port = Some(block.rpc_server_port),
            _ => return Err(refusal(CmrpcError::UNKNOWN_BLOCKS)),
        }
    }
    let ar = match (ars.pop(), ars.is_empty()) {
        (Some(ar), true) => ar,
        (Some(_), false) | (None, _) => return Err(refusal(CmrpcError::UNKNOWN_BLOCKS)),
    };
    check_ar(&ar, hooks)?;
    if ar.ar_properties.has(ArProperties::DEVICE_ACCESS) {
        let has_more = !(iocrs.is_empty() && alarm_crs.is_empty() && expected_blocks.is_empty());
        let plan = ConnectPlan { ar, exchange: None, rpc_port };
        return if has_more { Err(refusal(CmrpcError::UNKNOWN_BLOCKS)) } else { Ok(plan) };
    }
    for (at, iocr) in iocrs.iter().enumerate() {
        check_iocr(iocr, hooks)?;
        let is_unique = iocrs[..at].iter().all(|other| other.iocr_reference != iocr.iocr_reference);
        let is_unique = hooks.check(StackCheck::IocrField(iocr, IOCR_REFERENCE), is_unique);
        demand(ErrorSource::IOCR_BLOCK, [(IOCR_REFERENCE, is_unique)])?;
    }
    for kind in [IocrType::INPUT, IocrType::OUTPUT] {
        match iocrs.iter().filter(|iocr| iocr.iocr_type == kind).count() {
            0 => return Err(refusal(CmrpcError::IOCR_MISSING)),
            1 => {}
            _ => return Err(refusal(CmrpcError::OUT_OF_CR_RESOURCES)),
        }
    }
    let mut expected = Vec::new();
    for block in &expected_blocks {
        check_expected(block, plugged, hooks, &mut expected)?;
    }
    if expected.is_empty() {
        return Err(fault(ErrorSource::EXPECTED_SUBMODULE_BLOCK, NUMBER_OF_APIS));
    }
    for iocr in &iocrs {
        layout::check(iocr, &expected)?;
    }
    let alarm_cr = match alarm_crs[..] {
        [alarm_cr] => alarm_cr,
        _ => return Err(refusal(CmrpcError::ALARM_CR_COUNT)),
    };
    check_alarm_cr(&alarm_cr, hooks)?;
    Ok(ConnectPlan { ar, exchange: Some(ExchangePlan { iocrs, alarm_cr, expected }), rpc_port })
}

fn check_ar(ar: &ArBlockReq, hooks: &AttachedStackHooks) -> Result<(), PnioStatus> {
    let properties = ar.ar_properties;
    let access = properties.has(ArProperties::DEVICE_ACCESS);
    let initiator = ar.cm_initiator_mac_add;
    let properties_hold = properties.state() == 1
        && properties.reserved() == 0
        && properties.companion_ar() == 0
        && (access || properties.has(ArProperties::PARAMETRIZATION_BY_INITIATOR))
        && (!access || ar.ar_type == ArType::IOSAR);
    let name_length = ar.cm_initiator_station_name.len();
    demand(
        ErrorSource::AR_BLOCK,
        [
            (4, matches!(ar.ar_type, ArType::IOCAR_SINGLE | ArType::IOSAR)),
            (5, !ar.ar_uuid.is_nil()),
            (7, !initiator.is_group() && initiator != wire::ethernet::Mac::ZERO),
            (8, ObjectUuid::of(ar.cm_initiator_object_uuid).is_some()),
            (9, properties_hold),
            (10, (1..=1000).contains(&ar.cm_initiator_activity_timeout_factor)),
            (11, ar.initiator_udp_rt_port >= 0x0400),
            (12, (1..=240).contains(&name_length)),
            (13, station_name::check(&ar.cm_initiator_station_name).is_ok()),
        ]
        .map(|(field, holds)| (field, hooks.check(StackCheck::ArField(ar, field), holds))),
    )
}

const IOCR_REFERENCE: u8 = 5;

/// Longest data hold time and watchdog time in units of 31.25 us: 1.92 s.
const LONGEST_HOLD: u32 = 61_440;

fn check_iocr(iocr: &IocrBlockReq, hooks: &AttachedStackHooks) -> Result<(), PnioStatus> {
    let class = iocr.iocr_properties.rt_class();
    let frame_ids = match class {
        RtClass::RT_CLASS_1 => 0xC000..=0xF7FF,
        RtClass::RT_CLASS_3 => 0x0100..=0x6FFF,
        _ => 0x8000..=0xBBFF,
    };
    let leaves_frame_id = iocr.iocr_type == IocrType::OUTPUT && iocr.frame_id == 0xFFFF;
    let (clock, reduction) = (iocr.send_clock_factor, iocr.reduction_ratio);
    let longest = |factor: u16| u32::from(factor) * u32::from(clock) * u32::from(reduction) <= LONGEST_HOLD;
    let cycle_nanos = u32::from(clock) * 31_250;
    demand(
        ErrorSource::IOCR_BLOCK,
        [
            (4, matches!(iocr.iocr_type, IocrType::INPUT | IocrType::OUTPUT)),
            (6, iocr.lt == 0x8892),
            (7, matches!(class, RtClass::RT_CLASS_1 | RtClass::RT_CLASS_2) && iocr.iocr_properties.0 >> 4 == 0),
            (8, (40..=1440).contains(&iocr.data_length)),
            (9, frame_ids.contains(&iocr.frame_id) || leaves_frame_id),
            (10, matches!(clock, 8 | 16 | 32 | 64 | 128)),
            (11, reduction.is_power_of_two() && reduction <= 512),
            (12, (1..=reduction).contains(&iocr.phase)),
            (14, iocr.frame_send_offset == u32::MAX || iocr.frame_send_offset < cycle_nanos),
            (15, (1..=0x1E00).contains(&iocr.watchdog_factor) && longest(iocr.watchdog_factor)),
            (16, (1..=0x1E00).contains(&iocr.data_hold_factor) && longest(iocr.data_hold_factor)),
            (17, iocr.iocr_tag_header >> 12 == 0xC),
        ]
        .map(|(field, holds)| (field, hooks.check(StackCheck::IocrField(iocr, field), holds))),
    )
}

fn check_alarm_cr(alarm_cr: &AlarmCrBlockReq, hooks: &AttachedStackHooks) -> Result<(), PnioStatus> {
    demand(
        ErrorSource::ALARM_CR_BLOCK,
        [
            (4, alarm_cr.alarm_cr_type == 1),
            (5, alarm_cr.lt == 0x8892),
            (6, alarm_cr.alarm_cr_properties.0 >> 1 == 0),
            (7, (1..=100).contains(&alarm_cr.rta_timeout_factor)),
            (8, (3..=15).contains(&alarm_cr.rta_retries)),
            (10, (200..=1432).contains(&alarm_cr.max_alarm_data_length)),
            (11, alarm_cr.alarm_cr_tag_header_high >> 12 == 0xC),
            (12, alarm_cr.alarm_cr_tag_header_low >> 12 == 0xA),
        ]
        .map(|(field, holds)| (field, hooks.check(StackCheck::AlarmCrField(alarm_cr, field), holds))),
    )
}

const NUMBER_OF_APIS: u8 = 4;

/// The supported bits: direction of the data, and DiscardIOXS for a submodule without data.
const KNOWN_PROPERTIES: u16 = 0x3 | SubmoduleProperties::DISCARD_IOXS.0;

fn check_expected(
    block: &ExpectedSubmoduleBlockReq,
    plugged: &PluggedConfiguration,
    hooks: &AttachedStackHooks,
    all: &mut Vec<ExpectedSubmoduleData>,
) -> Result<(), PnioStatus> {
    let finder = ErrorSource::EXPECTED_SUBMODULE_BLOCK;
    let checked = |(field, holds)| (field, hooks.check(StackCheck::ExpectedField(field), holds));
    demand(finder, [(NUMBER_OF_APIS, !block.modules.is_empty())])?;
    for module in &block.modules {
        demand(
            finder,
            [
                (7, module.module_ident_number != 0),
                (8, module.module_properties == 0),
                (9, !module.submodules.is_empty()),
            ]
            .map(checked),
        )?;
        for (submodule, expected) in module.submodules.iter().zip(ExpectedSubmoduleData::of(module)) {
            let descriptions = &submodule.data_descriptions;
            let is_new = all.iter().all(|other| other.place != expected.place);
            let real = plugged.fitting(&expected);
            let inputs_fit = real.is_none_or(|plug| plug.input_octets == expected.input_octets);
            let inputs_fit = hooks.check(StackCheck::InputLength(expected.input_octets), inputs_fit);
            let outputs_fit = real.is_none_or(|plug| plug.output_octets == expected.output_octets);
            let outputs_fit = hooks.check(StackCheck::OutputLength(expected.output_octets), outputs_fit);
            // Inputs and outputs may come in either order.
            let count = |direction| descriptions.iter().filter(|one| one.data_description == direction).count();
            let counts = (count(1), count(2), descriptions.len());
            let directions_hold = match expected.kind {
                SubmoduleType::INPUT_OUTPUT => counts == (1, 1, 2),
                SubmoduleType::OUTPUT => counts == (0, 1, 1),
                _ => counts == (1, 0, 1),
            };
            let properties = submodule.submodule_properties;
            let has_data = properties.submodule_type() != SubmoduleType::NO_IO;
            let status_holds = !(has_data && properties.has(SubmoduleProperties::DISCARD_IOXS));
            demand(
                finder,
                [
                    (10, is_new),
                    (12, properties.0 & !KNOWN_PROPERTIES == 0 && status_holds),
                    (13, directions_hold),
                    (14, inputs_fit && outputs_fit),
                    (15, descriptions.iter().all(|one| one.length_iops == 1)),
                    (16, descriptions.iter().all(|one| one.length_iocs == 1)),
                ]
                .map(checked),
            )?;
            all.push(expected);
        }
    }
    Ok(())
}
