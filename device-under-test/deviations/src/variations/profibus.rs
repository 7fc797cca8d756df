//! What a PROFIBUS slave may do, whatever the manual of the encoder says.

use super::profibus_state::{
    AcknowledgedForeigners, AnnouncedDiagnosis, BrieflyStoredAnswer, FirstDiagnoses, LongAcknowledgement,
    MaxTsdrOfTheRate, diagnosis_in_portions, jittering_bits,
};
use crate::needs::Need;
use crate::seams::slave::{diagnosis_response, frame, with_data};
use crate::tables::Group;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profibus::SlaveStackCheck;
use reference_devices::manuals;
use wire::profibus::diag::{Status1, Status2};
use wire::profibus::fdl::{AnswerFunction, BitTimes, DataFrame, FdlFormat, FdlFrame, FunctionCode, StationType};
use wire::profibus::prm::Dpv1Status1;
use wire::profibus::sap::{SapService, SlaveSap};

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profibus],
        deviations: permitted! {
            // Data link
            "answers-at-max-tsdr" "Answers come 60 bits after the request, the MaxTsdr of the GSD at every baud rate up to 500 kbit/s."
                "MaxTsdr of the GSD; IEC 61158-4-3, station delay of a responder"
                => |d| d.slave.delay(|min_tsdr| BitTimes(min_tsdr.0.max(60)));
            "answers-between-min-and-max-tsdr" "Answers come 37 bits after the request."
                "MaxTsdr of the GSD; IEC 61158-4-3, station delay of a responder"
                => |d| d.slave.delay(|min_tsdr| BitTimes(min_tsdr.0.max(37)));
            "station-delay-jitters" "The time from request to answer differs from telegram to telegram, from 11 to 60 bits."
                "MaxTsdr of the GSD; IEC 61158-4-3, station delay of a responder: any time between min TSDR and max TSDR"
                => |d| d.slave.delay(jittering_bits(11, 60));
            "station-delay-alternates" "Answers come alternately 11 and 60 bits after the request."
                "MaxTsdr of the GSD; IEC 61158-4-3, station delay of a responder: any time between min TSDR and max TSDR"
                => |d| {
                    let mut is_late = false;
                    d.slave.delay(move |min_tsdr| {
                        is_late = !is_late;
                        if is_late { BitTimes(min_tsdr.0.max(60)) } else { min_tsdr }
                    });
                };
            "station-delay-of-each-number" "The time from request to answer is 11 bits, then 12, and so on up to 60."
                "MaxTsdr of the GSD; IEC 61158-4-3, station delay of a responder: any time between min TSDR and max TSDR"
                => |d| {
                    let mut bits = 10;
                    d.slave.delay(move |min_tsdr| {
                        bits = if bits < 60 { bits + 1 } else { 11 };
                        BitTimes(min_tsdr.0.max(bits))
                    });
                };
            "answers-at-max-tsdr-of-the-rate" "Answers come as late as MaxTsdr of the GSD permits at the rate of the bus, for instance 100 bits at 500 kbit/s and 800 at 12 Mbit/s."
                "MaxTsdr of the GSD; IEC 61158-4-3, station delay of a responder; the slot time at these rates is longer"
                => |d| d.slave.add(MaxTsdrOfTheRate::default());
            "answer-stored-until-the-next-frame" "A repeated request gets the stored answer only if no other frame, for instance the token, came in between; else it is carried out."
                "IEC 61158-4-3, frame count bit: the answer is stored for a retry, and a master sends its retries right after the slot time"
                => |d| d.slave.add(BrieflyStoredAnswer::default());
            "long-acknowledgements" "A request without an answer is acknowledged by a frame without data (FC 00h) instead of E5h."
                "IEC 61158-4-3: the short acknowledgement E5h stands for an acknowledgement frame, and may be used instead"
                => |d| d.slave.add(LongAcknowledgement::default());
            "eight-bytes-in-a-fixed-frame" "A response with eight bytes after the function code is sent as a frame of fixed length (SD3)."
                "IEC 61158-4-3, frames of fixed length with data (SD3)"
                => |d| d.slave.answer(fixed_length);
            "diagnosis-with-high-priority" "The response to Slave_Diag has high priority (FC 0Ah)."
                "IEC 61158-4-3: DL and DH are both responses with data; IEC 61158-6-3 gives DH a meaning in Data_Exchange only"
                => |d| d.slave.answer(|telegram| if diagnosis_response(telegram).is_some() {
                    set_function(telegram, AnswerFunction::DATA_HIGH);
                });
            "other-responses-with-high-priority" "The responses to Get_Cfg, RD_Inp, RD_Outp and to a poll for a record have high priority (FC 0Ah)."
                "IEC 61158-4-3: DL and DH are both responses with data; IEC 61158-6-3 gives DH a meaning in Data_Exchange only"
                => |d| d.slave.answer(|telegram| if is_response_of_a_service(telegram) {
                    set_function(telegram, AnswerFunction::DATA_HIGH);
                });

            // Start-up
            "boots-at-once" "The slave answers 20 ms after power-up."
                "the manuals print no time from power-up to the first answer"
                => |d| d.slave.boot_time(|_| Duration::from_millis(20));
            "boots-slowly" "The slave answers 4 s after power-up."
                "the manuals print no time from power-up to the first answer"
                => |d| d.slave.boot_time(|_| Duration::from_secs(4));
            "ready-after-30-ms" "After a valid Chk_Cfg the slave reports Station_Not_Ready for 30 ms."
                "IEC 61158-6-3, Station_Not_Ready: set until the slave is ready for data exchange; no time is given"
                => |d| d.slave.ready_time(|_| Duration::from_millis(30));
            "ready-after-2-s" "After a valid Chk_Cfg the slave reports Station_Not_Ready for 2 s."
                "IEC 61158-6-3, Station_Not_Ready: set until the slave is ready for data exchange; no time is given"
                => |d| d.slave.ready_time(|_| Duration::from_secs(2));
            "ready-time-jitters" "After a valid Chk_Cfg the slave reports Station_Not_Ready for 0 to 60 ms, each time for another time."
                "IEC 61158-6-3, Station_Not_Ready: set until the slave is ready for data exchange; no time is given"
                => |d| {
                    let mut bits = jittering_bits(0, 60);
                    d.slave.ready_time(move |_| Duration::from_millis(bits(BitTimes(0)).0));
                };
            "static-diagnosis-at-start" "The first three diagnoses after a valid Chk_Cfg have Stat_Diag: there are no valid data yet."
                "IEC 61158-6-3, Stat_Diag: the master reads the diagnosis until the bit is 0"
                => |d| d.slave.add(FirstDiagnoses::of_exchange(3));
            "static-diagnosis-before-exchange" "Before data exchange the diagnosis has Stat_Diag: there are no valid data."
                "IEC 61158-6-3, Stat_Diag: set while the slave has no valid data"
                => |d| d.slave.diagnosis(|diag, _| if diag.status_1.has(Status1::STATION_NOT_READY) {
                    diag.status_2 = diag.status_2.with(Status2::STAT_DIAG);
                });
            "short-diagnosis-before-parameters" "Before Set_Prm the diagnosis has only its six fixed bytes."
                "IEC 61158-6-3, Slave_Diag: Ext_Diag_Data is optional"
                => |d| d.slave.diagnosis(|diag, _| if diag.status_2.has(Status2::PRM_REQ) {
                    diag.ext.clear();
                    diag.status_1.0 &= !Status1::EXT_DIAG.0;
                });
            "other-masters-acknowledged" "Set_Prm and Chk_Cfg of a master that does not own the slave are acknowledged, and have no effect."
                "IEC 61158-6-3, MSCY1S: a slave ignores Set_Prm of another master; the acknowledgement is one of the data link"
                => |d| d.slave.add(AcknowledgedForeigners::default());

            // Data exchange
            "fail-safe-without-its-bit" "A Data_Exchange without data clears the outputs, whatever Set_Prm says of Fail_Safe."
                "Fail_Safe of the GSD: in Clear the slave takes telegrams without data; the bit of Set_Prm came with DP-V1"
                => |d| d.slave.set_prm(|prm| if let Some(first) = prm.user.first_mut() { *first |= Dpv1Status1::FAIL_SAFE.0 });
            "diagnosis-announced-at-start" "The first answers in data exchange have high priority (FC 0Ah), until the diagnosis is read."
                "IEC 61158-6-3, Data_Exchange: DH while there is a diagnosis that the master has not read; when it is new, is the slave's choice"
                => |d| d.slave.add(AnnouncedDiagnosis::once());
            "inputs-one-cycle-old" "An answer has the inputs of the cycle before: the buffer of the slave was filled after the last answer."
                "no clause sets the age of the inputs; IEC 61158-6-3 lets a slave answer from a buffer"
                => |d| d.slave.inputs_old(1);
            "inputs-two-cycles-old" "An answer has the inputs of two cycles before, from two buffers in a row."
                "no clause sets the age of the inputs; IEC 61158-6-3 lets a slave answer from a buffer"
                => |d| d.slave.inputs_old(2);
            "outputs-one-cycle-late" "The encoder takes the outputs of a cycle in the next one."
                "no clause sets when outputs take effect; IEC 61158-6-3 lets a slave take them from a buffer"
                => |d| d.slave.outputs_late(1);
            "inputs-and-outputs-not-read" "RD_Inp and RD_Outp are answered by RS: the slave does not have these services."
                "EN 50170: RD_Inp and RD_Outp are optional services of a slave"
                => |d| d.slave.check(|check, right| right && check != SlaveStackCheck::ReadServices);
        },
    },
    // The GSD of the generic slave says what it has.
    Group {
        needs: &[Need::Profibus, Need::Encoder],
        deviations: permitted! {
            "without-fail-safe" "A Data_Exchange without data has the wrong length, whatever Set_Prm says of Fail_Safe."
                "Fail_Safe of the GSD may be 0: the manuals print no GSD"
                => |d| d.slave.set_prm(|prm| if let Some(first) = prm.user.first_mut() { *first &= !Dpv1Status1::FAIL_SAFE.0 });
        },
    },
    // The A3M60 announces each change of its diagnosis.
    Group {
        needs: &[Need::OfEither(&manuals::DATALOGIC_AMT58, &manuals::DP_SLAVE)],
        deviations: permitted! {
            "diagnosis-announced-again" "After every 100 answers in data exchange the slave announces its diagnosis (FC 0Ah), although it is the same."
                "IEC 61158-6-3, Data_Exchange: DH while there is a diagnosis that the master has not read; when it is new, is the slave's choice"
                => |d| d.slave.add(AnnouncedDiagnosis::every(100));
        },
    },
    Group {
        needs: &[Need::Of(&manuals::DP_SLAVE)],
        deviations: permitted! {
            "alarm-with-data" "An alarm has two more bytes after its specifier."
                "IEC 61158-6-3, Alarm-PDU: up to 59 bytes of Diagnostic_User_Data after the specifier"
                => |d| d.slave.diagnosis(|diag, _| if let [4, kind @ ..0x80, slot, specifier] = *diag.ext.as_slice() {
                    diag.ext = [6, kind, slot, specifier, 0x12, 0x34].to_vec();
                });
            "alarm-after-the-other-blocks" "An alarm is the last block of the diagnosis."
                "IEC 61158-6-3, Ext_Diag_Data: the blocks come in any order"
                => |d| d.slave.diagnosis(|diag, _| if let [4, ..0x80, ..] = diag.ext.as_slice() {
                    diag.ext.rotate_left(4);
                });
        },
    },
    // The others have these modes.
    Group {
        needs: &[Need::Of(&manuals::DATALOGIC_AMT58)],
        deviations: permitted! {
            "without-sync-and-freeze" "The slave has neither Sync nor Freeze, and reports Not_Supported when Set_Prm requests one of them."
                "Freeze_Mode_supp and Sync_Mode_supp of the GSD may be 0; the manual prints no GSD"
                => |d| d.slave.check(|check, right| right && check != SlaveStackCheck::Modes);
        },
    },
    Group {
        needs: &[Need::Of(&manuals::SICK_A3M60)],
        deviations: permitted! {
            "diagnosis-in-portions" "A diagnosis with several blocks is sent in turns, a block in each response, with Ext_Diag_Overflow."
                "IEC 61158-6-3, Ext_Diag_Overflow: more diagnoses than fit; section 5.4.1 prints no highest length (Max_Diag_Data_Len of the GSD)"
                => |d| d.slave.diagnosis(diagnosis_in_portions(3));
        },
    },
    Group {
        needs: &[Need::OfEither(&manuals::SICK_A3M60, &manuals::DP_SLAVE)],
        deviations: permitted! {
            "records-at-once" "The response to a record is available for the first poll."
                "IEC 61158-6-3, MS1 and MS2: the master polls until the response is available; no time is given"
                => |d| d.slave.record_time(|_| Duration::ZERO);
            "records-after-80-ms" "Polls for the response to a record are answered by E5h for 80 ms."
                "IEC 61158-6-3, MS1 and MS2: the master polls until the response is available; no time is given"
                => |d| d.slave.record_time(|_| Duration::from_millis(80));
            "record-time-jitters" "Polls for the response to a record are answered by E5h for 0 to 40 ms, each time for another time."
                "IEC 61158-6-3, MS1 and MS2: the master polls until the response is available; no time is given"
                => |d| {
                    let mut bits = jittering_bits(0, 40);
                    d.slave.record_time(move |_| Duration::from_millis(bits(BitTimes(0)).0));
                };
        },
    },
];

