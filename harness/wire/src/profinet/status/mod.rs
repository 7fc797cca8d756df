//! PNIO status: the four-byte result of a PROFINET service (IEC 61158-6-10, 5.2.6).

mod codes;
mod fields;

pub use codes::{AbortReason, CmrpcError, ErrorCode, ErrorDecode, ErrorSource, RecordError};

use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;
use core::fmt;

/// The status of a PROFINET service; four zeros mean success.
///
/// Bytes in blocks and alarm PDUs: 0 ErrorCode, 1 ErrorDecode, 2 ErrorCode1, 3 ErrorCode2. In the NDR header of a response they
/// are one 32-bit word in the byte order of the RPC header.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct PnioStatus {
    /// The response or PDU that the status belongs to.
    pub error_code: ErrorCode,
    /// The meaning of the last two bytes.
    pub error_decode: ErrorDecode,
    /// A [`RecordError`] or a [`ErrorSource`].
    pub error_code1: u8,
    /// The detail.
    pub error_code2: u8,
}

impl PnioStatus {
    /// Success.
    pub const OK: PnioStatus =
        PnioStatus { error_code: ErrorCode(0), error_decode: ErrorDecode(0), error_code1: 0, error_code2: 0 };

    /// An error of record access in a response of kind `code`; ErrorCode2 is 0.
    pub const fn record(code: ErrorCode, error: RecordError) -> PnioStatus {
        PnioStatus { error_code: code, error_decode: ErrorDecode::PNIORW, error_code1: error.0, error_code2: 0 }
    }

    /// An error that `error_source` detected, with its `detail`, in a response of kind `code`.
    pub const fn found(code: ErrorCode, finder: ErrorSource, detail: u8) -> PnioStatus {
        PnioStatus { error_code: code, error_decode: ErrorDecode::PNIO, error_code1: finder.0, error_code2: detail }
    }

    /// The status of an ERR-RTA PDU.
    pub const fn abort(reason: AbortReason) -> PnioStatus {
        PnioStatus::found(ErrorCode::RTA_ERROR, ErrorSource::RTA_PROTOCOL, reason.0)
    }

    /// Whether it is success.
    pub fn is_ok(&self) -> bool {
        *self == PnioStatus::OK
    }

    /// The error of record access; `None` if it is another error.
    pub fn record_error(&self) -> Option<RecordError> {
        (self.error_decode == ErrorDecode::PNIORW).then_some(RecordError(self.error_code1))
    }

    /// The part that detected the error, if there is one.
    pub fn error_source(&self) -> Option<ErrorSource> {
        (self.error_decode == ErrorDecode::PNIO).then_some(ErrorSource(self.error_code1))
    }

    /// The reason of an abort; `None` if it is another error.
    pub fn abort_reason(&self) -> Option<AbortReason> {
        (self.error_source() == Some(ErrorSource::RTA_PROTOCOL)).then_some(AbortReason(self.error_code2))
    }

    /// The error of the RPC part of context management; `None` if it is another error.
    pub fn cmrpc_error(&self) -> Option<CmrpcError> {
        (self.error_source() == Some(ErrorSource::CMRPC)).then_some(CmrpcError(self.error_code2))
    }

