//! What a burst on the bus is: it decides when the next frame may begin.

use wire::profibus::fdl::{BitTimes, DataFrame, FdlFrame, RequestFunction};
use wire::profibus::sap::SlaveSap;

/// Byte of Set_Prm with min TSDR (IEC 61158-6-3, Set_Prm).
const MIN_TSDR_AT: usize = 3;

/// The role of a frame on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BurstRole {
    /// A request with an answer.
    Request(AskedService),
    /// A request without an answer, or the token.
    Unanswered,
    Answer(AnswerKind),
    /// Not a frame.
    Noise,
}

/// The service of a request with an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AskedService {
    SetPrm(SentParameters),
    DataExchange { slave: u8, master: u8 },
    Other { station: u8 },
}

/// What a Set_Prm says of the time until an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SentParameters {
    pub slave: u8,
    pub master: u8,
    pub min_tsdr: BitTimes,
}

/// The kind of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AnswerKind {
    ShortAcknowledgement,
    Data,
    NoData,
}

impl BurstRole {
    pub fn of(octets: &[u8]) -> BurstRole {
        match FdlFrame::parse(octets) {
            Ok(FdlFrame::Data(frame)) => match (frame.fc.requested(), frame.fc.answered()) {
                (Some(function), _) if function.expects_response() => BurstRole::Request(AskedService::of(&frame)),
                (Some(_), _) => BurstRole::Unanswered,
                (None, Some(function)) if function.has_data() => BurstRole::Answer(AnswerKind::Data),
                (None, _) => BurstRole::Answer(AnswerKind::NoData),
            },
            Ok(FdlFrame::Token { .. }) => BurstRole::Unanswered,
            Ok(FdlFrame::ShortAcknowledgement) => BurstRole::Answer(AnswerKind::ShortAcknowledgement),
            Err(_) => BurstRole::Noise,
        }
    }

    /// Whether a station must answer it.
    pub fn expects_answer(self) -> bool {
        matches!(self, BurstRole::Request(_))
    }
}

impl AskedService {
    fn of(frame: &DataFrame<'_>) -> AskedService {
        let access_point = frame.destination.sap.map(SlaveSap);
        match (access_point, frame.data.get(MIN_TSDR_AT)) {
            (Some(SlaveSap::SET_PRM), Some(&bits)) => {
                let min_tsdr = BitTimes(bits.into());
                AskedService::SetPrm(SentParameters { slave: frame.da, master: frame.sa, min_tsdr })
            }
            (None, _) if matches!(frame.fc.requested(), Some(RequestFunction::SRD_LOW | RequestFunction::SRD_HIGH)) => {
                AskedService::DataExchange { slave: frame.da, master: frame.sa }
            }
            _ => AskedService::Other { station: frame.da },
        }
    }

    /// The station that is asked.
    pub fn station(self) -> u8 {
        match self {
            AskedService::SetPrm(SentParameters { slave, .. }) | AskedService::DataExchange { slave, .. } => slave,
            AskedService::Other { station } => station,
        }
    }
}
