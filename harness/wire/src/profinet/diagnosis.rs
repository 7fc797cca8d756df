//! Channel diagnosis: items of an alarm and blocks of the diagnosis records.
//!
//! Channel error types of profiles (from 0x9000) and vendors (from 0x0100) have no words here: the device defines them. Source: IEC
//! 61158-6-10, ChannelDiagnosis and DiagnosisData.

use super::blocks::{BlockHeader, BlockType};
use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

codes! {
    /// ChannelErrorType: the error of a channel.
    ///
    /// 0x0000 to 0x00FF and 0x8000 to 0x8FFF are standard, 0x0100 to 0x7FFF are vendor-specific, 0x9000 to 0x9FFF are defined by
    /// the profile of the API. Unknown numbers are preserved.
    pub struct ChannelErrorType(u16) {
        0x0001 SHORT_CIRCUIT short_circuit "A line has a short circuit.",
        0x0002 UNDERVOLTAGE undervoltage "The voltage is too low.",
        0x0003 OVERVOLTAGE overvoltage "The voltage is too high.",
        0x0004 OVERLOAD overload "The load is too high.",
        0x0005 OVERTEMPERATURE overtemperature "The temperature is too high.",
        0x0006 LINE_BREAK line_break "A line is broken.",
        0x0007 UPPER_LIMIT_EXCEEDED upper_limit_exceeded "The value is above its upper limit.",
        0x0008 LOWER_LIMIT_EXCEEDED lower_limit_exceeded "The value is below its lower limit.",
        0x0009 GENERAL_ERROR general_error "An error without further details.",
        0x000A SIMULATION_ACTIVE simulation_active "The value is simulated.",
        0x000F PARAMETER_MISSING parameter_missing "A parameter is missing.",
        0x0010 PARAMETER_FAULT parameter_fault "A parameter is wrong.",
        0x0011 POWER_SUPPLY_FAULT power_supply_fault "The power supply is faulty.",
        0x0012 FUSE_BLOWN fuse_blown "A fuse is blown or open.",
        0x0013 COMMUNICATION_FAULT communication_fault "Communication inside the device is faulty; the details are vendor-specific.",
        0x0014 GROUND_FAULT ground_fault "A line is connected to ground.",
        0x0015 REFERENCE_POINT_LOST reference_point_lost "The reference point is no longer known.",
        0x0016 SAMPLING_ERROR sampling_error "A process value or an event was missed.",
        0x0017 THRESHOLD_WARNING threshold_warning "A threshold was exceeded or fallen below.",
        0x0018 OUTPUT_DISABLED output_disabled "An output is switched off.",
        0x0019 SAFETY_EVENT safety_event "Functional safety reports an event.",
        0x001A EXTERNAL_FAULT external_fault "The cause is outside the device.",
        0x001F TEMPORARY_FAULT temporary_fault "The fault is temporary.",
        0x0040 SAFETY_DESTINATION_MISMATCH safety_destination_mismatch "The safety destination address does not match.",
        0x0041 SAFETY_DESTINATION_INVALID safety_destination_invalid "The safety destination address is not allowed.",
        0x0042 SAFETY_SOURCE_INVALID safety_source_invalid "The safety source address is not allowed.",
        0x0043 SAFETY_WATCHDOG_ZERO safety_watchdog_zero "The safety watchdog time is zero.",
        0x0044 SAFETY_LEVEL_EXCEEDED safety_level_exceeded "The application does not reach the required safety level.",
        0x0045 SAFETY_CRC_LENGTH safety_crc_length "The length of the safety checksum does not match.",
        0x0046 SAFETY_PARAMETER_VERSION safety_parameter_version "The version of the safety parameters does not match.",
        0x0047 SAFETY_PARAMETER_CRC safety_parameter_crc "The checksum of the safety parameters is wrong.",
        0x0048 SAFETY_DEVICE_SPECIFIC safety_device_specific "A device-specific safety diagnosis; see the manual of the device.",
        0x0049 SAFETY_SAVE_TIMEOUT safety_save_timeout "Saving individual parameters took too long.",
        0x004A SAFETY_RESTORE_TIMEOUT safety_restore_timeout "Restoring individual parameters took too long.",
        0x004B SAFETY_INDIVIDUAL_CRC safety_individual_crc "The checksum of the individual parameters is wrong.",
        0x004C SAFETY_BLOCK_ID safety_block_id "The block of safety parameters is not supported.",
        0x004D SAFETY_DATA_CRC safety_data_crc "Safety data arrived with a wrong checksum.",
        0x004E SAFETY_DATA_TIMEOUT safety_data_timeout "Safety data did not arrive in time.",
        0x004F SAFETY_ACKNOWLEDGE_NEEDED safety_acknowledge_needed "Channels wait for an acknowledgement.",
        0x8000 DATA_TRANSMISSION_IMPOSSIBLE data_transmission_impossible "No data can be transmitted.",
        0x8001 REMOTE_MISMATCH remote_mismatch "The neighbour is not the expected one.",
        0x8002 RING_MISMATCH ring_mismatch "The ring of media redundancy is not as configured.",
        0x8003 SYNC_MISMATCH sync_mismatch "The synchronisation is not as configured.",
        0x8004 ISOCHRONOUS_MISMATCH isochronous_mismatch "Isochronous operation is not as configured.",
        0x8005 MULTICAST_CR_MISMATCH multicast_cr_mismatch "A multicast relation is not as configured.",
        0x8007 FIBER_OPTIC_MISMATCH fiber_optic_mismatch "A fibre is not as expected.",
        0x8008 NETWORK_COMPONENT_MISMATCH network_component_mismatch "A network component does not work as expected.",
        0x8009 TIME_MISMATCH time_mismatch "The time is not as expected.",
        0x800A FRAME_PACKING_MISMATCH frame_packing_mismatch "Dynamic frame packing is not as configured.",
        0x800B PLANNED_DUPLICATION_MISMATCH planned_duplication_mismatch "Media redundancy with planned duplication is not as configured.",
        0x800C SYSTEM_REDUNDANCY_MISMATCH system_redundancy_mismatch "System redundancy is not as configured.",
        0x800D MULTIPLE_INTERFACE_MISMATCH multiple_interface_mismatch "Several interfaces do not match each other.",
        0x8010 SINGLE_PAIR_POWER_FAILURE single_pair_power_failure "Power over single pair Ethernet failed.",
    }
}

