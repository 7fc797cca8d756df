//! Reads a live slave before the first trial and checks it after the last.
//!
//! It judges no requirement.

use super::start::connection;
use super::unexpected;
use crate::trial::RunningTrial;
use crate::trial::step_error::BoxedStepError;
use controllers::profibus_dp::{DpParameterOutcome, MasterOutcome, MasterRequest};
use judge::observe::Address;
use results::journal::InitialDevice;
use suite::model::ConnectionStart;

impl RunningTrial<'_> {
    /// Whether the slave exchanges data after this start-up; `None` if it neither accepts nor refuses it.
    pub(super) fn slave_connects_with(&mut self, start: &ConnectionStart) -> Result<Option<bool>, BoxedStepError> {
        self.disconnect(false)?;
        let address = self.slave.address;
        self.world.scene.follower.station = Some(Address::Fdl(address));
        let connection = connection(&self.world.manual.device, start, address, self.patience());
        self.use_module(start.module);
        let outcome = self.ask_master(false, MasterRequest::Connect(Box::new(connection)))?;
        let MasterOutcome::StartUp(outcome) = outcome else { return Err(unexpected(&outcome)) };
        let stages = [&outcome.set_prm, &outcome.chk_cfg, &outcome.diagnosis_after];
        let answered = stages.into_iter().all(|answer| answer.as_ref().is_some_and(|of| of.is_positive()));
        Ok(match (outcome.standing, answered) {
            (true, _) => Some(true),
            (false, true) => Some(false),
            (false, false) => None,
        })
    }

    /// The response to a parameter request by data set 47, in the present connection.
    pub(super) fn slave_parameter(&mut self, request: Vec<u8>) -> Option<Vec<u8>> {
        let slot = self.parameter_slot();
        let to = self.slave.address;
        match self.ask_master(false, MasterRequest::Parameter { to, slot, request }) {
            Ok(MasterOutcome::Parameter(DpParameterOutcome::Answer(octets))) => Some(octets),
            _ => None,
        }
    }

    /// Checks that the slave is at the address where it was found; a search among other stations is not possible.
    pub(super) fn check_slave_address(&mut self, found: &InitialDevice, left: &mut Vec<String>) {
        let Some(station) = found.station else { return };
        let there = self.diagnose(false, station);
        let ident = there.ok().and_then(|answer| answer.diagnosis()).map(|diagnosis| diagnosis.ident);
        if ident != Some(found.device_id) {
            left.push(format!("the station address {station}"));
        }
    }
}
