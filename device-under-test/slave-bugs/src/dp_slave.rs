//! Bugs of the generic DP slave, beside those that each slave can have.

use super::Group;
use super::dp_slave_state::{
    AnyAccessPoint, AnyIdentification, CommandOfBefore, ConnectionTakenOver, ConnectionWithoutEnd, ExchangeWithAnybody,
    FirstMasterOnly, ForgottenFaults, FormerAddress, InCentiseconds, LeavesExchange, LockUntilPowerOff,
    NeedsParametersInExchange, NoExchangeAt, OutputsOfBefore, OutputsWithoutData, Repaired, Replaced, SlowPolls,
    asked_by_owner, completed, of_owner, to_access_point,
};
use crate::needs::Need;
use crate::seams::slave::{frame, request, with_data};
use alloc::rc::Rc;
use alloc::vec;
use alloc::vec::Vec;
use core::cell::Cell;
use device_stack::profibus::{SlaveHooks, SlaveStackCheck};
use reference_devices::manuals;
use reference_devices::models::generic_slave::CONFIGURATIONS;
use wire::profibus::diag::{SlaveDiag, Status1, Status2, Status3};
use wire::profibus::dpv1::{Dpv1Pdu, RecordError};
use wire::profibus::fdl::{DataFrame, Extension, FdlFrame, FunctionCode, RequestFunction};
use wire::profibus::global_control::{GlobalCommand, GlobalControl};
use wire::profibus::prm::StationStatus;
use wire::profibus::sap::{SapService, SlaveSap};

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::DP_SLAVE)],
    deviations: bugs! {
        // Data link
        "checksum-not-checked" "The checksum of a frame is not checked."
            => |d| d.slave.add(Repaired(|octets| if let [.., _, _] = octets.as_slice() && octets.len() > 6 {
                let at = octets.len() - 2;
                octets[at] = octets[4..at].iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
            }));
        "end-delimiter-not-checked" "The end delimiter of a frame is not checked."
            => |d| d.slave.add(Repaired(|octets| if let Some(last) = octets.last_mut() { *last = 0x16 }));
        "second-length-not-checked" "Only the first of the two lengths of a frame is used."
            => |d| d.slave.add(Repaired(|octets| if octets.len() > 3 { octets[2] = octets[1] }));
        "start-delimiter-not-checked" "A frame with any start delimiter is taken as one of variable length."
            => |d| d.slave.add(Repaired(|octets| if octets.len() > 6 {
                octets[0] = 0x68;
            }));
        "incomplete-frame-answered" "A frame that ends too early is completed to a Slave_Diag."
            => |d| d.slave.add(Repaired(completed));
        "damaged-frame-ends-exchange" "A damaged frame ends data exchange."
            => |d| d.slave.add(LeavesExchange::at(|telegram| FdlFrame::parse(telegram).is_err()));
        "reserved-function-code-taken" "The reserved function code 0Bh is taken as SRD high."
            => |d| d.slave.add(Replaced::new(|_, frame, _| {
                let count = frame.fc.count().filter(|_| frame.fc.requested() == Some(RequestFunction(0x0B)))?;
                let fc = FunctionCode::request(RequestFunction::SRD_HIGH, count);
                Some(vec![with_data(&DataFrame { fc, ..*frame }, frame.data)])
            }));
        "any-access-point-answered" "At access points without a service the diagnosis is sent."
            => |d| d.slave.add(AnyAccessPoint::default());
        "answers-from-another-access-point" "The answer to Get_Cfg comes from access point 60."
            => |d| d.slave.answer(|telegram| if let Some(frame) = frame(telegram) && frame.source.sap == Some(SlaveSap::GET_CFG.0) {
                *telegram = with_data(&DataFrame { source: Extension::sap(SlaveSap::SLAVE_DIAG.0), ..frame }, frame.data);
            });
        "no-exchange-below-187" "On a bus of less than 187.5 kbit/s Data_Exchange is not answered."
            => |d| d.slave.add(NoExchangeAt::new(0..=187_499));
        "no-exchange-from-187-to-1500" "On a bus of 187.5 kbit/s to 1.5 Mbit/s Data_Exchange is not answered."
            => |d| d.slave.add(NoExchangeAt::new(187_500..=1_500_000));

        // Parameters
        "short-parameters-taken" "A Set_Prm of less than seven bytes is completed with usual values."
            => |d| d.slave.request(SlaveSap::SET_PRM, |data| {
                if data.len() < 7 {
                    *data = vec![0x88, 20, 5, 11, 0xFE, 0xED, 0, 0, 0, 0, 1];
                }
                true
            });
        "wait-for-configuration-not-entered" "Between Set_Prm and Chk_Cfg the slave still requests parameters."
            => |d| d.slave.diagnosis(|diag, _| if diag.status_1.has(Status1::STATION_NOT_READY) {
                diag.status_2 = diag.status_2.with(Status2::PRM_REQ);
            });
        "both-locks" "With both Lock_Req and Unlock_Req the slave is locked."
            => |d| d.slave.set_prm(|prm| if prm.status.has(StationStatus::LOCK_REQ) {
                prm.status.0 &= !StationStatus::UNLOCK_REQ.0;
            });
        "modes-refused" "Freeze_Req and Sync_Req are reported as not supported, although the GSD has them."
            => |d| d.slave.check(|check, right| right && check != SlaveStackCheck::Modes);
        "isochronous-mode-ignored" "Set_Prm with IsoM_Req is taken, although the slave has no isochronous mode."
            => |d| d.slave.check(|check, right| right || check == SlaveStackCheck::Isochronous);
        "wrong-parameters-of-others-taken" "A wrong Set_Prm of another master ends data exchange."
            => |d| d.slave.add(Replaced::new(|session, frame, service| {
                let is_wrong = service == SapService::Slave(SlaveSap::SET_PRM) && frame.data.get(4..6) != Some(&[0xFE, 0xED]);
                (session.exchanges && is_wrong).then(|| vec![of_owner(session, frame)])
            }));
        "wrong-parameters-in-exchange-ignored" "A wrong Set_Prm in data exchange is acknowledged and ignored."
            => |d| d.slave.add(Replaced::new(|session, frame, service| {
                let is_wrong = service == SapService::Slave(SlaveSap::SET_PRM) && frame.data.get(4..6) != Some(&[0xFE, 0xED]);
                Some(vec![session.nothing().filter(|_| session.exchanges && is_wrong)?])
            }));
        "locked-by-the-first-master" "Only the first master that sends parameters is served until the next power-on."
            => |d| d.slave.add(FirstMasterOnly::default());
        "watchdog-base-ignored" "WD_Base_1ms is ignored: the watchdog is counted in 10 ms."
            => |d| d.slave.add(InCentiseconds::default());
        "first-watchdog-factor-only" "The second watchdog factor is ignored."
            => |d| d.slave.set_prm(|prm| prm.wd_fact_2 = prm.wd_fact_2.min(1));
        "watchdog-fed-by-anybody" "A Slave_Diag of any master restarts the watchdog."
            => |d| d.slave.add(asked_before_others(SlaveSap::GET_CFG));
        "outputs-kept-after-the-watchdog" "After a new start-up the former outputs stay in force until others than 0 come."
            => |d| d.slave.add(OutputsOfBefore::default());

        // Configuration
        "configuration-not-checked" "Any configuration is accepted; a wrong one is treated as the first of the slave."
            => |d| d.slave.request(SlaveSap::CHK_CFG, |data| instead(data, |_| true));
        "surplus-identifiers-ignored" "Identifiers beyond those of the slave are ignored."
            => |d| d.slave.request(SlaveSap::CHK_CFG, |data| instead(data, |data| data.starts_with(CONFIGURATIONS[0])));
        "lengths-not-compared" "The lengths in the identifiers are not compared."
            => |d| d.slave.request(SlaveSap::CHK_CFG, |data| instead(data, |data| {
                data.iter().map(|octet| octet & 0xF0).eq(CONFIGURATIONS[0].iter().map(|octet| octet & 0xF0))
            }));
        "consistency-bit-ignored" "The consistency in the identifiers is not compared."
            => |d| d.slave.request(SlaveSap::CHK_CFG, |data| instead(data, |data| {
                data.iter().map(|octet| octet | 0x80).eq(CONFIGURATIONS[0].iter().copied())
            }));
        "identifiers-as-a-set" "The order of the identifiers is not compared."
            => |d| d.slave.request(SlaveSap::CHK_CFG, |data| instead(data, |data| data.iter().rev().eq(CONFIGURATIONS[0])));
        "first-configuration-refused" "The first Chk_Cfg after power-up is refused."
            => |d| {
                let mut is_first = true;
                d.slave.request(SlaveSap::CHK_CFG, move |data| {
                    if core::mem::take(&mut is_first) {
                        data.push(0);
                    }
                    true
                });
            };
        "configuration-of-others-taken" "A Chk_Cfg of another master is taken."
            => |d| d.slave.add(Replaced::new(|session, frame, service| {
                let is_taken = service == SapService::Slave(SlaveSap::CHK_CFG) && session.exchanges;
                is_taken.then(|| vec![of_owner(session, frame)])
            }));
        "configuration-in-exchange-ignored" "A Chk_Cfg in data exchange is acknowledged and ignored."
            => |d| d.slave.add(Replaced::new(|session, _, service| {
                let is_ignored = service == SapService::Slave(SlaveSap::CHK_CFG) && session.exchanges;
                Some(vec![session.nothing().filter(|_| is_ignored)?])
            }));
        "configuration-in-exchange-ends-it" "Each Chk_Cfg in data exchange ends it."
            => |d| d.slave.add(LeavesExchange::at(|telegram| is_service(telegram, SlaveSap::CHK_CFG)));
        "get-cfg-in-exchange-only" "Get_Cfg is answered in data exchange only."
            => |d| d.slave.add(Replaced::new(|session, frame, service| {
                let is_refused = service == SapService::Slave(SlaveSap::GET_CFG) && !session.exchanges;
                is_refused.then(|| vec![to_access_point(frame, UNUSED)])
            }));
        "get-cfg-without-identifiers" "Get_Cfg is answered without identifiers."
            => |d| d.slave.get_cfg(Vec::clear);
        "get-cfg-for-its-master-only" "Get_Cfg of another master is refused in data exchange."
            => |d| d.slave.add(Replaced::new(|session, frame, service| {
                let is_foreign = session.owner().is_some_and(|owner| owner != frame.sa);
                let is_refused = service == SapService::Slave(SlaveSap::GET_CFG) && is_foreign;
                is_refused.then(|| vec![to_access_point(frame, UNUSED)])
            }));

        // Data exchange
        "inputs-one-byte-short" "The last byte of the inputs is missing."
            => |d| d.slave.answer(|telegram| if let Some(frame) = frame(telegram) && is_exchange(&frame) {
                *telegram = with_data(&frame, &frame.data[..frame.data.len() - 1]);
            });
        "inputs-of-the-first-configuration" "The inputs always have the length of the first configuration."
            => |d| d.slave.answer(|telegram| if let Some(frame) = frame(telegram) && is_exchange(&frame) && frame.data.len() == 4 {
                let data = [frame.data, &[0, 0]].concat();
                *telegram = with_data(&frame, &data);
            });
        "exchange-with-anybody" "Data_Exchange of another master is served."
            => |d| d.slave.add(ExchangeWithAnybody::default());
        "output-bytes-exchanged" "The first two bytes of the outputs are swapped."
            => |d| d.slave.add(ChangedOutputs(|octets| if octets.len() > 1 { octets.swap(0, 1) }));
        "outputs-kept-without-data" "A Data_Exchange without outputs keeps the former ones in spite of Fail_Safe."
            => |d| d.slave.add(OutputsWithoutData::default());
        "polls-in-a-millisecond-missed" "After 500 polls that are less than 2 ms apart no such poll is answered."
            => |d| d.slave.add(SlowPolls::default());
        "diagnosis-fetched-by-anybody" "A Slave_Diag of any master ends the announcement of a diagnosis."
            => |d| d.slave.add(asked_before_others(SlaveSap::SLAVE_DIAG));
        "exchange-ends-by-itself" "After 700 cycles the slave leaves data exchange."
            => |d| {
                let mut cycles = 0;
                d.slave.add(LeavesExchange::at(move |telegram| {
                    cycles += u32::from(request(telegram).is_some_and(|(_, service)| service == SapService::DataExchange));
                    cycles == 700
                }));
            };

        // Global_Control
        "freeze-once" "A further Freeze does not renew the inputs."
            => |d| d.slave.global_control(first_only(GlobalCommand::FREEZE, GlobalCommand::UNFREEZE));
        "unfreeze-ignored" "Unfreeze is ignored."
            => |d| d.slave.global_control(|control| control.command.0 &= !GlobalCommand::UNFREEZE.0);
        "freeze-before-unfreeze" "With both Freeze and Unfreeze the inputs are held."
            => |d| d.slave.global_control(|control| first_prevails(control, GlobalCommand::FREEZE, GlobalCommand::UNFREEZE));
        "sync-once" "A further Sync does not pass the outputs."
            => |d| d.slave.global_control(first_only(GlobalCommand::SYNC, GlobalCommand::UNSYNC));
        "unsync-ignored" "Unsync is ignored."
            => |d| d.slave.global_control(|control| control.command.0 &= !GlobalCommand::UNSYNC.0);
        "sync-before-unsync" "With both Sync and Unsync the outputs are held."
            => |d| d.slave.global_control(|control| first_prevails(control, GlobalCommand::SYNC, GlobalCommand::UNSYNC));
        "clear-stays" "After a Clear the outputs stay 0 until the next power-on."
            => |d| {
                let mut is_clear = false;
                d.slave.global_control(move |control| {
                    is_clear |= control.command.has(GlobalCommand::CLEAR_DATA);
                    if is_clear {
                        control.command.0 |= GlobalCommand::CLEAR_DATA.0;
                    }
                });
            };
        "clear-waits-for-sync" "Clear has no effect while Sync holds the outputs."
            => |d| {
                let mut is_held = false;
                d.slave.global_control(move |control| {
                    is_held = (is_held || control.command.has(GlobalCommand::SYNC)) && !control.command.has(GlobalCommand::UNSYNC);
                    if is_held {
                        control.command.0 &= !GlobalCommand::CLEAR_DATA.0;
                    }
                });
            };
        "global-control-ends-exchange" "Each Global_Control ends data exchange."
            => |d| d.slave.add(LeavesExchange::at(|telegram| is_service(telegram, SlaveSap::GLOBAL_CONTROL)));
        "group-commands-ignored" "Only commands to all groups are obeyed."
            => |d| d.slave.check(|check, right| right && !matches!(check, SlaveStackCheck::Group(1..)));
        "group-0-ignored" "Commands to all groups are not obeyed."
            => |d| d.slave.check(|check, right| right && check != SlaveStackCheck::Group(0));
        "control-of-anybody" "A Global_Control of any master is obeyed."
            => |d| d.slave.add(Replaced::new(|session, frame, service| {
                (service == SapService::Slave(SlaveSap::GLOBAL_CONTROL)).then(|| vec![of_owner(session, frame)])
            }));
        "freeze-mode-never-shown" "The diagnosis does not report Freeze_Mode."
            => |d| d.slave.diagnosis(|diag, _| diag.status_2.0 &= !Status2::FREEZE_MODE.0);
        "sync-mode-never-shown" "The diagnosis does not report Sync_Mode."
            => |d| d.slave.diagnosis(|diag, _| diag.status_2.0 &= !Status2::SYNC_MODE.0);
        "freeze-survives-start" "After a new start-up the inputs are held again."
            => |d| d.slave.add(CommandOfBefore::new(|data| begins(data, GlobalCommand::FREEZE, GlobalCommand::UNFREEZE)));
        "sync-survives-start" "After a new start-up the outputs are held again."
            => |d| d.slave.add(CommandOfBefore::new(|data| begins(data, GlobalCommand::SYNC, GlobalCommand::UNSYNC)));

        // Diagnosis
        "cfg-fault-always-set" "Cfg_Fault is always set."
            => |d| d.slave.diagnosis(|diag, _| diag.status_1 = diag.status_1.with(Status1::CFG_FAULT));
        "prm-fault-always-set" "Prm_Fault is always set."
            => |d| d.slave.diagnosis(|diag, _| diag.status_1 = diag.status_1.with(Status1::PRM_FAULT));
        "not-supported-always-set" "Not_Supported is always set."
            => |d| d.slave.diagnosis(|diag, _| diag.status_1 = diag.status_1.with(Status1::NOT_SUPPORTED));
        "prm-req-in-exchange" "Prm_Req is set from the first data exchange on."
            => |d| d.slave.add(NeedsParametersInExchange::default());
        "reserved-bit-of-status-3-set" "Bit 0 of the third status byte is set."
            => |d| d.slave.diagnosis(|diag, _| diag.status_3.0 |= 1);
        "overflow-always-set" "Ext_Diag_Overflow is always set."
            => |d| d.slave.diagnosis(|diag, _| diag.status_3 = diag.status_3.with(Status3::EXT_DIAG_OVERFLOW));
        "diagnosis-too-long" "The diagnosis always has 32 bytes, more than the GSD says."
            => |d| d.slave.diagnosis(|diag, _| diag.ext.resize(26, 0));
        "ext-diag-stays" "Ext_Diag stays set after a fault has gone."
            => |d| stays(d, |diag| &mut diag.status_1.0, Status1::EXT_DIAG.0);
        "stat-diag-stays" "Stat_Diag stays set after the data are valid again."
            => |d| stays(d, |diag| &mut diag.status_2.0, Status2::STAT_DIAG.0);
        "stat-diag-never-set" "Stat_Diag is never set."
            => |d| d.slave.diagnosis(|diag, _| diag.status_2.0 &= !Status2::STAT_DIAG.0);
        "no-blocks" "The diagnosis has only its six fixed bytes."
            => |d| d.slave.diagnosis(|diag, _| diag.ext.clear());
        "one-fault-at-a-time" "Of several faults only the first is reported."
            => |d| d.slave.diagnosis(|diag, _| if diag.ext.len() > BLOCKS {
                (diag.ext[STATUS_BITS], diag.ext[MODULE_BITS]) = (1, 1);
                diag.ext.truncate(BLOCKS);
            });
        "faults-before-exchange-forgotten" "A fault that is present before data exchange is not reported."
            => |d| d.slave.add(ForgottenFaults::default());
        "device-block-without-itself" "The header of the device-related block does not count itself."
            => |d| in_blocks(d, |ext| ext[0] = 4);
        "gap-after-the-blocks" "A byte 0 follows the blocks."
            => |d| in_blocks(d, |ext| ext.push(0));
        "text-of-another-fault" "The device-related block sets the bit of the other fault."
            => |d| in_blocks(d, |ext| ext[STATUS_BITS] ^= 3);
        "module-of-another-fault" "The identifier-related block sets the bit of the other module."
            => |d| in_blocks(d, |ext| ext[MODULE_BITS] ^= 3);
        "channel-of-another-module" "The channel-related block names the other module."
            => |d| in_blocks(d, |ext| ext[CHANNEL] ^= 1);
        "error-of-another-kind" "The channel-related block names a short circuit as a broken wire and the reverse."
            => |d| in_blocks(d, |ext| ext[CHANNEL + 2] ^= 7);

        // Address
        "address-acknowledged-and-not-made" "Set_Slave_Address is acknowledged, and the address does not change."
            => |d| d.slave.check(|check, right| right && !matches!(check, SlaveStackCheck::NewAddress(_)));
        "answers-at-both-addresses" "After Set_Slave_Address the slave answers at the former address too."
            => |d| d.slave.add(FormerAddress::beside());
        "new-address-not-stored" "After a loss of power the slave is at its former address."
            => |d| d.slave.add(FormerAddress::after_power_off());
        "address-0-not-taken" "Address 0 is not taken as a new address."
            => |d| d.slave.check(|check, right| right && check != SlaveStackCheck::NewAddress(0));
        "address-given-once" "Only the first Set_Slave_Address is served."
            => |d| {
                let mut is_given = false;
                d.slave.check(move |check, right| if check == SlaveStackCheck::AddressService {
                    right && !core::mem::replace(&mut is_given, true)
                } else {
                    right
                });
            };
        "no-exchange-at-a-new-address" "After Set_Slave_Address each configuration is refused until the next power-on."
            => |d| {
                let is_new = Rc::new(Cell::new(false));
                let given = Rc::clone(&is_new);
                d.slave.set_slave_address(move |_| given.set(true));
                d.slave.request(SlaveSap::CHK_CFG, move |data| {
                    if is_new.get() {
                        data.push(0);
                    }
                    true
                });
            };
        "lock-ignored" "No_Add_Chg is ignored."
            => |d| d.slave.set_slave_address(|request| request.no_change = 0);
        "lock-lost-at-power-off" "No_Add_Chg is in force only until the next power-on."
            => |d| d.slave.add(LockUntilPowerOff::default());
        "address-126-not-served" "A slave at address 126 does not serve Set_Slave_Address."
            => |d| d.slave.check_with(|slave, check, right| right && (check != SlaveStackCheck::AddressService || slave.address() != 126));

        // Records
        "record-write-lost" "What is written to a record is read as 0."
            => |d| d.slave.record(|pdu| if let Dpv1Pdu::Write(record) = pdu && record.index == NOTE {
                record.data.fill(0);
            });
        "unknown-record-index-answered" "A read of an index that does not exist is answered with the note."
            => |d| d.slave.record(|pdu| if let Dpv1Pdu::Read(record) = pdu && record.index == UNKNOWN_INDEX {
                record.index = NOTE;
            });
        "record-slot-not-checked" "The slot of a record is not checked."
            => |d| d.slave.record(|pdu| if let Dpv1Pdu::Read(record) | Dpv1Pdu::Write(record) = pdu {
                record.slot = 0;
            });
        "record-length-not-checked" "Missing bytes of a record are taken as 0."
            => |d| d.slave.record(|pdu| if let Dpv1Pdu::Write(record) = pdu && record.index == NOTE {
                record.data.resize(4, 0);
                record.length = 4;
            });
        "read-only-record-taken" "A write of a read-only record is acknowledged."
            => |d| d.slave.record(|pdu| if let Dpv1Pdu::Write(record) = pdu && record.index == COUNT {
                (record.index, record.length, record.data) = (NOTE, 4, vec![0; 4]);
            });
        "one-record-error-for-all" "Each refused record has the error for a feature that is not supported."
            => |d| d.slave.answer(|telegram| if let Some(frame) = frame(telegram)
                && let [function @ (0xDE | 0xDF), decode, _, more] = *frame.data
            {
                *telegram = with_data(&frame, &[function, decode, RecordError::FEATURE_NOT_SUPPORTED.0, more]);
            });
        "records-before-exchange" "Records are served over MS1 without data exchange."
            => |d| d.slave.check(|check, right| right || matches!(check, SlaveStackCheck::Dpv1 | SlaveStackCheck::Class1(None)));
        "records-for-anybody" "Records are served over MS1 to any master."
            => |d| d.slave.check(|check, right| right || matches!(check, SlaveStackCheck::Class1(Some(_))));
        "im0-cut" "I&M0 has 54 bytes: the first ten are missing."
            => |d| identification(d, |data| {
                data.drain(8..18);
                data[3] -= 10;
            });
        "im0-version-0" "The version of the identification data is 0.0."
            => |d| identification(d, |data| data[IM_VERSION..IM_VERSION + 2].fill(0));
        "im1-lost" "What is written to I&M1 is blank when it is read."
            => |d| d.slave.record(|pdu| if let Dpv1Pdu::Write(record) = pdu && record.index == 255 && record.data.len() > 4 {
                record.data[4..].fill(b' ');
            });
        "any-im-record-answered" "Each I&M record is answered with I&M0."
            => |d| d.slave.add(AnyIdentification::default());
        "ms2-refused" "Initiate is refused."
            => |d| d.slave.add(Replaced::new(|_, frame, service| {
                (service == SapService::Slave(SlaveSap::RESOURCE_MANAGER)).then(|| vec![to_access_point(frame, UNUSED)])
            }));
        "ms2-write-lost" "What is written over MS2 is read as 0."
            => |d| d.slave.add(Replaced::new(|_, frame, service| class_2(frame, service, |data| if let [0x5F, _, NOTE, _, rest @ ..] = data { rest.fill(0) })));
        "unknown-ms2-index-answered" "A read over MS2 of an index that does not exist is answered with the note."
            => |d| d.slave.add(Replaced::new(|_, frame, service| class_2(frame, service, |data| if let [0x5E, _, index @ UNKNOWN_INDEX, ..] = data { *index = NOTE })));
        "im-over-ms1-only" "CALL is refused over MS2."
            => |d| d.slave.add(Replaced::new(|_, frame, service| class_2(frame, service, |data| if let [0x5E | 0x5F, _, index @ 0xFF, ..] = data { *index = UNKNOWN_INDEX })));
        "ms2-without-a-limit" "A second Initiate takes over the only connection."
            => |d| d.slave.add(ConnectionTakenOver::default());
        "ms2-abort-ignored" "Abort does not free a connection."
            => |d| d.slave.add(Replaced::new(|_, frame, service| class_2(frame, service, |data| if let [function @ 0x58, ..] = data { *function = 0x48 })));
        "ms2-never-times-out" "A connection ends only by Abort."
            => |d| d.slave.add(ConnectionWithoutEnd::default());
        "ms2-ends-exchange" "An Initiate ends data exchange."
            => |d| d.slave.add(LeavesExchange::at(|telegram| is_service(telegram, SlaveSap::RESOURCE_MANAGER)));
    },
}];

