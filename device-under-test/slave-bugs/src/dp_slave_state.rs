//! Deviations of the generic DP slave that have state.

use super::slave_state::change_diagnosis;
use crate::seams::slave::{frame, request, with_data};
use alloc::vec;
use alloc::vec::Vec;
use core::ops::RangeInclusive;
use device_stack::profibus::{SlaveApplication, SlaveHooks, SlaveStackCheck};
use station::{StandAction, Time};
use wire::profibus::diag::{Status1, Status2};
use wire::profibus::fdl::{DataFrame, Extension, FdlFrame, FrameCount, FunctionCode, RequestFunction};
use wire::profibus::prm::{SetPrm, StationStatus};
use wire::profibus::sap::{MasterSap, SapService, SlaveSap};

const SET_PRM: SapService = SapService::Slave(SlaveSap::SET_PRM);
const SET_ADDRESS: SapService = SapService::Slave(SlaveSap::SET_SLAVE_ADDRESS);
/// A short acknowledgement: whatever is received discards an answer that has not been sent.
const DISCARDS_ANSWER: [u8; 1] = [0xE5];

/// The connection of the slave, as its telegrams show it.
#[derive(Default)]
pub struct ObservedSession {
    /// The last Set_Prm that locked the slave.
    locked_by: Option<Vec<u8>>,
    /// Whether inputs were sent since then.
    pub exchanges: bool,
}

impl ObservedSession {
    /// The master that has locked the slave.
    pub fn owner(&self) -> Option<u8> {
        self.locked_by.as_deref().and_then(frame).map(|frame| frame.sa)
    }

    fn observe(&mut self, telegram: &[u8], ident: u16) {
        let Some((frame, SET_PRM)) = request(telegram) else { return };
        let Ok(parameters) = SetPrm::parse(frame.data) else { return };
        if self.owner().is_some_and(|owner| owner != frame.sa) || parameters.ident != ident {
            return;
        }
        self.exchanges = false;
        let is_locked =
            parameters.status.has(StationStatus::LOCK_REQ) && !parameters.status.has(StationStatus::UNLOCK_REQ);
        self.locked_by = is_locked.then(|| telegram.to_vec());
    }

    /// A Set_Prm of the owner with another station status, without a frame count bit.
    fn parameters(&self, status: StationStatus) -> Option<Vec<u8>> {
        let frame = self.locked_by.as_deref().and_then(frame)?;
        let parameters = SetPrm { status, min_tsdr: 0, ..SetPrm::parse(frame.data).ok()? };
        let mut data = Vec::new();
        parameters.write(&mut data);
        Some(uncounted(&frame, &data))
    }

    /// A Set_Prm of the owner that unlocks the slave.
    pub fn unlock(&self) -> Option<Vec<u8>> {
        self.parameters(StationStatus::UNLOCK_REQ)
    }

    /// A Set_Prm of the owner that changes nothing and is acknowledged.
    pub fn nothing(&self) -> Option<Vec<u8>> {
        self.parameters(StationStatus(0))
    }
}

/// A request like `frame` with other data, without a frame count bit.
fn uncounted(frame: &DataFrame<'_>, data: &[u8]) -> Vec<u8> {
    let function = frame.fc.requested().unwrap_or(RequestFunction::SRD_HIGH);
    with_data(&DataFrame { fc: FunctionCode::request(function, FrameCount::Unused), ..*frame }, data)
}

/// A request to another access point of the slave.
pub fn to_access_point(frame: &DataFrame<'_>, point: u8) -> Vec<u8> {
    with_data(&DataFrame { destination: Extension::sap(point), ..*frame }, frame.data)
}

/// The same request as if the owner of the slave had sent it.
pub fn of_owner(session: &ObservedSession, frame: &DataFrame<'_>) -> Vec<u8> {
    uncounted(&DataFrame { sa: session.owner().unwrap_or(frame.sa), ..*frame }, frame.data)
}

/// A request without data of the owner to an access point.
pub fn asked_by_owner(session: &ObservedSession, own: u8, point: SlaveSap) -> Option<Vec<u8>> {
    let frame = session.locked_by.as_deref().and_then(frame)?;
    Some(uncounted(&DataFrame { da: own, destination: Extension::sap(point.0), ..frame }, &[]))
}

