//! The seam between a PROFIBUS DP slave and the encoder behind it.
//!
//! The stack speaks FDL and DP and owns what all slaves share: addresses and frame counts, the states from Power_On to
//! Data_Exch, watchdog, lock, freeze and sync, the six octets of the diagnosis, the polling of DP-V1. The application is what
//! one manual describes: parameters, configurations, cyclic data, blocks of the diagnosis, records, what is stored.
//!
//! This room must not know frames, access points or bit times, nor any particular encoder.

use alloc::vec::Vec;
use core::time::Duration;
use station::{StandAction, Time};
use wire::profibus::cfg::Sums;
use wire::profibus::dpv1::{Abilities, ErrorDecode, RecordError};
use wire::profibus::prm::{PrmBlock, SetPrm};

/// The encoder behind a PROFIBUS DP slave.
///
/// Every call says what time it is; time never goes backwards.
pub trait Application {
    /// What the slave is and can do; it never changes.
    fn identity(&self) -> &Identity;

    /// The supply has come: memory and switches are read, everything volatile is as at the beginning.
    ///
    /// The stack stays silent for [`Identity::boot_time`] from here on.
    fn power_up(&mut self, now: Time);

    /// The supply has gone: what is volatile is lost, what is being written to memory is not written.
    ///
    /// [`exchange_ends`](Application::exchange_ends) is not called for it.
    fn power_down(&mut self, now: Time);

    /// The station address as switches or memory have it; the stack takes it when it starts.
    ///
    /// A station with 127 or more is silent.
    fn address(&self) -> u8;

    /// Whether the bus may give the slave another address now; asked at each Set_Slave_Address.
    fn takes_address(&self) -> bool;

    /// Stores the address that the bus has given; `is_final` if it may not be changed again.
    fn set_address(&mut self, now: Time, address: u8, is_final: bool);

    /// Checks the parameters and takes them over if they are right; `false` is answered with Prm_Fault.
    ///
    /// The stack has checked the seven octets of the head. The user octets are complete, with those of DP-V1 in front.
    fn parameters(&mut self, now: Time, parameters: &SetPrm) -> bool;

    /// Checks the blocks of Set_Ext_Prm and takes them over if they are right; only asked if [`Identity::set_ext_prm`] says so.
    fn more_parameters(&mut self, now: Time, blocks: &[PrmBlock]) -> bool {
        let (_, _) = (now, blocks);
        false
    }

    /// Checks the identifiers of Chk_Cfg against the parameters taken before: how much is exchanged, or none for Cfg_Fault.
    fn check_configuration(&mut self, now: Time, identifiers: &[u8]) -> Option<Sums>;

    /// Appends the identifiers that Get_Cfg tells.
    fn configuration(&self, out: &mut Vec<u8>);

    /// Parameters and configuration are right: cyclic data follow.
    fn exchange_begins(&mut self, now: Time);

    /// The cyclic data end; [`outputs`](Application::outputs) with none was called before.
    fn exchange_ends(&mut self, now: Time, end: End);

    /// Takes outputs: once for each Data_Exchange that takes effect, or none when they are cleared, fail-safe or missing.
    fn outputs(&mut self, now: Time, data: Option<&[u8]>);

    /// Fills in the inputs, after the outputs of the same Data_Exchange; all of `data` is written.
    ///
    /// Also asked by RD_Inp, and once by Freeze.
    fn inputs(&mut self, now: Time, data: &mut [u8]);

    /// A Global_Control of the master has come, for the groups of the slave or for those that follow the clock of the bus.
    ///
    /// It comes before freeze and sync are followed. Whether it is the clock, the parameters say.
    fn clock(&mut self, now: Time) {
        let _ = now;
    }

    /// Appends the blocks behind the six octets of the diagnosis, and says which bits of the head belong to them.
    ///
    /// It is asked before the slave is parameterised too.
    fn diagnosis(&mut self, now: Time, out: &mut Vec<u8>) -> DiagnosisBits;

    /// Whether the diagnosis has changed since this was asked last, so that the master is to fetch it.
    fn diagnosis_changed(&mut self) -> bool;

    /// Writes a record of DP-V1.
    fn write(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), Refusal> {
        let (_, _, _) = (now, access, data);
        Err(Refusal::error(RecordError::INVALID_INDEX))
    }

    /// Reads a record of DP-V1 and appends it to `out`, complete; the stack cuts it to the length asked for.
    fn read(&mut self, now: Time, access: Access, out: &mut Vec<u8>) -> Result<(), Refusal> {
        let (_, _, _) = (now, access, out);
        Err(Refusal::error(RecordError::INVALID_INDEX))
    }