/// The severity of a diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MaintenanceSeverity {
    /// Fault: maintenance bits 00.
    Diagnosis,
    /// Maintenance required: bits 01.
    MaintenanceRequired,
    /// Maintenance demanded, which is more urgent: bits 10.
    MaintenanceDemanded,
    /// The qualifier of the entry defines the severity: bits 11.
    Qualified,
}

/// The specifier of a diagnosis: whether it appears or disappears.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ChannelChange {
    /// All diagnoses of the channel disappear: 00.
    AllDisappear,
    /// The diagnosis appears: 01.
    Appears,
    /// The diagnosis disappears: 10.
    Disappears,
    /// The diagnosis disappears, and others remain: 11.
    DisappearsOthersRemain,
}

/// ChannelProperties: type, severity, change and direction.
///
/// Bits 0-7 type, 8 accumulative, 9-10 maintenance, 11-12 specifier, 13-15 direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ChannelProperties(pub u16);

/// The diagnosis of a channel. Bytes: 0-1 channel number, 2-3 properties, 4-5 error type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelDiagnosis {
    /// Number of the channel; 0x8000 for the submodule as a whole.
    pub channel: u16,
    /// Type, severity, change and direction.
    pub properties: ChannelProperties,
    /// The diagnosis.
    pub error_type: ChannelErrorType,
}

/// The diagnosis of a channel with an extended error. Bytes after those of [`ChannelDiagnosis`]: 6-7 extended error type, 8-11
/// additional value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExtChannelDiagnosis {
    /// The diagnosis.
    pub channel: ChannelDiagnosis,
    /// ExtChannelErrorType; its meaning depends on the error type.
    pub ext_error_type: u16,
    /// ExtChannelAddValue; its meaning depends on the extended error type; 0 if none.
    pub add_value: u32,
}

/// The diagnosis of a channel with a qualified severity. Bytes after those of [`ExtChannelDiagnosis`]: 12-15
/// qualifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QualifiedChannelDiagnosis {
    /// The diagnosis.
    pub detail: ExtChannelDiagnosis,
    /// QualifiedChannelQualifier: one bit per severity, 3 to 31.
    pub qualifier: u32,
}