/// Whether a telegram is the response of a service other than Data_Exchange and Slave_Diag.
fn is_response_of_a_service(telegram: &[u8]) -> bool {
    frame(telegram).is_some_and(|frame| {
        let has_data = frame.fc.answered().is_some_and(AnswerFunction::has_data);
        let is_other =
            !matches!(SapService::of(&frame), SapService::DataExchange | SapService::Slave(SlaveSap::SLAVE_DIAG));
        has_data && is_other
    })
}

/// Replaces the function of a response.
pub(super) fn set_function(telegram: &mut Vec<u8>, function: AnswerFunction) {
    let Some(frame) = frame(telegram) else { return };
    let fc = FunctionCode::answer(function, StationType::SLAVE);
    *telegram = with_data(&DataFrame { fc, ..frame }, frame.data);
}

/// Sends a frame with eight bytes after the function code as one of fixed length.
fn fixed_length(telegram: &mut Vec<u8>) {
    let Some(frame) = frame(telegram).filter(|frame| frame.format == FdlFormat::Variable) else { return };
    // Extensions of the addresses count among the eight bytes.
    if telegram.len() != VARIABLE_WITH_EIGHT {
        return;
    }
    let mut fixed = Vec::new();
    FdlFrame::Data(DataFrame { format: FdlFormat::EightOctets, ..frame }).write(&mut fixed);
    *telegram = fixed;
}

/// Four bytes of header, DA, SA, FC, eight bytes, FCS and ED.
const VARIABLE_WITH_EIGHT: usize = 17;
