//! The list of blocks of a Connect request or response.

use super::{
    AlarmCrBlockReq, AlarmCrBlockRes, ArBlockReq, ArBlockRes, ArRpcBlock, ArServerBlockRes, ExpectedSubmoduleBlockReq,
    IocrBlockReq, IocrBlockRes, PrmServerBlockReq,
};
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use crate::profinet::blocks::{BlockHeader, BlockType, RawBlock};
use alloc::vec::Vec;

macro_rules! contents {
    ($($Variant:ident($Block:ty) = $KIND:ident $sentence:literal,)*) => {
        /// The content of a block of a Connect.
        #[derive(Clone, Debug, PartialEq, Eq)]
        pub enum ConnectContent {
            $(
                #[doc = $sentence]
                $Variant($Block),
            )*
            /// A block that is parsed elsewhere or not at all: its type and all bytes after its version.
            Other(BlockType, Vec<u8>),
        }

        impl ConnectContent {
            /// The type of the block.
            pub fn kind(&self) -> BlockType {
                match self {
                    $(ConnectContent::$Variant(_) => BlockType::$KIND,)*
                    ConnectContent::Other(kind, _) => *kind,
                }
            }

            fn read(kind: BlockType, body: &mut ByteReader) -> Result<ConnectContent> {
                Ok(match kind {
                    $(BlockType::$KIND => ConnectContent::$Variant(<$Block>::read(&mut *body)?),)*
                    _ => ConnectContent::Other(kind, body.rest().to_vec()),
                })
            }

            fn write(&self, out: &mut Vec<u8>) {
                match self {
                    $(ConnectContent::$Variant(block) => block.write(out),)*
                    ConnectContent::Other(_, body) => out.put(body),
                }
            }
        }
    };
}

contents! {
    ArReq(ArBlockReq) = AR_REQ "The requested AR.",
    ArRes(ArBlockRes) = AR_RES "The established AR.",
    IocrReq(IocrBlockReq) = IOCR_REQ "A requested cyclic connection.",
    IocrRes(IocrBlockRes) = IOCR_RES "An established cyclic connection.",
    AlarmCrReq(AlarmCrBlockReq) = ALARM_CR_REQ "The requested alarm connection.",
    AlarmCrRes(AlarmCrBlockRes) = ALARM_CR_RES "The established alarm connection.",
    ExpectedSubmodule(ExpectedSubmoduleBlockReq) = EXPECTED_SUBMODULE "Expected modules.",
    PrmServerReq(PrmServerBlockReq) = PRM_SERVER_REQ "The parameter server.",
    ArServerRes(ArServerBlockRes) = AR_SERVER_RES "The name of the responding station.",
    ArRpcReq(ArRpcBlock) = AR_RPC_REQ "The RPC port of the initiator.",
    ArRpcRes(ArRpcBlock) = AR_RPC_RES "The RPC port of the responder.",
}

/// A block of a Connect with its version and the bytes after its known fields.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConnectBlock {
    /// Version, high byte; 1.
    pub version_high: u8,
    /// Version, low byte; 0.
    pub version_low: u8,
    /// The content of the block.
    pub content: ConnectContent,
    /// Bytes after the known fields: padding, or fields of a newer version.
    pub rest: Vec<u8>,
}

impl ConnectBlock {
    /// Reads one block.
    pub fn read(reader: &mut ByteReader) -> Result<ConnectBlock> {
        let (header, body) = BlockHeader::read(reader)?;
        let mut body = body.layer(header.kind.word().unwrap_or("block"));
        let content = ConnectContent::read(header.kind, &mut body)?;
        let BlockHeader { version_high, version_low, .. } = header;
        Ok(ConnectBlock { version_high, version_low, content, rest: body.rest().to_vec() })
    }

    /// Appends the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        let header =
            BlockHeader { kind: self.content.kind(), version_high: self.version_high, version_low: self.version_low };
        header.write_with(out, |out| {
            self.content.write(out);
            out.put(&self.rest);
        });
    }
}

impl From<ConnectContent> for ConnectBlock {
    /// A block of version 1.0 without bytes after its fields; only an ARServerBlockRes is padded to a multiple of four bytes.
    fn from(content: ConnectContent) -> ConnectBlock {
        let mut rest = Vec::new();
        if let ConnectContent::ArServerRes(server) = &content {
            let length = 8 + server.cm_responder_station_name.len();
            rest.resize(length.next_multiple_of(4) - length, 0);
        }
        ConnectBlock { version_high: 1, version_low: 0, content, rest }
    }
}

