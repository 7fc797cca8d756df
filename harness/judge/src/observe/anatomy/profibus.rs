//! Parts of FDL frames: header, service access points, data, checksum.

use super::Parts;
use wire::profibus::fdl::{DataFrame, FdlFormat, FdlFrame};
use wire::profibus::sap::SapService;

pub(super) fn frame(parts: &mut Parts<'_>) {
    match FdlFrame::parse(parts.octets) {
        Ok(FdlFrame::Data(frame)) => data(parts, &frame),
        Ok(FdlFrame::Token { .. }) => {
            parts.plain(1, "SD4, a token");
            parts.number(1, "to station", |_| None);
            parts.number(1, "from station", |_| None);
        }
        Ok(FdlFrame::ShortAcknowledgement) => parts.plain(1, "SC, a short acknowledgement"),
        Err(error) => parts.rest(format!("damaged: {error}")),
    }
}

fn data(parts: &mut Parts<'_>, frame: &DataFrame<'_>) {
    match frame.format {
        FdlFormat::NoData => parts.plain(1, "SD1, no data"),
        FdlFormat::EightOctets => parts.plain(1, "SD3, eight bytes of data"),
        FdlFormat::Variable => {
            parts.plain(1, "SD2, data of any length");
            parts.number(1, "length", |_| None);
            parts.number(1, "length repeated", |_| None);
            parts.plain(1, "SD2 repeated");
        }
    }
    let station = |number: u64| Some(format!("station {}", number & 0x7F));
    parts.number(1, "destination", station);
    parts.number(1, "source", station);
    let fc = frame.fc;
    parts.take(1, "frame control", |_| match (fc.requested(), fc.answered()) {
        (Some(function), _) => format!("request {}", function.word().unwrap_or("unknown")),
        (_, Some(function)) => format!("answer {}", function.word().unwrap_or("unknown")),
        _ => String::new(),
    });
    let mut extension = |name: &str, length: usize| {
        if length > 0 {
            parts.take(length, name, |octets| {
                let number = octets.last().map_or(0, |octet| octet & 0x3F);
                format!("SAP {number}")
            });
        }
    };
    extension("destination SAP", frame.destination.length());
    extension("source SAP", frame.source.length());
    let what = match SapService::of(frame) {
        SapService::DataExchange => "data of Data_Exchange",
        _ => "data",
    };
    parts.plain(frame.data.len(), what);
    parts.take(1, "checksum", |_| "correct".to_owned());
    parts.plain(1, "end delimiter");
}
