//! A reference device at a wire that a fuzzer disturbs: frames of either side are changed, lost, doubled or late, or are its own.
//!
//! The controller, the master, the stacks of the devices and the judges must not panic, and a trial must end. Whether it passes is not
//! asked: a disturbed wire excuses much.

use crate::MANUALS;
use deviations::{Line, ReferenceDevice, Setup, subject};
use engine::dut::{DEVICE, STATION_NAME, virtual_segment};
use engine::segment::{DeviceOnStand, FactoryBuild, ModelOnStand};
use engine::{DutKind, DutSpec, RunOptions, dp_line, run_trial_on};
use station::{Duration, Outbox, Stand, Station, Time};
use std::collections::VecDeque;
use suite::model::{Manual, SuiteVariant, Trial};

/// More frames than this are not disturbed.
const MOST: usize = 4000;

/// The trials of a manual's first variant.
pub fn trials(manual: &str) -> (&'static Manual, &'static SuiteVariant) {
    let manual = MANUALS.iter().find(|of| of.device.name == manual).expect("a manual of `MANUALS`");
    (manual, manual.variants.first().expect("a variant"))
}

/// Runs the trial that the first two bytes choose, with what the others do to the wire.
pub fn exchange(manual: &str, data: &[u8]) {
    let Some((&[low, high], changes)) = data.split_first_chunk() else { return };
    let (manual, variant) = trials(manual);
    let trial: &Trial = &variant.trials[usize::from(u16::from_le_bytes([low, high])) % variant.trials.len()];
    let dut = DutSpec {
        manual: manual.device.name.clone(),
        variant: variant.name.clone(),
        kind: DutKind::Model { deviations: Vec::new() },
    };
    let line = dp_line(&dut, manual, Some(trial));
    let build = {
        let (name, variant) = (dut.manual.clone(), dut.variant.clone());
        move || -> Result<Box<dyn ReferenceDevice>, String> {
            let subject = subject(&name).map_err(|error| error.to_string())?;
            let setup = Setup {
                mac: subject.manual.mac(DEVICE.0.0),
                shaft: 12_345,
                station_name: STATION_NAME,
                line: Line { address: line.station, baud: line.baud },
                ..Setup::default()
            };
            subject.build(&variant, &setup).map_err(|error| error.to_string())
        }
    };
    let device = build().expect("a device of `MANUALS`");
    let deliver: FactoryBuild<'_> = Box::new(build);
    let changes = changes.iter().copied().collect();
    let device = DisturbedDevice {
        device: ModelOnStand::new(device, deliver),
        changes,
        sent: Outbox::new(),
        late: VecDeque::new(),
        last: Vec::new(),
        passed: 0,
    };
    let segment = virtual_segment(device, line, manual.device.profibus().is_some());
    std::hint::black_box(run_trial_on(segment, manual, variant, &dut, trial, &RunOptions::default()));
}

/// A device whose wire is disturbed: the bytes that are left say what happens to the next frame.
struct DisturbedDevice<'a> {
    device: ModelOnStand<'a>,
    changes: VecDeque<u8>,
    sent: Outbox,
    /// Frames that are sent later.
    late: VecDeque<(Time, Vec<u8>)>,
    last: Vec<u8>,
    passed: usize,
}

impl DisturbedDevice<'_> {
    fn next(&mut self) -> u8 {
        self.changes.pop_front().unwrap_or(0)
    }

    fn place(&mut self, length: usize) -> usize {
        let place = u16::from_le_bytes([self.next(), self.next()]);
        usize::from(place) % length.max(1)
    }

    /// The frames that come out for one that went in, at once or late.
    fn disturb(&mut self, now: Time, frame: &[u8], out: &mut Vec<Vec<u8>>) {
        self.passed += 1;
        let kind = if self.passed > MOST { 0 } else { self.next() };
        let mut frame = frame.to_vec();
        match kind & 0x0F {
            1 => {
                let at = self.place(frame.len());
                let with = self.next();
                if let Some(octet) = frame.get_mut(at) {
                    *octet = with;
                }
            }
            2 => {
                let at = self.place(frame.len());
                let word = [self.next(), self.next(), self.next(), self.next()];
                frame.iter_mut().skip(at).zip(word).for_each(|(octet, with)| *octet = with);
            }
            3 => frame.truncate(self.place(frame.len())),
            4 => frame.extend(std::iter::repeat_n(self.next(), usize::from(kind >> 4) * 20)),
            5 => {
                let (at, count) = (self.place(frame.len()), usize::from(self.next()));
                let piece: Vec<u8> = frame.iter().skip(at).take(count).copied().collect();
                frame.splice(at..at, piece);
            }
            6 => return,
            7 => out.push(frame.clone()),
            8 => {
                let wait = Duration::from_micros(u64::from(self.next()) * u64::from(self.next()) * 50);
                self.late.push_back((now + wait, frame));
                return;
            }
            9 if !self.last.is_empty() => out.push(self.last.clone()),
            10 => {
                let (at, from) = (self.place(frame.len()), self.place(self.last.len()));
                let piece: Vec<u8> = self.last.iter().skip(from).copied().collect();
                frame.truncate(at);
                frame.extend(piece);
            }
            _ => {}
        }
        self.last.clone_from(&frame);
        out.push(frame);
    }

    fn pass(&mut self, now: Time, out: &mut Outbox) {
        let sent: Vec<Vec<u8>> = self.sent.frames().map(<[u8]>::to_vec).collect();
        self.sent.clear();
        let mut disturbed = Vec::new();
        sent.iter().for_each(|frame| self.disturb(now, frame, &mut disturbed));
        disturbed.iter().for_each(|frame| out.push(frame));
        while self.late.front().is_some_and(|(due, _)| *due <= now) {
            self.late.pop_front().iter().for_each(|(_, frame)| out.push(frame));
        }
    }
}

impl Station for DisturbedDevice<'_> {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        let mut arriving = Vec::new();
        self.disturb(now, frame, &mut arriving);
        for frame in arriving {
            self.device.receive(now, &frame, &mut self.sent);
        }
        self.pass(now, out);
    }

    fn carrier(&mut self, now: Time) {
        self.device.carrier(now);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.device.wake(now, &mut self.sent);
        self.pass(now, out);
    }

    fn deadline(&self) -> Option<Time> {
        self.device.deadline().into_iter().chain(self.late.front().map(|(due, _)| *due)).min()
    }
}

impl DeviceOnStand for DisturbedDevice<'_> {
    fn station(&mut self) -> &mut dyn Station {
        self
    }

    fn stand(&mut self) -> &mut dyn Stand {
        &mut self.device
    }
}
