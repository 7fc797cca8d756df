//! DCP Set: name, addresses, Signal, resets and transactions.
//!
//! A name or address that differs from the one in use ends all connections. Setting the same value again has no
//! effect.

use super::super::fast_start_up::FastStartUp;
use super::super::hooks::StackCheck;
use super::super::maintenance::ImTexts;
use super::super::stack::{Stack, StackEnv};
use super::{DcpState, DcpTransaction, WriteDcpFrame, outcome, values};
use crate::profinet::{ResetScope, StationData};
use core::net::Ipv4Addr;
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockError, Dcp, DcpBlock, DcpValue, Element, ResetMode};
use wire::profinet::status::AbortReason;

impl Stack {
    /// Carries out a Set and answers it. A reset happens after the answer.
    pub(super) fn set(&mut self, env: &mut StackEnv<'_>, source: Mac, request: &Dcp) {
        let mut blocks = alloc::vec::Vec::new();
        let mut has_reset = false;
        for block in request.blocks() {
            let result = match &block.value {
                DcpValue::NameOfStation(name) => self.set_name(env, source, name, block),
                DcpValue::IpParameter(ip) => self.set_address(env, source, ip, block),
                DcpValue::Signal(value) => self.signal(env, *value),
                DcpValue::Start => self.begin(env, source),
                DcpValue::Stop => self.commit(env, source),
                DcpValue::FactoryReset => self.reset(env, ResetScope::Factory, &mut has_reset),
                DcpValue::ResetToFactory => {
                    self.reset(env, reset_scope(block.qualifier().reset_mode()), &mut has_reset)
                }
                DcpValue::Raw { element: Element::NAME_OF_STATION | Element::IP_PARAMETER, .. } => {
                    Err(BlockError::SUBOPTION_NOT_SET)
                }
                other => Err(match values::unsupported_error(other.element()) {
                    BlockError::OPTION_NOT_SUPPORTED => BlockError::OPTION_NOT_SUPPORTED,
                    _ => BlockError::SUBOPTION_NOT_SUPPORTED,
                }),
            };
            blocks.push(outcome(block.value.element(), result));
        }
        request.response(blocks).write_frame_to(source, self.retained.mac, env);
        self.abort_all_if(env, AbortReason::RESET_TO_FACTORY, has_reset);
        if has_reset {
            self.dcp.transaction = None;
            self.restart_station(env);
        }
    }

    /// Starts the flashing of the LED.
    fn signal(&mut self, env: &StackEnv<'_>, value: u16) -> Result<(), BlockError> {
        if !self.hooks.check(StackCheck::Signal(value), value == DcpValue::FLASH_ONCE) {
            return Err(BlockError::SUBOPTION_NOT_SET);
        }
        self.dcp.signals_until = Some(env.now + DcpState::SIGNAL);
        Ok(())
    }

    /// Aborts all connections with `reason` if `ends` is set.
    fn abort_all_if(&mut self, env: &mut StackEnv<'_>, reason: AbortReason, ends: bool) {
        if self.hooks.check(StackCheck::Ends(reason), ends) {
            self.abort_all(env, reason);
        }
    }

    fn set_name(
        &mut self,
        env: &mut StackEnv<'_>,
        source: Mac,
        name: &[u8],
        block: &DcpBlock,
    ) -> Result<(), BlockError> {
        if !self.hooks.check(StackCheck::Name(name), env.application.accepts_name(name)) {
            return Err(BlockError::SUBOPTION_NOT_SET);
        }
        self.change(
            env,
            source,
            block,
            |station, name_only| {
                station.name = name_only.name.clone();
            },
            &StationData { name: name.to_vec(), ..StationData::default() },
        )
    }

    fn set_address(
        &mut self,
        env: &mut StackEnv<'_>,
        source: Mac,
        ip: &IpParameter,
        block: &DcpBlock,
    ) -> Result<(), BlockError> {
        if !self.hooks.check(StackCheck::Address(*ip), is_usable(ip)) {
            return Err(BlockError::SUBOPTION_NOT_SET);
        }
        let requested = StationData {
            ip: ip.address.octets(),
            mask: ip.mask.octets(),
            gateway: ip.gateway.octets(),
            ..StationData::default()
        };
        self.change(
            env,
            source,
            block,
            |station, requested| {
                (station.ip, station.mask, station.gateway) = (requested.ip, requested.mask, requested.gateway);
            },
            &requested,
        )
    }

