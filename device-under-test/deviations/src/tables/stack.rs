//! Deviations of the PROFINET stack.

use super::Group;
use super::sensor_memory::HeldRequests;
use super::stack_memory::{
    AbortsAtImplicitRead, AbortsAtShortFrame, AnnouncesFirstName, InputsStandStill, KeepsRoom, NameReturns,
    OneBadClearsAll, OnlyAnswersReset, OnlyNewAlarms, SilentAfterReset, WearsOut, WritableIm0,
};
use crate::needs::Need;
use crate::seams::stack::{IM0, Stack, dcp, is_of_stack, profinet};
use alloc::vec::Vec;
use core::ops::RangeInclusive;
use core::time::Duration;
use device_stack::profinet::{Access, Connection, Plug, StackCheck, StackView};
use encoder_profile::encoder_object::names::accepts;
use reference_devices::manuals;
use wire::datagram::Datagram;
use wire::datagram::arp::Arp;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::lldp::{Lldp, Tlv};
use wire::profinet::blocks::connect::{Connect, Content, RtClass};
use wire::profinet::blocks::module_diff::{ArInfo, IdentInfo, ModuleDiffBlock, ModuleState, SubmoduleState};
use wire::profinet::blocks::physical::{MultipleBlock, PortDataReal};
use wire::profinet::dcp::Value;
use wire::profinet::rpc::{self, Pdu};
use wire::profinet::rt::{ApduStatus, FrameKind};
use wire::profinet::status::{AbortReason, RecordError};

/// I&M1 to I&M3, which a user writes.
const IM1_TO_IM3: RangeInclusive<u16> = 0xAFF1..=0xAFF3;

