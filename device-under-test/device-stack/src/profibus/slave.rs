//! A slave while it has power: what it keeps from one frame to the next, and when something is due.

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

/// What the slave has in its hands during one input.
pub(super) struct Env<'a> {
    /// The time by the slave's clock.
    pub now: Time,
    /// By how much the encoder's clock is ahead.
    pub encoder_ahead: Duration,
    /// The encoder.
    pub application: &'a mut dyn Application,
    /// Where frames are sent.
    pub out: &'a mut Outbox,
}

impl Env<'_> {
    /// The time by the encoder's clock.
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
    /// The master that has parameterised the slave.
    pub(super) master: Option<u8>,
    pub(super) groups: u8,
    /// The time of the watchdog, and when it expires.
    pub(super) watchdog: Option<(Duration, Time)>,
    pub(super) has_fail_safe: bool,
    /// Whether the master has turned DP-V1 on.
    pub(super) has_dpv1: bool,
    pub(super) sums: Sums,
    pub(super) faults: Faults,
    pub(super) has_expired: bool,
    pub(super) is_clear: bool,
    /// Inputs that Freeze holds.
    pub(super) frozen: Option<Vec<u8>>,
    /// Whether Sync holds the outputs, and those that wait for the next one.
    pub(super) held: Option<Option<Vec<u8>>>,
    /// The outputs of the last exchange.
    pub(super) outputs: Vec<u8>,
    /// Whether the master is to fetch the diagnosis.
    pub(super) is_announced: bool,
    pub(super) records: Records,
    /// When the last frame came.
    pub(super) heard: Option<Time>,
}

impl Slave {
    /// A slave that has just started.
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

    /// The slave after a new start.
    pub fn restarted(&self, env: &mut Env<'_>) -> Slave {
        self.hooks.notify(|hooks| hooks.starts());
        Slave::new(self.link.baud(), self.hooks.clone(), env.application)
    }

    /// What there is to be seen of it.
    pub fn seen(&self, seen: Seen) -> Seen {
        Seen {
            state: self.state,
            heard: self.heard,
            prm_fault: self.faults.prm,
            cfg_fault: self.faults.cfg,
            watchdog_expired: self.has_expired,
            is_clear: self.is_clear,
            ..seen
        }
    }

    /// Whether a watchdog runs.
    pub fn is_watching(&self) -> bool {
        self.watchdog.is_some()
    }

    /// What is decided, in the end.
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

    /// After each input: takes note of what the encoder has to tell.
    pub fn settle(&mut self, env: &mut Env<'_>) {
        let is_changed = env.application.diagnosis_changed() && self.state == State::DataExchange;
        self.is_announced |= is_changed;
    }

    /// When something is due, the encoder's own affairs apart.
    pub fn deadline(&self) -> Option<Time> {
        let watchdog = self.watchdog.map(|(_, expires)| expires);
        earlier(self.link.due(), earlier(self.records.due(), watchdog))
    }
}
