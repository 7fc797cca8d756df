//! The header of each block.

use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

codes! {
    /// The type of a block; unknown numbers are preserved.
    pub struct BlockType(u16) {
        0x0001 ALARM_NOTIFICATION_HIGH alarm_notification_high "An alarm of high priority.",
        0x0002 ALARM_NOTIFICATION_LOW alarm_notification_low "An alarm of low priority.",
        0x0008 WRITE_REQ write_req "IODWriteReqHeader: the request to write a record.",
        0x0009 READ_REQ read_req "IODReadReqHeader: the request to read a record.",
        0x0010 DIAGNOSIS_DATA diagnosis_data "Diagnosis of one or several channels.",
        0x0012 EXPECTED_IDENTIFICATION expected_identification "The modules that a controller expects.",
        0x0013 REAL_IDENTIFICATION real_identification "The plugged modules.",
        0x0014 SUBSTITUTE_VALUE substitute_value "Substitute values for missing output data.",
        0x0015 RECORD_INPUT_DATA record_input_data "The input data of a submodule as a record.",
        0x0016 RECORD_OUTPUT_DATA record_output_data "The output data of a submodule as a record.",
        0x0018 AR_DATA ar_data "The established ARs.",
        0x0019 LOG_BOOK_DATA log_book_data "The log book of the station.",
        0x001A API_DATA api_data "The APIs of the station.",
        0x0020 IM0 im0 "I&M0: vendor, order ID, serial number and revisions.",
        0x0021 IM1 im1 "I&M1: function and location.",
        0x0022 IM2 im2 "I&M2: date of installation.",
        0x0023 IM3 im3 "I&M3: descriptor.",
        0x0024 IM4 im4 "I&M4: signature.",
        0x0025 IM5 im5 "I&M5: annotation.",
        0x0030 IM0_FILTER_SUBMODULE im0_filter_submodule "Submodules with their own I&M0.",
        0x0031 IM0_FILTER_MODULE im0_filter_module "Submodules whose I&M0 is that of the module.",
        0x0032 IM0_FILTER_DEVICE im0_filter_device "Submodules whose I&M0 is that of the device.",
        0x0034 IM5_DATA im5_data "One entry of I&M5.",
        0x0101 AR_REQ ar_req "ARBlockReq: the requested AR.",
        0x0102 IOCR_REQ iocr_req "IOCRBlockReq: a requested cyclic connection.",
        0x0103 ALARM_CR_REQ alarm_cr_req "AlarmCRBlockReq: the requested alarm connection.",
        0x0104 EXPECTED_SUBMODULE expected_submodule "ExpectedSubmoduleBlockReq: submodules that the controller expects.",
        0x0105 PRM_SERVER_REQ prm_server_req "PrmServerBlockReq: the parameter server.",
        0x0106 MCR_REQ mcr_req "MCRBlockReq: a requested multicast connection.",
        0x0107 SUB_FRAME sub_frame "SubFrameBlock: the packing of subframes.",
        0x0108 AR_VENDOR_REQ ar_vendor_req "ARVendorBlockReq: vendor-specific.",
        0x0109 IR_INFO ir_info "IRInfoBlock: isochronous real time.",
        0x010A SR_INFO sr_info "SRInfoBlock: system redundancy.",
        0x010B AR_FSU ar_fsu "ARFSUBlock: fast start-up.",
        0x010C RS_INFO rs_info "RSInfoBlock: reporting system.",
        0x0110 PRM_END_REQ prm_end_req "IODControlReq: parametrization after Connect is complete.",
        0x0111 PLUG_PRM_END_REQ plug_prm_end_req "IODControlReq: parametrization after a plug alarm is complete.",
        0x0112 APPLICATION_READY_REQ application_ready_req "IOXControlReq: the application of the device is ready.",
        0x0113 PLUG_APPLICATION_READY_REQ plug_application_ready_req "IOXControlReq: the plugged submodule is ready.",
        0x0114 RELEASE_REQ release_req "ReleaseBlockReq: the request to close the AR.",
        0x0115 AR_RPC_REQ ar_rpc_req "ARRPCBlockReq: the RPC port of the initiator.",
        0x0116 READY_FOR_COMPANION_REQ ready_for_companion_req "IOXControlReq: the device waits for the companion AR.",
        0x0117 READY_FOR_RTC3_REQ ready_for_rtc3_req "IOXControlReq: the device is ready for RT class 3.",
        0x0118 PRM_BEGIN_REQ prm_begin_req "IODControlReq: parametrization begins again.",
        0x0119 SUBMODULE_LIST submodule_list "SubmoduleListBlock: the submodules to which PrmBegin applies.",
        0x0200 PD_PORT_DATA_CHECK pd_port_data_check "The expected values that a port checks.",
        0x0202 PD_PORT_DATA_ADJUST pd_port_data_adjust "The settings of a port.",
        0x020F PD_PORT_DATA_REAL pd_port_data_real "The actual state of a port.",
        0x0240 PD_INTERFACE_DATA_REAL pd_interface_data_real "The actual state of the interface.",
        0x0250 PD_INTERFACE_ADJUST pd_interface_adjust "The settings of the interface.",
        0x0251 PD_PORT_STATISTIC pd_port_statistic "Counters of a port.",
        0x0400 MULTIPLE multiple "MultipleBlockHeader: the following blocks belong to one submodule.",
        0x0F00 MAINTENANCE_ITEM maintenance_item "The maintenance state in an alarm.",
        0x8001 ALARM_ACK_HIGH alarm_ack_high "The acknowledgement of an alarm of high priority.",
        0x8002 ALARM_ACK_LOW alarm_ack_low "The acknowledgement of an alarm of low priority.",
        0x8008 WRITE_RES write_res "IODWriteResHeader: the result of writing a record.",
        0x8009 READ_RES read_res "IODReadResHeader: the result of reading a record.",
        0x8101 AR_RES ar_res "ARBlockRes: the established AR.",
        0x8102 IOCR_RES iocr_res "IOCRBlockRes: an established cyclic connection.",
        0x8103 ALARM_CR_RES alarm_cr_res "AlarmCRBlockRes: the established alarm connection.",
        0x8104 MODULE_DIFF module_diff "ModuleDiffBlock: the differences between real and expected modules.",
        0x8105 PRM_SERVER_RES prm_server_res "PrmServerBlockRes: the parameter server is accepted.",
        0x8106 AR_SERVER_RES ar_server_res "ARServerBlockRes: the name of the responding station.",
        0x8107 AR_RPC_RES ar_rpc_res "ARRPCBlockRes: the RPC port of the responder.",
        0x8108 AR_VENDOR_RES ar_vendor_res "ARVendorBlockRes: vendor-specific.",
        0x8110 PRM_END_RES prm_end_res "IODControlRes to PrmEnd.",
        0x8111 PLUG_PRM_END_RES plug_prm_end_res "IODControlRes to PrmEnd after a plug alarm.",
        0x8112 APPLICATION_READY_RES application_ready_res "IOXControlRes to ApplicationReady.",
        0x8113 PLUG_APPLICATION_READY_RES plug_application_ready_res "IOXControlRes to ApplicationReady after a plug alarm.",
        0x8114 RELEASE_RES release_res "ReleaseBlockRes: the AR is closed.",
        0x8116 READY_FOR_COMPANION_RES ready_for_companion_res "IOXControlRes to ReadyForCompanion.",
        0x8117 READY_FOR_RTC3_RES ready_for_rtc3_res "IOXControlRes to ReadyForRT_CLASS_3.",
        0x8118 PRM_BEGIN_RES prm_begin_res "IODControlRes to PrmBegin.",
    }
}