/// The deviations, by what they need of a device.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profinet],
        deviations: bugs! {
            // Discovery
            "name-prefix-answered" "Whoever looks for the beginning of the name is answered."
                => |d| d.stack.check(|check, right| match check { StackCheck::AskedName(own, asked) => own.starts_with(asked), _ => right });
            "any-name-answered" "Whoever looks for any name is answered."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::AskedName(..)));
            "nameless-answers-everybody" "A device without a name answers whoever looks for any name."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::AskedName(b"", _)));
            "name-with-padding" "A name of odd length is told with its padding."
                => |d| d.stack.element(|value| match value { Value::NameOfStation(name) => Value::NameOfStation(padded(name)), other => other });
            "station-type-of-the-stack" "The type of the station is that of a sample application."
                => |d| d.stack.element(|value| station_type(value, b"SAMPLE DEVICE"));
            "name-told-as-empty" "The name is told as empty, whatever it is."
                => |d| d.stack.element(without_name);
            "vendor-of-the-stack-told" "DCP tells the vendor of a sample application."
                => |d| d.stack.element(|value| ids(value, |(_, device)| (0xFEED, device)));
            "device-id-swapped" "DCP tells the octets of the device number in the other order."
                => |d| d.stack.element(|value| ids(value, |(vendor, device)| (vendor, device.swap_bytes())));
            "type-of-station-empty" "The type of the station is empty."
                => |d| d.stack.element(|value| station_type(value, b""));
            "mac-of-the-stack" "The MAC address begins with the number of the maker of the stack."
                => |d| d.stack.mac(|Mac([_, _, _, d, e, f])| Mac([0x00, 0x0E, 0xCF, d, e, f]));
            "mac-changes-with-reset" "A factory reset gives a new MAC address."
                => |d| d.stack.mac({
                let mut resets = 0..;
                move |Mac([a, b, c, d, e, f])| Mac([a, b, c, d, e, f.wrapping_add(resets.next().unwrap_or(0))])
            });

            // DCP Set
            "set-of-others-taken" "A name or an address is taken that was sent to another device."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Addressed(_)));
            "mask-ignored" "The subnet mask of a Set is not taken over."
                => |d| d.stack.set_station(|before, now, stored| (now.mask, stored.mask) = (before.mask, before.mask));
            "address-after-restart-only" "An address that is set is used after the next start only."
                => |d| d.stack.set_station(|before, now, _| (now.ip, now.mask, now.gateway) = (before.ip, before.mask, before.gateway));
            "name-after-restart-only" "A name that is set is used after the next start only."
                => |d| d.stack.set_station(|before, now, _| now.name = before.name.clone());
            "name-erases-address" "Setting the name erases the address."
                => |d| d.stack.set_station(|before, now, stored| {
                if now.name != before.name {
                    (now.ip, stored.ip) = ([0; 4], [0; 4]);
                }
            });
            "address-waits-for-dcp" "The stored address is not used until DCP sets one."
                => |d| d.stack.load_station(|_, station| (station.ip, station.mask, station.gateway) = ([0; 4], [0; 4], [0; 4]));
            "link-local-address" "Without an address the device takes one of its own."
                => |d| d.stack.load_station(|_, station| {
                if station.ip == [0; 4] {
                    (station.ip, station.mask) = ([169, 254, 1, 1], [255, 255, 0, 0]);
                }
            });
            "arp-probe-ignored" "Whoever looks whether the address is in use is not answered."
                => |d| d.stack.hear(|_, frame| !is_arp_probe(frame));
            "temporary-name-kept" "A name that was given for the time being is there after a power cycle."
                => |d| d.stack.set_station(|_, now, stored| stored.clone_from(now));
            "signal-refused" "The light does not flash when it is asked to."
                => |d| d.stack.check(|check, right| right && !matches!(check, StackCheck::Signal(_)));
            "fixed-address" "The address is one that the maker has chosen, and no Set changes it."
                => |d| {
                d.stack.load_station(|_, station| (station.ip, station.mask) = ([192, 168, 0, 199], [255, 255, 255, 0]));
                d.stack.set_station(|before, now, _| {
                    (now.ip, now.mask, now.gateway) = (before.ip, before.mask, before.gateway);
                });
            };
            "reset-leaves-connection" "A reset of the station leaves the connection alone."
                => |d| d.stack.set(StackCheck::Ends(AbortReason::RESET_TO_FACTORY), false);
            "reset-answered-and-not-done" "A reset is answered positively and does not take place."
                => |d| d.stack.add(OnlyAnswersReset::default());
            "silent-after-reset" "After a reset nothing is answered until the next start."
                => |d| d.stack.add(SilentAfterReset::default());
            "name-back-after-reset" "The name from before a factory reset is there again 5 s after it."
                => |d| d.stack.add(NameReturns::default());

            // LLDP
            "neighbours-not-told" "LLDP is not sent."
                => |d| d.stack.lldp(|_| false);
            "not-announced-without-name" "Without a name LLDP is not sent."
                => |d| d.stack.lldp(|lldp| !is_nameless(lldp));
            "lldp-tells-old-name" "LLDP tells the name from before the last change."
                => |d| d.stack.add(AnnouncesFirstName::default());
            "neighbour-not-told" "No record tells who the neighbour is."
                => |d| d.stack.hear(|_, frame| !is_lldp(frame));
            "second-port-announced" "A second port is told that is not there."
                => |d| d.stack.plugs(add_port);
            "half-duplex-reported" "The line is told to be half duplex."
                => |d| half_duplex_reported(&mut d.stack);
            "lldp-tells-the-other-port" "LLDP at the first port tells the number of the second one."
                => |d| d.stack.lldp(|lldp| { renumber(lldp); true });

            // Connect
            "ident-not-checked" "The ident numbers of submodules are not checked."
                => |d| d.stack.connect(with_idents_of_plugs);
            "module-difference-not-reported" "Connect and ApplicationReady do not say that something else is plugged."
                => |d| d.stack.difference(|_, differing| *differing = None);
            "output-length-not-checked" "The length of the outputs is not compared in Connect."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::OutputLength(_)));
            "input-length-not-checked" "The length of the inputs is not compared in Connect."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::InputLength(_)));
            "difference-for-a-proper-module" "Connect and ApplicationReady name modules that are as expected among those that differ."
                => |d| d.stack.difference(name_proper_modules);
            "rt-class-1-refused" "Cyclic data of RT class 1 are refused."
                => |d| d.stack.check(|check, right| right && !is_class_field(check, RtClass::RT_CLASS_1));
            "old-connection-blocks-reconnect" "A controller that comes again is refused until its old connection has run out."
                => |d| d.stack.set(StackCheck::GivesWay, false);
            "rt-class-3-accepted" "Cyclic data of RT class 3 are agreed, and nothing comes."
                => |d| d.stack.check(|check, right| right || is_class_field(check, RtClass::RT_CLASS_3));
            "other-frame-id" "The inputs are sent under another frame id than was agreed."
                => |d| d.stack.inputs(|frame| frame[1] = frame[1].wrapping_add(1));
            "second-controller-served" "A second controller gets a connection to what the first one uses."
                => |d| d.stack.check(|check, right| match check { StackCheck::Room { is_exchange: true, others } => others < 2, _ => right });
            "fourth-connection-refused" "After three connections there is no further one."
                => |d| d.stack.add(WearsOut::default());
            "proper-module-called-substitute" "Connect and ApplicationReady call modules that are as expected substitutes."
                => |d| d.stack.difference(call_proper_modules_substitutes);

            // Cyclic data
            "good-inputs-before-ready" "The inputs are good before ApplicationReady."
                => |d| d.stack.set(StackCheck::InputsReady, true);
            "consumer-status-always-bad" "The device never says that it takes the outputs."
                => |d| d.stack.set(StackCheck::TakesOutputs, false);
            "bad-outputs-taken" "Outputs whose provider status is bad are taken."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ProviderStatus(_)));
            "one-bad-status-clears-all" "The bad status of one submodule makes the outputs of all bad."
                => |d| d.stack.add(OneBadClearsAll::default());
            "inputs-stop-with-bad-outputs" "The inputs stand still while outputs are bad."
                => |d| d.stack.add(InputsStandStill::default());
            "outputs-not-watched" "The connection does not end when no outputs come."
                => |d| d.stack.hold(|_| Duration::from_secs(31_536_000));
            "watch-too-short" "The connection ends after a quarter of the time for which outputs may be missing."
                => |d| d.stack.hold(|agreed| agreed / 4);
            "watch-too-long" "Outputs may be missing ten times as long as was agreed."
                => |d| d.stack.hold(|agreed| agreed * 10);
            "cycle-counter-stands-still" "The cycle counter is the same in every frame."
                => |d| d.stack.inputs(|frame| { let at = frame.len() - ApduStatus::LENGTH; frame[at..at + 2].copy_from_slice(&[0x10, 0x00]) });
            "outputs-of-anybody" "Outputs are taken from any station."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Source(_)));

            // I&M
            "im0-refused" "There is no I&M0."
                => |d| d.stack.read(|access, result| if access.index == IM0 && result.is_ok() { *result = Err(RecordError::INVALID_INDEX) });
            "im0-length-counts-header" "The length in the header of I&M0 counts the header too."
                => |d| d.stack.im0_octets(|octets| octets[3] += 6);
            "im0-of-54-octets" "I&M0 is told without its header."
                => |d| d.stack.im0_octets(|octets| drop(octets.drain(..6)));
            "im0-without-vendor" "The vendor in I&M0 is 0."
                => |d| d.stack.im0(|im0| im0.vendor_id = 0);
            "im0-padded-with-zeros" "The order number in I&M0 is filled with zeros."
                => |d| d.stack.im0(|im0| im0.order_id.iter_mut().filter(|octet| **octet == b' ').for_each(|octet| *octet = 0));
            "im0-serial-empty" "The serial number in I&M0 is empty."
                => |d| d.stack.im0(|im0| im0.serial_number = [b' '; 16]);
            "im0-serial-of-zeros" "The serial number in I&M0 is sixteen octets of 0."
                => |d| d.stack.im0(|im0| im0.serial_number = [0; 16]);
            "im0-revisions-wrong" "The hardware revision in I&M0 is the software revision."
                => |d| d.stack.im0(|im0| {
                let software = im0.software_revision;
                im0.hardware_revision = u16::from_be_bytes([software.functional_enhancement, software.bug_fix]);
            });
            "im0-software-as-text" "The software revision in I&M0 is a text."
                => |d| d.stack.im0_octets(|octets| octets[46..50].copy_from_slice(b"1.09"));
            "im0-counts-reads" "The revision counter and the type of the profile in I&M0 change with each read."
                => |d| d.stack.im0({
                let mut reads = 0_u16;
                move |im0| {
                    (im0.revision_counter, im0.profile_specific_type) = (reads, reads);
                    reads = reads.wrapping_add(1);
                }
            });
            "im0-version-0" "The version of I&M in I&M0 is 0."
                => |d| d.stack.im0(|im0| im0.im_version = [0, 0]);
            "im0-written" "I&M0 can be written."
                => |d| d.stack.add(WritableIm0::default());

            // Records
            "records-not-cut" "A record is answered whole, however few octets are asked for."
                => |d| d.stack.set(StackCheck::TooLong, false);
            "unknown-index-answered" "Unknown records are read as empty ones."
                => |d| d.stack.read(|access, result| if is_unknown(access, result) { *result = Ok(Vec::new()) });
            "unknown-index-written" "Unknown records are written as if they were there."
                => |d| d.stack.written(|access, _, result| if is_unknown(access, result) { *result = Ok(()) });
            "plugged-not-told" "No record tells what is plugged."
                => |d| d.stack.read(|access, result| if matches!(access.index, 0x8001 | 0xC001 | 0xE001 | 0xF000) && result.is_ok() { *result = Err(RecordError::INVALID_INDEX) });
            "place-not-checked" "I&M0 can be read where nothing is plugged."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Plugged(Access { index: IM0, .. })));
            "read-only-record-written" "Writing a record that can only be read is accepted and lost."
                => |d| d.stack.written(|access, _, result| if is_of_stack(access.index) && *result == Err(RecordError::ACCESS_DENIED) { *result = Ok(()) });
            "one-error-for-all" "Every refusal of a record gives the same reason."
                => |d| {
                d.stack.read(|_, result| if result.is_err() { *result = Err(RecordError::READ_ERROR) });
                d.stack.written(|_, _, result| if result.is_err() { *result = Err(RecordError::READ_ERROR) });
            };
            "second-reader-ends-connection" "Reading without a connection ends the connections of others."
                => |d| d.stack.add(AbortsAtImplicitRead::default());

            // Alarms
            "pending-diagnosis-not-told" "A new connection is not told what is wrong already."
                => |d| d.stack.add(OnlyNewAlarms::default());

            // The end of a connection
            "released-connection-kept" "A connection that was released stands in the way of the next one."
                => |d| d.stack.add(KeepsRoom { after: Connection::Released, is_taken: false });
            "aborted-connection-kept" "A connection that was aborted stands in the way of the next one."
                => |d| d.stack.add(KeepsRoom { after: Connection::Aborted, is_taken: false });

            // Broken requests
            "damaged-dcp-ends-connection" "A DCP frame that cannot be read ends the connection."
                => |d| d.stack.abort_at(is_damaged_dcp);
            "damaged-call-ends-connection" "A datagram that is no call ends the connection."
                => |d| d.stack.abort_at(is_damaged_call);
            "short-frame-ends-connection" "A cyclic frame that is too short ends the connection."
                => |d| d.stack.add(AbortsAtShortFrame::default());
            "any-endpoint-ends-connection" "An ERR-RTA for another alarm endpoint ends the connection."
                => |d| d.stack.set(StackCheck::AlarmEndpoint, true);
        },
    },
    Group {
        needs: &[Need::Profinet, Need::EncoderProfile],
        deviations: bugs! {
            "encoder-in-slot-0" "The encoder stands in slot 0."
                => |d| d.stack.plugs(|plugs| plugs.iter_mut().for_each(|plug| plug.slot = 0));
            "encoder-in-api-0" "The encoder stands in the process that belongs to no profile."
                => |d| d.stack.plugs(|plugs| plugs.iter_mut().for_each(|plug| plug.api = 0));
            "access-point-with-data" "Submodules that have no cyclic data are said to have two octets of inputs."
                => |d| d.stack.plugs(|plugs| {
                let is_blank = |plug: &&mut Plug| plug.slot != 0 && (plug.input_octets, plug.output_octets) == (0, 0);
                plugs.iter_mut().filter(is_blank).for_each(|plug| plug.input_octets = 2);
            });
            "dap-1-accepted" "Access point 1 is taken for the own one."
                => |d| d.stack.plugs(|plugs| add_access_point(plugs, |_| 1));
            "outputs-held-after-loss" "The encoder goes on with the last outputs when its connection has ended."
                => |b| {
                b.stack.set(StackCheck::OutputsEnd, false);
                b.at_encoder.add(HeldRequests::over_connections());
            };
            "im0-without-profile" "I&M0 names no profile."
                => |d| d.stack.im0(|im0| im0.profile_id = 0);
            "long-name-cut" "A name of more than 127 characters is taken and cut."
                => |d| {
                d.stack.check(|check, right| match check {
                    StackCheck::Name(name) => name.is_empty() || name.split(|octet| *octet == b'.').all(|label| !label.is_empty() && accepts(label)),
                    _ => right,
                });
                d.stack.set_station(|_, now, stored| {
                    now.name.truncate(127);
                    stored.name.truncate(127);
                });
            };
            "two-telegrams-missing" "There are no submodules for the telegrams 82 and 84."
                => |d| d.stack.plugs(|plugs| plugs.retain(|plug| !matches!(plug.submodule_ident, 82 | 84)));
        },
    },
    Group {
        needs: &[Need::Profinet, Need::OnlyIm0],
        deviations: bugs! {
            "im1-accepted" "Writing I&M1 is accepted and lost."
                => |d| d.stack.written(|access, _, result| if IM1_TO_IM3.contains(&access.index) && *result == Err(RecordError::INVALID_INDEX) { *result = Ok(()) });
            "im0-announces-im1" "I&M0 says that there are I&M1 to I&M3."
                => |d| d.stack.im0(|im0| im0.im_supported = 0b1110);
        },
    },
    Group {
        needs: &[Need::Of(&manuals::LIKA_XAC77)],
        deviations: bugs! {
            "other-variant-accepted" "The access point of the other variant is taken for the own one."
                => |d| d.stack.plugs(|plugs| add_access_point(plugs, |own| 5 - own));
        },
    },
    Group {
        needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)],
        deviations: bugs! {
            "parameter-submodule-with-data" "The parameter access point has two octets of inputs."
                => |d| d.stack.plugs(|plugs| {
                plugs.iter_mut().filter(|plug| (plug.slot, plug.subslot) == (1, 1)).for_each(|plug| plug.input_octets = 2);
            });
            "universal-without-mt-pos" "The module with all submodules lacks the one with the revolutions."
                => |d| d.stack.plugs(|plugs| plugs.retain(|plug| (plug.module_ident, plug.submodule_ident) != (0x30, 0x103)));
            "record-in-every-api" "Records are read and written in API 0 too."
                => |d| d.stack.access(|access| if !is_of_stack(access.index) { access.api = 0x3D00 });
        },
    },
    Group {
        needs: &[Need::Of(&manuals::PROFINET_IO)],
        deviations: bugs! {
            "im1-not-kept" "I&M1 is written and reads as before."
                => |d| d.stack.record(|index, data| if IM1_TO_IM3.contains(&index) { data[6..].fill(b' ') });
        },
    },
];

