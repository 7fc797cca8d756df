//! What a GSDML says, as plain data; texts are those of the primary language.

use std::ops::RangeInclusive;

/// A GSDML file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gsdml {
    /// The version of the schema that it names, for instance `2.43`; empty where it names none.
    pub version: String,
    /// Vendor ID of PI.
    pub vendor_id: u16,
    /// Device ID of the vendor.
    pub device_id: u16,
    /// The vendor's name.
    pub vendor: String,
    /// The main family and the product family.
    pub family: (String, String),
    /// The device access points.
    pub access_points: Vec<AccessPoint>,
    /// The modules that can be plugged.
    pub modules: Vec<Module>,
    /// The submodules that can be plugged into modules.
    pub submodules: Vec<Submodule>,
    /// What is wrong in the file but does not hinder reading it, as sentences with line and column.
    pub remarks: Vec<String>,
}

/// What is said about an access point, module or submodule for people.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModuleInfo {
    /// Its name.
    pub name: String,
    /// The order number; empty where there is none.
    pub order_number: String,
    /// The hardware release; empty where there is none.
    pub hardware: String,
    /// The software release; empty where there is none.
    pub software: String,
}

/// A device access point: one kind of head module.
#[derive(Clone, Debug, PartialEq)]
pub struct AccessPoint {
    /// Its ID in the file.
    pub id: String,
    /// For people.
    pub info: ModuleInfo,
    /// Ident number of its module.
    pub ident: u32,
    /// The slot that it is in.
    pub slot: u16,
    /// The slots that the device has.
    pub slots: Vec<RangeInclusive<u16>>,
    /// Submodules that are always there.
    pub submodules: Vec<Submodule>,
    /// Modules that it takes.
    pub modules: Vec<Offered>,
    /// Submodules of the file that can be plugged into its own slot.
    pub pluggable: Vec<Offered>,
    /// The smallest time between two cyclic frames, in units of 31.25 µs; 0 where the file does not say.
    pub min_device_interval: u16,
    /// The most octets of input and of output data, status octets included; 0 where the file does not say.
    pub max_input: u16,
    /// The most octets of output data.
    pub max_output: u16,
    /// Everything else that it claims of itself, its interface and its connections: the name of the attribute and its
    /// value, in the order of the file.
    pub features: Vec<(String, String)>,
}

/// A module or submodule of the file that can be plugged, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Offered {
    /// Index into [`Gsdml::modules`] or [`Gsdml::submodules`].
    pub index: usize,
    /// Slots or subslots that it may be in, however it comes to be there.
    pub places: Vec<RangeInclusive<u16>>,
    /// Those of them in which it always is.
    pub fixed: Vec<RangeInclusive<u16>>,
    /// Those of them in which an engineering tool puts it at first.
    pub used: Vec<RangeInclusive<u16>>,
}

/// A module.
#[derive(Clone, Debug, PartialEq)]
pub struct Module {
    /// Its ID in the file.
    pub id: String,
    /// For people.
    pub info: ModuleInfo,
    /// Its ident number.
    pub ident: u32,
    /// Submodules that are always there.
    pub submodules: Vec<Submodule>,
    /// Submodules of the file that can be plugged into it.
    pub pluggable: Vec<Offered>,
}

/// How a submodule comes to be where it is.
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
pub struct Submodule {
    /// Its ID in the file.
    pub id: String,
    /// How it comes to be where it is.
    pub kind: SubmoduleKind,
    /// For people.
    pub info: ModuleInfo,
    /// Its ident number.
    pub ident: u32,
    /// API; 0 where the file does not say.
    pub api: u32,
    /// The subslots that it is in; empty for one that is pluggable, where [`Offered`] says it.
    pub subslots: Vec<RangeInclusive<u16>>,
    /// Its input data.
    pub inputs: Vec<DataItem>,
    /// Its output data.
    pub outputs: Vec<DataItem>,
    /// Records that are written at start-up.
    pub records: Vec<Record>,
    /// Which I&M records can be written.
    pub writable_im: Vec<u16>,
    /// PROFIsafe and the like: whether it claims to be fail-safe.
    pub failsafe: bool,
}

/// A piece of the cyclic data.
#[derive(Clone, Debug, PartialEq)]
pub struct DataItem {
    /// Its name.
    pub name: String,
    /// Its type as the file writes it.
    pub kind: String,
    /// How many octets it has; none for a type that is not known.
    pub octets: Option<u16>,
    /// Its bits that have names of their own: number, 0 is the lowest of the item, and name.
    pub bits: Vec<(u16, String)>,
}

/// A record that is written at start-up.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Its name.
    pub name: String,
    /// Index.
    pub index: u32,
    /// Its length in octets.
    pub octets: usize,
    /// In which order it is written.
    pub transfer_sequence: u16,
    /// Its octets as delivered: constants, and the defaults of its items put over them.
    pub default: Vec<u8>,
    /// What can be set in it.
    pub items: Vec<Item>,
}

/// Something that can be set in a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Its name.
    pub name: String,
    /// Its type.
    pub kind: DataType,
    /// First octet.
    pub octet: usize,
    /// How many octets it has; 0 for bits, and where the file does not say.
    pub octets: usize,
    /// For bits: which of the octets from `octet` on, read as one number with the most significant octet first.
    pub bits: Option<Bits>,
    /// Its default, for a number.
    pub default: Option<i128>,
    /// The numbers that it may have; empty where the file does not say.
    pub allowed: Vec<RangeInclusive<i128>>,
    /// Words for its numbers.
    pub words: Vec<(i128, String)>,
    /// Whether and how an engineering tool lets people set it.
    pub access: Access,
}

/// Bits in an octet or in several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bits {
    /// The lowest, 0 is the least significant.
    pub low: u32,
    /// How many.
    pub width: u32,
}

/// Whether people can set something in an engineering tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// They can.
    Changeable,
    /// They only see it.
    Visible,
    /// They do not see it.
    Hidden,
}

/// A type of data in a record or in the cyclic data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DataType {
    /// A single bit.
    Bit,
    /// Some bits.
    BitArea,
    /// A whole number of so many octets, with a sign or without.
    Whole {
        /// Octets.
        octets: u16,
        /// Whether it is a two's complement.
        signed: bool,
    },
    /// A floating point number of so many octets.
    Float(u16),
    /// Octets or text.
    Octets,
    /// Any other, by its name.
    Other(String),
}
