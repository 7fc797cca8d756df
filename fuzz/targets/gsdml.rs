//! GSDML files, in any encoding: reading, showing, and what they say of a device of a manual.
#![no_main]

use description::gsdml;
use encspec_fuzz::{PROFINET, trials};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Ok(description) = gsdml::read_octets(data) else { return };
    std::hint::black_box(gsdml::show(&description));
    let device = &trials(PROFINET).0.device;
    std::hint::black_box(gsdml::compare(device, 0, Some(&description), None));
});