// Discovery

fn padded(name: Vec<u8>) -> Vec<u8> {
    let length = name.len().next_multiple_of(2);
    let mut padded = name;
    padded.resize(length, 0);
    padded
}

fn station_type(value: Value, other: &[u8]) -> Value {
    if matches!(value, Value::Vendor(_)) { Value::Vendor(other.to_vec()) } else { value }
}

fn without_name(value: Value) -> Value {
    if matches!(value, Value::NameOfStation(_)) { Value::NameOfStation(Vec::new()) } else { value }
}

fn ids(value: Value, other: fn((u16, u16)) -> (u16, u16)) -> Value {
    let Value::DeviceId { vendor_id, device_id } = value else { return value };
    let (vendor_id, device_id) = other((vendor_id, device_id));
    Value::DeviceId { vendor_id, device_id }
}

fn is_arp_probe(frame: &[u8]) -> bool {
    let Ok((header, payload)) = FrameHeader::parse(frame) else { return false };
    header.ether_type == EtherType::ARP && Arp::parse(payload).is_ok_and(|arp| arp.sender_ip.is_unspecified())
}

// LLDP

fn is_lldp(frame: &[u8]) -> bool {
    FrameHeader::parse(frame).is_ok_and(|(header, _)| header.ether_type == EtherType::LLDP)
}

