//! Cyclic data: Data_Exchange, Global_Control, and reading what is exchanged.

use super::application::{End, State};
use super::link::Answer;
use super::slave::{Env, Faults, Slave};
use alloc::vec;
use alloc::vec::Vec;
use wire::profibus::global_control::{ControlCommand, GlobalControl};

impl Slave {
    /// Takes outputs and gives inputs.
    pub(super) fn exchange(&mut self, env: &mut Env<'_>, sa: u8, data: &[u8]) -> Answer {
        let goes_ahead = !self.behaviour.exchanges_after_configuration && self.state == State::WaitCfg;
        if !self.is_exchanging_with(sa) && !goes_ahead {
            env.application.outputs_refused(env.at(), data);
            return Answer::NO_SERVICE;
        }
        if !env.application.takes_outputs(env.at()) {
            return Answer::NO_SERVICE;
        }
        if goes_ahead {
            let mut identifiers = Vec::new();
            env.application.configuration(&mut identifiers);
            let Some(sums) = env.application.check_configuration(env.at(), &identifiers) else {
                return Answer::NO_SERVICE;
            };
            self.sums = sums;
        }
        let is_fail_safe = data.is_empty() && self.has_fail_safe;
        if !is_fail_safe && !(self.behaviour.takes_outputs)(data.len(), self.sums.outputs) {
            self.leave(env, End::Fault);
            self.faults = Faults { cfg: true, ..self.faults };
            return Answer::NO_SERVICE;
        }
        // Those that are put away for the command have to stay what they are; others come back with what is put in their place.
        let mut outputs = match self.held {
            Some(_) => self.image.outputs.clone(),
            None => core::mem::take(&mut self.image.outputs),
        };
        outputs.resize(self.sums.outputs, 0);
        let takes = !self.is_clear || self.behaviour.clears_outputs;
        for (octet, sent) in outputs.iter_mut().zip(data.iter().filter(|_| takes)) {
            *octet = *sent;
        }
        let is_clear = self.is_clear && self.behaviour.clears_outputs;
        let outputs = (!is_fail_safe && !is_clear).then_some(outputs);
        match &mut self.held {
            Some(held) => *held = outputs,
            None => self.put(env, outputs),
        }
        let octets = self.inputs(env);
        self.answers = self.answers.wrapping_add(1);
        let is_high = (self.behaviour.announces)(self.is_announced, self.told_fault, self.answers);
        if octets.is_empty() && !is_high {
            return Answer::Taken;
        }
        Answer::Data { octets, is_high }
    }

    fn put(&mut self, env: &mut Env<'_>, outputs: Option<Vec<u8>>) {
        env.application.outputs(env.at(), outputs.as_deref());
        let image = outputs.unwrap_or_else(|| vec![0; self.sums.outputs]);
        self.image.first_outputs.get_or_insert_with(|| image.clone());
        self.image.outputs = image;
    }

    fn inputs(&mut self, env: &mut Env<'_>) -> Vec<u8> {
        let inputs = match &self.frozen {
            Some(frozen) => frozen.clone(),
            None => self.fresh_inputs(env),
        };
        self.image.first_inputs.get_or_insert_with(|| inputs.clone());
        inputs
    }

    fn fresh_inputs(&mut self, env: &mut Env<'_>) -> Vec<u8> {
        let mut inputs = vec![0; self.sums.inputs];
        if !self.is_clear || self.behaviour.keeps_inputs_in_clear {
            env.application.inputs(env.at(), &mut inputs);
        }
        inputs
    }

    /// Gives the inputs without taking outputs.
    pub(super) fn read_inputs(&mut self, env: &mut Env<'_>) -> Answer {
        if self.state != State::DataExchange {
            return Answer::NO_SERVICE;
        }
        let octets = match self.behaviour.reads_fresh_inputs {
            true => self.frozen.clone().unwrap_or_else(|| self.fresh_inputs(env)),
            false => self.image.first_inputs.clone().unwrap_or_default(),
        };
        Answer::data(octets)
    }

    /// Gives the outputs of the last exchange.
    pub(super) fn read_outputs(&self) -> Answer {
        match (self.state, self.behaviour.reads_fresh_outputs) {
            (State::WaitPrm | State::WaitCfg, _) => Answer::NO_SERVICE,
            (State::DataExchange, true) => Answer::data(self.image.outputs.clone()),
            (State::DataExchange, false) => Answer::data(self.image.first_outputs.clone().unwrap_or_default()),
        }
    }

    /// Follows a command of its master.
    pub(super) fn global_control(&mut self, env: &mut Env<'_>, sa: u8, data: &[u8]) {
        let Ok(control) = GlobalControl::parse(data) else { return };
        if self.state != State::DataExchange || self.master != Some(sa) || !(self.behaviour.follows)(&control) {
            return;
        }
        let is_meant = (self.behaviour.is_in_group)(self.groups, &control);
        if is_meant || control.groups & CLOCK_GROUP != 0 {
            env.application.clock(env.at());
        }
        if !is_meant {
            return;
        }
        let command = control.command;
        self.is_clear = command.has(ControlCommand::CLEAR_DATA);
        if self.is_clear && self.behaviour.clears_outputs {
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
            env.application.freeze(env.at(), false);
        } else if command.has(ControlCommand::FREEZE) && self.identity.freeze && self.behaviour.freezes {
            self.frozen = Some(self.fresh_inputs(env));
            env.application.freeze(env.at(), true);
        }
    }

    fn follow_sync(&mut self, env: &mut Env<'_>, command: ControlCommand) {
        let is_sync = command.has(ControlCommand::SYNC) && self.identity.sync && self.behaviour.synchronises;
        if command.has(ControlCommand::UNSYNC) {
            if let Some(outputs) = self.held.take() {
                self.put(env, outputs);
            }
        } else if is_sync {
            match self.held.clone() {
                Some(outputs) => self.put(env, outputs),
                None => self.held = Some(Some(self.image.outputs.clone()).filter(|_| !self.is_clear)),
            }
        }
    }
}

/// The group to which all stations belong that follow the clock of the bus.
const CLOCK_GROUP: u8 = 0x80;
