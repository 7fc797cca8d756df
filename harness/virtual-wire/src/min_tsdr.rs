//! The min TSDR of each station: 11 bit times until a Set_Prm gives it a longer one.

use crate::burst_role::{AnswerKind, AskedService, BurstRole, SentParameters};
use wire::profibus::fdl::BitTimes;

/// The min TSDR of each station, as far as the frames on the bus prove that it is in force.
///
/// A Set_Prm can be acknowledged and refused afterwards. It is in force once the slave answers a Data_Exchange of the master that
/// sent it; until then 11 bit times count, and also once the slave has not answered a request, since its power may have been off.
#[derive(Debug, Default)]
pub(crate) struct MinTsdrs {
    /// The stations with another than the default.
    in_force: Vec<(u8, BitTimes)>,
    /// The min TSDR of the last Set_Prm that each station acknowledged, in force or not.
    given: Vec<(u8, BitTimes)>,
    /// The last acknowledged Set_Prm.
    acknowledged: Option<SentParameters>,
    /// The request whose answer comes next.
    asked: Option<AskedService>,
}

impl MinTsdrs {
    /// The least time until the answer to the last request.
    pub(crate) fn of_next_answer(&self) -> BitTimes {
        self.of_asked(&self.in_force)
    }

    /// The longest min TSDR that the asked station may obey: that of an acknowledged Set_Prm, which it need not have refused.
    pub(crate) fn longest_of_next_answer(&self) -> BitTimes {
        self.of_next_answer().max(self.of_asked(&self.given))
    }

    fn of_asked(&self, times: &[(u8, BitTimes)]) -> BitTimes {
        let asked = self.asked.map(AskedService::station);
        let own = times.iter().find(|(known, _)| Some(*known) == asked);
        own.map_or(BitTimes::DEFAULT_MIN_TSDR, |(_, bits)| *bits)
    }

    /// Takes a frame that has ended on the bus.
    pub(crate) fn observe(&mut self, frame: BurstRole) {
        match (frame, self.asked.take()) {
            (BurstRole::Request(_) | BurstRole::Unanswered, before) => {
                if let Some(silent) = before {
                    self.put(silent.station(), BitTimes::DEFAULT_MIN_TSDR);
                }
                self.asked = match frame {
                    BurstRole::Request(asked) => Some(asked),
                    _ => None,
                };
            }
            (BurstRole::Answer(AnswerKind::ShortAcknowledgement), Some(AskedService::SetPrm(sent))) => {
                self.put(sent.slave, BitTimes::DEFAULT_MIN_TSDR);
                self.given.retain(|(known, _)| *known != sent.slave);
                self.given.push((sent.slave, sent.min_tsdr));
                self.acknowledged = Some(sent);
            }
            // A slave without inputs acknowledges its outputs by E5h.
            (
                BurstRole::Answer(AnswerKind::ShortAcknowledgement | AnswerKind::Data),
                Some(AskedService::DataExchange { slave, master }),
            ) => {
                let sent = self.acknowledged.take_if(|sent| (sent.slave, sent.master) == (slave, master));
                if let Some(SentParameters { min_tsdr, .. }) = sent {
                    self.put(slave, min_tsdr);
                }
            }
            _ => {}
        }
    }

