//! Deviations of the PROFINET stack in discovery, naming and Connect.

use super::Group;
use super::connection_state::ThreeConnectionsOnly;
use super::cyclic_state::HeldRequests;
use super::station_state::{AnnouncesFirstName, NameReturns, OnlyAnswersReset, SilentAfterReset};
use crate::needs::Need;
use crate::seams::stack::{Stack, is_of_stack};
use alloc::vec::Vec;
use core::mem;
use device_stack::profinet::{PluggableSubmodule, StackCheck, StackView};
use encoder_profile::encoder_object::names::accepts;
use reference_devices::manuals;
use wire::datagram::arp::Arp;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::lldp::{Lldp, Tlv};
use wire::profinet::blocks::connect::{Connect, ConnectContent, RtClass};
use wire::profinet::blocks::module_diff::{ArInfo, IdentInfo, ModuleDiffBlock, ModuleState, SubmoduleState};
use wire::profinet::blocks::physical::{MultipleBlock, PortDataReal};
use wire::profinet::dcp::DcpValue;
use wire::profinet::status::AbortReason;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profinet],
        deviations: bugs! {
            // Discovery
            "name-prefix-answered" "A DCP Identify with a prefix of the name is answered."
                => |d| d.stack.check(|check, right| match check { StackCheck::IdentifyName(name, requested) => name.starts_with(requested), _ => right });
            "any-name-answered" "A DCP Identify with any name is answered."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IdentifyName(..)));
            "all-stations-answered-once" "Only the first DCP Identify for all stations is answered."
                => |d| {
                    let mut is_first = true;
                    d.stack.check(move |check, right| right && (check != StackCheck::IdentifyAll || mem::take(&mut is_first)));
                };
            "nameless-answers-all" "A device without a name answers a DCP Identify with any name."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IdentifyName(b"", _)));
            "name-with-padding" "A name of odd length includes its padding byte."
                => |d| d.stack.element(|value| match value { DcpValue::NameOfStation(name) => DcpValue::NameOfStation(padded(name)), other => other });
            "station-type-of-the-stack" "The station type is that of a sample application."
                => |d| d.stack.element(|value| station_type(value, b"SAMPLE DEVICE"));
            "type-of-station-empty" "The station type is empty."
                => |d| d.stack.element(|value| station_type(value, b""));
            "mac-of-the-stack" "The MAC address has the OUI of the stack vendor."
                => |d| d.stack.mac(|Mac([_, _, _, d, e, f])| Mac([0x00, 0x0E, 0xCF, d, e, f]));
            "mac-changes-with-reset" "A factory reset changes the MAC address."
                => |d| d.stack.mac({
                let mut resets = 0..;
                move |Mac([a, b, c, d, e, f])| Mac([a, b, c, d, e, f.wrapping_add(resets.next().unwrap_or(0))])
            });

            // DCP Set
            "set-of-others-taken" "A DCP Set to another device is accepted."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Addressed(_)));
            "mask-ignored" "The subnet mask of a DCP Set is not applied."
                => |d| d.stack.set_station(|before, now, stored| (now.mask, stored.mask) = (before.mask, before.mask));
            "address-after-restart-only" "An IP address set by DCP is used only after the next power-up."
                => |d| d.stack.set_station(|before, now, _| (now.ip, now.mask, now.gateway) = (before.ip, before.mask, before.gateway));
            "name-after-restart-only" "A name set by DCP is used only after the next power-up."
                => |d| d.stack.set_station(|before, now, _| now.name = before.name.clone());
            "name-erases-address" "Setting the name erases the IP address."
                => |d| d.stack.set_station(|before, now, stored| {
                if now.name != before.name {
                    (now.ip, stored.ip) = ([0; 4], [0; 4]);
                }
            });
            "address-waits-for-dcp" "The stored IP address is not used until DCP sets one."
                => |d| d.stack.load_station(|_, station| (station.ip, station.mask, station.gateway) = ([0; 4], [0; 4], [0; 4]));
            "link-local-address" "Without an IP address the device uses a link-local one."
                => |d| d.stack.load_station(|_, station| {
                if station.ip == [0; 4] {
                    (station.ip, station.mask) = ([169, 254, 1, 1], [255, 255, 0, 0]);
                }
            });
            "arp-probe-ignored" "ARP probes for the IP address are not answered."
                => |d| d.stack.filter_frames(|_, frame| !is_arp_probe(frame));
            "temporary-name-kept" "A temporary name survives a power cycle."
                => |d| d.stack.set_station(|_, now, stored| stored.clone_from(now));
            "signal-refused" "DCP Signal is refused, and the LED does not flash."
                => |d| d.stack.check(|check, right| right && !matches!(check, StackCheck::Signal(_)));
            "reset-leaves-connection" "A station reset does not end the connection."
                => |d| d.stack.set(StackCheck::Ends(AbortReason::RESET_TO_FACTORY), false);
            "reset-answered-and-not-done" "A reset is answered positively but not carried out."
                => |d| d.stack.add(OnlyAnswersReset::default());
            "silent-after-reset" "After a reset the device does not answer until the next power-up."
                => |d| d.stack.add(SilentAfterReset::default());
            "name-back-after-reset" "The name from before a factory reset is restored after 5 s."
                => |d| d.stack.add(NameReturns::default());

            // LLDP
            "neighbours-not-reported" "LLDP is not sent."
                => |d| d.stack.lldp(|_| false);
            "not-announced-without-name" "Without a name LLDP is not sent."
                => |d| d.stack.lldp(|lldp| !is_nameless(lldp));
            "lldp-reports-old-name" "LLDP announces the name from before the last change."
                => |d| d.stack.add(AnnouncesFirstName::default());
            "neighbour-not-reported" "The neighbour is not reported in any record."
                => |d| d.stack.filter_frames(|_, frame| !is_lldp(frame));
            "second-port-announced" "A second port is reported that does not exist."
                => |d| d.stack.plugs(add_port);
            "half-duplex-reported" "The link is reported as half duplex."
                => |d| half_duplex_reported(&mut d.stack);
            "lldp-reports-the-other-port" "LLDP at the first port announces the port ID of the second one."
                => |d| d.stack.lldp(|lldp| { renumber(lldp); true });

            // Connect
            "ident-not-checked" "The ident numbers of submodules are not checked."
                => |d| d.stack.connect(with_idents_of_plugs);
            "module-difference-not-reported" "Connect and ApplicationReady do not report that other modules are plugged."
                => |d| d.stack.difference(|_, differing| *differing = None);
            "output-length-not-checked" "Connect does not compare the length of the outputs."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::OutputLength(_)));
            "input-length-not-checked" "Connect does not compare the length of the inputs."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::InputLength(_)));
            "rt-class-1-refused" "A Connect with RT class 1 is refused."
                => |d| d.stack.check(|check, right| right && !is_class_field(check, RtClass::RT_CLASS_1));
            "rt-class-3-accepted" "A Connect with RT class 3 is accepted, but no cyclic data are sent."
                => |d| d.stack.check(|check, right| right || is_class_field(check, RtClass::RT_CLASS_3));
            "other-frame-id" "The inputs are sent with another frame ID than agreed."
                => |d| d.stack.inputs(|frame| frame[1] = frame[1].wrapping_add(1));
            "second-controller-served" "A second controller gets a connection to the same submodules."
                => |d| d.stack.check(|check, right| match check { StackCheck::ConnectionLimit { is_exchange: true, others } => others < 2, StackCheck::OwnedByOther(..) => false, _ => right });
            "fourth-connection-refused" "After three connections every further Connect is refused."
                => |d| d.stack.add(ThreeConnectionsOnly::default());
            "proper-module-called-substitute" "Connect and ApplicationReady report proper modules as substitutes."
                => |d| d.stack.difference(call_proper_modules_substitutes);
        },
    },
    Group {
        needs: &[Need::Profinet, Need::EncoderProfile],
        deviations: bugs! {
            "encoder-in-slot-0" "The encoder is in slot 0."
                => |d| d.stack.plugs(|plugs| plugs.iter_mut().for_each(|plug| plug.slot = 0));
            "encoder-in-api-0" "The encoder is in API 0 instead of the API of the encoder profile."
                => |d| d.stack.plugs(|plugs| plugs.iter_mut().for_each(|plug| plug.api = 0));
            "access-point-with-data" "Submodules without cyclic data report two input bytes."
                => |d| d.stack.plugs(|plugs| {
                let is_blank = |plug: &&mut PluggableSubmodule| plug.slot != 0 && (plug.input_octets, plug.output_octets) == (0, 0);
                plugs.iter_mut().filter(is_blank).for_each(|plug| plug.input_octets = 2);
            });
            "dap-1-accepted" "Access point 1 is accepted."
                => |d| d.stack.plugs(|plugs| add_access_point(plugs, |_| 1));
            "outputs-held-after-loss" "The encoder continues to use the last outputs after the end of the connection."
                => |d| {
                d.stack.set(StackCheck::OutputsEnd, false);
                d.encoder.add(HeldRequests::over_connections());
            };
            "im0-profile-of-drives" "The profile ID in I&M0 is that of PROFIdrive, 3A00h."
                => |d| d.stack.im0(|im0| im0.profile_id = 0x3A00);
            "long-name-cut" "A name of more than 127 characters is accepted and truncated."
                => |d| {
                d.stack.check(|check, right| match check {
                    StackCheck::Name(name) => name.is_empty() || name.split(|octet| *octet == b'.').all(|label| !label.is_empty() && accepts(label, 127)),
                    _ => right,
                });
                d.stack.set_station(|_, now, stored| {
                    now.name.truncate(127);
                    stored.name.truncate(127);
                });
            };
        },
    },
    Group {
        needs: &[Need::Of(&manuals::LIKA_XAC77)],
        deviations: bugs! {
            "other-variant-accepted" "The access point of the other variant is accepted."
                => |d| d.stack.plugs(|plugs| add_access_point(plugs, |own| 5 - own));
        },
    },
    Group {
        needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)],
        deviations: bugs! {
            "parameter-submodule-with-data" "The parameter access point has two input bytes."
                => |d| d.stack.plugs(|plugs| {
                plugs.iter_mut().filter(|plug| (plug.slot, plug.subslot) == (1, 1)).for_each(|plug| plug.input_octets = 2);
            });
            "universal-without-mt-pos" "The universal module lacks the submodule with the revolutions."
                => |d| d.stack.plugs(|plugs| plugs.retain(|plug| (plug.module_ident, plug.submodule_ident) != (0x30, 0x103)));
            "record-in-every-api" "Records are also served in API 0."
                => |d| d.stack.access(|access| if !is_of_stack(access.index) { access.api = 0x3D00 });
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

fn station_type(value: DcpValue, other: &[u8]) -> DcpValue {
    if matches!(value, DcpValue::Vendor(_)) { DcpValue::Vendor(other.to_vec()) } else { value }
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

/// Announces port 2 instead of port 1.
fn renumber(lldp: &mut Lldp) {
    for tlv in &mut lldp.tlvs {
        if let Tlv::PortId { id, .. } = tlv {
            id.splice(..8, *b"port-002");
        }
    }
}

/// dot3MauType of 100BASE-TX full duplex.
const FULL_DUPLEX: u16 = 16;
/// dot3MauType of 100BASE-TX half duplex.
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
fn add_port(plugs: &mut Vec<PluggableSubmodule>) {
    if let Some(last) = plugs.last().copied() {
        plugs.push(PluggableSubmodule { subslot: last.subslot + 1, submodule_ident: last.submodule_ident + 1, ..last });
    }
}

/// Adds the submodules of slot 0 again, with another module ident.
fn add_access_point(plugs: &mut Vec<PluggableSubmodule>, other: fn(u32) -> u32) {
    let head: Vec<PluggableSubmodule> = plugs.iter().filter(|plug| plug.slot == 0).copied().collect();
    plugs.extend(head.iter().map(|plug| PluggableSubmodule { module_ident: other(plug.module_ident), ..*plug }));
}

/// Replaces each expected submodule ident that cannot be plugged by the ident that is plugged there.
fn with_idents_of_plugs(view: &StackView<'_>, connect: &mut Connect) {
    for block in &mut connect.blocks {
        let ConnectContent::ExpectedSubmodule(expected) = &mut block.content else { continue };
        for module in &mut expected.modules {
            for submodule in &mut module.submodules {
                let place = (module.api, module.slot_number, submodule.subslot_number);
                let idents = (module.module_ident_number, submodule.submodule_ident_number);
                let is_at = |plug: &&PluggableSubmodule| (plug.api, plug.slot, plug.subslot) == place;
                let mut possible = view.application.plugs().iter().chain(view.plugged).filter(is_at);
                let is_possible = possible.any(|plug| (plug.module_ident, plug.submodule_ident) == idents);
                if let Some(plug) = view.plugged.iter().find(is_at).filter(|_| !is_possible) {
                    submodule.submodule_ident_number = plug.submodule_ident;
                }
            }
        }
    }
}

fn call_proper_modules_substitutes(all: &ModuleDiffBlock, differing: &mut Option<ModuleDiffBlock>) {
    let reported = differing.get_or_insert_with(|| all.clone());
    let modules = reported.apis.iter_mut().flat_map(|api| &mut api.modules);
    for module in modules.filter(|module| module.state == ModuleState::PROPER_MODULE) {
        module.state = ModuleState::SUBSTITUTE;
        let state = SubmoduleState::new(IdentInfo::SUBSTITUTE, ArInfo::OWN, 0);
        module.submodules.iter_mut().for_each(|submodule| submodule.state = state);
    }
}

/// Number of the field IOCRProperties in an IOCRBlockReq, counting the header.
const IOCR_PROPERTIES: u8 = 7;

/// Whether a check is about the properties of an IOCR of this class.
fn is_class_field(check: StackCheck<'_>, class: RtClass) -> bool {
    matches!(check, StackCheck::IocrField(iocr, IOCR_PROPERTIES) if iocr.iocr_properties.rt_class() == class)
}
