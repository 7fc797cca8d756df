//! The interface between a PROFIBUS DP slave and its application.
//!
//! The stack implements what all slaves share: FDL, addresses and frame count bits, the states from Power_On to
//! Data_Exch, watchdog, lock, Freeze and Sync, the first six bytes of the diagnosis, the polling of DP-V1. The
//! application implements what one manual describes: parameters, configurations, cyclic data, diagnosis blocks,
//! records, stored data.
//!
//! This module must not depend on frames, service access points, bit times or a particular encoder.

use alloc::vec::Vec;
use core::time::Duration;
use station::{StandAction, Time};
use wire::profibus::cfg::IoLengths;
use wire::profibus::diag::Specifier;
use wire::profibus::dpv1::{Dpv1ErrorDecode, InitiateFeatures, RecordError};
use wire::profibus::prm::{PrmBlock, SetPrm};

/// The application of a PROFIBUS DP slave, for instance an encoder.
///
/// Every call passes the current time, which never goes backwards.
#[allow(unused_variables, reason = "the names document the parameters")]
pub trait SlaveApplication {
    /// The identification and the features of the slave; they never change.
    fn identity(&self) -> &SlaveIdentity;

    /// The supply was switched on: load memory, read switches and initialise everything volatile.
    ///
    /// The stack sends nothing during [`SlaveIdentity::boot_time`] from here on.
    fn power_up(&mut self, now: Time);

    /// The supply failed: volatile data are lost, and a running write to memory is not completed.
    ///
    /// The stack does not call [`exchange_ends`](SlaveApplication::exchange_ends) in this case.
    fn power_down(&mut self, now: Time);

    /// The station address from switches or memory. The stack reads it at its start.
    ///
    /// With an address of 127 or more the slave sends nothing.
    fn address(&self) -> u8;

    /// Whether Set_Slave_Address is permitted now. The stack checks it for each request.
    fn takes_address(&self) -> bool;

    /// Stores the address from Set_Slave_Address. `is_final` is its No_Add_Chg: the address must not change again.
    fn set_address(&mut self, now: Time, address: u8, is_final: bool);

    /// Checks the parameters of Set_Prm and applies them if they are valid. `false` results in Prm_Fault.
    ///
    /// The stack has checked the seven bytes of the standard part. The user parameters are complete, with the three
    /// DP-V1 bytes first.
    fn parameters(&mut self, now: Time, parameters: &SetPrm) -> bool;

    /// Checks the blocks of Set_Ext_Prm and applies them if they are valid. Called only if [`SlaveIdentity::set_ext_prm`]
    /// is set.
    fn more_parameters(&mut self, now: Time, blocks: &[PrmBlock]) -> bool {
        false
    }

    /// Checks the identifiers of Chk_Cfg against the parameters. Returns the lengths of inputs and outputs, or `None`
    /// for Cfg_Fault.
    fn check_configuration(&mut self, now: Time, identifiers: &[u8]) -> Option<IoLengths>;

    /// Appends the identifiers that Get_Cfg reports.
    fn configuration(&self, out: &mut Vec<u8>);

    /// Parameters and configuration are valid: data exchange begins.
    fn exchange_begins(&mut self, now: Time);

    /// Data exchange ends. The stack has called [`outputs`](SlaveApplication::outputs) with `None` before.
    fn exchange_ends(&mut self, now: Time, end: ExchangeEnd);

    /// Receives outputs: once for each Data_Exchange that takes effect, and `None` when they are cleared, fail-safe
    /// or missing.
    fn outputs(&mut self, now: Time, data: Option<&[u8]>);

    /// Fills in the inputs, after the outputs of the same Data_Exchange. Write all of `data`.
    ///
    /// Also called for RD_Inp, and once for Freeze.
    fn inputs(&mut self, now: Time, data: &mut [u8]);

    /// The master sent a Global_Control to a group of the slave, or to the group of the bus clock.
    ///
    /// Called before Freeze and Sync are carried out. The parameters define whether it is the clock.
    fn clock(&mut self, now: Time) {}

    /// Appends the blocks after the first six bytes of the diagnosis, and returns the bits in those bytes that belong
    /// to them.
    ///
    /// Also called before the slave is parameterised.
    fn diagnosis(&mut self, now: Time, out: &mut Vec<u8>) -> DiagnosisBits;

    /// Whether the diagnosis has changed since the last call, so that the master must fetch it.
    fn diagnosis_changed(&mut self) -> bool;

    /// Writes a record of DP-V1.
    fn write(&mut self, now: Time, access: Dpv1Access, data: &[u8]) -> Result<(), Dpv1RecordRefusal> {
        Err(Dpv1RecordRefusal::error(RecordError::INVALID_INDEX))
    }

    /// Reads a record of DP-V1 and appends all of it to `out`. The stack truncates it to the requested length.
    fn read(&mut self, now: Time, access: Dpv1Access, out: &mut Vec<u8>) -> Result<(), Dpv1RecordRefusal> {
        Err(Dpv1RecordRefusal::error(RecordError::INVALID_INDEX))
    }

    /// The class 1 master acknowledges an alarm. Refused unless this alarm of the slot waits for it.
    fn acknowledge_alarm(&mut self, now: Time, alarm: AcknowledgedAlarm) -> Result<(), Dpv1RecordRefusal> {
        Err(Dpv1RecordRefusal::error(RecordError::FEATURE_NOT_SUPPORTED))
    }

    /// A connection of a class 2 master, or MS1, has ended: drop responses that were not fetched.
    fn forget(&mut self, now: Time, channel: Dpv1Channel) {}

