//! The device as a party on the wire and as a thing on a stand: supply, cable, and the stack that lives while there is power.

use super::ahead::Ahead;
use super::hooks::{Hooks, StackHooks};
use super::stack::{Env, Kept, Stack};
use crate::attached::Attached;
use crate::earlier;
use crate::profinet::{Application, Seen};
use alloc::string::String;
use alloc::vec;
use core::time::Duration;
use station::{Outbox, Refusal, Stand, StandAction, Station, Time};
use wire::ethernet::Mac;

/// A PROFINET device: a stack with the encoder behind it.
///
/// A stand may let time go by for it at once. While a watchdog runs only the encoder's clock jumps, for the other end of
/// the connection has not waited; otherwise that of the whole device does.
pub struct Device<A> {
    hooks: Attached<dyn StackHooks>,
    application: Ahead<A>,
    stack: Stack,
    ahead: Duration,
    /// Whether the supply of the stand is connected.
    is_fed: bool,
    supply: Supply,
    is_linked: bool,
    /// What there was to be seen, as long as nothing happens and no time goes by.
    shown: Option<(Time, Seen)>,
}

/// Whether there is power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Supply {
    Off,
    Booting { until: Time },
    On,
}

impl<A: Application> Device<A> {
    /// A device that has power and is plugged in since long before the run: it answers from the start of the run on.
    ///
    /// After a power cycle it is silent for the boot time of its identity.
    pub fn new(application: A, mac: Mac, hooks: Attached<dyn StackHooks>) -> Device<A> {
        let stack = Stack::new(Time::ZERO, &application, Kept::new(mac, Hooks(hooks.clone())));
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

    /// The encoder behind the stack.
    pub fn application(&self) -> &A {
        &self.application.inner
    }

    /// The encoder behind the stack, to be changed.
    pub fn application_mut(&mut self) -> &mut A {
        self.shown = None;
        &mut self.application.inner
    }

    /// Connects (`true`) or cuts the supply; without power all is silent, and what is not stored is lost.
    pub fn power(&mut self, now: Time, on: bool) {
        self.shown = None;
        self.is_fed = on;
        self.feel_supply(now + self.ahead);
    }

    /// Goes down or starts, as the supply of the stand and what the encoder makes of it say; `now` is by its own clock.
    fn feel_supply(&mut self, now: Time) {
        match (self.supply, self.is_fed && self.application.is_alive()) {
            (Supply::Off, true) => {
                self.application.power_up(now);
                self.supply = Supply::Booting { until: now + self.application.identity().boot_time };
            }
            (Supply::On | Supply::Booting { .. }, false) => {
                self.application.power_down(now);
                self.supply = Supply::Off;
                // An application that was gone for a moment only starts again at once.
                if self.is_fed && self.application.is_alive() {
                    self.feel_supply(now);
                }
            }
            (Supply::Off, false) | (Supply::On | Supply::Booting { .. }, true) => {}
        }
    }

    /// Plugs (`true`) or pulls the cable; without it nothing is received and what is sent is lost.
    pub fn link(&mut self, now: Time, up: bool) {
        self.shown = None;
        if up && !self.is_linked {
            self.stack.announce(now + self.ahead);
        }
        self.is_linked = up;
    }

    /// Whether the light that DCP Signal lets flash is flashing at `now`.
    pub fn is_signalling(&self, now: Time) -> bool {
        self.supply == Supply::On && self.stack.is_signalling(now + self.ahead)
    }

    /// What there is to be seen of the stack at `now`.
    fn seen(&self, now: Time) -> Seen {
        let seen = Seen {
            has_supply: self.supply != Supply::Off,
            is_booting: matches!(self.supply, Supply::Booting { .. }),
            is_linked: self.is_linked,
            ..Seen::default()
        };
        if self.supply == Supply::On { self.stack.seen(now, seen) } else { seen }
    }

    /// Lets `time` go by at once.
    pub fn skip(&mut self, time: Duration) {
        self.shown = None;
        match self.supply == Supply::On && self.stack.is_watching() {
            true => self.application.by += time,
            false => self.ahead += time,
        }
    }

    /// The next time by its own clock at which something is due.
    fn due(&self) -> Option<Time> {
        match self.supply {
            Supply::Off => None,
            Supply::Booting { until } => Some(self.application.deadline().map_or(until, |due| due.min(until))),
            Supply::On => earlier(self.stack.deadline(), self.application.deadline()),
        }
    }

    fn run(&mut self, now: Time, out: &mut Outbox, input: impl FnOnce(&mut Stack, &mut Env<'_>)) {
        let mut own = Outbox::new();
        let leaves_at_once = self.is_linked && !self.hooks.is_any();
        let sent = if leaves_at_once { &mut *out } else { &mut own };
        let mut env = Env { now, application: &mut self.application, out: sent };
        input(&mut self.stack, &mut env);
        self.stack.settle(&mut env);
        self.feel_supply(now);
        for frame in own.frames().filter(|_| self.is_linked) {
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
                return means.ok_or_else(|| Refusal::CannotDo(String::from("the reference device has no such means")));
            }
        }
        Ok(now)
    }

    fn led(&mut self, now: Time, name: &str) -> Option<&'static str> {
        let now = now + self.ahead;
        if self.shown.is_none_or(|(at, _)| at != now) {
            self.shown = Some((now, self.seen(now)));
        }
        let (_, seen) = self.shown.as_ref()?;
        self.application.led(now, name, seen)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.application.counter(now + self.ahead, name)
    }
}
