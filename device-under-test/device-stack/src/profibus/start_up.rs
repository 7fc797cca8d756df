//! The start-up requests of the master: Set_Prm, Set_Ext_Prm and Chk_Cfg (IEC 61158-6-3, coding of MS0).

use super::application::{DpState, ExchangeEnd};
use super::diagnosis::StartUpFaults;
use super::hooks::SlaveStackCheck;
use super::link::ServiceAnswer;
use super::slave::{PoweredSlave, SlaveEnv};
use core::time::Duration;
use wire::profibus::fdl::BitTimes;
use wire::profibus::prm::{Dpv1, Dpv1Status1, Dpv1Status3, PrmBlock, SetPrm, StationStatus};

/// The request in the Lock_Req and Unlock_Req bits of Set_Prm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LockRequest {
    /// Lock the slave for this master.
    Lock,
    /// Unlock the slave.
    Unlock,
    /// Set min TSDR only.
    DelayOnly,
}

impl PoweredSlave {
    /// Processes Set_Prm: applies the parameters, sets min TSDR only, or unlocks the slave.
    pub(super) fn set_prm(&mut self, env: &mut SlaveEnv<'_>, sa: u8, data: &[u8]) -> ServiceAnswer {
        let is_free = self.master.is_none_or(|master| master == sa);
        if !self.check(env, SlaveStackCheck::Master(sa), is_free) {
            return ServiceAnswer::NO_SERVICE;
        }
        let Ok(parameters) = SetPrm::parse(data) else {
            self.refuse(env, StartUpFaults { prm: true, ..self.faults });
            return ServiceAnswer::Taken;
        };
        let is_set = |bit| parameters.status.has(bit);
        let request = match (is_set(StationStatus::LOCK_REQ), is_set(StationStatus::UNLOCK_REQ)) {
            (_, true) => LockRequest::Unlock,
            (true, false) => LockRequest::Lock,
            (false, false) => LockRequest::DelayOnly,
        };
        match request {
            LockRequest::Lock => self.lock(env, sa, parameters),
            LockRequest::DelayOnly => self.set_min_tsdr(parameters.min_tsdr),
            LockRequest::Unlock => {
                self.enter_wait_prm(env, ExchangeEnd::Unlocked);
                self.faults = StartUpFaults::default();
                self.watchdog_expired = false;
            }
        }
        ServiceAnswer::Taken
    }

    fn set_min_tsdr(&mut self, min_tsdr: u8) {
        let delay = BitTimes(min_tsdr.into());
        if delay >= BitTimes::DEFAULT_MIN_TSDR {
            self.link.delay = delay;
        }
    }

    fn lock(&mut self, env: &mut SlaveEnv<'_>, sa: u8, mut parameters: SetPrm) {
        let status = parameters.status;
        let lacks = |requested: StationStatus, has: bool| status.has(requested) && !has;
        let has_modes = !lacks(StationStatus::FREEZE_REQ, self.identity.freeze)
            && !lacks(StationStatus::SYNC_REQ, self.identity.sync);
        let modes = status.has(StationStatus::FREEZE_REQ) || status.has(StationStatus::SYNC_REQ);
        let dpv1 = parameters.dpv1().filter(|_| self.identity.dpv1).unwrap_or_default();
        let lacks_clock = dpv1.status_3.has(Dpv1Status3::ISOCHRONOUS) && !self.identity.isochronous;
        let not_supported = modes && !self.check(env, SlaveStackCheck::Modes, has_modes)
            || lacks_clock && !self.check(env, SlaveStackCheck::Isochronous, false);
        let factors = u32::from(parameters.wd_fact_1) * u32::from(parameters.wd_fact_2);
        let has_watchdog = status.has(StationStatus::WD_ON);
        let is_own = self.check(env, SlaveStackCheck::Ident(parameters.ident), parameters.ident == self.identity.ident);
        let is_right = is_own && !(has_watchdog && factors == 0);
        if not_supported || !is_right {
            self.refuse(env, StartUpFaults { prm: !is_right, cfg: self.faults.cfg, not_supported });
            return;
        }
        self.enter_wait_prm(env, ExchangeEnd::Parameters);
        let are_given = self.hooks.apply(true, |hooks, _| hooks.parameters(&mut parameters));
        if are_given && !env.application.parameters(env.application_time(), &parameters) {
            self.refuse(env, StartUpFaults { prm: true, ..self.faults });
            return;
        }
        self.set_min_tsdr(parameters.min_tsdr);
        let time = Duration::from_millis(u64::from(factors) * u64::from(dpv1.watchdog_base_ms()));
        let time = self.hooks.apply(time, |hooks, time| hooks.watchdog(time));
        self.watchdog = has_watchdog.then(|| (time, env.now + time));
        self.master = Some(sa);
        self.groups = parameters.groups;
        self.use_dpv1(dpv1);
        self.faults = StartUpFaults::default();
        self.watchdog_expired = false;
        self.enter_wait_cfg();
    }

    fn use_dpv1(&mut self, dpv1: Dpv1) {
        self.has_fail_safe = self.identity.fail_safe && dpv1.status_1.has(Dpv1Status1::FAIL_SAFE);
        self.has_dpv1 = dpv1.status_1.has(Dpv1Status1::DPV1_ENABLE);
    }

    /// Takes more parameters, as blocks.
    pub(super) fn set_ext_prm(&mut self, env: &mut SlaveEnv<'_>, sa: u8, data: &[u8]) -> ServiceAnswer {
        if !self.identity.set_ext_prm || self.state != DpState::WaitCfg || self.master != Some(sa) {
            return ServiceAnswer::NO_SERVICE;
        }
        let blocks = PrmBlock::parse_all(data);
        if !blocks.is_ok_and(|blocks| env.application.more_parameters(env.application_time(), &blocks)) {
            self.refuse(env, StartUpFaults { prm: true, ..self.faults });
        }
        ServiceAnswer::Taken
    }

    /// Checks the configuration and begins the exchange of data.
    pub(super) fn check_cfg(&mut self, env: &mut SlaveEnv<'_>, sa: u8, data: &[u8]) -> ServiceAnswer {
        let has_parameters = self.check(env, SlaveStackCheck::Order, self.state != DpState::WaitPrm);
        if !has_parameters || self.master.is_some_and(|master| master != sa) {
            return ServiceAnswer::NO_SERVICE;
        }
        let lengths = env.application.check_configuration(env.application_time(), data);
        let lengths = self.hooks.apply(lengths, |hooks, lengths| hooks.configuration(env.application, data, lengths));
        match lengths {
            None => self.refuse(env, StartUpFaults { cfg: true, ..self.faults }),
            Some(sums) => {
                self.faults.cfg = false;
                let takes = self.hooks.apply(Duration::ZERO, |hooks, takes| hooks.ready_time(takes));
                if takes.is_zero() {
                    self.enter_data_exchange(env, sums);
                } else {
                    self.configured = Some((env.now + takes, sums));
                }
            }
        }
        ServiceAnswer::Taken
    }
}