    /// Carries out an action of the stand on the sensor. Returns when it is complete, or `None` if the application
    /// does not support the action.
    ///
    /// The stack handles power and link itself. The call also occurs without supply.
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time>;

    /// Whether the supply suffices for the device to work. While it does not, the device behaves as with the supply
    /// cut.
    fn is_alive(&self) -> bool {
        true
    }

    /// The stand reads the LEDs at `now`: compute here, once, the state that they share. `status` is the state of the
    /// stack.
    ///
    /// The stack then calls [`led`](SlaveApplication::led) for each LED that is read, with the same `now` and `status` and
    /// nothing in between.
    fn update_leds(&mut self, now: Time, status: &SlaveStatus) {}

    /// What the LED `name` shows at `now`, as a word of `device.yaml`. `status` is the state of the stack.
    fn led(&mut self, now: Time, name: &str, status: &SlaveStatus) -> Option<&'static str> {
        None
    }

    /// The value of the counter `name`; `None` if there is no counter of this name.
    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        None
    }

    /// The next time at which [`advance`](SlaveApplication::advance) has something to do.
    fn deadline(&self) -> Option<Time> {
        None
    }

    /// Does what is due at `now`. An early or late call is allowed.
    fn advance(&mut self, now: Time) {}
}

/// The identification and the features of a slave, as in its GSD.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlaveIdentity {
    /// Ident_Number.
    pub ident: u16,
    /// Time from power-up to the first answer.
    pub boot_time: Duration,
    /// Freeze_Mode_supp: it can freeze its inputs.
    pub freeze: bool,
    /// Sync_Mode_supp: it can synchronise its outputs.
    pub sync: bool,
    /// Fail_Safe: a Data_Exchange without data clears the outputs, if Set_Prm enables it.
    pub fail_safe: bool,
    /// Whether the first three user parameter bytes of Set_Prm are those of DP-V1.
    pub dpv1: bool,
    /// Whether a class 1 master can read and write records.
    pub ms1: bool,
    /// Extra_Alarm_SAP_supp: whether a class 1 master can acknowledge alarms at an access point of their own, too.
    pub extra_alarm_sap: bool,
    /// Number of connections of class 2 masters; 0 without MS2.
    pub ms2: usize,
    /// The features and addresses in the answer to the Initiate of a class 2 master.
    pub abilities: Option<InitiateFeatures>,
    /// Whether the slave supports isochronous mode.
    pub isochronous: bool,
    /// Whether the slave supports Set_Ext_Prm.
    pub set_ext_prm: bool,
}

/// Why data exchange ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExchangeEnd {
    /// The watchdog expired.
    Watchdog,
    /// The master unlocked the slave.
    Unlocked,
    /// The master sent new parameters.
    Parameters,
    /// Parameters, configuration or outputs were wrong.
    Fault,
}

/// The bits in the first six bytes of the diagnosis that belong to its blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DiagnosisBits {
    /// Ext_Diag: the blocks report an error.
    pub ext_diag: bool,
    /// Stat_Diag: the cyclic data are not usable as long as it is set.
    pub stat_diag: bool,
    /// Ext_Diag_Overflow: not all diagnoses fit.
    pub overflow: bool,
}

/// The master that accesses records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dpv1Channel {
    /// The class 1 master.
    Ms1,
    /// A class 2 master, by the service access point of its connection.
    Ms2(u8),
}

/// The record that is accessed, and the master that accesses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dpv1Access {
    /// The master.
    pub channel: Dpv1Channel,
    /// Slot_Number.
    pub slot: u8,
    /// Index.
    pub index: u8,
}

/// The alarm that a master acknowledges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AcknowledgedAlarm {
    /// Slot_Number.
    pub slot: u8,
    /// Alarm_Type, 0 to 126.
    pub alarm_type: u8,
    /// The specifier of the alarm, with its sequence number.
    pub specifier: Specifier,
}

/// Why a record was refused: the error bytes after the function number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dpv1RecordRefusal {
    /// Error_Decode.
    pub decode: Dpv1ErrorDecode,
    /// Error_Code_1.
    pub code_1: u8,
    /// Error_Code_2.
    pub code_2: u8,
}

impl Dpv1RecordRefusal {
    /// A refusal with an error of DP-V1, without a manufacturer specific code.
    pub const fn error(error: RecordError) -> Dpv1RecordRefusal {
        Dpv1RecordRefusal { decode: Dpv1ErrorDecode::DPV1, code_1: error.0, code_2: 0 }
    }
}

/// The state of a slave on the way to data exchange.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DpState {
    /// Wait_Prm: the slave waits for parameters.
    #[default]
    WaitPrm,
    /// Wait_Cfg: parameters are valid, the slave waits for a configuration.
    WaitCfg,
    /// Data_Exch: parameters and configuration are valid.
    DataExchange,
}

/// The state of the stack, for LEDs that show it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SlaveStatus {
    /// Whether the supply is on and sufficient.
    pub has_supply: bool,
    /// Whether the device is booting: it has power and does not answer yet.
    pub is_booting: bool,
    /// Whether the cable is plugged in.
    pub is_linked: bool,
    /// The state of the slave.
    pub state: DpState,
    /// When the slave received the last frame of any kind.
    pub last_frame_at: Option<Time>,
    /// Whether the last parameters were invalid.
    pub prm_fault: bool,
    /// Whether the last configuration was invalid.
    pub cfg_fault: bool,
    /// Whether the watchdog has expired since the last valid parameters.
    pub watchdog_expired: bool,
    /// Whether outputs are cleared.
    pub is_clear: bool,
}
