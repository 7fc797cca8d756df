//! A request to one station, and the frames that answer it.

use super::outcome::DataLinkAnswer;
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;
use wire::WireError;
use wire::profibus::fdl::{
    BROADCAST, DataFrame, Extension, FdlFormat, FdlFrame, FrameCount, FunctionCode, RequestFunction,
};
use wire::profibus::global_control::GlobalControl;
use wire::profibus::sap::{MasterSap, SlaveSap};

/// A request; its function code says whether an answer is awaited.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct DpMessage {
    pub to: u8,
    pub dsap: Option<u8>,
    pub ssap: Option<u8>,
    pub function: RequestFunction,
    pub data: Vec<u8>,
}

impl DpMessage {
    /// A DP-V0 service with its own access point (SAP).
    pub fn service(to: u8, sap: SlaveSap, data: Vec<u8>) -> DpMessage {
        let (dsap, ssap) = (Some(sap.0), Some(MasterSap::MS0.0));
        DpMessage { to, dsap, ssap, function: RequestFunction::SRD_HIGH, data }
    }

    pub fn diagnosis(to: u8) -> DpMessage {
        DpMessage::service(to, SlaveSap::SLAVE_DIAG, Vec::new())
    }

    pub fn exchange(to: u8, data: Vec<u8>) -> DpMessage {
        DpMessage { to, dsap: None, ssap: None, function: RequestFunction::SRD_HIGH, data }
    }

    pub fn global_control(to: u8, control: GlobalControl) -> DpMessage {
        let mut data = Vec::new();
        control.write(&mut data);
        let function = RequestFunction::SDN_HIGH;
        DpMessage { function, ..DpMessage::service(to, SlaveSap::GLOBAL_CONTROL, data) }
    }

    pub fn fdl_status(to: u8) -> DpMessage {
        DpMessage { to, dsap: None, ssap: None, function: RequestFunction::FDL_STATUS, data: Vec::new() }
    }

    /// Whether the requests of this kind carry a frame count bit (FCB).
    pub fn is_counted(&self) -> bool {
        self.expects_answer() && !self.function.is_link()
    }

    /// Whether the data link sends it before messages of low priority.
    pub fn is_high(&self) -> bool {
        matches!(self.function, RequestFunction::SRD_HIGH | RequestFunction::SDN_HIGH | RequestFunction::SDA_HIGH)
    }

    /// Whether a station must answer.
    pub fn expects_answer(&self) -> bool {
        self.to != BROADCAST && self.function.expects_response()
    }

    /// Appends the frame from the station `own`. As DP masters do it is SD1 or SD2: eight bytes are sent as SD2, although an SD3
    /// of a slave is accepted (IEC 61158-6-3, telegram formats of DP).
    pub fn write(&self, own: u8, count: FrameCount, out: &mut Vec<u8>) {
        let extension = |sap| Extension { segment: None, sap };
        let fc = FunctionCode::request(self.function, count);
        let frame = DataFrame::new((self.to, extension(self.dsap)), (own, extension(self.ssap)), fc, &self.data);
        let format = match frame.format {
            FdlFormat::EightOctets => FdlFormat::Variable,
            other => other,
        };
        DataFrame { format, ..frame }.write(out);
    }

    /// The answer in `frame`, which followed this message.
    pub fn answer(&self, own: u8, frame: Result<FdlFrame<'_>, WireError>) -> DataLinkAnswer {
        let frame = match frame {
            Ok(FdlFrame::ShortAcknowledgement) => return DataLinkAnswer::Short,
            Ok(FdlFrame::Token { da, sa }) => return DataLinkAnswer::Unfit(format!("a token from {sa} to {da}")),
            Err(error) => return DataLinkAnswer::Unfit(error.to_string()),
            Ok(FdlFrame::Data(frame)) => frame,
        };
        let (Some(function), Some(station)) = (frame.fc.answered(), frame.fc.station()) else {
            return DataLinkAnswer::Unfit(format!("a request from station {}", frame.sa));
        };
        if (frame.da, frame.sa) != (own, self.to) {
            return DataLinkAnswer::Unfit(format!("an answer from station {} to {}", frame.sa, frame.da));
        }
        let points = (frame.source.sap, frame.destination.sap);
        let is_bare = points == (None, None) && frame.data.is_empty();
        if points != (self.dsap, self.ssap) && !is_bare {
            let sap_text = |sap: Option<u8>| sap.map_or("none".to_string(), |sap| sap.to_string());
            let (from, to) = (sap_text(points.0), sap_text(points.1));
            return DataLinkAnswer::Unfit(format!("an answer from access point {from} to {to}"));
        }
        DataLinkAnswer::Frame { function, station, data: frame.data.to_vec() }
    }
}

/// The frame count bits of all stations.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameCountBits {
    next: Vec<(u8, FrameCount)>,
}

impl FrameCountBits {
    /// The frame count of the next new request to `station`.
    pub fn next(&self, station: u8) -> FrameCount {
        self.next.iter().find(|(known, _)| *known == station).map_or(FrameCount::First, |(_, next)| *next)
    }

    /// Records that a request to `station` with `count` was answered.
    pub fn answered(&mut self, station: u8, count: FrameCount) {
        match self.next.iter_mut().find(|(known, _)| *known == station) {
            Some((_, next)) => *next = count.next(),
            None => self.next.push((station, count.next())),
        }
    }

    /// Resets the frame count: the next request to `station` is the first one.
    pub fn forget(&mut self, station: u8) {
        self.next.retain(|(known, _)| *known != station);
    }
}
