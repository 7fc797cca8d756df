//! The device: a station on the bus and a specimen on a stand. It handles supply and cable and runs the slave while
//! it has power.

use super::application::{SlaveApplication, SlaveStatus};
use super::hooks::SlaveHooks;
use super::slave::{PoweredSlave, SlaveEnv};
use crate::attached::Attached;
use crate::earlier;
use crate::supply::SupplyState;
use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Stand, StandAction, StandRefusal, Station, Time};
use wire::profibus::fdl::BaudRate;

/// A PROFIBUS DP device: a slave and its application.
///
/// A stand can skip time for the device. While a watchdog runs, only the clock of the application jumps, because the
/// master has not waited. Otherwise the clock of the whole device jumps.
pub struct DpDevice<A> {
    hooks: Attached<dyn SlaveHooks>,
    application: Box<A>,
    /// By how much the clock of the application is ahead of the clock of the slave.
    encoder_ahead: Duration,
    slave: PoweredSlave,
    ahead: Duration,
    /// Whether the stand supplies the device.
    is_supplied: bool,
    supply: SupplyState,
    is_linked: bool,
    /// The slave status at this time of the application's clock, cached until the next event.
    shown: Option<(Time, SlaveStatus)>,
}

impl<A: SlaveApplication> DpDevice<A> {
    /// A device that had power and a cable long before the run, on a bus with this baud rate.
    pub fn new(application: A, baud: BaudRate, hooks: Attached<dyn SlaveHooks>) -> DpDevice<A> {
        let slave = PoweredSlave::new(baud, hooks.clone(), &application);
        DpDevice {
            hooks,
            application: Box::new(application),
            encoder_ahead: Duration::ZERO,
            slave,
            ahead: Duration::ZERO,
            is_supplied: true,
            supply: SupplyState::On,
            is_linked: true,
            shown: None,
        }
    }

    /// The application.
    pub fn application(&self) -> &A {
        &self.application
    }

    /// Connects (`true`) or cuts the supply. Without power the device sends nothing and loses everything that is not
    /// stored.
    pub fn power(&mut self, now: Time, on: bool) {
        self.shown = None;
        self.is_supplied = on;
        self.update_supply(now + self.ahead);
    }

    /// Starts or stops the device according to the supply and to [`SlaveApplication::is_alive`]. `now` is the time of the
    /// slave's clock.
    fn update_supply(&mut self, now: Time) {
        let at = now + self.encoder_ahead;
        match (self.supply, self.is_supplied && self.application.is_alive()) {
            (SupplyState::Off, true) => {
                self.application.power_up(at);
                let takes = self.application.identity().boot_time;
                let takes = self.hooks.apply(takes, |hooks, takes| hooks.boot_time(takes));
                self.supply = SupplyState::Booting { until: now + takes };
            }
            (SupplyState::On | SupplyState::Booting { .. }, false) => {
                self.application.power_down(at);
                self.supply = SupplyState::Off;
                // After a short interruption the application starts again at once.
                if self.is_supplied && self.application.is_alive() {
                    self.update_supply(now);
                }
            }
            (SupplyState::Off, false) | (SupplyState::On | SupplyState::Booting { .. }, true) => {}
        }
    }

    fn status(&self) -> SlaveStatus {
        let status = SlaveStatus {
            has_supply: self.supply != SupplyState::Off,
            is_booting: matches!(self.supply, SupplyState::Booting { .. }),
            is_linked: self.is_linked,
            ..SlaveStatus::default()
        };
        if self.supply == SupplyState::On { self.slave.complete_status(status) } else { status }
    }

    fn skip(&mut self, time: Duration) {
        if self.supply == SupplyState::On && self.slave.watchdog.is_some() {
            self.encoder_ahead += time;
        } else {
            self.ahead += time;
        }
    }

