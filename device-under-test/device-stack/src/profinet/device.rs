//! The device: a station on the wire and a specimen on a stand. It handles supply and cable and runs the stack while
//! it has power.

use super::clock_offset::OffsetClock;
use super::hooks::StackHooks;
use super::stack::{RetainedStackData, Stack, StackEnv, hooked_identity};
use crate::attached::Attached;
use crate::earlier;
use crate::profinet::{IoApplication, StackStatus};
use crate::supply::SupplyState;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Stand, StandAction, StandRefusal, Station, Time};
use wire::ethernet::Mac;

/// A PROFINET device: a stack and its application.
///
/// A stand can skip time for the device. While a watchdog runs, only the clock of the application jumps, because the
/// controller has not waited. Otherwise the clock of the whole device jumps.
pub struct IoDevice<A> {
    hooks: Attached<dyn StackHooks>,
    application: OffsetClock<A>,
    stack: Stack,
    ahead: Duration,
    /// Whether the stand supplies the device.
    is_supplied: bool,
    supply: SupplyState,
    is_linked: bool,
    /// The stack status at this time, cached until the next event.
    led_status: Option<(Time, StackStatus)>,
}

impl<A: IoApplication> IoDevice<A> {
    /// A device that had power and a cable long before the run: it answers from the start of the run.
    ///
    /// After a power cycle it sends nothing during [`IoIdentity::boot_time`](crate::profinet::IoIdentity::boot_time).
    pub fn new(application: A, mac: Mac, hooks: Attached<dyn StackHooks>) -> IoDevice<A> {
        let stack = Stack::new(Time::ZERO, &application, RetainedStackData::new(mac, hooks.clone()));
        let application = OffsetClock { inner: application, ahead: Duration::ZERO };
        IoDevice {
            hooks,
            application,
            stack,
            ahead: Duration::ZERO,
            is_supplied: true,
            supply: SupplyState::On,
            is_linked: true,
            led_status: None,
        }
    }

    /// The application.
    pub fn application(&self) -> &A {
        &self.application.inner
    }

    /// The application, mutable.
    pub fn application_mut(&mut self) -> &mut A {
        self.led_status = None;
        &mut self.application.inner
    }

    /// Connects (`true`) or cuts the supply. Without power the device sends nothing and loses everything that is not
    /// stored.
    pub fn power(&mut self, now: Time, on: bool) {
        self.led_status = None;
        self.is_supplied = on;
        self.update_supply(now + self.ahead);
    }

    /// Starts or stops the device according to the supply and to [`IoApplication::is_alive`]. `now` is the time of the
    /// device's clock.
    fn update_supply(&mut self, now: Time) {
        match (self.supply, self.is_supplied && self.application.is_alive()) {
            (SupplyState::Off, true) => {
                self.application.power_up(now);
                let identity = hooked_identity(&self.hooks, self.application.identity());
                self.supply = SupplyState::Booting { until: now + identity.boot_time };
            }
            (SupplyState::On | SupplyState::Booting { .. }, false) => {
                self.application.power_down(now);
                self.supply = SupplyState::Off;
                // After a short interruption the application starts again at once.
                if self.is_supplied && self.application.is_alive() {
                    self.update_supply(now);
                }
            }
            (SupplyState::Off, false) | (SupplyState::On | SupplyState::Booting { .. }, true) => {}
        }
    }

    /// Plugs in (`true`) or unplugs the cable. Without it the device receives nothing and its frames are lost.
    pub fn link(&mut self, now: Time, up: bool) {
        self.led_status = None;
        if up && !self.is_linked {
            self.stack.announce(now + self.ahead);
        }
        self.is_linked = up;
    }

    /// Whether the LED flashes for DCP Signal at `now`.
    pub fn is_signalling(&self, now: Time) -> bool {
        self.supply == SupplyState::On && self.stack.is_signalling(now + self.ahead)
    }

    /// The status of device and stack at `now`.
    fn status(&self, now: Time) -> StackStatus {
        let status = StackStatus {
            has_supply: self.supply != SupplyState::Off,
            is_booting: matches!(self.supply, SupplyState::Booting { .. }),
            is_linked: self.is_linked,
            ..StackStatus::default()
        };
        if self.supply == SupplyState::On { self.stack.complete_status(now, status) } else { status }
    }

    /// Skips `time`.
    pub fn skip(&mut self, time: Duration) {
        self.led_status = None;
        if self.supply == SupplyState::On && self.stack.is_monitoring_outputs() {
            self.application.ahead += time;
        } else {
            self.ahead += time;
        }
    }

