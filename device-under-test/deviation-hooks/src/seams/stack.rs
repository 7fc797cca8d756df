//! Deviations at the hooks of a PROFINET stack.

use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{
    ArEvent, DiagnosisChange, IoIdentity, MibObject, PluggableSubmodule, RecordAccess, SnmpAnswer, StackCheck,
    StackHooks, StackView, StationData, StationLoad,
};
use station::Time;
use wire::datagram::Datagram;
use wire::ethernet::{EtherType, FrameHeader, Mac, pad};
use wire::lldp::{Lldp, Tlv};
use wire::octets::ByteOrder;
use wire::profinet::alarm::AlarmNotification;
use wire::profinet::blocks::connect::Connect;
use wire::profinet::blocks::im::Im0;
use wire::profinet::blocks::module_diff::ModuleDiffBlock;
use wire::profinet::dcp::{Dcp, DcpBlock, DcpValue, ServiceId, ServiceType};
use wire::profinet::rpc::{NdrRequest, Opnum, RpcHeader};
use wire::profinet::rt::{FrameId, IoxS};
use wire::profinet::status::{AbortReason, PnioStatus, RecordError};
use wire::snmp;

hooks! { Stack: StackHooks
    /// Changes a decision, given the check and the decision of the stack.
    check(check: StackCheck<'_>) -> bool;
    /// Replaces a received frame by any number of frames.
    received_frames(view: &StackView<'_>) -> Vec<Vec<u8>>;
    /// Changes each frame that the stack sends; an empty one is not sent.
    sent_frame(view: &StackView<'_>, frame: &mut Vec<u8>);
    /// When the next frame that is held back is due.
    due() -> Option<Time>;
    /// Appends the received frames that are due now.
    late_received(now: Time, frames: &mut Vec<Vec<u8>>);
    /// Appends the frames to send that are due now.
    late_sent(now: Time, frames: &mut Vec<Vec<u8>>);
    /// Changes the byte order of RPC and NDR headers, given that of the request.
    byte_order() -> ByteOrder;
    /// Changes the status and the blocks of the answer to an RPC call.
    answer(header: &RpcHeader, status: &mut PnioStatus, blocks: &mut Vec<u8>);
    /// Changes the UDP port from which the device calls the controller.
    client_port() -> u16;
    /// Changes the FrameID of the outputs that the device chooses.
    chosen_frame_id() -> u16;
    /// Changes the LocalAlarmReference of the device.
    alarm_reference() -> u16;
    /// Changes each IOPS and IOCS of the inputs frame.
    status() -> IoxS;
    /// Changes the identification data, at each start.
    identity(identity: &mut IoIdentity);
    /// Changes the body of each RPC call.
    call(view: &StackView<'_>, header: &RpcHeader, body: &mut Vec<u8>);
    /// Changes which record is accessed.
    access(access: &mut RecordAccess);
    /// Changes the result of each record read.
    read(access: RecordAccess, result: &mut Result<Vec<u8>, RecordError>);
    /// Changes the result of each record write.
    written(access: RecordAccess, data: &[u8], result: &mut Result<(), RecordError>);
    /// Changes the objects of the SNMP agent, in the order of their names.
    snmp_objects(objects: &mut Vec<MibObject>);
    /// Changes each response of the SNMP agent.
    snmp_answer(answer: &mut SnmpAnswer);
    /// Changes the value of each DCP element.
    element() -> DcpValue;
    /// Changes the MAC address, at the start and after each reset by DCP.
    mac() -> Mac;
    /// Changes the stored name and addresses as they come into use.
    load_station(start: StationLoad, station: &mut StationData);
    /// Changes the result of a DCP Set, given the previous data: the station data in use and the stored ones.
    set_station(before: &StationData, station: &mut StationData, stored: &mut StationData);
    /// Changes which submodules can be plugged.
    plugs(plugs: &mut Vec<PluggableSubmodule>);
    /// Changes the ModuleDiffBlock, given the comparison of all modules.
    difference(all: &ModuleDiffBlock, differing: &mut Option<ModuleDiffBlock>);
    /// Changes the outputs that a submodule receives.
    outputs(slot: u16, subslot: u16, data: &mut Option<Vec<u8>>);
    /// Changes the data hold time.
    data_hold_time() -> Duration;
    /// Changes each diagnosis that appears or disappears; with `false` the stack is not informed.
    diagnosis(change: &mut DiagnosisChange) -> bool;
    /// Changes each alarm; with `false` it is not sent.
    alarm(alarm: &mut AlarmNotification) -> bool;
    /// Changes the sequence number in each ApplicationReady for a plugged or released submodule; with `None` it is not sent.
    plug_ready() -> Option<u16>;
    /// Is called when a connection begins or ends.
    connection(event: ArEvent);
    /// Changes the reason of the ERR-RTA for a released connection.
    release_error() -> Option<AbortReason>;
    /// Ends all connections with `true`; called after each event.
    aborts() -> bool;
}

impl Stack {
    /// Fixes the result of a check.
    pub fn set(&mut self, of: StackCheck<'static>, verdict: bool) {
        self.check(move |check, right| if check == of { verdict } else { right });
    }

    /// Drops the frames for which `receives` returns `false`.
    pub fn filter_frames(&mut self, mut receives: impl FnMut(&StackView<'_>, &[u8]) -> bool + 'static) {
        self.received_frames(move |view, mut frames| {
            frames.retain(|frame| receives(view, frame));
            frames
        });
    }

    /// Drops what is sent to the SNMP agent.
    pub fn drop_snmp(&mut self) {
        self.filter_frames(|_, frame| {
            Datagram::parse(frame).map_or(true, |datagram| datagram.destination.port() != snmp::PORT)
        });
    }

    /// Changes each response to a DCP Get.
    pub fn get_response(&mut self, mut change: impl FnMut(&mut DcpValue) + 'static) {
        self.sent_frame(move |_, frame| {
            change_dcp(frame, |dcp, blocks| {
                if (dcp.service_id, dcp.service_type) == (ServiceId::GET, ServiceType::RESPONSE) {
                    blocks.iter_mut().for_each(|block| change(&mut block.value));
                }
            });
        });
    }

    /// Changes each LLDP frame; with `false` it is not sent.
    pub fn lldp(&mut self, mut change: impl FnMut(&mut Lldp) -> bool + 'static) {
        self.sent_frame(move |_, frame| change_lldp(frame, &mut change));
    }

    /// Changes each frame that the device sends on its way to the controller, as a switch or an adapter does.
    pub fn on_the_way(&mut self, change: impl FnMut(&mut Vec<u8>) + 'static) {
        struct OnTheWay<F>(F);

        impl<F: FnMut(&mut Vec<u8>)> StackHooks for OnTheWay<F> {
            fn sent_frame(&mut self, _: &StackView<'_>, frame: &mut Vec<u8>) {
                (self.0)(frame);
            }
        }

        self.add_last(OnTheWay(change));
    }

    /// Changes each cyclic frame that the stack sends, starting at its frame ID.
    pub fn inputs(&mut self, mut change: impl FnMut(&mut [u8]) + 'static) {
        self.sent_frame(move |_, frame| {
            if let Some(at) = cyclic(frame) {
                change(&mut frame[at..]);
            }
        });
    }

    /// Changes the blocks of each RPC call of this operation.
    pub fn blocks(&mut self, of: Opnum, mut change: impl FnMut(&StackView<'_>, &mut Vec<u8>) + 'static) {
        self.call(move |view, header, body| {
            let order = header.order();
            let Ok((ndr, blocks)) = NdrRequest::parse(order, body).map(|(ndr, blocks)| (ndr, blocks.to_vec())) else {
                return;
            };
            let mut changed = blocks.clone();
            change(view, &mut changed);
            if header.opnum == of && changed != blocks {
                *body = NdrRequest::body(order, ndr.args_maximum, &changed);
            }
        });
    }

    /// Changes each Connect.
    pub fn connect(&mut self, mut change: impl FnMut(&StackView<'_>, &mut Connect) + 'static) {
        self.blocks(Opnum::CONNECT, move |view, blocks| {
            let Ok(connect) = Connect::parse(blocks) else { return };
            let mut changed = connect.clone();
            change(view, &mut changed);
            if changed != connect {
                *blocks = changed.to_vec();
            }
        });
    }

    /// Changes the bytes of each record that was read, given its index.
    pub fn record(&mut self, mut change: impl FnMut(u16, &mut Vec<u8>) + 'static) {
        self.read(move |access, result| {
            if let Ok(data) = result {
                change(access.index, data);
            }
        });
    }

    /// Changes I&M0.
    pub fn im0(&mut self, mut change: impl FnMut(&mut Im0) + 'static) {
        self.record(move |index, data| {
            if let Some(mut im0) = Im0::parse(data).ok().filter(|_| index == IM0) {
                change(&mut im0);
                data.clear();
                im0.write(data);
            }
        });
    }

    /// Changes the bytes of I&M0, including its header.
    pub fn im0_octets(&mut self, mut change: impl FnMut(&mut Vec<u8>) + 'static) {
        self.record(move |index, data| {
            if index == IM0 {
                change(data);
            }
        });
    }

    /// Ends all connections when such a frame is received.
    pub fn abort_at(&mut self, is_harmful: impl FnMut(&StackView<'_>, &[u8]) -> bool + 'static) {
        self.add(AbortsAt { is_harmful, aborts: false });
    }
}

struct AbortsAt<F> {
    is_harmful: F,
    aborts: bool,
}

impl<F: FnMut(&StackView<'_>, &[u8]) -> bool> StackHooks for AbortsAt<F> {
    fn received_frames(&mut self, view: &StackView<'_>, frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        self.aborts |= frames.iter().any(|frame| (self.is_harmful)(view, frame));
        frames
    }

    fn aborts(&mut self, aborts: bool) -> bool {
        core::mem::take(&mut self.aborts) || aborts
    }
}

/// Record index of I&M0.
pub const IM0: u16 = 0xAFF0;

/// Whether the stack serves the record with this index, not the application.
pub fn is_of_stack(index: u16) -> bool {
    matches!(
        index,
        0x8000 | 0x8001 | 0x800A..=0x800C | 0x802A | 0x8080 | 0xAFF0..=0xAFF3 | 0xC000 | 0xC001 | 0xC00A..=0xC00C | 0xE000..
    )
}

/// Parses a PROFINET frame: its Ethernet header, the offset of its frame ID, and the frame ID.
pub fn profinet(frame: &[u8]) -> Option<(FrameHeader, usize, FrameId)> {
    let (header, payload) = FrameHeader::parse(frame).ok()?;
    let frame_id = FrameId::peek(payload).ok().filter(|_| header.ether_type == EtherType::PROFINET)?;
    Some((header, frame.len() - payload.len(), frame_id))
}

/// The offset of the frame ID in a cyclic frame; `None` for other frames.
pub fn cyclic(frame: &[u8]) -> Option<usize> {
    profinet(frame).filter(|(.., frame_id)| frame_id.is_cyclic()).map(|(_, at, _)| at)
}

/// Parses a DCP frame, with its Ethernet header.
pub fn dcp(frame: &[u8]) -> Option<(FrameHeader, Dcp)> {
    let (header, at, _) = profinet(frame)?;
    Some((header, Dcp::parse(&frame[at..]).ok()?))
}

/// Changes the blocks of a DCP frame.
pub fn change_dcp(frame: &mut Vec<u8>, change: impl FnOnce(&Dcp, &mut Vec<DcpBlock>)) {
    use wire::profinet::dcp::DcpBody;
    let Some((header, of)) = dcp(frame) else { return };
    let mut blocks = of.blocks().to_vec();
    change(&of, &mut blocks);
    if blocks != of.blocks() {
        frame.clear();
        Dcp { body: DcpBody::Blocks(blocks), ..of }.write_frame(header.destination, header.source, frame);
    }
}

/// Changes an LLDP frame; with `false` it is not sent.
pub fn change_lldp(frame: &mut Vec<u8>, change: impl FnOnce(&mut Lldp) -> bool) {
    let Ok((header, payload)) = FrameHeader::parse(frame) else { return };
    let Some(mut lldp) = Lldp::parse(payload).ok().filter(|_| header.ether_type == EtherType::LLDP) else { return };
    let is_sent = change(&mut lldp);
    frame.clear();
    if is_sent {
        lldp.write_frame(header.source, frame);
        pad(frame, 0);
    }
}

/// Sets the station name that an LLDP frame announces.
pub fn rename(lldp: &mut Lldp, name: &[u8]) {
    let mac = lldp.tlvs.iter().find_map(|tlv| if let Tlv::ChassisMac(mac) = tlv { Some(*mac) } else { None });
    for tlv in &mut lldp.tlvs {
        match tlv {
            Tlv::ChassisId { subtype, id } if name.is_empty() => {
                *subtype = Tlv::CHASSIS_MAC_ADDRESS;
                *id = mac.unwrap_or(Mac::ZERO).0.into();
            }
            Tlv::ChassisId { subtype, id } => (*subtype, *id) = (Tlv::LOCALLY_ASSIGNED, name.to_vec()),
            Tlv::PortId { id, .. } => {
                let port = id.split(|octet| *octet == b'.').next().unwrap_or_default().to_vec();
                *id = if name.is_empty() { port } else { [&port[..], b".", name].concat() };
            }
            _ => {}
        }
    }
}
