//! A live slave at a serial line: whether the bus can be used ([`preflight`]), and what is heard on it, in words.
//!
//! This room must not know suites.

pub mod preflight;

use plain_text::hex_start;
use wire::profibus::fdl::Frame;

/// Octets of a frame that a message shows.
const SHOWN: usize = 16;

/// Whether only a master sends such octets: a token, or a request.
pub fn is_of_master(octets: &[u8]) -> bool {
    match Frame::parse(octets) {
        Ok(Frame::Token { .. }) => true,
        Ok(Frame::Data(frame)) => frame.fc.is_request(),
        Ok(Frame::ShortAcknowledgement) | Err(_) => false,
    }
}

/// What was heard, for messages.
pub fn words(octets: &[u8]) -> String {
    match Frame::parse(octets) {
        Ok(Frame::Token { da, sa }) => format!("a token from station {sa} to station {da}"),
        Ok(Frame::Data(frame)) if frame.fc.is_request() => {
            format!("a request of station {} to station {}", frame.sa, frame.da)
        }
        Ok(Frame::Data(frame)) => format!("an answer of station {} to station {}", frame.sa, frame.da),
        Ok(Frame::ShortAcknowledgement) => "a short acknowledgement".to_owned(),
        Err(_) => format!("something that is no frame ({})", hex_start(octets, SHOWN)),
    }
}
