//! Cyclic frames that are lost on the path, but never so many in a row that a data hold time expires.

use crate::seams::stack::cyclic;
use alloc::vec::Vec;
use core::mem;
use core::time::Duration;
use device_stack::profinet::{ArEvent, StackHooks, StackView};
use station::Time;
use wire::profinet::rt::ApduStatus;

/// When frames of one direction are lost.
#[derive(Default)]
struct FrameLoss {
    /// Frames in a row that may be lost.
    row: u32,
    /// One row in so many frames.
    each: u32,
    hold: Duration,
    frames: u32,
    lost: u32,
    last: Option<Time>,
    arrived: Option<Time>,
}

impl FrameLoss {
    fn new(row: u32, each: u32) -> FrameLoss {
        FrameLoss { row, each, ..FrameLoss::default() }
    }

    fn begin(&mut self) {
        (self.frames, self.lost, self.last, self.arrived) = (0, 0, None, None);
    }

    /// Whether the frame of this moment is lost; one that `may` not be lost ends a row.
    fn loses(&mut self, now: Time, may: bool) -> bool {
        let (last, arrived) = (self.last.replace(now), self.arrived);
        self.frames += 1;
        let is_turn = self.frames % self.each < self.row && self.lost < self.row;
        let is_in_time = last.zip(arrived).is_some_and(|(last, arrived)| {
            // The next frame, half a cycle late, is still in time.
            let cycle = now.since(last);
            now + cycle + cycle / 2 < arrived + self.hold
        });
        let is_lost = may && is_turn && is_in_time;
        self.lost = if is_lost { self.lost + 1 } else { 0 };
        if !is_lost {
            self.arrived = Some(now);
        }
        is_lost
    }
}

/// Loses frames of the device.
pub struct LosesInputs(FrameLoss);

impl LosesInputs {
    /// Up to `row` frames, once in so many.
    pub fn row_of(row: u32, each: u32) -> LosesInputs {
        LosesInputs(FrameLoss::new(row, each))
    }
}

impl StackHooks for LosesInputs {
    fn data_hold_time(&mut self, agreed: Duration) -> Duration {
        self.0.hold = agreed;
        agreed
    }

    fn connection(&mut self, event: ArEvent) {
        if event == ArEvent::Opened {
            self.0.begin();
        }
    }

    fn sent_frame(&mut self, view: &StackView<'_>, frame: &mut Vec<u8>) {
        if cyclic(frame).is_some() && self.0.loses(view.now, true) {
            frame.clear();
        }
    }
}

/// Loses frames of the controller that repeat the outputs of the frame before, so that no output is lost.
pub struct LosesOutputs {
    loss: FrameLoss,
    before: Vec<u8>,
}

impl LosesOutputs {
    /// Up to `row` frames, once in so many.
    pub fn row_of(row: u32, each: u32) -> LosesOutputs {
        LosesOutputs { loss: FrameLoss::new(row, each), before: Vec::new() }
    }
}

impl StackHooks for LosesOutputs {
    fn data_hold_time(&mut self, agreed: Duration) -> Duration {
        self.loss.hold = agreed;
        agreed
    }

    fn connection(&mut self, event: ArEvent) {
        if event == ArEvent::Opened {
            self.loss.begin();
            self.before.clear();
        }
    }

    fn received_frames(&mut self, view: &StackView<'_>, mut frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        frames.retain(|frame| {
            let Some(at) = cyclic(frame) else { return true };
            let Some(end) = frame.len().checked_sub(ApduStatus::LENGTH).filter(|end| *end >= at) else { return true };
            // Both the outputs and DataStatus; the cycle counter differs in each frame.
            let before = mem::replace(&mut self.before, [&frame[..end], &frame[end + 2..]].concat());
            !self.loss.loses(view.now, before == self.before)
        });
        frames
    }
}
