//! The function code (FC): the function of a frame, and the frame count bit, which distinguishes a retry from a new request.

use crate::codes::codes;

codes! {
    /// The function of a request: bits 7 and 3-0 of the function code; unknown numbers are preserved (IEC 61158-4-3, FC).
    pub struct RequestFunction(u8) {
        0x00 TIME_EVENT time_event "The reference time of the clock value that follows.",
        0x03 SDA_LOW sda_low "Sends data of low priority with acknowledgement (SDA).",
        0x04 SDN_LOW sdn_low "Sends data of low priority without acknowledgement (SDN).",
        0x05 SDA_HIGH sda_high "Sends data of high priority with acknowledgement (SDA).",
        0x06 SDN_HIGH sdn_high "Sends data of high priority without acknowledgement (SDN).",
        0x07 MSRD msrd "Sends and requests data with multicast response (MSRD).",
        0x09 FDL_STATUS fdl_status "Requests the FDL status: whether there is a station, and its type.",
        0x0C SRD_LOW srd_low "Sends data of low priority and requests data (SRD).",
        0x0D SRD_HIGH srd_high "Sends data of high priority and requests data (SRD).",
        0x0E IDENT ident "Requests the identification: manufacturer and version of the station.",
        0x0F LSAP_STATUS lsap_status "Requests the status of an access point.",
        0x80 CLOCK_VALUE clock_value "The time at the preceding time event.",
    }
}

codes! {
    /// The function of a response: bits 7 and 3-0 of the function code; unknown numbers are preserved (IEC 61158-4-3, FC).
    pub struct AnswerFunction(u8) {
        0x00 OK ok "The request was accepted.",
        0x01 USER_ERROR user_error "The user of the access point rejected the request (UE).",
        0x02 NO_RESOURCE no_resource "No resource for the request (RR).",
        0x03 NO_SERVICE no_service "The access point is not active or does not support the service (RS).",
        0x08 DATA_LOW data_low "Data of low priority (DL).",
        0x09 NO_DATA no_data "The request was accepted, but there are no data (NR).",
        0x0A DATA_HIGH data_high "Data of high priority (DH); in Data_Exchange the master must read a new diagnosis.",
        0x0C NO_RESOURCE_DATA_LOW no_resource_data_low "Data of low priority, but no resource for the request (RDL).",
        0x0D NO_RESOURCE_DATA_HIGH no_resource_data_high "Data of high priority, but no resource for the request (RDH).",
    }
}

codes! {
    /// The type of the responding station: bits 5-4 of the function code (IEC 61158-4-3, station type).
    pub struct StationType(u8) {
        0 SLAVE slave "A slave.",
        1 MASTER_NOT_READY master_not_ready "A master that is not ready for the logical ring.",
        2 MASTER_READY master_ready "A master that is ready for the logical ring.",
        3 MASTER_IN_RING master_in_ring "A master in the logical ring.",
    }
}

/// The frame count of a request, from the frame count bit (FCB, bit 5) and its validity bit (FCV, bit 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FrameCount {
    /// FCV 0, FCB 0: not counted.
    Unused,
    /// FCV 0, FCB 1: the first request to a station, which resets the frame count of the station.
    First,
    /// FCV 1, FCB 0.
    Zero,
    /// FCV 1, FCB 1.
    One,
}

impl FrameCount {
    /// The frame count of the next new request; a retry has the same frame count.
    #[inline]
    pub fn next(self) -> FrameCount {
        match self {
            FrameCount::Unused => FrameCount::Unused,
            FrameCount::First | FrameCount::One => FrameCount::Zero,
            FrameCount::Zero => FrameCount::One,
        }
    }
}

/// The function code (FC); reserved bits are preserved.
///
/// Request: bit 6 is 1, bit 5 FCB, bit 4 FCV, bits 7 and 3-0 function. Response: bit 6 is 0, bits 5-4 type of the station, bits 7
/// and 3-0 function (IEC 61158-4-3, FC).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FunctionCode(pub u8);

impl FunctionCode {
    const REQUEST: u8 = 0x40;
    const FCB: u8 = 0x20;
    const FCV: u8 = 0x10;
    const FUNCTION: u8 = 0x8F;

    /// The code of a request.
    pub const fn request(function: RequestFunction, count: FrameCount) -> FunctionCode {
        let count = match count {
            FrameCount::Unused => 0,
            FrameCount::First => FunctionCode::FCB,
            FrameCount::Zero => FunctionCode::FCV,
            FrameCount::One => FunctionCode::FCV | FunctionCode::FCB,
        };
        FunctionCode(FunctionCode::REQUEST | count | function.0 & FunctionCode::FUNCTION)
    }

    /// The code of a response.
    pub const fn answer(function: AnswerFunction, station: StationType) -> FunctionCode {
        FunctionCode((station.0 & 3) << 4 | function.0 & FunctionCode::FUNCTION)
    }

    /// Whether it is a request; otherwise it is a response.
    #[inline]
    pub fn is_request(self) -> bool {
        self.0 & FunctionCode::REQUEST != 0
    }

    /// The function of a request; `None` for a response.
    #[inline]
    pub fn requested(self) -> Option<RequestFunction> {
        self.is_request().then_some(RequestFunction(self.0 & FunctionCode::FUNCTION))
    }

    /// The function of a response; `None` for a request.
    #[inline]
    pub fn answered(self) -> Option<AnswerFunction> {
        (!self.is_request()).then_some(AnswerFunction(self.0 & FunctionCode::FUNCTION))
    }

    /// The frame count of a request; `None` for a response.
    #[inline]
    pub fn count(self) -> Option<FrameCount> {
        self.is_request().then_some(match (self.0 & FunctionCode::FCV != 0, self.0 & FunctionCode::FCB != 0) {
            (false, false) => FrameCount::Unused,
            (false, true) => FrameCount::First,
            (true, false) => FrameCount::Zero,
            (true, true) => FrameCount::One,
        })
    }

    /// The type of the responding station; `None` for a request.
    #[inline]
    pub fn station(self) -> Option<StationType> {
        (!self.is_request()).then_some(StationType(self.0 >> 4 & 3))
    }
}

impl RequestFunction {
    /// Whether a station responds to the request: not to requests without acknowledgement, to time events, clock values and unknown
    /// functions.
    #[inline]
    pub fn expects_response(self) -> bool {
        match self {
            RequestFunction::TIME_EVENT
            | RequestFunction::CLOCK_VALUE
            | RequestFunction::SDN_LOW
            | RequestFunction::SDN_HIGH => false,
            _ => self.word().is_some(),
        }
    }
}

impl AnswerFunction {
    /// Whether the response has data.
    #[inline]
    pub fn has_data(self) -> bool {
        matches!(
            self,
            AnswerFunction::DATA_LOW
                | AnswerFunction::DATA_HIGH
                | AnswerFunction::NO_RESOURCE_DATA_LOW
                | AnswerFunction::NO_RESOURCE_DATA_HIGH
        )
    }

    /// Whether the data are of high priority; in Data_Exchange the slave signals a new diagnosis by it.
    #[inline]
    pub fn is_high(self) -> bool {
        matches!(self, AnswerFunction::DATA_HIGH | AnswerFunction::NO_RESOURCE_DATA_HIGH)
    }
}
