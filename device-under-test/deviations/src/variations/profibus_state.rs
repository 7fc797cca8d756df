//! Permitted variations of a PROFIBUS slave that have state.

use super::profibus::set_function;
use crate::seams::slave::{diagnosis_response, frame, request, with_data};
use alloc::vec;
use alloc::vec::Vec;
use device_stack::profibus::{SlaveApplication, SlaveHooks, SlaveStackCheck};
use wire::profibus::cfg::IoLengths;
use wire::profibus::diag::{SlaveDiag, Status1, Status2, Status3};
use wire::profibus::fdl::{
    AnswerFunction, BitTimes, DataFrame, Extension, FdlFormat, FdlFrame, FunctionCode, StationType,
};
use wire::profibus::sap::{SapService, SlaveSap};

/// A time that differs each time, in no order, from `least` to `most`; at least the given one.
pub(super) fn jittering_bits(least: u64, most: u64) -> impl FnMut(BitTimes) -> BitTimes + 'static {
    let mut state = 1_u32;
    move |right| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let way = u64::from(state >> 16) % (most - least + 1);
        BitTimes(right.0.max(least + way))
    }
}

/// Acknowledges by a frame without data.
#[derive(Default)]
pub(super) struct LongAcknowledgement {
    /// The master of the last request, and the address to which it was sent.
    asked: Option<(u8, u8)>,
}

impl SlaveHooks for LongAcknowledgement {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        self.asked = request(telegram).map(|(frame, _)| (frame.sa, frame.da));
        vec![telegram.to_vec()]
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        let (Ok(FdlFrame::ShortAcknowledgement), Some((da, sa))) = (FdlFrame::parse(telegram), self.asked) else {
            return;
        };
        let fc = FunctionCode::answer(AnswerFunction::OK, StationType::SLAVE);
        let none = Extension::NONE;
        telegram.clear();
        let frame = DataFrame { format: FdlFormat::NoData, da, sa, fc, destination: none, source: none, data: &[] };
        FdlFrame::Data(frame).write(telegram);
    }
}

/// Acknowledges Set_Prm and Chk_Cfg of a master that does not own the slave.
#[derive(Default)]
pub(super) struct AcknowledgedForeigners {
    is_parameter_service: bool,
    is_owned: bool,
}

impl SlaveHooks for AcknowledgedForeigners {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let service = request(telegram).map(|(_, service)| service);
        let of = [SlaveSap::SET_PRM, SlaveSap::CHK_CFG].map(|sap| Some(SapService::Slave(sap)));
        self.is_parameter_service = of.contains(&service);
        vec![telegram.to_vec()]
    }

    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        match check {
            SlaveStackCheck::Master(_) => self.is_owned = !verdict,
            // A slave in Wait_Prm has no owner.
            SlaveStackCheck::Order => self.is_owned = verdict,
            _ => {}
        }
        verdict
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        let is_refused = frame(telegram).and_then(|frame| frame.fc.answered()) == Some(AnswerFunction::NO_SERVICE);
        if is_refused && self.is_parameter_service && self.is_owned {
            telegram.clear();
            FdlFrame::ShortAcknowledgement.write(telegram);
        }
    }
}

/// Sets Stat_Diag in the first diagnoses of a data exchange.
pub(super) struct FirstDiagnoses {
    count: u32,
    left: u32,
}

impl FirstDiagnoses {
    /// In the first `count` diagnoses of each data exchange.
    pub fn of_exchange(count: u32) -> FirstDiagnoses {
        FirstDiagnoses { count, left: 0 }
    }
}

impl SlaveHooks for FirstDiagnoses {
    fn configuration(&mut self, _: &dyn SlaveApplication, _: &[u8], right: Option<IoLengths>) -> Option<IoLengths> {
        self.left = if right.is_some() { self.count } else { 0 };
        right
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        let Some((frame, mut diagnosis)) = diagnosis_response(telegram) else { return };
        if self.left == 0 || diagnosis.status_1.has(Status1::STATION_NOT_READY) {
            return;
        }
        self.left -= 1;
        diagnosis.status_2 = diagnosis.status_2.with(Status2::STAT_DIAG);
        let mut data = Vec::new();
        diagnosis.write(&mut data);
        *telegram = with_data(&frame, &data);
    }
}

