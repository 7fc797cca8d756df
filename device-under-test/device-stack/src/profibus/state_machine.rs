//! The states of a slave and their transitions (IEC 61158-6-3, MSCY1S).
//!
//! Wait_Prm: after power-up and after every loss of the master. Wait_Cfg: with parameters and without a
//! configuration. Data_Exch: parameters and configuration are valid.

use super::application::{DpState, ExchangeEnd};
use super::diagnosis::StartUpFaults;
use super::slave::{PoweredSlave, SlaveEnv};
use alloc::vec;
use station::Time;
use wire::profibus::cfg::IoLengths;

impl PoweredSlave {
    /// Whether this master exchanges data with the slave.
    pub(super) fn is_exchanging_with(&self, sa: u8) -> bool {
        self.state == DpState::DataExchange && self.master.is_none_or(|master| master == sa)
    }

    /// From Wait_Prm to Wait_Cfg. In Data_Exch new parameters do not change the state.
    pub(super) fn enter_wait_cfg(&mut self) {
        self.state = match self.state {
            DpState::WaitPrm | DpState::WaitCfg => DpState::WaitCfg,
            DpState::DataExchange => DpState::DataExchange,
        };
    }

    /// Enters Data_Exch, or continues there with other lengths.
    pub(super) fn enter_data_exchange(&mut self, env: &mut SlaveEnv<'_>, sums: IoLengths) {
        if self.state != DpState::DataExchange || sums != self.sums {
            self.sums = sums;
            self.outputs = vec![0; sums.outputs];
        }
        if self.state != DpState::DataExchange {
            self.state = DpState::DataExchange;
            env.application.exchange_begins(env.application_time());
        }
    }

    /// Back to Wait_Prm because the master sent something invalid. The diagnosis reports `faults`.
    pub(super) fn refuse(&mut self, env: &mut SlaveEnv<'_>, faults: StartUpFaults) {
        self.enter_wait_prm(env, ExchangeEnd::Fault);
        self.faults = faults;
    }

    /// Back to Wait_Prm: ends data exchange and releases the lock.
    pub(super) fn enter_wait_prm(&mut self, env: &mut SlaveEnv<'_>, end: ExchangeEnd) {
        if self.state == DpState::DataExchange {
            self.set_outputs(env, None);
            env.application.exchange_ends(env.application_time(), end);
        }
        self.state = DpState::WaitPrm;
        self.configured = None;
        self.master = None;
        self.watchdog = None;
        self.is_clear = false;
        self.frozen_inputs = None;
        self.sync_outputs = None;
        self.has_new_diagnosis = false;
        self.has_dpv1 = false;
        self.records.end_ms1(env);
    }

    /// Restarts the watchdog if the request comes from the master of the slave.
    pub(super) fn trigger_watchdog(&mut self, now: Time, sa: u8) {
        if self.master == Some(sa)
            && let Some((time, expires)) = &mut self.watchdog
        {
            *expires = now + *time;
        }
    }
}