/// The content of an alarm or of a diagnosis block, selected by the user structure identifier.
///
/// In an alarm, write each entry as a separate item: devices do so, and tshark parses nothing else.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AlarmItem {
    /// 0x8000: entries of 6 bytes.
    Channel(Vec<ChannelDiagnosis>),
    /// 0x8001: diagnosis blocks; inside a diagnosis block it is preserved as [`AlarmItem::Other`].
    Multiple(Vec<DiagnosisData>),
    /// 0x8002: entries of 12 bytes.
    ExtChannel(Vec<ExtChannelDiagnosis>),
    /// 0x8003: entries of 16 bytes.
    QualifiedChannel(Vec<QualifiedChannelDiagnosis>),
    /// 0x8100: the maintenance state of the submodule: bit 0 required, bit 1 demanded, 2-31 qualifiers.
    Maintenance(u32),
    /// Anything else: 0x0000 to 0x7FFF are vendor-specific.
    Other {
        /// The user structure identifier.
        identifier: u16,
        /// The bytes after it, up to the end of the alarm or block.
        data: Vec<u8>,
    },
}

/// The diagnosis of one kind on one submodule: block 0x0010, as in the records 0x800A to 0x800C, 0xC00A to 0xC00C, 0xE00A
/// to 0xE00C, 0xF00A to 0xF00C and 0xF80C.
///
/// Bytes after the block header: in version 1.1 an API of four, then 0-1 slot, 2-3 subslot, 4-5 channel, 6-7 properties,
/// then the item.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DiagnosisData {
    /// The API; only in version 1.1.
    pub api: Option<u32>,
    /// Slot of the submodule.
    pub slot: u16,
    /// Subslot of the submodule.
    pub subslot: u16,
    /// Number of the channel; 0x8000 if the item has it.
    pub channel: u16,
    /// The common properties of the entries.
    pub properties: ChannelProperties,
    /// The diagnosis entries.
    pub item: AlarmItem,
}

impl MaintenanceSeverity {
    /// The word that suites and reports use.
    pub fn word(self) -> &'static str {
        match self {
            MaintenanceSeverity::Diagnosis => "diagnosis",
            MaintenanceSeverity::MaintenanceRequired => "maintenance_required",
            MaintenanceSeverity::MaintenanceDemanded => "maintenance_demanded",
            MaintenanceSeverity::Qualified => "qualified",
        }
    }
}

impl ChannelChange {
    /// The word that suites and reports use.
    pub fn word(self) -> &'static str {
        match self {
            ChannelChange::AllDisappear => "all_disappear",
            ChannelChange::Appears => "appears",
            ChannelChange::Disappears => "disappears",
            ChannelChange::DisappearsOthersRemain => "disappears_others_remain",
        }
    }
}

impl ChannelProperties {
    /// Properties without channel type, direction and accumulative flag.
    pub fn new(severity: MaintenanceSeverity, change: ChannelChange) -> ChannelProperties {
        ChannelProperties((severity as u16) << 9 | (change as u16) << 11)
    }

    /// The same properties with a channel type: 0 unspecified, 1 to 7 for 1, 2, 4, 8, 16, 32, 64 bits.
    pub fn with_type(self, channel_type: u8) -> ChannelProperties {
        ChannelProperties(self.0 & 0xFF00 | u16::from(channel_type))
    }

    /// The same properties with a direction: 0 vendor, 1 input, 2 output, 3 both.
    pub fn with_direction(self, direction: u8) -> ChannelProperties {
        ChannelProperties(self.0 & 0x1FFF | u16::from(direction) << 13)
    }

    /// Data width of the channel: 0 unspecified, 1 to 7 for 1, 2, 4, 8, 16, 32, 64 bits.
    pub fn channel_type(self) -> u8 {
        self.0 as u8
    }

    /// Whether the entry accumulates several channels.
    pub fn accumulative(self) -> bool {
        self.0 & 0x0100 != 0
    }

    /// The severity.
    pub fn severity(self) -> MaintenanceSeverity {
        match self.0 >> 9 & 3 {
            0 => MaintenanceSeverity::Diagnosis,
            1 => MaintenanceSeverity::MaintenanceRequired,
            2 => MaintenanceSeverity::MaintenanceDemanded,
            _ => MaintenanceSeverity::Qualified,
        }
    }

    /// Whether the diagnosis appears or disappears.
    pub fn change(self) -> ChannelChange {
        match self.0 >> 11 & 3 {
            0 => ChannelChange::AllDisappear,
            1 => ChannelChange::Appears,
            2 => ChannelChange::Disappears,
            _ => ChannelChange::DisappearsOthersRemain,
        }
    }

