//! The measuring task of an absolute encoder: shaft, scaling, offset, velocity, memory.
//!
//! Places are counted in *hardware steps* as the sensor sees them; *units* are what the user has scaled them to.
//!
//! This module must not know a bus: no telegram, no parameter number, no shift factor, no sign bit in an output. What a
//! protocol makes of a position (left alignment, 31 bits and a trigger, an error in the topmost bit) is its emitter's.

pub mod measuring;
pub mod memory;
pub mod scaling;
pub mod shaft;
pub mod velocity;

pub use measuring::{Measuring, PresetMode, Settings};
pub use memory::Cell;
pub use scaling::{Direction, Gear, Hardware, RedZone, Scaling};
pub use shaft::Shaft;
pub use velocity::{Sampling, Unit, Velocity};