/// Announces the diagnosis in Data_Exchange by high priority until it is read.
pub(super) struct AnnouncedDiagnosis {
    /// After how many answers it is announced again; `None` for the first answer of a data exchange only.
    every: Option<u32>,
    answers: u32,
    is_pending: bool,
    /// Whether the request repeats the one before: its answer is the same again.
    is_repetition: bool,
}

impl AnnouncedDiagnosis {
    /// When data exchange begins.
    pub fn once() -> AnnouncedDiagnosis {
        AnnouncedDiagnosis { every: None, answers: 0, is_pending: false, is_repetition: false }
    }

    /// After each `every` answers.
    pub fn every(every: u32) -> AnnouncedDiagnosis {
        AnnouncedDiagnosis { every: Some(every), answers: 0, is_pending: false, is_repetition: false }
    }
}

impl SlaveHooks for AnnouncedDiagnosis {
    fn configuration(&mut self, _: &dyn SlaveApplication, _: &[u8], right: Option<IoLengths>) -> Option<IoLengths> {
        (self.answers, self.is_pending) = (0, false);
        right
    }

    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        if check == SlaveStackCheck::Repetition {
            self.is_repetition = verdict;
        }
        verdict
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if diagnosis_response(telegram).is_some() {
            self.is_pending = false;
            return;
        }
        let is_exchange = frame(telegram).is_some_and(|frame| {
            SapService::of(&frame) == SapService::DataExchange
                && frame.fc.answered().is_some_and(AnswerFunction::has_data)
        });
        if !is_exchange {
            return;
        }
        self.answers += u32::from(!self.is_repetition);
        match self.every {
            _ if self.is_repetition => {}
            Some(every) if self.answers >= every => (self.answers, self.is_pending) = (0, true),
            None if self.answers == 1 => self.is_pending = true,
            _ => {}
        }
        if self.is_pending {
            set_function(telegram, AnswerFunction::DATA_HIGH);
        }
    }
}

/// Stores an answer only until the next frame on the bus.
#[derive(Default)]
pub(super) struct BrieflyStoredAnswer {
    last: Vec<u8>,
    is_next: bool,
}

impl SlaveHooks for BrieflyStoredAnswer {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        self.is_next = self.last == telegram;
        self.last.clear();
        self.last.extend_from_slice(telegram);
        vec![telegram.to_vec()]
    }

    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        verdict && (check != SlaveStackCheck::Repetition || self.is_next)
    }
}

/// Answers at the MaxTsdr that the GSD has for the rate of the bus.
#[derive(Default)]
pub(super) struct MaxTsdrOfTheRate {
    rate: u32,
}

impl SlaveHooks for MaxTsdrOfTheRate {
    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        if let SlaveStackCheck::Rate(rate) = check {
            self.rate = rate;
        }
        verdict
    }

    fn delay(&mut self, right: BitTimes) -> BitTimes {
        let most = match self.rate {
            45_450 | 3_000_000 => 250,
            500_000 => 100,
            1_500_000 => 150,
            6_000_000 => 450,
            12_000_000 => 800,
            _ => 60,
        };
        BitTimes(right.0.max(most))
    }
}

/// Sends one block of the diagnosis after the other, each with Ext_Diag_Overflow.
pub(super) fn diagnosis_in_portions(octets: usize) -> impl FnMut(&mut SlaveDiag, &DataFrame<'_>) + 'static {
    let mut turn = 0_usize;
    move |diagnosis, _| {
        if diagnosis.ext.len() <= octets {
            return;
        }
        turn = (turn + 1) % diagnosis.ext.len().div_ceil(octets);
        diagnosis.ext = diagnosis.ext.chunks(octets).nth(turn).unwrap_or_default().to_vec();
        diagnosis.status_3 = diagnosis.status_3.with(Status3::EXT_DIAG_OVERFLOW);
    }
}
