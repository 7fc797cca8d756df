//! Start-ups of a slave: from `start` of a suite to the connection request, and from its outcome to replies.

use super::{reply, unexpected};
use crate::record;
use crate::trial::RunningTrial;
use crate::trial::step_error::{StepError, StepResult};
use controllers::profibus_dp::{
    ClearOutputs, IsoModeClock, MasterOutcome, MasterRequest, SlaveConfig, SlaveFailureReason, SlaveStartUpResult,
    StartUpService,
};
use expression::{Program, Value};
use judge::answer::ReceivedReply;
use judge::diagnosis;
use judge::observe::Address;
use results::outcome::FailureCause;
use results::verdict::Verdict;
use station::Duration;
use std::sync::Arc;
use suite::device::{DeviceDescription, DiagnosisName, UserPrmLayout};
use suite::model::{AnswerMatcher, AnswerPart, ConnectionStart, StartDeviation};
use wire::profibus::prm::{Dpv1Status1, Dpv1Status3, Isochronous, PrmBlock, PrmBlockType, SetPrm, StationStatus};

/// T_BASE_DP in microseconds, and in units of 1/12 microsecond as the field has it.
const T_BASE: (u64, u32) = (125, 1_500);
/// The group of the slaves that follow the clock of the bus.
pub const ISOCHRONOUS_GROUP: u8 = 0x80;
/// The watchdog of start-ups that give none, and its two watchdog factors of 10 ms as masters usually set them.
const USUAL_WATCHDOG: (Duration, (u8, u8)) = (Duration::from_secs(1), (20, 5));

impl<'a> RunningTrial<'a> {
    /// Sends parameters and configuration to the slave and starts the data exchange.
    pub(super) fn parameterise(
        &mut self,
        start: &'a ConnectionStart,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
        to: Option<&'a Program>,
    ) -> StepResult {
        let address = self.station_of(to)?;
        let device = &self.world.manual.device;
        let connection = connection(device, start, address, self.patience());
        if !second {
            self.use_module(start.module);
            self.world.scene.follower.station = Some(Address::Fdl(address));
            self.world.cycle = Some(connection.cycle);
        }
        let outcome = self.ask_master(second, MasterRequest::Connect(Box::new(connection)))?;
        let MasterOutcome::StartUp(outcome) = outcome else { return Err(unexpected(&outcome)) };
        if let Some(failed) = &outcome.failed
            && matches!(failed.why, SlaveFailureReason::NoToken(_))
        {
            // The slave received no request, so its silence is not an answer.
            let what = format!("The connection was not established: {failed}.");
            return Err(StepError::other(FailureCause::Environment, Verdict::Inconclusive, what));
        }
        let own = self.environment.line.masters[usize::from(second)];
        self.world.scene.notebook_mut().answers = replies(&self.world.manual.device, &outcome, own);
        let stages = [("Set_Prm", &outcome.set_prm), ("Chk_Cfg", &outcome.chk_cfg)];
        let mut replies = stages.into_iter().filter_map(|(stage, answer)| Some((stage, reply(answer.as_ref()?))));
        let refused = replies.find(|(_, reply)| *reply != ReceivedReply::Accepted);
        let refused = refused.map(|(stage, reply)| format!("{stage} was not accepted: {reply}."));
        let stands = match (outcome.standing, outcome.failed) {
            (true, _) => Ok(refused),
            (false, failed) => Err(failed.map(|failed| failed.to_string())),
        };
        self.started(stands, answer, second)
    }
}

/// The connection request for `start`.
pub(super) fn connection(
    device: &DeviceDescription,
    start: &ConnectionStart,
    address: u8,
    patience: Duration,
) -> SlaveConfig {
    let module = &device.modules[start.module];
    let submodules = module.submodules.iter().filter_map(|&index| device.submodules.get(index));
    let (mut output, mut input) = submodules.fold((0, 0), |(output, input), of| {
        (output + usize::from(of.output_octets), input + usize::from(of.input_octets))
    });
    let mut cfg = module.cfg().to_vec();
    let mut services = StartUpService::USUAL.to_vec();
    for instead in &start.instead {
        match instead {
            StartDeviation::ChkCfg(octets) => cfg.clone_from(octets),
            StartDeviation::OutputLength(octets) => output = usize::from(*octets),
            StartDeviation::InputLength(octets) => input = usize::from(*octets),
            StartDeviation::NoSetPrm => services.retain(|service| *service != StartUpService::SetPrm),
            StartDeviation::NoChkCfg => services.retain(|service| *service != StartUpService::CheckConfiguration),
            _ => {}
        }
    }
    let (octets, fail_safe) = set_prm(device, start);
    let mut connection = SlaveConfig::new(address, octets, cfg, (output, input));
    connection.cycle = start.cycle(device);
    connection.services = services;
    connection.patience = patience;
    connection.clock = start.isochronous.map(|_| IsoModeClock::default());
    connection.clear = if fail_safe { ClearOutputs::Empty } else { ClearOutputs::Zeros };
    connection
}

