//! A slave while it has power: its state and its timers.

use super::application::{DpState, ExchangeEnd, SlaveApplication, SlaveIdentity, SlaveStatus};
use super::diagnosis::StartUpFaults;
use super::hooks::{SlaveHooks, SlaveStackCheck};
use super::link::FdlLink;
use super::records::Dpv1Records;
use crate::attached::Attached;
use crate::earlier;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::profibus::cfg::IoLengths;
use wire::profibus::fdl::BaudRate;

/// The context of each call: current time, application, and output queue.
pub(super) struct SlaveEnv<'a> {
    /// The time of the slave's clock.
    pub now: Time,
    /// By how much the clock of the application is ahead.
    pub encoder_ahead: Duration,
    /// The application.
    pub application: &'a mut dyn SlaveApplication,
    /// The queue of frames to send.
    pub out: &'a mut Outbox,
}

impl SlaveEnv<'_> {
    /// The time of the application's clock.
    pub fn application_time(&self) -> Time {
        self.now + self.encoder_ahead
    }
}

/// A slave while it has power.
pub(super) struct PoweredSlave {
    pub(super) hooks: Attached<dyn SlaveHooks>,
    pub(super) identity: SlaveIdentity,
    pub(super) link: FdlLink,
    pub(super) address: u8,
    pub(super) state: DpState,
    /// The master that has locked the slave.
    pub(super) master: Option<u8>,
    pub(super) groups: u8,
    /// The lengths of a valid configuration, and when data exchange begins with them.
    pub(super) configured: Option<(Time, IoLengths)>,
    /// The watchdog time, and when it expires.
    pub(super) watchdog: Option<(Duration, Time)>,
    pub(super) has_fail_safe: bool,
    /// Whether the master has enabled DP-V1.
    pub(super) has_dpv1: bool,
    pub(super) sums: IoLengths,
    pub(super) faults: StartUpFaults,
    pub(super) watchdog_expired: bool,
    pub(super) is_clear: bool,
    /// The inputs held by Freeze.
    pub(super) frozen_inputs: Option<Vec<u8>>,
    /// `Some` while Sync holds the outputs, with the outputs that wait for the next Sync.
    pub(super) sync_outputs: Option<Option<Vec<u8>>>,
    /// The outputs of the last exchange.
    pub(super) outputs: Vec<u8>,
    /// Whether the master must fetch the diagnosis.
    pub(super) has_new_diagnosis: bool,
    pub(super) records: Dpv1Records,
    /// When the last frame was received.
    pub(super) last_frame_at: Option<Time>,
}

impl PoweredSlave {
    /// A slave after its start.
    pub fn new(baud: BaudRate, hooks: Attached<dyn SlaveHooks>, application: &dyn SlaveApplication) -> PoweredSlave {
        PoweredSlave {
            hooks,
            identity: application.identity().clone(),
            link: FdlLink::new(baud),
            address: application.address(),
            state: DpState::WaitPrm,
            master: None,
            groups: 0,
            configured: None,
            watchdog: None,
            has_fail_safe: false,
            has_dpv1: false,
            sums: IoLengths::default(),
            faults: StartUpFaults::default(),
            watchdog_expired: false,
            is_clear: false,
            frozen_inputs: None,
            sync_outputs: None,
            outputs: Vec::new(),
            has_new_diagnosis: false,
            records: Dpv1Records::default(),
            last_frame_at: None,
        }
    }

    /// The slave after a restart.
    pub fn restarted(&self, env: &mut SlaveEnv<'_>) -> PoweredSlave {
        self.hooks.notify(|hooks| hooks.starts());
        PoweredSlave::new(self.link.baud(), self.hooks.clone(), env.application)
    }

    /// Completes the status of the device with that of the slave.
    pub fn complete_status(&self, device: SlaveStatus) -> SlaveStatus {
        SlaveStatus {
            state: self.state,
            last_frame_at: self.last_frame_at,
            prm_fault: self.faults.prm,
            cfg_fault: self.faults.cfg,
            watchdog_expired: self.watchdog_expired,
            is_clear: self.is_clear,
            ..device
        }
    }

    /// Returns `verdict`, unless a deviation flips it.
    pub(super) fn check(&self, env: &SlaveEnv<'_>, check: SlaveStackCheck, verdict: bool) -> bool {
        self.hooks.apply(verdict, |hooks, verdict| hooks.check(env.application, check, verdict))
    }

    /// Does what is due.
    pub fn wake(&mut self, env: &mut SlaveEnv<'_>) {
        let at = env.application_time();
        if env.application.deadline().is_some_and(|due| due <= at) {
            env.application.advance(at);
        }
        self.link.wake(env.now, env.out);
        self.records.wake(env);
        if let Some((_, sums)) = self.configured.take_if(|(due, _)| *due <= env.now) {
            self.enter_data_exchange(env, sums);
        }
        if self.watchdog.is_some_and(|(_, expires)| expires <= env.now) {
            self.watchdog_expired = true;
            self.enter_wait_prm(env, ExchangeEnd::Watchdog);
        }
    }

    /// Called after each event: checks whether the application has a new diagnosis.
    pub fn check_diagnosis(&mut self, env: &mut SlaveEnv<'_>) {
        let is_changed = env.application.diagnosis_changed() && self.state == DpState::DataExchange;
        self.has_new_diagnosis |= is_changed;
    }

    /// When the next timer of the slave expires, those of the application excluded.
    pub fn deadline(&self) -> Option<Time> {
        let watchdog = self.watchdog.map(|(_, expires)| expires);
        let ready = self.configured.map(|(due, _)| due);
        earlier(self.link.due(), earlier(self.records.due(), earlier(ready, watchdog)))
    }
}
