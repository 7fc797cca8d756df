//! Control and Release: PrmEnd, ApplicationReady and other control commands.

use crate::error::Result;
use crate::octets::{Append, ByteOrder, ByteReader};
use crate::profinet::blocks::{BlockHeader, BlockType, RawBlock};
use crate::profinet::rpc::Uuid;
use alloc::vec::Vec;

/// ControlCommand: 16 bits, of which one is set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ControlCommand(pub u16);

impl ControlCommand {
    /// Bit 0: parametrization is complete.
    pub const PRM_END: ControlCommand = ControlCommand(1);
    /// Bit 1: the application is ready.
    pub const APPLICATION_READY: ControlCommand = ControlCommand(1 << 1);
    /// Bit 2: closes the AR.
    pub const RELEASE: ControlCommand = ControlCommand(1 << 2);
    /// Bit 3: the response to any of the other commands.
    pub const DONE: ControlCommand = ControlCommand(1 << 3);
    /// Bit 4: the device waits for the companion AR.
    pub const READY_FOR_COMPANION: ControlCommand = ControlCommand(1 << 4);
    /// Bit 5: the device is ready for RT class 3.
    pub const READY_FOR_RTC3: ControlCommand = ControlCommand(1 << 5);
    /// Bit 6: parametrization begins.
    pub const PRM_BEGIN: ControlCommand = ControlCommand(1 << 6);

    /// Whether all bits of `command` are set.
    pub fn has(self, command: ControlCommand) -> bool {
        self.0 & command.0 == command.0
    }
}

/// A control block, request or response; also for Release.
///
/// Bytes of the body: 0-1 padding, 2-17 ARUUID, 18-19 SessionKey, 20-21 AlarmSequenceNumber or padding, 22-23 ControlCommand,
/// 24-25 ControlBlockProperties.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControlBlock {
    /// Type and version.
    pub header: BlockHeader,
    /// Padding, 0.
    pub padding: u16,
    /// The UUID of the AR.
    pub ar_uuid: Uuid,
    /// The session key of the AR.
    pub session_key: u16,
    /// The sequence number of the plug alarm that caused this; otherwise padding, 0.
    pub alarm_sequence_number: u16,
    /// The command.
    pub control_command: ControlCommand,
    /// Properties; 0, except the bits below for ApplicationReady in advanced start-up.
    pub control_block_properties: u16,
}

impl ControlBlock {
    /// ControlBlockProperties of ApplicationReady, bit 0: ReadyForCompanion will follow, wait for it.
    pub const PROPERTY_WAIT_FOR_COMPANION: u16 = 1;
    /// ControlBlockProperties of ApplicationReady, bit 1: ReadyForRT_CLASS_3 will follow, wait for it.
    pub const PROPERTY_WAIT_FOR_RTC3: u16 = 2;

    /// A request of type `kind`, version 1.0.
    pub fn request(kind: BlockType, ar_uuid: Uuid, session_key: u16, control_command: ControlCommand) -> ControlBlock {
        ControlBlock {
            header: BlockHeader { kind, version_high: 1, version_low: 0 },
            padding: 0,
            ar_uuid,
            session_key,
            alarm_sequence_number: 0,
            control_command,
            control_block_properties: 0,
        }
    }

    /// PrmEnd after Connect.
    pub fn prm_end(ar_uuid: Uuid, session_key: u16) -> ControlBlock {
        ControlBlock::request(BlockType::PRM_END_REQ, ar_uuid, session_key, ControlCommand::PRM_END)
    }

    /// ApplicationReady after Connect.
    pub fn application_ready(ar_uuid: Uuid, session_key: u16) -> ControlBlock {
        let command = ControlCommand::APPLICATION_READY;
        ControlBlock::request(BlockType::APPLICATION_READY_REQ, ar_uuid, session_key, command)
    }

    /// Release.
    pub fn release(ar_uuid: Uuid, session_key: u16) -> ControlBlock {
        ControlBlock::request(BlockType::RELEASE_REQ, ar_uuid, session_key, ControlCommand::RELEASE)
    }

    /// The response to this request: the type with bit 15 set, command Done, properties 0.
    pub fn done(&self) -> ControlBlock {
        ControlBlock {
            header: BlockHeader { kind: BlockType(self.header.kind.0 | 0x8000), ..self.header },
            control_command: ControlCommand::DONE,
            control_block_properties: 0,
            ..*self
        }
    }
}

/// The blocks of a Control or Release call: the control block and further blocks (ModuleDiffBlock, SubmoduleListBlock).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ControlBlocks {
    /// The control block.
    pub block: ControlBlock,
    /// Bytes in the control block after its known fields.
    pub rest: Vec<u8>,
    /// The blocks after the control block.
    pub more: Vec<RawBlock>,
}

impl ControlBlocks {
    /// Reads the blocks after the NDR header.
    pub fn parse(octets: &[u8]) -> Result<ControlBlocks> {
        let mut reader = ByteReader::new("Control", octets);
        let (header, mut body) = BlockHeader::read(&mut reader)?;
        let block = ControlBlock {
            header,
            padding: body.u16()?,
            ar_uuid: Uuid::read(&mut body)?,
            session_key: body.u16()?,
            alarm_sequence_number: body.u16()?,
            control_command: ControlCommand(body.u16()?),
            control_block_properties: body.u16()?,
        };
        let mut more = Vec::new();
        while !reader.is_empty() {
            more.push(RawBlock::read(&mut reader)?);
        }
        Ok(ControlBlocks { block, rest: body.rest().to_vec(), more })
    }

    /// Appends the blocks.
    pub fn write(&self, out: &mut Vec<u8>) {
        let block = &self.block;
        block.header.write_with(out, |out| {
            out.put_u16(block.padding);
            block.ar_uuid.write(out, ByteOrder::Big);
            out.put_u16(block.session_key);
            out.put_u16(block.alarm_sequence_number);
            out.put_u16(block.control_command.0);
            out.put_u16(block.control_block_properties);
            out.put(&self.rest);
        });
        for block in &self.more {
            block.write(out);
        }
    }

    /// Serializes the blocks.
    pub fn to_vec(&self) -> Vec<u8> {
        let mut out = Vec::new();
        self.write(&mut out);
        out
    }

    /// The first further block of type `kind`, including its header, for the parser of its type.
    pub fn block(&self, kind: BlockType) -> Option<Vec<u8>> {
        self.more.iter().find(|block| block.header.kind == kind).map(RawBlock::to_vec)
    }
}

impl From<ControlBlock> for ControlBlocks {
    fn from(block: ControlBlock) -> ControlBlocks {
        ControlBlocks { block, rest: Vec::new(), more: Vec::new() }
    }
}
