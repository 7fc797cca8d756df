//! Start and end of PROFIBUS connections: parameters, configuration, diagnosis.

use super::super::tracker::Sink;
use super::super::{
    Address, ArId, ArStage, DiagnosisFrame, Dp, Leaving, Observation, ObservedAr, Party, PollFault, SlaveStartData,
};
use super::{DpAnswer, DpTracker, MOST_CONNECTIONS, PendingDpRequest, watchdog_base_ms};
use station::Duration;
use wire::profibus::cfg::{Identifier, io_lengths};
use wire::profibus::diag::{NO_MASTER, SlaveDiag, Status1, Status2};
use wire::profibus::prm::{SetPrm, StationStatus};

impl DpTracker {
    /// Adds a connection that was established before the trace began; false if there are too many.
    pub(super) fn add_established_slave(&mut self, asked: &PendingDpRequest) -> bool {
        self.add(asked.da, between(asked))
    }

    fn add(&mut self, station: u8, ar: ObservedAr) -> bool {
        let slave = &mut self.slaves[usize::from(station)];
        slave.ar = None;
        let index = match self.unused.pop() {
            Some(index) => {
                self.ars[index as usize] = ar;
                index
            }
            None if self.ars.len() >= MOST_CONNECTIONS => return false,
            None => {
                self.ars.push(ar);
                self.ars.len() as u32 - 1
            }
        };
        slave.ar = Some(index);
        slave.lengths = None;
        slave.unanswered = 0;
        slave.gap = Duration::ZERO;
        true
    }

    pub(super) fn parameters(&mut self, asked: &PendingDpRequest, sink: Sink<'_>) {
        let Ok(prm) = SetPrm::parse(&asked.data) else { return };
        let owner = self.master_of(asked.da);
        let ready = self.slaves[usize::from(asked.da)].ar.and_then(|ar| self.ars.get(ar as usize));
        let stands = ready.is_some_and(|ar| ar.stage == ArStage::Ready);
        let (master, station) = (asked.sa, asked.da);
        let event = Dp::Parameters { master, station, octets: &asked.data };
        sink(&self.ars, Observation::Dp { ar: None, event });
        if prm.status.has(StationStatus::UNLOCK_REQ) {
            self.end(station, ArStage::Released, |ar| Observation::Released { ar }, sink);
        } else if prm.status.has(StationStatus::LOCK_REQ) && (!stands || owner == Some(master)) {
            self.end(station, ArStage::Released, |ar| Observation::Released { ar }, sink);
            let mut ar = requested_ar(asked);
            let watchdog = watchdog(&prm);
            (ar.inputs.watchdog, ar.outputs.watchdog) = (watchdog, watchdog);
            ar.device.ident = Some(prm.ident);
            ar.slave =
                Some(Box::new(SlaveStartData { parameters: Some(asked.data.clone()), ..SlaveStartData::default() }));
            self.add(station, ar);
        }
    }

    pub(super) fn configuration(&mut self, asked: &PendingDpRequest, octets: &[u8], number: u64, sink: Sink<'_>) {
        let (master, station) = (asked.sa, asked.da);
        sink(&self.ars, Observation::Dp { ar: None, event: Dp::Configuration { master, station, octets } });
        if self.master_of(station) == Some(master) {
            self.learn(station, octets, number);
        }
    }

    /// Takes the configuration from Get_Cfg if the trace has no Chk_Cfg.
    pub(super) fn take_get_cfg(&mut self, asked: &PendingDpRequest, octets: &[u8]) {
        let slave = &self.slaves[usize::from(asked.da)];
        let unknown = slave.ar.and_then(|ar| self.ars.get(ar as usize)).is_some_and(|ar| ar.connect_frame.is_none());
        if unknown && slave.lengths.is_none() {
            self.learn(asked.da, octets, asked.number);
        }
    }

    fn learn(&mut self, station: u8, octets: &[u8], number: u64) {
        let slave = &mut self.slaves[usize::from(station)];
        let Some(ar) = slave.ar.and_then(|ar| self.ars.get_mut(ar as usize)) else { return };
        slave.lengths = Identifier::parse_all(octets).ok().map(|identifiers| io_lengths(&identifiers));
        ar.slave.get_or_insert_default().configuration = Some(octets.to_vec());
        ar.parameter_end_frame.get_or_insert(number);
        if ar.stage == ArStage::Asked {
            ar.stage = ArStage::Parameterised;
        }
    }

