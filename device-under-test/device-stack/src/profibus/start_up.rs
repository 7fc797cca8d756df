//! The start-up requests of the master: Set_Prm, Set_Ext_Prm and Chk_Cfg (IEC 61158-6-3, coding of MS0).

use super::application::{End, State};
use super::diagnosis::Faults;
use super::hooks::Check;
use super::link::Answer;
use super::slave::{Env, Slave};
use core::time::Duration;
use wire::profibus::fdl::BitTimes;
use wire::profibus::prm::{Dpv1, Dpv1Status1, PrmBlock, SetPrm, StationStatus};

/// The request in the Lock_Req and Unlock_Req bits of Set_Prm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wish {
    /// Lock the slave for this master.
    Lock,
    /// Unlock the slave.
    Unlock,
    /// Set min TSDR only.
    DelayOnly,
}

impl Slave {
    /// Processes Set_Prm: applies the parameters, sets min TSDR only, or unlocks the slave.
    pub(super) fn set_prm(&mut self, env: &mut Env<'_>, sa: u8, data: &[u8]) -> Answer {
        let is_free = self.master.is_none_or(|master| master == sa);
        if !self.check(env, Check::Master(sa), is_free) {
            return Answer::NO_SERVICE;
        }
        let Ok(parameters) = SetPrm::parse(data) else {
            self.refuse(env, Faults { prm: true, ..self.faults });
            return Answer::Taken;
        };
        let is_set = |bit| parameters.status.has(bit);
        let request = match (is_set(StationStatus::LOCK_REQ), is_set(StationStatus::UNLOCK_REQ)) {
            (_, true) => Wish::Unlock,
            (true, false) => Wish::Lock,
            (false, false) => Wish::DelayOnly,
        };
        match request {
            Wish::Lock => self.take(env, sa, parameters),
            Wish::DelayOnly => self.take_delay(parameters.min_tsdr),
            Wish::Unlock => {
                self.leave(env, End::Unlocked);
                self.faults = Faults::default();
                self.has_expired = false;
            }
        }
        Answer::Taken
    }

    fn take_delay(&mut self, min_tsdr: u8) {
        let delay = BitTimes(min_tsdr.into());
        if delay >= BitTimes::LEAST_DELAY {
            self.link.delay = delay;
        }
    }

    fn take(&mut self, env: &mut Env<'_>, sa: u8, mut parameters: SetPrm) {
        let status = parameters.status;
        let lacks = |requested: StationStatus, has: bool| status.has(requested) && !has;
        let not_supported = lacks(StationStatus::FREEZE_REQ, self.identity.freeze)
            || lacks(StationStatus::SYNC_REQ, self.identity.sync);
        let dpv1 = parameters.dpv1().filter(|_| self.identity.dpv1).unwrap_or_default();
        let factors = u32::from(parameters.wd_fact_1) * u32::from(parameters.wd_fact_2);
        let has_watchdog = status.has(StationStatus::WD_ON);
        let is_own = self.check(env, Check::Ident(parameters.ident), parameters.ident == self.identity.ident);
        let is_right = is_own && !(has_watchdog && factors == 0);
        if not_supported || !is_right {
            self.refuse(env, Faults { prm: !is_right, cfg: self.faults.cfg, not_supported });
            return;
        }
        self.leave(env, End::Parameters);
        let are_given = self.hooks.apply(true, |hooks, _| hooks.parameters(&mut parameters));
        if are_given && !env.application.parameters(env.at(), &parameters) {
            self.refuse(env, Faults { prm: true, ..self.faults });
            return;
        }
        self.take_delay(parameters.min_tsdr);
        let time = Duration::from_millis(u64::from(factors) * u64::from(dpv1.watchdog_base_ms()));
        let time = self.hooks.apply(time, |hooks, time| hooks.watchdog(time));
        self.watchdog = has_watchdog.then(|| (time, env.now + time));
        self.master = Some(sa);
        self.groups = parameters.groups;
        self.use_dpv1(dpv1);
        self.faults = Faults::default();
        self.has_expired = false;
        self.parametrized();
    }

    fn use_dpv1(&mut self, dpv1: Dpv1) {
        self.has_fail_safe = self.identity.fail_safe && dpv1.status_1.has(Dpv1Status1::FAIL_SAFE);
        self.has_dpv1 = dpv1.status_1.has(Dpv1Status1::DPV1_ENABLE);
    }

    /// Takes more parameters, as blocks.
    pub(super) fn set_ext_prm(&mut self, env: &mut Env<'_>, sa: u8, data: &[u8]) -> Answer {
        if !self.identity.set_ext_prm || self.state != State::WaitCfg || self.master != Some(sa) {
            return Answer::NO_SERVICE;
        }
        let blocks = PrmBlock::parse_all(data);
        if !blocks.is_ok_and(|blocks| env.application.more_parameters(env.at(), &blocks)) {
            self.refuse(env, Faults { prm: true, ..self.faults });
        }
        Answer::Taken
    }

    /// Checks the configuration and begins the exchange of data.
    pub(super) fn check_cfg(&mut self, env: &mut Env<'_>, sa: u8, data: &[u8]) -> Answer {
        let has_parameters = self.check(env, Check::Order, self.state != State::WaitPrm);
        if !has_parameters || self.master.is_some_and(|master| master != sa) {
            return Answer::NO_SERVICE;
        }
        let lengths = env.application.check_configuration(env.at(), data);
        let lengths = self.hooks.apply(lengths, |hooks, lengths| hooks.configuration(env.application, data, lengths));
        match lengths {
            None => self.refuse(env, Faults { cfg: true, ..self.faults }),
            Some(sums) => {
                self.faults.cfg = false;
                self.begin(env, sums);
            }
        }
        Answer::Taken
    }
}
