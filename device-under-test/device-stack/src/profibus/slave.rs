//! The slave: which service a frame is for, and what it keeps from one to the next.

use super::application::{Application, DiagnosisBits, End, Identity, Seen, State};
use super::hooks::{Check, SlaveHooks};
use super::link::{Answer, Link};
use super::records::{Records, Request};
use crate::attached::Attached;
use crate::earlier;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::profibus::cfg::Sums;
use wire::profibus::diag::{NO_MASTER, SlaveDiag, Status1, Status2, Status3};
use wire::profibus::fdl::{AnswerFunction, BROADCAST, BaudRate, DataFrame, Frame, RequestFunction, UNNAMED};
use wire::profibus::sap::{MasterSap, SlaveSap};

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
    heard: Option<Time>,
}

/// What was wrong with what the master sent, as the diagnosis tells it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Faults {
    pub prm: bool,
    pub cfg: bool,
    pub not_supported: bool,
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

    /// Takes a frame off the bus.
    pub fn receive(&mut self, env: &mut Env<'_>, octets: &[u8]) {
        self.heard = Some(env.now);
        self.link.hear();
        let Ok(Frame::Data(frame)) = Frame::parse(octets) else { return };
        let Some(function) = frame.fc.requested() else { return };
        let is_for_own = self.address <= UNNAMED && self.check(env, Check::Address(frame.da), self.address == frame.da);
        if frame.destination.segment.is_some() || !(is_for_own || frame.da == BROADCAST) {
            return;
        }
        match function {
            RequestFunction::SDN_LOW | RequestFunction::SDN_HIGH => {
                if frame.destination.sap == Some(SlaveSap::GLOBAL_CONTROL.0) {
                    self.global_control(env, frame.sa, frame.data);
                }
            }
            _ if !is_for_own || !function.wants_answer() => {}
            _ => self.serve(env, function, &frame),
        }
    }

    fn serve(&mut self, env: &mut Env<'_>, function: RequestFunction, frame: &DataFrame<'_>) {
        let own = self.address;
        let delay = self.hooks.apply(self.link.delay, |hooks, delay| hooks.delay(delay));
        if self.check(env, Check::Repetition, self.link.is_repetition(frame)) {
            self.link.repeat(env.now, delay);
            self.trigger_watchdog(env.now, frame.sa);
            return;
        }
        let answer = match function {
            RequestFunction::FDL_STATUS => Answer::Code(AnswerFunction::OK),
            RequestFunction::SRD_LOW | RequestFunction::SRD_HIGH => {
                let answer = self.service(env, frame);
                self.trigger_watchdog(env.now, frame.sa);
                answer
            }
            _ => Answer::NO_SERVICE,
        };
        let delay = self.hooks.apply(self.link.delay, |hooks, delay| hooks.delay(delay));
        self.link.answer(env.now, own, frame, &answer, delay);
    }

    fn service(&mut self, env: &mut Env<'_>, frame: &DataFrame<'_>) -> Answer {
        let DataFrame { sa, data, .. } = *frame;
        let source = frame.source.sap.map(MasterSap);
        let Some(sap) = frame.destination.sap else {
            return if source.is_none() { self.exchange(env, sa, data) } else { Answer::NO_SERVICE };
        };
        match (SlaveSap(sap), source) {
            (SlaveSap::SLAVE_DIAG, Some(MasterSap::MS0)) => self.slave_diag(env, sa),
            (SlaveSap::SET_PRM, Some(MasterSap::MS0)) => self.set_prm(env, sa, data),
            (SlaveSap::SET_EXT_PRM, Some(MasterSap::MS0)) => self.set_ext_prm(env, sa, data),
            (SlaveSap::CHK_CFG, Some(MasterSap::MS0)) => self.check_cfg(env, sa, data),
            (SlaveSap::GET_CFG, Some(MasterSap::MS0)) => {
                let mut octets = Vec::new();
                env.application.configuration(&mut octets);
                Answer::data(octets)
            }
            (SlaveSap::READ_INPUTS, Some(MasterSap::MS0)) => self.read_inputs(env),
            (SlaveSap::READ_OUTPUTS, Some(MasterSap::MS0)) => self.read_outputs(),
            (SlaveSap::SET_SLAVE_ADDRESS, Some(MasterSap::MS0)) => self.set_slave_address(env, data),
            (SlaveSap::SERVER, Some(MasterSap::MS1)) => {
                let is_on = self.check(env, Check::Dpv1, self.has_dpv1);
                if !self.identity.ms1 || !is_on || !self.is_exchanging_with(sa) {
                    return Answer::NO_SERVICE;
                }
                self.records.serve_ms1(env, data)
            }
            (SlaveSap(sap), Some(MasterSap::MS2)) => {
                self.records.serve_ms2(env, Request { sap, master: sa, data }, &self.identity)
            }
            _ => Answer::NO_SERVICE,
        }
    }

    /// Whether this master exchanges data with the slave.
    pub(super) fn is_exchanging_with(&self, sa: u8) -> bool {
        self.state == State::DataExchange && self.master.is_none_or(|master| master == sa)
    }

    fn slave_diag(&mut self, env: &mut Env<'_>, sa: u8) -> Answer {
        let mut ext = Vec::new();
        let bits = env.application.diagnosis(env.at(), &mut ext);
        let mut diagnosis = self.diagnosis(bits);
        diagnosis.ext = ext;
        if self.master == Some(sa) {
            self.is_announced = false;
        }
        let mut octets = Vec::new();
        diagnosis.write(&mut octets);
        octets.truncate(SlaveDiag::LONGEST);
        Answer::data(octets)
    }

    fn diagnosis(&self, bits: DiagnosisBits) -> SlaveDiag {
        let sum = |flags: &[(bool, u8)]| flags.iter().filter(|(is_set, _)| *is_set).map(|(_, bit)| bit).sum();
        SlaveDiag {
            status_1: Status1(sum(&[
                (self.state != State::DataExchange, Status1::STATION_NOT_READY.0),
                (self.faults.cfg, Status1::CFG_FAULT.0),
                (bits.ext_diag, Status1::EXT_DIAG.0),
                (self.faults.not_supported, Status1::NOT_SUPPORTED.0),
                (self.faults.prm, Status1::PRM_FAULT.0),
            ])),
            status_2: Status2(sum(&[
                (true, Status2::FIXED_ONE.0),
                (self.state == State::WaitPrm, Status2::PRM_REQ.0),
                (bits.stat_diag, Status2::STAT_DIAG.0),
                (self.watchdog.is_some(), Status2::WD_ON.0),
                (self.frozen.is_some(), Status2::FREEZE_MODE.0),
                (self.held.is_some(), Status2::SYNC_MODE.0),
            ])),
            status_3: Status3(sum(&[(bits.overflow, Status3::EXT_DIAG_OVERFLOW.0)])),
            master: self.master.unwrap_or(NO_MASTER),
            ident: self.identity.ident,
            ext: Vec::new(),
        }
    }

    fn trigger_watchdog(&mut self, now: Time, sa: u8) {
        if self.master == Some(sa)
            && let Some((time, expires)) = &mut self.watchdog
        {
            *expires = now + *time;
        }
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