    fn put(&mut self, station: u8, min_tsdr: BitTimes) {
        self.in_force.retain(|(known, _)| *known != station);
        if min_tsdr > BitTimes::DEFAULT_MIN_TSDR {
            self.in_force.push((station, min_tsdr));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;
    use wire::profibus::fdl::{
        AnswerFunction, DataFrame, Extension, FrameCount, FunctionCode, RequestFunction, StationType,
    };

    const MASTER: u8 = 1;
    const OTHER_MASTER: u8 = 2;
    const SLAVE: u8 = 8;

    fn frame(to: (u8, Extension), from: (u8, Extension), fc: FunctionCode, data: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        DataFrame::new(to, from, fc, data).write(&mut out);
        out
    }

    fn request() -> FunctionCode {
        FunctionCode::request(RequestFunction::SRD_HIGH, FrameCount::Zero)
    }

    fn set_prm(master: u8, min_tsdr: u8) -> Vec<u8> {
        let data = [0x88, 20, 5, min_tsdr, 0x16, 0x55, 0];
        frame((SLAVE, Extension::sap(61)), (master, Extension::sap(62)), request(), &data)
    }

    fn data_exchange(master: u8) -> Vec<u8> {
        frame((SLAVE, Extension::NONE), (master, Extension::NONE), request(), &[0, 0])
    }

    fn inputs(master: u8) -> Vec<u8> {
        let fc = FunctionCode::answer(AnswerFunction::DATA_LOW, StationType::SLAVE);
        frame((master, Extension::NONE), (SLAVE, Extension::NONE), fc, &[0, 0])
    }

    fn not_ready(master: u8) -> Vec<u8> {
        let fc = FunctionCode::answer(AnswerFunction::NO_SERVICE, StationType::SLAVE);
        frame((master, Extension::NONE), (SLAVE, Extension::NONE), fc, &[])
    }

    const E5: &[u8] = &[0xE5];

    #[rstest]
    #[case::before_any([].into(), 11)]
    #[case::acknowledged_only([set_prm(MASTER, 60), E5.into()].into(), 11)]
    #[case::in_data_exchange([set_prm(MASTER, 60), E5.into(), data_exchange(MASTER), inputs(MASTER)].into(), 60)]
    #[case::without_inputs([set_prm(MASTER, 60), E5.into(), data_exchange(MASTER), E5.into()].into(), 60)]
    #[case::refused([set_prm(MASTER, 60), E5.into(), data_exchange(MASTER), not_ready(MASTER)].into(), 11)]
    #[case::of_another_master([set_prm(OTHER_MASTER, 60), E5.into(), data_exchange(MASTER), inputs(MASTER)].into(), 11)]
    #[case::below_the_least([set_prm(MASTER, 0), E5.into(), data_exchange(MASTER), inputs(MASTER)].into(), 11)]
    #[case::replaced(
        [set_prm(MASTER, 60), E5.into(), data_exchange(MASTER), inputs(MASTER), set_prm(MASTER, 0), E5.into()].into(), 11
    )]
    #[case::silent(
        [set_prm(MASTER, 60), E5.into(), data_exchange(MASTER), inputs(MASTER), data_exchange(MASTER)].into(), 11
    )]
    fn a_set_prm_counts_once_data_exchange_is_answered(#[case] frames: Vec<Vec<u8>>, #[case] bits: u64) {
        let mut times = MinTsdrs::default();
        for octets in frames {
            times.observe(BurstRole::of(&octets));
        }
        times.observe(BurstRole::of(&data_exchange(MASTER)));
        assert_eq!(times.of_next_answer(), BitTimes(bits));
    }

    #[rstest]
    #[case::before_any([].into(), 11)]
    #[case::acknowledged_only([set_prm(MASTER, 255), E5.into()].into(), 255)]
    #[case::refused([set_prm(MASTER, 255), E5.into(), data_exchange(MASTER), not_ready(MASTER)].into(), 255)]
    #[case::silent([set_prm(MASTER, 255), E5.into(), data_exchange(MASTER)].into(), 255)]
    #[case::replaced([set_prm(MASTER, 255), E5.into(), set_prm(MASTER, 0), E5.into()].into(), 11)]
    #[case::not_acknowledged([set_prm(MASTER, 255)].into(), 11)]
    fn a_slave_may_obey_what_it_has_acknowledged(#[case] frames: Vec<Vec<u8>>, #[case] bits: u64) {
        let mut times = MinTsdrs::default();
        for octets in frames {
            times.observe(BurstRole::of(&octets));
        }
        times.observe(BurstRole::of(&data_exchange(MASTER)));
        assert_eq!(times.longest_of_next_answer(), BitTimes(bits));
    }
}
