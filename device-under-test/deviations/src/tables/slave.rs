//! Bugs of the PROFIBUS slave, which all models have; each model says which of them it can be told to have.

use super::Bug;
use core::time::Duration;
use device_stack::profibus::{State, View};
use wire::profibus::diag::{NO_MASTER, SlaveDiag, Status1, Status2, Status3};
use wire::profibus::fdl::BitTimes;
use wire::profibus::prm::StationStatus;

/// The bugs of this seam.
pub static BUGS: &[Bug] = bugs! {
    // Data link
    "repetition-carried-out" "A repeated request is carried out again."
        => |b| b.slave.knows_repetitions = false;
    "answers-too-early" "Answers come 5 bits after the request, before min TSDR."
        => |b| b.slave.delay = |_| BitTimes(5);
    "answers-too-late" "Answers come 5000 bits after the request, when the slot time is over."
        => |b| b.slave.delay = |_| BitTimes(5_000);
    "fdl-status-not-answered" "FDL status is not answered."
        => |b| b.slave.answers_fdl_status = false;
    "answers-every-address" "Requests to any address are answered."
        => |b| b.slave.is_addressed = |_, _| true;

    // Parameters
    "exchange-with-old-parameters" "After power-up data are exchanged with the parameters and the configuration of the last session."
        => |b| b.slave.waits_for_parameters = false;
    "ident-not-checked" "The ident number of Set_Prm is not compared."
        => |b| b.slave.takes_ident = |_, _| true;
    "watchdog-never-expires" "The watchdog never expires."
        => |b| b.slave.watchdog = |_, is_on, _| is_on.then_some(Duration::MAX);
    "watchdog-always-active" "Without WD_On the watchdog runs with 1 s."
        => |b| b.slave.watchdog = |factors, is_on, base| Some(if is_on { time(factors, base) } else { Duration::from_secs(1) });
    "watchdog-in-milliseconds" "The watchdog counts in milliseconds, whatever its unit is."
        => |b| b.slave.watchdog = |factors, is_on, _| is_on.then(|| time(factors, 1));
    "watchdog-factor-0-taken" "A watchdog factor of 0 is accepted."
        => |b| {
            b.slave.checks_watchdog_factors = false;
            b.slave.watchdog = |factors, is_on, base| (is_on && factors > 0).then(|| time(factors, base));
        };
    "min-tsdr-0-refused" "A min TSDR of 0 is a parameter fault."
        => |b| b.slave.takes_min_tsdr = |min_tsdr| min_tsdr != 0;
    "unlock-ignored" "Unlock_Req is ignored, and the data exchange goes on."
        => |b| b.slave.unlocks = false;
    "parameters-taken-without-lock" "Without Lock_Req and Unlock_Req the parameters are taken over too."
        => |b| b.slave.needs_lock_request = false;
    "second-master-takes-over" "Set_Prm of another master is taken over while the device belongs to one."
        => |b| b.slave.is_locked = false;
    "new-parameters-need-power-off" "Parameters that come after an exchange of data take effect after a power cycle only."
        => |b| b.slave.takes_new_parameters = false;
    "user-octets-shifted" "The parameters are read one octet too early."
        => |b| b.slave.taken_parameters = |parameters| parameters.user.rotate_right(1);

    // Configuration
    "configuration-taken-after-fault" "After a configuration fault a right configuration is accepted without a new Set_Prm."
        => |b| b.slave.leaves_after_wrong_configuration = false;
    "configuration-before-parameters" "A configuration is accepted before any Set_Prm, and data are exchanged with the defaults."
        => |b| b.slave.checks_order = false;

    // Exchange
    "inputs-before-configuration" "After Set_Prm the exchange of data is answered with inputs, without Chk_Cfg."
        => |b| b.slave.exchanges_after_configuration = false;
    "short-outputs-taken" "Outputs of another length are taken, missing octets being those of the cycle before."
        => |b| b.slave.takes_outputs = |_, _| true;
    "clear-keeps-outputs" "During Clear the last outputs go on counting as sent in each cycle."
        => |b| b.slave.clears_outputs = false;
    "clear-zeroes-inputs" "During Clear the inputs are 0."
        => |b| b.slave.keeps_inputs_in_clear = false;
    "global-control-ignored" "Global_Control is not followed, Clear included."
        => |b| b.slave.follows = |_| false;
    "groups-ignored" "A Global_Control to another group is followed."
        => |b| b.slave.is_in_group = |_, _| true;
    "freeze-ignored" "Freeze does not hold the inputs."
        => |b| b.slave.freezes = false;
    "sync-ignored" "Sync does not hold the outputs."
        => |b| b.slave.synchronises = false;
    "read-inputs-are-old" "RD_Inp returns the inputs of the first cycle of the exchange."
        => |b| b.slave.reads_fresh_inputs = false;
    "read-outputs-are-old" "RD_Outp returns the outputs of the first cycle of the exchange."
        => |b| b.slave.reads_fresh_outputs = false;

    // Diagnosis
    "diagnosis-ends-exchange" "Each Slave_Diag in data exchange sends the device back to Wait_Prm."
        => |b| b.slave.diagnosis_is_harmless = false;
    "no-diagnosis-while-waiting-for-configuration" "Between Set_Prm and Chk_Cfg a request for the diagnosis is not answered."
        => |b| b.slave.answers_diagnosis = |state| state != State::WaitCfg;
    "diagnosis-never-announced" "No answer has high priority, whatever changes."
        => |b| b.slave.announces = |_, _, _| false;
    "diagnosis-always-announced" "While a block is there every tenth answer has high priority."
        => |b| b.slave.announces = |should, is_faulty, count| should || is_faulty && count % 10 == 0;
    "station-non-existent-set" "The slave sets Station_Non_Existent in each diagnosis."
        => |b| b.slave.told_diagnosis = |told, _| told.status_1 = told.status_1.with(Status1::STATION_NON_EXISTENT);
    "ready-before-parameters" "Station_Not_Ready is 0 before Set_Prm and Chk_Cfg."
        => |b| b.slave.told_diagnosis = |told, _| without_1(told, Status1::STATION_NOT_READY);
    "not-ready-never-cleared" "Station_Not_Ready stays 1 in data exchange."
        => |b| b.slave.told_diagnosis = |told, _| told.status_1 = told.status_1.with(Status1::STATION_NOT_READY);
    "cfg-fault-never-set" "A refused configuration does not set Cfg_Fault."
        => |b| b.slave.told_diagnosis = |told, _| without_1(told, Status1::CFG_FAULT);
    "cfg-fault-sticks" "Cfg_Fault stays 1 when a right configuration comes."
        => |b| b.slave.forgets_cfg_fault = false;
    "ext-diag-always-set" "Ext_Diag is 1 since octets follow the sixth."
        => |b| b.slave.told_diagnosis = |told, _| told.status_1 = told.status_1.with(Status1::EXT_DIAG);
    "ext-diag-never-set" "Ext_Diag is 0 with errors too."
        => |b| b.slave.told_diagnosis = |told, _| without_1(told, Status1::EXT_DIAG);
    "invalid-response-set" "The slave sets Invalid_Slave_Response in each diagnosis."
        => |b| b.slave.told_diagnosis = |told, _| told.status_1 = told.status_1.with(Status1::INVALID_SLAVE_RESPONSE);
    "prm-fault-sticks" "Prm_Fault stays 1 when a right Set_Prm comes."
        => |b| b.slave.told_diagnosis = |told, view| if view.had_prm_fault {
            told.status_1 = told.status_1.with(Status1::PRM_FAULT);
        };
    "prm-fault-never-set" "A refused Set_Prm does not set Prm_Fault."
        => |b| b.slave.told_diagnosis = |told, _| without_1(told, Status1::PRM_FAULT);
    "master-lock-set-by-slave" "The slave sets Master_Lock when a master asks that did not parameterise it."
        => |b| b.slave.told_diagnosis = |told, view| if view.master.is_some_and(|master| master != view.asked_by) {
            told.status_1 = told.status_1.with(Status1::MASTER_LOCK);
        };
    "prm-req-not-set" "Prm_Req is 0 while the slave waits for Set_Prm."
        => |b| b.slave.told_diagnosis = |told, _| without_2(told, Status2::PRM_REQ);
    "stat-diag-always-set" "Stat_Diag is 1 in data exchange."
        => |b| b.slave.told_diagnosis = |told, view| in_exchange(told, view, Status2::STAT_DIAG);
    "always-one-missing" "Bit 2 of octet 1 is 0."
        => |b| b.slave.told_diagnosis = |told, _| told.status_2.0 &= !0x04;
    "fixed-bit-missing" "Bit 2 of the second octet is 0."
        => |b| b.slave.told_diagnosis = |told, _| told.status_2.0 &= !0x04;
    "watchdog-not-shown" "WD_On of the diagnosis is 0 whatever Set_Prm says."
        => |b| b.slave.told_diagnosis = |told, _| without_2(told, Status2::WD_ON);
    "watchdog-never-shown" "The bit of the watchdog in the diagnosis is 0."
        => |b| b.slave.told_diagnosis = |told, _| without_2(told, Status2::WD_ON);
    "watchdog-always-shown" "The bit of the watchdog is 1 without a watchdog too."
        => |b| b.slave.told_diagnosis = |told, _| told.status_2 = told.status_2.with(Status2::WD_ON);
    "freeze-mode-always-shown" "Freeze_Mode is 1 in data exchange without a Freeze."
        => |b| b.slave.told_diagnosis = |told, view| in_exchange(told, view, Status2::FREEZE_MODE);
    "sync-mode-always-shown" "Sync_Mode is 1 in data exchange without a Sync."
        => |b| b.slave.told_diagnosis = |told, view| in_exchange(told, view, Status2::SYNC_MODE);
    "deactivated-set" "The slave sets Deactivated in each diagnosis."
        => |b| b.slave.told_diagnosis = |told, _| told.status_2 = told.status_2.with(Status2::DEACTIVATED);
    "overflow-with-extended-diagnosis" "With the extended diagnosis Ext_Diag_Overflow is 1."
        => |b| b.slave.told_diagnosis = |told, _| if told.ext.len() > 10 {
            told.status_3 = told.status_3.with(Status3::EXT_DIAG_OVERFLOW);
        };
    "own-address-as-master" "Octet 3 is the address of the slave itself."
        => |b| b.slave.told_diagnosis = |told, view| told.master = view.address;
    "ident-swapped-in-exchange" "In data exchange the two octets of the ident number are swapped."
        => |b| b.slave.told_diagnosis = |told, view| if view.state == State::DataExchange {
            told.ident = told.ident.swap_bytes();
        };
    "first-master-stays" "Octet 3 stays the address of the first master that parameterised the slave since power-up."
        => |b| b.slave.told_diagnosis = |told, view| told.master = view.first_master.unwrap_or(NO_MASTER);
    "last-master-kept" "After power-up octet 3 is the address of the last master."
        => |b| b.slave.told_diagnosis = |told, view| if view.first_master.is_none() {
            told.master = view.last_master.unwrap_or(NO_MASTER);
        };

    // Address
    "address-taken-without-ident" "The ident number of Set_Slave_Address is not compared."
        => |b| b.slave.compares_ident_of_address = |_, _| true;
    "address-from-ident-octets" "The new address is taken from the second octet of the telegram."
        => |b| b.slave.understood_address = |asked| asked.address = (asked.ident >> 8) as u8;
    "address-in-decimal" "The new address is read as two decimal digits, so that 0Ah is 16."
        => |b| b.slave.understood_address = |asked| asked.address = asked.address / 10 * 16 + asked.address % 10;
    "address-127-taken" "The addresses 126 and 127 are taken as new ones; at 127 the device answers nobody."
        => |b| b.slave.takes_new_address = |_| true;
    "address-changed-in-exchange" "Set_Slave_Address is taken in data exchange too."
        => |b| b.slave.takes_address = |_, is_allowed| is_allowed;
    "address-after-power-off-only" "The new address counts after the next power cycle only."
        => |b| b.slave.moves_at_once = false;
    "short-address-telegram-taken" "A telegram of three octets is taken."
        => |b| b.slave.fills_address_telegram = true;

    // Records
    "acyclic-access-without-enable" "DS_Read and DS_Write are served without DPV1_Enable."
        => |b| b.slave.records_need_enable = false;
    "records-not-cut" "A record is not cut to the length that was asked for."
        => |b| b.slave.cuts_records = false;
};

