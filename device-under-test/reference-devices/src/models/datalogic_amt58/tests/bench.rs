//! An AMT58 with its slave, and a master that sends single frames. The tests of the bugs use it too.

use super::slave::SlaveBench;
use encoder_profile::encoder_object::EncoderSpecimen;
use reference_devices::deviations::DeviceDeviations;
use reference_devices::manuals::DATALOGIC_AMT58;
use reference_devices::{Line, ReferenceDevice};
use station::StandAction;
use std::boxed::Box;
use std::vec::Vec;
use wire::profibus::fdl::BaudRate;

/// An AMT58 and its master.
pub type AmtBench = SlaveBench<Box<dyn ReferenceDevice>>;

pub const HS: &str = "hs5818";
pub const HM: &str = "hm5816-16384";

/// A bench with an encoder at address 5 that has these deviations, or none.
pub fn bench_with(variant: &str, shaft: u64, deviations: Option<&DeviceDeviations>) -> AmtBench {
    let line = Line { address: 5, baud: BaudRate(1_500_000) };
    let plain = DeviceDeviations::default();
    let piece = EncoderSpecimen { shaft, ..EncoderSpecimen::default() };
    let device = DATALOGIC_AMT58.build(variant, deviations.unwrap_or(&plain), piece, line);
    SlaveBench::new(device.expect("the variant is known"), 5)
}

pub fn act(bench: &mut AmtBench, action: StandAction<'_>) {
    let done = bench.device.act(bench.now, &action).expect("the stand supports the action");
    bench.wait(done.since(bench.now));
}

/// Set_Prm: watchdog 1 s, min TSDR 11, ident 1655h, bytes of DP-V1, then bytes 10 to 20.
pub fn parameters(operating: u8, units: u32, range: u32, unit: u8) -> Vec<u8> {
    let mut octets = Vec::from([0x88, 0x14, 0x05, 0x0B, 0x16, 0x55, 0, 0, 0, 0, operating]);
    octets.extend_from_slice(&units.to_be_bytes());
    octets.extend_from_slice(&range.to_be_bytes());
    octets.extend_from_slice(&[unit, 0]);
    octets
}
