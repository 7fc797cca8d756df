//! Ethernet frames of a capture, from DCP to alarms, judged by the rules of a manual.
#![no_main]

use virtual_wire::capture::LinkType;

libfuzzer_sys::fuzz_target!(|data: &[u8]| encspec_fuzz::replayed(&encspec_fuzz::capture(data, LinkType::ETHERNET)));