/// The bugs of this seam that not all manuals have.
pub static OTHERS: &[Bug] = bugs! {
    "mode-requests-corrupt-class" "With Sync_Req or Freeze_Req the operating parameters lose their bit of scaling."
        => |b| b.slave.taken_parameters = |parameters| {
            let asked = StationStatus::FREEZE_REQ.0 | StationStatus::SYNC_REQ.0;
            if let Some(operating) = parameters.user.get_mut(3).filter(|_| parameters.status.0 & asked != 0) {
                *operating &= !0x08;
            }
        };
    "reserved-bits-not-supported" "A reserved bit of octet 10 of Set_Prm sets Not_Supported."
        => |b| b.slave.told_diagnosis = |told, view| {
            let operating = view.parameters.and_then(|parameters| parameters.user.get(3));
            if operating.is_some_and(|bits| bits & 0x34 != 0) {
                told.status_1 = told.status_1.with(Status1::NOT_SUPPORTED);
            }
        };
};

fn time(factors: u32, base: u32) -> Duration {
    Duration::from_millis(u64::from(factors) * u64::from(base))
}

fn without_1(told: &mut SlaveDiag, bit: Status1) {
    told.status_1.0 &= !bit.0;
}

fn without_2(told: &mut SlaveDiag, bit: Status2) {
    told.status_2.0 &= !bit.0;
}

fn in_exchange(told: &mut SlaveDiag, view: &View<'_>, bit: Status2) {
    if view.state == State::DataExchange {
        told.status_2 = told.status_2.with(bit);
    }
}
