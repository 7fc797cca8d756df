//! Cyclic data: Data_Exchange, Global_Control, RD_Inp and RD_Outp.

use super::application::{End, State};
use super::diagnosis::Faults;
use super::hooks::Check;
use super::link::Answer;
use super::slave::{Env, Slave};
use alloc::vec;
use alloc::vec::Vec;
use wire::profibus::global_control::{ControlCommand, GlobalControl};

impl Slave {
    /// Answers Data_Exchange: takes the outputs and returns the inputs.
    pub(super) fn exchange(&mut self, env: &mut Env<'_>, sa: u8, data: &[u8]) -> Answer {
        if !self.is_exchanging_with(sa) {
            return Answer::NO_SERVICE;
        }
        let is_fail_safe = data.is_empty() && self.has_fail_safe;
        let fits = self.check(env, Check::OutputLength(data.len()), data.len() == self.sums.outputs);
        if !is_fail_safe && !fits {
            self.leave(env, End::Fault);
            self.faults = Faults { cfg: true, ..self.faults };
            return Answer::NO_SERVICE;
        }
        // Outputs held by Sync must not change. Otherwise the buffer is reused and returned by `put`.
        let mut outputs = match self.held {
            Some(_) => self.outputs.clone(),
            None => core::mem::take(&mut self.outputs),
        };
        outputs.resize(self.sums.outputs, 0);
        for (output, byte) in outputs.iter_mut().zip(data) {
            *output = *byte;
        }
        let outputs = (!is_fail_safe && !self.is_clear).then_some(outputs);
        match &mut self.held {
            Some(held) => *held = outputs,
            None => self.put(env, outputs),
        }
        let octets = self.inputs(env);
        if octets.is_empty() && !self.is_announced {
            return Answer::Taken;
        }
        Answer::Data { octets, is_high: self.is_announced }
    }

    pub(super) fn put(&mut self, env: &mut Env<'_>, outputs: Option<Vec<u8>>) {
        let outputs = self.hooks.apply(outputs, |hooks, mut outputs| {
            hooks.outputs(&mut outputs);
            outputs
        });
        env.application.outputs(env.at(), outputs.as_deref());
        self.outputs = outputs.unwrap_or_else(|| vec![0; self.sums.outputs]);
    }

    fn inputs(&mut self, env: &mut Env<'_>) -> Vec<u8> {
        match &self.frozen {
            Some(frozen) => frozen.clone(),
            None => self.fresh_inputs(env),
        }
    }

    fn fresh_inputs(&mut self, env: &mut Env<'_>) -> Vec<u8> {
        let mut inputs = vec![0; self.sums.inputs];
        env.application.inputs(env.at(), &mut inputs);
        self.hooks.notify(|hooks| hooks.inputs(&mut inputs));
        inputs
    }

    /// Answers RD_Inp.
    pub(super) fn read_inputs(&mut self, env: &mut Env<'_>) -> Answer {
        if self.state != State::DataExchange {
            return Answer::NO_SERVICE;
        }
        Answer::data(self.inputs(env))
    }

    /// Answers RD_Outp with the outputs of the last Data_Exchange.
    pub(super) fn read_outputs(&self) -> Answer {
        match self.state {
            State::WaitPrm | State::WaitCfg => Answer::NO_SERVICE,
            State::DataExchange => Answer::data(self.outputs.clone()),
        }
    }

    /// Carries out a Global_Control of the master of the slave.
    pub(super) fn global_control(&mut self, env: &mut Env<'_>, sa: u8, data: &[u8]) {
        let Ok(control) = GlobalControl::parse(data) else { return };
        if self.state != State::DataExchange || self.master != Some(sa) {
            return;
        }
        let is_addressed = self.check(env, Check::Group(control.groups), control.is_for(self.groups));
        if is_addressed || control.groups & CLOCK_GROUP != 0 {
            env.application.clock(env.at());
        }
        if !is_addressed {
            return;
        }
        let command = control.command;
        self.is_clear = command.has(ControlCommand::CLEAR_DATA);
        if self.is_clear {
            if let Some(held) = &mut self.held {
                *held = None;
            }
            self.put(env, None);
        }
        self.follow_freeze(env, command);
        self.follow_sync(env, command);
    }

    fn follow_freeze(&mut self, env: &mut Env<'_>, command: ControlCommand) {
        if command.has(ControlCommand::UNFREEZE) {
            self.frozen = None;
        } else if command.has(ControlCommand::FREEZE) && self.identity.freeze {
            self.frozen = Some(self.fresh_inputs(env));
        }
    }

    fn follow_sync(&mut self, env: &mut Env<'_>, command: ControlCommand) {
        let is_sync = command.has(ControlCommand::SYNC) && self.identity.sync;
        if command.has(ControlCommand::UNSYNC) {
            if let Some(outputs) = self.held.take() {
                self.put(env, outputs);
            }
        } else if is_sync {
            match self.held.clone() {
                Some(outputs) => self.put(env, outputs),
                None => self.held = Some(Some(self.outputs.clone()).filter(|_| !self.is_clear)),
            }
        }
    }
}

/// The group of all stations that follow the bus clock.
const CLOCK_GROUP: u8 = 0x80;
