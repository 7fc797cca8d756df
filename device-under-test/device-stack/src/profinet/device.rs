//! The device: a station on the wire and a specimen on a stand. It handles supply and cable and runs the stack while
//! it has power.

use super::ahead::Ahead;
use super::hooks::StackHooks;
use super::stack::{Env, Kept, Stack};
use crate::attached::Attached;
use crate::earlier;
use crate::profinet::{Application, Seen};
use crate::supply::Supply;
use alloc::string::String;
use alloc::vec;
use core::time::Duration;
use station::{Outbox, Refusal, Stand, StandAction, Station, Time};
use wire::ethernet::Mac;

/// A PROFINET device: a stack and its application.
///
/// A stand can skip time for the device. While a watchdog runs, only the clock of the application jumps, because the
/// controller has not waited. Otherwise the clock of the whole device jumps.
pub struct Device<A> {
    hooks: Attached<dyn StackHooks>,
    application: Ahead<A>,
    stack: Stack,
    ahead: Duration,
    /// Whether the stand supplies the device.
    is_fed: bool,
    supply: Supply,
    is_linked: bool,
    /// The stack status at this time, cached until the next event.
    shown: Option<(Time, Seen)>,
}

impl<A: Application> Device<A> {
    /// A device that had power and a cable long before the run: it answers from the start of the run.
    ///
    /// After a power cycle it sends nothing during [`Identity::boot_time`](crate::profinet::Identity::boot_time).
    pub fn new(application: A, mac: Mac, hooks: Attached<dyn StackHooks>) -> Device<A> {
        let stack = Stack::new(Time::ZERO, &application, Kept::new(mac, hooks.clone()));
        let application = Ahead { inner: application, by: Duration::ZERO };
        Device {
            hooks,
            application,
            stack,
            ahead: Duration::ZERO,
            is_fed: true,
            supply: Supply::On,
            is_linked: true,
            shown: None,
        }
    }

    /// The application.
    pub fn application(&self) -> &A {
        &self.application.inner
    }

    /// The application, mutable.
    pub fn application_mut(&mut self) -> &mut A {
        self.shown = None;
        &mut self.application.inner
    }

    /// Connects (`true`) or cuts the supply. Without power the device sends nothing and loses everything that is not
    /// stored.
    pub fn power(&mut self, now: Time, on: bool) {
        self.shown = None;
        self.is_fed = on;
        self.feel_supply(now + self.ahead);
    }

    /// Starts or stops the device according to the supply and to [`Application::is_alive`]. `now` is the time of the
    /// device's clock.
    fn feel_supply(&mut self, now: Time) {
        match (self.supply, self.is_fed && self.application.is_alive()) {
            (Supply::Off, true) => {
                self.application.power_up(now);
                self.supply = Supply::Booting { until: now + self.application.identity().boot_time };
            }
            (Supply::On | Supply::Booting { .. }, false) => {
                self.application.power_down(now);
                self.supply = Supply::Off;
                // After a short interruption the application starts again at once.
                if self.is_fed && self.application.is_alive() {
                    self.feel_supply(now);
                }
            }
            (Supply::Off, false) | (Supply::On | Supply::Booting { .. }, true) => {}
        }
    }

    /// Plugs in (`true`) or unplugs the cable. Without it the device receives nothing and its frames are lost.
    pub fn link(&mut self, now: Time, up: bool) {
        self.shown = None;
        if up && !self.is_linked {
            self.stack.announce(now + self.ahead);
        }
        self.is_linked = up;
    }

    /// Whether the LED flashes for DCP Signal at `now`.
    pub fn is_signalling(&self, now: Time) -> bool {
        self.supply == Supply::On && self.stack.is_signalling(now + self.ahead)
    }

    /// The status of device and stack at `now`.
    fn seen(&self, now: Time) -> Seen {
        let status = Seen {
            has_supply: self.supply != Supply::Off,
            is_booting: matches!(self.supply, Supply::Booting { .. }),
            is_linked: self.is_linked,
            ..Seen::default()
        };
        if self.supply == Supply::On { self.stack.seen(now, status) } else { status }
    }

    /// Skips `time`.
    pub fn skip(&mut self, time: Duration) {
        self.shown = None;
        if self.supply == Supply::On && self.stack.is_watching() {
            self.application.by += time;
        } else {
            self.ahead += time;
        }
    }

    /// The next time, by the device's clock, at which something is due.
    fn due(&self) -> Option<Time> {
        match self.supply {
            Supply::Off => None,
            Supply::Booting { until } => Some(self.application.deadline().map_or(until, |due| due.min(until))),
            Supply::On => earlier(self.stack.deadline(), self.application.deadline()),
        }
    }

    fn run(&mut self, now: Time, out: &mut Outbox, input: impl FnOnce(&mut Stack, &mut Env<'_>)) {
        let mut unhooked = Outbox::new();
        let leaves_at_once = self.is_linked && !self.hooks.is_any();
        let sent = if leaves_at_once { &mut *out } else { &mut unhooked };
        let mut env = Env { now, application: &mut self.application, out: sent };
        input(&mut self.stack, &mut env);
        self.stack.settle(&mut env);
        self.feel_supply(now);
        for frame in unhooked.frames().filter(|_| self.is_linked) {
            let view = self.stack.view(now, &self.application);
            let frame = self.hooks.apply(frame.to_vec(), |hooks, mut frame| {
                hooks.goes(&view, &mut frame);
                frame
            });
            if !frame.is_empty() {
                out.push(&frame);
            }
        }
    }
}

impl<A: Application> Station for Device<A> {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.shown = None;
        if !self.is_linked || self.supply != Supply::On {
            return;
        }
        let now = now + self.ahead;
        if !self.hooks.is_any() {
            return self.run(now, out, |stack, env| stack.receive(env, frame));
        }
        let view = self.stack.view(now, &self.application);
        for frame in self.hooks.apply(vec![frame.to_vec()], |hooks, frames| hooks.comes(&view, frames)) {
            self.run(now, out, |stack, env| stack.receive(env, &frame));
        }
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.shown = None;
        let now = now + self.ahead;
        if let Supply::Booting { until } = self.supply
            && until <= now
        {
            self.stack = Stack::new(now, &self.application, self.stack.kept());
            self.supply = Supply::On;
        }
        match self.supply {
            Supply::On => self.run(now, out, |stack, env| stack.wake(env)),
            Supply::Booting { .. } if self.application.deadline().is_some_and(|due| due <= now) => {
                self.application.advance(now);
                self.feel_supply(now);
            }
            Supply::Booting { .. } | Supply::Off => {}
        }
    }

    fn deadline(&self) -> Option<Time> {
        self.due().map(|due| due - self.ahead)
    }
}

impl<A: Application> Stand for Device<A> {
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, Refusal> {
        self.shown = None;
        match action {
            StandAction::Power(on) => self.power(now, *on),
            StandAction::Link(up) => self.link(now, *up),
            StandAction::Skip(time) => self.skip(*time),
            other => {
                let means = self.application.act(now + self.ahead, other).map(|done| done - self.ahead);
                self.feel_supply(now + self.ahead);
                return means.ok_or_else(|| {
                    Refusal::CannotDo(String::from("the reference device does not support this action"))
                });
            }
        }
        Ok(now)
    }

    fn led(&mut self, now: Time, name: &str) -> Option<&'static str> {
        let now = now + self.ahead;
        if self.shown.is_none_or(|(at, _)| at != now) {
            self.shown = Some((now, self.seen(now)));
        }
        let (_, status) = self.shown.as_ref()?;
        self.application.led(now, name, status)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.application.counter(now + self.ahead, name)
    }
}