    fn run(&mut self, now: Time, out: &mut Outbox, input: impl FnOnce(&mut PoweredSlave, &mut SlaveEnv<'_>)) {
        let mut unhooked = Outbox::new();
        let leaves_at_once = self.is_linked && !self.hooks.is_any();
        let sent = if leaves_at_once { &mut *out } else { &mut unhooked };
        let encoder = &mut *self.application;
        let mut env = SlaveEnv { now, encoder_ahead: self.encoder_ahead, application: encoder, out: sent };
        input(&mut self.slave, &mut env);
        self.slave.check_diagnosis(&mut env);
        self.update_supply(now);
        for telegram in unhooked.frames().filter(|_| self.is_linked) {
            let encoder = &*self.application;
            let telegram = self.hooks.apply(telegram.to_vec(), |hooks, mut telegram| {
                hooks.sent_telegram(encoder, &mut telegram);
                telegram
            });
            if !telegram.is_empty() {
                out.push(&telegram);
            }
        }
    }

    /// The deadline of the application, by the clock of the slave.
    fn encoder_due(&self) -> Option<Time> {
        self.application.deadline().map(|due| due - self.encoder_ahead)
    }
}

impl<A: SlaveApplication> Station for DpDevice<A> {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.shown = None;
        if !self.is_linked || self.supply != SupplyState::On {
            return;
        }
        if !self.hooks.is_any() {
            self.run(now + self.ahead, out, |slave, env| slave.receive(env, frame));
            return;
        }
        let application = &*self.application;
        for telegram in self.hooks.apply(Vec::new(), |hooks, _| hooks.received_telegrams(application, frame)) {
            self.run(now + self.ahead, out, |slave, env| slave.receive(env, &telegram));
        }
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.shown = None;
        let now = now + self.ahead;
        if let SupplyState::Booting { until } = self.supply
            && until <= now
        {
            let application = &mut *self.application;
            let mut env = SlaveEnv { now, encoder_ahead: self.encoder_ahead, application, out: &mut Outbox::new() };
            self.slave = self.slave.restarted(&mut env);
            self.supply = SupplyState::On;
        }
        match self.supply {
            SupplyState::On => self.run(now, out, |slave, env| slave.wake(env)),
            SupplyState::Booting { .. } if self.encoder_due().is_some_and(|due| due <= now) => {
                self.application.advance(now + self.encoder_ahead);
                self.update_supply(now);
            }
            SupplyState::Booting { .. } | SupplyState::Off => {}
        }
    }

    fn deadline(&self) -> Option<Time> {
        let due = match self.supply {
            SupplyState::Off => None,
            SupplyState::Booting { until } => Some(self.encoder_due().map_or(until, |due| due.min(until))),
            SupplyState::On => earlier(self.slave.deadline(), self.encoder_due()),
        };
        due.map(|due| due - self.ahead)
    }
}

impl<A: SlaveApplication> Stand for DpDevice<A> {
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, StandRefusal> {
        self.shown = None;
        self.hooks.notify(|hooks| hooks.act(action));
        match action {
            StandAction::Power(on) => self.power(now, *on),
            StandAction::Link(up) => self.is_linked = *up,
            StandAction::Skip(time) => self.skip(*time),
            other => {
                let ahead = self.ahead + self.encoder_ahead;
                let means = self.application.act(now + ahead, other).map(|done| done - ahead);
                self.update_supply(now + self.ahead);
                return means.ok_or_else(|| {
                    StandRefusal::CannotDo(String::from("the reference device does not support this action"))
                });
            }
        }
        Ok(now)
    }

    fn led(&mut self, now: Time, name: &str) -> Option<&'static str> {
        let now = now + self.ahead + self.encoder_ahead;
        if self.shown.is_none_or(|(at, _)| at != now) {
            let status = self.status();
            let status =
                SlaveStatus { last_frame_at: status.last_frame_at.map(|time| time + self.encoder_ahead), ..status };
            self.application.update_leds(now, &status);
            self.shown = Some((now, status));
        }
        let (_, status) = self.shown.as_ref()?;
        self.application.led(now, name, status)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.shown = None;
        self.application.counter(now + self.ahead + self.encoder_ahead, name)
    }
}
