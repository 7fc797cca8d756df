//! The IO CRs (cyclic connections) of an AR: frame ID, cycle, and the position of each submodule in the frame.

use crate::codes::codes;
use crate::error::Result;
use crate::ethernet::Mac;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

codes! {
    /// The direction of a cyclic connection; 16 bits.
    pub struct IocrType(u16) {
        1 INPUT input "From the device to the controller.",
        2 OUTPUT output "From the controller to the device.",
        3 MULTICAST_PROVIDER multicast_provider "From the device to several consumers.",
        4 MULTICAST_CONSUMER multicast_consumer "From another device to this one.",
    }
}

codes! {
    /// The real-time class of a cyclic connection: bits 0 to 3 of IOCRProperties.
    pub struct RtClass(u8) {
        1 RT_CLASS_1 rt_class_1 "Unsynchronized, frame IDs from 0xC000 on.",
        2 RT_CLASS_2 rt_class_2 "Frame IDs from 0x8000 on; unsynchronized in most devices.",
        3 RT_CLASS_3 rt_class_3 "Synchronized, with planned transmission.",
        4 RT_CLASS_UDP rt_class_udp "Over UDP.",
    }
}

/// The properties of a cyclic connection: bits 0 to 3 RT class, the others reserved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct IocrProperties(pub u32);

impl IocrProperties {
    /// The RT class in bits 0 to 3.
    pub fn rt_class(self) -> RtClass {
        RtClass((self.0 & 0xF) as u8)
    }
}

impl From<RtClass> for IocrProperties {
    fn from(class: RtClass) -> IocrProperties {
        IocrProperties((class.0 & 0xF).into())
    }
}

/// The position of the data or of the IOCS of a submodule in the frame. Bytes: 0-1 slot, 2-3 subslot, 4-5 offset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FrameObject {
    /// The slot of the submodule.
    pub slot_number: u16,
    /// The subslot of the submodule.
    pub subslot_number: u16,
    /// Offset of the object from the end of the frame ID, in bytes.
    pub frame_offset: u16,
}

impl FrameObject {
    fn read_list(reader: &mut ByteReader) -> Result<Vec<FrameObject>> {
        let number = reader.u16()?;
        let mut objects = reader.sub(usize::from(number) * 6)?;
        let mut list = Vec::with_capacity(number.into());
        while !objects.is_empty() {
            list.push(FrameObject {
                slot_number: objects.u16()?,
                subslot_number: objects.u16()?,
                frame_offset: objects.u16()?,
            });
        }
        Ok(list)
    }

    fn write_list(list: &[FrameObject], out: &mut Vec<u8>) {
        out.put_u16(list.len() as u16);
        for object in list {
            out.put_u16(object.slot_number);
            out.put_u16(object.subslot_number);
            out.put_u16(object.frame_offset);
        }
    }
}

/// The objects of one API in a cyclic frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IocrApi {
    /// The API, 0 without a profile, 0x3D00 for encoders of profile 3.162.
    pub api: u32,
    /// Data with IOPS that the sender of the frame provides.
    pub io_data_objects: Vec<FrameObject>,
    /// IOCS for data that the sender of the frame consumes.
    pub iocs: Vec<FrameObject>,
}

