//! Frames damaged on purpose, to check that a slave survives them.
//!
//! Each is a single frame and is not repeated. An answer is awaited for the slot time, although a conforming slave answers few of them.

use super::message::DpMessage;
use super::request::DamagedDpFrame;
use alloc::vec::Vec;
use wire::profibus::fdl::{FrameCount, RequestFunction};
use wire::profibus::sap::SlaveSap;

/// A function code that the standard reserves.
const RESERVED: RequestFunction = RequestFunction(0x0B);
/// An access point (SAP) that no service uses.
const UNUSED_SAP: u8 = 52;

/// The request behind a damaged frame to the station `to`: an answer to the frame has to fit it.
pub(super) fn request(to: u8, broken: DamagedDpFrame) -> DpMessage {
    let diagnosis = DpMessage::diagnosis(to);
    match broken {
        DamagedDpFrame::UnknownFunction => DpMessage { function: RESERVED, ..diagnosis },
        DamagedDpFrame::UnknownAccessPoint => DpMessage { dsap: Some(UNUSED_SAP), ..diagnosis },
        DamagedDpFrame::SetPrmShort => DpMessage::service(to, SlaveSap::SET_PRM, [0x88, 0x01, 0x01].into()),
        DamagedDpFrame::Checksum
        | DamagedDpFrame::EndDelimiter
        | DamagedDpFrame::LengthRepeated
        | DamagedDpFrame::LengthBeyond
        | DamagedDpFrame::StartDelimiter
        | DamagedDpFrame::Truncated
        | DamagedDpFrame::Noise => diagnosis,
    }
}

/// The bytes of a damaged frame from the master `own` to the station `to`.
pub(super) fn frame(own: u8, to: u8, broken: DamagedDpFrame) -> Vec<u8> {
    let mut octets = Vec::new();
    request(to, broken).write(own, FrameCount::First, &mut octets);
    // SD2, LE, LEr, SD2, DA, SA, FC, DAE, SAE, FCS, ED.
    match broken {
        DamagedDpFrame::Checksum => octets[9] ^= 0x01,
        DamagedDpFrame::EndDelimiter => octets[10] = 0x17,
        DamagedDpFrame::LengthRepeated => octets[2] ^= 0x04,
        DamagedDpFrame::LengthBeyond => octets[1..3].fill(0x20),
        DamagedDpFrame::StartDelimiter => octets[0] = 0x69,
        DamagedDpFrame::Truncated => octets.truncate(7),
        DamagedDpFrame::Noise => octets = Vec::from([0x00, 0xFF, 0x55, 0xAA, 0x68, 0x10, 0x16, to]),
        DamagedDpFrame::UnknownFunction | DamagedDpFrame::UnknownAccessPoint | DamagedDpFrame::SetPrmShort => {}
    }
    octets
}
