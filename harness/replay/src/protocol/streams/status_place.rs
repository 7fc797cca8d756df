//! Where the APDU status stands in the frames of a stream whose layout is not known.
//!
//! Padding, trailers of switches, check sequences and snap lengths move the end of a frame, so the status is not looked for there: it is
//! where a counter advances by one constant step and the byte of the TransferStatus is 0 in all sampled frames.

use super::super::coverage::CapturePosition;
use station::Duration;

/// So many frames are sampled before the place is looked for.
pub(super) const FEWEST: usize = 16;
/// After this many frames without a place the stream is not judged.
pub(super) const MOST: usize = 64;
/// The length of the APDU status: cycle counter, DataStatus, TransferStatus.
const LENGTH: usize = 4;
/// The bits of DataStatus that are reserved (IEC 61158-6-10): 3 and 6.
const RESERVED: u8 = 0b0100_1000;
/// The unit of the cycle counter in nanoseconds.
pub(super) const COUNTER_UNIT_NS: u64 = 31_250;

/// A sampled frame: when it was captured, and its bytes after the FrameID.
#[derive(Clone, Debug)]
pub(super) struct SampledFrame {
    pub at: CapturePosition,
    pub octets: Vec<u8>,
}

/// The place of the APDU status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct StatusPlace {
    /// The offset of the cycle counter after the FrameID.
    pub offset: usize,
    /// By how much the counter advances with each frame.
    pub step: u16,
}

/// The cycle counter at an offset.
pub(super) fn counter_at(octets: &[u8], offset: usize) -> Option<u16> {
    Some(u16::from_be_bytes([*octets.get(offset)?, *octets.get(offset + 1)?]))
}

/// The place of the status in these frames, if a single one is possible. Where a counter in the data looks like one, the one that
/// fits the clock of the capture is meant.
pub(super) fn place(samples: &[SampledFrame]) -> Option<StatusPlace> {
    let shortest = samples.iter().map(|sample| sample.octets.len()).min()?;
    let possible = (0..=shortest.checked_sub(LENGTH)?).rev().filter_map(|offset| {
        let step = step_at(samples, offset)?;
        Some(StatusPlace { offset, step })
    });
    let possible: Vec<StatusPlace> = possible.collect();
    let usual = usual_interval(samples);
    let in_time: Vec<&StatusPlace> = possible.iter().filter(|place| keeps_time(place.step, usual)).collect();
    match (possible.as_slice(), in_time.as_slice()) {
        (_, [only]) => Some(**only),
        ([only], _) => Some(*only),
        _ => None,
    }
}

/// The constant step of the counter at an offset, if these can be an APDU status. Missing frames make it several steps.
fn step_at(samples: &[SampledFrame], offset: usize) -> Option<u16> {
    let is_status = |sample: &SampledFrame| {
        let [status, transfer] = [offset + 2, offset + 3].map(|at| sample.octets.get(at).copied().unwrap_or(u8::MAX));
        status & RESERVED == 0 && transfer == 0
    };
    if !samples.iter().all(is_status) {
        return None;
    }
    let counters: Vec<u16> = samples.iter().filter_map(|sample| counter_at(&sample.octets, offset)).collect();
    let steps: Vec<u16> = counters.windows(2).map(|pair| pair[1].wrapping_sub(pair[0])).collect();
    let step = commonest(&steps)?;
    let of_it = steps.iter().filter(|of| **of == step).count();
    let whole = step != 0 && steps.iter().all(|of| *of != 0 && of.is_multiple_of(step));
    (whole && of_it * 2 > steps.len()).then_some(step)
}

fn commonest(steps: &[u16]) -> Option<u16> {
    let count = |step: u16| steps.iter().filter(|of| **of == step).count();
    steps.iter().copied().max_by_key(|step| (count(*step), std::cmp::Reverse(*step)))
}

/// The median of the times between two frames.
fn usual_interval(samples: &[SampledFrame]) -> Option<Duration> {
    let mut intervals: Vec<Duration> = samples.windows(2).filter_map(|pair| pair[1].at.since(pair[0].at)).collect();
    intervals.sort();
    intervals.get(intervals.len() / 2).copied()
}

/// Whether a step of the counter is about the time between two frames.
fn keeps_time(step: u16, interval: Option<Duration>) -> bool {
    let cycle = Duration::from_nanos(u64::from(step) * COUNTER_UNIT_NS);
    interval.is_some_and(|interval| interval * 2 > cycle && interval < cycle * 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;
    use station::Time;

    /// Frames of 1 ms with the counter of that cycle (32 units) behind `data` bytes, and `trailer` behind the status.
    fn frames(data: usize, trailer: &[u8], change: impl Fn(u16, &mut Vec<u8>)) -> Vec<SampledFrame> {
        let frame = |number: u16| {
            let mut octets = vec![0; data];
            octets.extend((number * 32).to_be_bytes());
            octets.extend([0x35, 0]);
            octets.extend(trailer);
            change(number, &mut octets);
            let time = Time::from_nanos(u64::from(number) * 1_000_000);
            SampledFrame { at: CapturePosition { frame: number.into(), time, piece: 0 }, octets }
        };
        (1..=20).map(frame).collect()
    }

    #[rstest]
    #[case::at_the_end(&[])]
    #[case::before_zeros(&[0; 6])]
    #[case::before_a_check_sequence(&[0x12, 0x34, 0x56, 0x78])]
    fn it_is_where_the_counter_advances(#[case] trailer: &[u8]) {
        assert_eq!(place(&frames(40, trailer, |_, _| {})), Some(StatusPlace { offset: 40, step: 32 }));
    }

    #[test]
    fn missing_frames_are_several_steps() {
        let mut samples = frames(40, &[], |_, _| {});
        samples.drain(5..8);
        assert_eq!(place(&samples), Some(StatusPlace { offset: 40, step: 32 }));
    }

    #[test]
    fn a_counter_in_the_data_does_not_keep_the_time_of_the_capture() {
        let samples = frames(40, &[], |number, octets| {
            octets[10..12].copy_from_slice(&number.to_be_bytes());
        });
        assert_eq!(place(&samples), Some(StatusPlace { offset: 40, step: 32 }));
    }

    #[rstest]
    #[case::standing(|_, octets: &mut Vec<u8>| octets[40..42].fill(7))]
    #[case::cut(|_, octets: &mut Vec<u8>| octets.truncate(41))]
    #[case::damaged(|number, octets: &mut Vec<u8>| octets[43] = (number == 9).into())]
    #[case::another_field(|number, octets: &mut Vec<u8>| octets[42] = if number == 3 { 0x48 } else { 0x35 })]
    fn without_a_counter_there_is_no_place(#[case] change: impl Fn(u16, &mut Vec<u8>)) {
        assert_eq!(place(&frames(40, &[], change)), None);
    }
}