fn is_nameless(lldp: &Lldp) -> bool {
    lldp.tlvs.iter().any(|tlv| matches!(tlv, Tlv::ChassisId { subtype: Tlv::CHASSIS_MAC_ADDRESS, .. }))
}

/// Announces port 2 in the place of port 1.
fn renumber(lldp: &mut Lldp) {
    for tlv in &mut lldp.tlvs {
        if let Tlv::PortId { id, .. } = tlv {
            id.splice(..8, *b"port-002");
        }
    }
}

/// dot3MauType of 100BASE-TX.
const FULL_DUPLEX: u16 = 16;
const HALF_DUPLEX: u16 = 15;

fn half_duplex_reported(stack: &mut Stack) {
    stack.lldp(|lldp| {
        for tlv in &mut lldp.tlvs {
            if let Tlv::MacPhy { mau_type, .. } = tlv {
                *mau_type = HALF_DUPLEX;
            }
        }
        true
    });
    stack.record(|index, data| match index {
        0x802A => with_half_duplex(data),
        0xF841 => {
            let Ok(blocks) = MultipleBlock::parse_record(data) else { return };
            data.clear();
            for mut block in blocks {
                with_half_duplex(&mut block.blocks);
                block.write(data);
            }
        }
        _ => {}
    });
}

