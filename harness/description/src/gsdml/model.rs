//! The contents of a GSDML as plain data; texts are in the primary language.

use std::ops::RangeInclusive;

/// A GSDML file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gsdml {
    /// The version of its schema, for instance `2.43`; empty if it names none.
    pub version: String,
    /// Vendor ID assigned by PI.
    pub vendor_id: u16,
    /// Device ID assigned by the vendor.
    pub device_id: u16,
    /// The vendor's name.
    pub vendor: String,
    /// The main family and the product family.
    pub family: (String, String),
    /// The device access points.
    pub access_points: Vec<AccessPoint>,
    /// The modules that can be plugged.
    pub modules: Vec<GsdmlModule>,
    /// The submodules that can be plugged into modules.
    pub submodules: Vec<GsdmlSubmodule>,
    /// Errors that do not prevent reading it, as sentences with line and column.
    pub remarks: Vec<String>,
}

/// Name, order number and releases of an access point, module or submodule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModuleInfo {
    pub name: String,
    /// The order number; empty if there is none.
    pub order_number: String,
    /// The hardware release; empty if there is none.
    pub hardware: String,
    /// The software release; empty if there is none.
    pub software: String,
}

/// A device access point (DAP): a kind of head module.
#[derive(Clone, Debug, PartialEq)]
pub struct AccessPoint {
    /// Its ID in the file.
    pub id: String,
    pub info: ModuleInfo,
    /// Ident number of its module.
    pub ident: u32,
    /// Its slot.
    pub slot: u16,
    /// The slots of the device.
    pub slots: Vec<RangeInclusive<u16>>,
    /// Built-in submodules.
    pub submodules: Vec<GsdmlSubmodule>,
    /// The modules that can be plugged.
    pub modules: Vec<PluggableItem>,
    /// Submodules of the file that can be plugged into its own slot.
    pub pluggable: Vec<PluggableItem>,
    /// The shortest cycle time in units of 31.25 µs; 0 if not given.
    pub min_device_interval: u16,
    /// The longest input data in bytes, including status bytes; 0 if not given.
    pub max_input: u16,
    /// The longest output data in bytes, including status bytes; 0 if not given.
    pub max_output: u16,
    /// All other attributes of the access point, its interface and its connections: name and value, in the order of the file.
    pub features: Vec<(String, String)>,
}

impl AccessPoint {
    /// Whether the device has an SNMP agent: it lists SNMP among its protocols, or claims a conformance class that has it.
    pub fn has_snmp(&self) -> bool {
        self.features.iter().any(|(name, value)| match name.as_str() {
            "SupportedProtocols" => value.split([';', ' ']).any(|protocol| protocol == "SNMP"),
            "ConformanceClass" => matches!(value.as_str(), "B" | "C" | "D"),
            _ => false,
        })
    }
}

impl AccessPoint {
    /// Whether the device says Hello where record 0x8090 has it do so.
    pub fn has_hello(&self) -> bool {
        self.features.iter().any(|(name, value)| name == "DCP_HelloSupported" && matches!(value.as_str(), "true" | "1"))
    }
}

/// A module or submodule of the file that can be plugged, and its slots or subslots.
#[derive(Clone, Debug, PartialEq)]
pub struct PluggableItem {
    /// Index into [`Gsdml::modules`] or [`Gsdml::submodules`].
    pub index: usize,
    /// All slots or subslots in which it can be.
    pub places: Vec<RangeInclusive<u16>>,
    /// Those in which it always is.
    pub fixed: Vec<RangeInclusive<u16>>,
    /// Those in which an engineering tool puts it by default.
    pub used: Vec<RangeInclusive<u16>>,
}

/// A module.
#[derive(Clone, Debug, PartialEq)]
pub struct GsdmlModule {
    /// Its ID in the file.
    pub id: String,
    pub info: ModuleInfo,
    /// Its ident number.
    pub ident: u32,
    /// Built-in submodules.
    pub submodules: Vec<GsdmlSubmodule>,
    /// Submodules of the file that can be plugged into it.
    pub pluggable: Vec<PluggableItem>,
}

/// How a submodule gets into its subslot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SubmoduleKind {
    /// Built into its module.
    Virtual,
    /// The interface of the device.
    Interface,
    /// A port of the device.
    Port,
    /// Plugged into a subslot.
    Pluggable,
}

/// A submodule.
#[derive(Clone, Debug, PartialEq)]
pub struct GsdmlSubmodule {
    /// Its ID in the file.
    pub id: String,
    pub kind: SubmoduleKind,
    pub info: ModuleInfo,
    /// Its ident number.
    pub ident: u32,
    /// API; 0 if not given.
    pub api: u32,
    /// Its subslots; empty for a pluggable one, for which [`PluggableItem`] has them.
    pub subslots: Vec<RangeInclusive<u16>>,
    /// Its input data.
    pub inputs: Vec<DataItem>,
    /// Its output data.
    pub outputs: Vec<DataItem>,
    /// Records that are written at start-up.
    pub records: Vec<GsdmlRecord>,
    /// The I&M records that can be written.
    pub writable_im: Vec<u16>,
    /// Whether it claims to be fail-safe (PROFIsafe).
    pub failsafe: bool,
}

/// An item of the cyclic data.
#[derive(Clone, Debug, PartialEq)]
pub struct DataItem {
    pub name: String,
    /// Its type as written in the file.
    pub kind: String,
    /// The number of bytes; `None` for an unknown type.
    pub octets: Option<u16>,
    /// Named bits: number, 0 is the lowest of the item, and name.
    pub bits: Vec<(u16, String)>,
}

/// A record that is written at start-up.
#[derive(Clone, Debug, PartialEq)]
pub struct GsdmlRecord {
    pub name: String,
    /// Index.
    pub index: u32,
    /// Its length in bytes.
    pub octets: usize,
    /// Its position in the order of writing.
    pub transfer_sequence: u16,
    /// Its default bytes: constants, overwritten by the defaults of its items.
    pub default: Vec<u8>,
    /// The items that can be set.
    pub items: Vec<RecordItem>,
}

/// An item of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordItem {
    pub name: String,
    pub kind: DataType,
    /// The offset of its first byte.
    pub octet: usize,
    /// The number of bytes; 0 for bits, and if not given.
    pub octets: usize,
    /// The bits, in the big-endian number that begins at byte `octet`.
    pub bits: Option<Bits>,
    /// Its default, for a number.
    pub default: Option<i128>,
    /// The allowed numbers; empty if not given.
    pub allowed: Vec<RangeInclusive<i128>>,
    /// Names of its numbers.
    pub words: Vec<(i128, String)>,
    /// Its name and the names of its numbers in the other languages of the file.
    pub translations: (Vec<String>, Vec<(i128, String)>),
    /// Whether an engineering tool lets users change it.
    pub access: ItemAccess,
}

/// Bits in one or more bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bits {
    /// The lowest bit, 0 is the least significant.
    pub low: u32,
    /// The number of bits.
    pub width: u32,
}

/// Whether users can change a value in an engineering tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemAccess {
    /// They can change it.
    Changeable,
    /// They can only read it.
    Visible,
    /// It is hidden.
    Hidden,
}

/// A data type in a record or in the cyclic data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DataType {
    /// A single bit.
    Bit,
    /// Several bits.
    BitArea,
    /// A whole number, signed or unsigned.
    Whole {
        /// Bytes.
        octets: u16,
        /// Whether it is in two's complement.
        signed: bool,
    },
    /// A floating point number with this many bytes.
    Float(u16),
    /// Bytes or text.
    Octets,
    /// Any other type, by its name.
    Other(String),
}
