//! The presence of a device: its identity before a trial, its answers after it, and restoring its name.

use super::{IDENTIFY, unexpected};
use crate::trial::RunningTrial;
use crate::trial::step_error::{BoxedStepError, StepError, StepResult};
use controllers::profinet_io::{ControllerOutcome, ControllerRequest, DcpOutcome, IdentifiedStation, IdentifyBy};
use judge::observe::Address;
use results::outcome::FailureCause;
use results::verdict::Verdict;
use station::Duration;
use wire::ethernet::Mac;
use wire::profinet::dcp::{BlockQualifier, DcpBlock, DcpValue, Element};

/// How long the answer to an Identify by name may take.
const FOUND: Duration = Duration::from_millis(100);
/// The time between two attempts to reach the device.
const AGAIN: Duration = Duration::from_millis(100);

impl RunningTrial<'_> {
    /// Checks that the device of a live bench, found before, answers as the same one, and restores a name that an earlier trial
    /// changed.
    pub(super) fn check_same_device(&mut self, mac: Mac) -> StepResult {
        self.mac = mac;
        let until = self.world.now() + self.patience();
        let station = loop {
            if let Some(station) = self.identify_device()? {
                break station;
            }
            if self.world.now() >= until {
                let what = "The device does not answer DCP Identify.";
                return Err(StepError::other(FailureCause::Environment, Verdict::Inconclusive, what));
            }
            self.world.run(self.world.now() + AGAIN, |_| false);
        };
        let is_named = station.name == self.environment.name.as_bytes();
        self.check_claim(station)?;
        self.renamed = !is_named;
        self.restore_station_name()?;
        self.renamed = false;
        Ok(())
    }

    fn check_claim(&mut self, station: IdentifiedStation) -> StepResult {
        let claimed = self.world.manual.device.ids().unwrap_or_default();
        if station.id != Some(claimed) {
            let observed = station.id.map_or_else(
                || "reports no vendor and device id".to_owned(),
                |(vendor, device)| format!("is vendor 0x{vendor:04X} device 0x{device:04X}"),
            );
            let (vendor, device) = claimed;
            let what =
                format!("The station {observed}, but the bench claims vendor 0x{vendor:04X} device 0x{device:04X}.");
            return Err(StepError::other(FailureCause::Environment, Verdict::Inconclusive, what));
        }
        self.mac = station.mac;
        self.world.scene.follower.station = Some(Address::Mac(station.mac));
        self.identity = Some(station);
        Ok(())
    }

    pub(super) fn find_device(&mut self) -> StepResult {
        let inconclusive = |what: String| StepError::other(FailureCause::Environment, Verdict::Inconclusive, what);
        let outcome = self.ask(false, ControllerRequest::Identify { by: IdentifyBy::All, wait: IDENTIFY })?;
        let ControllerOutcome::Stations(stations) = outcome else { return Err(unexpected(&outcome)) };
        let is_device = |station: &&IdentifiedStation| station.name == self.environment.name.as_bytes();
        let Some(station) = stations.iter().find(is_device) else {
            let is_other = |station: &&IdentifiedStation| !self.world.addresses.contains(&Address::Mac(station.mac));
            let others = match stations.iter().filter(is_other).count() {
                0 => "no station answers".to_owned(),
                count => format!("{count} other station(s) answer"),
            };
            return Err(inconclusive(format!("The device does not answer DCP Identify; {others}.")));
        };
        let station = station.clone();
        self.check_claim(station)
    }

    /// Restores the name of the station, if the trial may have changed it.
    pub(super) fn restore_station_name(&mut self) -> StepResult {
        if !self.renamed {
            return Ok(());
        }
        // On a live bench a correct name is not written again: this would wear out its memory, and some devices accept no name.
        let name = self.environment.name.as_bytes();
        if !self.world.segment.is_virtual() && self.identify_device()?.is_some_and(|station| station.name == name) {
            return Ok(());
        }
        let name = DcpValue::NameOfStation(self.environment.name.clone().into_bytes());
        let blocks = vec![DcpBlock::set(BlockQualifier::PERMANENT, name)];
        match self.ask(false, ControllerRequest::DcpSet { to: self.mac, blocks })? {
            ControllerOutcome::Dcp(DcpOutcome::Accepted) => Ok(()),
            outcome => {
                let why = match &outcome {
                    ControllerOutcome::Dcp(outcome) => super::station::dcp(outcome).to_string(),
                    ControllerOutcome::Impossible(why) => (*why).to_owned(),
                    other => format!("outcome of another request: {other:?}"),
                };
                let what = format!("The station did not accept its old name: {why}.");
                Err(StepError::other(FailureCause::Device, Verdict::Inconclusive, what))
            }
        }
    }

    pub(super) fn check_presence(&mut self) -> StepResult {
        let began = self.world.now();
        let until = began + self.patience();
        let claimed = self.world.manual.device.ids().unwrap_or_default();
        loop {
            // A live device need not support DCP Get; every device has to answer Identify.
            if !self.world.segment.is_virtual()
                && self.identify_device()?.is_some_and(|station| station.id == Some(claimed))
            {
                return Ok(());
            }
            let outcome =
                self.ask(false, ControllerRequest::DcpGet { to: self.mac, elements: vec![Element::DEVICE_ID] })?;
            let lives = matches!(&outcome, ControllerOutcome::Dcp(DcpOutcome::Values(blocks)) if blocks.iter().any(|block| {
                block.value == DcpValue::DeviceId { vendor_id: claimed.0, device_id: claimed.1 }
            }));
            if lives {
                return Ok(());
            }
            if self.world.now() >= until {
                let what = "The device no longer answers after the trial.";
                return Err(StepError::other(FailureCause::Device, Verdict::Inconclusive, what));
            }
            self.world.run(self.world.now() + AGAIN, |_| false);
        }
    }

    /// The identity of a live device: requested by its name, which it answers at once, else among all stations, since it may have
    /// another name now.
    pub(super) fn identify_device(&mut self) -> Result<Option<IdentifiedStation>, BoxedStepError> {
        let by_name = (IdentifyBy::Name(self.environment.name.clone().into_bytes()), FOUND);
        let questions =
            [Some(by_name).filter(|_| !self.environment.name.is_empty()), Some((IdentifyBy::All, IDENTIFY))];
        for (by, wait) in questions.into_iter().flatten() {
            let outcome = self.ask(false, ControllerRequest::Identify { by, wait })?;
            let ControllerOutcome::Stations(stations) = outcome else { return Err(unexpected(&outcome)) };
            if let Some(station) = stations.into_iter().find(|station| station.mac == self.mac) {
                return Ok(Some(station));
            }
        }
        Ok(None)
    }
}