/// IOCRBlockReq: a cyclic connection that the initiator requests.
///
/// Bytes of the body: 0-1 IOCRType, 2-3 IOCRReference, 4-5 LT, 6-9 IOCRProperties, 10-11 DataLength, 12-13 FrameID,
/// 14-15 SendClockFactor, 16-17 ReductionRatio, 18-19 Phase, 20-21 Sequence, 22-25 FrameSendOffset, 26-27 WatchdogFactor,
/// 28-29 DataHoldFactor, 30-31 IOCRTagHeader, 32-37 IOCRMulticastMACAdd, 38-39 NumberOfAPIs, then per API: 0-3 API,
/// NumberOfIODataObjects and its list, NumberOfIOCS and its list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IocrBlockReq {
    /// The direction of the connection.
    pub iocr_type: IocrType,
    /// The number of the connection within the AR.
    pub iocr_reference: u16,
    /// Ethertype, 0x8892; 0x0800 over UDP.
    pub lt: u16,
    /// RT class.
    pub iocr_properties: IocrProperties,
    /// Length of the data in bytes with all IOPS, IOCS and padding; 40 to 1440.
    pub data_length: u16,
    /// Frame ID; with 0xFFFF for an output connection the device chooses it.
    pub frame_id: u16,
    /// Send clock; unit 31.25 us, 1 to 128.
    pub send_clock_factor: u16,
    /// Reduction ratio: the frame is sent in each n-th send clock; 1 to 512, a power of two.
    pub reduction_ratio: u16,
    /// Phase: in which of these send clocks, from 1.
    pub phase: u16,
    /// Sequence among the frames of the same phase; 0 for any.
    pub sequence: u16,
    /// Frame send offset within the send clock, unit 1 ns; 0xFFFFFFFF for "as soon as possible".
    pub frame_send_offset: u32,
    /// Watchdog factor: the number of cycles without a frame after which the watchdog of the consumer expires; 1 to 7680.
    pub watchdog_factor: u16,
    /// Data hold factor: the number of cycles without a frame after which the data hold time expires; 1 to 7680.
    pub data_hold_factor: u16,
    /// 802.1Q: bits 0 to 11 VLAN ID, bits 13 to 15 priority; 0xC000 for priority 6.
    pub iocr_tag_header: u16,
    /// Destination of a multicast connection; zeros otherwise.
    pub iocr_multicast_mac_add: Mac,
    /// The position of each submodule in the frame.
    pub apis: Vec<IocrApi>,
}

impl IocrBlockReq {
    /// Reads the body of the block.
    pub fn read(reader: &mut ByteReader) -> Result<IocrBlockReq> {
        let mut block = IocrBlockReq {
            iocr_type: IocrType(reader.u16()?),
            iocr_reference: reader.u16()?,
            lt: reader.u16()?,
            iocr_properties: IocrProperties(reader.u32()?),
            data_length: reader.u16()?,
            frame_id: reader.u16()?,
            send_clock_factor: reader.u16()?,
            reduction_ratio: reader.u16()?,
            phase: reader.u16()?,
            sequence: reader.u16()?,
            frame_send_offset: reader.u32()?,
            watchdog_factor: reader.u16()?,
            data_hold_factor: reader.u16()?,
            iocr_tag_header: reader.u16()?,
            iocr_multicast_mac_add: Mac::read(reader)?,
            apis: Vec::new(),
        };
        for _ in 0..reader.u16()? {
            block.apis.push(IocrApi {
                api: reader.u32()?,
                io_data_objects: FrameObject::read_list(reader)?,
                iocs: FrameObject::read_list(reader)?,
            });
        }
        Ok(block)
    }

    /// Appends the body of the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.iocr_type.0);
        out.put_u16(self.iocr_reference);
        out.put_u16(self.lt);
        out.put_u32(self.iocr_properties.0);
        for word in
            [self.data_length, self.frame_id, self.send_clock_factor, self.reduction_ratio, self.phase, self.sequence]
        {
            out.put_u16(word);
        }
        out.put_u32(self.frame_send_offset);
        out.put_u16(self.watchdog_factor);
        out.put_u16(self.data_hold_factor);
        out.put_u16(self.iocr_tag_header);
        out.put(&self.iocr_multicast_mac_add.0);
        out.put_u16(self.apis.len() as u16);
        for api in &self.apis {
            out.put_u32(api.api);
            FrameObject::write_list(&api.io_data_objects, out);
            FrameObject::write_list(&api.iocs, out);
        }
    }
}

/// IOCRBlockRes: a cyclic connection that the responder established. Bytes of the body: 0-1 IOCRType, 2-3 IOCRReference, 4-5
/// FrameID.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IocrBlockRes {
    /// The direction of the connection, as requested.
    pub iocr_type: IocrType,
    /// The number of the connection, as requested.
    pub iocr_reference: u16,
    /// The effective frame ID; for an output connection chosen by the device.
    pub frame_id: u16,
}

impl IocrBlockRes {
    /// Reads the body of the block.
    pub fn read(reader: &mut ByteReader) -> Result<IocrBlockRes> {
        Ok(IocrBlockRes { iocr_type: IocrType(reader.u16()?), iocr_reference: reader.u16()?, frame_id: reader.u16()? })
    }

    /// Appends the body of the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.iocr_type.0);
        out.put_u16(self.iocr_reference);
        out.put_u16(self.frame_id);
    }
}
