//! The hooks of a slave: the seams at which a deviation may change what comes in and what goes out, and the checks it may flip.
//!
//! The slave itself is plain. Without the feature `deviations` no hook is ever called.

use super::application::Application;
use alloc::vec;
use alloc::vec::Vec;
use core::time::Duration;
use station::StandAction;
use wire::profibus::cfg::Sums;
use wire::profibus::fdl::BitTimes;
use wire::profibus::prm::SetPrm;

/// A yes or no that the slave decides, with what it decides about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// A telegram to this address is for the slave.
    Address(u8),
    /// A counted request is the one before once more, and gets the same answer.
    Repetition,
    /// Set_Prm comes from a master that may set parameters: the slave belongs to no other one.
    Master(u8),
    /// The ident number of Set_Prm is that of the slave.
    Ident(u16),
    /// Chk_Cfg comes when there are parameters.
    Order,
    /// The outputs have as many octets as the configuration says.
    OutputLength(usize),
    /// Global_Control is for the groups of the slave.
    Group(u8),
    /// The encoder leaves its address to the bus: Set_Slave_Address is served.
    AddressService,
    /// Set_Slave_Address comes while parameters are awaited.
    AddressTime,
    /// The ident number of Set_Slave_Address is that of the slave.
    AddressIdent(u16),
    /// This may be the address of a slave.
    NewAddress(u8),
    /// The master has turned DP-V1 on, so that it may access records.
    Dpv1,
}

/// The hooks of a slave; each default changes nothing. The encoder is passed for reading only.
#[allow(unused_variables, reason = "the names tell what a seam is about")]
pub trait SlaveHooks {
    /// What the slave has decided about this.
    fn check(&mut self, encoder: &dyn Application, check: Check, verdict: bool) -> bool {
        verdict
    }

    /// The telegrams that the slave hears in the place of one that came off the bus.
    fn comes(&mut self, encoder: &dyn Application, telegram: &[u8]) -> Vec<Vec<u8>> {
        vec![telegram.to_vec()]
    }

    /// Changes a telegram that the slave sends; an empty one is not sent.
    fn goes(&mut self, encoder: &dyn Application, telegram: &mut Vec<u8>) {}

    /// How long the slave waits until it answers, from what was agreed.
    fn delay(&mut self, right: BitTimes) -> BitTimes {
        right
    }

    /// How long the watchdog waits for the master.
    fn watchdog(&mut self, right: Duration) -> Duration {
        right
    }

    /// Changes the parameters that the encoder is given; `false` keeps them from it as if they were right.
    fn parameters(&mut self, parameters: &mut SetPrm) -> bool {
        true
    }

    /// How much is exchanged after Chk_Cfg with these identifiers, or none for Cfg_Fault.
    fn configuration(&mut self, encoder: &dyn Application, identifiers: &[u8], right: Option<Sums>) -> Option<Sums> {
        right
    }

    /// Changes the outputs that the encoder is given; none while they are clear or missing.
    fn outputs(&mut self, outputs: &mut Option<Vec<u8>>) {}

    /// Changes the inputs that the encoder has given.
    fn inputs(&mut self, inputs: &mut [u8]) {}

    /// The slave has started anew.
    fn starts(&mut self) {}

    /// What hands do to the device.
    fn act(&mut self, action: &StandAction<'_>) {}
}