/// An access point that no service uses.
const UNUSED: u8 = 52;
/// Bytes of the blocks for one fault, and the places in them.
const BLOCKS: usize = 10;
const STATUS_BITS: usize = 4;
const MODULE_BITS: usize = 6;
const CHANNEL: usize = 7;
/// The records of the slave, and an index that it does not have.
const NOTE: u8 = 1;
const COUNT: u8 = 2;
const UNKNOWN_INDEX: u8 = 9;
/// The place of the version of the identification data in the response to a read.
const IM_VERSION: usize = 68;

/// Makes a configuration the first of the slave if it is none of its own and `is_taken`.
fn instead(data: &mut Vec<u8>, is_taken: impl Fn(&[u8]) -> bool) -> bool {
    if !CONFIGURATIONS.contains(&data.as_slice()) && is_taken(data) {
        *data = CONFIGURATIONS[0].to_vec();
    }
    true
}

/// Before each Slave_Diag of another master the owner asks at `point`.
fn asked_before_others(point: SlaveSap) -> impl SlaveHooks {
    Replaced::new(move |session, frame, service| {
        let is_foreign = service == SapService::Slave(SlaveSap::SLAVE_DIAG) && session.owner() != Some(frame.sa);
        let asked = asked_by_owner(session, frame.da, point).filter(|_| is_foreign)?;
        Some(vec![asked, with_data(frame, frame.data)])
    })
}

