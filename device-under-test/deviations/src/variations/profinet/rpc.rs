//! How a PROFINET device forms its RPC PDUs.

use super::state::{AnswersTwice, SaysWorking, with_header, with_source_port};
use crate::needs::Need;
use crate::seams::late::FrameTopic;
use crate::tables::Group;
use core::time::Duration;
use reference_devices::manuals::PROFINET_IO;
use wire::octets::ByteOrder;
use wire::profinet::rpc::{Flags1, Opnum, PacketType};

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        // Only this suite calls with little-endian headers; the others see big-endian answers anyway.
        needs: &[Need::Of(&PROFINET_IO)],
        deviations: permitted! {
            "rpc-big-endian" "RPC and NDR headers are big-endian in every answer and in ApplicationReady."
                "IEC 61158-6-10, RPCDRep: each sender chooses its byte order"
                => |d| d.stack.byte_order(|_| ByteOrder::Big);
        },
    },
    Group {
        needs: &[Need::Profinet],
        deviations: permitted! {
            "rpc-little-endian" "RPC and NDR headers are little-endian in every answer and in ApplicationReady; PNIO blocks stay big-endian."
                "IEC 61158-6-10, RPCDRep: each sender chooses its byte order"
                => |d| d.stack.byte_order(|_| ByteOrder::Little);
            "rpc-other-order" "RPC and NDR headers of an answer have the other byte order than the request."
                "IEC 61158-6-10, RPCDRep: each sender chooses its byte order"
                => |d| d.stack.byte_order(|order| match order {
                    ByteOrder::Big => ByteOrder::Little,
                    ByteOrder::Little => ByteOrder::Big,
                });
            "rpc-boot-time" "The server reports a boot time from its calendar, more than 2 000 000 000."
                "C706, 12.5.1: the boot time is any number that changes with each start"
                => |d| d.stack.sent_frame(|_, frame| with_header(frame, |header| {
                    if header.packet_type != PacketType::REQUEST {
                        header.server_boot = header.server_boot.wrapping_add(BOOT);
                    }
                }));
            "rpc-hints" "The server gives hints for its interface and the activity."
                "C706, 12.5.1: hints are the business of the server"
                => |d| d.stack.sent_frame(|_, frame| with_header(frame, |header| {
                    if header.packet_type != PacketType::REQUEST {
                        (header.interface_hint, header.activity_hint) = (0, 3);
                    }
                }));
            "rpc-flags" "An answer carries the flags of the request, idempotent among them."
                "IEC 61158-6-10, RPCFlags: a receiver ignores all but the fragment flags of a response"
                => |d| d.stack.sent_frame(|_, frame| with_header(frame, |header| {
                    if header.packet_type == PacketType::RESPONSE {
                        header.flags1 = Flags1(header.flags1.0 | Flags1::IDEMPOTENT.0);
                    }
                }));
            "rpc-serial" "The PDUs carry a serial number other than 0."
                "C706, 12.5.1: the serial number is of the sender's choice, a fack repeats it"
                => |d| d.stack.sent_frame(|_, frame| with_header(frame, |header| header.serial = 0x0101));
            "working-before-answer" "Each call is first answered by a PDU `working`, and 200 ms later by the response."
                "C706, 10.2: a server that is busy sends `working`; the client pings and waits"
                => |d| {
                    d.late.added(SaysWorking::before_response);
                    d.late.sent(|topic| matches!(topic, FrameTopic::Response(opnum) if opnum != Opnum::EPT_LOOKUP).then_some(Duration::from_millis(200)));
                };
            "answers-twice" "Each response is repeated after 30 ms."
                "C706, 10.2: a server repeats a response that is not acknowledged; the client drops the second"
                => |d| d.late.added(AnswersTwice::response);
            "ready-call-repeated" "ApplicationReady is sent three times within 20 ms."
                "C706, 10.2: a client repeats a request until it is answered; the standard prints no interval"
                => |d| d.late.added(AnswersTwice::application_ready);
            "client-port-first" "ApplicationReady comes from UDP port 0xC000."
                "IEC 61158-6-10, RPC: a client uses any port from 0xC000 on"
                => |d| d.stack.client_port(|_| 0xC000);
            "client-port-high" "ApplicationReady comes from UDP port 0xFFFE."
                "IEC 61158-6-10, RPC: a client uses any port from 0xC000 on"
                => |d| d.stack.client_port(|_| 0xFFFE);
            "server-port-ephemeral" "Answers come from UDP port 0xC010, requests arrive at 0x8894."
                "C706, 10.2: a server may answer from another endpoint; IEC 61158-6-10: any port from 0xC000 on"
                => |d| d.stack.sent_frame(|_, frame| with_source_port(frame, 0x8894, 0xC010));
        },
    },
];

const BOOT: u32 = 2_000_000_000;
