//! Where the stack can be told to do something else than a healthy one.

use crate::profinet::{Access, Plug, StationData};
use alloc::vec::Vec;
use station::Duration;
use wire::datagram::arp::Arp;
use wire::ethernet::Mac;
use wire::octets::Order;
use wire::profinet::alarm::AlarmNotification;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{IocrBlockReq, RtClass};
use wire::profinet::blocks::im::Im0;
use wire::profinet::blocks::module_diff::ModuleState;
use wire::profinet::dcp::Value;
use wire::profinet::status::RecordError;

/// How a controller ends a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// By Release.
    Released,
    /// By an ERR-RTA.
    Aborted,
}

/// What has happened to a device since it was delivered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Past {
    /// How often I&M0 was read.
    pub im0_reads: u32,
    /// How often the station was reset.
    pub resets: u32,
}

/// How the stack behaves; the default is healthy. Each field is read at one seam.
#[derive(Clone, Copy, Debug)]
pub struct StackBehaviour {
    /// Whether the answer to Identify waits as the address of the device and the request say.
    pub delays_identify: bool,
    /// Whether a device of the first name answers to who asks for the second one.
    pub answers_to: fn(&[u8], &[u8]) -> bool,
    /// The type of the station that DCP tells, from the one of the device.
    pub station_type: fn(&'static str) -> &'static str,
    /// The MAC address, from the one that it was made with.
    pub mac: fn(Mac, Past) -> Mac,
    /// Whether a frame is for a device of the first address, by the one that it is sent to.
    pub is_addressed: fn(Mac, Mac) -> bool,
    /// The name that DCP tells, from the one in use.
    pub told_name: fn(&[u8]) -> Vec<u8>,
    /// Changes what a Set has made of the station in use and of the stored one, in view of the one that was in use.
    pub after_set: fn(&StationData, &mut StationData, &mut StationData),
    /// Changes the stored station that is taken into use at the start and after a reset.
    pub at_start: fn(&mut StationData),
    /// Whether an ARP packet is looked at.
    pub takes_arp: fn(&Arp) -> bool,
    /// Whether a name or an address that was set temporarily is gone after the next start.
    pub forgets_temporary: bool,
    /// Whether a reset that was answered positively takes place.
    pub executes_reset: bool,
    /// Whether the device answers between a reset and the next start.
    pub survives_reset: bool,
    /// Whether the light flashes when DCP asks for it; else that is refused.
    pub answers_signal: bool,
    /// Vendor and device that DCP tells, from those of the device.
    pub told_ids: fn((u16, u16)) -> (u16, u16),
    /// What Get is given, from what DCP tells otherwise.
    pub got: fn(Value) -> Value,
    /// Whether a reset of the station ends the connections.
    pub ends_with_reset: bool,
    /// Whether neighbours are told who is here, by the name of the device.
    pub announces_itself: fn(&[u8]) -> bool,
    /// The name that neighbours are told, from the one in use and the one at the start.
    pub announced_name: for<'a> fn(&'a [u8], &'a [u8]) -> &'a [u8],
    /// The number of the port that neighbours are told, from that of the port.
    pub announced_port: fn(u16) -> u16,
    /// When the name from before a reset of the station is there again.
    pub name_returns_after: Option<Duration>,
    /// Where a record of the application is looked up, from where it is asked for.
    pub looks_up: fn(Access) -> Access,
    /// Whether it is kept who the neighbour is.
    pub keeps_neighbour: bool,
    /// The kind of the line that is told.
    pub mau_type: u16,
    /// Whether damaged DCP is passed over, and does not end the connections.
    pub survives_damaged_dcp: bool,
    /// Whether a cyclic frame that is too short is passed over, and does not end the connection.
    pub survives_short_frames: bool,
    /// Whether a datagram that is no call is passed over, and does not end the connections.
    pub survives_damaged_calls: bool,
    /// The byte order of an answer, from that of the request.
    pub answer_order: fn(Order) -> Order,
    /// Whether calls in this byte order are answered.
    pub takes_order: fn(Order) -> bool,
    /// How long a call takes; until then the device tells whoever asks that it is working.
    pub answer_time: Duration,
    /// Whether a repeated request gets the answer again, and is not carried out again.
    pub keeps_answers: bool,
    /// Changes what can be plugged, interface and ports among it.
    pub plugs: fn(&mut Vec<Plug>),
    /// Whether a submodule with an unknown ident is another one than what is plugged.
    pub checks_submodule_ident: bool,
    /// Whether the length of the outputs in Connect is compared with that of the submodule.
    pub checks_output_length: bool,
    /// Whether the length of the inputs in Connect is compared with that of the submodule.
    pub checks_input_length: bool,
    /// Whether a block of Connect that is not for this device is passed over, and not refused; it is asked about those
    /// that controllers send to every device.
    pub passes_over: fn(BlockType) -> bool,
    /// Whether the blocks of a Connect, by their types as they were sent, stand in an order that is taken.
    pub takes_blocks: fn(&[BlockType]) -> bool,
    /// Whether a start-up of the advanced mode is taken.
    pub takes_advanced_start: bool,
    /// The field of a cyclic connection, by its number, for which it is refused although all of it is right.
    pub refused_field: fn(&IocrBlockReq) -> Option<u8>,
    /// The frame id under which outputs are taken, from the one that the controller has proposed.
    pub output_frame_id: fn(u16) -> u16,
    /// Whether cyclic data are taken without a tag of priority too, as switches on the way may have taken it off.
    pub takes_untagged: bool,
    /// Whether the connection of a controller gives way to a new one of the same controller, by whether both have the
    /// same UUID.
    pub gives_way: fn(bool) -> bool,
    /// How many records of a multiple write are carried out, from how many there are; the others are answered likewise.
    pub writes_of_multiple: fn(usize) -> usize,
    /// Whether cyclic data of this class can be agreed.
    pub takes_rt_class: fn(RtClass) -> bool,
    /// How many connections there can be in the life of the device.
    pub connections_ever: u32,
    /// How many connections with cyclic data there can be at a time.
    pub connections: usize,
    /// Whether a connection that was released or aborted by its controller makes room for another one.
    pub frees_connections: fn(End) -> bool,
    /// The frame id of the inputs, from the one agreed in Connect.
    pub input_frame_id: fn(u16) -> u16,
    /// Whether Connect and ApplicationReady tell what is plugged otherwise than expected.
    pub reports_module_diff: bool,
    /// Whether Connect and ApplicationReady tell what is plugged although all of it is as expected.
    pub tells_proper_modules: bool,
    /// What they call a module that is as expected, where they tell it.
    pub proper_state: ModuleState,
    /// Whether ApplicationReady waits for the end of the parameters.
    pub waits_for_parameters: bool,
    /// Whether the place of an I&M record is looked at.
    pub checks_place: bool,
    /// Whether a record that can only be read refuses to be written.
    pub refuses_read_only: bool,
    /// Whether an index that nobody knows refuses to be written.
    pub refuses_unknown_write: bool,
    /// Whether the device tells in records what is plugged.
    pub tells_what_is_plugged: bool,
    /// Whether I&M1 to I&M3 keep what is written to them.
    pub keeps_texts: bool,
    /// The reason for which an access to a record is refused, from the right one.
    pub record_error: fn(RecordError) -> RecordError,
    /// Whether an index that nobody knows is refused.
    pub refuses_unknown_index: bool,
    /// Whether I&M1 to I&M3 are refused if the device does not have them.
    pub refuses_missing_im: bool,
    /// Whether I&M0 can be read.
    pub serves_im0: bool,
    /// Changes I&M0.
    pub im0: fn(&mut Im0, Past),
    /// Changes the octets of I&M0.
    pub im0_octets: fn(&mut Vec<u8>),
    /// Whether I&M0 can be written.
    pub im0_is_writable: bool,
    /// Whether a read without a connection leaves the connections alone.
    pub survives_implicit_read: bool,
    /// Whether a record is cut to the length asked for.
    pub cuts_records: bool,
    /// Whether inputs are bad until ApplicationReady.
    pub inputs_wait_for_ready: bool,
    /// Whether the device tells in each frame how it finds the outputs.
    pub sends_consumer_status: bool,
    /// The cycle counter that is sent, from the right one.
    pub cycle_counter: fn(u16) -> u16,
    /// Whether the status of the station says that a diagnosis is pending.
    pub indicates_problem: bool,
    /// Whether the status of a received frame is looked for behind its data, and not at the end of the frame.
    pub finds_status_behind_data: bool,
    /// Whether outputs count only while the controller runs and its data are valid.
    pub heeds_data_status: bool,
    /// Whether the outputs of a submodule count only while their IOPS is good.
    pub heeds_provider_status: bool,
    /// Whether the bad status of one submodule leaves the outputs of the others good.
    pub tells_outputs_apart: bool,
    /// Whether the encoder is told that outputs have gone when their connection ends.
    pub clears_outputs: bool,
    /// Whether the inputs go on while outputs are bad.
    pub inputs_go_on: bool,
    /// Whether the connection ends when no outputs come.
    pub watches_outputs: bool,
    /// How long outputs may be missing, from the time that was agreed.
    pub hold: fn(Duration) -> Duration,
    /// Whether outputs are taken from the controller of the connection alone.
    pub checks_source: bool,
    /// Whether an alarm PDU is taken by the connection whose endpoints it names alone.
    pub checks_alarm_endpoints: bool,
    /// The sequence number of the first alarm of a connection.
    pub first_alarm_sequence: u16,
    /// Whether an alarm without acknowledgement is repeated.
    pub repeats_alarms: bool,
    /// Whether the acknowledgement of an alarm is taken, and makes room for the next one.
    pub takes_acknowledgements: bool,
    /// Whether a new connection is told what is pending already.
    pub tells_pending_diagnoses: bool,
    /// What is sent of an alarm, from the right one.
    pub alarm: fn(&mut AlarmNotification),
    /// Whether the inputs stay good while an alarm waits for its acknowledgement.
    pub sends_inputs_during_alarm: bool,
    /// Whether records tell the diagnoses that are pending.
    pub tells_diagnoses: bool,
    /// Whether web pages are at the address in use, and not at the first one since the start.
    pub moves_pages: bool,
}

/// dot3MauType 100BASE-TX full duplex.
const FAST_ETHERNET: u16 = 16;

impl Default for StackBehaviour {
    fn default() -> StackBehaviour {
        StackBehaviour {
            delays_identify: true,
            answers_to: |own, asked| own == asked,
            station_type: |own| own,
            mac: |made_with, _| made_with,
            is_addressed: |own, to| own == to,
            told_name: <[u8]>::to_vec,
            after_set: |_, _, _| {},
            at_start: |_| {},
            takes_arp: |_| true,
            forgets_temporary: true,
            executes_reset: true,
            survives_reset: true,
            answers_signal: true,
            told_ids: |ids| ids,
            got: |value| value,
            ends_with_reset: true,
            announces_itself: |_| true,
            announced_name: |now, _| now,
            announced_port: |port| port,
            name_returns_after: None,
            looks_up: |asked| asked,
            keeps_neighbour: true,
            mau_type: FAST_ETHERNET,
            survives_damaged_dcp: true,
            survives_short_frames: true,
            survives_damaged_calls: true,
            answer_order: |order| order,
            takes_order: |_| true,
            answer_time: Duration::ZERO,
            keeps_answers: true,
            plugs: |_| {},
            checks_submodule_ident: true,
            checks_output_length: true,
            checks_input_length: true,
            passes_over: |_| true,
            takes_blocks: |_| true,
            takes_advanced_start: true,
            refused_field: |_| None,
            output_frame_id: |proposed| proposed,
            takes_untagged: true,
            gives_way: |_| true,
            writes_of_multiple: |records| records,
            takes_rt_class: |class| matches!(class, RtClass::RT_CLASS_1 | RtClass::RT_CLASS_2),
            connections_ever: u32::MAX,
            connections: 1,
            frees_connections: |_| true,
            input_frame_id: |agreed| agreed,
            reports_module_diff: true,
            tells_proper_modules: false,
            proper_state: ModuleState::PROPER_MODULE,
            waits_for_parameters: true,
            checks_place: true,
            refuses_read_only: true,
            refuses_unknown_write: true,
            tells_what_is_plugged: true,
            keeps_texts: true,
            record_error: |error| error,
            refuses_unknown_index: true,
            refuses_missing_im: true,
            serves_im0: true,
            im0: |_, _| {},
            im0_octets: |_| {},
            im0_is_writable: false,
            survives_implicit_read: true,
            cuts_records: true,
            inputs_wait_for_ready: true,
            sends_consumer_status: true,
            cycle_counter: |counter| counter,
            indicates_problem: true,
            finds_status_behind_data: true,
            heeds_data_status: true,
            heeds_provider_status: true,
            tells_outputs_apart: true,
            clears_outputs: true,
            inputs_go_on: true,
            watches_outputs: true,
            hold: |agreed| agreed,
            checks_source: true,
            checks_alarm_endpoints: true,
            first_alarm_sequence: 0xFFFF,
            repeats_alarms: true,
            takes_acknowledgements: true,
            tells_pending_diagnoses: true,
            alarm: |_| {},
            sends_inputs_during_alarm: true,
            tells_diagnoses: true,
            moves_pages: true,
        }
    }
}
