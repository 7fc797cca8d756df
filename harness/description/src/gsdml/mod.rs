//! A vendor's GSDML: its contents, and where manual, GSDML and device disagree.
//!
//! [`read`] reads the file, [`ReportedIdentity`] has the identity that the device reports (DCP, records 0xF821 and 0xF000, I&M0),
//! [`compare`] finds disagreements, and [`overlay`] adds the idents that no manual prints to the description of a device, so that a
//! connection to a live device is possible. This module must not know how a device is driven.
//!
//! Source: ISO 15745-4 and the GSDML schemas 2.3 to 2.45 for the file, IEC 61158-6-10 for the records.

mod compare;
mod data;
mod describe;
mod encoder_record;
mod identity;
mod matching;
mod model;
mod names;
mod overlay;
mod parameters;
mod read;
mod records;
mod selection;
mod show;
mod variant;
mod xml;

pub use compare::compare;
pub use describe::{DescribeEncoderError, DescribedEncoder, SensorFormat, describe};
pub use identity::{AcceptedSubmodule, PluggedSubmodule, ReportedIdentity, ReportedIdentityError};
pub use model::{
    AccessPoint, Bits, DataItem, DataType, Gsdml, GsdmlModule, GsdmlRecord, GsdmlSubmodule, ItemAccess, ModuleInfo,
    PluggableItem, RecordItem, SubmoduleKind,
};
pub use overlay::{Overlay, needs_description, overlay};
pub use read::{GsdmlError, read, read_octets};
pub use selection::best_described;
pub use show::show;
pub use variant::variant_readings;