    /// The most specific word for the status, as suites write it, such as `state_conflict`; `ok` for success, `None` if unknown.
    ///
    /// The word of a faulty block is that of its [`ErrorSource`]; [`PnioStatus::faulty_field`] returns the faulty field.
    pub fn word(&self) -> Option<&'static str> {
        match (self.error_decode, ErrorSource(self.error_code1)) {
            _ if self.is_ok() => Some("ok"),
            (ErrorDecode::PNIORW, _) => RecordError(self.error_code1).word(),
            (ErrorDecode::PNIO, ErrorSource::CMRPC) => CmrpcError(self.error_code2).word(),
            (ErrorDecode::PNIO, ErrorSource::RTA_PROTOCOL) => AbortReason(self.error_code2).word(),
            (ErrorDecode::PNIO, finder) => finder.word(),
            _ => None,
        }
    }

    /// The meaning of the status, as one sentence.
    pub fn sentence(&self) -> Option<&'static str> {
        match (self.error_decode, ErrorSource(self.error_code1)) {
            _ if self.is_ok() => Some("Success."),
            (ErrorDecode::PNIORW, _) => RecordError(self.error_code1).sentence(),
            (ErrorDecode::PNIO, ErrorSource::CMRPC) => CmrpcError(self.error_code2).sentence(),
            (ErrorDecode::PNIO, ErrorSource::RTA_PROTOCOL) => AbortReason(self.error_code2).sentence(),
            (ErrorDecode::PNIO, finder) => finder.sentence(),
            _ => None,
        }
    }

    /// A status in a response of kind `code` for which [`PnioStatus::word`] returns `word`.
    ///
    /// Words of record access have precedence: `state_conflict` is that of a record unless `code` is of Connect, Control or
    /// Release.
    pub fn by_word(code: ErrorCode, word: &str) -> Option<PnioStatus> {
        if word == "ok" {
            return Some(PnioStatus::OK);
        }
        let record = RecordError::by_word(word).map(|error| PnioStatus::record(code, error));
        let cmrpc = CmrpcError::by_word(word).map(|error| PnioStatus::found(code, ErrorSource::CMRPC, error.0));
        let of_context =
            matches!(code, ErrorCode::CONNECT_RESPONSE | ErrorCode::CONTROL_RESPONSE | ErrorCode::RELEASE_RESPONSE);
        let first = if of_context { cmrpc.or(record) } else { record.or(cmrpc) };
        first
            .or_else(|| AbortReason::by_word(word).map(PnioStatus::abort))
            .or_else(|| ErrorSource::by_word(word).map(|finder| PnioStatus::found(code, finder, 0)))
    }

    /// Whether suites may use `word` for a status.
    pub fn is_status_word(word: &str) -> bool {
        PnioStatus::by_word(ErrorCode::PNIO, word).is_some()
    }

    /// The faulty field of the block, to which ErrorCode2 refers, with its name in the standard.
    pub fn faulty_field(&self) -> Option<&'static str> {
        fields::faulty_field(self.error_source()?, self.error_code2)
    }

    /// Parses the four bytes in a block or alarm PDU.
    pub fn read(reader: &mut ByteReader) -> Result<PnioStatus> {
        Ok(PnioStatus::from(u32::from_be_bytes(reader.array()?)))
    }

    /// Appends the four bytes for a block or alarm PDU.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u32((*self).into());
    }
}

impl From<u32> for PnioStatus {
    /// ErrorCode is the most significant byte.
    fn from(word: u32) -> PnioStatus {
        let [code, decode, error_code1, error_code2] = word.to_be_bytes();
        PnioStatus { error_code: ErrorCode(code), error_decode: ErrorDecode(decode), error_code1, error_code2 }
    }
}

impl From<PnioStatus> for u32 {
    fn from(status: PnioStatus) -> u32 {
        u32::from_be_bytes([status.error_code.0, status.error_decode.0, status.error_code1, status.error_code2])
    }
}

impl fmt::Display for PnioStatus {
    /// The response, the word, the faulty field, and all four bytes in hexadecimal.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let raw = u32::from(*self).to_be_bytes();
        if !self.is_ok() {
            write!(f, "{}: ", self.error_code.word().unwrap_or("unknown"))?;
        }
        f.write_str(self.word().unwrap_or("unknown"))?;
        if let Some(field) = self.faulty_field() {
            write!(f, " in {field}")?;
        }
        write!(f, " ({:02x} {:02x} {:02x} {:02x})", raw[0], raw[1], raw[2], raw[3])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::ToString;
    use rstest::rstest;

