//! A live slave on a serial line: the [`survey`] of a bus, the [`preflight`] of a bench, and descriptions of received frames.
//!
//! This module must not know suites.

pub mod preflight;
pub mod survey;

use plain_text::hex_start;
use wire::profibus::fdl::FdlFrame;

/// Number of bytes of a frame shown in a message.
const SHOWN: usize = 16;

/// Whether only a master sends these bytes: a token or a request.
pub fn is_of_master(octets: &[u8]) -> bool {
    match FdlFrame::parse(octets) {
        Ok(FdlFrame::Token { .. }) => true,
        Ok(FdlFrame::Data(frame)) => frame.fc.is_request(),
        Ok(FdlFrame::ShortAcknowledgement) | Err(_) => false,
    }
}

/// A description of received bytes, for messages.
pub fn words(octets: &[u8]) -> String {
    match FdlFrame::parse(octets) {
        Ok(FdlFrame::Token { da, sa }) => format!("a token from station {sa} to station {da}"),
        Ok(FdlFrame::Data(frame)) if frame.fc.is_request() => {
            format!("a request of station {} to station {}", frame.sa, frame.da)
        }
        Ok(FdlFrame::Data(frame)) => format!("an answer of station {} to station {}", frame.sa, frame.da),
        Ok(FdlFrame::ShortAcknowledgement) => "a short acknowledgement".to_owned(),
        Err(_) => format!("bytes that are not a frame ({})", hex_start(octets, SHOWN)),
    }
}
