//! The presence of a slave: its identity before a trial, its answers after it, and counting cycles.

use super::unexpected;
use crate::trial::failure;
use crate::trial::step_error::{BoxedStepError, StepError, StepResult, no_connection};
use crate::trial::{RunningTrial, cycle_limit};
use crate::world::TrialWorld;
use controllers::profibus_dp::{DataLinkAnswer, MasterOutcome, MasterRequest, SlaveReleaseOutcome};
use judge::observe::Address;
use results::outcome::FailureCause;
use results::verdict::Verdict;
use station::{Duration, StandAction, Time};
use suite::model::AnswerPart;
use wire::profibus::address::SetSlaveAddress;

/// The time between two attempts to reach the slave.
const AGAIN: Duration = Duration::from_millis(50);

/// How long a model may take to answer when a trial begins.
const AT_ONCE: Duration = Duration::from_millis(100);
/// How long the power is off in a power cycle.
const WITHOUT_POWER: Duration = Duration::from_secs(1);

impl RunningTrial<'_> {
    /// The ident number that the device claims.
    pub(super) fn ident(&self) -> u16 {
        self.world.manual.device.ident().unwrap_or_default()
    }

    /// The slot of the data set for parameters.
    pub(super) fn parameter_slot(&self) -> u8 {
        self.world.manual.device.profibus().map_or(0, |slave| slave.parameter_slot)
    }

    /// Checks that the slave answers Slave_Diag with the ident number that the bench claims; otherwise the trial is inconclusive.
    pub(super) fn check_slave_identity(&mut self) -> StepResult {
        let claimed = self.ident();
        let address = self.slave.address;
        self.world.scene.follower.station = Some(Address::Fdl(address));
        // A model was powered long before the trial, so it answers at once or never.
        let patience = if self.world.segment.is_virtual() { AT_ONCE } else { self.patience() };
        let until = self.world.now() + patience;
        let ident = loop {
            let answer = self.diagnose(false, address)?;
            if let Some(diagnosis) = answer.diagnosis() {
                break diagnosis.ident;
            }
            if self.world.now() >= until {
                let what = format!("The device does not answer Slave_Diag at station {address} ({answer}).");
                return Err(StepError::other(FailureCause::Environment, Verdict::Inconclusive, what));
            }
            self.world.run(self.world.now() + AGAIN, |_| false);
        };
        if ident != claimed {
            let what = format!("The slave has ident 0x{ident:04X}, but the bench claims 0x{claimed:04X}.");
            return Err(StepError::other(FailureCause::Environment, Verdict::Inconclusive, what));
        }
        self.slave.ident = Some(ident);
        Ok(())
    }

    /// Sends one Slave_Diag, whose answer counts as the diagnosis of the device.
    pub(super) fn diagnose(&mut self, second: bool, to: u8) -> Result<DataLinkAnswer, BoxedStepError> {
        self.world.scene.follower.station = Some(Address::Fdl(to));
        self.ask_link(second, MasterRequest::Diagnosis { to })
    }

    /// Checks that the slave answers at one of the addresses that it may have now.
    pub(super) fn check_slave_presence(&mut self) -> StepResult {
        let addresses = self.slave.possible().to_vec();
        self.found_at(&addresses, self.patience())?;
        Ok(())
    }

    /// Makes sure that the slave is at the address of the bench, in its initial state. `has_read`: it has started with switches or
    /// faults that no longer apply, so it has to start again.
    ///
    /// An address that the slave stores for another position of its switches stays: no service removes it.
    pub(super) fn restore_slave_address(&mut self, has_read: bool) -> StepResult {
        let home = self.slave.address;
        let addresses = self.slave.possible().to_vec();
        let mut patience = AT_ONCE;
        if has_read {
            self.act_on_stand(&StandAction::Power(false))?;
            self.world.run(self.world.now() + WITHOUT_POWER, |_| false);
            self.act_on_stand(&StandAction::Power(true))?;
            patience = self.patience();
        } else if addresses == [home] {
            return Ok(());
        }
        if self.found_at(&[home], patience).is_ok() {
            return Ok(());
        }
        let at = self.found_at(&addresses, self.patience())?;
        if self.slave.was_assigned(at) {
            let ident = self.ident();
            let set = SetSlaveAddress { address: home, ident, no_change: 0, slave_data: Vec::new() };
            self.ask_link(false, MasterRequest::SetSlaveAddress { to: at, set })?;
            if self.found_at(&[home], AT_ONCE).is_ok() {
                return Ok(());
            }
        }
        let what = format!("The device stays at station {at} and does not return to {home}.");
        Err(StepError::other(FailureCause::Device, Verdict::Inconclusive, what))
    }

    /// Whether the slave is at this address.
    fn is_at(&mut self, address: u8) -> Result<bool, BoxedStepError> {
        let expected = self.ident();
        Ok(self.diagnose(false, address)?.diagnosis().is_some_and(|diagnosis| diagnosis.ident == expected))
    }

    /// The address of the slave among these; it may be absent for the time `patience`.
    fn found_at(&mut self, addresses: &[u8], patience: Duration) -> Result<u8, BoxedStepError> {
        let until = self.world.now() + patience;
        loop {
            for &address in addresses {
                if self.is_at(address)? {
                    return Ok(address);
                }
            }
            if self.world.now() >= until {
                let what = "The device no longer answers after the trial.";
                return Err(StepError::other(FailureCause::Device, Verdict::Inconclusive, what));
            }
            self.world.run(self.world.now() + AGAIN, |_| false);
        }
    }

    /// Releases the slave.
    pub(super) fn release(&mut self, second: bool) -> StepResult {
        match self.ask_master(second, MasterRequest::Release)? {
            MasterOutcome::Ended(SlaveReleaseOutcome::Released(answer)) => {
                self.world.scene.notebook_mut().answers = vec![(AnswerPart::Whole, super::reply(&answer))];
                Ok(())
            }
            MasterOutcome::Ended(SlaveReleaseOutcome::Aborted | SlaveReleaseOutcome::NoConnection) => Ok(()),
            outcome => Err(unexpected(&outcome)),
        }
    }

    /// Waits until a request with the present outputs has been sent; its answer is the next sample.
    ///
    /// Nothing is sent any more to a slave that the step has cut off: the first poll without an answer ends the exchange.
    pub(super) fn wait_for_outputs(&mut self) -> StepResult {
        let (sent, observed) = (self.world.stations.cycles_begun(), self.world.output_frames);
        let done =
            self.run_cycles(1, |world| world.stations.cycles_begun() > sent && world.output_frames > observed)?;
        let is_cut_off = self.may_end && !self.world.stations.is_connected(0);
        if done || is_cut_off { Ok(()) } else { Err(self.no_exchange()) }
    }

    /// Waits until this many exchanges have ended; one that has already begun does not count.
    pub(super) fn whole_cycles(&mut self, count: u64) -> StepResult {
        let target = self.world.stations.cycles_begun() + count;
        let done = self.run_cycles(count, |world| world.stations.cycles_done() >= target)?;
        if done { Ok(()) } else { Err(self.no_exchange()) }
    }

    /// The trouble with a step that needs data exchange when there is none: why our master has ended it, if it has.
    fn no_exchange(&mut self) -> BoxedStepError {
        let misfit = self.driver.misfit(self);
        let ended = self.world.stations.master_mut(0).and_then(|master| master.take_end());
        match (misfit.or_else(|| ended.map(|end| end.to_string())), self.world.lost) {
            (Some(why), _) => {
                StepError::device(format!("There is no connection any more, because of the device: {why}."), Vec::new())
            }
            (None, Some(lost)) => {
                StepError::device(format!("There is no connection any more. {}", failure::lost(&lost)), Vec::new())
            }
            (None, None) => no_connection(),
        }
    }

    fn run_cycles(
        &mut self,
        count: u64,
        mut done: impl FnMut(&TrialWorld<'_>) -> bool,
    ) -> Result<bool, BoxedStepError> {
        let cycle = self.cycle_in_use().ok_or_else(|| self.no_exchange())?;
        let limit = cycle_limit(cycle, count);
        let until: Time = self.world.now() + limit;
        let ran = self.world.run(until, |world| done(world) || world.lost.is_some() || !world.stations.is_connected(0));
        Ok(ran && self.world.lost.is_none() && done(&self.world))
    }

    fn cycle_in_use(&self) -> Option<Duration> {
        self.world.stations.is_connected(0).then(|| self.world.scene.follower.image.cycle()).flatten()
    }
}