    pub(super) fn diagnosis(&mut self, asked: &PendingDpRequest, answer: DpAnswer<'_>, sink: Sink<'_>) {
        let Ok(diag) = SlaveDiag::parse(answer.data) else {
            if self.is_recorded {
                let fault = PollFault::ShortDiagnosis { octets: answer.data.len() };
                return self.fault((asked.sa, asked.da, asked.service), fault, sink);
            }
            let why = format!("Slave_Diag has {} bytes, expected at least 6", answer.data.len());
            sink(&self.ars, Observation::Unreadable { why: &why });
            return;
        };
        let (master, station) = (asked.sa, asked.da);
        let (octets, frame) = (answer.data.to_vec(), answer.number);
        let slave = &mut self.slaves[usize::from(station)];
        slave.diagnosis = Some(DiagnosisFrame { octets, frame, time: answer.time, at: answer.at });
        let id = slave.ar;
        let mut stage = None;
        if let Some(ar) = id.and_then(|id| self.ars.get_mut(id as usize)) {
            ar.device.ident = Some(diag.ident);
            stage = Some(ar.stage);
        }
        let event = Dp::Diagnosis { master, station, octets: answer.data, at: answer.at };
        sink(&self.ars, Observation::Dp { ar: id.map(ArId), event });
        let needs_new_start = diag.status_2.has(Status2::PRM_REQ) || diag.status_1.has(Status1::STATION_NOT_READY);
        let other = diag.master == NO_MASTER || self.master_of(station) != Some(diag.master);
        let faults = diag.status_1.has(Status1::PRM_FAULT) || diag.status_1.has(Status1::CFG_FAULT);
        match stage {
            Some(ArStage::Ready) if needs_new_start || other => {
                let event = Dp::Left { why: Leaving::Diagnosis };
                self.end(station, ArStage::Left, |ar| Observation::Dp { ar: Some(ar), event }, sink);
            }
            Some(ArStage::Asked | ArStage::Parameterised) if faults => {
                let event = Dp::Left { why: Leaving::Diagnosis };
                self.end(station, ArStage::Refused, |ar| Observation::Dp { ar: Some(ar), event }, sink);
            }
            _ => {}
        }
    }

    /// Ends the connection of a slave, if there is one, and reports it.
    pub(super) fn end(
        &mut self,
        station: u8,
        stage: ArStage,
        observation: impl FnOnce(ArId) -> Observation<'static>,
        sink: Sink<'_>,
    ) {
        self.standing.retain(|standing| *standing != station);
        let slave = &mut self.slaves[usize::from(station)];
        slave.lengths = None;
        slave.acyclic.clear();
        let Some(index) = slave.ar.take() else { return };
        let Some(ar) = self.ars.get_mut(index as usize) else { return };
        let stood = ar.stage.stands();
        ar.stage = stage;
        if stood || stage == ArStage::Refused {
            sink(&self.ars, observation(ArId(index)));
        }
    }
}

fn between(asked: &PendingDpRequest) -> ObservedAr {
    let party = |station| Party::at(Address::Fdl(station));
    ObservedAr::between(party(asked.sa), party(asked.da))
}

fn requested_ar(asked: &PendingDpRequest) -> ObservedAr {
    let (connect_frame, connect_time) = (Some(asked.number), Some(asked.time));
    ObservedAr { stage: ArStage::Asked, connect_frame, connect_time, ..between(asked) }
}

/// The watchdog time of the slave; zero without a watchdog.
fn watchdog(prm: &SetPrm) -> Duration {
    // Without DP-V1 these bytes have another meaning and rarely have all reserved bits at 0.
    let dpv1 = prm.dpv1().filter(|dpv1| dpv1.status_1.reserved() == 0);
    Duration::from_millis(prm.watchdog_ms(watchdog_base_ms(dpv1)).unwrap_or(0).into())
}
