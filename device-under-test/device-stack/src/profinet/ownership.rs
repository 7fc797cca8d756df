//! Which connection owns which submodule, and what follows when a submodule becomes free, is pulled or is plugged.
//!
//! A submodule belongs to the first connection that expects it. A later one that expects it as well gets it once the
//! owner has ended its connection: it is informed by an alarm, sends parameters and PrmEnd, and the device answers by
//! ApplicationReady for this submodule. The same sequence follows a plug (IEC 61158-6-10, alarm types Plug and Released).

use super::cm::{CmAnswer, application_ready, cmrpc};
use super::hooks::StackCheck;
use super::plugged::{ExpectedSubmoduleData, SubmoduleAddress};
use super::stack::{Stack, StackEnv};
use crate::profinet::{PlugChange, PluggableSubmodule, RecordAccess};
use alloc::vec::Vec;
use wire::octets::ByteOrder;
use wire::profinet::alarm::{AlarmNotification, AlarmPriority, AlarmSpecifier, AlarmType};
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks};
use wire::profinet::status::{CmrpcError, ErrorCode, PnioStatus};

/// A submodule that was plugged or released during a connection and waits for its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PluggedAfterwards {
    place: SubmoduleAddress,
    /// The sequence number of its alarm, which PrmEnd repeats.
    sequence: u16,
}

fn alarm(alarm_type: AlarmType, plug: &PluggableSubmodule) -> AlarmNotification {
    AlarmNotification {
        priority: AlarmPriority::Low,
        alarm_type,
        api: plug.api,
        slot: plug.slot,
        subslot: plug.subslot,
        module_ident: plug.module_ident,
        submodule_ident: plug.submodule_ident,
        specifier: AlarmSpecifier::new(0, 0),
        items: Vec::new(),
    }
}

impl Stack {
    /// Whether a connection owns the submodule at `place`.
    pub(super) fn is_owned(&self, place: SubmoduleAddress) -> bool {
        let is_owned = self.ars.iter().any(|ar| ar.owns(place));
        self.hooks.check(StackCheck::OwnedByOther(place.slot, place.subslot), is_owned)
    }

    /// Whether connection `at` has cyclic data and another such connection owns the submodule of a record that it
    /// writes. A connection for records only may write everywhere.
    pub(super) fn is_write_of_other(&self, at: usize, access: RecordAccess) -> bool {
        let is_exchange = self.ars[at].exchange.is_some();
        is_exchange
            && self.is_of_other(at, access.into())
            && !self.hooks.check(StackCheck::WritesOfOthers(access), false)
    }

    /// Whether a connection other than `at` owns the submodule at `place`.
    pub(super) fn is_of_other(&self, at: usize, place: SubmoduleAddress) -> bool {
        self.ars.iter().enumerate().any(|(other, ar)| other != at && ar.owns(place))
    }

    /// Gives the submodules of a connection that has ended to the next connection that expects them.
    pub(super) fn hand_over(&mut self, env: &mut StackEnv<'_>, freed: &[ExpectedSubmoduleData]) {
        for place in freed.iter().map(|submodule| submodule.place) {
            let Stack { ars, plugged, hooks, .. } = self;
            let waiting = ars.iter_mut().find_map(|ar| {
                let submodule = ar.expected.iter().copied().find(|submodule| submodule.place == place)?;
                (ar.exchange.is_some() && !ar.owns(place)).then_some((ar, submodule))
            });
            let Some((ar, submodule)) = waiting else { continue };
            let Some(plug) = plugged.fitting(&submodule) else { continue };
            ar.owned.push(submodule);
            match &mut ar.exchange {
                Some(exchange) if ar.phase.has_alarms() => {
                    let sequence = exchange.alarms.push(alarm(AlarmType::RELEASED, &plug));
                    ar.plugs.push(PluggedAfterwards { place, sequence });
                    if !hooks.check(StackCheck::PlugAwaitsParameters, true) {
                        ar.set_usable(env.now, place, true, env.application);
                    }
                }
                // The parameters of the start-up are still to come.
                _ => ar.set_usable(env.now, place, true, env.application),
            }
        }
    }