fn is_service(telegram: &[u8], of: SlaveSap) -> bool {
    request(telegram).is_some_and(|(_, service)| service == SapService::Slave(of))
}

/// Whether a frame is an answer with inputs.
fn is_exchange(frame: &DataFrame<'_>) -> bool {
    !frame.fc.is_request() && frame.source.is_empty() && !frame.data.is_empty()
}

fn first_prevails(control: &mut GlobalControl, first: GlobalCommand, second: GlobalCommand) {
    if control.command.has(first) {
        control.command.0 &= !second.0;
    }
}

/// Takes `begin` out of each Global_Control between the first one with it and one with `end`.
fn first_only(begin: GlobalCommand, end: GlobalCommand) -> impl FnMut(&mut GlobalControl) {
    let mut is_on = false;
    move |control| {
        let has = control.command.has(begin);
        if is_on {
            control.command.0 &= !begin.0;
        }
        is_on = (is_on || has) && !control.command.has(end);
    }
}

/// Whether a Global_Control begins a mode or ends it.
fn begins(data: &[u8], first: GlobalCommand, second: GlobalCommand) -> Option<bool> {
    let command = GlobalControl::parse(data).ok()?.command;
    if command.has(second) { Some(false) } else { command.has(first).then_some(true) }
}

/// Keeps a bit of the diagnosis once it was set.
fn stays(d: &mut crate::seams::Deviations, of: fn(&mut SlaveDiag) -> &mut u8, bit: u8) {
    let mut was_set = false;
    d.slave.diagnosis(move |diag, _| {
        let status = of(diag);
        was_set |= *status & bit != 0;
        *status |= if was_set { bit } else { 0 };
    });
}

