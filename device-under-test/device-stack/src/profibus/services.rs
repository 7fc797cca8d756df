//! Dispatches frames to services by function code and service access points (IEC 61158-4-3 and 61158-6-3).

use super::application::DpState;
use super::hooks::SlaveStackCheck;
use super::link::ServiceAnswer;
use super::records::{Ms2Request, RECORD_TIME};
use super::slave::{PoweredSlave, SlaveEnv};
use alloc::vec::Vec;
use core::time::Duration;
use wire::profibus::fdl::{AnswerFunction, BROADCAST, BitTimes, DataFrame, FdlFrame, RequestFunction, UNNAMED};
use wire::profibus::sap::{MasterSap, SlaveSap};

impl PoweredSlave {
    /// Processes a frame from the bus.
    pub fn receive(&mut self, env: &mut SlaveEnv<'_>, octets: &[u8]) {
        self.last_frame_at = Some(env.now);
        self.link.discard_answer();
        if !self.check(env, SlaveStackCheck::Rate(self.link.baud().0), true) {
            return;
        }
        let Ok(FdlFrame::Data(frame)) = FdlFrame::parse(octets) else { return };
        let Some(function) = frame.fc.requested() else { return };
        let is_for_us =
            self.address <= UNNAMED && self.check(env, SlaveStackCheck::Address(frame.da), self.address == frame.da);
        if frame.destination.segment.is_some() || !(is_for_us || frame.da == BROADCAST) {
            return;
        }
        match function {
            RequestFunction::SDN_LOW | RequestFunction::SDN_HIGH => {
                if frame.destination.sap == Some(SlaveSap::GLOBAL_CONTROL.0) {
                    self.global_control(env, frame.sa, frame.data);
                }
            }
            _ if !is_for_us || !function.expects_response() => {}
            _ => self.serve(env, function, &frame),
        }
    }

    fn serve(&mut self, env: &mut SlaveEnv<'_>, function: RequestFunction, frame: &DataFrame<'_>) {
        let own = self.address;
        if self.check(env, SlaveStackCheck::Repetition, self.link.is_repetition(frame)) {
            let delay = self.answer_delay();
            self.link.repeat(env.now, delay);
            self.trigger_watchdog(env.now, frame.sa);
            return;
        }
        let answer = match function {
            RequestFunction::FDL_STATUS => ServiceAnswer::Code(AnswerFunction::OK),
            RequestFunction::SRD_LOW | RequestFunction::SRD_HIGH => {
                let answer = self.service(env, frame);
                self.trigger_watchdog(env.now, frame.sa);
                answer
            }
            _ => ServiceAnswer::NO_SERVICE,
        };
        let delay = self.answer_delay();
        self.link.answer(env.now, own, frame, &answer, delay);
    }

    /// The time from the request to its answer; called once for each answer.
    fn answer_delay(&self) -> BitTimes {
        self.hooks.apply(self.link.delay, |hooks, delay| hooks.delay(delay))
    }

    /// The time that a record takes.
    fn record_time(&self) -> Duration {
        self.hooks.apply(RECORD_TIME, |hooks, takes| hooks.record_time(takes))
    }

    fn service(&mut self, env: &mut SlaveEnv<'_>, frame: &DataFrame<'_>) -> ServiceAnswer {
        let DataFrame { sa, data, .. } = *frame;
        let source = frame.source.sap.map(MasterSap);
        let Some(sap) = frame.destination.sap else {
            return if source.is_none() { self.exchange(env, sa, data) } else { ServiceAnswer::NO_SERVICE };
        };
        match (SlaveSap(sap), source) {
            (SlaveSap::SLAVE_DIAG, Some(MasterSap::MS0)) => self.slave_diag(env, sa),
            (SlaveSap::SET_PRM, Some(MasterSap::MS0)) => self.set_prm(env, sa, data),
            (SlaveSap::SET_EXT_PRM, Some(MasterSap::MS0)) => self.set_ext_prm(env, sa, data),
            (SlaveSap::CHK_CFG, Some(MasterSap::MS0)) => self.check_cfg(env, sa, data),
            (SlaveSap::GET_CFG, Some(MasterSap::MS0)) => {
                let mut octets = Vec::new();
                env.application.configuration(&mut octets);
                ServiceAnswer::data(octets)
            }
            (SlaveSap::READ_INPUTS, Some(MasterSap::MS0)) => self.read_inputs(env),
            (SlaveSap::READ_OUTPUTS, Some(MasterSap::MS0)) => self.read_outputs(env),
            (SlaveSap::SET_SLAVE_ADDRESS, Some(MasterSap::MS0)) => self.set_slave_address(env, data),
            (access_point @ (SlaveSap::SERVER | SlaveSap::ALARM), Some(MasterSap::MS1)) => {
                let is_on = self.check(env, SlaveStackCheck::Dpv1, self.has_dpv1);
                let other = self.master.filter(|master| *master != sa && self.state == DpState::DataExchange);
                let is_own = self.check(env, SlaveStackCheck::Class1(other), self.is_exchanging_with(sa));
                if !self.identity.ms1 || !is_on || !is_own {
                    return ServiceAnswer::NO_SERVICE;
                }
                let takes = self.record_time();
                match access_point {
                    SlaveSap::ALARM if !self.identity.extra_alarm_sap => ServiceAnswer::NO_SERVICE,
                    SlaveSap::ALARM => self.records.serve_alarms(env, data, takes),
                    _ => self.records.serve_ms1(env, data, takes),
                }
            }
            (SlaveSap(sap), Some(MasterSap::MS2)) => {
                let takes = self.record_time();
                self.records.serve_ms2(env, Ms2Request { sap, master: sa, data, takes }, &self.identity)
            }
            _ => ServiceAnswer::NO_SERVICE,
        }
    }
}