/// The bytes of Set_Prm, and whether outputs without data mean clear (fail safe).
fn set_prm(device: &DeviceDescription, start: &ConnectionStart) -> (Vec<u8>, bool) {
    let layout = device.profibus().map(|slave| &slave.set_prm);
    let mut dpv1 = layout.and_then(|layout| layout.dpv1);
    let mut status = StationStatus::LOCK_REQ.0;
    let mut factors = (1, 1);
    if !start.unwatched {
        status |= StationStatus::WD_ON.0;
        let (found, base_1_ms) = watchdog(start.watchdog(device), dpv1.is_some());
        factors = found;
        if let Some([first, ..]) = dpv1.as_mut().filter(|_| base_1_ms) {
            *first |= Dpv1Status1::WD_BASE_1MS.0;
        }
    }
    let mut prm = SetPrm {
        status: StationStatus(status),
        wd_fact_1: factors.0,
        wd_fact_2: factors.1,
        min_tsdr: 11,
        ident: device.ident().unwrap_or_default(),
        groups: 0,
        user: Vec::new(),
    };
    if start.isochronous.is_some() {
        prm.groups = ISOCHRONOUS_GROUP;
        if let Some([_, _, third]) = &mut dpv1 {
            *third |= Dpv1Status3::PRM_STRUCTURE | Dpv1Status3::ISOCHRONOUS;
        }
    }
    let mut user = user_octets(device, start);
    for instead in &start.instead {
        match instead {
            StartDeviation::Dpv1(octets) => dpv1 = Some(*octets),
            StartDeviation::Ident(ident) => prm.ident = *ident,
            StartDeviation::Lock { lock, unlock } => {
                let both = StationStatus::LOCK_REQ.0 | StationStatus::UNLOCK_REQ.0;
                let asked = if *lock { StationStatus::LOCK_REQ.0 } else { 0 };
                let asked = asked | if *unlock { StationStatus::UNLOCK_REQ.0 } else { 0 };
                prm.status = StationStatus(prm.status.0 & !both | asked);
            }
            StartDeviation::FreezeRequest => prm.status.0 |= StationStatus::FREEZE_REQ.0,
            StartDeviation::SyncRequest => prm.status.0 |= StationStatus::SYNC_REQ.0,
            StartDeviation::MinTsdr(bits) => prm.min_tsdr = *bits,
            StartDeviation::Groups(groups) => prm.groups = *groups,
            StartDeviation::WatchdogFactors(first, second) => (prm.wd_fact_1, prm.wd_fact_2) = (*first, *second),
            StartDeviation::RecordNone(_) => user.clear(),
            StartDeviation::RecordBytes(_, octets) => user.clone_from(octets),
            _ => {}
        }
    }
    let fail_safe = dpv1.is_some_and(|[first, ..]| Dpv1Status1(first).has(Dpv1Status1::FAIL_SAFE));
    prm.user.extend(dpv1.into_iter().flatten());
    prm.user.extend(user);
    let mut octets = Vec::new();
    for instead in &start.instead {
        match instead {
            StartDeviation::UserOctets(user) => prm.user.clone_from(user),
            StartDeviation::SetPrm(whole) => return (whole.clone(), fail_safe),
            _ => {}
        }
    }
    prm.write(&mut octets);
    (octets, fail_safe)
}

/// The bytes after those of DP-V1: the user bytes, in isochronous mode in a block next to the block of times.
fn user_octets(device: &DeviceDescription, start: &ConnectionStart) -> Vec<u8> {
    let of_record = start.parameters.iter().filter(|of| of.record == UserPrmLayout::RECORD);
    let record = device.records.get(UserPrmLayout::RECORD);
    let fields = record.map(|record| record::octets(record, of_record.map(|of| (of.field, of.value))));
    let mut user = fields.unwrap_or_default();
    let block = |kind, data| PrmBlock { kind, slot: 0, reserved: 0, data };
    if start.isochronous.is_some() && !user.is_empty() {
        let plain = std::mem::take(&mut user);
        block(PrmBlockType::USER_PRM_DATA, plain).write(&mut user);
    }
    if let Some(cycle) = start.isochronous {
        let mut data = Vec::new();
        isochronous_times(cycle).write(&mut data);
        block(PrmBlockType::ISOCHRONOUS, data).write(&mut user);
    }
    user
}