    /// A submodule was pulled or plugged: its data become bad, and its owner is informed.
    pub(super) fn change_plug(&mut self, env: &mut StackEnv<'_>, change: PlugChange) {
        let (plug, alarm_type) = match change {
            PlugChange::Pulled(plug) => {
                let real = self.plugged.at((&plug).into()).copied();
                self.plugged.pull((&plug).into());
                (real.unwrap_or(plug), AlarmType::PULL)
            }
            PlugChange::Plugged(plug) => match self.plugged.plug(plug, &self.hooks) {
                (plug, true) => (plug, AlarmType::PLUG),
                (plug, false) => (plug, AlarmType::PLUG_WRONG),
            },
        };
        let place = SubmoduleAddress::from(&plug);
        let Stack { ars, plugged, hooks, .. } = self;
        for ar in ars.iter_mut().filter(|ar| ar.owns(place)) {
            ar.differs = plugged.differs(&ar.expected);
            ar.plugs.retain(|waiting| waiting.place != place);
            let is_plug = alarm_type == AlarmType::PLUG;
            let is_usable = is_plug && !hooks.check(StackCheck::PlugAwaitsParameters, true);
            ar.set_usable(env.now, place, is_usable, env.application);
            if let Some(exchange) = ar.exchange.as_mut().filter(|_| ar.phase.has_alarms()) {
                let sequence = exchange.alarms.push(alarm(alarm_type, &plug));
                if is_plug {
                    ar.plugs.push(PluggedAfterwards { place, sequence });
                }
            }
        }
    }

    /// An event in the process: reports it to the owner of the submodule, with high priority.
    pub(super) fn report_event(&mut self, slot: u16, subslot: u16) {
        let is_there = |plug: &&PluggableSubmodule| (plug.slot, plug.subslot) == (slot, subslot);
        let Some(plug) = self.plugged.all().iter().find(is_there) else { return };
        for ar in self.ars.iter_mut().filter(|ar| ar.owns(plug.into()) && ar.phase.has_alarms()) {
            if let Some(exchange) = &mut ar.exchange {
                exchange
                    .alarms
                    .push(AlarmNotification { priority: AlarmPriority::High, ..alarm(AlarmType::PROCESS, plug) });
            }
        }
    }

    /// PrmEnd for a submodule that was plugged or released: it is ready from now on.
    pub(super) fn end_plug_parameters(
        &mut self,
        env: &mut StackEnv<'_>,
        at: usize,
        block: &ControlBlock,
    ) -> Result<CmAnswer, PnioStatus> {
        let ar = &mut self.ars[at];
        let waiting = ar.plugs.iter().position(|plug| plug.sequence == block.alarm_sequence_number);
        let Some(waiting) = waiting else {
            return Err(cmrpc(ErrorCode::CONTROL_RESPONSE, CmrpcError::STATE_CONFLICT));
        };
        let PluggedAfterwards { place, sequence } = ar.plugs.remove(waiting);
        if self.hooks.check(StackCheck::PlugBecomesReady, true) {
            ar.set_usable(env.now, place, true, env.application);
            ar.ready_plugs.push(sequence);
        }
        Ok(CmAnswer::done(ControlBlocks::from(block.done()).to_vec()))
    }

    /// Sends ApplicationReady for plugged submodules, one call at a time.
    pub(super) fn announce_ready_plugs(&mut self, env: &mut StackEnv<'_>) {
        for at in 0..self.ars.len() {
            let ar = &mut self.ars[at];
            if ar.call.is_some() || ar.ready_plugs.is_empty() {
                continue;
            }
            let alarm = self.hooks.apply(Some(ar.ready_plugs.remove(0)), |hooks, alarm| hooks.plug_ready(alarm));
            if alarm.is_some() {
                let order = self.hooks.byte_order(ByteOrder::Big);
                ar.call = Some(application_ready(env.now, self.retained.mac, ar, alarm, order));
            }
        }
    }
}
