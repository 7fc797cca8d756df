//! Logs of bytes in hexadecimal, as adapters for PROFIBUS write them.
#![no_main]

use virtual_wire::record::import;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = std::hint::black_box(import(data, Vec::new(), "fuzz", None));
});