impl From<RawBlock> for ConnectBlock {
    /// A block that another module writes, such as the ModuleDiffBlock.
    fn from(block: RawBlock) -> ConnectBlock {
        let BlockHeader { kind, version_high, version_low } = block.header;
        ConnectBlock { version_high, version_low, content: ConnectContent::Other(kind, block.body), rest: Vec::new() }
    }
}

/// The blocks of a Connect request or response, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Connect {
    /// The blocks.
    pub blocks: Vec<ConnectBlock>,
}

impl Connect {
    /// Blocks of version 1.0 with these contents.
    pub fn of(contents: impl IntoIterator<Item = ConnectContent>) -> Connect {
        Connect { blocks: contents.into_iter().map(ConnectBlock::from).collect() }
    }

    /// Reads the blocks after the NDR header.
    pub fn parse(octets: &[u8]) -> Result<Connect> {
        let mut reader = ByteReader::new("Connect", octets);
        let mut blocks = Vec::new();
        while !reader.is_empty() {
            blocks.push(ConnectBlock::read(&mut reader)?);
        }
        Ok(Connect { blocks })
    }

    /// Appends the blocks.
    pub fn write(&self, out: &mut Vec<u8>) {
        for block in &self.blocks {
            block.write(out);
        }
    }

    /// Serializes the blocks.
    pub fn to_vec(&self) -> Vec<u8> {
        let mut out = Vec::new();
        self.write(&mut out);
        out
    }

    /// All contents in order.
    pub fn contents(&self) -> impl Iterator<Item = &ConnectContent> {
        self.blocks.iter().map(|block| &block.content)
    }

    /// The ARBlockReq.
    pub fn ar_req(&self) -> Option<&ArBlockReq> {
        self.contents().find_map(|content| if let ConnectContent::ArReq(block) = content { Some(block) } else { None })
    }

    /// The ARBlockRes.
    pub fn ar_res(&self) -> Option<&ArBlockRes> {
        self.contents().find_map(|content| if let ConnectContent::ArRes(block) = content { Some(block) } else { None })
    }

    /// All IOCRBlockReq.
    pub fn iocr_requests(&self) -> impl Iterator<Item = &IocrBlockReq> {
        self.contents()
            .filter_map(|content| if let ConnectContent::IocrReq(block) = content { Some(block) } else { None })
    }

    /// All IOCRBlockRes.
    pub fn iocr_responses(&self) -> impl Iterator<Item = &IocrBlockRes> {
        self.contents()
            .filter_map(|content| if let ConnectContent::IocrRes(block) = content { Some(block) } else { None })
    }

    /// The AlarmCRBlockReq.
    pub fn alarm_cr_req(&self) -> Option<&AlarmCrBlockReq> {
        self.contents()
            .find_map(|content| if let ConnectContent::AlarmCrReq(block) = content { Some(block) } else { None })
    }

    /// The AlarmCRBlockRes.
    pub fn alarm_cr_res(&self) -> Option<&AlarmCrBlockRes> {
        self.contents()
            .find_map(|content| if let ConnectContent::AlarmCrRes(block) = content { Some(block) } else { None })
    }

    /// The ARServerBlockRes.
    pub fn ar_server_res(&self) -> Option<&ArServerBlockRes> {
        self.contents()
            .find_map(|content| if let ConnectContent::ArServerRes(block) = content { Some(block) } else { None })
    }

    /// The modules of all ExpectedSubmoduleBlockReq.
    pub fn expected_modules(&self) -> impl Iterator<Item = &super::ExpectedModule> {
        self.contents()
            .filter_map(
                |content| if let ConnectContent::ExpectedSubmodule(block) = content { Some(block) } else { None },
            )
            .flat_map(|block| &block.modules)
    }

    /// The first block of type `kind`, including its header, for the parser of its type, such as the ModuleDiffBlock.
    pub fn block(&self, kind: BlockType) -> Option<Vec<u8>> {
        let block = self.blocks.iter().find(|block| block.content.kind() == kind)?;
        let mut out = Vec::new();
        block.write(&mut out);
        Some(out)
    }
}
