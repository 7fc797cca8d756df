//! Capture files: pcap and pcapng, packed or not, whole or damaged; with their texts and the annotated copy.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| encspec_fuzz::replayed(data));
