//! Every prefix, flipped bits and overwritten bytes of all PROFIBUS services; every parsed result can be written again.
#![allow(clippy::unwrap_used, reason = "an unwrap fails the test")]

use crate::round_trip::try_hard;
use encspec_wire::WireError;
use encspec_wire::profibus::address::SetSlaveAddress;
use encspec_wire::profibus::cfg::{Identifier, io_lengths};
use encspec_wire::profibus::diag::{DiagnosisBlock, DiagnosisMessage, SlaveDiag, identifiers};
use encspec_wire::profibus::dpv1::{Dpv1Pdu, PduDirection};
use encspec_wire::profibus::fdl::{FdlFrame, FdlPiece, Splitter};
use encspec_wire::profibus::global_control::GlobalControl;
use encspec_wire::profibus::prm::{Isochronous, PrmBlock, SetPrm};
use encspec_wire::profibus::sap::SapService;
use rstest::rstest;
use testing::{every_prefix_and_flip, golden, hex};

#[test]
fn frames() {
    for (_, octets) in golden("pyprofibus.txt") {
        every_prefix_and_flip(&octets, |trial| {
            let _ = FdlFrame::length(trial);
            let Ok(frame) = FdlFrame::parse(trial) else { return };
            let mut out = Vec::new();
            frame.write(&mut out);
            assert_eq!(out, trial, "the parsed data are written unchanged");
            if let FdlFrame::Data(frame) = frame {
                let _ = (SapService::of(&frame), SapService::of(&frame).word());
            }
        });
    }
}

/// A frame with one flipped bit is an error, except in the addresses of a token.
#[test]
fn a_flipped_bit_is_detected() {
    for (name, octets) in golden("pyprofibus.txt") {
        for at in 0..octets.len() * 8 {
            let mut damaged = octets.clone();
            damaged[at / 8] ^= 1 << (at % 8);
            let read = FdlFrame::parse(&damaged);
            assert_eq!(read.is_ok(), name == "token" && at >= 8, "{name}, bit {at}: {read:?}");
            if let Err(WireError::Value { offset, .. } | WireError::Short { offset, .. }) = read {
                assert!(offset <= damaged.len(), "{name}, bit {at}: byte {offset}");
            }
        }
    }
}

/// A splitter returns all bytes that were pushed, in frames or damaged pieces, however they were split.
#[test]
fn streams() {
    let stream: Vec<u8> = golden("pyprofibus.txt").into_iter().flat_map(|(_, octets)| octets).collect();
    every_prefix_and_flip(&stream[..200], |trial| {
        let mut splitter = Splitter::new();
        let mut out = Vec::new();
        let mut keep = |piece| match piece {
            FdlPiece::Frame(octets) => out.extend(octets),
            FdlPiece::Damaged { octets, .. } => {
                assert!(!octets.is_empty());
                out.extend(octets);
            }
        };
        for part in trial.chunks(7) {
            splitter.push(part);
            while let Some(piece) = splitter.next_piece() {
                keep(piece);
            }
        }
        while let Some(piece) = splitter.silence() {
            keep(piece);
        }
        assert!(!splitter.is_waiting());
        assert_eq!(out, trial);
    });
}

#[rstest]
#[case("080C00021655 814036 0403010811 4201 C5 0A000102030405060708")]
#[case("000C000216553900CA000000040000000000000000000001010002000000")]
fn diagnosis(#[case] octets: &str) {
    let octets = hex(octets);
    try_hard(&octets, SlaveDiag::parse, SlaveDiag::write);
    every_prefix_and_flip(&octets, |trial| {
        let Ok(diag) = SlaveDiag::parse(trial) else { return };
        let mut out = Vec::new();
        let mut whole = true;
        for block in diag.blocks() {
            let Ok(block) = block else {
                whole = false;
                continue;
            };
            block.write(&mut out);
            if let DiagnosisBlock::Device(data) | DiagnosisBlock::Identifier(data) = block {
                let _ = (identifiers(data).count(), DiagnosisMessage::parse(data).map(|message| message.alarm()));
            }
        }
        assert!(diag.ext.starts_with(&out), "blocks are written unchanged");
        assert!(!whole || diag.ext == out);
    });
}

#[test]
fn parameters() {
    let blocks = "1c04000001000005dc000801000005dc00010002000002ee000c0000 0681000001ff 04200000";
    let octets = hex(&format!("b814050b165581 c4a11c {blocks}"));
    try_hard(&octets, SetPrm::parse, SetPrm::write);
    try_hard(&hex(blocks), PrmBlock::parse_all, |blocks, out| blocks.iter().for_each(|block| block.write(out)));
    try_hard(&hex(&blocks[8..56]), Isochronous::parse, Isochronous::write);
    every_prefix_and_flip(&octets, |trial| {
        if let Ok(prm) = SetPrm::parse(trial) {
            let _ = (prm.watchdog_ms(10), prm.dpv1().map(|dpv1| dpv1.status_3.alarms()), prm.user_after_dpv1());
        }
        if let Ok(times) = Isochronous::parse(trial) {
            let _ = times.cycle_nanoseconds();
        }
    });
}

#[rstest]
#[case("D3213F")]
#[case("C3C1C5FD0051 403F 8047 00 0F CF0102 4E000102030405060708091011121314")]
fn configuration(#[case] octets: &str) {
    let octets = hex(octets);
    try_hard(&octets, Identifier::parse_all, |all, out| all.iter().for_each(|identifier| identifier.write(out)));
    every_prefix_and_flip(&octets, |trial| {
        if let Ok(identifiers) = Identifier::parse_all(trial) {
            let mut out = Vec::new();
            identifiers.iter().for_each(|identifier| identifier.write(&mut out));
            assert_eq!(out, trial, "the parsed data are written unchanged");
            let _ = io_lengths(&identifiers);
        }
    });
}

#[test]
fn small_services() {
    try_hard(&hex("2881"), GlobalControl::parse, GlobalControl::write);
    try_hard(&hex("05165500AABB"), SetSlaveAddress::parse, SetSlaveAddress::write);
}

#[rstest]
#[case(PduDirection::Request, "48")]
#[case(PduDirection::Request, "51000103AABBCC")]
#[case(PduDirection::Response, "56300064")]
#[case(PduDirection::Request, "5700000000640100000003030002000200000000")]
#[case(PduDirection::Response, "57F00100000003030002000200000000")]
#[case(PduDirection::Request, "58011300")]
#[case(PduDirection::Request, "5C010109")]
#[case(PduDirection::Request, "5E002FF0")]
#[case(PduDirection::Response, "5E002F0401020304")]
#[case(PduDirection::Request, "5F002F0401020304")]
#[case(PduDirection::Response, "5F002F04")]
#[case(PduDirection::Response, "DE80B500")]
#[case(PduDirection::Response, "4712")]
fn acyclic(#[case] side: PduDirection, #[case] octets: &str) {
    let as_request = |octets: &[u8]| Dpv1Pdu::parse(octets, PduDirection::Request);
    let as_response = |octets: &[u8]| Dpv1Pdu::parse(octets, PduDirection::Response);
    match side {
        PduDirection::Request => try_hard(&hex(octets), as_request, Dpv1Pdu::write),
        PduDirection::Response => try_hard(&hex(octets), as_response, Dpv1Pdu::write),
    }
    every_prefix_and_flip(&hex(octets), |trial| drop((as_request(trial), as_response(trial))));
}