/// Replaces requests by others, depending on the connection of the slave; `None` leaves a request as it is.
pub struct Replaced<F> {
    session: ObservedSession,
    replace: F,
}

impl<F> Replaced<F>
where
    F: FnMut(&ObservedSession, &DataFrame<'_>, SapService) -> Option<Vec<Vec<u8>>>,
{
    /// A deviation that replaces requests.
    pub fn new(replace: F) -> Replaced<F> {
        Replaced { session: ObservedSession::default(), replace }
    }
}

impl<F> SlaveHooks for Replaced<F>
where
    F: FnMut(&ObservedSession, &DataFrame<'_>, SapService) -> Option<Vec<Vec<u8>>>,
{
    fn received_telegrams(&mut self, encoder: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let replaced = request(telegram).and_then(|(frame, service)| (self.replace)(&self.session, &frame, service));
        let received = replaced.unwrap_or_else(|| vec![telegram.to_vec()]);
        received.iter().for_each(|telegram| self.session.observe(telegram, encoder.identity().ident));
        received
    }

    fn inputs(&mut self, _: Time, _: &mut [u8]) {
        self.session.exchanges = true;
    }

    fn starts(&mut self) {
        self.session = ObservedSession::default();
    }
}

/// Leaves data exchange at the telegrams for which a condition holds.
pub struct LeavesExchange<F> {
    session: ObservedSession,
    leaves: F,
}

impl<F: FnMut(&[u8]) -> bool> LeavesExchange<F> {
    /// A deviation that leaves data exchange at these telegrams.
    pub fn at(leaves: F) -> LeavesExchange<F> {
        LeavesExchange { session: ObservedSession::default(), leaves }
    }
}

impl<F: FnMut(&[u8]) -> bool> SlaveHooks for LeavesExchange<F> {
    fn received_telegrams(&mut self, encoder: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        self.session.observe(telegram, encoder.identity().ident);
        let is_left = self.session.exchanges && (self.leaves)(telegram);
        let Some(unlock) = self.session.unlock().filter(|_| is_left) else { return vec![telegram.to_vec()] };
        self.session.observe(&unlock, encoder.identity().ident);
        match request(telegram) {
            Some((frame, _)) if frame.fc.requested().is_some_and(RequestFunction::expects_response) => {
                vec![unlock, telegram.to_vec()]
            }
            _ => vec![telegram.to_vec(), unlock, DISCARDS_ANSWER.to_vec()],
        }
    }

    fn inputs(&mut self, _: Time, _: &mut [u8]) {
        self.session.exchanges = true;
    }

    fn starts(&mut self) {
        self.session = ObservedSession::default();
    }
}

/// Accepts a damaged frame as if it were the one that `repair` makes of it.
pub struct Repaired(pub fn(&mut Vec<u8>));

impl SlaveHooks for Repaired {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if FdlFrame::parse(telegram).is_ok() {
            return vec![telegram.to_vec()];
        }
        let mut repaired = telegram.to_vec();
        (self.0)(&mut repaired);
        vec![repaired]
    }
}

/// Completes a frame of variable length that ends too early to a request for the diagnosis.
pub fn completed(telegram: &mut Vec<u8>) {
    let [0x68, first, ..] = *telegram.as_slice() else { return };
    if telegram.len() >= usize::from(first) + 6 || telegram.len() < 7 {
        return;
    }
    let head = [0x68, 5, 5, 0x68, telegram[4], telegram[5], telegram[6], SlaveSap::SLAVE_DIAG.0, MasterSap::MS0.0];
    let sum = head[4..].iter().fold(0u8, |sum, octet| sum.wrapping_add(*octet));
    *telegram = [&head[..], &[sum, 0x16]].concat();
}

/// Answers requests at access points without a service as if they were for the diagnosis.
#[derive(Default)]
pub struct AnyAccessPoint {
    asked: Option<u8>,
}

impl SlaveHooks for AnyAccessPoint {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let of_ms0 = request(telegram).filter(|(frame, _)| frame.source.sap == Some(MasterSap::MS0.0));
        let point = of_ms0.as_ref().and_then(|(frame, _)| frame.destination.sap);
        self.asked = point.filter(|point| *point < 49 || *point == 52);
        match (of_ms0, self.asked) {
            (Some((frame, _)), Some(_)) => vec![to_access_point(&frame, SlaveSap::SLAVE_DIAG.0)],
            _ => vec![telegram.to_vec()],
        }
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if let (Some(frame), Some(asked)) = (frame(telegram), self.asked) {
            *telegram = with_data(&DataFrame { source: Extension::sap(asked), ..frame }, frame.data);
        }
    }
}

