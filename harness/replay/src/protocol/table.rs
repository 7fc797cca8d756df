//! The protocol checks: id, sentence, likely cause, next step. Each finding of this module belongs to one of them.

use crate::finding::{CaptureBlame, CaptureFinding, FindingSeverity};

/// A protocol check; it needs no manual.
#[derive(Debug, PartialEq, Eq)]
pub struct ProtocolCheck {
    /// The id of the check and of its findings: `PN-...` on PROFINET, `DP-...` on PROFIBUS.
    pub id: &'static str,
    /// What is wrong, in one sentence.
    pub sentence: &'static str,
    /// The most likely cause.
    pub cause: &'static str,
    /// What to do next.
    pub next: &'static str,
}

impl ProtocolCheck {
    /// A finding of this check in packet `frame`, with its likely cause and next step.
    pub(super) fn finding(
        &self,
        severity: FindingSeverity,
        blame: CaptureBlame,
        frame: u64,
        text: impl Into<String>,
    ) -> CaptureFinding {
        CaptureFinding::protocol(self.id, severity, blame, frame, text).cause(self.cause).next(self.next)
    }

    /// The check with this id, in upper or lower case.
    pub fn by_id(id: &str) -> Option<&'static ProtocolCheck> {
        CHECKS.iter().copied().find(|check| check.id.eq_ignore_ascii_case(id))
    }
}

macro_rules! checks {
    ($($NAME:ident $id:literal $sentence:literal $cause:literal $next:literal;)+) => {
        $(
            #[doc = $sentence]
            pub(crate) const $NAME: &ProtocolCheck = &ProtocolCheck { id: $id, sentence: $sentence, cause: $cause, next: $next };
        )+

        /// All checks, those of PROFINET first.
        pub const CHECKS: &[&ProtocolCheck] = &[$($NAME),+];
    };
}

