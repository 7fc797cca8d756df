//! A vendor's GSD: its contents, and where it disagrees with the manual.
//!
//! [`read`] reads the file, [`compare`] finds disagreements, [`overlay`] adds values that no manual prints to the description of a
//! device, so that a live device can be parameterised. This module must not know how a device is driven.
//!
//! Source: PROFIBUS Guideline 2.122, "Specification for PROFIBUS Device Description and Device Integration, Volume 1: GSD".

mod compare;
mod describe;
mod encoder;
mod encoder_text;
mod model;
mod overlay;
mod read;
mod show;

pub use compare::compare;
pub use describe::{DescribeError, DescribedSlave, describe};
pub use model::{FieldType, Gsd, GsdField, GsdModule, GsdParameters};
pub use overlay::overlay;
pub use read::{GsdError, read, read_octets};
pub use show::show;