    /// A connection of a class 2 master has ended, or all that MS1 left open is forgotten.
    fn forget(&mut self, now: Time, channel: Channel) {
        let (_, _) = (now, channel);
    }

    /// Does at `now` what the stand does to the sensor, and says when it will be done; `None` if it has no means for it.
    ///
    /// Power and link are the stack's and never come here. Without supply it is called too.
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time>;

    /// Whether what is fed to the device is enough for it to work; while it is not, it is as if its supply were cut.
    fn is_alive(&self) -> bool {
        true
    }

    /// Somebody looks at the LEDs at `now` and has `seen` what the stack knows: what they show together is settled here, once.
    ///
    /// [`led`](Application::led) follows for each LED that is looked at, with the same `now` and `seen`. Nothing is called
    /// between them.
    fn look(&mut self, now: Time, seen: &Seen) {
        let (_, _) = (now, seen);
    }

    /// What the LED `name` shows at `now` to who has `seen` what the stack knows, in a word of `device.yaml`.
    fn led(&mut self, now: Time, name: &str, seen: &Seen) -> Option<&'static str>;

    /// How often the counter `name` has counted; `None` if there is none of this name.
    fn counter(&mut self, now: Time, name: &str) -> Option<u64>;

    /// The next time at which [`advance`](Application::advance) has something to do.
    fn deadline(&self) -> Option<Time>;

    /// Does what is due at `now`; called early or late it does what is due and nothing else.
    fn advance(&mut self, now: Time);
}

/// What a slave is and can do, as its GSD says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Ident_Number.
    pub ident: u16,
    /// How long the slave is silent after power-up.
    pub boot_time: Duration,
    /// Whether it can freeze its inputs.
    pub freeze: bool,
    /// Whether it can synchronise its outputs.
    pub sync: bool,
    /// Whether outputs without data are taken as clear if Set_Prm says so.
    pub fail_safe: bool,
    /// Whether the first three user octets of Set_Prm are those of DP-V1.
    pub dpv1: bool,
    /// Whether a class 1 master can read and write records.
    pub ms1: bool,
    /// How many connections of class 2 masters there can be; 0 without MS2.
    pub ms2: usize,
    /// What the slave says of itself in a connection of a class 2 master.
    pub abilities: Option<Abilities>,
    /// Whether there is Set_Ext_Prm.
    pub set_ext_prm: bool,
}

/// Why cyclic data ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The watchdog expired.
    Watchdog,
    /// The master unlocked the slave.
    Unlocked,
    /// The master sent parameters anew.
    Parameters,
    /// Parameters, configuration or outputs were wrong.
    Fault,
}

/// The bits in the head of the diagnosis that belong to its blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DiagnosisBits {
    /// Ext_Diag: something is wrong, and the blocks say what.
    pub ext_diag: bool,
    /// Stat_Diag: the cyclic data are of no use as long as it is set.
    pub stat_diag: bool,
    /// Ext_Diag_Overflow: there is more to report than has room.
    pub overflow: bool,
}

/// Who accesses records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// The class 1 master.
    Ms1,
    /// A class 2 master, by the access point of its connection.
    Ms2(u8),
}

/// Which record is accessed by whom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// Who accesses it.
    pub channel: Channel,
    /// Slot_Number.
    pub slot: u8,
    /// Index.
    pub index: u8,
}

/// Why a record was refused: what stands behind the function number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Error_Decode.
    pub decode: ErrorDecode,
    /// Error_Code_1.
    pub code_1: u8,
    /// Error_Code_2.
    pub code_2: u8,
}

impl Refusal {
    /// A refusal with an error of DP-V1 and nothing of the maker's.
    pub const fn error(error: RecordError) -> Refusal {
        Refusal { decode: ErrorDecode::DPV1, code_1: error.0, code_2: 0 }
    }
}

/// How far the slave has come on its way to the exchange of data.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// Parameters are awaited.
    #[default]
    WaitPrm,
    /// Parameters are right, a configuration is awaited.
    WaitCfg,
    /// Both are right, data are exchanged.
    DataExchange,
}

/// What the stack knows of itself that an LED may show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// Whether there is power, and enough of it.
    pub has_supply: bool,
    /// Whether the device has power and does not answer yet.
    pub is_booting: bool,
    /// Whether the cable is plugged.
    pub is_linked: bool,
    /// How far the slave has come.
    pub state: State,
    /// When a frame of whatever kind was heard last.
    pub heard: Option<Time>,
    /// Whether the last parameters were wrong.
    pub prm_fault: bool,
    /// Whether the last configuration was wrong.
    pub cfg_fault: bool,
    /// Whether the watchdog has expired since parameters were taken last.
    pub watchdog_expired: bool,
    /// Whether outputs are cleared.
    pub is_clear: bool,
}