    // The first status is from merged-many-devices.pcapng; the words are those of tshark 4.0 for the numbers.
    #[rstest]
    #[case(0xDB81_4004, "out_of_ar_resources", "connect_response: out_of_ar_resources (db 81 40 04)")]
    #[case(0x0000_0000, "ok", "ok (00 00 00 00)")]
    #[case(0xDE80_B500, "state_conflict", "read_response: state_conflict (de 80 b5 00)")]
    #[case(0xDF80_B600, "access_denied", "write_response: access_denied (df 80 b6 00)")]
    #[case(0xDE80_B000, "invalid_index", "read_response: invalid_index (de 80 b0 00)")]
    #[case(0xDF80_B10A, "write_length_error", "write_response: write_length_error (df 80 b1 0a)")]
    #[case(0xDE80_C200, "resource_busy", "read_response: resource_busy (de 80 c2 00)")]
    #[case(0xDB81_0104, "faulty_ar_block", "connect_response: faulty_ar_block in ARType (db 81 01 04)")]
    #[case(0xDB81_020F, "faulty_iocr_block", "connect_response: faulty_iocr_block in WatchdogFactor (db 81 02 0f)")]
    #[case(
        0xDB81_0310,
        "faulty_expected_submodule_block",
        "connect_response: faulty_expected_submodule_block in LengthIOCS (db 81 03 10)"
    )]
    #[case(0xDB81_0408, "faulty_alarm_cr_block", "connect_response: faulty_alarm_cr_block in RTARetries (db 81 04 08)")]
    #[case(
        0xDD81_1408,
        "faulty_control_block",
        "control_response: faulty_control_block in ControlCommand (dd 81 14 08)"
    )]
    #[case(0xDC81_2800, "faulty_release_block", "release_response: faulty_release_block in BlockType (dc 81 28 00)")]
    #[case(0xDA81_3C00, "alarm_ack_error", "alarm_ack: alarm_ack_error (da 81 3c 00)")]
    #[case(0xCF81_FD05, "consumer_timeout", "rta_error: consumer_timeout (cf 81 fd 05)")]
    #[case(0xCF81_FD0F, "release_received", "rta_error: release_received (cf 81 fd 0f)")]
    #[case(0xCF81_FD1F, "station_name_changed", "rta_error: station_name_changed (cf 81 fd 1f)")]
    #[case(0xCF81_FD20, "reset_to_factory", "rta_error: reset_to_factory (cf 81 fd 20)")]
    fn a_known_status_has_a_word(#[case] raw: u32, #[case] word: &str, #[case] text: &str) {
        let status = PnioStatus::from(raw);
        assert_eq!(status.word(), Some(word));
        assert!(status.sentence().is_some());
        assert!(PnioStatus::is_status_word(word));
        assert_eq!(status.to_string(), text);
        assert_eq!(u32::from(status), raw);
        let again = PnioStatus::by_word(status.error_code, word).expect("a known word");
        assert_eq!(again.word(), Some(word));
        assert_eq!(again.error_code1, status.error_code1);
    }

    #[rstest]
    #[case(0xDE80_A300, "read_response: unknown (de 80 a3 00)")]
    #[case(0x1122_3344, "unknown: unknown (11 22 33 44)")]
    #[case(0xDB81_020D, "connect_response: faulty_iocr_block (db 81 02 0d)")]
    #[case(0xDB81_02FF, "connect_response: faulty_iocr_block (db 81 02 ff)")]
    fn an_unknown_status_keeps_its_bytes(#[case] raw: u32, #[case] text: &str) {
        assert_eq!(PnioStatus::from(raw).to_string(), text);
    }

    #[rstest]
    #[case(ErrorCode::READ_RESPONSE, 0xDE80_B500)]
    #[case(ErrorCode::WRITE_RESPONSE, 0xDF80_B500)]
    #[case(ErrorCode::CONTROL_RESPONSE, 0xDD81_4006)]
    fn a_state_conflict_depends_on_the_service(#[case] code: ErrorCode, #[case] raw: u32) {
        assert_eq!(PnioStatus::by_word(code, "state_conflict").map(u32::from), Some(raw));
    }

    #[test]
    fn a_word_that_is_in_no_table_is_unknown() {
        assert!(!PnioStatus::is_status_word("state conflict"));
        assert_eq!(PnioStatus::by_word(ErrorCode::READ_RESPONSE, "STATE_CONFLICT"), None);
    }

    #[test]
    fn every_word_of_every_table_converts_back_to_its_number() {
        for (error, word, _) in RecordError::TABLE {
            let status = PnioStatus::by_word(ErrorCode::READ_RESPONSE, word).expect("a known word");
            assert_eq!(status.record_error(), Some(*error));
        }
        for (error, word, _) in CmrpcError::TABLE {
            let status = PnioStatus::by_word(ErrorCode::CONNECT_RESPONSE, word).expect("a known word");
            assert_eq!(status.cmrpc_error(), Some(*error));
        }
        for (reason, word, _) in AbortReason::TABLE {
            let status = PnioStatus::by_word(ErrorCode::RTA_ERROR, word).expect("a known word");
            assert_eq!(status.abort_reason(), Some(*reason), "{word}");
        }
    }
}
