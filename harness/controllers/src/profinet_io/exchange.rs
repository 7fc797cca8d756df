//! Cyclic exchange of an AR: the provider sends output frames, the consumer checks input frames.
//!
//! Frames are sent on a grid: multiples of the cycle since the start of the run plus the phase, as in the cycle counter. A late
//! wake sends one frame and skips the missed ones, so frames neither drift nor bunch.

use super::connection::{ArConfig, SEND_CLOCK_UNIT_NANOS};
use super::layout::Layout;
use super::state::{AwaitedEvent, Wait};
use crate::outputs::CyclicOutputs;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::ethernet::{EtherType, FrameHeader, Mac, Vlan};
use wire::octets::Append;
use wire::profinet::rt::{ApduStatus, CyclicFrame, DataStatus, FrameId, Instance, IoxS};

/// Both directions.
#[derive(Debug)]
pub(super) struct IoExchange {
    pub(super) provider: OutputProvider,
    pub(super) consumer: InputConsumer,
}

/// Sends the output frames.
#[derive(Debug)]
pub(super) struct OutputProvider {
    frame: Vec<u8>,
    data_at: usize,
    status_at: usize,
    /// For each output: its index in [`CyclicOutputs`], its offset in the data, its length.
    outputs: Vec<(usize, usize, usize)>,
    iocs: Vec<usize>,
    cycle: u64,
    /// The phase: offset of the grid from the multiples of the cycle, in nanoseconds.
    phase: u64,
    next: Time,
    ready: bool,
}

/// Receives the input frames.
#[derive(Debug)]
pub(super) struct InputConsumer {
    from: Mac,
    frame_id: FrameId,
    data_length: usize,
    /// The IOPS that a valid sample needs: slot, subslot, offset.
    needed: Vec<(u16, u16, usize)>,
    last_counter: Option<u16>,
    hold: Duration,
    /// When the last frame arrived, or since when frames are due.
    last: Option<Time>,
}

/// The two ends of the exchange and the frame IDs.
#[derive(Clone, Copy, Debug)]
pub(super) struct CyclicAddresses {
    pub(super) own: Mac,
    pub(super) device: Mac,
    pub(super) frame_id_in: u16,
    pub(super) frame_id_out: u16,
}

impl IoExchange {
    /// The exchange of `connection`; the first frame leaves at the next grid point after `now`.
    pub(super) fn new(
        connection: &ArConfig,
        layout: &Layout,
        ends: CyclicAddresses,
        outputs: &mut CyclicOutputs,
        now: Time,
    ) -> IoExchange {
        let provider = OutputProvider::new(connection, layout, ends, outputs, now);
        let inputs = || layout.input.data.iter();
        let with_data = inputs().any(|place| place.octets > 0);
        let consumer = InputConsumer {
            from: ends.device,
            frame_id: FrameId(ends.frame_id_in),
            data_length: layout.input.data_length,
            needed: inputs()
                .filter(|place| place.octets > 0 || !with_data)
                .map(|place| (place.slot, place.subslot, place.iops()))
                .collect(),
            last_counter: None,
            hold: connection.data_hold_time().max(Duration::from_nanos(2 * grid(connection))),
            last: None,
        };
        IoExchange { provider, consumer }
    }
}

/// The time between two frames in nanoseconds, never zero.
fn grid(connection: &ArConfig) -> u64 {
    (connection.cycle().as_nanos() as u64).max(SEND_CLOCK_UNIT_NANOS)
}

impl OutputProvider {
    fn new(
        connection: &ArConfig,
        layout: &Layout,
        ends: CyclicAddresses,
        outputs: &mut CyclicOutputs,
        now: Time,
    ) -> OutputProvider {
        let header = FrameHeader::new(ends.device, ends.own, EtherType::PROFINET);
        let tag = Vlan { control: connection.iocr_tag, ..Vlan::RT };
        let header = if connection.vlan { header.tagged(tag) } else { header };
        let mut frame = Vec::new();
        header.write(&mut frame);
        frame.put_u16(ends.frame_id_out);
        let data_at = frame.len();
        let status_at = data_at + layout.output.data_length;
        frame.resize(status_at + ApduStatus::LENGTH, 0);
        frame[status_at + 2] = DataStatus::NORMAL.0;
        let outputs = layout
            .output
            .data
            .iter()
            .map(|place| (outputs.submodule_index(place.slot, place.subslot), place.at, place.octets))
            .collect();
        let iocs = layout.output.iocs.iter().map(|place| place.at).collect();
        let clock = u64::from(connection.send_clock_factor.max(1)) * SEND_CLOCK_UNIT_NANOS;
        let phase = u64::from(connection.phase_out.saturating_sub(1)) * clock;
        let cycle = grid(connection);
        let mut provider = OutputProvider {
            frame,
            data_at,
            status_at,
            outputs,
            iocs,
            cycle,
            phase: phase % cycle,
            next: now,
            ready: false,
        };
        provider.next = provider.after(now);
        provider
    }

