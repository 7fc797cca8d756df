//! The checks of the protocol: word, sentence, likely cause, next step. Each finding of this room belongs to one of them.

use crate::finding::{Blame, Finding, Severity};

/// A check of the protocol, which needs no manual.
#[derive(Debug, PartialEq, Eq)]
pub struct Check {
    /// Its word, which is the id of its findings: `PN-...` on PROFINET, `DP-...` on PROFIBUS.
    pub id: &'static str,
    /// What its findings say, in one sentence.
    pub sentence: &'static str,
    /// What they most likely come from.
    pub cause: &'static str,
    /// What to do next.
    pub next: &'static str,
}

impl Check {
    /// A finding of this check in packet `frame`, with its likely cause and next step.
    pub(super) fn finding(&self, severity: Severity, blame: Blame, frame: u64, text: impl Into<String>) -> Finding {
        Finding::protocol(self.id, severity, blame, frame, text).cause(self.cause).next(self.next)
    }

    /// The check of this word, whatever its case.
    pub fn by_id(id: &str) -> Option<&'static Check> {
        CHECKS.iter().copied().find(|check| check.id.eq_ignore_ascii_case(id))
    }
}

macro_rules! checks {
    ($($NAME:ident $id:literal $sentence:literal $cause:literal $next:literal;)+) => {
        $(
            #[doc = $sentence]
            pub(super) const $NAME: &Check = &Check { id: $id, sentence: $sentence, cause: $cause, next: $next };
        )+

        /// All checks, those of PROFINET first.
        pub const CHECKS: &[&Check] = &[$($NAME),+];
    };
}