    /// Direction of the channel: 0 vendor, 1 input, 2 output, 3 both, others reserved.
    pub fn direction(self) -> u8 {
        (self.0 >> 13) as u8
    }
}

impl ChannelDiagnosis {
    /// The channel number of the submodule as a whole.
    pub const WHOLE_SUBMODULE: u16 = 0x8000;

    fn read(reader: &mut ByteReader<'_>) -> Result<ChannelDiagnosis> {
        Ok(ChannelDiagnosis {
            channel: reader.u16()?,
            properties: ChannelProperties(reader.u16()?),
            error_type: ChannelErrorType(reader.u16()?),
        })
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.channel);
        out.put_u16(self.properties.0);
        out.put_u16(self.error_type.0);
    }
}

impl ExtChannelDiagnosis {
    fn read(reader: &mut ByteReader<'_>) -> Result<ExtChannelDiagnosis> {
        Ok(ExtChannelDiagnosis {
            channel: ChannelDiagnosis::read(reader)?,
            ext_error_type: reader.u16()?,
            add_value: reader.u32()?,
        })
    }

    fn write(&self, out: &mut Vec<u8>) {
        self.channel.write(out);
        out.put_u16(self.ext_error_type);
        out.put_u32(self.add_value);
    }
}

impl QualifiedChannelDiagnosis {
    fn read(reader: &mut ByteReader<'_>) -> Result<QualifiedChannelDiagnosis> {
        Ok(QualifiedChannelDiagnosis { detail: ExtChannelDiagnosis::read(reader)?, qualifier: reader.u32()? })
    }

    fn write(&self, out: &mut Vec<u8>) {
        self.detail.write(out);
        out.put_u32(self.qualifier);
    }
}

/// The start of the block inside an item 0x8100: type, length, version and two bytes of padding; the maintenance state follows.
const MAINTENANCE_BLOCK: [u8; 8] = [0x0F, 0x00, 0x00, 0x08, 0x01, 0x00, 0x00, 0x00];

impl AlarmItem {
    /// The user structure identifier.
    pub fn identifier(&self) -> u16 {
        match self {
            AlarmItem::Channel(_) => 0x8000,
            AlarmItem::Multiple(_) => 0x8001,
            AlarmItem::ExtChannel(_) => 0x8002,
            AlarmItem::QualifiedChannel(_) => 0x8003,
            AlarmItem::Maintenance(_) => 0x8100,
            AlarmItem::Other { identifier, .. } => *identifier,
        }
    }

    /// The channel diagnoses in the item, whatever its form.
    pub fn channels(&self) -> Vec<ChannelDiagnosis> {
        match self {
            AlarmItem::Channel(entries) => entries.clone(),
            AlarmItem::ExtChannel(entries) => entries.iter().map(|entry| entry.channel).collect(),
            AlarmItem::QualifiedChannel(entries) => entries.iter().map(|entry| entry.detail.channel).collect(),
            AlarmItem::Multiple(blocks) => blocks.iter().flat_map(|block| block.item.channels()).collect(),
            AlarmItem::Maintenance(_) | AlarmItem::Other { .. } => Vec::new(),
        }
    }

    /// Parses items up to the end of the reader.
    pub fn read_all(reader: &mut ByteReader<'_>) -> Result<Vec<AlarmItem>> {
        let mut items = Vec::new();
        while !reader.is_empty() {
            items.push(AlarmItem::read(reader, false)?);
        }
        Ok(items)
    }

    /// Parses one item.
    ///
    /// In a block, the entries extend to the end of the block. In an alarm they do so if the rest is a whole number of entries and
    /// not a chain of items with one entry each, which scapy and tshark expect there; otherwise there is one entry, followed by
    /// another item. Items inside a block cannot contain blocks, which limits the nesting.
    fn read(reader: &mut ByteReader<'_>, inside_block: bool) -> Result<AlarmItem> {
        let identifier = reader.u16()?;
        Ok(match identifier {
            0x8000 => AlarmItem::Channel(entries(reader, 6, inside_block, ChannelDiagnosis::read)?),
            0x8001 if !inside_block => {
                let mut blocks = Vec::new();
                while !reader.is_empty() {
                    blocks.push(DiagnosisData::read(reader)?);
                }
                AlarmItem::Multiple(blocks)
            }
            0x8002 => AlarmItem::ExtChannel(entries(reader, 12, inside_block, ExtChannelDiagnosis::read)?),
            0x8003 => AlarmItem::QualifiedChannel(entries(reader, 16, inside_block, QualifiedChannelDiagnosis::read)?),
            0x8100 => {
                let mut lookahead = *reader;
                if lookahead.array().is_ok_and(|head: [u8; 8]| head == MAINTENANCE_BLOCK) {
                    *reader = lookahead;
                    AlarmItem::Maintenance(reader.u32()?)
                } else {
                    AlarmItem::Other { identifier, data: reader.rest().to_vec() }
                }
            }
            _ => AlarmItem::Other { identifier, data: reader.rest().to_vec() },
        })
    }

