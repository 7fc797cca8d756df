//! The faulty fields of blocks, to which ErrorCode2 of a PNIO status refers.

use super::ErrorSource;

/// The field of the block `finder` to which ErrorCode2 `detail` refers.
pub(super) fn faulty_field(finder: ErrorSource, detail: u8) -> Option<&'static str> {
    let (_, fields) = FIELDS.iter().find(|(known, _)| *known == finder)?;
    let index = usize::from(detail);
    let name = HEADER_FIELDS.get(index).or_else(|| fields.get(index.checked_sub(HEADER_FIELDS.len())?))?;
    (!name.is_empty()).then_some(name)
}

/// The fields of a block header: ErrorCode2 0 to 3.
const HEADER_FIELDS: [&str; 4] = ["BlockType", "BlockLength", "BlockVersionHigh", "BlockVersionLow"];

/// The fields of each block: ErrorCode2 from 4 on; an empty name if the number has no field.
const FIELDS: [(ErrorSource, &[&str]); 13] = [
    (
        ErrorSource::AR_BLOCK,
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
        ErrorSource::IOCR_BLOCK,
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
        ErrorSource::EXPECTED_SUBMODULE_BLOCK,
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
        ErrorSource::ALARM_CR_BLOCK,
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
        ErrorSource::PRM_SERVER_BLOCK,
        &[
            "ParameterServerObjectUUID",
            "ParameterServerProperties",
            "CMInitiatorActivityTimeoutFactor",
            "StationNameLength",
            "ParameterServerStationName",
        ],
    ),
    (
        ErrorSource::MCR_BLOCK,
        &[
            "IOCRReference",
            "AddressResolutionProperties",
            "MCITimeoutFactor",
            "StationNameLength",
            "ProviderStationName",
        ],
    ),
    (ErrorSource::AR_RPC_BLOCK, &["InitiatorRPCServerPort"]),
    (
        ErrorSource::RECORD,
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
    (ErrorSource::CONTROL_BLOCK, CONTROL_FIELDS),
    (ErrorSource::CONTROL_BLOCK_PLUG, CONTROL_FIELDS_PLUG),
    (ErrorSource::READY_BLOCK, CONTROL_FIELDS),
    (ErrorSource::READY_BLOCK_PLUG, CONTROL_FIELDS_PLUG),
    (ErrorSource::RELEASE_BLOCK, CONTROL_FIELDS),
];

const CONTROL_FIELDS: &[&str] =
    &["Padding", "ARUUID", "SessionKey", "Padding", "ControlCommand", "ControlBlockProperties"];
const CONTROL_FIELDS_PLUG: &[&str] =
    &["Padding", "ARUUID", "SessionKey", "AlarmSequenceNumber", "ControlCommand", "ControlBlockProperties"];
