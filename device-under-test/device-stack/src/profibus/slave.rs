//! A slave while it has power: its state and its timers.

use super::application::{Application, End, Identity, Seen, State};
use super::diagnosis::Faults;
use super::hooks::{Check, SlaveHooks};
use super::link::Link;
use super::records::Records;
use crate::attached::Attached;
use crate::earlier;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::profibus::cfg::Sums;
use wire::profibus::fdl::BaudRate;

/// The context of each call: current time, application, and output queue.
pub(super) struct Env<'a> {
    /// The time of the slave's clock.
    pub now: Time,
    /// By how much the clock of the application is ahead.
    pub encoder_ahead: Duration,
    /// The application.
    pub application: &'a mut dyn Application,
    /// The queue of frames to send.
    pub out: &'a mut Outbox,
}

impl Env<'_> {
    /// The time of the application's clock.
    pub fn at(&self) -> Time {
        self.now + self.encoder_ahead
    }
}

/// A slave while it has power.
pub(super) struct Slave {
    pub(super) hooks: Attached<dyn SlaveHooks>,
    pub(super) identity: Identity,
    pub(super) link: Link,
    pub(super) address: u8,
    pub(super) state: State,
    /// The master that has locked the slave.
    pub(super) master: Option<u8>,
    pub(super) groups: u8,
    /// The watchdog time, and when it expires.
    pub(super) watchdog: Option<(Duration, Time)>,
    pub(super) has_fail_safe: bool,
    /// Whether the master has enabled DP-V1.
    pub(super) has_dpv1: bool,
    pub(super) sums: Sums,
    pub(super) faults: Faults,
    pub(super) has_expired: bool,
    pub(super) is_clear: bool,
    /// The inputs held by Freeze.
    pub(super) frozen: Option<Vec<u8>>,
    /// `Some` while Sync holds the outputs, with the outputs that wait for the next Sync.
    pub(super) held: Option<Option<Vec<u8>>>,
    /// The outputs of the last exchange.
    pub(super) outputs: Vec<u8>,
    /// Whether the master must fetch the diagnosis.
    pub(super) is_announced: bool,
    pub(super) records: Records,
    /// When the last frame was received.
    pub(super) heard: Option<Time>,
}

impl Slave {
    /// A slave after its start.
    pub fn new(baud: BaudRate, hooks: Attached<dyn SlaveHooks>, application: &dyn Application) -> Slave {
        Slave {
            hooks,
            identity: application.identity().clone(),
            link: Link::new(baud),
            address: application.address(),
            state: State::WaitPrm,
            master: None,
            groups: 0,
            watchdog: None,
            has_fail_safe: false,
            has_dpv1: false,
            sums: Sums::default(),
            faults: Faults::default(),
            has_expired: false,
            is_clear: false,
            frozen: None,
            held: None,
            outputs: Vec::new(),
            is_announced: false,
            records: Records::default(),
            heard: None,
        }
    }

    /// The slave after a restart.
    pub fn restarted(&self, env: &mut Env<'_>) -> Slave {
        self.hooks.notify(|hooks| hooks.starts());
        Slave::new(self.link.baud(), self.hooks.clone(), env.application)
    }

    /// Completes the status of the device with that of the slave.
    pub fn seen(&self, device: Seen) -> Seen {
        Seen {
            state: self.state,
            heard: self.heard,
            prm_fault: self.faults.prm,
            cfg_fault: self.faults.cfg,
            watchdog_expired: self.has_expired,
            is_clear: self.is_clear,
            ..device
        }
    }

    /// Whether a watchdog runs.
    pub fn is_watching(&self) -> bool {
        self.watchdog.is_some()
    }

    /// Returns `verdict`, unless a deviation flips it.
    pub(super) fn check(&self, env: &Env<'_>, check: Check, verdict: bool) -> bool {
        self.hooks.apply(verdict, |hooks, verdict| hooks.check(env.application, check, verdict))
    }

    /// Does what is due.
    pub fn wake(&mut self, env: &mut Env<'_>) {
        let at = env.at();
        if env.application.deadline().is_some_and(|due| due <= at) {
            env.application.advance(at);
        }
        self.link.wake(env.now, env.out);
        self.records.wake(env);
        if self.watchdog.is_some_and(|(_, expires)| expires <= env.now) {
            self.has_expired = true;
            self.leave(env, End::Watchdog);
        }
    }

    /// Called after each event: checks whether the application has a new diagnosis.
    pub fn settle(&mut self, env: &mut Env<'_>) {
        let is_changed = env.application.diagnosis_changed() && self.state == State::DataExchange;
        self.is_announced |= is_changed;
    }

    /// When the next timer of the slave expires, those of the application excluded.
    pub fn deadline(&self) -> Option<Time> {
        let watchdog = self.watchdog.map(|(_, expires)| expires);
        earlier(self.link.due(), earlier(self.records.due(), watchdog))
    }
}