checks! {
    START_REFUSED "PN-START-REFUSED" "A device refused a connection."
        "The configuration of the controller does not fit the device, or the device has no connection left."
        "Compare the configured modules with those of the device; check whether another controller is connected to it.";
    START_UNANSWERED "PN-START-UNANSWERED" "No station answered a Connect."
        "The device is off, still starting, or does not have the IP address to which the controller sends."
        "Read the device's name and IP address by DCP and compare them with the controller's configuration.";
    START_INCOMPLETE "PN-START-INCOMPLETE" "A start-up ended before the device was ready."
        "The side that had to take the next step waited or gave up."
        "Read the frames between the last step and the end; they show what the other side refused.";
    START_SLOW "PN-START-SLOW" "A step of a start-up took too long."
        "The device prepares its modules, or the controller writes many parameters."
        "Compare with the start-up time in the manual and with the timeout of the controller.";
    START_ORDER "PN-START-ORDER" "A start-up step was taken too early."
        "A bug in the stack of the sender."
        "Report it to the maker of that stack and attach this capture.";
    START_MODULES "PN-START-MODULES" "A device has other modules than the controller expects."
        "The configuration has another type or order of modules, or a module is missing."
        "Compare these slots with the hardware configuration.";
    START_AGAIN "PN-START-AGAIN" "A connection broke and was established again several times."
        "An unstable link or power supply, a watchdog that is too short, or two controllers that use the same device."
        "Check how each of these connections ended.";
    CALL_UNANSWERED "PN-CALL-UNANSWERED" "A call was never answered."
        "The answer was lost, or the station has crashed or was disconnected."
        "Check whether the station sends any frame after this one.";
    CALL_SLOW "PN-CALL-SLOW" "A call was answered late or only after repetitions."
        "The station is under load, or frames are lost."
        "Check for lost cyclic frames at the same time. If there are none, the station is slow.";
    CALL_FAILED "PN-CALL-FAILED" "A call failed."
        "The station does not accept this call in its present state."
        "Look up the status in the manual and read the frames before this one.";
    ANSWER_MALFORMED "PN-ANSWER-MALFORMED" "An answer is empty or cannot be read."
        "A bug in the stack of the station that answered."
        "Report it to the maker of that stack and attach this capture.";
    RECORD_REFUSED "PN-RECORD-REFUSED" "A record was refused."
        "The record does not exist in this slot and subslot, or its length or values are not allowed."
        "Compare slot, index and contents with the GSDML and the manual of the device.";
    CYCLE_LOST "PN-CYCLE-LOST" "Cyclic frames are missing."
        "Bad cables or connectors, an overloaded switch, or a recorder that does not keep up."
        "Read the error counters of the switch ports on the path, and capture again at both ends.";
    CYCLE_SILENT "PN-CYCLE-SILENT" "One side sent no cyclic frames for longer than the watchdog."
        "It lost power or its link, restarted, or crashed."
        "Check its last frames, its power supply and the link of its port.";
    CYCLE_COUNTER "PN-CYCLE-COUNTER" "The cycle counter of a sender does not match the agreed cycle."
        "A bug in the stack of the sender."
        "Report it to the maker of that stack and attach this capture.";
    STATUS_STOP "PN-STATUS-STOP" "A provider is in STOP state."
        "The controller's program or the device's application was stopped."
        "Read the entries of the controller's diagnostic buffer from this time.";
    STATUS_PROBLEM "PN-STATUS-PROBLEM" "A provider reports a problem."
        "A diagnosis is pending at the provider."
        "Read the diagnosis of the device and the alarms before this frame.";
    STATUS_INVALID "PN-STATUS-INVALID" "A provider marks its data as invalid."
        "The provider has not started its application, or has stopped it."
        "Read the frames right before this one.";
    STATUS_BAD_PROVIDER "PN-STATUS-BAD-PROVIDER" "The data of a submodule are marked as bad."
        "The submodule is missing, wrong or faulty, or the provider is not running."
        "Read the diagnosis of this slot.";
    STATUS_BAD_CONSUMER "PN-STATUS-BAD-CONSUMER" "A submodule does not accept the data sent to it."
        "The submodule is missing, wrong or not parameterised."
        "Read the diagnosis of this slot and check whether its parameters were accepted.";
    ABORTED "PN-ABORT" "An ERR-RTA ended a connection."
        "The status in the ERR-RTA gives the reason."
        "Read the frames before this one with this reason in mind.";
    ALARM_DIAGNOSIS "PN-ALARM-DIAGNOSIS" "A device reported a fault by an alarm or in a record."
        "The fault that the diagnosis names."
        "Look up the error number in the manual of the device.";
    ALARM_UNACKNOWLEDGED "PN-ALARM-UNACKNOWLEDGED" "An alarm was not acknowledged."
        "The controller is overloaded or does not handle this alarm."
        "Check the part of the controller's program that handles diagnosis alarms.";
    ALARM_REFUSED "PN-ALARM-REFUSED" "A controller refused an alarm."
        "The alarm names a module or a type that the controller did not configure."
        "Compare slot and type of the alarm with the configuration.";
    ALARM_PRIORITY "PN-ALARM-PRIORITY" "An alarm has one priority in its frame ID and the other one in its block."
        "The stack of the sender builds the frame from two settings that differ."
        "Report it to the maker of the sender; a receiver that compares both drops such an alarm.";
    NAME_DUPLICATE "PN-NAME-DUPLICATE" "Two stations have the same name."
        "Two devices were given the same name, often a spare part that was prepared with the name of the first."
        "Disconnect one of the two and give it another name.";
    ADDRESS_DUPLICATE "PN-ADDRESS-DUPLICATE" "Two stations have the same IP address."
        "The address was assigned twice by hand, or a DHCP server assigns addresses that the controller uses too."
        "Find both by their MAC addresses and change one.";
    ADDRESS_FORGED "PN-ADDRESS-FORGED" "A station sends frames with the address of another one."
        "A station that redirects or scans the network, a loop, or two stations with one MAC address."
        "Find the sender at the switch (its table of MAC addresses) and disconnect it.";
    FLOOD "PN-NETWORK-FLOOD" "A station floods the network with frames."
        "A loop in the network, a scan, or a faulty station."
        "Find the sender at the switch by its port counters, and limit the load of that port.";
    NAME_INVALID "PN-NAME-INVALID" "A station has a name that PROFINET does not allow."
        "A tool that does not check names assigned it, or it is a factory name."
        "Give it a name of lower-case letters, digits, hyphens and dots; a controller may not find it by the present one.";
    NAME_UNKNOWN "PN-NAME-UNKNOWN" "No station answers to a name."
        "The device is off, not connected, or has another name."
        "List the stations by DCP and give the device this name.";
    DCP_UNANSWERED "PN-DCP-UNANSWERED" "A station did not answer a DCP request."
        "It is off, restarting, or busy with another request."
        "Repeat the request, and check whether the station sends any other frame.";
    DCP_REFUSED "PN-DCP-REFUSED" "A station refused a DCP Set."
        "The station is in data exchange, or the value is not allowed."
        "End the connection first and check the value.";
    SET_RUNNING "PN-SET-RUNNING" "A station was given another name or address while it was connected."
        "An engineering tool or another controller addressed the wrong station."
        "Find the sender by its MAC address.";
    RESET_RUNNING "PN-RESET-RUNNING" "A station was reset while it was connected."
        "An engineering tool or another controller addressed the wrong station."
        "Find the sender by its MAC address.";
    TOPOLOGY_CHANGED "PN-TOPOLOGY-CHANGED" "The neighbours of a station have changed."
        "A cable was plugged into another port, or a device was replaced or switched off."
        "Compare with the planned topology.";
    ONE_SIDED "PN-CAPTURE-ONE-SIDED" "The capture shows one direction only."
        "The mirror port copies one direction only, or the other station is not connected."
        "Capture again with a mirror port that copies both directions, or with a tap. Until then missing frames prove nothing.";
    CAPTURE_GAP "PN-CAPTURE-GAP" "The capture has a gap, or does not show all frames."
        "The recorder or the mirror port did not keep up, or their link was interrupted."
        "Capture again with a tap or with less load. The gap is not judged.";
    ODD_FRAME "PN-CAPTURE-ODD-FRAME" "A single frame contradicts those before and after it."
        "A bit that the recorder or the file has changed; its sender may also have sent it once."
        "Look whether it happens again in a longer capture: then its sender is the cause.";
    NOTHING "PN-CAPTURE-NOTHING" "The capture has no PROFINET and no PROFIBUS frame."
        "It was taken at the wrong interface, at a switch port that is not mirrored, or with a filter."
        "Capture without a filter, at a mirror port of the switch next to the device or with a tap.";
    DP_LEFT "DP-SLAVE-LEFT" "A slave left the data exchange."
        "It lost its parameters by a reset, by its watchdog, or by a short loss of power."
        "Check its power supply, and its diagnosis right after this frame.";
    DP_SILENT "DP-SLAVE-SILENT" "A slave stopped answering."
        "Its power supply, its connector, the bus termination, or the slave itself."
        "Measure the bus at this station, and check whether its neighbours are disturbed too.";
    DP_WATCHDOG "DP-SLAVE-WATCHDOG" "The watchdog of a slave expired."
        "The master did not address the slave in time: it stopped, or its cycle is longer than the watchdog."
        "Compare the watchdog time in Set_Prm with the bus cycle time.";
    DP_UNANSWERED "DP-POLL-UNANSWERED" "Requests to a slave were not answered."
        "Disturbances, bad termination, or a slave that was off for a short time."
        "Check shield, termination and cable length near this station.";
    DP_REPEATED "DP-POLL-REPEATED" "A master had to repeat requests."
        "Disturbances on the bus, or a slave that answers too late."
        "Check shield, termination and cable length near this station, and the slot time of the master.";
    DP_DIAGNOSIS "DP-DIAGNOSIS-STANDING" "A slave reported a diagnosis."
        "The fault that the diagnosis names."
        "Look up these bits in the manual of the slave.";
    DP_PARAMETER_FAULT "DP-PARAMETER-FAULT" "A slave refused its parameters."
        "The user parameters, the ident number or the watchdog do not fit the slave."
        "Compare Set_Prm with the GSD of exactly this slave.";
    DP_CONFIGURATION_FAULT "DP-CONFIGURATION-FAULT" "A slave refused its configuration."
        "The configured modules are not those of the slave."
        "Compare Chk_Cfg with the answer of Get_Cfg and with the GSD.";
    DP_NOT_SUPPORTED "DP-NOT-SUPPORTED" "A slave does not support a requested function."
        "The master requested Sync, Freeze or another function that the slave does not have."
        "Remove it from the parameters of the slave.";
    DP_OTHER_MASTER "DP-OTHER-MASTER" "Two masters use the same slave."
        "The slave is configured in two masters, or an engineering tool is online."
        "Remove it from one of the two.";
    DP_REFUSED "DP-SERVICE-REFUSED" "A slave refused a service."
        "The slave does not have this service, or not in its present state."
        "Look up in its manual which services it has.";
    DP_TOKEN_LOST "DP-TOKEN-LOST" "A master lost the token or left the ring."
        "A master was switched off, or the token was lost in a disturbance."
        "Read the frames before this one, and check the highest station address (HSA) and the target rotation time.";
    DP_TOKEN_TWICE "DP-TOKEN-TWICE" "Two masters sent at the same time."
        "Two masters have the same address, or the bus was split and joined again."
        "Check the addresses of all masters.";
    DP_ADDRESS "DP-ADDRESS-GIVEN" "A slave in data exchange was given another address."
        "An engineering tool addressed the wrong slave."
        "Find the master that sent it.";
    DP_ADDRESS_IGNORED "DP-ADDRESS-IGNORED" "A slave acknowledged another address and kept its own."
        "The slave may not change its address any more (No_Add_Chg), its address is set by switches, or it has a bug."
        "Read in its manual how its address is set, and compare the ident number in the request with that of the slave.";
    DP_INPUT_LENGTH "DP-INPUT-LENGTH" "A slave sends another number of input bytes than its accepted configuration has."
        "A bug in the slave: it acknowledged the configuration in Chk_Cfg."
        "Compare Chk_Cfg with these answers, and report it to the maker of the slave with this capture.";
    DP_FIXED_BIT "DP-DIAGNOSIS-FIXED-BIT" "A diagnosis lacks the bit that is always 1."
        "A bug in the slave: bit 2 of the second byte of Slave_Diag is fixed."
        "Report it to the maker of the slave and attach this capture.";
    DP_WRONG_ANSWER "DP-ANSWER-WRONG" "A slave sends an answer that cannot be read, from another SAP than the requested one, or to another station."
        "A bug in the slave, or two stations with one address."
        "Disconnect the slave and check whether this address still answers.";
    DP_DAMAGED "DP-FRAME-DAMAGED" "Frames on the bus are damaged."
        "Disturbances, bad termination, two stations with one address, or the wrong baud rate at the recorder."
        "Check whether most of them belong to one station, and measure the bus there.";
    DP_ONE_SIDED "DP-CAPTURE-ONE-SIDED" "The capture shows requests only, or answers only."
        "The recorder receives one side of the bus only."
        "Record again at another point of the bus. Until then missing frames prove nothing.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_check_has_its_own_id_a_cause_and_a_next_step() {
        for (place, check) in CHECKS.iter().enumerate() {
            assert!(CHECKS[..place].iter().all(|before| before.id != check.id), "{} is listed twice", check.id);
            assert!(check.id.starts_with("PN-") || check.id.starts_with("DP-"));
            for text in [check.sentence, check.cause, check.next] {
                assert!(text.ends_with('.') && text.starts_with(char::is_uppercase), "{}: {text}", check.id);
            }
            assert_eq!(ProtocolCheck::by_id(&check.id.to_lowercase()), Some(*check));
        }
    }
}