    /// The first grid point after `now`.
    fn after(&self, now: Time) -> Time {
        let since = now.as_nanos() + self.cycle - self.phase;
        Time::from_nanos((since / self.cycle).saturating_mul(self.cycle).saturating_add(self.phase))
    }

    /// The device has reported ApplicationReady: the controller's data and IOCS become good.
    pub(super) fn application_is_ready(&mut self) {
        self.ready = true;
    }

    /// When the next frame leaves.
    pub(super) fn deadline(&self) -> Time {
        self.next
    }

    /// Sends the frame that is due, if any; returns whether it did.
    pub(super) fn wake(&mut self, now: Time, outputs: &mut CyclicOutputs, out: &mut Outbox) -> bool {
        if now < self.next {
            return false;
        }
        let due = self.next.as_nanos() + (now.as_nanos() - self.next.as_nanos()) / self.cycle * self.cycle;
        self.next = self.after(now);
        if outputs.is_paused() {
            return false;
        }
        outputs.step();
        self.fill(due, outputs);
        out.push(&self.frame);
        true
    }

    fn fill(&mut self, due: u64, outputs: &CyclicOutputs) {
        let bad = IoxS::bad(Instance::Controller);
        let (data, status) = self.frame[self.data_at..].split_at_mut(self.status_at - self.data_at);
        for &(place, at, octets) in &self.outputs {
            outputs.copy(place, &mut data[at..at + octets]);
            data[at + octets] = if self.ready && outputs.is_good(place) { IoxS::GOOD.0 } else { bad.0 };
        }
        for &at in &self.iocs {
            data[at] = if self.ready { IoxS::GOOD.0 } else { bad.0 };
        }
        let counter = (due / SEND_CLOCK_UNIT_NANOS) as u16;
        status[..2].copy_from_slice(&counter.to_be_bytes());
        status[2] = outputs.sent_data_status().unwrap_or(DataStatus::NORMAL.0);
    }

    /// A copy of the last frame sent, with the offsets of its data and its status.
    pub(super) fn last_frame(&self) -> (Vec<u8>, usize, usize) {
        (self.frame.clone(), self.data_at, self.status_at)
    }
}

/// The kind of a received frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InputSample {
    /// Not a new frame of this stream.
    Foreign,
    /// A frame whose data are not valid.
    Bad,
    /// A frame with valid data.
    Good,
}

impl InputConsumer {
    /// Frames are due from now on, even if none has arrived yet.
    pub(super) fn expect(&mut self, now: Time) {
        self.last.get_or_insert(now);
    }

    /// Excludes submodules from the check for valid samples.
    pub(super) fn exclude(&mut self, is_improper: impl Fn(u16, u16) -> bool) {
        self.needed.retain(|&(slot, subslot, _)| !is_improper(slot, subslot));
    }

    /// Processes a cyclic frame to this controller. A frame whose counter is not ahead by less than 0xF000 is old and is dropped
    /// (IEC 61158-6-10, CPM).
    pub(super) fn receive(&mut self, now: Time, from: Mac, payload: &[u8]) -> InputSample {
        let is_of_stream = from == self.from && FrameId::peek(payload) == Ok(self.frame_id);
        let Some(frame) = CyclicFrame::parse(payload, self.data_length).ok().filter(|_| is_of_stream) else {
            return InputSample::Foreign;
        };
        let ApduStatus { cycle_counter, data_status, transfer_status } = frame.status;
        let new = self.last_counter.is_none_or(|last| (1..=0xF000).contains(&cycle_counter.wrapping_sub(last)));
        if !new || transfer_status != 0 {
            return InputSample::Foreign;
        }
        (self.last_counter, self.last) = (Some(cycle_counter), Some(now));
        let usable = data_status.has(DataStatus::DATA_VALID | DataStatus::RUN) && !data_status.has(DataStatus::IGNORE);
        let good = |&(_, _, at): &(u16, u16, usize)| frame.data.get(at).is_some_and(|octet| IoxS(*octet).is_good());
        if usable && self.needed.iter().all(good) { InputSample::Good } else { InputSample::Bad }
    }

    /// When the data hold time ends.
    pub(super) fn deadline(&self) -> Option<Time> {
        self.last.map(|last| last + self.hold)
    }

    /// The wait that timed out, if any.
    pub(super) fn wake(&self, now: Time) -> Option<Wait> {
        let last = self.last?;
        (now >= last + self.hold).then(|| Wait { what: AwaitedEvent::Data, time: now.since(last) })
    }
}