/// Type, length and version at the start of a block.
///
/// Bytes: 0-1 type, 2-3 length of the rest (version included), 4 version high, 5 version low.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockHeader {
    /// The type of the block.
    pub kind: BlockType,
    /// Version, high byte.
    pub version_high: u8,
    /// Version, low byte.
    pub version_low: u8,
}

impl BlockHeader {
    /// Parses a header; returns it and a reader for exactly the body of its block.
    pub fn read<'a>(reader: &mut ByteReader<'a>) -> Result<(BlockHeader, ByteReader<'a>)> {
        let kind = BlockType(reader.u16()?);
        let length = reader.u16()?;
        if length < 2 {
            return Err(reader.wrong("BlockLength", 2, "at least 2", length.into()));
        }
        let mut body = reader.sub(length.into())?;
        let header = BlockHeader { kind, version_high: body.u8()?, version_low: body.u8()? };
        Ok((header, body))
    }

    /// Parses the header of a block that must be of type `kind` and version 1.0, and returns a reader for its body; `expected` is
    /// the expectation as text.
    pub fn read_only<'a>(
        reader: &mut ByteReader<'a>,
        kind: BlockType,
        expected: &'static str,
    ) -> Result<ByteReader<'a>> {
        let (header, body) = BlockHeader::read(reader)?;
        if header.kind != kind {
            return Err(body.wrong("BlockType", 6, expected, header.kind.0.into()));
        }
        match (header.version_high, header.version_low) {
            (1, 0) => Ok(body),
            (high, low) => Err(body.wrong("BlockVersion", 2, expected, u16::from_be_bytes([high, low]).into())),
        }
    }

    /// Appends a block of type `kind`, version 1.0, whose body `write` appends; the length is filled in.
    pub fn write(kind: BlockType, out: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>)) {
        BlockHeader { kind, version_high: 1, version_low: 0 }.write_with(out, write);
    }

    /// Appends a block with this header whose body `write` appends; the length is filled in.
    pub fn write_with(self, out: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>)) {
        out.put_u16(self.kind.0);
        let length_at = out.len();
        out.put(&[0, 0, self.version_high, self.version_low]);
        write(out);
        let length = (out.len() - length_at - 2) as u16;
        out[length_at..length_at + 2].copy_from_slice(&length.to_be_bytes());
    }
}

/// A block of which only the header is parsed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawBlock {
    /// Type and version.
    pub header: BlockHeader,
    /// Everything after the version.
    pub body: Vec<u8>,
}

impl RawBlock {
    /// Parses one block.
    pub fn read(reader: &mut ByteReader) -> Result<RawBlock> {
        let (header, mut body) = BlockHeader::read(reader)?;
        Ok(RawBlock { header, body: body.rest().to_vec() })
    }

    /// Appends the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        self.header.write_with(out, |out| out.put(&self.body));
    }

    /// Parses one block at the start of `octets`, as its own type writes it.
    pub fn parse(octets: &[u8]) -> Result<RawBlock> {
        RawBlock::read(&mut ByteReader::new("block", octets))
    }

    /// Serializes the whole block, including its header, as the parser of its type expects it.
    pub fn to_vec(&self) -> Vec<u8> {
        let mut out = Vec::new();
        self.write(&mut out);
        out
    }
}