fn with_half_duplex(data: &mut Vec<u8>) {
    if let Some(mut port) = PortDataReal::parse(data).ok().filter(|port| port.mau_type == FULL_DUPLEX) {
        port.mau_type = HALF_DUPLEX;
        data.clear();
        port.write(data);
    }
}

// Connect

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

/// Expects of each submodule that cannot be plugged the ident of the one that is plugged in its place.
fn with_idents_of_plugs(view: &StackView<'_>, connect: &mut Connect) {
    for block in &mut connect.blocks {
        let Content::ExpectedSubmodule(expected) = &mut block.content else { continue };
        for module in &mut expected.modules {
            for submodule in &mut module.submodules {
                let place = (module.api, module.slot_number, submodule.subslot_number);
                let idents = (module.module_ident_number, submodule.submodule_ident_number);
                let is_at = |plug: &&Plug| (plug.api, plug.slot, plug.subslot) == place;
                let mut possible = view.application.plugs().iter().chain(view.plugged).filter(is_at);
                let is_possible = possible.any(|plug| (plug.module_ident, plug.submodule_ident) == idents);
                if let Some(plug) = view.plugged.iter().find(is_at).filter(|_| !is_possible) {
                    submodule.submodule_ident_number = plug.submodule_ident;
                }
            }
        }
    }
}