    /// Appends the item.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.identifier());
        match self {
            AlarmItem::Channel(entries) => entries.iter().for_each(|entry| entry.write(out)),
            AlarmItem::Multiple(blocks) => blocks.iter().for_each(|block| block.write(out)),
            AlarmItem::ExtChannel(entries) => entries.iter().for_each(|entry| entry.write(out)),
            AlarmItem::QualifiedChannel(entries) => entries.iter().for_each(|entry| entry.write(out)),
            AlarmItem::Maintenance(state) => {
                out.put(&MAINTENANCE_BLOCK);
                out.put_u32(*state);
            }
            AlarmItem::Other { data, .. } => out.put(data),
        }
    }
}

/// Parses the entries of one item.
fn entries<T>(
    reader: &mut ByteReader<'_>,
    width: usize,
    inside_block: bool,
    read: impl Fn(&mut ByteReader<'_>) -> Result<T>,
) -> Result<Vec<T>> {
    let left = reader.left();
    let count = match (inside_block, left % width) {
        (true, _) => left.div_ceil(width),
        (false, 0) if !is_chain(*reader, width) => left / width,
        _ => 1,
    };
    (0..count.max(1)).map(|_| read(reader)).collect()
}

/// Whether the rest is one entry, followed by items of one entry each, every item with its own identifier.
fn is_chain(mut reader: ByteReader<'_>, width: usize) -> bool {
    let mut links = 0;
    while reader.take(width).is_ok() {
        match reader.u16() {
            Ok(0x8000 | 0x8002 | 0x8003) => links += 1,
            Ok(_) => return false,
            Err(_) => return links > 0 && reader.is_empty(),
        }
    }
    false
}

impl DiagnosisData {
    /// Parses the blocks of a diagnosis record; a record without diagnosis is empty.
    pub fn parse_record(octets: &[u8]) -> Result<Vec<DiagnosisData>> {
        let mut reader = ByteReader::new("diagnosis record", octets);
        let mut blocks = Vec::new();
        while !reader.is_empty() {
            blocks.push(DiagnosisData::read(&mut reader)?);
        }
        Ok(blocks)
    }

    /// Parses one block; fails on another type or version.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<DiagnosisData> {
        let (header, mut block) = BlockHeader::read(reader)?;
        if header.kind != BlockType::DIAGNOSIS_DATA {
            return Err(block.wrong("BlockType", 6, "0x0010, diagnosis data", header.kind.0.into()));
        }
        let api = match (header.version_high, header.version_low) {
            (1, 0) => None,
            (1, 1) => Some(block.u32()?),
            (high, low) => {
                let found = u16::from_be_bytes([high, low]);
                return Err(block.wrong("BlockVersion", 2, "1.0 or 1.1", found.into()));
            }
        };
        Ok(DiagnosisData {
            api,
            slot: block.u16()?,
            subslot: block.u16()?,
            channel: block.u16()?,
            properties: ChannelProperties(block.u16()?),
            item: AlarmItem::read(&mut block, true)?,
        })
    }

    /// Appends the block: version 1.1 if it has an API, otherwise 1.0.
    pub fn write(&self, out: &mut Vec<u8>) {
        let header =
            BlockHeader { kind: BlockType::DIAGNOSIS_DATA, version_high: 1, version_low: u8::from(self.api.is_some()) };
        header.write_with(out, |out| {
            if let Some(api) = self.api {
                out.put_u32(api);
            }
            out.put_u16(self.slot);
            out.put_u16(self.subslot);
            out.put_u16(self.channel);
            out.put_u16(self.properties.0);
            self.item.write(out);
        });
    }
}
