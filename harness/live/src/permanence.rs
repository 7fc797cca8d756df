//! Whether a device has stored its station name and its IP address: DCP cannot read it, and one power cycle before the first change
//! shows it.
//!
//! What the device loses by the power cycle is put back at once. This module must not know suites.

use super::device_discovery::{PreflightDiscovery, preflight_change, why};
use super::journal::{Journal, JournalEntry};
use super::stand::LiveStand;
use super::unusable::{PreflightResult, Unusable, unusable};
use controllers::profinet_io::{
    Controller, ControllerOutcome, ControllerRequest, DcpOutcome, IdentifiedStation, IdentifyBy,
};
use results::bench_file::{BenchFile, DcpPermanence};
use results::journal::{InitialDevice, change};
use station::{Duration, StandAction};
use std::net::Ipv4Addr;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, DcpBlock, DcpValue};

/// How long the device may take to answer DCP after power-on.
const POWER_UP_TIMEOUT: Duration = Duration::from_secs(60);
/// How long answers to one Identify are collected.
const ROUND: Duration = Duration::from_millis(500);
/// The stand name of the power.
const POWER: &str = "power";

/// Whether a power cycle may show what is stored: the stand switches the power without a person, the bench permits both changes
/// that put back what is lost, there is something to learn, and the bench file does not say it.
pub(super) fn may_learn(bench: &BenchFile, found: &InitialDevice) -> bool {
    let has_any = !found.name.is_empty() || found.ip != Ipv4Addr::UNSPECIFIED;
    let permits = bench.consent.set_name && bench.consent.set_ip;
    let is_known = bench.ip_permanence.is_some();
    if !has_any || !permits || is_known || bench.stand.ask.iter().any(|name| name == POWER) {
        return false;
    }
    let mut stand = bench.stand.clone();
    if stand.offers.is_none() {
        stand.offers = LiveStand::new(&stand).offers().ok().flatten();
    }
    // A control channel that does not say what it serves is not trusted with the power.
    (stand.control.is_none() || stand.offers.is_some()) && stand.serves(POWER)
}

/// What the power cycle shows of a value that was there before.
fn permanence<T: PartialEq>(before: &T, after: &T, none: &T) -> DcpPermanence {
    match () {
        () if before == none => DcpPermanence::Unknown,
        () if before == after => DcpPermanence::Permanent,
        () => DcpPermanence::Temporary,
    }
}

impl PreflightDiscovery {
    /// Switches the power off and on, notes what the device has kept, and puts back what it has lost; returns the changes.
    pub fn learn_permanence(
        &mut self,
        bench: &BenchFile,
        controller: &mut Controller,
        station: &IdentifiedStation,
        found: &mut InitialDevice,
        journal: &mut Journal,
        notes: &mut Vec<String>,
    ) -> PreflightResult<Vec<&'static str>> {
        let mut add = |entry: &JournalEntry| {
            journal.add(entry).map_err(|error| Unusable(format!("the journal cannot be written: {error}")))
        };
        add(&JournalEntry::Changes {
            trial: "preflight".to_owned(),
            what: vec![change::POWER_CYCLE.to_owned()],
            stand: vec![POWER.to_owned()],
        })?;
        let cycled = LiveStand::new(&bench.stand).act_in_turn(&[StandAction::Power(false), StandAction::Power(true)]);
        cycled.map_err(|why| Unusable(format!("the power cycle that shows what the device has stored: {why}")))?;
        let Some(after) = self.identify_again(controller, station)? else {
            return unusable(format!(
                "{} does not answer DCP Identify within {} s after a power cycle, which was to show what it has stored; say \
                 `ip_permanence` in the bench file to do without",
                station.mac,
                POWER_UP_TIMEOUT.as_secs()
            ));
        };
        found.name_permanence = permanence(&station.name, &after.name, &Vec::new());
        found.ip_permanence = permanence(&station.ip, &after.ip, &IpParameter::NONE);
        add(&JournalEntry::Permanence { name: found.name_permanence, ip: found.ip_permanence })?;
        notes.push(format!(
            "a power cycle before the first change showed: station name {}, IP address {}",
            text(found.name_permanence),
            text(found.ip_permanence)
        ));
        let mut changes = vec![change::POWER_CYCLE];
        if found.name_permanence == DcpPermanence::Temporary {
            changes.push(change::NAME);
            // A name that is lost with the power would not last through the run; it is put back as a temporary one at its end.
            add(&preflight_change(change::NAME))?;
            self.set_back(
                controller,
                station,
                BlockQualifier::PERMANENT,
                DcpValue::NameOfStation(station.name.clone()),
            )?;
        }
        if found.ip_permanence == DcpPermanence::Temporary {
            changes.push(change::TEMPORARY_IP);
            if !after.ip.address.is_unspecified() {
                notes.push(format!(
                    "the device had stored the IP address {}, which a temporary one erases",
                    after.ip.address
                ));
            }
            add(&preflight_change(change::TEMPORARY_IP))?;
            self.set_back(controller, station, BlockQualifier::TEMPORARY, DcpValue::IpParameter(station.ip))?;
        }
        Ok(changes)
    }

    /// The same station after its start; `None` if it does not answer.
    fn identify_again(
        &mut self,
        controller: &mut Controller,
        station: &IdentifiedStation,
    ) -> PreflightResult<Option<IdentifiedStation>> {
        let until = self.wire.clock().now() + POWER_UP_TIMEOUT;
        while self.wire.clock().now() < until {
            let request = ControllerRequest::Identify { by: IdentifyBy::All, wait: ROUND };
            if let ControllerOutcome::Stations(stations) = self.ask(controller, request)?
                && let Some(same) = stations.into_iter().find(|of| of.mac == station.mac)
            {
                return Ok(Some(same));
            }
        }
        Ok(None)
    }

    fn set_back(
        &mut self,
        controller: &mut Controller,
        station: &IdentifiedStation,
        qualifier: BlockQualifier,
        value: DcpValue,
    ) -> PreflightResult<()> {
        let blocks = vec![DcpBlock::set(qualifier, value)];
        match self.ask(controller, ControllerRequest::DcpSet { to: station.mac, blocks })? {
            ControllerOutcome::Dcp(DcpOutcome::Accepted) => Ok(()),
            outcome => unusable(format!("what the power cycle erased cannot be put back: {}", why(&outcome))),
        }
    }
}

/// The word for the report.
fn text(permanence: DcpPermanence) -> &'static str {
    match permanence {
        DcpPermanence::Permanent => "permanent",
        DcpPermanence::Temporary => "temporary",
        DcpPermanence::Unknown => "none, so unknown",
    }
}
