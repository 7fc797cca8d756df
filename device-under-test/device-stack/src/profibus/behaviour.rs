//! Where the slave can be told to do something else than a healthy one.

use super::application::State;
use station::Duration;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::diag::SlaveDiag;
use wire::profibus::dpv1::Pdu;
use wire::profibus::fdl::BitTimes;
use wire::profibus::global_control::GlobalControl;
use wire::profibus::prm::SetPrm;

/// What the slave knows when it tells its diagnosis.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// How far it has come.
    pub state: State,
    /// Its own address.
    pub address: u8,
    /// Who asks.
    pub asked_by: u8,
    /// The master to which it belongs.
    pub master: Option<u8>,
    /// The first master that parameterised it since power-up.
    pub first_master: Option<u8>,
    /// The master that parameterised it last, before power-up too.
    pub last_master: Option<u8>,
    /// The parameters taken last since power-up.
    pub parameters: Option<&'a SetPrm>,
    /// Whether parameters were wrong since power-up.
    pub had_prm_fault: bool,
}

/// How the slave behaves; the default is healthy. Each field is read at one seam.
#[derive(Clone, Copy, Debug)]
pub struct SlaveBehaviour {
    /// Whether a station of the first address takes what is sent to the second one.
    pub is_addressed: fn(u8, u8) -> bool,
    /// Whether a repeated request gets the answer again, and is not carried out again.
    pub knows_repetitions: bool,
    /// How long it takes to an answer, from what was agreed.
    pub delay: fn(BitTimes) -> BitTimes,
    /// Whether FDL status is answered.
    pub answers_fdl_status: bool,
    /// Whether the states from Wait_Prm on are gone through, and data are not exchanged from the start.
    pub waits_for_parameters: bool,
    /// Whether the ident number of Set_Prm, the first, is right for a slave of the second.
    pub takes_ident: fn(u16, u16) -> bool,
    /// Whether a watchdog that is on needs factors.
    pub checks_watchdog_factors: bool,
    /// Whether this min TSDR is taken.
    pub takes_min_tsdr: fn(u8) -> bool,
    /// The time of the watchdog that is set, from the factors, whether it is to be on, and its unit in milliseconds.
    pub watchdog: fn(u32, bool, u32) -> Option<Duration>,
    /// Whether only its own master may parameterise a locked slave.
    pub is_locked: bool,
    /// Whether the request to unlock is followed.
    pub unlocks: bool,
    /// Whether parameters are taken with Lock_Req alone.
    pub needs_lock_request: bool,
    /// Whether new parameters end the exchange of data.
    pub starts_anew: bool,
    /// Whether parameters that come after an exchange of data take effect, and not only after the next start.
    pub takes_new_parameters: bool,
    /// Changes the parameters that the encoder is given.
    pub taken_parameters: fn(&mut SetPrm),
    /// Whether the configuration is only checked once parameters are right.
    pub checks_order: bool,
    /// Whether data are only exchanged once the configuration is right.
    pub exchanges_after_configuration: bool,
    /// Whether a wrong configuration sends the slave back to Wait_Prm.
    pub leaves_after_wrong_configuration: bool,
    /// Whether Cfg_Fault goes when parameters are taken again.
    pub forgets_cfg_fault: bool,
    /// Whether outputs of this many octets are taken where so many are configured.
    pub takes_outputs: fn(usize, usize) -> bool,
    /// Whether a Global_Control of its master is followed.
    pub follows: fn(&GlobalControl) -> bool,
    /// Whether a slave of the groups of the first is meant by the second.
    pub is_in_group: fn(u8, &GlobalControl) -> bool,
    /// Whether Clear makes outputs clear, and they are not left as they are.
    pub clears_outputs: bool,
    /// Whether Clear leaves the inputs alone.
    pub keeps_inputs_in_clear: bool,
    /// Whether Freeze holds the inputs.
    pub freezes: bool,
    /// Whether Sync holds the outputs.
    pub synchronises: bool,
    /// Whether a request for a mode that the slave has not is told by Not_Supported.
    pub tells_not_supported: bool,
    /// Whether outputs are cleared when the exchange ends.
    pub clears_at_end: bool,
    /// Whether an answer announces the diagnosis, by whether it should, whether the diagnosis told last has a fault, and the number
    /// of the answer.
    pub announces: fn(bool, bool, u32) -> bool,
    /// Changes the diagnosis.
    pub told_diagnosis: fn(&mut SlaveDiag, &View<'_>),
    /// Whether the diagnosis is answered in this state.
    pub answers_diagnosis: fn(State) -> bool,
    /// Whether reading the diagnosis leaves the exchange alone.
    pub diagnosis_is_harmless: bool,
    /// Whether RD_Inp gives the inputs of now, and not those of the first cycle.
    pub reads_fresh_inputs: bool,
    /// Whether RD_Outp gives the outputs of the last cycle, and not those of the first one.
    pub reads_fresh_outputs: bool,
    /// Whether an address may be given in this state, from whether the encoder allows it.
    pub takes_address: fn(State, bool) -> bool,
    /// Whether Set_Slave_Address with the first ident number is for a slave of the second.
    pub compares_ident_of_address: fn(u16, u16) -> bool,
    /// Whether this address may be given.
    pub takes_new_address: fn(u8) -> bool,
    /// Changes what Set_Slave_Address is understood as.
    pub understood_address: fn(&mut SetSlaveAddress),
    /// Whether a Set_Slave_Address that is too short is taken, as if 0 followed.
    pub fills_address_telegram: bool,
    /// Whether the address of the encoder is looked at all the time, and not only at the start.
    pub follows_address: bool,
    /// Whether a new address is used at once, and not only after the next start.
    pub moves_at_once: bool,
    /// Whether records may only be accessed by a master that exchanges data.
    pub records_need_exchange: bool,
    /// Whether records may only be accessed once DP-V1 is on.
    pub records_need_enable: bool,
    /// Whether a request for a record of this slot is never answered.
    pub never_answers: fn(u8) -> bool,
    /// How long a record takes.
    pub record_time: Duration,
    /// Changes the answer to a request for a record.
    pub told_record: fn(&mut Pdu),
    /// Whether a record is cut to the length asked for.
    pub cuts_records: bool,
}

impl Default for SlaveBehaviour {
    fn default() -> SlaveBehaviour {
        SlaveBehaviour {
            is_addressed: |own, asked| own == asked,
            knows_repetitions: true,
            delay: |agreed| agreed,
            answers_fdl_status: true,
            waits_for_parameters: true,
            takes_ident: |told, own| told == own,
            checks_watchdog_factors: true,
            takes_min_tsdr: |_| true,
            watchdog: |factors, is_on, base| is_on.then(|| Duration::from_millis(u64::from(factors) * u64::from(base))),
            is_locked: true,
            unlocks: true,
            needs_lock_request: true,
            starts_anew: true,
            takes_new_parameters: true,
            taken_parameters: |_| {},
            checks_order: true,
            exchanges_after_configuration: true,
            leaves_after_wrong_configuration: true,
            forgets_cfg_fault: true,
            takes_outputs: |sent, configured| sent == configured,
            follows: |_| true,
            is_in_group: |own, control| control.is_for(own),
            clears_outputs: true,
            keeps_inputs_in_clear: true,
            freezes: true,
            synchronises: true,
            tells_not_supported: true,
            clears_at_end: true,
            announces: |should, _, _| should,
            told_diagnosis: |_, _| {},
            answers_diagnosis: |_| true,
            diagnosis_is_harmless: true,
            reads_fresh_inputs: true,
            reads_fresh_outputs: true,
            takes_address: |state, is_allowed| is_allowed && state == State::WaitPrm,
            compares_ident_of_address: |told, own| told == own,
            takes_new_address: |address| address <= 125,
            understood_address: |_| {},
            fills_address_telegram: false,
            follows_address: false,
            moves_at_once: true,
            records_need_exchange: true,
            records_need_enable: true,
            never_answers: |_| false,
            record_time: Duration::from_millis(2),
            told_record: |_| {},
            cuts_records: true,
        }
    }
}
