//! Evaluates Connect calls: stations, role, and the offsets of each submodule in the cyclic frames.

use super::tracker::COUNTER_STEP_NS;
use super::{Address, ArStage, CyclicStream, ObservedAr, Party, Role, SubmodulePlacement};
use plain_text::escaped;
use station::{Duration, Time};
use wire::ethernet::Mac;
use wire::profinet::blocks::connect::{ArType, Connect, ExpectedSubmodule, IocrApi, IocrBlockReq, IocrType};
use wire::profinet::rpc::{ObjectUuid, Uuid};

/// Internal data of a connection.
#[derive(Clone, Debug, Default)]
pub(super) struct ArLink {
    /// Source and destination address of the Connect frame.
    pub macs: (Mac, Mac),
    /// IOCRReference of the input CR.
    pub input_reference: Option<u16>,
    /// IOCRReference of the output CR.
    pub output_reference: Option<u16>,
    /// LocalAlarmReferences of controller and device.
    pub alarm_references: (Option<u16>, Option<u16>),
    /// The last DATA of each direction and priority: sequence number and hash of its bytes.
    pub last_data: [Option<(u16, u64)>; 4],
    /// Length of the stored start records in bytes.
    pub record_octets: usize,
}

/// The connection that a Connect request describes; `None` without an ARBlockReq.
///
/// `macs` are source and destination of the frame, `object` is the object UUID; then number and time of the frame.
pub(super) fn requested_connection(
    connect: &Connect,
    macs: (Mac, Mac),
    object: Uuid,
    (number, time): (u64, Time),
) -> Option<(ObservedAr, ArLink)> {
    let request = connect.ar_req()?;
    let iocr = |kind| connect.iocr_requests().find(|iocr| iocr.iocr_type == kind);
    let (input, output) = (iocr(IocrType::INPUT), iocr(IocrType::OUTPUT));
    let role = match (request.ar_type, input.or(output)) {
        (ArType::IOSAR, _) | (_, None) => Role::Access,
        _ => Role::Exchange,
    };
    let own = request.cm_initiator_mac_add;
    let controller = Party {
        address: Address::Mac(if own == Mac::ZERO || own.is_group() { macs.0 } else { own }),
        station: Some(escaped(&request.cm_initiator_station_name)).filter(|name| !name.is_empty()),
        ids: ids(request.cm_initiator_object_uuid),
        ident: None,
    };
    let device = Party { ids: ids(object), ..Party::at(Address::Mac(macs.1)) };
    let ar = ObservedAr {
        uuid: request.ar_uuid,
        role,
        submodules: placed(connect, input, output),
        stage: ArStage::Asked,
        connect_frame: Some(number),
        connect_time: Some(time),
        inputs: input.map(stream).unwrap_or_default(),
        outputs: output.map(stream).unwrap_or_default(),
        ..ObservedAr::between(controller, device)
    };
    let link = ArLink {
        macs,
        input_reference: input.map(|iocr| iocr.iocr_reference),
        output_reference: output.map(|iocr| iocr.iocr_reference),
        alarm_references: (connect.alarm_cr_req().map(|alarms| alarms.local_alarm_reference), None),
        ..ArLink::default()
    };
    Some((ar, link))
}

/// Vendor ID and device ID in the object UUID of a station.
pub(super) fn ids(uuid: Uuid) -> Option<(u16, u16)> {
    ObjectUuid::of(uuid).map(|object| (object.vendor_id, object.device_id))
}

/// A connection that was established before the trace began.
pub(super) fn established_connection(uuid: Uuid, controller: Mac, device: Mac) -> ObservedAr {
    let party = |mac| Party::at(Address::Mac(mac));
    ObservedAr { uuid, ..ObservedAr::between(party(controller), party(device)) }
}

