//! Bugs of the PROFINET stack, which all models have; each model says which of them it can be told to have.

use super::Deviation;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::End;
use device_stack::profinet::{Access, Plug};
use encoder_profile::profidrive::mantel::Cleared;
use wire::ethernet::Mac;
use wire::octets::Order;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::RtClass;
use wire::profinet::blocks::module_diff::ModuleState;
use wire::profinet::status::RecordError;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Discovery
    "name-prefix-answered" "Whoever looks for the beginning of the name is answered."
        => |b| b.stack.answers_to = |own, asked| own.starts_with(asked);
    "any-name-answered" "Whoever looks for any name is answered."
        => |b| b.stack.answers_to = |_, _| true;
    "nameless-answers-everybody" "A device without a name answers whoever looks for any name."
        => |b| b.stack.answers_to = |own, asked| own.is_empty() || own == asked;
    "name-with-padding" "A name of odd length is told with its padding."
        => |b| b.stack.told_name = padded;
    "station-type-of-the-stack" "The type of the station is that of a sample application."
        => |b| b.stack.station_type = |_| "SAMPLE DEVICE";
    "name-told-as-empty" "The name is told as empty, whatever it is."
        => |b| b.stack.told_name = |_| Vec::new();
    "vendor-of-the-stack-told" "DCP tells the vendor of a sample application."
        => |b| b.stack.told_ids = |(_, device)| (0xFEED, device);
    "device-id-swapped" "DCP tells the octets of the device number in the other order."
        => |b| b.stack.told_ids = |(vendor, device)| (vendor, device.swap_bytes());
    "type-of-station-empty" "The type of the station is empty."
        => |b| b.stack.station_type = |_| "";
    "mac-of-the-stack" "The MAC address begins with the number of the maker of the stack."
        => |b| b.stack.mac = |Mac([_, _, _, rest @ ..]), _| mac([0x00, 0x0E, 0xCF], rest);
    "mac-changes-with-reset" "A factory reset gives a new MAC address."
        => |b| b.stack.mac = |Mac([a, b, c, d, e, f]), past| mac([a, b, c], [d, e, f.wrapping_add(past.resets as u8)]);

    // DCP Set
    "set-of-others-taken" "A name or an address is taken that was sent to another device."
        => |b| b.stack.is_addressed = |_, _| true;
    "mask-ignored" "The subnet mask of a Set is not taken over."
        => |b| b.stack.after_set = |before, now, stored| (now.mask, stored.mask) = (before.mask, before.mask);
    "address-after-restart-only" "An address that is set is used after the next start only."
        => |b| b.stack.after_set = |before, now, _| (now.ip, now.mask, now.gateway) = (before.ip, before.mask, before.gateway);
    "name-after-restart-only" "A name that is set is used after the next start only."
        => |b| b.stack.after_set = |before, now, _| now.name = before.name.clone();
    "name-erases-address" "Setting the name erases the address."
        => |b| b.stack.after_set = |before, now, stored| {
            if now.name != before.name {
                (now.ip, stored.ip) = ([0; 4], [0; 4]);
            }
        };
    "long-name-cut" "A name of more than 127 characters is taken and cut."
        => |b| {
            b.encoder.names.longest = usize::MAX;
            b.stack.after_set = |_, now, stored| {
                now.name.truncate(127);
                stored.name.truncate(127);
            };
        };
    "address-waits-for-dcp" "The stored address is not used until DCP sets one."
        => |b| b.stack.at_start = |station| (station.ip, station.mask, station.gateway) = ([0; 4], [0; 4], [0; 4]);
    "link-local-address" "Without an address the device takes one of its own."
        => |b| b.stack.at_start = |station| {
            if station.ip == [0; 4] {
                (station.ip, station.mask) = ([169, 254, 1, 1], [255, 255, 0, 0]);
            }
        };
    "arp-probe-ignored" "Whoever looks whether the address is in use is not answered."
        => |b| b.stack.takes_arp = |arp| !arp.sender_ip.is_unspecified();
    "temporary-name-kept" "A name that was given for the time being is there after a power cycle."
        => |b| b.stack.forgets_temporary = false;
    "signal-refused" "The light does not flash when it is asked to."
        => |b| b.stack.answers_signal = false;
    "fixed-address" "The address is one that the maker has chosen, and no Set changes it."
        => |b| {
            b.stack.at_start = |station| (station.ip, station.mask) = ([192, 168, 0, 199], [255, 255, 255, 0]);
            b.stack.after_set = |before, now, _| {
                (now.ip, now.mask, now.gateway) = (before.ip, before.mask, before.gateway);
            };
        };
    "reset-leaves-connection" "A reset of the station leaves the connection alone."
        => |b| b.stack.ends_with_reset = false;
    "reset-answered-and-not-done" "A reset is answered positively and does not take place."
        => |b| b.stack.executes_reset = false;
    "silent-after-reset" "After a reset nothing is answered until the next start."
        => |b| b.stack.survives_reset = false;

    // LLDP
    "neighbours-not-told" "LLDP is not sent."
        => |b| b.stack.announces_itself = |_| false;
    "not-announced-without-name" "Without a name LLDP is not sent."
        => |b| b.stack.announces_itself = |name| !name.is_empty();
    "lldp-tells-old-name" "LLDP tells the name from before the last change."
        => |b| b.stack.announced_name = |_, at_start| at_start;
    "neighbour-not-told" "No record tells who the neighbour is."
        => |b| b.stack.keeps_neighbour = false;
    "second-port-announced" "A second port is told that is not there."
        => |b| b.stack.plugs = add_port;
    "half-duplex-reported" "The line is told to be half duplex."
        => |b| b.stack.mau_type = 15;

    // Connect
    "ident-not-checked" "The ident numbers of submodules are not checked."
        => |b| b.stack.checks_submodule_ident = false;
    "module-difference-not-reported" "Connect and ApplicationReady do not say that something else is plugged."
        => |b| b.stack.reports_module_diff = false;
    "output-length-not-checked" "The length of the outputs is not compared in Connect."
        => |b| b.stack.checks_output_length = false;
    "input-length-not-checked" "The length of the inputs is not compared in Connect."
        => |b| b.stack.checks_input_length = false;
    "other-variant-accepted" "The access point of the other variant is taken for the own one."
        => |b| b.stack.plugs = |plugs| add_access_point(plugs, |own| 5 - own);
    "dap-1-accepted" "Access point 1 is taken for the own one."
        => |b| b.stack.plugs = |plugs| add_access_point(plugs, |_| 1);
    "encoder-in-slot-0" "The encoder stands in slot 0."
        => |b| b.stack.plugs = |plugs| plugs.iter_mut().for_each(|plug| plug.slot = 0);
    "encoder-in-api-0" "The encoder stands in the process that belongs to no profile."
        => |b| b.stack.plugs = |plugs| plugs.iter_mut().for_each(|plug| plug.api = 0);
    "access-point-with-data" "Submodules that have no cyclic data are said to have two octets of inputs."
        => |b| b.stack.plugs = |plugs| {
            let is_blank = |plug: &&mut Plug| plug.slot != 0 && (plug.input_octets, plug.output_octets) == (0, 0);
            plugs.iter_mut().filter(is_blank).for_each(|plug| plug.input_octets = 2);
        };
    "two-telegrams-missing" "There are no submodules for the telegrams 82 and 84."
        => |b| b.stack.plugs = |plugs| plugs.retain(|plug| !matches!(plug.submodule_ident, 82 | 84));
    "difference-for-a-proper-module" "Connect and ApplicationReady name modules that are as expected among those that differ."
        => |b| b.stack.tells_proper_modules = true;
    "rt-class-1-refused" "Cyclic data of RT class 1 are refused."
        => |b| b.stack.takes_rt_class = |class| class == RtClass::RT_CLASS_2;
    "advanced-start-refused" "A controller that starts up in the advanced mode is refused."
        => |b| b.stack.takes_advanced_start = false;
    "little-endian-refused" "A call in little-endian byte order is answered with a fault."
        => |b| b.stack.takes_order = |order| order == Order::Big;
    "block-order-fixed" "A Connect is refused if its alarm connection does not stand at the end."
        => |b| b.stack.takes_blocks = |kinds| {
            let alarms = &BlockType::ALARM_CR_REQ;
            !kinds.contains(alarms) || kinds.last() == Some(alarms)
        };
    "unknown-block-refused" "A Connect is refused if it offers fast start-up."
        => |b| b.stack.passes_over = |_| false;
    "phase-not-1-refused" "Cyclic data are refused that are to be sent in another phase than the first."
        => |b| b.stack.refused_field = |iocr| (iocr.phase != 1).then_some(12);
    "reduction-of-512-refused" "Cyclic data are refused that are to be sent every 512 send clocks."
        => |b| b.stack.refused_field = |iocr| (iocr.reduction_ratio == 512).then_some(11);
    "output-frame-id-not-taken" "The frame id that the controller proposes for the outputs is agreed and not looked at."
        => |b| b.stack.output_frame_id = |proposed| proposed ^ 1;
    "tag-needed" "Cyclic data without a tag of priority are passed over."
        => |b| b.stack.takes_untagged = false;
    "old-connection-blocks-reconnect" "A controller that comes again is refused until its old connection has run out."
        => |b| b.stack.gives_way = |_| false;
    "write-multiple-first-only" "Of several records in one write the first is written, and all are answered well."
        => |b| b.stack.writes_of_multiple = |_| 1;
    "rt-class-3-accepted" "Cyclic data of RT class 3 are agreed, and nothing comes."
        => |b| b.stack.takes_rt_class = |_| true;
    "other-frame-id" "The inputs are sent under another frame id than was agreed."
        => |b| b.stack.input_frame_id = |agreed| agreed + 1;
    "second-controller-served" "A second controller gets a connection to what the first one uses."
        => |b| b.stack.connections = 2;
    "fourth-connection-refused" "After three connections there is no further one."
        => |b| b.stack.connections_ever = 3;

    // Cyclic data
    "good-inputs-before-ready" "The inputs are good before ApplicationReady."
        => |b| b.stack.inputs_wait_for_ready = false;
    "consumer-status-always-bad" "The device never says that it takes the outputs."
        => |b| b.stack.sends_consumer_status = false;
    "bad-outputs-taken" "Outputs whose provider status is bad are taken."
        => |b| b.stack.heeds_provider_status = false;
    "one-bad-status-clears-all" "The bad status of one submodule makes the outputs of all bad."
        => |b| b.stack.tells_outputs_apart = false;
    "outputs-held-after-loss" "The encoder goes on with the last outputs when its connection has ended."
        => |b| {
            (b.stack.clears_outputs, b.encoder.sensor.keeps_parked, b.encoder.sensor.keeps_requests) = (false, true, true);
            b.encoder.mantel.clears = |cleared| cleared != Cleared::End;
        };
    "inputs-stop-with-bad-outputs" "The inputs stand still while outputs are bad."
        => |b| b.stack.inputs_go_on = false;
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

    // I&M
    "im0-refused" "There is no I&M0."
        => |b| b.stack.serves_im0 = false;
    "im0-length-counts-header" "The length in the header of I&M0 counts the header too."
        => |b| b.stack.im0_octets = |octets| octets[3] += 6;
    "im0-of-54-octets" "I&M0 is told without its header."
        => |b| b.stack.im0_octets = |octets| drop(octets.drain(..6));
    "im0-without-vendor" "The vendor in I&M0 is 0."
        => |b| b.stack.im0 = |im0, _| im0.vendor_id = 0;
    "im0-padded-with-zeros" "The order number in I&M0 is filled with zeros."
        => |b| b.stack.im0 = |im0, _| im0.order_id.iter_mut().filter(|octet| **octet == b' ').for_each(|octet| *octet = 0);
    "im0-serial-empty" "The serial number in I&M0 is empty."
        => |b| b.stack.im0 = |im0, _| im0.serial_number = [b' '; 16];
    "im0-serial-of-zeros" "The serial number in I&M0 is sixteen octets of 0."
        => |b| b.stack.im0 = |im0, _| im0.serial_number = [0; 16];
    "im0-revisions-wrong" "The hardware revision in I&M0 is the software revision."
        => |b| b.stack.im0 = |im0, _| {
            let software = im0.software_revision;
            im0.hardware_revision = u16::from_be_bytes([software.functional_enhancement, software.bug_fix]);
        };
    "im0-software-as-text" "The software revision in I&M0 is a text."
        => |b| b.stack.im0_octets = |octets| octets[46..50].copy_from_slice(b"1.09");
    "im0-counts-reads" "The revision counter and the type of the profile in I&M0 change with each read."
        => |b| b.stack.im0 = |im0, past| {
            im0.revision_counter = past.im0_reads as u16;
            im0.profile_specific_type = past.im0_reads as u16;
        };
    "im0-without-profile" "I&M0 names no profile."
        => |b| b.stack.im0 = |im0, _| im0.profile_id = 0;
    "im0-version-0" "The version of I&M in I&M0 is 0."
        => |b| b.stack.im0 = |im0, _| im0.im_version = [0, 0];
    "im0-announces-im1" "I&M0 says that there are I&M1 to I&M3."
        => |b| b.stack.im0 = |im0, _| im0.im_supported = 0b1110;
    "im0-written" "I&M0 can be written."
        => |b| b.stack.im0_is_writable = true;
    "im1-accepted" "Writing I&M1 is accepted and lost."
        => |b| b.stack.refuses_missing_im = false;
    "im1-not-kept" "I&M1 is written and reads as before."
        => |b| b.stack.keeps_texts = false;

    // Records
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
    "second-reader-ends-connection" "Reading without a connection ends the connections of others."
        => |b| b.stack.survives_implicit_read = false;

    // Alarms
    "pending-diagnosis-not-told" "A new connection is not told what is wrong already."
        => |b| b.stack.tells_pending_diagnoses = false;

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

