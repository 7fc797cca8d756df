//! What a code most likely means, and what to do next: reasons of an ERR-RTA, refused connections, calls and records, diagnoses.
//!
//! A cause here is only what the code itself says. What the frames show beside it is added by the check that reads them.

use crate::finding::CaptureFinding;
use wire::profinet::alarm::AlarmType;
use wire::profinet::diagnosis::ChannelErrorType as Channel;
use wire::profinet::status::{AbortReason as Abort, CmrpcError, ErrorSource, PnioStatus, RecordError};

/// Cause and next step, each one sentence or two.
pub(super) type Advice = (&'static str, &'static str);

/// What a pause means in which a station sent nothing.
pub(super) const PAUSED: Option<Advice> = Some((
    "Its stack stalled: its processor was busy, a virtual machine was stopped, or its send cycle was blocked.",
    "Look what the station did at this time: load, a download, a snapshot of its virtual machine.",
));

/// A finding with the advice for its code, if there is any.
pub(super) fn advised(finding: CaptureFinding, advice: Option<Advice>) -> CaptureFinding {
    match advice {
        Some((cause, next)) => finding.cause(cause).next(next),
        None => finding,
    }
}

/// What the reason of an ERR-RTA means.
pub(super) fn of_abort(reason: Abort) -> Option<Advice> {
    Some(match reason {
        Abort::SEQUENCE => (
            "The two sides disagree about the sequence numbers of their alarms: one of them restarted, or its stack has a bug.",
            "Read the alarms before this frame, and look whether one side restarted.",
        ),
        Abort::INSTANCE_CLOSED => (
            "The sender had already ended this connection and received another frame of it.",
            "Look for the first ERR-RTA or Release before it.",
        ),
        Abort::OUT_OF_MEMORY => (
            "The sender ran out of memory for this connection.",
            "Count the connections of this station, and restart it; if it happens again, report it to its maker.",
        ),
        Abort::ADD_PROVIDER_OR_CONSUMER => (
            "The sender cannot provide or receive cyclic frames of this cycle, length or number.",
            "Use a longer update time or fewer connections, and compare with the limits in the GSDML.",
        ),
        Abort::CONSUMER_TIMEOUT => (
            "The sender of the ERR-RTA accepted no cyclic frame of the other side for its watchdog time.",
            "Compare the last cyclic frames of the other side with this time, and read the port statistics of the switches between.",
        ),
        Abort::CMI_TIMEOUT => (
            "The next step of the start-up did not arrive within the time that the controller had announced.",
            "Read the last step of the start-up, and what the side that owed the next one did instead.",
        ),
        Abort::ALARM_OPEN => (
            "The channel for alarms could not be opened.",
            "Compare the AlarmCR of the Connect with what the GSDML allows.",
        ),
        Abort::ALARM_SEND => (
            "The other side acknowledged an alarm too late or never.",
            "Look at the alarm before this frame and its repetitions, and at the load of its receiver.",
        ),
        Abort::ALARM_ACK_SEND => (
            "The acknowledgement of an alarm was not confirmed by the sender of the alarm.",
            "Look at the acknowledgement before this frame and its repetitions.",
        ),
        Abort::ALARM_DATA_TOO_LONG => (
            "An alarm is longer than the Connect allows.",
            "Compare the length of the alarm before this frame with MaxAlarmDataLength in the Connect, and report it to the maker.",
        ),
        Abort::ALARM_INDICATION => (
            "An alarm arrived that its receiver cannot read.",
            "Read the alarm before this frame, and report it to the maker of its sender.",
        ),
        Abort::RPC_CLIENT_CALL => (
            "A call of the sender was refused or not answered; on a device that is its ApplicationReady.",
            "Read the last calls of this connection and their answers.",
        ),
        Abort::ABORT_REQUEST => (
            "The application of the sender ended the connection on purpose: a download, a stop, or a program.",
            "Read its diagnostic buffer or log at this time.",
        ),
        Abort::RE_RUN => (
            "The controller connected again while the device still had the old connection.",
            "Look why the controller started again: a restart, or a loss of the connection on its side only.",
        ),
        Abort::RELEASE_RECEIVED => (
            "The device ended the connection because of a Release.",
            "Nothing, if a Release of the controller is before it; otherwise look who sent it.",
        ),
        Abort::DEVICE_DEACTIVATED => (
            "The device was deactivated by the program of the controller.",
            "Look in the program for the call that deactivates it.",
        ),
        Abort::AR_REMOVED => {
            ("The station removed the connection: its configuration changed.", "Look for a download at this time.")
        }
        Abort::PROTOCOL_VIOLATION => (
            "The other side broke the protocol in the eyes of the sender.",
            "Read the last frames of the other side before this one.",
        ),
        Abort::NAME_RESOLUTION => (
            "The controller found no station with the name, or several.",
            "Search the name by DCP: exactly one station must answer.",
        ),
        Abort::RPC_BIND => (
            "The RPC endpoint of the other side could not be reached.",
            "Check its IP address and that its UDP port 34964 answers.",
        ),
        Abort::RPC_CONNECT | Abort::RPC_READ | Abort::RPC_WRITE | Abort::RPC_CONTROL => (
            "A call of the controller failed: it was refused or not answered.",
            "Read the last call of this connection and its answer.",
        ),
        Abort::FORBIDDEN_PULL_OR_PLUG => (
            "A module was pulled or plugged during the start-up.",
            "Let the start-up end before modules are changed, and check the contacts of the modules.",
        ),
        Abort::AP_REMOVED => {
            ("The application of the station was removed or restarted.", "Look for a download or restart at this time.")
        }
        Abort::LINK_DOWN => (
            "The port of the sender lost its link.",
            "Check cable and connector of the port, and the power of the other end.",
        ),
        Abort::MULTICAST_MAC => (
            "A multicast address could not be registered.",
            "Compare the multicast connections with the limits of the station.",
        ),
        Abort::NOT_SYNCHRONIZED => {
            ("The station is not synchronised.", "Check the sync master and that the ports between are synchronised.")
        }
        Abort::WRONG_TOPOLOGY => {
            ("The cabling is not the configured one.", "Compare the neighbours by LLDP with the configured topology.")
        }
        Abort::STATION_NAME_CHANGED => {
            ("The station was given another name.", "Look for the DCP Set before this frame and its sender.")
        }
        Abort::RESET_TO_FACTORY => (
            "The station was reset.",
            "Look for the DCP Set before this frame and its sender; it may also have been reset by hand.",
        ),
        Abort::COMPANION_SUBMODULE => (
            "Interface or ports belong to another connection.",
            "Look which other controller has the interface and ports configured.",
        ),
        Abort::NO_IR_DATA => (
            "The planned times of isochronous real time were not written.",
            "Check that the planning was downloaded to the controller.",
        ),
        Abort::PDEV => {
            ("The interface or a port of the station has a fault.", "Read the diagnosis of its interface and ports.")
        }
        Abort::PORT_SPEED => (
            "No port has the required speed and duplex mode.",
            "Check that both ends of the link negotiate 100 Mbit/s full duplex.",
        ),
        Abort::IP_SUITE_CHANGED => (
            "The station was given another IP address.",
            "Look for the DCP Set before this frame and its sender, and for a DHCP server.",
        ),
        Abort::REDUNDANCY_HOLD_TIME
        | Abort::REDUNDANCY_PDEV
        | Abort::REDUNDANCY_INTERFACES
        | Abort::REDUNDANCY_MTOT
        | Abort::REDUNDANCY_PROTOCOL => (
            "The redundant connection failed.",
            "Look at the other connection of the pair at this time, and at the switch-over.",
        ),
        Abort::APPLICATION_READY_TIMEOUT => (
            "The device did not report that its application is ready within the time of the controller.",
            "Compare the start-up time of the device in its manual with the time that it had; look what it did after the end of parameters.",
        ),
        Abort::PORT_WITHOUT_CONTAINER => (
            "A port was plugged without the module that carries it.",
            "Compare the modules of the interface with the configuration.",
        ),
        Abort::NME_CONFIGURATION => {
            ("The network management has no valid configuration.", "Check the configuration of the network management.")
        }
        Abort::USER => {
            ("A reason of the vendor; the bytes after it say more.", "Look up the code in the manual of the sender.")
        }
        _ => return None,
    })
}