/// Does not answer Data_Exchange at these rates.
pub struct NoExchangeAt {
    rates: RangeInclusive<u32>,
    is_at: bool,
}

impl NoExchangeAt {
    /// Does not exchange data at rates of this range in bit/s.
    pub fn new(rates: RangeInclusive<u32>) -> NoExchangeAt {
        NoExchangeAt { rates, is_at: false }
    }
}

impl SlaveHooks for NoExchangeAt {
    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        if let SlaveStackCheck::Rate(rate) = check {
            self.is_at = self.rates.contains(&rate);
        }
        verdict
    }

    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let exchange = request(telegram).filter(|(_, service)| *service == SapService::DataExchange);
        if self.is_at && exchange.is_some() { Vec::new() } else { vec![telegram.to_vec()] }
    }
}

/// Answers no poll that follows another one in less than 2 ms.
#[derive(Default)]
pub struct SlowPolls {
    last: Option<Time>,
    /// How many polls were less than 2 ms apart.
    fast: u32,
    is_poll: bool,
    is_missed: bool,
}

impl SlaveHooks for SlowPolls {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        self.is_poll = request(telegram).is_some_and(|(_, service)| service == SapService::DataExchange);
        vec![telegram.to_vec()]
    }

    fn inputs(&mut self, now: Time, _: &mut [u8]) {
        if self.is_poll {
            let is_fast = self.last.is_some_and(|last| now.since(last) < core::time::Duration::from_millis(2));
            self.fast += u32::from(is_fast);
            self.is_missed = is_fast && self.fast > 500;
            self.last = Some(now);
        }
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if self.is_poll && self.is_missed {
            telegram.clear();
        }
    }
}

/// Serves only the first master that sends parameters.
#[derive(Default)]
pub struct FirstMasterOnly(Option<u8>);

impl SlaveHooks for FirstMasterOnly {
    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        match check {
            SlaveStackCheck::Master(master) => verdict && *self.0.get_or_insert(master) == master,
            _ => verdict,
        }
    }
}

/// Counts the watchdog in 10 ms, whatever its base.
#[derive(Default)]
pub struct InCentiseconds {
    base: u32,
}

impl SlaveHooks for InCentiseconds {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((frame, SET_PRM)) = request(telegram)
            && let Ok(parameters) = SetPrm::parse(frame.data)
        {
            self.base = parameters.dpv1().unwrap_or_default().watchdog_base_ms();
        }
        vec![telegram.to_vec()]
    }

    fn watchdog(&mut self, right: core::time::Duration) -> core::time::Duration {
        if self.base == 1 { right * 10 } else { right }
    }
}

/// Keeps outputs of a former connection while the new ones are 0.
#[derive(Default)]
pub struct OutputsOfBefore {
    last: Vec<u8>,
    kept: Vec<u8>,
}

impl SlaveHooks for OutputsOfBefore {
    fn outputs(&mut self, outputs: &mut Option<Vec<u8>>) {
        match outputs {
            None => self.kept = core::mem::take(&mut self.last),
            Some(octets) if octets.iter().all(|octet| *octet == 0) && octets.len() == self.kept.len() => {
                octets.clone_from(&self.kept);
            }
            Some(octets) => self.last.clone_from(octets),
        }
    }

    fn starts(&mut self) {
        *self = OutputsOfBefore::default();
    }
}

/// Keeps the outputs at a Data_Exchange without data.
#[derive(Default)]
pub struct OutputsWithoutData {
    last: Vec<u8>,
    has_none: bool,
}