/// The bugs of this seam that not all manuals have.
pub static OTHERS: &[Deviation] = bugs! {
    "lldp-tells-the-other-port" "LLDP at the first port tells the number of the second one."
        => |b| b.stack.announced_port = |port| 3 - port;
    "name-back-after-reset" "The name from before a factory reset is there again 5 s after it."
        => |b| b.stack.name_returns_after = Some(Duration::from_secs(5));
    "parameter-submodule-with-data" "The parameter access point has two octets of inputs."
        => |b| b.stack.plugs = |plugs| {
            plugs.iter_mut().filter(|plug| (plug.slot, plug.subslot) == (1, 1)).for_each(|plug| plug.input_octets = 2);
        };
    "universal-without-mt-pos" "The module with all submodules lacks the one with the revolutions."
        => |b| b.stack.plugs = |plugs| plugs.retain(|plug| (plug.module_ident, plug.submodule_ident) != (0x30, 0x103));
    "proper-module-called-substitute" "Connect and ApplicationReady call modules that are as expected substitutes."
        => |b| (b.stack.tells_proper_modules, b.stack.proper_state) = (true, ModuleState::SUBSTITUTE);
    "record-in-every-api" "Records are read and written in API 0 too."
        => |b| b.stack.looks_up = |asked| Access { api: 0x3D00, ..asked };
};

fn mac([a, b, c]: [u8; 3], [d, e, f]: [u8; 3]) -> Mac {
    Mac([a, b, c, d, e, f])
}

fn padded(name: &[u8]) -> Vec<u8> {
    let mut told = name.to_vec();
    told.resize(name.len().next_multiple_of(2), 0);
    told
}

/// Adds a port after the last one.
fn add_port(plugs: &mut Vec<Plug>) {
    if let Some(last) = plugs.last().copied() {
        plugs.push(Plug { subslot: last.subslot + 1, submodule_ident: last.submodule_ident + 1, ..last });
    }
}

/// Adds what stands in slot 0 once more, as an alternative of another module.
fn add_access_point(plugs: &mut Vec<Plug>, other: fn(u32) -> u32) {
    let head: Vec<Plug> = plugs.iter().filter(|plug| plug.slot == 0).copied().collect();
    plugs.extend(head.iter().map(|plug| Plug { module_ident: other(plug.module_ident), ..*plug }));
}