/// Changes the blocks of a diagnosis with a fault.
fn in_blocks(d: &mut crate::seams::Deviations, change: fn(&mut Vec<u8>)) {
    d.slave.diagnosis(move |diag, _| {
        if diag.ext.len() >= BLOCKS {
            change(&mut diag.ext);
        }
    });
}

/// Changes the response to a read of I&M0 over MS1.
fn identification(d: &mut crate::seams::Deviations, change: fn(&mut Vec<u8>)) {
    d.slave.answer(move |telegram| {
        let Some(frame) = frame(telegram).filter(|frame| frame.source.sap == Some(SlaveSap::SERVER.0)) else { return };
        if let [0x5E, _, 0xFF, _, 0x08, 0x00, 0xFD, 0xE8, ..] = frame.data
            && frame.data.len() > IM_VERSION + 2
        {
            let mut data = frame.data.to_vec();
            change(&mut data);
            *telegram = with_data(&frame, &data);
        }
    });
}

/// Changes a request on a connection of a class 2 master.
fn class_2(frame: &DataFrame<'_>, service: SapService, change: fn(&mut [u8])) -> Option<Vec<Vec<u8>>> {
    if !matches!(service, SapService::Connection(_)) {
        return None;
    }
    let mut data = frame.data.to_vec();
    change(&mut data);
    Some(vec![with_data(frame, &data)])
}

/// Changes the outputs.
struct ChangedOutputs(fn(&mut Vec<u8>));

impl device_stack::profibus::SlaveHooks for ChangedOutputs {
    fn outputs(&mut self, outputs: &mut Option<Vec<u8>>) {
        if let Some(octets) = outputs {
            (self.0)(octets);
        }
    }
}
