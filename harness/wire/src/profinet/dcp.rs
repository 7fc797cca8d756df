//! DCP: finding devices, assigning name and IP address, flashing the LED, resetting (IEC 61158-6-10, DCP).
//!
//! A frame is a [`Dcp`]: a header, and blocks whose format depends on the service. The blocks are in [`block`], the codes in
//! [`codes`], the rules for station names in [`station_name`].
//! This module must not know which station responds to what, nor when.

pub mod block;
pub mod codes;
pub mod station_name;

pub use block::{DcpBlock, DcpValue};
pub use codes::{BlockError, BlockInfo, BlockQualifier, Element, ResetMode, ServiceId, ServiceType};

use crate::error::Result;
use crate::ethernet::{EtherType, FrameHeader, Mac, pad};
use crate::octets::{Append, ByteReader};
use crate::profinet::rt::FrameId;
use alloc::vec::Vec;
use block::DcpBlockForm;

/// A DCP frame, starting with its frame ID.
///
/// Bytes: 0-1 frame ID, 2 service ID, 3 service type, 4-7 transaction ID, 8-9 response delay factor, 10-11 length of the
/// rest, then blocks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dcp {
    /// One of the four DCP frame IDs; one that does not match the service is preserved.
    pub frame_id: FrameId,
    /// Get, Set, Identify or Hello.
    pub service_id: ServiceId,
    /// Request or response.
    pub service_type: ServiceType,
    /// Transaction ID; the response has that of its request.
    pub xid: u32,
    /// ResponseDelayFactor: spreads the responses to an Identify request, 1..=6400; reserved (0) in all other frames.
    pub response_delay_factor: u16,
    /// The elements or blocks.
    pub body: DcpBody,
}

/// The content of a DCP frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DcpBody {
    /// A Get request: the requested elements, two bytes each.
    Elements(Vec<Element>),
    /// Everything else: elements with their values.
    Blocks(Vec<DcpBlock>),
}

impl Dcp {
    /// An Identify request to all stations that match all `filters`; to all stations if the filter is [`DcpValue::AllSelector`].
    pub fn identify(xid: u32, response_delay_factor: u16, filters: Vec<DcpValue>) -> Dcp {
        let blocks = filters.into_iter().map(DcpBlock::plain).collect();
        Dcp {
            frame_id: FrameId::DCP_IDENTIFY_REQUEST,
            service_id: ServiceId::IDENTIFY,
            service_type: ServiceType::REQUEST,
            xid,
            response_delay_factor,
            body: DcpBody::Blocks(blocks),
        }
    }

    /// A Get request for `elements`.
    pub fn get(xid: u32, elements: Vec<Element>) -> Dcp {
        Dcp::get_set(ServiceId::GET, ServiceType::REQUEST, xid, DcpBody::Elements(elements))
    }

    /// A Set request; each block carries its [`BlockQualifier`], see [`DcpBlock::set`].
    pub fn set(xid: u32, blocks: Vec<DcpBlock>) -> Dcp {
        Dcp::get_set(ServiceId::SET, ServiceType::REQUEST, xid, DcpBody::Blocks(blocks))
    }

    /// A Set request that makes the device flash its LED once.
    pub fn signal(xid: u32) -> Dcp {
        Dcp::set_control(xid, BlockQualifier(0), DcpValue::Signal(DcpValue::FLASH_ONCE))
    }

    /// A Set request that resets the device with suboption 6 (ResetToFactory).
    pub fn reset_to_factory(xid: u32, mode: ResetMode) -> Dcp {
        Dcp::set_control(xid, mode.qualifier(), DcpValue::ResetToFactory)
    }

    /// A Set request that resets the device with the older suboption 5 (FactoryReset), whose qualifier is reserved.
    pub fn factory_reset(xid: u32) -> Dcp {
        Dcp::set_control(xid, BlockQualifier(0), DcpValue::FactoryReset)
    }

    /// A Hello of a device that has just started; each block carries its [`BlockInfo`], see [`DcpBlock::report`].
    pub fn hello(xid: u32, blocks: Vec<DcpBlock>) -> Dcp {
        Dcp {
            frame_id: FrameId::DCP_HELLO,
            service_id: ServiceId::HELLO,
            service_type: ServiceType::REQUEST,
            xid,
            response_delay_factor: 0,
            body: DcpBody::Blocks(blocks),
        }
    }

