//! Which field of which block a PNIO status points at.

use super::Finder;

/// The field of the block that `finder` names at which ErrorCode2 points.
pub(super) fn faulty_field(finder: Finder, detail: u8) -> Option<&'static str> {
    let (_, fields) = FIELDS.iter().find(|(known, _)| *known == finder)?;
    let place = usize::from(detail);
    let name = HEADER_FIELDS.get(place).or_else(|| fields.get(place.checked_sub(HEADER_FIELDS.len())?))?;
    (!name.is_empty()).then_some(name)
}

/// The fields of a block header, at which ErrorCode2 0 to 3 point.
const HEADER_FIELDS: [&str; 4] = ["BlockType", "BlockLength", "BlockVersionHigh", "BlockVersionLow"];

/// The fields of each block, at which ErrorCode2 from 4 on points; empty where the number has no field.
const FIELDS: [(Finder, &[&str]); 13] = [
    (
        Finder::AR_BLOCK,
        &[
            "ARType",
            "ARUUID",
            "SessionKey",
            "CMInitiatorMacAdd",
            "CMInitiatorObjectUUID",
            "ARProperties",
            "CMInitiatorActivityTimeoutFactor",
            "InitiatorUDPRTPort",
            "StationNameLength",
            "CMInitiatorStationName",
        ],
    ),
    (
        Finder::IOCR_BLOCK,
        &[
            "IOCRType",
            "IOCRReference",
            "LT",
            "IOCRProperties",
            "DataLength",
            "FrameID",
            "SendClockFactor",
            "ReductionRatio",
            "Phase",
            "",
            "FrameSendOffset",
            "WatchdogFactor",
            "DataHoldFactor",
            "IOCRTagHeader",
            "IOCRMulticastMACAdd",
            "NumberOfAPIs",
            "API",
            "NumberOfIODataObjects",
            "SlotNumber",
            "SubslotNumber",
            "IODataObjectFrameOffset",
            "NumberOfIOCS",
            "SlotNumber",
            "SubslotNumber",
            "IOCSFrameOffset",
        ],
    ),
    (
        Finder::EXPECTED_SUBMODULE_BLOCK,
        &[
            "NumberOfAPIs",
            "API",
            "SlotNumber",
            "ModuleIdentNumber",
            "ModuleProperties",
            "NumberOfSubmodules",
            "SubslotNumber",
            "SubmoduleIdentNumber",
            "SubmoduleProperties",
            "DataDescription",
            "SubmoduleDataLength",
            "LengthIOPS",
            "LengthIOCS",
        ],
    ),
    (
        Finder::ALARM_CR_BLOCK,
        &[
            "AlarmCRType",
            "LT",
            "AlarmCRProperties",
            "RTATimeoutFactor",
            "RTARetries",
            "LocalAlarmReference",
            "MaxAlarmDataLength",
            "AlarmCRTagHeaderHigh",
            "AlarmCRTagHeaderLow",
        ],
    ),
    (
        Finder::PRM_SERVER_BLOCK,
        &[
            "ParameterServerObjectUUID",
            "ParameterServerProperties",
            "CMInitiatorActivityTimeoutFactor",
            "StationNameLength",
            "ParameterServerStationName",
        ],
    ),
    (
        Finder::MCR_BLOCK,
        &[
            "IOCRReference",
            "AddressResolutionProperties",
            "MCITimeoutFactor",
            "StationNameLength",
            "ProviderStationName",
        ],
    ),
    (Finder::AR_RPC_BLOCK, &["InitiatorRPCServerPort"]),
    (
        Finder::RECORD,
        &[
            "SeqNumber",
            "ARUUID",
            "API",
            "SlotNumber",
            "SubslotNumber",
            "Padding",
            "Index",
            "RecordDataLength",
            "TargetARUUID",
        ],
    ),
    (Finder::CONTROL_BLOCK, CONTROL_FIELDS),
    (Finder::CONTROL_BLOCK_PLUG, CONTROL_FIELDS_PLUG),
    (Finder::READY_BLOCK, CONTROL_FIELDS),
    (Finder::READY_BLOCK_PLUG, CONTROL_FIELDS_PLUG),
    (Finder::RELEASE_BLOCK, CONTROL_FIELDS),
];

const CONTROL_FIELDS: &[&str] =
    &["Padding", "ARUUID", "SessionKey", "Padding", "ControlCommand", "ControlBlockProperties"];
const CONTROL_FIELDS_PLUG: &[&str] =
    &["Padding", "ARUUID", "SessionKey", "AlarmSequenceNumber", "ControlCommand", "ControlBlockProperties"];
