//! The way to the exchange of data and back: parameters, configuration, lock, watchdog, and the address.

use super::application::{End, State};
use super::link::Answer;
use super::slave::{Env, Faults, Image, Slave};
use alloc::vec;
use alloc::vec::Vec;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::cfg::Sums;
use wire::profibus::fdl::BitTimes;
use wire::profibus::prm::{Dpv1, Dpv1Status1, PrmBlock, SetPrm, StationStatus};

/// What Set_Prm asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wish {
    /// The slave is to belong to this master.
    Lock,
    /// The slave is to belong to nobody.
    Unlock,
    /// Nothing but min TSDR is to be taken.
    DelayOnly,
}

/// What has made the slave what it is, for one that does not wait to be told again.
#[derive(Clone, Debug, Default)]
pub(super) struct Session {
    pub parameters: Option<SetPrm>,
    pub identifiers: Vec<u8>,
}

impl Slave {
    /// Takes parameters, or gives the slave free.
    pub(super) fn set_prm(&mut self, env: &mut Env<'_>, sa: u8, data: &[u8]) -> Answer {
        if self.behaviour.is_locked && self.master.is_some_and(|master| master != sa) {
            return Answer::NO_SERVICE;
        }
        let Ok(parameters) = SetPrm::parse(data) else {
            self.refuse(env, Faults { prm: true, ..self.faults });
            return Answer::Taken;
        };
        let lock = parameters.status.has(StationStatus::LOCK_REQ) || !self.behaviour.needs_lock_request;
        let wish = match (lock, parameters.status.has(StationStatus::UNLOCK_REQ)) {
            (_, true) => Wish::Unlock,
            (true, false) => Wish::Lock,
            (false, false) => Wish::DelayOnly,
        };
        match wish {
            Wish::Lock => self.take(env, sa, parameters),
            Wish::DelayOnly => self.take_delay(parameters.min_tsdr),
            Wish::Unlock if self.behaviour.unlocks => {
                self.leave(env, End::Unlocked);
                self.faults = Faults::default();
                self.has_expired = false;
            }
            Wish::Unlock => {}
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
        let lacks = |asked: StationStatus, has: bool| status.has(asked) && !has;
        let not_supported = lacks(StationStatus::FREEZE_REQ, self.identity.freeze)
            || lacks(StationStatus::SYNC_REQ, self.identity.sync);
        let dpv1 = parameters.dpv1().filter(|_| self.identity.dpv1).unwrap_or_default();
        let factors = u32::from(parameters.wd_fact_1) * u32::from(parameters.wd_fact_2);
        let has_watchdog = status.has(StationStatus::WD_ON);
        let is_right = (self.behaviour.takes_ident)(parameters.ident, self.identity.ident)
            && (self.behaviour.takes_min_tsdr)(parameters.min_tsdr)
            && !(has_watchdog && factors == 0 && self.behaviour.checks_watchdog_factors);
        if not_supported && self.behaviour.tells_not_supported || !is_right {
            let not_supported = not_supported && self.behaviour.tells_not_supported;
            self.refuse(env, Faults { prm: !is_right, cfg: self.faults.cfg, not_supported });
            return;
        }
        if self.behaviour.starts_anew {
            self.leave(env, End::Parameters);
        }
        (self.behaviour.taken_parameters)(&mut parameters);
        let comes_too_late = !self.behaviour.takes_new_parameters && !self.session.identifiers.is_empty();
        if !comes_too_late && !env.application.parameters(env.at(), &parameters) {
            self.refuse(env, Faults { prm: true, ..self.faults });
            return;
        }
        self.take_delay(parameters.min_tsdr);
        let watchdog = (self.behaviour.watchdog)(factors, has_watchdog, dpv1.watchdog_base_ms());
        self.watchdog = watchdog.map(|time| (time, env.now + time));
        self.master = Some(sa);
        self.past.first_master.get_or_insert(sa);
        self.past.last_master = Some(sa);
        self.groups = parameters.groups;
        self.use_dpv1(dpv1);
        self.faults = Faults { cfg: self.faults.cfg && !self.behaviour.forgets_cfg_fault, ..Faults::default() };
        self.has_expired = false;
        if self.state == State::WaitPrm {
            self.state = State::WaitCfg;
        }
        self.session.parameters = Some(parameters);
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
        let comes_too_early = self.behaviour.checks_order && self.state == State::WaitPrm;
        if comes_too_early || self.master.is_some_and(|master| master != sa) {
            return Answer::NO_SERVICE;
        }
        match env.application.check_configuration(env.at(), data) {
            None if self.behaviour.leaves_after_wrong_configuration => {
                self.refuse(env, Faults { cfg: true, ..self.faults });
            }
            None => self.faults.cfg = true,
            Some(sums) => {
                self.faults.cfg &= !self.behaviour.forgets_cfg_fault;
                self.session.identifiers = data.to_vec();
                self.begin(env, sums);
            }
        }
        Answer::Taken
    }

    /// Begins the exchange of data, or goes on with other lengths.
    pub(super) fn begin(&mut self, env: &mut Env<'_>, sums: Sums) {
        if self.state != State::DataExchange || sums != self.sums {
            self.sums = sums;
            self.image = Image { outputs: vec![0; sums.outputs], first_outputs: None, first_inputs: None };
        }
        if self.state != State::DataExchange {
            self.state = State::DataExchange;
            env.application.exchange_begins(env.at());
        }
    }

    /// What the master sent is wrong: the slave tells so and waits for parameters.
    pub(super) fn refuse(&mut self, env: &mut Env<'_>, faults: Faults) {
        self.leave(env, End::Fault);
        self.past.had_prm_fault |= faults.prm;
        self.faults = faults;
    }

    /// Ends whatever there is with the master, and waits for parameters.
    pub(super) fn leave(&mut self, env: &mut Env<'_>, end: End) {
        if self.state == State::DataExchange {
            if self.behaviour.clears_at_end {
                env.application.outputs(env.at(), None);
            }
            env.application.exchange_ends(env.at(), end);
        }
        self.state = State::WaitPrm;
        self.master = None;
        self.watchdog = None;
        self.is_clear = false;
        self.frozen = None;
        self.held = None;
        self.is_announced = false;
        self.has_dpv1 = false;
        self.records.end_ms1(env);
    }

    /// Exchanges data again with what the slave before was told.
    pub(super) fn resume(&mut self, env: &mut Env<'_>, before: &Slave) {
        self.state = State::WaitPrm;
        let Session { parameters: Some(parameters), identifiers } = before.session.clone() else { return };
        let is_right = env.application.parameters(env.at(), &parameters);
        let sums = env.application.check_configuration(env.at(), &identifiers).filter(|_| is_right);
        if let Some(sums) = sums {
            self.begin(env, sums);
        }
        self.session = before.session.clone();
    }

    /// Takes another address.
    pub(super) fn set_slave_address(&mut self, env: &mut Env<'_>, data: &[u8]) -> Answer {
        let may = env.application.takes_address();
        let mut data = data.to_vec();
        if self.behaviour.fills_address_telegram && data.len() == 3 {
            data.push(0);
        }
        let (true, Ok(mut request)) = ((self.behaviour.takes_address)(self.state, may), SetSlaveAddress::parse(&data))
        else {
            return Answer::NO_SERVICE;
        };
        (self.behaviour.understood_address)(&mut request);
        let is_meant = (self.behaviour.compares_ident_of_address)(request.ident, self.identity.ident);
        if is_meant && (self.behaviour.takes_new_address)(request.address) {
            env.application.set_address(env.at(), request.address, request.no_change != 0);
            if self.behaviour.moves_at_once {
                self.address = request.address;
            }
        }
        Answer::Taken
    }
}
