//! The service of each frame on a bus. Some answers do not contain it; it is that of the request directly before them.

use wire::profibus::fdl::DataFrame;
use wire::profibus::sap::{SapService, SlaveSap};

/// Determines the service of each frame of one bus.
#[derive(Clone, Debug, Default)]
pub(super) struct DpServices {
    asked: Option<LastDpRequest>,
}

/// The last request that expects an answer.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastDpRequest {
    pub da: u8,
    pub sa: u8,
    pub service: SapService,
}

impl DpServices {
    /// The service of the next frame.
    pub fn of(&mut self, frame: &DataFrame<'_>) -> SapService {
        let service = SapService::of(frame);
        let DataFrame { da, sa, fc, .. } = *frame;
        if let Some(function) = fc.requested() {
            self.asked = function.expects_response().then_some(LastDpRequest { da, sa, service });
        } else if let Some(asked) = self.asked.take()
            && (asked.da, asked.sa) == (sa, da)
            && (service == SapService::BareAnswer
                || service == SapService::DataExchange && matches!(asked.service, SapService::Link(_)))
        {
            return asked.service;
        }
        service
    }

    /// The request that a short acknowledgement answers.
    pub fn acknowledged(&mut self) -> Option<LastDpRequest> {
        self.asked.take()
    }
}

/// The word for a service.
pub(super) fn service_word(service: SapService) -> String {
    match service {
        SapService::Connection(sap) => format!("ms2 by SAP {sap}"),
        SapService::Slave(SlaveSap(sap)) if service.word().is_none() => format!("SAP {sap}"),
        _ => service.word().unwrap_or("frame").to_owned(),
    }
}
