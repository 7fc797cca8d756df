//! The fields of a Connect that can be replaced after its blocks are built, to check that a device refuses what it cannot use.
//!
//! Source: IEC 61158-6-10, coding of ARBlockReq, IOCRBlockReq, ExpectedSubmoduleBlockReq and AlarmCRBlockReq, and of ErrorCode2.

use alloc::vec::Vec;
use wire::octets::ByteReader;
use wire::profinet::blocks::{BlockType, RawBlock};
use wire::profinet::rpc::Uuid;
use wire::profinet::status::ErrorSource;

/// A field of a block of the Connect request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConnectField {
    /// Its word in suites.
    pub word: &'static str,
    /// The word of the refusal that names it.
    pub refusal: &'static str,
    /// Its block.
    pub block: BlockType,
    /// Its number in the block, which a refusal has as ErrorCode2.
    pub number: u8,
    /// Its first byte in the block, the header included.
    offset: usize,
    /// How many bytes it has.
    octets: usize,
    /// What it is, as a sentence.
    pub sentence: &'static str,
}

macro_rules! fields {
    ($($block:ident { $($number:literal $offset:literal $octets:literal $word:literal $sentence:literal,)* })*) => {
        &[$($(ConnectField {
            word: $word,
            refusal: concat!("wrong_", $word),
            block: BlockType::$block,
            number: $number,
            offset: $offset,
            octets: $octets,
            sentence: $sentence,
        },)*)*]
    };
}

impl ConnectField {
    /// Every field: its number, offset, length, word and sentence. Both IOCRBlockReqs are changed; of the expected submodules it is the
    /// first, that of the access point.
    pub const TABLE: &'static [ConnectField] = fields! {
        AR_REQ {
            2 4 1 "ar_version" "BlockVersionHigh of the ARBlockReq.",
            4 6 2 "ar_type" "ARType.",
            5 8 16 "ar_uuid" "ARUUID.",
            8 32 16 "initiator_object" "CMInitiatorObjectUUID.",
            9 48 4 "ar_properties" "ARProperties.",
            10 52 2 "activity_timeout" "CMInitiatorActivityTimeoutFactor, in 100 ms.",
            11 54 2 "initiator_udp_port" "InitiatorUDPRTPort.",
        }
        IOCR_REQ {
            2 4 1 "iocr_version" "BlockVersionHigh of the IOCRBlockReqs.",
            4 6 2 "iocr_type" "IOCRType.",
            5 8 2 "iocr_reference" "IOCRReference.",
            6 10 2 "iocr_lt" "LT, the EtherType.",
            7 12 4 "iocr_properties" "IOCRProperties, with the RT class.",
            8 16 2 "data_length" "DataLength of the cyclic frame.",
            9 18 2 "frame_id" "FrameID.",
            10 20 2 "send_clock" "SendClockFactor, in 31.25 µs.",
            11 22 2 "reduction" "ReductionRatio.",
            12 24 2 "phase" "Phase.",
            14 28 4 "frame_send_offset" "FrameSendOffset, in ns.",
            15 32 2 "watchdog_factor" "WatchdogFactor.",
            16 34 2 "data_hold_factor" "DataHoldFactor.",
            17 36 2 "iocr_tag" "IOCRTagHeader.",
        }
        EXPECTED_SUBMODULE {
            2 4 1 "expected_version" "BlockVersionHigh of the ExpectedSubmoduleBlockReqs.",
            7 14 4 "expected_module" "ModuleIdentNumber.",
            8 18 2 "module_properties" "ModuleProperties.",
            12 28 1 "submodule_properties" "SubmoduleProperties, their reserved high byte.",
            13 30 2 "data_description" "DataDescription.",
            15 35 1 "length_iops" "LengthIOPS.",
            16 34 1 "length_iocs" "LengthIOCS.",
        }
        ALARM_CR_REQ {
            2 4 1 "alarm_version" "BlockVersionHigh of the AlarmCRBlockReq.",
            4 6 2 "alarm_cr_type" "AlarmCRType.",
            5 8 2 "alarm_lt" "LT, the EtherType.",
            6 10 4 "alarm_properties" "AlarmCRProperties.",
            7 14 2 "rta_timeout" "RTATimeoutFactor, in 100 ms.",
            8 16 2 "rta_retries" "RTARetries.",
            10 20 2 "max_alarm_data" "MaxAlarmDataLength.",
            11 22 2 "alarm_tag_high" "AlarmCRTagHeaderHigh.",
            12 24 2 "alarm_tag_low" "AlarmCRTagHeaderLow.",
        }
    };

    /// The field with this word.
    pub fn by_word(word: &str) -> Option<ConnectField> {
        Self::TABLE.iter().find(|field| field.word == word).copied()
    }

    /// The ARUUID if it is one of the `replaced` fields: the AR has to be released by it.
    pub(super) fn ar_uuid(replaced: &[(ConnectField, u64)]) -> Option<Uuid> {
        let (_, value) = replaced.iter().find(|(field, _)| field.word == "ar_uuid")?;
        Some(Uuid(u128::from(*value).to_be_bytes()))
    }

    /// What finds a fault in its block: ErrorCode1 of a refusal.
    pub fn finder(self) -> ErrorSource {
        match self.block {
            BlockType::AR_REQ => ErrorSource::AR_BLOCK,
            BlockType::IOCR_REQ => ErrorSource::IOCR_BLOCK,
            BlockType::EXPECTED_SUBMODULE => ErrorSource::EXPECTED_SUBMODULE_BLOCK,
            _ => ErrorSource::ALARM_CR_BLOCK,
        }
    }

    /// Writes `value` into each block of the request that has the field; the field is filled from its end, and its other bytes are zero.
    pub(super) fn replace(self, request: &mut [u8], value: u64) {
        let mut reader = ByteReader::new("Connect", request);
        let mut places = Vec::new();
        loop {
            let begin = reader.offset();
            match RawBlock::read(&mut reader) {
                Ok(block) if block.header.kind == self.block => places.push(begin + self.offset),
                Ok(_) => {}
                Err(_) => break,
            }
        }
        if self.block == BlockType::EXPECTED_SUBMODULE {
            places.truncate(1);
        }
        for place in places {
            if let Some(octets) = request.get_mut(place..place + self.octets) {
                octets.fill(0);
                for (octet, byte) in octets.iter_mut().rev().zip(value.to_le_bytes()) {
                    *octet = byte;
                }
            }
        }
    }
}
