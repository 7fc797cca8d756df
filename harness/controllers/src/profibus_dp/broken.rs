//! Frames damaged on purpose, to check that a slave survives them.
//!
//! Each is a single frame; the bus is left idle for the slot time after it.

use super::message::DpMessage;
use super::request::DamagedDpFrame;
use alloc::vec::Vec;
use wire::profibus::fdl::{FrameCount, RequestFunction};
use wire::profibus::sap::SlaveSap;

/// A function code that the standard reserves.
const RESERVED: RequestFunction = RequestFunction(0x0B);
/// An access point (SAP) that no service uses.
const UNUSED_SAP: u8 = 52;

/// The bytes of a damaged frame from the master `own` to the station `to`.
pub(super) fn frame(own: u8, to: u8, broken: DamagedDpFrame) -> Vec<u8> {
    let diagnosis = DpMessage::diagnosis(to);
    let of = |message: DpMessage| {
        let mut octets = Vec::new();
        message.write(own, FrameCount::First, &mut octets);
        octets
    };
    let damaged = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut octets = of(diagnosis.clone());
        change(&mut octets);
        octets
    };
    // SD2, LE, LEr, SD2, DA, SA, FC, DAE, SAE, FCS, ED.
    match broken {
        DamagedDpFrame::Checksum => damaged(&|octets| octets[9] ^= 0x01),
        DamagedDpFrame::EndDelimiter => damaged(&|octets| octets[10] = 0x17),
        DamagedDpFrame::LengthRepeated => damaged(&|octets| octets[2] ^= 0x04),
        DamagedDpFrame::LengthBeyond => damaged(&|octets| octets[1..3].fill(0x20)),
        DamagedDpFrame::StartDelimiter => damaged(&|octets| octets[0] = 0x69),
        DamagedDpFrame::Truncated => damaged(&|octets| octets.truncate(7)),
        DamagedDpFrame::UnknownFunction => of(DpMessage { function: RESERVED, ..diagnosis }),
        DamagedDpFrame::UnknownAccessPoint => of(DpMessage { dsap: Some(UNUSED_SAP), ..diagnosis }),
        DamagedDpFrame::SetPrmShort => of(DpMessage::service(to, SlaveSap::SET_PRM, [0x88, 0x01, 0x01].into())),
        DamagedDpFrame::Noise => Vec::from([0x00, 0xFF, 0x55, 0xAA, 0x68, 0x10, 0x16, to]),
    }
}
