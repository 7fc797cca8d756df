//! The frames that the device receives.

use super::super::StackBehaviour;
use super::super::plugged::{Expected, Place};
use super::interval;
use crate::profinet::Application;
use alloc::vec::Vec;
use station::{Duration, Time};
use wire::ethernet::Mac;
use wire::profinet::blocks::connect::IocrBlockReq;
use wire::profinet::rt::{CyclicFrame, DataStatus, FrameId, IoxS};

/// Takes the outputs of a connection and watches that they come.
#[derive(Debug)]
pub(in super::super) struct Consumer {
    source: Mac,
    frame_id: FrameId,
    data_length: usize,
    outputs: Vec<Output>,
    hold: Duration,
    expires: Option<Time>,
    counter: Option<u16>,
}

/// The data of a submodule in the frame; its IOPS is behind them.
#[derive(Clone, Copy, Debug)]
struct Output {
    slot: u16,
    subslot: u16,
    at: usize,
    octets: usize,
    was_good: bool,
}

impl Consumer {
    /// How many steps back of the cycle counter mean an old frame and not a new one.
    const OLD: u16 = 4096;

    /// Takes from `source` what `iocr` agrees, under `frame_id`; outputs of submodules that are not plugged are passed over.
    pub(in super::super) fn new(
        source: Mac,
        frame_id: u16,
        iocr: &IocrBlockReq,
        expected: &[Expected],
        is_plugged: impl Fn(&Expected) -> bool,
    ) -> Consumer {
        let mut outputs = Vec::new();
        for api in &iocr.apis {
            for object in &api.io_data_objects {
                let place = Place { api: api.api, slot: object.slot_number, subslot: object.subslot_number };
                let submodule = expected.iter().find(|submodule| submodule.place == place && is_plugged(submodule));
                if let Some(submodule) = submodule {
                    outputs.push(Output {
                        slot: place.slot,
                        subslot: place.subslot,
                        at: object.frame_offset.into(),
                        octets: submodule.output_octets.into(),
                        was_good: false,
                    });
                }
            }
        }
        Consumer {
            source,
            frame_id: FrameId(frame_id),
            data_length: iocr.data_length.into(),
            outputs,
            hold: interval(iocr) * u32::from(iocr.data_hold_factor),
            expires: None,
            counter: None,
        }
    }

    /// Whether a frame with this source and id is one of these.
    pub(in super::super) fn expects(&self, source: Mac, frame_id: FrameId, behaviour: &StackBehaviour) -> bool {
        self.frame_id == frame_id && (self.source == source || !behaviour.checks_source)
    }

    /// Whether a frame, from its frame id on, is as long as was agreed.
    pub(in super::super) fn is_whole(&self, payload: &[u8]) -> bool {
        CyclicFrame::parse(payload, self.data_length).is_ok()
    }

    /// When the outputs count as missing; `None` before the first frame.
    pub(in super::super) fn expires(&self) -> Option<Time> {
        self.expires
    }

    /// Takes a frame, from its frame id on, and says whether it was a new one of the right form.
    ///
    /// The application gets the outputs once it `is_ready`.
    pub(in super::super) fn receive(
        &mut self,
        now: Time,
        payload: &[u8],
        is_ready: bool,
        application: &mut dyn Application,
        behaviour: &StackBehaviour,
    ) -> bool {
        let frame = if behaviour.finds_status_behind_data {
            CyclicFrame::parse(payload, self.data_length)
        } else {
            CyclicFrame::parse_to_end(payload)
        };
        let Ok(frame) = frame else { return false };
        let status = frame.status;
        let is_old = self.counter.is_some_and(|last| last.wrapping_sub(status.cycle_counter) < Consumer::OLD);
        if is_old || status.transfer_status != 0 || status.data_status.has(DataStatus::IGNORE) {
            return false;
        }
        self.counter = Some(status.cycle_counter);
        self.expires = Some(now + (behaviour.hold)(self.hold));
        if !is_ready {
            return true;
        }
        let wanted = DataStatus::PRIMARY | DataStatus::DATA_VALID | DataStatus::RUN;
        let counts = status.data_status.has(wanted) || !behaviour.heeds_data_status;
        let is_provided = |output: &Output| {
            let status = frame.data.get(output.at + output.octets).copied().map_or(IoxS::BAD, IoxS);
            status.is_good() || !behaviour.heeds_provider_status
        };
        let counts = counts && (behaviour.tells_outputs_apart || self.outputs.iter().all(is_provided));
        for output in &mut self.outputs {
            let end = output.at + output.octets;
            let is_good = counts && is_provided(output);
            let data = frame.data.get(output.at..end).filter(|_| is_good);
            if data.is_some() || output.was_good {
                application.outputs(now, output.slot, output.subslot, data);
            }
            output.was_good = data.is_some();
        }
        true
    }

    /// Whether a submodule has outputs that are not good, though frames come.
    pub(in super::super) fn has_bad_outputs(&self) -> bool {
        self.expires.is_some() && self.outputs.iter().any(|output| output.octets > 0 && !output.was_good)
    }

    /// Tells the application that no more outputs come.
    pub(in super::super) fn stop(&mut self, now: Time, application: &mut dyn Application, behaviour: &StackBehaviour) {
        self.expires = None;
        if !behaviour.clears_outputs {
            return;
        }
        for output in self.outputs.iter_mut().filter(|output| output.was_good) {
            output.was_good = false;
            application.outputs(now, output.slot, output.subslot, None);
        }
    }
}
