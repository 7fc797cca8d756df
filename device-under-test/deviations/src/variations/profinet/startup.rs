//! Connections of a PROFINET device: the answer to Connect, refusals, Release, and the numbers that a device chooses.

use super::state::{blocks_in_order, changed_blocks, changed_contents, refuse};
use crate::needs::Need;
use crate::tables::Group;
use alloc::vec::Vec;
use device_stack::profinet::StackCheck;
use reference_devices::manuals::PROFINET_IO;
use wire::profinet::alarm::AlarmType;
use wire::profinet::blocks::connect::ConnectContent;
use wire::profinet::status::{AbortReason, CmrpcError};

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        // Only this suite connects a second controller or supervisor, and has modules that are pulled.
        needs: &[Need::Of(&PROFINET_IO)],
        deviations: permitted! {
            "second-refused-cr-resources" "A connection too many is refused for lack of providers and consumers."
                "IEC 61158-6-10, ErrorCode2 of CMRPC: out of AR, CR or memory, whichever is exhausted first"
                => |d| d.stack.answer(|header, status, _| refuse(header, status, CmrpcError::OUT_OF_CR_RESOURCES));
            "second-refused-memory" "A connection too many is refused for lack of memory."
                "IEC 61158-6-10, ErrorCode2 of CMRPC: out of AR, CR or memory, whichever is exhausted first"
                => |d| d.stack.answer(|header, status, _| refuse(header, status, CmrpcError::OUT_OF_MEMORY));
            "more-supervisors" "The device accepts four supervisors at the same time."
                "GSDML, NumberOfDeviceAccessAR: how many there can be at least"
                => |d| d.stack.check(|check, right| match check {
                    StackCheck::ConnectionLimit { is_exchange: false, others } => others < 4,
                    _ => right,
                });
            "pull-names-the-module" "The alarm of a pulled module has subslot 0."
                "IEC 61158-6-10, AlarmType, Pull: subslot 0 is the module with all of its submodules"
                => |d| d.stack.alarm(|alarm, is_sent| {
                    if alarm.alarm_type == AlarmType::PULL {
                        alarm.subslot = 0;
                    }
                    is_sent
                });
        },
    },
    Group {
        needs: &[Need::Profinet],
        deviations: permitted! {
            "alarm-block-first" "In the answer to Connect, AlarmCRBlockRes follows ARBlockRes, and the IOCRBlockRes come after it."
                "IEC 61158-6-10, IODConnectRes: the blocks after ARBlockRes come in any order"
                => |d| d.stack.answer(|header, _, blocks| blocks_in_order(header, blocks, |content| match content {
                    ConnectContent::ArRes(_) => 0,
                    ConnectContent::AlarmCrRes(_) => 1,
                    _ => 2,
                }));
            "output-block-first" "In the answer to Connect, the IOCRBlockRes come in reverse order."
                "IEC 61158-6-10, IODConnectRes: the blocks after ARBlockRes come in any order"
                => |d| d.stack.answer(|header, _, blocks| changed_blocks(header, blocks, |blocks| {
                    let at: Vec<usize> = (0..blocks.len()).filter(|at| matches!(blocks[*at].content, ConnectContent::IocrRes(_))).collect();
                    if let [first, .., last] = at[..] {
                        blocks.swap(first, last);
                    }
                }));
            "difference-block-second" "In the answer to Connect, all other blocks come in reverse order after ARBlockRes."
                "IEC 61158-6-10, IODConnectRes: the blocks after ARBlockRes come in any order"
                => |d| d.stack.answer(|header, _, blocks| changed_blocks(header, blocks, |blocks| {
                    if let [_, others @ ..] = &mut blocks[..] {
                        others.reverse();
                    }
                }));
            "alarm-length-larger" "The device accepts alarms of up to 1432 bytes."
                "IEC 61158-6-10, AlarmCRBlockRes, MaxAlarmDataLength: 200 to 1432"
                => |d| d.stack.answer(|header, _, blocks| changed_contents(header, blocks, |content| {
                    if let ConnectContent::AlarmCrRes(alarm) = content {
                        alarm.max_alarm_data_length = 1432;
                    }
                }));
            "alarm-reference-high" "The alarm references of the device begin with 0x7F01."
                "IEC 61158-6-10, LocalAlarmReference: any number that is unique in the device"
                => |d| d.stack.alarm_reference(|reference| reference.wrapping_add(0x7F00));
            "alarm-reference-zero" "The alarm references of the device begin with 0."
                "IEC 61158-6-10, LocalAlarmReference: any number that is unique in the device"
                => |d| d.stack.alarm_reference(|reference| reference.wrapping_sub(1));
            "rt-port-dynamic" "The UDP port for cyclic data over UDP, which no one uses, is 0xC123."
                "IEC 61158-6-10, ARBlockRes, ResponderUDPRTPort: 0x8892 or a dynamic port"
                => |d| d.stack.answer(|header, _, blocks| changed_contents(header, blocks, |content| {
                    if let ConnectContent::ArRes(ar) = content {
                        ar.responder_udp_rt_port = 0xC123;
                    }
                }));
            "output-frame-id-chosen" "Where the controller leaves the FrameID of the outputs open, the device chooses another one than the first."
                "IEC 61158-6-10, IOCRBlockReq, FrameID 0xFFFF: the consumer chooses any FrameID of the RT class"
                => |d| d.stack.chosen_frame_id(|first| first.wrapping_add(0x0155));
            "release-with-error-pdu" "After a Release the device closes its alarm endpoint with an ERR-RTA of code 15."
                "IEC 61158-6-10, alarm endpoint: closing sends ERR-RTA with the reason, AR release indication received (15)"
                => |d| d.stack.release_error(|_| Some(AbortReason::RELEASE_RECEIVED));
            "difference-lists-all" "A ModuleDiffBlock also lists the expected submodules that are proper."
                "IEC 61158-6-10, ModuleDiffBlock: proper submodules may be listed besides the others"
                => |d| d.stack.difference(|all, differing| {
                    if differing.is_some() {
                        *differing = Some(all.clone());
                    }
                });
        },
    },
];
