//! A vendor's GSD: what it says of a PROFIBUS slave, and where it disagrees with the manual.
//!
//! [`read`] reads the file, [`compare`] finds disagreements, [`overlay`] puts what no manual prints into the description of a
//! device so that a live one can be parameterised. This room must not know how a device is driven.
//!
//! Source: PROFIBUS Guideline 2.122, "Specification for PROFIBUS Device Description and Device Integration, Volume 1: GSD".

mod compare;
mod model;
mod overlay;
mod read;
mod show;

pub use compare::compare;
pub use model::{Field, FieldType, Gsd, Module, Parameters};
pub use overlay::overlay;
pub use read::{GsdError, read, read_octets};
pub use show::show;
