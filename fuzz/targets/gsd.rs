//! GSD files: reading, showing, and what they say of a device of a manual, of any slave and of any encoder.
#![no_main]

use description::gsd;
use encspec_fuzz::{PROFIBUS, trials};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Ok(description) = gsd::read_octets(data) else { return };
    std::hint::black_box(gsd::show(&description));
    let device = &trials(PROFIBUS).0.device;
    std::hint::black_box(gsd::compare(device, 0, &description));
    let _ = std::hint::black_box(gsd::describe(&description, None));
    std::hint::black_box(gsd::overlay(&mut device.as_ref().clone(), Some(&description), &[]));
});
