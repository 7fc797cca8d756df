//! A vendor's GSDML: its contents, and where manual, GSDML and device disagree.
//!
//! [`read`] reads the file, [`DeviceSays`] has the identity that the device reports (DCP, records 0xF821 and 0xF000, I&M0),
//! [`compare`] finds disagreements, and [`overlay`] adds the idents that no manual prints to the description of a device, so that a
//! connection to a live device is possible. This module must not know how a device is driven.
//!
//! Source: ISO 15745-4 and the GSDML schemas 2.3 to 2.45 for the file, IEC 61158-6-10 for the records.

mod compare;
mod data;
mod likest;
mod model;
mod names;
mod overlay;
mod places;
mod read;
mod records;
mod says;
mod show;
mod xml;

pub use compare::compare;
pub use likest::likest;
pub use model::{
    Access, AccessPoint, Bits, DataItem, DataType, Gsdml, Item, Module, ModuleInfo, Offered, Record, Submodule,
    SubmoduleKind,
};
pub use overlay::{Overlay, needs_description, overlay};
pub use read::{GsdmlError, read, read_octets};
pub use says::{Connected, DeviceSays, Plugged, SaysError};
pub use show::show;
