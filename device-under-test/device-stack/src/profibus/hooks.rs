//! The hooks of a slave: the seams at which a deviation may change incoming and outgoing data, and the checks that it
//! may flip.
//!
//! The slave itself conforms. Without the feature `deviations` no hook is called.

use super::application::SlaveApplication;
use alloc::vec;
use alloc::vec::Vec;
use core::time::Duration;
use station::{StandAction, Time};
use wire::profibus::cfg::IoLengths;
use wire::profibus::fdl::BitTimes;
use wire::profibus::prm::SetPrm;

/// A yes-or-no decision of the slave and its subject. Each comment says what `true` means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlaveStackCheck {
    /// The slave detects a bus of this rate in bit/s.
    Rate(u32),
    /// A telegram to this address is for the slave.
    Address(u8),
    /// A request with a frame count bit is a repetition, and gets the same answer.
    Repetition,
    /// Set_Prm comes from a master that may send parameters: no other master has locked the slave.
    Master(u8),
    /// Set_Prm contains the ident number of the slave.
    Ident(u16),
    /// Chk_Cfg comes after valid parameters.
    Order,
    /// The outputs have the configured length in bytes.
    OutputLength(usize),
    /// Global_Control addresses a group of the slave.
    Group(u8),
    /// Set_Slave_Address is served: the application permits it.
    AddressService,
    /// Set_Slave_Address comes in Wait_Prm.
    AddressTime,
    /// Set_Slave_Address contains the ident number of the slave.
    AddressIdent(u16),
    /// A slave may have this address.
    NewAddress(u8),
    /// The master has enabled DP-V1 and may access records.
    Dpv1,
    /// A class 1 master may access records: the slave exchanges data with it. The other master with which the slave exchanges data, if
    /// it does.
    Class1(Option<u8>),
    /// The slave has the modes that Set_Prm requests: Freeze and Sync, as its GSD says.
    Modes,
    /// The slave has isochronous mode, which Set_Prm requests.
    Isochronous,
    /// Another master may read inputs and outputs: RD_Inp and RD_Outp are services of the slave.
    ReadServices,
}

/// The hooks of a slave; each default changes nothing. The application (`encoder`) is passed for reading only.
#[allow(unused_variables, reason = "the names document the hook")]
pub trait SlaveHooks {
    /// Replaces a decision of the slave, which is `verdict`.
    fn check(&mut self, encoder: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        verdict
    }

    /// Replaces a received telegram by the telegrams that the slave receives instead.
    fn received_telegrams(&mut self, encoder: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        vec![telegram.to_vec()]
    }

    /// Changes a telegram that the slave sends; an empty telegram is not sent.
    fn sent_telegram(&mut self, encoder: &dyn SlaveApplication, telegram: &mut Vec<u8>) {}

    /// Changes the delay of an answer (min TSDR).
    fn delay(&mut self, right: BitTimes) -> BitTimes {
        right
    }

    /// Changes the time from power-up to the first answer.
    fn boot_time(&mut self, right: Duration) -> Duration {
        right
    }

    /// Changes the time from a valid Chk_Cfg to data exchange.
    fn ready_time(&mut self, right: Duration) -> Duration {
        right
    }

    /// Changes the time that a record takes.
    fn record_time(&mut self, right: Duration) -> Duration {
        right
    }

    /// Changes the watchdog time.
    fn watchdog(&mut self, right: Duration) -> Duration {
        right
    }

    /// Changes the parameters for the application. `false` hides them from it, as if they were valid.
    fn parameters(&mut self, parameters: &mut SetPrm) -> bool {
        true
    }

    /// Changes the result of Chk_Cfg with these identifiers: the lengths of inputs and outputs, or `None` for
    /// Cfg_Fault.
    fn configuration(
        &mut self,
        encoder: &dyn SlaveApplication,
        identifiers: &[u8],
        right: Option<IoLengths>,
    ) -> Option<IoLengths> {
        right
    }

    /// Changes the outputs for the application; `None` while they are clear or missing.
    fn outputs(&mut self, outputs: &mut Option<Vec<u8>>) {}

    /// Changes the inputs that the application gives at `now`.
    fn inputs(&mut self, now: Time, inputs: &mut [u8]) {}

    /// The slave has restarted.
    fn starts(&mut self) {}

    /// The stand acts on the device.
    fn act(&mut self, action: &StandAction<'_>) {}
}