    /// Changes the name or the addresses. `assign` copies them from its second argument: `requested`, or a blank
    /// station for the stored data of a temporary Set.
    fn change(
        &mut self,
        env: &mut StackEnv<'_>,
        source: Mac,
        block: &DcpBlock,
        assign: impl Fn(&mut StationData, &StationData),
        requested: &StationData,
    ) -> Result<(), BlockError> {
        let stores = block.qualifier().is_permanent();
        let blank = StationData::default();
        let retained = if stores { requested } else { &blank };
        let owner = self.dcp.transaction.as_ref().map(|transaction| transaction.owner);
        if owner.is_some_and(|owner| !self.hooks.check(StackCheck::TransactionOwner, owner == source)) {
            return Err(BlockError::RESOURCE_ERROR);
        }
        match &mut self.dcp.transaction {
            Some(transaction) => {
                assign(&mut transaction.station, requested);
                assign(&mut transaction.stored, retained);
            }
            None => {
                let (mut station, mut stored) = (self.station.clone(), self.stored.clone());
                assign(&mut station, requested);
                assign(&mut stored, retained);
                self.apply_station(env, station, stored);
            }
        }
        Ok(())
    }

    fn begin(&mut self, env: &mut StackEnv<'_>, owner: Mac) -> Result<(), BlockError> {
        if self.dcp.transaction.as_ref().is_some_and(|transaction| transaction.owner != owner) {
            return Err(BlockError::RESOURCE_ERROR);
        }
        let expires = Some(env.now + DcpState::TRANSACTION);
        let expires = expires.filter(|_| self.hooks.check(StackCheck::TransactionEnds, true));
        let (station, stored) = (self.station.clone(), self.stored.clone());
        self.dcp.transaction = Some(DcpTransaction { owner, expires, station, stored });
        Ok(())
    }

    fn commit(&mut self, env: &mut StackEnv<'_>, owner: Mac) -> Result<(), BlockError> {
        match self.dcp.transaction.take() {
            Some(transaction) if transaction.owner == owner => {
                self.apply_station(env, transaction.station, transaction.stored);
                Ok(())
            }
            other => {
                self.dcp.transaction = other;
                Err(BlockError::SUBOPTION_NOT_SET)
            }
        }
    }

    /// Starts to use `station` and lets the application store `stored`.
    fn apply_station(&mut self, env: &mut StackEnv<'_>, mut station: StationData, mut stored: StationData) {
        self.hooks.notify(|hooks| hooks.set_station(&self.station, &mut station, &mut stored));
        self.abort_all_if(env, AbortReason::STATION_NAME_CHANGED, station.name != self.station.name);
        let addresses = |of: &StationData| (of.ip, of.mask, of.gateway);
        self.abort_all_if(env, AbortReason::IP_SUITE_CHANGED, addresses(&station) != addresses(&self.station));
        env.application.set_station(env.now, &station, &stored);
        self.stored = stored;
        self.use_station(env.now, station);
    }

    fn reset(&mut self, env: &mut StackEnv<'_>, scope: ResetScope, has_reset: &mut bool) -> Result<(), BlockError> {
        if !env.application.factory_reset(env.now, scope) {
            return Err(BlockError::SUBOPTION_NOT_SET);
        }
        match scope {
            ResetScope::Factory
            | ResetScope::ApplicationData
            | ResetScope::AllData
            | ResetScope::Device
            | ResetScope::FactoryImage => self.retained.texts = ImTexts::default(),
            ResetScope::Communication | ResetScope::Engineering | ResetScope::Other(_) => {}
        }
        let is_kept = matches!(scope, ResetScope::ApplicationData | ResetScope::Engineering | ResetScope::Other(_));
        if self.hooks.check(StackCheck::ResetsFastStartUp, !is_kept) {
            self.retained.fast_start_up = FastStartUp::default();
        }
        *has_reset = true;
        Ok(())
    }
}

fn reset_scope(mode: ResetMode) -> ResetScope {
    match mode {
        ResetMode::APPLICATION => ResetScope::ApplicationData,
        ResetMode::COMMUNICATION => ResetScope::Communication,
        ResetMode::ENGINEERING => ResetScope::Engineering,
        ResetMode::ALL => ResetScope::AllData,
        ResetMode::DEVICE => ResetScope::Device,
        ResetMode::FACTORY_IMAGE => ResetScope::FactoryImage,
        ResetMode(other) => ResetScope::Other(other),
    }
}

/// Whether a station can use these addresses: all 0, or a host address with a contiguous mask and a gateway of the
/// same subnet or none.
fn is_usable(ip: &IpParameter) -> bool {
    if *ip == IpParameter::NONE {
        return true;
    }
    let (address, mask, gateway) = (u32::from(ip.address), u32::from(ip.mask), u32::from(ip.gateway));
    let is_host = |address: u32| address & !mask != 0 && address & !mask != !mask;
    let is_unicast = |address: Ipv4Addr| {
        !(address.is_multicast() || address.is_loopback() || address.is_broadcast() || address.octets()[0] == 0)
            && address.octets()[0] < 240
    };
    let mask_holds = mask.leading_ones() == mask.count_ones() && (1..=30).contains(&mask.count_ones());
    let gateway_holds = gateway == 0 || (gateway & mask == address & mask && is_host(gateway));
    is_unicast(ip.address) && mask_holds && is_host(address) && gateway_holds
}
