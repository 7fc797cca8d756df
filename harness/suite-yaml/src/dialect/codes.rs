//! Words of refusals: the tables that a service has on either bus, and which numbers a word stands for.

use controllers::profinet_io::ConnectField;
use suite::model::Code;
use wire::profibus::dpv1::Dpv1AbortReason;
use wire::profibus::fdl::AnswerFunction;
use wire::profidrive::ErrorNumber;
use wire::profinet::dcp::BlockError;
use wire::profinet::status::{CmrpcError, ErrorDecode, ErrorSource, RecordError};

/// What refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Service {
    /// Base mode parameter access, or the records that carry it.
    Parameters,
    /// A record.
    Record,
    /// DCP.
    Station,
    /// A service of PROFIBUS.
    Dp,
    /// A start-up.
    Connect,
    /// It is not known beforehand: the last answer.
    Last,
}

/// The answers of the data link that are no acceptance: the service is missing, or the data was not accepted.
const REFUSALS: [AnswerFunction; 6] = [
    AnswerFunction::USER_ERROR,
    AnswerFunction::NO_RESOURCE,
    AnswerFunction::NO_SERVICE,
    AnswerFunction::NO_DATA,
    AnswerFunction::NO_RESOURCE_DATA_LOW,
    AnswerFunction::NO_RESOURCE_DATA_HIGH,
];

/// Tables of words for codes, each with the name that it has in messages.
pub(crate) type Tables = Vec<(&'static str, Vec<(&'static str, Code)>)>;

fn parameter() -> impl Iterator<Item = (&'static str, Code)> {
    ErrorNumber::TABLE.iter().map(|(code, word, _)| (*word, Code::Parameter(code.0, (*word).to_owned())))
}

/// The tables of a service on PROFIBUS.
pub(crate) fn on_profibus(service: Service) -> Tables {
    let fdl = || {
        let refusals = AnswerFunction::TABLE.iter().filter(|(function, ..)| REFUSALS.contains(function));
        refusals.map(|(function, word, _)| (*word, Code::Fdl(function.0, (*word).to_owned()))).collect::<Vec<_>>()
    };
    let dpv1 = || {
        let all = RecordError::TABLE.iter();
        all.map(|(code, word, _)| (*word, Code::Dpv1 { code1: code.0, word: (*word).to_owned() })).collect::<Vec<_>>()
    };
    let both = [("FDL answer", fdl()), ("DP-V1", dpv1())];
    match service {
        Service::Parameters | Service::Last => {
            [("PROFIdrive", parameter().collect())].into_iter().chain(both).collect()
        }
        Service::Dp => {
            let all = Dpv1AbortReason::TABLE.iter();
            let abort = all.map(|(code, word, _)| (*word, Code::Abort(code.0, (*word).to_owned()))).collect();
            both.into_iter().chain([("Abort of MS2", abort)]).collect()
        }
        Service::Record | Service::Station | Service::Connect => both.into(),
    }
}

/// The tables of a service on PROFINET.
pub(crate) fn on_profinet(service: Service) -> Tables {
    let record = || {
        RecordError::TABLE.iter().map(|(code, word, _)| {
            (*word, Code::Pnio { decode: ErrorDecode::PNIORW.0, code1: code.0, code2: None, word: (*word).to_owned() })
        })
    };
    let finder = || {
        ErrorSource::TABLE.iter().map(|(code, word, _)| {
            (*word, Code::Pnio { decode: ErrorDecode::PNIO.0, code1: code.0, code2: None, word: (*word).to_owned() })
        })
    };
    let cmrpc = || {
        CmrpcError::TABLE.iter().map(|(code, word, _)| {
            let (decode, code1) = (ErrorDecode::PNIO.0, ErrorSource::CMRPC.0);
            (*word, Code::Pnio { decode, code1, code2: Some(code.0), word: (*word).to_owned() })
        })
    };
    let field = || {
        ConnectField::TABLE.iter().map(|field| {
            let (decode, code1, word) = (ErrorDecode::PNIO.0, field.finder().0, field.refusal);
            (word, Code::Pnio { decode, code1, code2: Some(field.number), word: word.to_owned() })
        })
    };
    let dcp = || {
        BlockError::TABLE
            .iter()
            .filter(|(code, ..)| code.0 != 0)
            .map(|(code, word, _)| (*word, Code::Dcp(code.0, (*word).to_owned())))
    };
    let pnio = || ("PNIO status", record().chain(finder()).chain(cmrpc()).collect());
    match service {
        Service::Parameters => vec![("PROFIdrive", parameter().collect()), pnio()],
        Service::Record | Service::Dp => vec![pnio()],
        Service::Station => vec![("DCP", dcp().collect())],
        Service::Connect => vec![("PNIO status", cmrpc().chain(finder()).chain(record()).chain(field()).collect())],
        Service::Last => vec![("PROFIdrive", parameter().collect()), pnio(), ("DCP", dcp().collect())],
    }
}