checks! {
    START_REFUSED "PN-START-REFUSED" "A device refused a connection."
        "The configuration of the controller does not fit the device, or the device has no connection left."
        "Compare the configured modules with those of the device; look for another controller that has a connection to it.";
    START_UNANSWERED "PN-START-UNANSWERED" "Nobody answered a Connect."
        "The device is off, still starting, or does not have the address that the controller sends to."
        "Ask the device for its name and address by DCP, and compare them with those of the controller.";
    START_INCOMPLETE "PN-START-INCOMPLETE" "A start-up came to its end before the device was ready."
        "The side that owed the next step waited for something or gave up."
        "Look at the frames between the last step and the end; what the other side refused stands there.";
    START_SLOW "PN-START-SLOW" "A step of a start-up took long."
        "The device prepares its modules, or the controller writes many parameters."
        "Compare with the start-up time that the manual gives, and with what the controller waits for.";
    START_ORDER "PN-START-ORDER" "A step of a start-up came before one that it has to follow."
        "A fault of the stack of the side that sent it."
        "Tell the maker of that stack, with this capture.";
    START_MODULES "PN-START-MODULES" "A device has other modules than the controller expects."
        "The project was made for another type or order of modules, or one is missing."
        "Compare the slots named here with the hardware configuration.";
    START_AGAIN "PN-START-AGAIN" "A connection broke and was made again several times."
        "An unsteady link or power supply, a watchdog too short, or two controllers that want the same device."
        "Look at how each of the connections ended.";
    CALL_UNANSWERED "PN-CALL-UNANSWERED" "A call was never answered."
        "The answer was lost, or the station hangs or is gone."
        "See whether the station sends anything at all behind this frame.";
    CALL_SLOW "PN-CALL-SLOW" "A call was answered late, or only after it was repeated."
        "A station under load, or frames that get lost."
        "Look for lost cyclic frames at the same time; if there are none, the station is slow.";
    CALL_FAILED "PN-CALL-FAILED" "A call failed."
        "The station does not accept what was asked of it in its state."
        "Look up the status in the manual, and what went before in the frames around.";
    RECORD_REFUSED "PN-RECORD-REFUSED" "A record was refused."
        "The record does not exist at this place, or its length or values are not allowed."
        "Compare slot, index and contents with the GSDML and the manual of the device.";
    CYCLE_LOST "PN-CYCLE-LOST" "Cyclic frames are missing."
        "Bad cables or connectors, load in a switch, or a capture that does not keep up."
        "Read the error counters of the ports on the way; capture again at both ends.";
    CYCLE_SILENT "PN-CYCLE-SILENT" "One side sent no cyclic frames for longer than the watchdog."
        "It lost power or its link, was restarted, or its program hung."
        "Look at its last frames, at its supply and at the link of its port.";
    CYCLE_COUNTER "PN-CYCLE-COUNTER" "The cycle counter of a sender does not count as agreed."
        "A fault of the stack of the sender."
        "Tell the maker of that stack, with this capture.";
    STATUS_STOP "PN-STATUS-STOP" "A provider is in STOP."
        "The program of the controller was stopped, or the application of the device."
        "Read the diagnostic buffer of the controller at this time.";
    STATUS_PROBLEM "PN-STATUS-PROBLEM" "A provider signals a problem."
        "A diagnosis is pending there."
        "Read the diagnosis of the device; alarms before this frame tell more.";
    STATUS_INVALID "PN-STATUS-INVALID" "A provider marks its data as invalid."
        "The provider has not started its application, or has stopped it."
        "Look at what happened right before it.";
    STATUS_BAD_PROVIDER "PN-STATUS-BAD-PROVIDER" "The data of a submodule are marked as bad."
        "The submodule is missing, wrong or faulty, or the provider is not running."
        "Read the diagnosis of this slot.";
    STATUS_BAD_CONSUMER "PN-STATUS-BAD-CONSUMER" "A submodule does not take the data sent to it."
        "The submodule is missing, wrong or not parameterised."
        "Read the diagnosis of this slot, and see whether its parameters were accepted.";
    ABORTED "PN-ABORT" "A connection was ended by an ERR-RTA."
        "The sender gives the reason."
        "Follow the reason to the frames before this one.";
    ALARM_DIAGNOSIS "PN-ALARM-DIAGNOSIS" "A device reported a fault, by an alarm or in a record that was read."
        "What the diagnosis names."
        "Look up the error number in the manual of the device.";
    ALARM_UNACKNOWLEDGED "PN-ALARM-UNACKNOWLEDGED" "An alarm was not acknowledged."
        "The controller is overloaded or does not handle this alarm."
        "Look at the program of the controller that handles diagnosis alarms.";
    ALARM_REFUSED "PN-ALARM-REFUSED" "A controller refused an alarm."
        "The alarm names something that the controller did not plan."
        "Compare slot and type of the alarm with the configuration.";
    NAME_DUPLICATE "PN-NAME-DUPLICATE" "Two stations have the same name."
        "Two devices were given the same name, mostly a spare part that was prepared with the name of the first."
        "Unplug one of the two and give it a name of its own.";
    ADDRESS_DUPLICATE "PN-ADDRESS-DUPLICATE" "Two stations have the same IP address."
        "An address was given twice by hand, or a DHCP server gives addresses that the controller uses too."
        "Find both by their MAC addresses and change one.";
    NAME_INVALID "PN-NAME-INVALID" "A station has a name that PROFINET does not allow."
        "Somebody named it by a tool that does not check, or its maker gave it this name."
        "Give it a name of small letters, digits, hyphens and dots; a controller may not find it by this one.";
    NAME_UNKNOWN "PN-NAME-UNKNOWN" "Nobody answers to a name."
        "The device is off, not connected, or has another name."
        "List the stations by DCP; give the device this name.";
    DCP_UNANSWERED "PN-DCP-UNANSWERED" "A station did not answer a DCP request."
        "It is off, restarting, or busy with another request."
        "Ask again; see whether it sends anything else.";
    DCP_REFUSED "PN-DCP-REFUSED" "A station refused what it was told by DCP."
        "It is in data exchange, or the value is not allowed."
        "End the connection first, and check the value.";
    SET_RUNNING "PN-SET-RUNNING" "Somebody gave a station another name or address while it was connected."
        "An engineering tool or another controller took it for one of its own."
        "Find the sender by its MAC address.";
    RESET_RUNNING "PN-RESET-RUNNING" "Somebody reset a station while it was connected."
        "An engineering tool or another controller took it for one of its own."
        "Find the sender by its MAC address.";
    TOPOLOGY_CHANGED "PN-TOPOLOGY-CHANGED" "The neighbours of a station have changed."
        "A cable was plugged into another port, or a device was replaced or switched off."
        "Compare with the planned topology.";
    ONE_SIDED "PN-CAPTURE-ONE-SIDED" "The capture shows one direction only."
        "The mirror port copies one direction only, or the other station is not there."
        "Capture again with a mirror of both directions or a tap; until then what is missing says nothing.";
    CAPTURE_GAP "PN-CAPTURE-GAP" "The capture has a gap, or does not show all frames."
        "The recorder or the mirror port did not keep up, or the link of both was interrupted."
        "Capture again with a tap or less load; what lies in the gap is not judged.";
    NOTHING "PN-CAPTURE-NOTHING" "The capture has no frame of PROFINET and none of PROFIBUS."
        "It was taken at another interface, behind a switch that does not mirror the port, or with a filter."
        "Capture at a mirror port of the switch next to the device, or with a tap, and without a filter.";
    DP_LEFT "DP-SLAVE-LEFT" "A slave left the data exchange."
        "It lost its parameters by a reset, its watchdog, or a short loss of power."
        "Look at its supply and at its diagnosis right behind this frame.";
    DP_SILENT "DP-SLAVE-SILENT" "A slave stopped answering."
        "Its supply, its connector, the termination of the bus, or the slave itself."
        "Measure the bus at this station; see whether its neighbours are disturbed too.";
    DP_WATCHDOG "DP-SLAVE-WATCHDOG" "The watchdog of a slave ran out."
        "The master did not address the slave in time: it stopped, or its cycle is longer than the watchdog."
        "Compare the watchdog in Set_Prm with the cycle of the bus.";
    DP_UNANSWERED "DP-POLL-UNANSWERED" "Requests to a slave were not answered."
        "Disturbances, bad termination, or a slave that was off for a moment."
        "Look at shield, termination and cable length around this station.";
    DP_REPEATED "DP-POLL-REPEATED" "A master had to repeat requests."
        "Disturbances on the bus, or a slave that answers too late."
        "Look at shield, termination and cable length around this station; check the slot time of the master.";
    DP_DIAGNOSIS "DP-DIAGNOSIS-STANDING" "A slave reported a diagnosis."
        "What the diagnosis names."
        "Look up the bits in the manual of the slave.";
    DP_PARAMETER_FAULT "DP-PARAMETER-FAULT" "A slave refused its parameters."
        "The user parameters, the ident number or the watchdog do not fit the slave."
        "Compare Set_Prm with the GSD of this very slave.";
    DP_CONFIGURATION_FAULT "DP-CONFIGURATION-FAULT" "A slave refused its configuration."
        "Other modules are configured than the slave has."
        "Compare Chk_Cfg with the answer of Get_Cfg and with the GSD.";
    DP_NOT_SUPPORTED "DP-NOT-SUPPORTED" "A slave does not have what was asked of it."
        "The master asked for sync, freeze or a function that the slave lacks."
        "Take it out of the parameters of the slave.";
    DP_OTHER_MASTER "DP-OTHER-MASTER" "Two masters want the same slave."
        "The slave is configured in two masters, or an engineering tool is online."
        "Take it out of one of the two.";
    DP_REFUSED "DP-SERVICE-REFUSED" "A slave refused a service."
        "The slave does not have this service, or not in its state."
        "Look up in its manual what it has.";
    DP_TOKEN_LOST "DP-TOKEN-LOST" "A master lost the token or left the ring."
        "A master was switched off, or the token was lost by a disturbance."
        "Look at the frames before it; check the highest station address and the target rotation time.";
    DP_TOKEN_TWICE "DP-TOKEN-TWICE" "Two masters spoke at the same time."
        "Two masters have the same address, or the bus was split and joined again."
        "Check the addresses of all masters.";
    DP_ADDRESS "DP-ADDRESS-GIVEN" "A slave in data exchange was given another address."
        "An engineering tool took it for another one."
        "Find out who sent it.";
    DP_DAMAGED "DP-FRAME-DAMAGED" "Frames on the bus are damaged."
        "Disturbances, bad termination, two stations with one address, or a recorder at the wrong baud rate."
        "See whether they gather at one station; measure the bus there.";
    DP_ONE_SIDED "DP-CAPTURE-ONE-SIDED" "The capture shows requests only, or answers only."
        "The recorder hears one side of the bus only."
        "Record again at another place; until then what is missing says nothing.";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_check_has_a_word_of_its_own_and_tells_what_to_do() {
        for (place, check) in CHECKS.iter().enumerate() {
            assert!(CHECKS[..place].iter().all(|before| before.id != check.id), "{} stands there twice", check.id);
            assert!(check.id.starts_with("PN-") || check.id.starts_with("DP-"));
            for text in [check.sentence, check.cause, check.next] {
                assert!(text.ends_with('.') && text.starts_with(char::is_uppercase), "{}: {text}", check.id);
            }
            assert_eq!(Check::by_id(&check.id.to_lowercase()), Some(*check));
        }
    }
}