/// What the refusal of a Connect or a Control means; `for_access`: the connection was for access to records only.
pub(super) fn of_refusal(status: &PnioStatus, for_access: bool) -> Option<Advice> {
    if let Some(error) = status.cmrpc_error() {
        return of_cmrpc(error);
    }
    if let Some(error) = status.record_error() {
        return of_record(error);
    }
    Some(match status.error_source()? {
        ErrorSource::ALARM_CR_BLOCK if for_access => (
            "The device grants access to its records only with an alarm channel, and this request has none or another.",
            "Nothing for the data exchange. Ask the maker whether the device supports access without an alarm channel.",
        ),
        ErrorSource::AR_BLOCK => (
            "The device does not support this kind of connection or one of its properties.",
            "Compare the field that it names with the GSDML: kind of connection, start-up mode, MAC address.",
        ),
        ErrorSource::IOCR_BLOCK => (
            "The device does not support the cycle, length or kind of the cyclic frames.",
            "Compare the field that it names with the GSDML: send clock, reduction ratio, data length, RT class, FrameID.",
        ),
        ErrorSource::EXPECTED_SUBMODULE_BLOCK => (
            "The configured modules, or the lengths of their data, are not possible on this device.",
            "Compare slots, module idents and data lengths with the GSDML of exactly this version.",
        ),
        ErrorSource::ALARM_CR_BLOCK => (
            "The alarm channel in the request does not fit the device.",
            "Compare the field that it names: timeout, retries, length of alarms.",
        ),
        ErrorSource::PRM_SERVER_BLOCK
        | ErrorSource::MCR_BLOCK
        | ErrorSource::AR_RPC_BLOCK
        | ErrorSource::IR_INFO_BLOCK => (
            "The device does not support this optional part of the request, or a value in it.",
            "Switch this function off in the configuration, or compare it with the GSDML.",
        ),
        ErrorSource::ALARM_ACK => (
            "The controller does not take this alarm: it does not know the module, the type or the contents.",
            "Compare slot, type and contents of the alarm with the configuration and the GSDML.",
        ),
        ErrorSource::CONTROL_BLOCK | ErrorSource::READY_BLOCK => (
            "The step came at a time at which the other side does not expect it, or names another connection.",
            "Read the steps before it: does the other side have this connection?",
        ),
        _ => return None,
    })
}

