//! The device as a party on the bus and as a thing on a stand: supply, cable, and the slave that lives while there is power.

use super::application::{Application, Seen};
use super::hooks::SlaveHooks;
use super::slave::{Env, Slave};
use crate::attached::Attached;
use crate::earlier;
use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Refusal, Stand, StandAction, Station, Time};
use wire::profibus::fdl::BaudRate;

/// A PROFIBUS DP device: a slave with the encoder behind it.
///
/// A stand may let time go by for it at once. While a watchdog runs only the encoder's clock jumps, for the master has not
/// waited; otherwise that of the whole device does.
pub struct Device<A> {
    hooks: Attached<dyn SlaveHooks>,
    application: Box<A>,
    /// By how much the encoder's clock is ahead of the slave's.
    encoder_ahead: Duration,
    slave: Slave,
    ahead: Duration,
    /// Whether the supply of the stand is connected.
    is_fed: bool,
    supply: Supply,
    is_linked: bool,
    /// What there was to be seen, by the encoder's clock, as long as nothing happens and no time goes by.
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
    /// A device that has power and is plugged in since long before the run, on a bus of this rate.
    pub fn new(application: A, baud: BaudRate, hooks: Attached<dyn SlaveHooks>) -> Device<A> {
        let slave = Slave::new(baud, hooks.clone(), &application);
        Device {
            hooks,
            application: Box::new(application),
            encoder_ahead: Duration::ZERO,
            slave,
            ahead: Duration::ZERO,
            is_fed: true,
            supply: Supply::On,
            is_linked: true,
            shown: None,
        }
    }

    /// The encoder behind the slave.
    pub fn application(&self) -> &A {
        &self.application
    }

    /// Connects (`true`) or cuts the supply; without power all is silent, and what is not stored is lost.
    pub fn power(&mut self, now: Time, on: bool) {
        self.shown = None;
        self.is_fed = on;
        self.feel_supply(now + self.ahead);
    }

    /// Goes down or starts, as the supply of the stand and what the encoder makes of it say; `now` is by its own clock.
    fn feel_supply(&mut self, now: Time) {
        let at = now + self.encoder_ahead;
        match (self.supply, self.is_fed && self.application.is_alive()) {
            (Supply::Off, true) => {
                self.application.power_up(at);
                self.supply = Supply::Booting { until: now + self.application.identity().boot_time };
            }
            (Supply::On | Supply::Booting { .. }, false) => {
                self.application.power_down(at);
                self.supply = Supply::Off;
                // An application that was gone for a moment only starts again at once.
                if self.is_fed && self.application.is_alive() {
                    self.feel_supply(now);
                }
            }
            (Supply::Off, false) | (Supply::On | Supply::Booting { .. }, true) => {}
        }
    }

    fn seen(&self) -> Seen {
        let seen = Seen {
            has_supply: self.supply != Supply::Off,
            is_booting: matches!(self.supply, Supply::Booting { .. }),
            is_linked: self.is_linked,
            ..Seen::default()
        };
        if self.supply == Supply::On { self.slave.seen(seen) } else { seen }
    }

    fn skip(&mut self, time: Duration) {
        match self.supply == Supply::On && self.slave.is_watching() {
            true => self.encoder_ahead += time,
            false => self.ahead += time,
        }
    }

    fn run(&mut self, now: Time, out: &mut Outbox, input: impl FnOnce(&mut Slave, &mut Env<'_>)) {
        let mut own = Outbox::new();
        let leaves_at_once = self.is_linked && !self.hooks.is_any();
        let sent = if leaves_at_once { &mut *out } else { &mut own };
        let encoder = &mut *self.application;
        let mut env = Env { now, encoder_ahead: self.encoder_ahead, application: encoder, out: sent };
        input(&mut self.slave, &mut env);
        self.slave.settle(&mut env);
        self.feel_supply(now);
        for telegram in own.frames().filter(|_| self.is_linked) {
            let encoder = &*self.application;
            let telegram = self.hooks.apply(telegram.to_vec(), |hooks, mut telegram| {
                hooks.goes(encoder, &mut telegram);
                telegram
            });
            if !telegram.is_empty() {
                out.push(&telegram);
            }
        }
    }

    /// When the encoder has something to do, by the clock of the slave.
    fn encoder_due(&self) -> Option<Time> {
        self.application.deadline().map(|due| due - self.encoder_ahead)
    }
}

impl<A: Application> Station for Device<A> {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.shown = None;
        if !self.is_linked || self.supply != Supply::On {
            return;
        }
        if !self.hooks.is_any() {
            self.run(now + self.ahead, out, |slave, env| slave.receive(env, frame));
            return;
        }
        let application = &*self.application;
        for heard in self.hooks.apply(Vec::new(), |hooks, _| hooks.comes(application, frame)) {
            self.run(now + self.ahead, out, |slave, env| slave.receive(env, &heard));
        }
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.shown = None;
        let now = now + self.ahead;
        if let Supply::Booting { until } = self.supply
            && until <= now
        {
            let application = &mut *self.application;
            let mut env = Env { now, encoder_ahead: self.encoder_ahead, application, out: &mut Outbox::new() };
            self.slave = self.slave.restarted(&mut env);
            self.supply = Supply::On;
        }
        match self.supply {
            Supply::On => self.run(now, out, |slave, env| slave.wake(env)),
            Supply::Booting { .. } if self.encoder_due().is_some_and(|due| due <= now) => {
                self.application.advance(now + self.encoder_ahead);
                self.feel_supply(now);
            }
            Supply::Booting { .. } | Supply::Off => {}
        }
    }

    fn deadline(&self) -> Option<Time> {
        let due = match self.supply {
            Supply::Off => None,
            Supply::Booting { until } => Some(self.encoder_due().map_or(until, |due| due.min(until))),
            Supply::On => earlier(self.slave.deadline(), self.encoder_due()),
        };
        due.map(|due| due - self.ahead)
    }
}

impl<A: Application> Stand for Device<A> {
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, Refusal> {
        self.shown = None;
        self.hooks.notify(|hooks| hooks.act(action));
        match action {
            StandAction::Power(on) => self.power(now, *on),
            StandAction::Link(up) => self.is_linked = *up,
            StandAction::Skip(time) => self.skip(*time),
            other => {
                let ahead = self.ahead + self.encoder_ahead;
                let means = self.application.act(now + ahead, other).map(|done| done - ahead);
                self.feel_supply(now + self.ahead);
                return means.ok_or_else(|| Refusal::CannotDo(String::from("the reference device has no such means")));
            }
        }
        Ok(now)
    }

    fn led(&mut self, now: Time, name: &str) -> Option<&'static str> {
        let now = now + self.ahead + self.encoder_ahead;
        if self.shown.is_none_or(|(at, _)| at != now) {
            let seen = self.seen();
            let seen = Seen { heard: seen.heard.map(|time| time + self.encoder_ahead), ..seen };
            self.application.look(now, &seen);
            self.shown = Some((now, seen));
        }
        let (_, seen) = self.shown.as_ref()?;
        self.application.led(now, name, seen)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.shown = None;
        self.application.counter(now + self.ahead + self.encoder_ahead, name)
    }
}
