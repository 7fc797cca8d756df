//! The cyclic frames that the device sends.

use super::super::hooks::{AttachedStackHooks, StackCheck};
use super::super::plugged::{ExpectedSubmoduleData, SubmoduleAddress};
use super::super::stack::StackEnv;
use super::input::{InputOffset, IocsOffset};
use super::{CLOCK, interval, put, status};
use alloc::vec::Vec;
use station::{Duration, Time};
use wire::ethernet::{EtherType, FrameHeader, Mac, Vlan};
use wire::profinet::blocks::connect::IocrBlockReq;
use wire::profinet::rt::{ApduStatus, DataStatus};

/// Sends the inputs of a connection in each cycle.
#[derive(Debug)]
pub(in super::super) struct InputProvider {
    frame: Vec<u8>,
    status_at: usize,
    inputs: Vec<InputOffset>,
    consumer_status: Vec<IocsOffset>,
    interval: Duration,
    due: Time,
    hooks: AttachedStackHooks,
}

/// The state that determines the status bytes of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) struct ProviderState {
    /// Whether the inputs can be good, because the application is ready.
    pub inputs_are_ready: bool,
    /// Whether the outputs are consumed, because the application is ready.
    pub takes_outputs: bool,
    /// Whether a fault is pending.
    pub has_problem: bool,
}

impl InputProvider {
    /// A provider that sends frames to `destination`, laid out as `iocr` says, from the next cycle after `now` on.
    ///
    /// `is_usable` says whether an expected submodule is plugged and owned by the connection. `iocr` must have been checked against `expected`.
    pub(in super::super) fn new(
        now: Time,
        (destination, source): (Mac, Mac),
        iocr: &IocrBlockReq,
        expected: &[ExpectedSubmoduleData],
        is_usable: impl Fn(&ExpectedSubmoduleData) -> bool,
        hooks: AttachedStackHooks,
    ) -> InputProvider {
        let tag = Vlan { protocol: EtherType::VLAN, control: iocr.iocr_tag_header };
        let mut frame = Vec::new();
        FrameHeader::new(destination, source, EtherType::PROFINET).tagged(tag).write(&mut frame);
        frame.extend(iocr.frame_id.to_be_bytes());
        let data_at = frame.len();
        let status_at = data_at + usize::from(iocr.data_length);
        frame.resize(status_at + ApduStatus::LENGTH, 0);
        let mut provider = InputProvider {
            frame,
            status_at,
            inputs: Vec::new(),
            consumer_status: Vec::new(),
            interval: interval(iocr),
            due: now,
            hooks,
        };
        for api in &iocr.apis {
            let find = |slot, subslot| {
                let place = SubmoduleAddress { api: api.api, slot, subslot };
                let found = expected.iter().find(|submodule| submodule.place == place);
                found.filter(|submodule| !submodule.discards_status)
            };
            for object in &api.io_data_objects {
                let Some(submodule) = find(object.slot_number, object.subslot_number) else { continue };
                provider.inputs.push(InputOffset {
                    slot: object.slot_number,
                    subslot: object.subslot_number,
                    at: data_at + usize::from(object.frame_offset),
                    octets: submodule.input_octets.into(),
                    is_usable: is_usable(submodule),
                });
            }
            for object in &api.iocs {
                let Some(submodule) = find(object.slot_number, object.subslot_number) else { continue };
                provider.consumer_status.push(IocsOffset {
                    slot: object.slot_number,
                    subslot: object.subslot_number,
                    at: data_at + usize::from(object.frame_offset),
                    is_usable: is_usable(submodule),
                });
            }
        }
        let phase = CLOCK * u32::from(iocr.send_clock_factor) * u32::from(iocr.phase.saturating_sub(1));
        let cycles = (now.as_nanos() / provider.cycle_nanos() + 1).saturating_mul(provider.cycle_nanos());
        provider.due = Time::from_nanos(cycles) + phase;
        provider
    }

    fn cycle_nanos(&self) -> u64 {
        (self.interval.as_nanos() as u64).max(1)
    }

    /// Says whether the submodule at this slot and subslot can have good data.
    pub(in super::super) fn set_usable(&mut self, place: (u16, u16), is_usable: bool) {
        for input in self.inputs.iter_mut().filter(|input| (input.slot, input.subslot) == place) {
            input.is_usable = is_usable;
        }
        for outputs in self.consumer_status.iter_mut().filter(|outputs| (outputs.slot, outputs.subslot) == place) {
            outputs.is_usable = is_usable;
        }
    }

    /// When the next frame is due.
    pub(in super::super) fn due(&self) -> Time {
        self.due
    }

    /// Sends a frame if one is due. Missed frames are skipped.
    pub(in super::super) fn wake(&mut self, env: &mut StackEnv<'_>, state: ProviderState) {
        if env.now < self.due {
            return;
        }
        let (late, cycle) = (env.now.as_nanos() - self.due.as_nanos(), self.cycle_nanos());
        // A frame is nearly always sent in its own cycle.
        let missed = if late < cycle { 0 } else { late - late % cycle };
        let sent_at = self.due + Duration::from_nanos(missed);
        self.due = sent_at + self.interval;
        env.application.frame(env.now);
        let InputProvider { frame, inputs, consumer_status, hooks, .. } = self;
        let status = |is_good| hooks.apply(status(is_good), |hooks, status| hooks.status(status)).0;
        for input in inputs.iter() {
            let end = input.at + input.octets;
            let Some(data) = frame.get_mut(input.at..end) else { continue };
            let is_good = hooks.check(StackCheck::Usable(input.slot, input.subslot), input.is_usable)
                && (data.is_empty() || env.application.inputs(env.now, input.slot, input.subslot, data));
            put(frame, end, status(is_good && state.inputs_are_ready));
        }
        for outputs in consumer_status.iter() {
            let is_usable = hooks.check(StackCheck::Consumes(outputs.slot, outputs.subslot), outputs.is_usable);
            put(frame, outputs.at, status(is_usable && state.takes_outputs));
        }
        let [high, low] = ((sent_at.as_nanos() / CLOCK.as_nanos() as u64) as u16).to_be_bytes();
        let problem = if state.has_problem { DataStatus::NO_PROBLEM } else { 0 };
        for (offset, byte) in [high, low, DataStatus::NORMAL.0 & !problem, 0].into_iter().enumerate() {
            put(&mut self.frame, self.status_at + offset, byte);
        }
        env.out.push(&self.frame);
    }
}