fn of_cmrpc(error: CmrpcError) -> Option<Advice> {
    Some(match error {
        CmrpcError::ARGS_LENGTH => (
            "The length of the request does not match its blocks.",
            "Report it to the maker of the sender, and attach this capture.",
        ),
        CmrpcError::UNKNOWN_BLOCKS => (
            "The request has blocks that the device does not know.",
            "Use a GSDML version that fits the firmware, or switch off functions that the device does not have.",
        ),
        CmrpcError::IOCR_MISSING | CmrpcError::ALARM_CR_COUNT => (
            "The request lacks a part that the device needs.",
            "Compare the blocks of the Connect with those of a controller with which the device works.",
        ),
        CmrpcError::OUT_OF_AR_RESOURCES => (
            "The device has as many connections as it can hold.",
            "Look which other controllers are connected, or whether it still holds a connection that was not released.",
        ),
        CmrpcError::OUT_OF_CR_RESOURCES | CmrpcError::OUT_OF_MEMORY => {
            ("The device has no resources left for this connection.", "Count its connections, and restart it.")
        }
        CmrpcError::AR_UUID_UNKNOWN => (
            "The device does not have this connection: it ended, or the device restarted.",
            "Look how the connection ended, and whether the device restarted.",
        ),
        CmrpcError::STATE_CONFLICT => (
            "The request came in a state in which the device does not take it.",
            "Read the steps of the connection before it.",
        ),
        CmrpcError::PDEV_ALREADY_OWNED => (
            "Interface and ports of the device already belong to another controller.",
            "Configure them in one controller only.",
        ),
        _ => return None,
    })
}

/// What the refusal of a record means.
pub(super) fn of_record(error: RecordError) -> Option<Advice> {
    Some(match error {
        RecordError::INVALID_INDEX => (
            "The submodule has no record with this index.",
            "Compare the index with the GSDML and the manual; a tool that reads optional records meets this often.",
        ),
        RecordError::WRITE_LENGTH_ERROR => (
            "The record has another length than the device expects.",
            "Compare the length with the GSDML of exactly this firmware.",
        ),
        RecordError::INVALID_SLOT => (
            "The device has no such slot or subslot.",
            "Compare the modules of the configuration with those of the device.",
        ),
        RecordError::INVALID_AREA => {
            ("The device has no such API.", "Compare the API with the GSDML; a profile needs its own API.")
        }
        RecordError::STATE_CONFLICT => (
            "The device does not take the record in its present state.",
            "Read what the connection was doing: parameters belong between Connect and the end of parameters.",
        ),
        RecordError::ACCESS_DENIED => (
            "The record may not be written or read by this connection.",
            "Look whether another controller owns the submodule, or whether the device is write-protected.",
        ),
        RecordError::INVALID_RANGE | RecordError::INVALID_PARAMETER | RecordError::INVALID_TYPE => {
            ("A value in the record is not allowed.", "Compare the values with the manual of the device.")
        }
        RecordError::BUSY | RecordError::RESOURCE_BUSY | RecordError::WRITE_CONSTRAIN_CONFLICT => {
            ("The device was busy with another request.", "Look whether the controller repeated it later with success.")
        }
        RecordError::MODULE_FAILURE => ("The module has failed.", "Read the diagnosis of this slot."),
        RecordError::FEATURE_NOT_SUPPORTED => {
            ("The device does not have this function.", "Switch the function off in the configuration.")
        }
        _ => return None,
    })
}

