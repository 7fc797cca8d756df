//! The IO controller and a device stack on PROFINET, with a wire that changes, loses, doubles and delays frames.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| encspec_fuzz::exchange(encspec_fuzz::PROFINET, data));
