//! Frames compared with profirust: both write the same bytes, and both accept and reject the same frames.
#![allow(clippy::unwrap_used, reason = "an unwrap fails the test")]

use crate::round_trip::written;
use encspec_wire::profibus::fdl::{DataFrame, Extension, FdlFrame, FunctionCode, StartDelimiter};
use profirust::fdl::{DataTelegramHeader, FunctionCode as TheirCode, Telegram};
use testing::golden;

fn written_by_profirust(frame: &DataFrame<'_>) -> Vec<u8> {
    let header = DataTelegramHeader {
        da: frame.da,
        sa: frame.sa,
        dsap: frame.destination.sap,
        ssap: frame.source.sap,
        fc: TheirCode::from_byte(frame.fc.0).unwrap(),
    };
    let mut buffer = vec![0; 300];
    let length = header.serialize(&mut buffer, frame.data.len(), |out| out.copy_from_slice(frame.data));
    buffer.truncate(length);
    buffer
}

#[test]
fn both_write_the_same() {
    let data: Vec<u8> = (0..=243).map(|at: u8| at.wrapping_mul(37)).collect();
    let saps = [Extension::NONE, Extension::sap(62), Extension::sap(0)];
    let mut compared = 0;
    for length in (0..=20).chain([100, 243, 244]) {
        for code in (0..=0xFF).filter(|code| TheirCode::from_byte(*code).is_ok_and(|read| read.to_byte() == *code)) {
            for (destination, source) in [(saps[0], saps[0]), (saps[1], saps[2]), (saps[0], saps[1])] {
                let frame =
                    DataFrame::new((code & 0x7F, destination), (126, source), FunctionCode(code), &data[..length]);
                assert_eq!(written(|out| frame.write(out)), written_by_profirust(&frame), "{frame:?}");
                compared += 1;
            }
        }
    }
    assert!(compared > 4_000, "{compared} frames were compared");
}

/// Parses with profirust and writes the result with this crate.
fn parsed_by_profirust(octets: &[u8]) -> Option<Vec<u8>> {
    let (telegram, length) = Telegram::deserialize(octets)?.ok()?;
    (length == octets.len()).then(|| match telegram {
        Telegram::Token(token) => vec![token.da, token.sa],
        Telegram::ShortConfirmation(_) => Vec::new(),
        Telegram::Data(frame) => {
            let head = [frame.h.da, frame.h.sa, frame.h.dsap.unwrap_or(255), frame.h.ssap.unwrap_or(255)];
            [&head[..], &[frame.h.fc.to_byte()], frame.pdu].concat()
        }
    })
}

fn parsed_here(octets: &[u8]) -> Option<Vec<u8>> {
    Some(match FdlFrame::parse(octets).ok()? {
        FdlFrame::Token { da, sa } => vec![da, sa],
        FdlFrame::ShortAcknowledgement => Vec::new(),
        FdlFrame::Data(frame) => {
            let head = [frame.da, frame.sa, frame.destination.sap.unwrap_or(255), frame.source.sap.unwrap_or(255)];
            [&head[..], &[frame.fc.0], frame.data].concat()
        }
    })
}

#[test]
fn both_parse_the_same_and_reject_the_same() {
    let (mut read, mut refused) = (0, 0);
    for (name, octets) in golden("pyprofibus.txt") {
        // profirust does not support segments.
        if name == "segments" {
            continue;
        }
        assert_eq!(parsed_here(&octets), parsed_by_profirust(&octets), "{name}");
        for at in 0..octets.len() * 8 {
            // profirust does not check the second start delimiter.
            if octets[0] == StartDelimiter::SD2.0 && at / 8 == 3 {
                continue;
            }
            let mut damaged = octets.clone();
            damaged[at / 8] ^= 1 << (at % 8);
            let (here, profirust) = (parsed_here(&damaged), parsed_by_profirust(&damaged));
            assert_eq!(here, profirust, "{name}, bit {at} flipped: {damaged:02x?}");
            if here.is_some() { read += 1 } else { refused += 1 }
        }
    }
    // Only a token has no checksum.
    assert_eq!(read, 16);
    assert!(refused > 4_900, "{refused} frames were rejected");
}
