//! Cyclic data: Data_Exchange, Global_Control, RD_Inp and RD_Outp.

use super::application::{DpState, ExchangeEnd};
use super::diagnosis::StartUpFaults;
use super::hooks::SlaveStackCheck;
use super::link::ServiceAnswer;
use super::slave::{PoweredSlave, SlaveEnv};
use alloc::vec;
use alloc::vec::Vec;
use wire::profibus::global_control::{GlobalCommand, GlobalControl};

impl PoweredSlave {
    /// Answers Data_Exchange: takes the outputs and returns the inputs.
    pub(super) fn exchange(&mut self, env: &mut SlaveEnv<'_>, sa: u8, data: &[u8]) -> ServiceAnswer {
        if !self.is_exchanging_with(sa) {
            return ServiceAnswer::NO_SERVICE;
        }
        let is_fail_safe = data.is_empty() && self.has_fail_safe;
        let fits = self.check(env, SlaveStackCheck::OutputLength(data.len()), data.len() == self.sums.outputs);
        if !is_fail_safe && !fits {
            self.enter_wait_prm(env, ExchangeEnd::Fault);
            self.faults = StartUpFaults { cfg: true, ..self.faults };
            return ServiceAnswer::NO_SERVICE;
        }
        // Outputs held by Sync must not change. Otherwise the buffer is reused and returned by `set_outputs`.
        let mut outputs = match self.sync_outputs {
            Some(_) => self.outputs.clone(),
            None => core::mem::take(&mut self.outputs),
        };
        outputs.resize(self.sums.outputs, 0);
        for (output, byte) in outputs.iter_mut().zip(data) {
            *output = *byte;
        }
        let outputs = (!is_fail_safe && !self.is_clear).then_some(outputs);
        match &mut self.sync_outputs {
            Some(held) => *held = outputs,
            None => self.set_outputs(env, outputs),
        }
        let octets = self.inputs(env);
        if octets.is_empty() && !self.has_new_diagnosis {
            return ServiceAnswer::Taken;
        }
        ServiceAnswer::Data { octets, is_high: self.has_new_diagnosis }
    }

    pub(super) fn set_outputs(&mut self, env: &mut SlaveEnv<'_>, outputs: Option<Vec<u8>>) {
        let outputs = self.hooks.apply(outputs, |hooks, mut outputs| {
            hooks.outputs(&mut outputs);
            outputs
        });
        env.application.outputs(env.application_time(), outputs.as_deref());
        self.outputs = outputs.unwrap_or_else(|| vec![0; self.sums.outputs]);
    }

    fn inputs(&mut self, env: &mut SlaveEnv<'_>) -> Vec<u8> {
        match &self.frozen_inputs {
            Some(frozen) => frozen.clone(),
            None => self.fresh_inputs(env),
        }
    }

    fn fresh_inputs(&mut self, env: &mut SlaveEnv<'_>) -> Vec<u8> {
        let mut inputs = vec![0; self.sums.inputs];
        env.application.inputs(env.application_time(), &mut inputs);
        let now = env.application_time();
        self.hooks.notify(|hooks| hooks.inputs(now, &mut inputs));
        inputs
    }

    /// Answers RD_Inp.
    pub(super) fn read_inputs(&mut self, env: &mut SlaveEnv<'_>) -> ServiceAnswer {
        if self.state != DpState::DataExchange || !self.check(env, SlaveStackCheck::ReadServices, true) {
            return ServiceAnswer::NO_SERVICE;
        }
        ServiceAnswer::data(self.inputs(env))
    }

    /// Answers RD_Outp with the outputs of the last Data_Exchange.
    pub(super) fn read_outputs(&self, env: &SlaveEnv<'_>) -> ServiceAnswer {
        if self.state != DpState::DataExchange || !self.check(env, SlaveStackCheck::ReadServices, true) {
            return ServiceAnswer::NO_SERVICE;
        }
        ServiceAnswer::data(self.outputs.clone())
    }

    /// Carries out a Global_Control of the master of the slave.
    pub(super) fn global_control(&mut self, env: &mut SlaveEnv<'_>, sa: u8, data: &[u8]) {
        let Ok(control) = GlobalControl::parse(data) else { return };
        if self.state != DpState::DataExchange || self.master != Some(sa) {
            return;
        }
        let is_addressed = self.check(env, SlaveStackCheck::Group(control.groups), control.is_for(self.groups));
        if is_addressed || control.groups & CLOCK_GROUP != 0 {
            env.application.clock(env.application_time());
        }
        if !is_addressed {
            return;
        }
        let command = control.command;
        self.is_clear = command.has(GlobalCommand::CLEAR_DATA);
        if self.is_clear {
            if let Some(held) = &mut self.sync_outputs {
                *held = None;
            }
            self.set_outputs(env, None);
        }
        self.follow_freeze(env, command);
        self.follow_sync(env, command);
    }

    fn follow_freeze(&mut self, env: &mut SlaveEnv<'_>, command: GlobalCommand) {
        if command.has(GlobalCommand::UNFREEZE) {
            self.frozen_inputs = None;
        } else if command.has(GlobalCommand::FREEZE) && self.identity.freeze {
            self.frozen_inputs = Some(self.fresh_inputs(env));
        }
    }

    fn follow_sync(&mut self, env: &mut SlaveEnv<'_>, command: GlobalCommand) {
        let is_sync = command.has(GlobalCommand::SYNC) && self.identity.sync;
        if command.has(GlobalCommand::UNSYNC) {
            if let Some(outputs) = self.sync_outputs.take() {
                self.set_outputs(env, outputs);
            }
        } else if is_sync {
            match self.sync_outputs.clone() {
                Some(outputs) => self.set_outputs(env, outputs),
                None => self.sync_outputs = Some(Some(self.outputs.clone()).filter(|_| !self.is_clear)),
            }
        }
    }
}

/// The group of all stations that follow the bus clock.
const CLOCK_GROUP: u8 = 0x80;
