//! The controller's own presence: it answers DCP Identify and announces itself by LLDP.

use super::request::ControllerSettings;
use alloc::vec::Vec;
use station::Outbox;
use wire::ethernet::Mac;
use wire::lldp::{Lldp, Tlv};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockInfo, Dcp, DcpBlock, DcpValue, ServiceId};
use wire::profinet::rt::FrameId;

/// Bit 1 of the device role: IO controller.
const IO_CONTROLLER: u8 = 0x02;
/// TTL of the announcement, in seconds.
const TIME_TO_LIVE: u16 = 20;

/// Answers `request` from `from` if it is an Identify request that matches this controller.
pub(super) fn identify(settings: &ControllerSettings, from: Mac, request: &Dcp, out: &mut Outbox) {
    if (request.frame_id, request.service_id) != (FrameId::DCP_IDENTIFY_REQUEST, ServiceId::IDENTIFY) {
        return;
    }
    let ControllerSettings { mac, vendor_id, device_id, .. } = *settings;
    let ip = IpParameter { address: settings.ip, mask: settings.mask, gateway: settings.gateway };
    let values = [
        DcpValue::NameOfStation(settings.station_name.clone()),
        DcpValue::IpParameter(ip),
        DcpValue::DeviceId { vendor_id, device_id },
        DcpValue::DeviceRole { role: IO_CONTROLLER, reserved: 0 },
    ];
    let fits = |filter: &DcpBlock| filter.value == DcpValue::AllSelector || values.contains(&filter.value);
    if request.blocks().is_empty() || !request.blocks().iter().all(fits) {
        return;
    }
    let info =
        |value: &DcpValue| if matches!(value, DcpValue::IpParameter(_)) { BlockInfo::IP_SET } else { BlockInfo::NONE };
    let blocks = values.into_iter().map(|value| DcpBlock::report(info(&value), value)).collect();
    out.push_with(|octets| request.response(blocks).write_frame(from, mac, octets));
}

/// Announces the controller to its neighbour; an empty `chassis` stands for its name of station.
pub(super) fn announce(settings: &ControllerSettings, chassis: &[u8], port: &[u8], out: &mut Outbox) {
    let chassis: Vec<u8> = if chassis.is_empty() { settings.station_name.clone() } else { chassis.into() };
    let lldp = Lldp {
        tlvs: [
            Tlv::ChassisId { subtype: Tlv::LOCALLY_ASSIGNED, id: chassis },
            Tlv::PortId { subtype: Tlv::LOCALLY_ASSIGNED, id: port.into() },
            Tlv::TimeToLive(TIME_TO_LIVE),
            Tlv::PortStatus { rt_class_2: 0, rt_class_3: 0 },
            Tlv::ChassisMac(settings.mac),
        ]
        .into(),
    };
    out.push_with(|octets| lldp.write_frame(settings.mac, octets));
}
