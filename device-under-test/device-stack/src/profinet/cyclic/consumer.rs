//! The cyclic frames that the device receives.

use super::super::hooks::{AttachedStackHooks, StackCheck};
use super::super::plugged::{ExpectedSubmoduleData, SubmoduleAddress};
use super::interval;
use super::output::OutputOffset;
use crate::profinet::IoApplication;
use alloc::vec::Vec;
use station::{Duration, Time};
use wire::ethernet::Mac;
use wire::profinet::blocks::connect::IocrBlockReq;
use wire::profinet::rt::{CyclicFrame, DataStatus, FrameId, IoxS};

/// Receives the outputs of a connection and monitors the data hold time.
#[derive(Debug)]
pub(in super::super) struct OutputConsumer {
    hooks: AttachedStackHooks,
    source: Mac,
    frame_id: FrameId,
    data_length: usize,
    outputs: Vec<OutputOffset>,
    hold: Duration,
    expires: Option<Time>,
    counter: Option<u16>,
}

impl OutputConsumer {
    /// A cycle counter that is less than this number of steps back belongs to an old frame.
    const OLD: u16 = 4096;

    /// A consumer for frames from `source` with `frame_id`, laid out as `iocr` says. It ignores the outputs of a submodule that
    /// is not plugged or that another connection owns.
    pub(in super::super) fn new(
        source: Mac,
        frame_id: u16,
        iocr: &IocrBlockReq,
        expected: &[ExpectedSubmoduleData],
        is_usable: impl Fn(&ExpectedSubmoduleData) -> bool,
        hooks: AttachedStackHooks,
    ) -> OutputConsumer {
        let mut outputs = Vec::new();
        for api in &iocr.apis {
            for object in &api.io_data_objects {
                let place = SubmoduleAddress { api: api.api, slot: object.slot_number, subslot: object.subslot_number };
                let submodule = expected.iter().find(|submodule| submodule.place == place);
                if let Some(submodule) = submodule {
                    outputs.push(OutputOffset {
                        slot: place.slot,
                        subslot: place.subslot,
                        at: object.frame_offset.into(),
                        octets: submodule.output_octets.into(),
                        is_usable: is_usable(submodule),
                        was_good: false,
                    });
                }
            }
        }
        let agreed = interval(iocr) * u32::from(iocr.data_hold_factor);
        OutputConsumer {
            source,
            frame_id: FrameId(frame_id),
            data_length: iocr.data_length.into(),
            outputs,
            hold: hooks.apply(agreed, |hooks, agreed| hooks.data_hold_time(agreed)),
            expires: None,
            counter: None,
            hooks,
        }
    }

    /// Whether a frame with this source and FrameID belongs to this consumer.
    pub(in super::super) fn expects(&self, source: Mac, frame_id: FrameId) -> bool {
        self.hooks.check(StackCheck::FrameId(frame_id), self.frame_id == frame_id)
            && self.hooks.check(StackCheck::Source(source), self.source == source)
    }

    /// When the data hold time expires; `None` before the first frame.
    pub(in super::super) fn expires(&self) -> Option<Time> {
        self.expires
    }

    /// Processes a frame from its FrameID on. Returns whether it was new and had the right format.
    ///
    /// The outputs reach the application once it `is_ready`.
    pub(in super::super) fn receive(
        &mut self,
        now: Time,
        payload: &[u8],
        is_ready: bool,
        application: &mut dyn IoApplication,
    ) -> bool {
        let frame = CyclicFrame::parse(payload, self.data_length);
        let is_whole = self.hooks.check(StackCheck::FrameLength(payload.len()), frame.is_ok());
        let Some(frame) = frame.ok().filter(|_| is_whole) else { return false };
        let (status, data) = (frame.status, frame.status.data_status);
        let is_old = self.counter.is_some_and(|last| last.wrapping_sub(status.cycle_counter) < OutputConsumer::OLD);
        let ignores = self.hooks.check(StackCheck::IgnoredFrame(data), data.has(DataStatus::IGNORE));
        if is_old || status.transfer_status != 0 || ignores {
            return false;
        }
        (self.counter, self.expires) = (Some(status.cycle_counter), Some(now + self.hold));
        if !is_ready {
            return true;
        }
        let required = DataStatus::PRIMARY | DataStatus::DATA_VALID | DataStatus::RUN;
        let OutputConsumer { outputs, hooks, .. } = self;
        let counts = hooks.check(StackCheck::DataStatus(status.data_status), status.data_status.has(required));
        for output in outputs {
            let end = output.at + output.octets;
            let status = frame.data.get(end).copied().map_or(IoxS::BAD, IoxS);
            let is_good = hooks.check(StackCheck::ProviderStatus(status), status.is_good()) && output.is_usable;
            let data = frame.data.get(output.at..end).filter(|_| counts && is_good);
            if data.is_some() || output.was_good {
                output.deliver(now, application, data, hooks);
            }
            output.was_good = data.is_some();
        }
        true
    }

    /// Says whether the submodule at this slot and subslot can receive outputs. Outputs that end are reported.
    pub(in super::super) fn set_usable(
        &mut self,
        now: Time,
        place: (u16, u16),
        is_usable: bool,
        application: &mut dyn IoApplication,
    ) {
        let OutputConsumer { outputs, hooks, .. } = self;
        for output in outputs.iter_mut().filter(|output| (output.slot, output.subslot) == place) {
            output.set_usable(now, is_usable, application, hooks);
        }
    }

    /// Reports to the application that the outputs have ended.
    pub(in super::super) fn stop(&mut self, now: Time, application: &mut dyn IoApplication) {
        self.expires = None;
        let OutputConsumer { outputs, hooks, .. } = self;
        for output in outputs.iter_mut().filter(|output| hooks.check(StackCheck::OutputsEnd, output.was_good)) {
            output.was_good = false;
            output.deliver(now, application, None, hooks);
        }
    }
}