impl SlaveHooks for OutputsWithoutData {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let exchange = request(telegram).filter(|(_, service)| *service == SapService::DataExchange);
        self.has_none = exchange.is_some_and(|(frame, _)| frame.data.is_empty());
        vec![telegram.to_vec()]
    }

    fn outputs(&mut self, outputs: &mut Option<Vec<u8>>) {
        match outputs {
            None if self.has_none => *outputs = Some(self.last.clone()),
            None => self.last.clear(),
            Some(octets) => self.last.clone_from(octets),
        }
    }
}

/// Takes Data_Exchange of any master as that of its own.
#[derive(Default)]
pub struct ExchangeWithAnybody {
    session: ObservedSession,
    /// The other master, which gets the answer.
    asking: Option<u8>,
}

impl SlaveHooks for ExchangeWithAnybody {
    fn received_telegrams(&mut self, encoder: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        self.session.observe(telegram, encoder.identity().ident);
        let exchange = request(telegram).filter(|(_, service)| *service == SapService::DataExchange);
        let foreign = exchange.filter(|(frame, _)| self.session.owner().is_some_and(|owner| owner != frame.sa));
        self.asking = foreign.as_ref().map(|(frame, _)| frame.sa);
        match foreign {
            Some((frame, _)) => vec![of_owner(&self.session, &frame)],
            None => vec![telegram.to_vec()],
        }
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if let (Some(frame), Some(asking)) = (frame(telegram), self.asking) {
            *telegram = with_data(&DataFrame { da: asking, ..frame }, frame.data);
        }
    }
}

/// Carries out the last command of a kind again after each start-up.
pub struct CommandOfBefore {
    /// Whether a command begins the mode (`true`), ends it, or does neither.
    begins: fn(&[u8]) -> Option<bool>,
    command: Option<Vec<u8>>,
    is_new: bool,
}

impl CommandOfBefore {
    /// Repeats the command that began a mode.
    pub fn new(begins: fn(&[u8]) -> Option<bool>) -> CommandOfBefore {
        CommandOfBefore { begins, command: None, is_new: false }
    }
}

impl SlaveHooks for CommandOfBefore {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        match request(telegram) {
            Some((frame, SapService::Slave(SlaveSap::GLOBAL_CONTROL))) => match (self.begins)(frame.data) {
                Some(true) => self.command = Some(telegram.to_vec()),
                Some(false) => self.command = None,
                None => {}
            },
            Some((_, SapService::Slave(SlaveSap::CHK_CFG))) => self.is_new = true,
            Some((_, SapService::DataExchange)) if core::mem::take(&mut self.is_new) => {
                return self.command.iter().cloned().chain([telegram.to_vec()]).collect();
            }
            _ => {}
        }
        vec![telegram.to_vec()]
    }
}

/// Hides the faults that were there before data exchange.
#[derive(Default)]
pub struct ForgottenFaults {
    exchanges: bool,
    is_forgotten: bool,
}

impl SlaveHooks for ForgottenFaults {
    fn act(&mut self, action: &StandAction<'_>) {
        if let StandAction::Fault(_, is_present) = action {
            self.is_forgotten = *is_present && !self.exchanges;
        }
    }

    fn inputs(&mut self, _: Time, _: &mut [u8]) {
        self.exchanges = true;
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if self.is_forgotten {
            change_diagnosis(telegram, |diag| {
                diag.ext.clear();
                diag.status_1.0 &= !Status1::EXT_DIAG.0;
            });
        }
    }
}

/// Sets a bit of the diagnosis once data are exchanged.
#[derive(Default)]
pub struct NeedsParametersInExchange {
    exchanges: bool,
}

impl SlaveHooks for NeedsParametersInExchange {
    fn inputs(&mut self, _: Time, _: &mut [u8]) {
        self.exchanges = true;
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if self.exchanges {
            change_diagnosis(telegram, |diag| diag.status_2 = diag.status_2.with(Status2::PRM_REQ));
        }
    }
}

/// Answers at an address that it had before.
pub struct FormerAddress {
    /// Whether it does so at once, or only after a loss of power and then at this one alone.
    is_at_once: bool,
    former: Option<u8>,
    is_new: bool,
    asked: Option<u8>,
}