/// What an alarm reports that needs no channel to be a fault, with cause and next step.
pub(super) fn of_alarm(alarm: AlarmType) -> Option<(&'static str, &'static str, &'static str)> {
    Some(match alarm {
        AlarmType::PULL | AlarmType::PULL_MODULE => (
            "module pulled",
            "A module was pulled, or lost contact.",
            "Check that the module of this slot is plugged and has power.",
        ),
        AlarmType::PLUG_WRONG => (
            "another module than the configured one was plugged",
            "The module that was plugged is of another type or version.",
            "Compare the module with the configuration of this slot.",
        ),
        AlarmType::CONTROLLED_BY_SUPERVISOR => (
            "a supervisor took control of the submodule",
            "An engineering tool or another controller took this submodule.",
            "Look which station has a supervisor connection to the device, and end it.",
        ),
        AlarmType::MULTICAST_MISMATCH => (
            "multicast communication does not work",
            "The provider of a multicast connection is missing or configured otherwise.",
            "Check the provider of the multicast connection.",
        ),
        AlarmType::ISOCHRONOUS_PROBLEM => (
            "isochronous operation has a problem",
            "The application missed its cycle, or the device is not synchronised.",
            "Check the send clock, the times of the isochronous application, and the sync master.",
        ),
        AlarmType::NETWORK_PROBLEM | AlarmType::FRAME_PACKING_PROBLEM => (
            "a network component has a problem",
            "A switch or a line between the stations is not as planned.",
            "Read the diagnosis of the ports on the path.",
        ),
        AlarmType::MEDIA_REDUNDANCY_PROBLEM => (
            "media redundancy has a problem",
            "The ring is open, or one of its paths fails.",
            "Look at the ring manager and the ports of the ring.",
        ),
        AlarmType::MULTIPLE_INTERFACE_PROBLEM => (
            "several interfaces do not match each other",
            "Two interfaces of the device have settings that exclude each other.",
            "Compare the names and addresses of its interfaces.",
        ),
        _ => return None,
    })
}

/// What a diagnosis of a channel means.
pub(super) fn of_channel(error: u16) -> Option<Advice> {
    Some(match Channel(error) {
        Channel::SHORT_CIRCUIT | Channel::LINE_BREAK | Channel::GROUND_FAULT => (
            "A wire of the channel is broken or has contact with another one.",
            "Check connector and wires of this channel.",
        ),
        Channel::UNDERVOLTAGE | Channel::OVERVOLTAGE | Channel::POWER_SUPPLY_FAULT | Channel::FUSE_BLOWN => (
            "The supply of the device or of the channel is not as it should be.",
            "Measure the supply voltage at the device under load, and check its fuse.",
        ),
        Channel::OVERLOAD => ("The load at the channel is too high.", "Measure the current of what is connected."),
        Channel::OVERTEMPERATURE => ("The device is too hot.", "Check its ambient temperature and ventilation."),
        Channel::UPPER_LIMIT_EXCEEDED | Channel::LOWER_LIMIT_EXCEEDED | Channel::THRESHOLD_WARNING => {
            ("A value is outside its limits.", "Compare the value with the configured limits.")
        }
        Channel::PARAMETER_MISSING | Channel::PARAMETER_FAULT => (
            "A parameter was not written, or has a value that the device does not take.",
            "Read the records that were written in the start-up, and compare them with the manual.",
        ),
        Channel::COMMUNICATION_FAULT => (
            "Communication inside the device has failed.",
            "Look up the vendor's details in its manual, and replace the module.",
        ),
        Channel::REFERENCE_POINT_LOST => {
            ("The device no longer knows its reference point.", "Reference it again, and look for a loss of power.")
        }
        Channel::DATA_TRANSMISSION_IMPOSSIBLE => (
            "The port has no link, or its link cannot carry data.",
            "Check the cable at this port and the power of its neighbour; an unused port should be switched off in the configuration.",
        ),
        Channel::REMOTE_MISMATCH => (
            "The neighbour at this port is not the configured one.",
            "Compare the cabling with the configured topology.",
        ),
        Channel::SYNC_MISMATCH | Channel::ISOCHRONOUS_MISMATCH => {
            ("The device does not synchronise as configured.", "Check the sync master and the configured send clock.")
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_and_every_refusal_of_connections_has_its_own_advice() {
        let mut causes = Vec::new();
        for &(reason, ..) in Abort::TABLE {
            let (cause, next) = of_abort(reason).unwrap_or_else(|| panic!("{}", reason.0));
            assert!(cause.ends_with('.') && next.ends_with('.'));
            causes.push(cause);
        }
        causes.dedup();
        assert!(causes.len() > 35, "{}", causes.len());
        for error in [CmrpcError::OUT_OF_AR_RESOURCES, CmrpcError::AR_UUID_UNKNOWN, CmrpcError::STATE_CONFLICT] {
            assert!(of_cmrpc(error).is_some());
        }
    }
}