/// The times of isochronous mode for a cycle: T_I is one T_BASE_IO before its end, T_O is half of it.
pub fn isochronous_times(cycle: Duration) -> Isochronous {
    let (micros, base) = T_BASE;
    let t_dp = u16::try_from(cycle.as_micros() / u128::from(micros)).unwrap_or(u16::MAX);
    Isochronous {
        version: 1,
        t_base_dp: base,
        t_dp,
        t_mapc: 1,
        t_base_io: base,
        t_i: 1,
        t_o: (t_dp / 2).max(1),
        t_dx: u32::from(t_dp / 4).max(1) * base,
        t_pll_w: 12,
        t_pll_d: 0,
    }
}

/// The two watchdog factors, and whether their base is 1 ms.
fn watchdog(time: Duration, dpv1: bool) -> ((u8, u8), bool) {
    if time == USUAL_WATCHDOG.0 {
        return (USUAL_WATCHDOG.1, false);
    }
    let millis = u64::try_from(time.as_millis()).unwrap_or(u64::MAX).max(1);
    let fine = dpv1 && !millis.is_multiple_of(10);
    let units = if fine { millis } else { millis.div_ceil(10) };
    let exact = (1..=255).find(|second| units.is_multiple_of(*second) && units / second <= 255);
    let second = exact.unwrap_or_else(|| units.div_ceil(255).min(255));
    let first = units.div_ceil(second).min(255);
    ((first as u8, second as u8), fine)
}

/// The parts of the answer to a start-up; `own` is the address of its master.
fn replies(device: &DeviceDescription, start: &SlaveStartUpResult, own: u8) -> Vec<(AnswerPart, ReceivedReply)> {
    let mut replies = Vec::new();
    let stages = [(AnswerPart::SetPrm, &start.set_prm), (AnswerPart::ChkCfg, &start.chk_cfg)];
    replies.extend(stages.into_iter().filter_map(|(part, said)| Some((part, reply(said.as_ref()?)))));
    let octets = start.diagnosis_after.as_ref().and_then(|answer| answer.data()).filter(|octets| !octets.is_empty());
    if let Some(octets) = octets {
        let fields = device.profibus().map_or(0, |slave| slave.diagnosis.fields.len());
        let names = DiagnosisName::words().map(|(_, name)| name).chain((0..fields).map(DiagnosisName::Field));
        for name in names {
            let value = diagnosis::value(device, name, octets, Some(own));
            if !value.is_unknown() {
                replies.push((AnswerPart::Diagnosis(name), ReceivedReply::Value(value)));
            }
        }
    }
    let word = if start.standing { "data" } else { "none" };
    replies.push((AnswerPart::Connection, ReceivedReply::Value(Value::Text(Arc::from(word)))));
    let refused = [&start.set_prm, &start.chk_cfg].into_iter().flatten().map(reply);
    let whole = match start.standing {
        true => ReceivedReply::Accepted,
        false => refused
            .filter(|reply| *reply != ReceivedReply::Accepted)
            .chain(start.failed.iter().map(|failed| ReceivedReply::Silent(failed.to_string())))
            .next()
            .unwrap_or_else(|| ReceivedReply::Silent("the connection ended".into())),
    };
    replies.push((AnswerPart::Whole, whole));
    replies
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    /// IEC 61158-6-3: the watchdog time is 10 ms, or 1 ms, times both factors.
    #[rstest]
    #[case(1_000, false, (20, 5), false)]
    #[case(100, false, (10, 1), false)]
    #[case(15, false, (2, 1), false)]
    #[case(15, true, (15, 1), true)]
    #[case(10_000, true, (250, 4), false)]
    #[case(650_250, false, (255, 255), false)]
    fn factors_of_a_watchdog(#[case] millis: u64, #[case] dpv1: bool, #[case] factors: (u8, u8), #[case] fine: bool) {
        assert_eq!(watchdog(Duration::from_millis(millis), dpv1), (factors, fine));
    }
}
