//! Reads a live slave before the first trial, and restores it after the last.
//!
//! It judges no requirement.

use super::start::connection;
use super::unexpected;
use crate::live::{DeviceBackup, RestoreOutcome};
use crate::trial::RunningTrial;
use crate::trial::step_error::BoxedStepError;
use controllers::profibus_dp::{DataLinkAnswer, DpParameterOutcome, MasterOutcome, MasterRequest};
use judge::observe::Address;
use results::journal::InitialDevice;
use suite::model::ConnectionStart;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::fdl::BROADCAST;
use wire::profibus::prm::StationStatus;

/// The least min T_SDR, in bit times.
const LEAST_TSDR: u8 = 11;

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

    /// Restores the slave: the parameters at its present address, then, unlocked, the address at which it was found.
    pub(super) fn restore_slave(&mut self, found: &InitialDevice, kept: &DeviceBackup<'_>) -> RestoreOutcome {
        let mut outcome = RestoreOutcome::default();
        let home = found.station.unwrap_or(self.slave.address);
        let Some(at) = self.search_slave(home, found.device_id) else {
            outcome.left.push(format!(
                "anything: no slave with ident 0x{:04X} answers at station {home} or at an address that no other station has; \
                 check its power and cable",
                found.device_id
            ));
            return outcome;
        };
        self.slave.address = at;
        self.restore_values(kept, &mut outcome);
        if at != home
            && let Err(why) = self.move_slave(at, home, found.device_id)
        {
            outcome.left.push(format!("the station address {home}: the slave stays at {at}: {why}"));
        }
        outcome
    }

    /// The address at which a slave with this ident answers: `home`, that of the bench, else any that no other station has.
    fn search_slave(&mut self, home: u8, ident: u16) -> Option<u8> {
        let until = self.world.now() + self.patience();
        let masters = self.environment.line.masters;
        let mut addresses = vec![home, self.slave.address];
        loop {
            for &address in &addresses {
                let answer = self.diagnose(false, address).ok();
                if answer.and_then(|answer| answer.diagnosis()).is_some_and(|diagnosis| diagnosis.ident == ident) {
                    return Some(address);
                }
            }
            if self.world.now() >= until {
                if addresses.len() > 2 {
                    return None;
                }
                addresses = (0..BROADCAST).filter(|address| !masters.contains(address)).collect();
            }
        }
    }

    /// Unlocks the slave by a Set_Prm, since it takes an address only from there, and gives it the address `home`.
    fn move_slave(&mut self, at: u8, home: u8, ident: u16) -> Result<(), String> {
        let words = |answer: &DataLinkAnswer| super::reply(answer).to_string();
        let [high, low] = ident.to_be_bytes();
        let octets = vec![StationStatus::UNLOCK_REQ.0, 1, 1, LEAST_TSDR, high, low, 0];
        let unlocked =
            self.ask_link(false, MasterRequest::SetPrm { to: at, octets }).map_err(|trouble| trouble.what)?;
        if !unlocked.is_positive() {
            return Err(format!("Set_Prm with Unlock_Req: {}", words(&unlocked)));
        }
        let set = SetSlaveAddress { address: home, ident, no_change: 0, slave_data: Vec::new() };
        let taken =
            self.ask_link(false, MasterRequest::SetSlaveAddress { to: at, set }).map_err(|trouble| trouble.what)?;
        let until = self.world.now() + self.patience();
        loop {
            let answer = self.diagnose(false, home).map_err(|trouble| trouble.what)?;
            if answer.diagnosis().is_some_and(|diagnosis| diagnosis.ident == ident) {
                return Ok(());
            }
            if self.world.now() >= until {
                return Err(format!("Set_Slave_Address: {}, and nothing answers at {home}", words(&taken)));
            }
        }
    }
}
