//! Bugs of the device after no manual, most of them bugs of its stack.

use super::Bug;
use crate::application::Severity;
use crate::profinet::End;
use wire::profinet::status::RecordError;

pub(crate) static BUGS: &[Bug] = bugs! {
    // Discovery
    "name-prefix-answered" "Whoever looks for the beginning of the name is answered."
        => |b| b.stack.answers_to = |own, asked| own.starts_with(asked);
    "any-name-answered" "Whoever looks for any name is answered."
        => |b| b.stack.answers_to = |_, _| true;
    "type-of-station-empty" "The type of the station is empty."
        => |b| b.stack.station_type = |_| "";
    "any-name-taken" "A name against the rules is taken."
        => |b| b.plain.takes_name = |_| true;
    "no-name-taken" "No name is taken."
        => |b| b.plain.takes_name = |_| false;
    "mask-ignored" "The subnet mask of a Set is not taken over."
        => |b| b.stack.mask = |current, _| current;
    "name-lost-at-power-off" "The station name is lost at power-off."
        => |b| b.plain.stores_name = false;
    "temporary-name-kept" "A name that was given for the time being is there after a power cycle."
        => |b| b.stack.forgets_temporary = false;
    "reset-answered-and-not-done" "A reset is answered positively and does not take place."
        => |b| b.stack.executes_reset = false;
    "signal-refused" "The light does not flash when it is asked to."
        => |b| b.stack.answers_signal = false;
    "neighbours-not-told" "LLDP is not sent."
        => |b| b.stack.announces_itself = false;

    // Connect
    "ident-not-checked" "The ident numbers of submodules are not checked."
        => |b| b.stack.checks_submodule_ident = false;
    "module-difference-not-reported" "Connect and ApplicationReady do not say that something else is plugged."
        => |b| b.stack.reports_module_diff = false;
    "output-length-not-checked" "The length of the outputs is not compared in Connect."
        => |b| b.stack.checks_output_length = false;
    "input-length-not-checked" "The length of the inputs is not compared in Connect."
        => |b| b.stack.checks_input_length = false;
    "other-frame-id" "The inputs are sent under another frame id than was agreed."
        => |b| b.stack.input_frame_id = |agreed| agreed + 1;
    "second-controller-served" "A second controller gets a connection to what the first one uses."
        => |b| b.stack.connections = 2;

    // Cyclic data
    "good-inputs-before-ready" "The inputs are good before ApplicationReady."
        => |b| b.stack.inputs_wait_for_ready = false;
    "consumer-status-always-bad" "The device never says that it takes the outputs."
        => |b| b.stack.sends_consumer_status = false;
    "outputs-reversed" "The octets of the outputs are taken in reverse order."
        => |b| b.plain.mirror = |[a, b, c, d]| [d, c, b, a];
    "bad-outputs-taken" "Outputs whose provider status is bad are taken."
        => |b| b.stack.heeds_provider_status = false;
    "outputs-not-watched" "The connection does not end when no outputs come."
        => |b| b.stack.watches_outputs = false;
    "watch-too-short" "The connection ends after a quarter of the time for which outputs may be missing."
        => |b| b.stack.hold = |agreed| agreed / 4;
    "watch-too-long" "Outputs may be missing ten times as long as was agreed."
        => |b| b.stack.hold = |agreed| agreed * 10;
    "cycle-counter-stands-still" "The cycle counter is the same in every frame."
        => |b| b.stack.cycle_counter = |_| 0x1000;
    "outputs-of-anybody" "Outputs are taken from any station."
        => |b| b.stack.checks_source = false;

    // Records
    "im0-length-counts-header" "The length in the header of I&M0 counts the header too."
        => |b| b.stack.im0_length = |length| length + 6;
    "im1-not-kept" "I&M1 is written and reads as before."
        => |b| b.stack.keeps_texts = false;
    "records-not-cut" "A record is answered whole, however few octets are asked for."
        => |b| b.stack.cuts_records = false;
    "unknown-index-answered" "Unknown records are read as empty ones."
        => |b| b.stack.refuses_unknown_index = false;
    "unknown-index-written" "Unknown records are written as if they were there."
        => |b| b.stack.refuses_unknown_write = false;
    "plugged-not-told" "No record tells what is plugged."
        => |b| b.stack.tells_what_is_plugged = false;
    "place-not-checked" "I&M0 can be read where nothing is plugged."
        => |b| b.stack.checks_place = false;
    "read-only-record-written" "Writing a record that can only be read is accepted and lost."
        => |b| b.stack.refuses_read_only = false;
    "one-error-for-all" "Every refusal of a record gives the same reason."
        => |b| b.stack.record_error = |_| RecordError::READ_ERROR;

    // Alarms
    "pending-diagnosis-not-told" "A new connection is not told what is wrong already."
        => |b| b.stack.tells_pending_diagnoses = false;
    "diagnosis-never-withdrawn" "A diagnosis stays when its fault has gone."
        => |b| b.plain.withdraws = false;
    "fault-reported-as-maintenance" "A fault is reported as a need for maintenance."
        => |b| b.plain.severity = Severity::MaintenanceRequired;
    "diagnosis-of-another-slot" "A diagnosis names another slot than that of the fault."
        => |b| b.plain.diagnosed = 2;

    // The end of a connection
    "released-connection-kept" "A connection that was released stands in the way of the next one."
        => |b| b.stack.frees_connections = |end| end != End::Released;
    "aborted-connection-kept" "A connection that was aborted stands in the way of the next one."
        => |b| b.stack.frees_connections = |end| end != End::Aborted;

    // Broken requests
    "damaged-dcp-ends-connection" "A DCP frame that cannot be read ends the connection."
        => |b| b.stack.survives_damaged_dcp = false;
    "damaged-call-ends-connection" "A datagram that is no call ends the connection."
        => |b| b.stack.survives_damaged_calls = false;
    "short-frame-ends-connection" "A cyclic frame that is too short ends the connection."
        => |b| b.stack.survives_short_frames = false;
    "any-endpoint-ends-connection" "An ERR-RTA for another alarm endpoint ends the connection."
        => |b| b.stack.checks_alarm_endpoints = false;
};
