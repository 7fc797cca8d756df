//! Slave_Diag (IEC 61158-6-3): six bytes of the slave, followed by the blocks of the application.

use super::application::{DiagnosisBits, DpState};
use super::link::ServiceAnswer;
use super::slave::{PoweredSlave, SlaveEnv};
use alloc::vec::Vec;
use wire::profibus::diag::{NO_MASTER, SlaveDiag, Status1, Status2, Status3};

/// Errors in the parameters or the configuration from the master, as the diagnosis reports them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct StartUpFaults {
    /// Prm_Fault: Set_Prm was invalid.
    pub prm: bool,
    /// Cfg_Fault: Chk_Cfg was invalid.
    pub cfg: bool,
    /// Not_Supported: Set_Prm requested Freeze or Sync, which the slave does not support.
    pub not_supported: bool,
}

impl PoweredSlave {
    /// Answers Slave_Diag. If the request comes from the master of the slave, a change of the diagnosis counts as
    /// fetched.
    pub(super) fn slave_diag(&mut self, env: &mut SlaveEnv<'_>, sa: u8) -> ServiceAnswer {
        let mut ext = Vec::new();
        let bits = env.application.diagnosis(env.application_time(), &mut ext);
        let mut diagnosis = self.diagnosis(bits);
        diagnosis.ext = ext;
        if self.master == Some(sa) {
            self.has_new_diagnosis = false;
        }
        let mut octets = Vec::new();
        diagnosis.write(&mut octets);
        octets.truncate(SlaveDiag::LONGEST);
        ServiceAnswer::data(octets)
    }

    fn diagnosis(&self, bits: DiagnosisBits) -> SlaveDiag {
        let sum = |flags: &[(bool, u8)]| flags.iter().filter(|(is_set, _)| *is_set).map(|(_, bit)| bit).sum();
        SlaveDiag {
            status_1: Status1(sum(&[
                (self.state != DpState::DataExchange, Status1::STATION_NOT_READY.0),
                (self.faults.cfg, Status1::CFG_FAULT.0),
                (bits.ext_diag, Status1::EXT_DIAG.0),
                (self.faults.not_supported, Status1::NOT_SUPPORTED.0),
                (self.faults.prm, Status1::PRM_FAULT.0),
            ])),
            status_2: Status2(sum(&[
                (true, Status2::FIXED_ONE.0),
                (self.state == DpState::WaitPrm, Status2::PRM_REQ.0),
                (bits.stat_diag, Status2::STAT_DIAG.0),
                (self.watchdog.is_some(), Status2::WD_ON.0),
                (self.frozen_inputs.is_some(), Status2::FREEZE_MODE.0),
                (self.sync_outputs.is_some(), Status2::SYNC_MODE.0),
            ])),
            status_3: Status3(sum(&[(bits.overflow, Status3::EXT_DIAG_OVERFLOW.0)])),
            master: self.master.unwrap_or(NO_MASTER),
            ident: self.identity.ident,
            ext: Vec::new(),
        }
    }
}
