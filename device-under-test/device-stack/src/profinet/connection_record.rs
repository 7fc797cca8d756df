//! The records with the connections of the station: 0xF020 and 0xF820 (ARData, block version 1.1).

use super::ar::DeviceAr;
use super::plugged::RecordScope;
use super::stack::Stack;
use alloc::vec::Vec;
use wire::octets::{Append, ByteOrder};
use wire::profinet::blocks::connect::{AlarmCrBlockReq, IocrBlockReq, IocrProperties, IocrType};
use wire::profinet::blocks::{BlockHeader, BlockType};
use wire::profinet::rt::DataStatus;

/// The UDP port for RT over UDP, which the device does not use.
pub(super) const UDP_RT_PORT: u16 = 0x8892;
/// Fields of 32 bits begin at a multiple of this many bytes from the start of the block.
const ALIGNMENT: usize = 4;
const UUID_LENGTH: usize = 16;

/// What a Connect agreed on about cyclic data and alarms.
#[derive(Debug)]
pub(super) struct AgreedExchange {
    /// RT class, direction and FrameID of each cyclic connection.
    pub iocrs: Vec<(IocrProperties, IocrType, u16)>,
    /// AlarmCRType, and the references of the initiator and of the device.
    pub alarms: (u16, u16, u16),
}

impl AgreedExchange {
    /// What was requested; `frame_id` gives the FrameID of an IOCR, and `reference` is that of the device for alarms.
    pub(super) fn new(
        iocrs: &[IocrBlockReq],
        alarm_cr: &AlarmCrBlockReq,
        reference: u16,
        frame_id: impl Fn(&IocrBlockReq) -> u16,
    ) -> AgreedExchange {
        let iocrs = iocrs.iter().map(|iocr| (iocr.iocr_properties, iocr.iocr_type, frame_id(iocr))).collect();
        AgreedExchange { iocrs, alarms: (alarm_cr.alarm_cr_type, alarm_cr.local_alarm_reference, reference) }
    }
}

impl Stack {
    /// Appends the ARData block with the connections that have a submodule in `scope`, and those for records only where the
    /// scope is the device.
    pub(super) fn write_connections(&self, scope: RecordScope<'_>, out: &mut Vec<u8>) {
        let is_listed = |ar: &&DeviceAr| {
            scope == RecordScope::Device || ar.expected.iter().any(|submodule| scope.contains(submodule.place))
        };
        let listed: Vec<&DeviceAr> = self.ars.iter().filter(is_listed).collect();
        let start = out.len();
        BlockHeader { kind: BlockType::AR_DATA, version_high: 1, version_low: 1 }.write_with(out, |out| {
            out.put_u16(listed.len() as u16);
            listed.iter().for_each(|ar| write_connection(ar, start, out));
        });
    }
}

/// Fills with zeros up to the next field of 32 bits of the block that begins at `start`.
fn align(start: usize, out: &mut Vec<u8>) {
    out.resize(start + (out.len() - start).next_multiple_of(ALIGNMENT), 0);
}

fn write_connection(ar: &DeviceAr, start: usize, out: &mut Vec<u8>) {
    let of = &ar.request;
    of.ar_uuid.write(out, ByteOrder::Big);
    of.cm_initiator_object_uuid.write(out, ByteOrder::Big);
    // No parameter server.
    out.put(&[0; UUID_LENGTH]);
    out.put_u32(of.ar_properties.0);
    out.put_u16(of.ar_type.0);
    let (alarm_cr_type, initiator, responder) = ar.agreed.as_ref().map_or((0, 0, 0), |agreed| agreed.alarms);
    [alarm_cr_type, initiator, responder, of.initiator_udp_rt_port, UDP_RT_PORT]
        .iter()
        .for_each(|word| out.put_u16(*word));
    out.put_u16(of.cm_initiator_station_name.len() as u16);
    out.put(&of.cm_initiator_station_name);
    align(start, out);
    // The name of the parameter server.
    out.put_u16(0);
    align(start, out);
    let iocrs = ar.agreed.as_ref().map_or(&[][..], |agreed| &agreed.iocrs);
    out.put_u16(iocrs.len() as u16);
    align(start, out);
    for (properties, direction, frame_id) in iocrs {
        out.put_u32(properties.0);
        out.put_u16(direction.0);
        out.put_u16(*frame_id);
        // The cycle counter and the transfer status may be 0.
        out.put(&[0, 0, DataStatus::NORMAL.0, 0]);
    }
    let mut apis: Vec<u32> = ar.expected.iter().map(|submodule| submodule.place.api).collect();
    apis.sort_unstable();
    apis.dedup();
    out.put_u16(apis.len() as u16);
    align(start, out);
    apis.iter().for_each(|api| out.put_u32(*api));
    // No more information.
    out.put_u16(0);
    align(start, out);
}