impl FormerAddress {
    /// Answers at both addresses.
    pub fn beside() -> FormerAddress {
        FormerAddress { is_at_once: true, former: None, is_new: false, asked: None }
    }

    /// Answers at the former address after a loss of power.
    pub fn after_power_off() -> FormerAddress {
        FormerAddress { is_at_once: false, ..FormerAddress::beside() }
    }
}

impl SlaveHooks for FormerAddress {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        self.asked = None;
        if let Some((frame, SET_ADDRESS)) = request(telegram) {
            self.former = Some(frame.da);
        }
        vec![telegram.to_vec()]
    }

    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        let (SlaveStackCheck::Address(asked), Some(former)) = (check, self.former) else { return verdict };
        let is_former = asked == former;
        let answers = if self.is_at_once {
            verdict || is_former
        } else if self.is_new {
            is_former
        } else {
            verdict
        };
        self.asked = Some(asked).filter(|_| answers && is_former);
        answers
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if let (Some(frame), Some(asked)) = (frame(telegram), self.asked) {
            *telegram = with_data(&DataFrame { sa: asked, ..frame }, frame.data);
        }
    }

    fn starts(&mut self) {
        self.is_new = true;
    }
}

/// Forgets at each start that its address must not change.
#[derive(Default)]
pub struct LockUntilPowerOff {
    has_restarted: bool,
}

impl SlaveHooks for LockUntilPowerOff {
    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        verdict || self.has_restarted && check == SlaveStackCheck::AddressService
    }

    fn starts(&mut self) {
        self.has_restarted = true;
    }
}

/// Takes each call of identification data for that of I&M0.
#[derive(Default)]
pub struct AnyIdentification {
    asked: Option<[u8; 2]>,
}

impl SlaveHooks for AnyIdentification {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((frame, SapService::Slave(SlaveSap::SERVER))) = request(telegram)
            && let [0x5F, _, 0xFF, 4, 0x08, _, high, low] = *frame.data
        {
            self.asked = Some([high, low]);
            let mut data = frame.data.to_vec();
            data[6..].copy_from_slice(&[0xFD, 0xE8]);
            return vec![with_data(&frame, &data)];
        }
        vec![telegram.to_vec()]
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        let Some(frame) = frame(telegram) else { return };
        if let ([0x5E, _, 0xFF, _, 0x08, _, _, _, ..], Some(asked)) = (frame.data, self.asked) {
            let mut data = frame.data.to_vec();
            data[6..8].copy_from_slice(&asked);
            *telegram = with_data(&frame, &data);
        }
    }
}

/// Keeps a connection of a class 2 master until it is aborted.
#[derive(Default)]
pub struct ConnectionWithoutEnd {
    master: Option<u8>,
}

impl SlaveHooks for ConnectionWithoutEnd {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        match request(telegram) {
            Some((frame, SapService::Slave(SlaveSap::RESOURCE_MANAGER))) if !frame.data.is_empty() => {
                if self.master.is_some_and(|master| master != frame.sa) {
                    return vec![to_access_point(&frame, 52)];
                }
                self.master = Some(frame.sa);
            }
            Some((frame, SapService::Connection(_))) if frame.data.first() == Some(&0x58) => self.master = None,
            _ => {}
        }
        vec![telegram.to_vec()]
    }
}

/// Gives the only connection of class 2 masters to the next master that asks.
#[derive(Default)]
pub struct ConnectionTakenOver {
    open: Option<Vec<u8>>,
}

impl SlaveHooks for ConnectionTakenOver {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let Some((frame, SapService::Slave(SlaveSap::RESOURCE_MANAGER))) = request(telegram) else {
            return vec![telegram.to_vec()];
        };
        if frame.data.is_empty() {
            return vec![telegram.to_vec()];
        }
        let abort = |of: &[u8]| {
            let open = crate::seams::slave::frame(of)?;
            Some(uncounted(&DataFrame { destination: Extension::sap(0), ..open }, &[0x58, 0, 0x20]))
        };
        let taken = self.open.as_deref().and_then(abort);
        self.open = Some(telegram.to_vec());
        taken.into_iter().chain([telegram.to_vec()]).collect()
    }
}
