//! The controller under test, a station on the other side, and the wire between them, on a simulated clock.

use super::{ScriptedDevice, connection, settings};
use core::time::Duration;
use encspec_controllers::profinet_io::{ArConfig, ArStartUpResult, Controller, ControllerOutcome, ControllerRequest};
use station::{Outbox, Station, Time};
use std::collections::VecDeque;
use wire::datagram::Datagram;
use wire::profinet::rpc::{RpcHeader, RpcPdu};

/// Delay of a frame on the wire.
const TRAVEL: Duration = Duration::from_micros(10);

/// A modification of a frame on the wire.
type Forge = Box<dyn FnMut(&mut Vec<u8>)>;

/// The controller under test, the device, and the wire between them.
pub struct ControllerRig<D = ScriptedDevice> {
    pub controller: Controller,
    pub device: D,
    pub now: Time,
    /// Every frame in the order of arrival: time, whether the controller sent it, bytes.
    pub log: Vec<(Time, bool, Vec<u8>)>,
    /// Applied to each frame of the device before it arrives.
    pub forge: Forge,
    travelling: VecDeque<(Time, bool, Vec<u8>)>,
}

impl ControllerRig {
    pub fn new() -> ControllerRig {
        ControllerRig::with(ScriptedDevice::new())
    }

    /// Starts up `connection` and returns its outcome.
    pub fn start(&mut self, connection: ArConfig) -> ArStartUpResult {
        match self.ask(ControllerRequest::Connect(Box::new(connection))) {
            ControllerOutcome::StartUp(result) => *result,
            other => panic!("a start-up gave {other:?}"),
        }
    }

    /// A rig with an established AR.
    pub fn standing() -> ControllerRig {
        let mut rig = ControllerRig::new();
        let result = rig.start(connection());
        assert!(result.standing && result.failed.is_none(), "{result:?}");
        rig
    }

    /// Makes the device send something.
    pub fn let_device(&mut self, act: impl FnOnce(&mut ScriptedDevice, &mut Outbox)) {
        let mut out = Outbox::new();
        act(&mut self.device, &mut out);
        self.launch(false, &out);
    }
}

impl<D: Station> ControllerRig<D> {
    pub fn with(device: D) -> ControllerRig<D> {
        let controller = Controller::new(settings());
        let (log, travelling) = (Vec::new(), VecDeque::new());
        ControllerRig { controller, device, now: Time::ZERO, log, forge: Box::new(|_| {}), travelling }
    }

    /// Puts frames on the wire.
    pub fn launch(&mut self, from_controller: bool, out: &Outbox) {
        for frame in out.frames() {
            let mut frame = frame.to_vec();
            if !from_controller {
                (self.forge)(&mut frame);
            }
            self.travelling.push_back((self.now + TRAVEL, from_controller, frame));
        }
    }

    /// Runs the next event, not later than `until`; returns false if there is none.
    pub fn step(&mut self, until: Time) -> bool {
        let arrival = self.travelling.front().map(|(time, ..)| *time);
        let (controller_due, device_due) = (self.controller.deadline(), self.device.deadline());
        let Some(next) =
            [arrival, controller_due, device_due].into_iter().flatten().min().filter(|next| *next <= until)
        else {
            self.now = until;
            return false;
        };
        self.now = self.now.max(next);
        let mut out = Outbox::new();
        if arrival == Some(next) {
            let (_, from_controller, frame) = self.travelling.pop_front().expect("a frame arrives");
            if from_controller {
                self.device.receive(self.now, &frame, &mut out);
            } else {
                self.controller.receive(self.now, &frame, &mut out);
            }
            self.log.push((self.now, from_controller, frame));
            self.launch(!from_controller, &out);
        } else if controller_due == Some(next) {
            self.controller.wake(self.now, &mut out);
            self.launch(true, &out);
        } else {
            self.device.wake(self.now, &mut out);
            self.launch(false, &out);
        }
        true
    }

    /// Runs for `time`.
    pub fn run(&mut self, time: Duration) {
        let until = self.now + time;
        while self.step(until) {}
    }

    /// Sends a request to the controller and waits for the outcome, two minutes at most.
    pub fn ask(&mut self, request: ControllerRequest) -> ControllerOutcome {
        self.controller.request(self.now, request).expect("the controller is not busy");
        let until = self.now + Duration::from_secs(120);
        loop {
            if let Some(outcome) = self.controller.take_outcome() {
                return outcome;
            }
            assert!(self.step(until), "no outcome within two minutes");
        }
    }

    /// The frames that the controller sent and that arrived.
    pub fn sent(&self) -> impl Iterator<Item = (Time, &[u8])> {
        self.log
            .iter()
            .filter(|(_, from_controller, _)| *from_controller)
            .map(|(time, _, frame)| (*time, frame.as_slice()))
    }

    /// The headers of their RPC PDUs.
    pub fn sent_pdus(&self) -> Vec<(Time, RpcHeader)> {
        let pdu = |(time, frame)| {
            let datagram = Datagram::parse(frame).ok()?;
            Some((time, RpcPdu::parse(datagram.payload).ok()?.header))
        };
        self.sent().filter_map(pdu).collect()
    }
}