/// Names the modules that are as expected if there are no others.
fn name_proper_modules(all: &ModuleDiffBlock, differing: &mut Option<ModuleDiffBlock>) {
    differing.get_or_insert_with(|| all.clone());
}

fn call_proper_modules_substitutes(all: &ModuleDiffBlock, differing: &mut Option<ModuleDiffBlock>) {
    let told = differing.get_or_insert_with(|| all.clone());
    let modules = told.apis.iter_mut().flat_map(|api| &mut api.modules);
    for module in modules.filter(|module| module.state == ModuleState::PROPER_MODULE) {
        module.state = ModuleState::SUBSTITUTE;
        let state = SubmoduleState::new(IdentInfo::SUBSTITUTE, ArInfo::OWN, 0);
        module.submodules.iter_mut().for_each(|submodule| submodule.state = state);
    }
}

/// Number of IOCRProperties in an IOCRBlockReq, the header counted.
const IOCR_PROPERTIES: u8 = 7;

/// Whether it is decided about cyclic data of this class.
fn is_class_field(check: StackCheck<'_>, class: RtClass) -> bool {
    matches!(check, StackCheck::IocrField(iocr, IOCR_PROPERTIES) if iocr.iocr_properties.rt_class() == class)
}

// Records

/// Whether the application has no record of this index.
fn is_unknown<T>(access: Access, result: &Result<T, RecordError>) -> bool {
    !is_of_stack(access.index) && matches!(result, Err(RecordError::INVALID_INDEX))
}

// Broken requests

fn is_damaged_dcp(view: &StackView<'_>, frame: &[u8]) -> bool {
    let Some((header, _, frame_id)) = profinet(frame) else { return false };
    let is_dcp = matches!(frame_id.kind(), FrameKind::DcpIdentifyRequest | FrameKind::DcpGetSet);
    let is_received = header.destination == view.mac || header.destination.is_group();
    is_dcp && is_received && dcp(frame).is_none()
}

fn is_damaged_call(view: &StackView<'_>, frame: &[u8]) -> bool {
    let Ok(datagram) = Datagram::parse(frame) else { return false };
    let is_received = datagram.destination.ip().octets() == view.station.ip && datagram.checksum_ok();
    is_received && datagram.destination.port() == rpc::PORT && Pdu::parse(datagram.payload).is_err()
}
