//! Deviations of the PROFIBUS slave.

use super::Group;
use super::slave_memory::{
    Announces, ConfiguresEarly, EarlierAddress, EndsAtDiagnosis, FirstMaster, Held, InMilliseconds, LastMaster,
    NotSupported, OldInputs, OldOutputs, Resumes, Retries, StickingFault, TakesOnce, Zeroes,
};
use crate::needs::Need;
use crate::seams::slave::told_diagnosis;
use core::time::Duration;
use device_stack::profibus::SlaveStackCheck;
use reference_devices::manuals;
use wire::profibus::diag::{NO_MASTER, SlaveDiag, Status1, Status2, Status3};
use wire::profibus::dpv1::Dpv1Pdu;
use wire::profibus::fdl::{BitTimes, RequestFunction};
use wire::profibus::global_control::{GlobalCommand, GlobalControl};
use wire::profibus::prm::{SetPrm, StationStatus};
use wire::profibus::sap::SlaveSap;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profibus],
        deviations: bugs! {
            // Data link
            "repetition-carried-out" "A repeated request is carried out again."
                => |d| d.slave.check(|check, is_one| is_one && check != SlaveStackCheck::Repetition);
            "answers-too-early" "Answers come 5 bits after the request, before min TSDR."
                => |d| d.slave.delay(|_| BitTimes(5));
            "answers-too-late" "Answers come 5000 bits after the request, when the slot time is over."
                => |d| d.slave.delay(|_| BitTimes(5_000));
            "fdl-status-not-answered" "FDL status is not answered."
                => |d| d.slave.hear(|frame, _| frame.fc.requested() != Some(RequestFunction::FDL_STATUS));
            "answers-every-address" "Requests to any address are answered."
                => |d| d.slave.check(|check, is_for_it| is_for_it || matches!(check, SlaveStackCheck::Address(_)));

            // Parameters
            "exchange-with-old-parameters" "After power-up data are exchanged with the parameters and the configuration of the last session."
                => |d| d.slave.add(Resumes::default());
            "ident-not-checked" "The ident number of Set_Prm is not compared."
                => |d| d.slave.check(|check, is_own| is_own || matches!(check, SlaveStackCheck::Ident(_)));
            "watchdog-never-expires" "The watchdog never expires."
                => |d| d.slave.watchdog(|_| Duration::MAX);
            "watchdog-always-active" "Without WD_On the watchdog runs with 1 s."
                => |d| d.slave.set_prm(|parameters| if !parameters.status.has(StationStatus::WD_ON) {
                    let factors = if watchdog_base(parameters) == 1 { (100, 10) } else { (100, 1) };
                    (parameters.wd_fact_1, parameters.wd_fact_2) = factors;
                    parameters.status = parameters.status.with(StationStatus::WD_ON);
                });
            "watchdog-in-milliseconds" "The watchdog counts in milliseconds, whatever its unit is."
                => |d| d.slave.add(InMilliseconds::default());
            "watchdog-factor-0-taken" "A watchdog factor of 0 is accepted."
                => |d| d.slave.set_prm(|parameters| if parameters.wd_fact_1 == 0 || parameters.wd_fact_2 == 0 {
                    parameters.status.0 &= !StationStatus::WD_ON.0;
                });
            "min-tsdr-0-refused" "A min TSDR of 0 is a parameter fault."
                => |d| d.slave.set_prm(|parameters| if parameters.min_tsdr == 0 {
                    parameters.ident = !parameters.ident;
                });
            "unlock-ignored" "Unlock_Req is ignored, and the data exchange goes on."
                => |d| d.slave.set_prm(|parameters| if parameters.status.has(StationStatus::UNLOCK_REQ) {
                    // Neither to lock nor to unlock, and min TSDR as it is.
                    parameters.status.0 &= !(StationStatus::UNLOCK_REQ.0 | StationStatus::LOCK_REQ.0);
                    parameters.min_tsdr = 0;
                });
            "parameters-taken-without-lock" "Without Lock_Req and Unlock_Req the parameters are taken over too."
                => |d| d.slave.set_prm(|parameters| if !parameters.status.has(StationStatus::UNLOCK_REQ) {
                    parameters.status = parameters.status.with(StationStatus::LOCK_REQ);
                });
            "second-master-takes-over" "Set_Prm of another master is taken over while the device belongs to one."
                => |d| d.slave.check(|check, may| may || matches!(check, SlaveStackCheck::Master(_)));
            "new-parameters-need-power-off" "Parameters that come after an exchange of data take effect after a power cycle only."
                => |d| d.slave.add(TakesOnce::default());

            // Configuration
            "configuration-taken-after-fault" "After a configuration fault a right configuration is accepted without a new Set_Prm."
                => |d| d.slave.add(Retries::default());
            "configuration-before-parameters" "A configuration is accepted before any Set_Prm, and data are exchanged with the defaults."
                => |d| d.slave.check(|check, is_time| is_time || check == SlaveStackCheck::Order);

            // Exchange
            "inputs-before-configuration" "After Set_Prm the exchange of data is answered with inputs, without Chk_Cfg."
                => |d| d.slave.add(ConfiguresEarly::default());
            "short-outputs-taken" "Outputs of another length are taken, missing octets being those of the cycle before."
                => |d| d.slave.check(|check, fits| fits || matches!(check, SlaveStackCheck::OutputLength(_)));
            "clear-keeps-outputs" "During Clear the last outputs go on counting as sent in each cycle."
                => |d| d.slave.add(Held::default());
            "clear-zeroes-inputs" "During Clear the inputs are 0."
                => |d| d.slave.add(Zeroes::default());
            "global-control-ignored" "Global_Control is not followed, Clear included."
                => |d| d.slave.request(SlaveSap::GLOBAL_CONTROL, |_| false);
            "groups-ignored" "A Global_Control to another group is followed."
                => |d| d.slave.check(|check, is_meant| is_meant || matches!(check, SlaveStackCheck::Group(_)));
            "freeze-ignored" "Freeze does not hold the inputs."
                => |d| d.slave.global_control(|control| without(control, GlobalCommand::FREEZE));
            "sync-ignored" "Sync does not hold the outputs."
                => |d| d.slave.global_control(|control| without(control, GlobalCommand::SYNC));
            "read-inputs-are-old" "RD_Inp returns the inputs of the first cycle of the exchange."
                => |d| d.slave.add(OldInputs::default());
            "read-outputs-are-old" "RD_Outp returns the outputs of the first cycle of the exchange."
                => |d| d.slave.add(OldOutputs::default());

            // Diagnosis
            "diagnosis-ends-exchange" "Each Slave_Diag in data exchange sends the device back to Wait_Prm."
                => |d| d.slave.add(EndsAtDiagnosis::default());
            "no-diagnosis-while-waiting-for-configuration" "Between Set_Prm and Chk_Cfg a request for the diagnosis is not answered."
                => |d| d.slave.answer(|telegram| if told_diagnosis(telegram).is_some_and(|(_, told)| waits_for_configuration(&told)) {
                    telegram.clear();
                });
            "diagnosis-never-announced" "No answer has high priority, whatever changes."
                => |d| d.slave.add(Announces { counts: None, is_faulty: false });
            "diagnosis-always-announced" "While a block is there every tenth answer has high priority."
                => |d| d.slave.add(Announces { counts: Some(0), is_faulty: false });
            "station-non-existent-set" "The slave sets Station_Non_Existent in each diagnosis."
                => |d| d.slave.diagnosis(|told, _| told.status_1 = told.status_1.with(Status1::STATION_NON_EXISTENT));
            "ready-before-parameters" "Station_Not_Ready is 0 before Set_Prm and Chk_Cfg."
                => |d| d.slave.diagnosis(|told, _| without_1(told, Status1::STATION_NOT_READY));
            "not-ready-never-cleared" "Station_Not_Ready stays 1 in data exchange."
                => |d| d.slave.diagnosis(|told, _| told.status_1 = told.status_1.with(Status1::STATION_NOT_READY));
            "cfg-fault-never-set" "A refused configuration does not set Cfg_Fault."
                => |d| d.slave.diagnosis(|told, _| without_1(told, Status1::CFG_FAULT));
            "cfg-fault-sticks" "Cfg_Fault stays 1 when a right configuration comes."
                => |d| d.slave.add(StickingFault::new(Status1::CFG_FAULT));
            "ext-diag-always-set" "Ext_Diag is 1 since octets follow the sixth."
                => |d| d.slave.diagnosis(|told, _| told.status_1 = told.status_1.with(Status1::EXT_DIAG));
            "ext-diag-never-set" "Ext_Diag is 0 with errors too."
                => |d| d.slave.diagnosis(|told, _| without_1(told, Status1::EXT_DIAG));
            "invalid-response-set" "The slave sets Invalid_Slave_Response in each diagnosis."
                => |d| d.slave.diagnosis(|told, _| told.status_1 = told.status_1.with(Status1::INVALID_SLAVE_RESPONSE));
            "prm-fault-sticks" "Prm_Fault stays 1 when a right Set_Prm comes."
                => |d| d.slave.add(StickingFault::new(Status1::PRM_FAULT));
            "prm-fault-never-set" "A refused Set_Prm does not set Prm_Fault."
                => |d| d.slave.diagnosis(|told, _| without_1(told, Status1::PRM_FAULT));
            "master-lock-set-by-slave" "The slave sets Master_Lock when a master asks that did not parameterise it."
                => |d| d.slave.diagnosis(|told, frame| if told.master != NO_MASTER && told.master != frame.da {
                    told.status_1 = told.status_1.with(Status1::MASTER_LOCK);
                });
            "prm-req-not-set" "Prm_Req is 0 while the slave waits for Set_Prm."
                => |d| d.slave.diagnosis(|told, _| without_2(told, Status2::PRM_REQ));
            "stat-diag-always-set" "Stat_Diag is 1 in data exchange."
                => |d| d.slave.diagnosis(|told, _| in_exchange(told, Status2::STAT_DIAG));
            "always-one-missing" "Bit 2 of octet 1 is 0."
                => |d| d.slave.diagnosis(|told, _| told.status_2.0 &= !0x04);
            "fixed-bit-missing" "Bit 2 of the second octet is 0."
                => |d| d.slave.diagnosis(|told, _| told.status_2.0 &= !0x04);
            "watchdog-not-shown" "WD_On of the diagnosis is 0 whatever Set_Prm says."
                => |d| d.slave.diagnosis(|told, _| without_2(told, Status2::WD_ON));
            "watchdog-never-shown" "The bit of the watchdog in the diagnosis is 0."
                => |d| d.slave.diagnosis(|told, _| without_2(told, Status2::WD_ON));
            "watchdog-always-shown" "The bit of the watchdog is 1 without a watchdog too."
                => |d| d.slave.diagnosis(|told, _| told.status_2 = told.status_2.with(Status2::WD_ON));
            "freeze-mode-always-shown" "Freeze_Mode is 1 in data exchange without a Freeze."
                => |d| d.slave.diagnosis(|told, _| in_exchange(told, Status2::FREEZE_MODE));
            "sync-mode-always-shown" "Sync_Mode is 1 in data exchange without a Sync."
                => |d| d.slave.diagnosis(|told, _| in_exchange(told, Status2::SYNC_MODE));
            "deactivated-set" "The slave sets Deactivated in each diagnosis."
                => |d| d.slave.diagnosis(|told, _| told.status_2 = told.status_2.with(Status2::DEACTIVATED));
            "overflow-with-extended-diagnosis" "With the extended diagnosis Ext_Diag_Overflow is 1."
                => |d| d.slave.diagnosis(|told, _| if told.ext.len() > 10 {
                    told.status_3 = told.status_3.with(Status3::EXT_DIAG_OVERFLOW);
                });
            "own-address-as-master" "Octet 3 is the address of the slave itself."
                => |d| d.slave.diagnosis(|told, frame| told.master = frame.sa);
            "ident-swapped-in-exchange" "In data exchange the two octets of the ident number are swapped."
                => |d| d.slave.diagnosis(|told, _| if exchanges(told) {
                    told.ident = told.ident.swap_bytes();
                });
            "first-master-stays" "Octet 3 stays the address of the first master that parameterised the slave since power-up."
                => |d| d.slave.add(FirstMaster::default());
            "last-master-kept" "After power-up octet 3 is the address of the last master."
                => |d| d.slave.add(LastMaster::default());

            // Address
            "address-taken-without-ident" "The ident number of Set_Slave_Address is not compared."
                => |d| d.slave.check(|check, is_own| is_own || matches!(check, SlaveStackCheck::AddressIdent(_)));
            "address-from-ident-octets" "The new address is taken from the second octet of the telegram."
                => |d| d.slave.set_slave_address(|asked| asked.address = (asked.ident >> 8) as u8);
            "address-in-decimal" "The new address is read as two decimal digits, so that 0Ah is 16."
                => |d| d.slave.set_slave_address(|asked| asked.address = asked.address / 10 * 16 + asked.address % 10);
            "address-127-taken" "The addresses 126 and 127 are taken as new ones; at 127 the device answers nobody."
                => |d| d.slave.check(|check, is_one| is_one || matches!(check, SlaveStackCheck::NewAddress(_)));
            "address-changed-in-exchange" "Set_Slave_Address is taken in data exchange too."
                => |d| d.slave.check(|check, is_time| is_time || check == SlaveStackCheck::AddressTime);
            "address-after-power-off-only" "The new address counts after the next power cycle only."
                => |d| d.slave.add(EarlierAddress::default());
            "short-address-telegram-taken" "A telegram of three octets is taken."
                => |d| d.slave.request(SlaveSap::SET_SLAVE_ADDRESS, |data| {
                    if data.len() == 3 {
                        data.push(0);
                    }
                    true
                });

            // Records
            "acyclic-access-without-enable" "DS_Read and DS_Write are served without DPV1_Enable."
                => |d| d.slave.check(|check, is_on| is_on || check == SlaveStackCheck::Dpv1);
            "records-not-cut" "A record is not cut to the length that was asked for."
                => |d| d.slave.record(|pdu| if let Dpv1Pdu::Read(record) = pdu {
                    record.length = u8::MAX;
                });
        },
    },
    // User octets with the layout of the AMT58
    Group {
        needs: &[Need::Of(&manuals::DATALOGIC_AMT58)],
        deviations: bugs! {
            "user-octets-shifted" "The parameters are read one octet too early."
                => |d| d.slave.parameters(|parameters| {
                    if !parameters.user.is_empty() {
                        parameters.user.rotate_right(1);
                    }
                });
            "mode-requests-corrupt-class" "With Sync_Req or Freeze_Req the operating parameters lose their bit of scaling."
                => |d| d.slave.parameters(|parameters| {
                    let asked = StationStatus::FREEZE_REQ.0 | StationStatus::SYNC_REQ.0;
                    if let Some(operating) = parameters.user.get_mut(3).filter(|_| parameters.status.0 & asked != 0) {
                        *operating &= !0x08;
                    }
                });
            "reserved-bits-not-supported" "A reserved bit of octet 10 of Set_Prm sets Not_Supported."
                => |d| d.slave.add(NotSupported::default());
        },
    },
];

fn watchdog_base(parameters: &SetPrm) -> u32 {
    parameters.dpv1().unwrap_or_default().watchdog_base_ms()
}

fn without(control: &mut GlobalControl, command: GlobalCommand) {
    control.command.0 &= !command.0;
}

fn without_1(told: &mut SlaveDiag, bit: Status1) {
    told.status_1.0 &= !bit.0;
}

fn without_2(told: &mut SlaveDiag, bit: Status2) {
    told.status_2.0 &= !bit.0;
}

/// Whether data are exchanged by what the diagnosis says.
fn exchanges(told: &SlaveDiag) -> bool {
    !told.status_1.has(Status1::STATION_NOT_READY)
}

/// Whether the slave has parameters and waits for its configuration.
fn waits_for_configuration(told: &SlaveDiag) -> bool {
    told.status_1.has(Status1::STATION_NOT_READY) && !told.status_2.has(Status2::PRM_REQ)
}

fn in_exchange(told: &mut SlaveDiag, bit: Status2) {
    if exchanges(told) {
        told.status_2 = told.status_2.with(bit);
    }
}
