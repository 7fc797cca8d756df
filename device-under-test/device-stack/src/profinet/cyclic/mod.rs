//! Cyclic data of one connection: the provider of the inputs and the consumer of the outputs.
//!
//! Both store the offset of each submodule in its frame, as agreed in Connect, and allocate nothing per frame.

mod consumer;
mod input;
mod output;
mod provider;

pub(super) use consumer::OutputConsumer;
pub(super) use provider::{InputProvider, ProviderState};

use station::Duration;
use wire::profinet::blocks::connect::IocrBlockReq;
use wire::profinet::rt::IoxS;

/// The unit of send clocks and cycle counters: 31.25 us.
const CLOCK: Duration = Duration::from_nanos(31_250);
/// The shortest send clock: a SendClockFactor of 8 (IEC 61158-6-10).
const SHORTEST_CYCLE: Duration = Duration::from_micros(250);

/// The send interval of a cyclic connection.
fn interval(iocr: &IocrBlockReq) -> Duration {
    // A device that does not check the factors accepts 0, but it cannot send without a pause.
    (CLOCK * u32::from(iocr.send_clock_factor) * u32::from(iocr.reduction_ratio)).max(SHORTEST_CYCLE)
}

/// The IOPS or IOCS for a state.
fn status(is_good: bool) -> IoxS {
    if is_good { IoxS::GOOD } else { IoxS::BAD }
}

/// Writes one byte of a frame.
fn put(frame: &mut [u8], at: usize, value: u8) {
    if let Some(byte) = frame.get_mut(at) {
        *byte = value;
    }
}
