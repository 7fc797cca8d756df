//! The endpoint mapper. The device registers one interface, that of an IO device.

use super::server::{RpcCall, RpcReply};
use crate::profinet::IoIdentity;
use alloc::format;
use alloc::vec::Vec;
use wire::octets::ByteOrder;
use wire::profinet::rpc::{
    self, EndpointEntry, InquiryType, LookupHandle, LookupRequest, LookupResponse, ObjectUuid, RejectStatus, Tower,
    Uuid,
};

/// The entry of the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in super::super) struct MapperEntry {
    /// The object UUID of the device.
    pub object: Uuid,
    /// The annotation, 64 bytes.
    pub annotation: Vec<u8>,
}

impl MapperEntry {
    /// The entry of a device with this identity.
    ///
    /// The annotation is the device type (25 bytes), the order number (20), the hardware revision (5) and the
    /// software revision (a letter and three numbers of three digits), separated by blanks and terminated by a zero
    /// byte.
    pub(in super::super) fn new(identity: &IoIdentity) -> MapperEntry {
        let [prefix, functional, fix, internal] = identity.software_revision;
        let (kind, order_id, hardware) = (identity.station_type, identity.order_id, identity.hardware_revision);
        let prefix = char::from(prefix);
        let text =
            format!("{kind:<25.25} {order_id:<20.20} {hardware:>5} {prefix}{functional:>3}{fix:>3}{internal:>3}");
        let mut annotation = text.into_bytes();
        annotation.resize(63, b' ');
        annotation.push(0);
        let object = ObjectUuid { instance: 1, device_id: identity.device_id, vendor_id: identity.vendor_id };
        MapperEntry { object: object.into(), annotation }
    }
}

/// Answers a lookup: the entry for a nil handle, then `NOT_REGISTERED`.
pub(super) fn lookup(request: &RpcCall, order: ByteOrder, registered: &MapperEntry, address: [u8; 4]) -> RpcReply {
    let Ok(lookup) = LookupRequest::parse(request.header.order(), &request.body) else {
        return RpcReply::Fault(RejectStatus::FAULT_NDR);
    };
    let by_interface = lookup.interface.is_some_and(|(_, interface, ..)| interface == Uuid::DEVICE_INTERFACE);
    let by_object = lookup.object.is_some_and(|(_, object)| object == registered.object);
    let matches = match lookup.inquiry_type {
        InquiryType::ALL => true,
        InquiryType::BY_INTERFACE => by_interface,
        InquiryType::BY_OBJECT => by_object,
        InquiryType::BY_BOTH => by_interface && by_object,
        _ => false,
    };
    let mut response = LookupResponse {
        handle: LookupHandle::default(),
        max_entries: lookup.max_entries,
        entries: Vec::new(),
        status: LookupResponse::NOT_REGISTERED,
    };
    if matches && lookup.handle.uuid.is_nil() && lookup.max_entries > 0 {
        response.handle.uuid = registered.object;
        response.status = 0;
        response.entries.push(EndpointEntry {
            object: registered.object,
            tower: Some(Tower::udp(Uuid::DEVICE_INTERFACE, 1, 0, rpc::PORT, address)),
            annotation: registered.annotation.clone(),
        });
    }
    let mut body = Vec::new();
    response.write(&mut body, order);
    RpcReply::Response(body)
}
