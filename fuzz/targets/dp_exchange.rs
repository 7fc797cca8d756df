//! The DP master and a slave stack on PROFIBUS, with a bus that changes, loses, doubles and delays telegrams.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| encspec_fuzz::exchange(encspec_fuzz::PROFIBUS, data));