    /// The next time, by the device's clock, at which something is due.
    fn due(&self) -> Option<Time> {
        match self.supply {
            SupplyState::Off => None,
            SupplyState::Booting { until } => Some(self.application.deadline().map_or(until, |due| due.min(until))),
            SupplyState::On => {
                let due = earlier(self.stack.deadline(), self.application.deadline());
                self.hooks.apply(due, |hooks, due| hooks.due(due))
            }
        }
    }

    fn run(&mut self, now: Time, out: &mut Outbox, input: impl FnOnce(&mut Stack, &mut StackEnv<'_>)) {
        let mut unhooked = Outbox::new();
        let leaves_at_once = self.is_linked && !self.hooks.is_any();
        let sent = if leaves_at_once { &mut *out } else { &mut unhooked };
        let before = sent.frames().count();
        let mut env = StackEnv { now, application: &mut self.application, out: sent };
        input(&mut self.stack, &mut env);
        self.stack.process_pending(&mut env);
        env.out.frames().skip(before).for_each(|frame| self.stack.traffic.count_sent(frame));
        self.update_supply(now);
        for frame in unhooked.frames().filter(|_| self.is_linked) {
            let view = self.stack.view(now, &self.application);
            let frame = self.hooks.apply(frame.to_vec(), |hooks, mut frame| {
                hooks.sent_frame(&view, &mut frame);
                frame
            });
            if !frame.is_empty() {
                out.push(&frame);
            }
        }
        let late = self.hooks.apply(Vec::new(), |hooks, mut frames| {
            hooks.late_sent(now, &mut frames);
            frames
        });
        for frame in late.iter().filter(|_| self.is_linked) {
            out.push(frame);
        }
    }

    /// Processes the received frames that were held back and are due.
    fn receive_late_frames(&mut self, now: Time, out: &mut Outbox) {
        let frames = self.hooks.apply(Vec::new(), |hooks, mut frames| {
            hooks.late_received(now, &mut frames);
            frames
        });
        for frame in frames {
            self.run(now, out, |stack, env| stack.receive(env, &frame));
        }
    }
}

impl<A: IoApplication> Station for IoDevice<A> {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.led_status = None;
        if !self.is_linked || self.supply != SupplyState::On {
            return;
        }
        let now = now + self.ahead;
        if !self.hooks.is_any() {
            return self.run(now, out, |stack, env| stack.receive(env, frame));
        }
        let view = self.stack.view(now, &self.application);
        for frame in self.hooks.apply(vec![frame.to_vec()], |hooks, frames| hooks.received_frames(&view, frames)) {
            self.run(now, out, |stack, env| stack.receive(env, &frame));
        }
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.led_status = None;
        let now = now + self.ahead;
        if let SupplyState::Booting { until } = self.supply
            && until <= now
        {
            self.stack = Stack::new(now, &self.application, self.stack.retained_data());
            self.supply = SupplyState::On;
        }
        match self.supply {
            SupplyState::On => {
                self.receive_late_frames(now, out);
                self.run(now, out, |stack, env| stack.wake(env));
            }
            SupplyState::Booting { .. } if self.application.deadline().is_some_and(|due| due <= now) => {
                self.application.advance(now);
                self.update_supply(now);
            }
            SupplyState::Booting { .. } | SupplyState::Off => {}
        }
    }

    fn deadline(&self) -> Option<Time> {
        self.due().map(|due| due - self.ahead)
    }
}

impl<A: IoApplication> Stand for IoDevice<A> {
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, StandRefusal> {
        self.led_status = None;
        match action {
            StandAction::Power(on) => self.power(now, *on),
            StandAction::Link(up) => self.link(now, *up),
            StandAction::Skip(time) => self.skip(*time),
            other => {
                let means = self.application.act(now + self.ahead, other).map(|done| done - self.ahead);
                self.update_supply(now + self.ahead);
                return means.ok_or_else(|| {
                    StandRefusal::CannotDo(String::from("the reference device does not support this action"))
                });
            }
        }
        Ok(now)
    }

    fn led(&mut self, now: Time, name: &str) -> Option<&'static str> {
        let now = now + self.ahead;
        if self.led_status.is_none_or(|(at, _)| at != now) {
            self.led_status = Some((now, self.status(now)));
        }
        let (_, status) = self.led_status.as_ref()?;
        self.application.led(now, name, status)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.application.counter(now + self.ahead, name)
    }
}