/// Applies a positive Connect response: frame ids, alarm reference, station name.
pub(super) fn accepted(connect: &Connect, ar: &mut ObservedAr, link: &mut ArLink) {
    let frame_id = |kind, reference: Option<u16>, asked: u16| {
        let same = |iocr: &&_| {
            let wire::profinet::blocks::connect::IocrBlockRes { iocr_type, iocr_reference, .. } = **iocr;
            iocr_type == kind && Some(iocr_reference) == reference
        };
        connect.iocr_responses().find(same).map_or(asked, |iocr| iocr.frame_id)
    };
    ar.inputs.frame_id = frame_id(IocrType::INPUT, link.input_reference, ar.inputs.frame_id);
    ar.outputs.frame_id = frame_id(IocrType::OUTPUT, link.output_reference, ar.outputs.frame_id);
    link.alarm_references.1 = connect.alarm_cr_res().map(|alarms| alarms.local_alarm_reference);
    if let Some(answer) = connect.ar_res()
        && answer.cm_responder_mac_add != Mac::ZERO
        && !answer.cm_responder_mac_add.is_group()
    {
        ar.device.address = Address::Mac(answer.cm_responder_mac_add);
    }
    if let Some(server) = connect.ar_server_res().filter(|server| !server.cm_responder_station_name.is_empty()) {
        ar.device.station = Some(escaped(&server.cm_responder_station_name));
    }
    ar.stage = ArStage::Connected;
}

fn stream(iocr: &IocrBlockReq) -> CyclicStream {
    let clocks = u64::from(iocr.send_clock_factor) * u64::from(iocr.reduction_ratio);
    let cycle = Duration::from_nanos(clocks * COUNTER_STEP_NS);
    let factor = if iocr.data_hold_factor == 0 { iocr.watchdog_factor } else { iocr.data_hold_factor };
    CyclicStream {
        frame_id: iocr.frame_id,
        data_length: iocr.data_length.into(),
        cycle,
        watchdog: cycle * u32::from(factor),
        ..CyclicStream::default()
    }
}

fn placed(connect: &Connect, input: Option<&IocrBlockReq>, output: Option<&IocrBlockReq>) -> Vec<SubmodulePlacement> {
    let mut submodules = Vec::new();
    for module in connect.expected_modules() {
        for submodule in &module.submodules {
            let key = (module.api, module.slot_number, submodule.subslot_number);
            let data = |iocr: Option<&IocrBlockReq>| offset(iocr?, key, |api| &api.io_data_objects);
            let consumer = |iocr: Option<&IocrBlockReq>| offset(iocr?, key, |api| &api.iocs);
            let area = |at: Option<usize>, is_output| {
                let length = length(submodule, is_output);
                (at.filter(|_| length > 0).map(|at| at..at + length), at.map(|at| at + length))
            };
            let (input_data, input_status) = area(data(input), false);
            let (output_data, output_status) = area(data(output), true);
            submodules.push(SubmodulePlacement {
                api: module.api,
                slot: module.slot_number,
                subslot: submodule.subslot_number,
                module_ident: module.module_ident_number,
                submodule_ident: submodule.submodule_ident_number,
                input: input_data,
                input_status,
                input_consumer: consumer(output),
                output: output_data,
                output_status,
                output_consumer: consumer(input),
            });
        }
    }
    submodules
}

fn offset(
    iocr: &IocrBlockReq,
    (api, slot, subslot): (u32, u16, u16),
    list: fn(&IocrApi) -> &Vec<wire::profinet::blocks::connect::FrameObject>,
) -> Option<usize> {
    let objects = iocr.apis.iter().filter(|known| known.api == api).flat_map(list);
    let mut same = objects.filter(|object| (object.slot_number, object.subslot_number) == (slot, subslot));
    same.next().map(|object| object.frame_offset.into())
}

fn length(submodule: &ExpectedSubmodule, is_output: bool) -> usize {
    let mut descriptions = submodule.data_descriptions.iter();
    let description = descriptions.find(|description| description.is_output() == is_output);
    description.map_or(0, |description| description.submodule_data_length.into())
}
