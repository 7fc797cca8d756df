//! Deviations of the PROFIBUS slave.

use super::Group;
use super::slave_state::{
    ConfigurationRetry, ConfiguresEarly, DiagnosisAnnouncement, EarlierAddress, EndsAtDiagnosis, FirstMaster,
    InMilliseconds, LastMaster, NoFastExchange, NotSupported, OldInputs, OldOutputs, OutputsHeldInClear,
    ParametersTakenOnce, ResumedSession, StickingFault, ZeroInputsInClear,
};
use crate::needs::Need;
use crate::seams::slave::diagnosis_response;
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
            "repetition-carried-out" "A retried request is carried out again."
                => |d| d.slave.check(|check, is_one| is_one && check != SlaveStackCheck::Repetition);
            "answers-too-early" "Answers come 5 bits after the request, before min TSDR."
                => |d| d.slave.delay(|_| BitTimes(5));
            "answers-after-max-tsdr" "Answers come 155 bits after the request: at 1.5 Mbit/s after MaxTsdr of the GSD, but within the slot time."
                => |d| d.slave.delay(|_| BitTimes(155));
            "answers-too-late" "Answers come 5000 bits after the request, after the slot time."
                => |d| d.slave.delay(|_| BitTimes(5_000));
            "fdl-status-not-answered" "FDL status is not answered."
                => |d| d.slave.filter_requests(|frame, _| frame.fc.requested() != Some(RequestFunction::FDL_STATUS));
            "answers-every-address" "Requests to any address are answered."
                => |d| d.slave.check(|check, is_for_it| is_for_it || matches!(check, SlaveStackCheck::Address(_)));

            // Parameters
            "exchange-with-old-parameters" "After power-up data exchange starts with the parameters and the configuration of the last session."
                => |d| d.slave.add(ResumedSession::default());
            "ident-not-checked" "The ident number of Set_Prm is not compared."
                => |d| d.slave.check(|check, is_own| is_own || matches!(check, SlaveStackCheck::Ident(_)));
            "watchdog-never-expires" "The watchdog never expires."
                => |d| d.slave.watchdog(|_| Duration::MAX);
            "watchdog-always-active" "Without WD_On the watchdog runs with a time of 1 s."
                => |d| d.slave.set_prm(|parameters| if !parameters.status.has(StationStatus::WD_ON) {
                    let factors = if watchdog_base(parameters) == 1 { (100, 10) } else { (100, 1) };
                    (parameters.wd_fact_1, parameters.wd_fact_2) = factors;
                    parameters.status = parameters.status.with(StationStatus::WD_ON);
                });
            "watchdog-in-milliseconds" "The watchdog time base is always 1 ms."
                => |d| d.slave.add(InMilliseconds::default());
            "watchdog-factor-0-taken" "A watchdog factor of 0 is accepted."
                => |d| d.slave.set_prm(|parameters| if parameters.wd_fact_1 == 0 || parameters.wd_fact_2 == 0 {
                    parameters.status.0 &= !StationStatus::WD_ON.0;
                });
            "min-tsdr-0-refused" "A min TSDR of 0 is a parameter fault."
                => |d| d.slave.set_prm(|parameters| if parameters.min_tsdr == 0 {
                    parameters.ident = !parameters.ident;
                });
            "unlock-ignored" "Unlock_Req is ignored, and data exchange continues."
                => |d| d.slave.set_prm(|parameters| if parameters.status.has(StationStatus::UNLOCK_REQ) {
                    // Neither locks nor unlocks, and leaves min TSDR as it is.
                    parameters.status.0 &= !(StationStatus::UNLOCK_REQ.0 | StationStatus::LOCK_REQ.0);
                    parameters.min_tsdr = 0;
                });
            "parameters-taken-without-lock" "Parameters are applied even without Lock_Req and Unlock_Req."
                => |d| d.slave.set_prm(|parameters| if !parameters.status.has(StationStatus::UNLOCK_REQ) {
                    parameters.status = parameters.status.with(StationStatus::LOCK_REQ);
                });
            "second-master-takes-over" "Set_Prm of a second master is accepted while the slave is locked by the first."
                => |d| d.slave.check(|check, may| may || matches!(check, SlaveStackCheck::Master(_)));
            "new-parameters-need-power-off" "Parameters sent after a data exchange take effect only after a power cycle."
                => |d| d.slave.add(ParametersTakenOnce::default());

            // Configuration
            "configuration-taken-after-fault" "After a configuration fault a valid configuration is accepted without a new Set_Prm."
                => |d| d.slave.add(ConfigurationRetry::default());
            "configuration-before-parameters" "A configuration is accepted before any Set_Prm, and data exchange uses the defaults."
                => |d| d.slave.check(|check, is_time| is_time || check == SlaveStackCheck::Order);

            // Exchange
            "inputs-before-configuration" "After Set_Prm data exchange is answered with inputs, without Chk_Cfg."
                => |d| d.slave.add(ConfiguresEarly::default());
            "short-outputs-taken" "Outputs of another length are accepted; missing bytes are those of the previous cycle."
                => |d| d.slave.check(|check, fits| fits || matches!(check, SlaveStackCheck::OutputLength(_)));
            "clear-keeps-outputs" "During Clear the last outputs stay in force."
                => |d| d.slave.add(OutputsHeldInClear::default());
            "clear-zeroes-inputs" "During Clear the inputs are 0."
                => |d| d.slave.add(ZeroInputsInClear::default());
            "global-control-ignored" "Global_Control is ignored, including Clear."
                => |d| d.slave.request(SlaveSap::GLOBAL_CONTROL, |_| false);
            "groups-ignored" "A Global_Control to another group is obeyed."
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
            "diagnosis-ends-exchange" "Each Slave_Diag in data exchange sets the slave back to Wait_Prm."
                => |d| d.slave.add(EndsAtDiagnosis::default());
            "no-diagnosis-while-waiting-for-configuration" "Between Set_Prm and Chk_Cfg Slave_Diag is not answered."
                => |d| d.slave.answer(|telegram| if diagnosis_response(telegram).is_some_and(|(_, diag)| waits_for_configuration(&diag)) {
                    telegram.clear();
                });
            "diagnosis-never-announced" "No answer has high priority, even after a change of the diagnosis."
                => |d| d.slave.add(DiagnosisAnnouncement { counts: None, is_faulty: false });
            "diagnosis-always-announced" "While Ext_Diag is set, every tenth answer has high priority."
                => |d| d.slave.add(DiagnosisAnnouncement { counts: Some(0), is_faulty: false });
            "station-non-existent-set" "The slave sets Station_Non_Existent in each diagnosis."
                => |d| d.slave.diagnosis(|diag, _| diag.status_1 = diag.status_1.with(Status1::STATION_NON_EXISTENT));
            "ready-before-parameters" "Station_Not_Ready is 0 before Set_Prm and Chk_Cfg."
                => |d| d.slave.diagnosis(|diag, _| without_1(diag, Status1::STATION_NOT_READY));
            "not-ready-never-cleared" "Station_Not_Ready stays 1 in data exchange."
                => |d| d.slave.diagnosis(|diag, _| diag.status_1 = diag.status_1.with(Status1::STATION_NOT_READY));
            "cfg-fault-never-set" "A refused configuration does not set Cfg_Fault."
                => |d| d.slave.diagnosis(|diag, _| without_1(diag, Status1::CFG_FAULT));
            "cfg-fault-sticks" "Cfg_Fault stays set after a valid configuration."
                => |d| d.slave.add(StickingFault::new(Status1::CFG_FAULT));
            "ext-diag-always-set" "Ext_Diag is always set because there is an extended diagnosis."
                => |d| d.slave.diagnosis(|diag, _| diag.status_1 = diag.status_1.with(Status1::EXT_DIAG));
            "ext-diag-never-set" "Ext_Diag is 0 even with errors."
                => |d| d.slave.diagnosis(|diag, _| without_1(diag, Status1::EXT_DIAG));
            "invalid-response-set" "The slave sets Invalid_Slave_Response in each diagnosis."
                => |d| d.slave.diagnosis(|diag, _| diag.status_1 = diag.status_1.with(Status1::INVALID_SLAVE_RESPONSE));
            "prm-fault-sticks" "Prm_Fault stays set after a valid Set_Prm."
                => |d| d.slave.add(StickingFault::new(Status1::PRM_FAULT));
            "prm-fault-never-set" "A refused Set_Prm does not set Prm_Fault."
                => |d| d.slave.diagnosis(|diag, _| without_1(diag, Status1::PRM_FAULT));
            "master-lock-set-by-slave" "The slave sets Master_Lock in the answer to a master that did not parameterise it."
                => |d| d.slave.diagnosis(|diag, frame| if diag.master != NO_MASTER && diag.master != frame.da {
                    diag.status_1 = diag.status_1.with(Status1::MASTER_LOCK);
                });
            "prm-req-not-set" "Prm_Req is 0 while the slave waits for Set_Prm."
                => |d| d.slave.diagnosis(|diag, _| without_2(diag, Status2::PRM_REQ));
            "stat-diag-always-set" "Stat_Diag is 1 in data exchange."
                => |d| d.slave.diagnosis(|diag, _| in_exchange(diag, Status2::STAT_DIAG));
            "always-one-missing" "Bit 2 of byte 1 is 0."
                => |d| d.slave.diagnosis(|diag, _| diag.status_2.0 &= !0x04);
            "fixed-bit-missing" "Bit 2 of the second byte is 0."
                => |d| d.slave.diagnosis(|diag, _| diag.status_2.0 &= !0x04);
            "watchdog-not-shown" "WD_On in the diagnosis is always 0."
                => |d| d.slave.diagnosis(|diag, _| without_2(diag, Status2::WD_ON));
            "no-exchange-above-1500" "On a bus of more than 1.5 Mbit/s Data_Exchange is not answered."
                => |d| d.slave.add(NoFastExchange::default());
            "watchdog-never-shown" "WD_On in the diagnosis is always 0."
                => |d| d.slave.diagnosis(|diag, _| without_2(diag, Status2::WD_ON));
            "watchdog-always-shown" "WD_On in the diagnosis is set even without a watchdog."
                => |d| d.slave.diagnosis(|diag, _| diag.status_2 = diag.status_2.with(Status2::WD_ON));
            "freeze-mode-always-shown" "Freeze_Mode is always set in data exchange."
                => |d| d.slave.diagnosis(|diag, _| in_exchange(diag, Status2::FREEZE_MODE));
            "sync-mode-always-shown" "Sync_Mode is always set in data exchange."
                => |d| d.slave.diagnosis(|diag, _| in_exchange(diag, Status2::SYNC_MODE));
            "deactivated-set" "The slave sets Deactivated in each diagnosis."
                => |d| d.slave.diagnosis(|diag, _| diag.status_2 = diag.status_2.with(Status2::DEACTIVATED));
            "overflow-with-extended-diagnosis" "Ext_Diag_Overflow is set with the extended diagnosis."
                => |d| d.slave.diagnosis(|diag, _| if diag.ext.len() > 10 {
                    diag.status_3 = diag.status_3.with(Status3::EXT_DIAG_OVERFLOW);
                });
            "own-address-as-master" "Byte 3 is the address of the slave itself."
                => |d| d.slave.diagnosis(|diag, frame| diag.master = frame.sa);
            "ident-swapped-in-exchange" "In data exchange the two bytes of the ident number are swapped."
                => |d| d.slave.diagnosis(|diag, _| if exchanges(diag) {
                    diag.ident = diag.ident.swap_bytes();
                });
            "first-master-stays" "Byte 3 is always the address of the first master since power-up."
                => |d| d.slave.add(FirstMaster::default());
            "last-master-kept" "After power-up byte 3 is the address of the last master."
                => |d| d.slave.add(LastMaster::default());

            // Address
            "address-taken-without-ident" "The ident number of Set_Slave_Address is not compared."
                => |d| d.slave.check(|check, is_own| is_own || matches!(check, SlaveStackCheck::AddressIdent(_)));
            "address-from-ident-bytes" "The new address is taken from the second byte of the telegram."
                => |d| d.slave.set_slave_address(|request| request.address = (request.ident >> 8) as u8);
            "address-in-decimal" "The new address is converted to BCD, so 0Ah becomes 16."
                => |d| d.slave.set_slave_address(|request| request.address = request.address / 10 * 16 + request.address % 10);
            "address-127-taken" "Addresses 126 and 127 are accepted as new addresses; at 127 the slave does not answer."
                => |d| d.slave.check(|check, is_one| is_one || matches!(check, SlaveStackCheck::NewAddress(_)));
            "address-changed-in-exchange" "Set_Slave_Address is accepted even in data exchange."
                => |d| d.slave.check(|check, is_time| is_time || check == SlaveStackCheck::AddressTime);
            "address-after-power-off-only" "The new address is used only after the next power cycle."
                => |d| d.slave.add(EarlierAddress::default());
            "short-address-telegram-taken" "A Set_Slave_Address of three bytes is accepted."
                => |d| d.slave.request(SlaveSap::SET_SLAVE_ADDRESS, |data| {
                    if data.len() == 3 {
                        data.push(0);
                    }
                    true
                });

            // Records
            "acyclic-access-without-enable" "DS_Read and DS_Write are served without DPV1_Enable."
                => |d| d.slave.check(|check, is_on| is_on || check == SlaveStackCheck::Dpv1);
            "records-not-cut" "A record is not cut to the requested length."
                => |d| d.slave.record(|pdu| if let Dpv1Pdu::Read(record) = pdu {
                    record.length = u8::MAX;
                });
        },
    },
    // User bytes with the layout of the AMT58
    Group {
        needs: &[Need::OfEither(&manuals::DATALOGIC_AMT58, &manuals::DP_ENCODER)],
        deviations: bugs! {
            "user-bytes-shifted" "The parameters are read one byte too early."
                => |d| d.slave.parameters(|parameters| {
                    if !parameters.user.is_empty() {
                        parameters.user.rotate_right(1);
                    }
                });
            "mode-requests-corrupt-class" "With Sync_Req or Freeze_Req the scaling bit of the operating parameters is lost."
                => |d| d.slave.parameters(|parameters| {
                    let modes = StationStatus::FREEZE_REQ.0 | StationStatus::SYNC_REQ.0;
                    if let Some(operating) = parameters.user.get_mut(3).filter(|_| parameters.status.0 & modes != 0) {
                        *operating &= !0x08;
                    }
                });
            "reserved-bits-not-supported" "A reserved bit of byte 10 of Set_Prm sets Not_Supported."
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

fn without_1(diag: &mut SlaveDiag, bit: Status1) {
    diag.status_1.0 &= !bit.0;
}

fn without_2(diag: &mut SlaveDiag, bit: Status2) {
    diag.status_2.0 &= !bit.0;
}

/// Whether the diagnosis is that of a slave in data exchange.
fn exchanges(diag: &SlaveDiag) -> bool {
    !diag.status_1.has(Status1::STATION_NOT_READY)
}

/// Whether the diagnosis is that of a slave in Wait_Cfg.
fn waits_for_configuration(diag: &SlaveDiag) -> bool {
    diag.status_1.has(Status1::STATION_NOT_READY) && !diag.status_2.has(Status2::PRM_REQ)
}

fn in_exchange(diag: &mut SlaveDiag, bit: Status2) {
    if exchanges(diag) {
        diag.status_2 = diag.status_2.with(bit);
    }
}