    /// The response to this request: with the same service and transaction, and the frame ID of responses.
    pub fn response(&self, blocks: Vec<DcpBlock>) -> Dcp {
        Dcp {
            frame_id: match self.frame_id {
                FrameId::DCP_IDENTIFY_REQUEST => FrameId::DCP_IDENTIFY_RESPONSE,
                other => other,
            },
            service_id: self.service_id,
            service_type: ServiceType::RESPONSE,
            xid: self.xid,
            response_delay_factor: 0,
            body: DcpBody::Blocks(blocks),
        }
    }

    /// The response for a service that is not supported.
    pub fn not_supported(&self) -> Dcp {
        Dcp { service_type: ServiceType::NOT_SUPPORTED, ..self.response(Vec::new()) }
    }

    fn get_set(service_id: ServiceId, service_type: ServiceType, xid: u32, body: DcpBody) -> Dcp {
        Dcp { frame_id: FrameId::DCP_GET_SET, service_id, service_type, xid, response_delay_factor: 0, body }
    }

    fn set_control(xid: u32, qualifier: BlockQualifier, value: DcpValue) -> Dcp {
        Dcp::set(xid, [DcpBlock::set(qualifier, value)].into())
    }

    /// The blocks; empty in a Get request.
    pub fn blocks(&self) -> &[DcpBlock] {
        match &self.body {
            DcpBody::Elements(_) => &[],
            DcpBody::Blocks(blocks) => blocks,
        }
    }

    /// The blocks as bytes, each padded to an even length.
    pub fn block_octets(blocks: &[DcpBlock]) -> Vec<u8> {
        let mut out = Vec::new();
        blocks.iter().for_each(|block| block.write(&mut out));
        out
    }

    /// The elements in the frame, in order.
    pub fn elements(&self) -> impl Iterator<Item = Element> + '_ {
        let (requested, blocks): (&[Element], &[DcpBlock]) = match &self.body {
            DcpBody::Elements(elements) => (elements, &[]),
            DcpBody::Blocks(blocks) => (&[], blocks),
        };
        requested.iter().copied().chain(blocks.iter().map(|block| block.value.element()))
    }

    /// Parses a frame, starting with its frame ID; ignores padding after the last block.
    ///
    /// A block whose value has an invalid length for its element is preserved as [`DcpValue::Raw`].
    pub fn parse(payload: &[u8]) -> Result<Dcp> {
        let mut reader = ByteReader::new("DCP", payload);
        let frame_id = FrameId(reader.u16()?);
        let service_id = ServiceId(reader.u8()?);
        let service_type = ServiceType(reader.u8()?);
        let xid = reader.u32()?;
        let response_delay_factor = reader.u16()?;
        let length = reader.u16()?;
        let mut reader = reader.sub(length.into())?;
        let body = match DcpBlockForm::of(service_id, service_type) {
            None => {
                let mut elements = Vec::new();
                while !reader.is_empty() {
                    elements.push(Element::read(&mut reader)?);
                }
                DcpBody::Elements(elements)
            }
            Some(form) => {
                let mut blocks = Vec::new();
                while !reader.is_empty() {
                    blocks.push(DcpBlock::read(form, &mut reader)?);
                }
                DcpBody::Blocks(blocks)
            }
        };
        Ok(Dcp { frame_id, service_id, service_type, xid, response_delay_factor, body })
    }

    /// Appends the frame, starting with its frame ID; fills in lengths and pads blocks of odd length with a zero.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.frame_id.0);
        out.put(&[self.service_id.0, self.service_type.0]);
        out.put_u32(self.xid);
        out.put_u16(self.response_delay_factor);
        let length_at = out.len();
        out.put_u16(0);
        match &self.body {
            DcpBody::Elements(elements) => elements.iter().for_each(|element| element.write(out)),
            DcpBody::Blocks(blocks) => blocks.iter().for_each(|block| block.write(out)),
        }
        let length = (out.len() - length_at - 2) as u16;
        out[length_at..length_at + 2].copy_from_slice(&length.to_be_bytes());
    }

    /// Appends the whole frame, untagged and padded.
    pub fn write_frame(&self, destination: Mac, source: Mac, out: &mut Vec<u8>) {
        let start = out.len();
        FrameHeader::new(destination, source, EtherType::PROFINET).write(out);
        self.write(out);
        pad(out, start);
    }
}

/// The delay of the response to an Identify request from a device with address `mac`, in units of 10 ms.
///
/// It is the last two bytes of the address modulo the factor of the request; 0 with a factor of 0 or 1.
pub fn response_delay_steps(mac: Mac, response_delay_factor: u16) -> u16 {
    u16::from_be_bytes([mac.0[4], mac.0[5]]) % response_delay_factor.max(1)
}
