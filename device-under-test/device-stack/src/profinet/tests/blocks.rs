//! The blocks of a Connect that a conforming device accepts. Tests make single fields invalid.

use super::bench::{AR, CONTROLLER};
use super::toy::API;
use alloc::vec::Vec;
use wire::ethernet::Mac;
use wire::profinet::blocks::connect::{
    AlarmCrBlockReq, ArBlockReq, ArProperties, ArType, Connect, ConnectContent, DataDescription, ExpectedModule,
    ExpectedSubmodule, ExpectedSubmoduleBlockReq, FrameObject, IocrApi, IocrBlockReq, IocrType, RtClass, SubmoduleType,
};
use wire::profinet::rpc::{ObjectUuid, Uuid};

pub fn ar_block() -> ArBlockReq {
    ArBlockReq {
        ar_type: ArType::IOCAR_SINGLE,
        ar_uuid: AR,
        session_key: 1,
        cm_initiator_mac_add: CONTROLLER,
        cm_initiator_object_uuid: ObjectUuid { instance: 1, device_id: 2, vendor_id: 0x0239 }.into(),
        ar_properties: ArProperties::ACTIVE | ArProperties::PARAMETRIZATION_BY_INITIATOR,
        cm_initiator_activity_timeout_factor: 600,
        initiator_udp_rt_port: 0x8892,
        cm_initiator_station_name: b"controller".to_vec(),
    }
}

pub fn iocr(iocr_type: IocrType) -> IocrBlockReq {
    let is_input = iocr_type == IocrType::INPUT;
    IocrBlockReq {
        iocr_type,
        iocr_reference: if is_input { 1 } else { 2 },
        lt: 0x8892,
        iocr_properties: RtClass::RT_CLASS_2.into(),
        data_length: 40,
        frame_id: if is_input { 0x8001 } else { 0xFFFF },
        send_clock_factor: 32,
        reduction_ratio: 2,
        phase: 1,
        sequence: 0,
        frame_send_offset: u32::MAX,
        watchdog_factor: 3,
        data_hold_factor: 3,
        iocr_tag_header: 0xC000,
        iocr_multicast_mac_add: Mac::ZERO,
        apis: Vec::new(),
    }
}

pub fn alarm_cr() -> AlarmCrBlockReq {
    AlarmCrBlockReq {
        alarm_cr_type: 1,
        lt: 0x8892,
        alarm_cr_properties: Default::default(),
        rta_timeout_factor: 1,
        rta_retries: 3,
        local_alarm_reference: 5,
        max_alarm_data_length: 200,
        alarm_cr_tag_header_high: 0xC000,
        alarm_cr_tag_header_low: 0xA000,
    }
}

pub fn submodule(subslot: u16, ident: u32, kind: SubmoduleType, input: u16, output: u16) -> ExpectedSubmodule {
    let mut data_descriptions = Vec::new();
    if kind != SubmoduleType::OUTPUT {
        data_descriptions.push(DataDescription::input(input));
    }
    if matches!(kind, SubmoduleType::OUTPUT | SubmoduleType::INPUT_OUTPUT) {
        data_descriptions.push(DataDescription::output(output));
    }
    ExpectedSubmodule {
        subslot_number: subslot,
        submodule_ident_number: ident,
        submodule_properties: kind.into(),
        data_descriptions,
    }
}

pub fn module(api: u32, slot: u16, ident: u32, submodules: Vec<ExpectedSubmodule>) -> ExpectedModule {
    ExpectedModule { api, slot_number: slot, module_ident_number: ident, module_properties: 0, submodules }
}

pub fn modules() -> Vec<ExpectedModule> {
    let none = SubmoduleType::NO_IO;
    alloc::vec![
        module(
            0,
            0,
            1,
            alloc::vec![
                submodule(1, 1, none, 0, 0),
                submodule(0x8000, 0x8000, none, 0, 0),
                submodule(0x8001, 0x8001, none, 0, 0),
                submodule(0x8002, 0x8002, none, 0, 0),
            ]
        ),
        module(
            API,
            1,
            1,
            alloc::vec![submodule(1, 2, none, 0, 0), submodule(2, 83, SubmoduleType::INPUT_OUTPUT, 16, 4),]
        ),
    ]
}

/// The blocks of a Connect with `modules`. The data are contiguous; those of the telegram come first in both frames.
pub fn connect_blocks(modules: &[ExpectedModule]) -> Vec<ConnectContent> {
    let (mut inputs, mut outputs) = (iocr(IocrType::INPUT), iocr(IocrType::OUTPUT));
    let (mut input_at, mut output_at) = (0, 0);
    let mut ordered: Vec<&ExpectedModule> = modules.iter().collect();
    ordered.sort_by_key(|module| u32::MAX - module.api);
    for module in ordered {
        let mut input = IocrApi { api: module.api, ..IocrApi::default() };
        let mut output = IocrApi { api: module.api, ..IocrApi::default() };
        let mut submodules: Vec<&ExpectedSubmodule> = module.submodules.iter().collect();
        submodules.sort_by_key(|submodule| 3 - submodule.submodule_properties.submodule_type().0);
        for submodule in submodules {
            let object = |frame_offset| FrameObject {
                slot_number: module.slot_number,
                subslot_number: submodule.subslot_number,
                frame_offset,
            };
            for description in &submodule.data_descriptions {
                if description.is_output() {
                    input.iocs.push(object(input_at));
                    input_at += 1;
                } else {
                    input.io_data_objects.push(object(input_at));
                    input_at += description.submodule_data_length + 1;
                }
            }
            for description in submodule.data_descriptions.iter().rev() {
                if description.is_output() {
                    output.io_data_objects.push(object(output_at));
                    output_at += description.submodule_data_length + 1;
                } else {
                    output.iocs.push(object(output_at));
                    output_at += 1;
                }
            }
        }
        inputs.apis.push(input);
        outputs.apis.push(output);
    }
    let mut blocks = alloc::vec![
        ConnectContent::ArReq(ar_block()),
        ConnectContent::IocrReq(inputs),
        ConnectContent::IocrReq(outputs)
    ];
    for module in modules {
        blocks.push(ConnectContent::ExpectedSubmodule(ExpectedSubmoduleBlockReq {
            modules: alloc::vec![module.clone()],
        }));
    }
    blocks.push(ConnectContent::AlarmCrReq(alarm_cr()));
    blocks
}

pub fn full_connect() -> Connect {
    Connect::of(connect_blocks(&modules()))
}

/// A Connect for records only.
pub fn access_connect(uuid: Uuid) -> Connect {
    let properties = ArProperties::ACTIVE | ArProperties::DEVICE_ACCESS;
    Connect::of([ConnectContent::ArReq(ArBlockReq {
        ar_type: ArType::IOSAR,
        ar_uuid: uuid,
        ar_properties: properties | ArProperties::PARAMETRIZATION_BY_INITIATOR,
        ..ar_block()
    })])
}
