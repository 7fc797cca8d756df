//! The states of a slave and their transitions (IEC 61158-6-3, MSCY1S).
//!
//! Wait_Prm: after power-up and after every loss of the master. Wait_Cfg: with parameters and without a
//! configuration. Data_Exch: parameters and configuration are valid.

use super::application::{End, State};
use super::diagnosis::Faults;
use super::slave::{Env, Slave};
use alloc::vec;
use station::Time;
use wire::profibus::cfg::Sums;

impl Slave {
    /// Whether this master exchanges data with the slave.
    pub(super) fn is_exchanging_with(&self, sa: u8) -> bool {
        self.state == State::DataExchange && self.master.is_none_or(|master| master == sa)
    }

    /// From Wait_Prm to Wait_Cfg. In Data_Exch new parameters do not change the state.
    pub(super) fn parametrized(&mut self) {
        self.state = match self.state {
            State::WaitPrm | State::WaitCfg => State::WaitCfg,
            State::DataExchange => State::DataExchange,
        };
    }

    /// Enters Data_Exch, or continues there with other lengths.
    pub(super) fn begin(&mut self, env: &mut Env<'_>, sums: Sums) {
        if self.state != State::DataExchange || sums != self.sums {
            self.sums = sums;
            self.outputs = vec![0; sums.outputs];
        }
        if self.state != State::DataExchange {
            self.state = State::DataExchange;
            env.application.exchange_begins(env.at());
        }
    }

    /// Back to Wait_Prm because the master sent something invalid. The diagnosis reports `faults`.
    pub(super) fn refuse(&mut self, env: &mut Env<'_>, faults: Faults) {
        self.leave(env, End::Fault);
        self.faults = faults;
    }

    /// Back to Wait_Prm: ends data exchange and releases the lock.
    pub(super) fn leave(&mut self, env: &mut Env<'_>, end: End) {
        if self.state == State::DataExchange {
            self.put(env, None);
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

    /// Restarts the watchdog if the request comes from the master of the slave.
    pub(super) fn trigger_watchdog(&mut self, now: Time, sa: u8) {
        if self.master == Some(sa)
            && let Some((time, expires)) = &mut self.watchdog
        {
            *expires = now + *time;
        }
    }
}
