//! Whether a device has stored its station name and its IP address: DCP cannot read it, and one power cycle before the first change
//! shows it.
//!
//! What the device loses by the power cycle is put back at once. This module must not know suites.

use super::device_discovery::{PreflightDiscovery, note};
use super::journal::{Journal, JournalEntry};
use super::stand::LiveStand;
use super::unusable::{PreflightResult, Unusable, unusable};
use controllers::profinet_io::{Controller, ControllerOutcome, ControllerRequest, IdentifiedStation, IdentifyBy};
use results::bench_file::{BenchFile, DcpPermanence, StandSpec};
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
const NOT_PUT_BACK: &str = "what the power cycle erased cannot be put back";

/// Whether a power cycle may show what is stored: the stand switches the power without a person, the bench permits both changes
/// that put back what is lost, there is something to learn, and the bench file does not say it. `offers` is what its control channel
/// serves.
pub(super) fn may_learn(bench: &BenchFile, offers: Option<Vec<String>>, found: &InitialDevice) -> bool {
    let has_any = !found.name.is_empty() || found.ip != Ipv4Addr::UNSPECIFIED;
    let permits = bench.consent.set_name && bench.consent.set_ip;
    let is_known = bench.ip_permanence.is_some();
    if !has_any || !permits || is_known || bench.stand.ask.iter().any(|name| name == POWER) {
        return false;
    }
    let stand = StandSpec { offers, ..bench.stand.clone() };
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
        let (what, stand) = (vec![change::POWER_CYCLE.to_owned()], vec![POWER.to_owned()]);
        note(journal, &JournalEntry::Changes { trial: "preflight".to_owned(), what, stand })?;
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
        note(journal, &JournalEntry::Permanence { name: found.name_permanence, ip: found.ip_permanence })?;
        notes.push(format!(
            "a power cycle before the first change showed: station name {}, IP address {}",
            text(found.name_permanence),
            text(found.ip_permanence)
        ));
        let mut changes = vec![change::POWER_CYCLE];
        if found.name_permanence == DcpPermanence::Temporary {
            changes.push(change::NAME);
            // A name that is lost with the power would not last through the run; it is put back as a temporary one at its end.
            let block = DcpBlock::set(BlockQualifier::PERMANENT, DcpValue::NameOfStation(station.name.clone()));
            self.change(controller, journal, station.mac, (change::NAME, block), NOT_PUT_BACK)?;
        }
        if found.ip_permanence == DcpPermanence::Temporary {
            changes.push(change::TEMPORARY_IP);
            if !after.ip.address.is_unspecified() {
                notes.push(format!(
                    "the device had stored the IP address {}, which a temporary one erases",
                    after.ip.address
                ));
            }
            let block = DcpBlock::set(BlockQualifier::TEMPORARY, DcpValue::IpParameter(station.ip));
            self.change(controller, journal, station.mac, (change::TEMPORARY_IP, block), NOT_PUT_BACK)?;
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
}

/// The word for the report.
fn text(permanence: DcpPermanence) -> &'static str {
    match permanence {
        DcpPermanence::Permanent => "permanent",
        DcpPermanence::Temporary => "temporary",
        DcpPermanence::Unknown => "none, so unknown",
    }
}
